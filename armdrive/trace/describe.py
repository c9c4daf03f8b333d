"""What passes on the wire, and what is asked and answered, in words.

How the bytes of a dialect are cut and worded is stated by its row of the registry.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, get_args

from armdrive.dialects.words import AnswerLines, Describer, answer
from armdrive.moves import Move
from armdrive.registry import DIALECTS
from armdrive.tasks import (
    Alert,
    Event,
    MoveAlong,
    MoveBy,
    ProtocolWarning,
    Registers,
    Request,
    Timeout,
)
from armdrive.text.json_forms import move_to_json
from armdrive.trace.entries import EntryKind

_PLAIN = Describer(lambda: AnswerLines(b"\r\n", answer), None)


def talk(dialect: str) -> Describer:
    """Return how a dialect is put into words; of an unknown one, lines without words."""
    row = DIALECTS.get(dialect)
    return _PLAIN if row is None else row.driver().talk


# Requests, answers, calls and errors in the words that a recording keeps.


def request_words(request: Request) -> str:
    """Return a request in words; what is a program of its own is left out."""
    if isinstance(request, MoveBy):
        return f"MoveBy({_counts(request.steps)}; {request.rate_hz:g} steps/s)"
    if isinstance(request, MoveAlong):
        return f"MoveAlong({'jogging, ' if request.jog else ''}{request.ahead_s:g} s ahead)"
    return repr(request)


def event_words(event: Event) -> tuple[EntryKind, str]:
    """Return the kind of an answer or an alert, and its words; counts of motors come first."""
    if isinstance(event, Registers):
        return EntryKind.REGISTERS, f"{_counts(event.positions)}; {event}"
    if isinstance(event, Alert):
        return EntryKind.ALERT, f"{event.kind.value}: {event.text}"
    if isinstance(event, ProtocolWarning):
        return EntryKind.ODDITY, event.text
    return EntryKind.SILENCE if isinstance(event, Timeout) else EntryKind.REPLY, str(event)


def call_words(name: str, words: tuple[Any, ...], named: Mapping[str, Any]) -> str:
    """Return a call as it would be written; a move in its JSON form."""
    shown = [_argument(word) for word in words]
    shown += [f"{key}={_argument(value)}" for key, value in named.items()]
    return f"{name}({', '.join(shown)})"


def _argument(value: object) -> str:
    return json.dumps(move_to_json(value)) if isinstance(value, get_args(Move)) else repr(value)


def error_words(error: BaseException) -> str:
    """Return an error in words."""
    return f"{type(error).__name__}: {error}"


def _counts(counts: tuple[int, ...]) -> str:
    return " ".join(map(str, counts))
