"""What passes on the wire in words, as the row of its dialect in the registry states it."""

from __future__ import annotations

from armdrive.dialects.words import AnswerLines, Describer, answer
from armdrive.registry import DIALECTS

_PLAIN = Describer(lambda: AnswerLines(b"\r\n", answer), None)


def talk(dialect: str) -> Describer:
    """Return how a dialect is put into words; of an unknown one, lines without words."""
    row = DIALECTS.get(dialect)
    return _PLAIN if row is None else row.tools().talk
