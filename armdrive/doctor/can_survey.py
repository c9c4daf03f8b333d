"""Asks a CAN bus of MKS drives politely who is on it: it listens, then asks each id its position.

Nothing but readings is ever sent, one at a time and with pauses; nothing at all while another
program is heard to command drives.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from armdrive.commissioning.acts import Hear, Put, Talk
from armdrive.commissioning.drives import Known, answer_of, known
from armdrive.doctor import canopen_survey
from firmware_protocol.errors import ProtocolError
from firmware_protocol.frames import Frame
from firmware_protocol.mks import (
    Event,
    Foreign,
    Garbled,
    ReadEncoder,
    decode_answer,
    decode_request,
)

LISTEN_S = 1.0
"""An arm that is driven is commanded far oftener than that."""
ASK_S = 0.02
"""A drive's answer takes a millisecond."""
PAUSE_S = 0.005
ROUNDS = 2
IDS = tuple(range(1, 17))
"""Asked where nobody says otherwise."""


@dataclass(frozen=True, slots=True)
class Survey:
    """What was heard and found.

    `passing` are the frames that passed while nothing was sent, and `commands` those of them that
    somebody else has put to drives. `asked` is empty where nothing was sent.
    """

    passing: tuple[Frame, ...] = ()
    commands: tuple[Frame, ...] = ()
    asked: tuple[int, ...] = ()
    drives: tuple[Known, ...] = ()
    garbled: int = 0


def listen(seconds: float = LISTEN_S, master: int | None = None) -> Talk[Survey]:
    """Hear what passes by itself, whatever is spoken; `master` is a CANopen master's node."""
    heard: tuple[Event, ...] = yield Hear(seconds)
    frames = tuple(each.frame for each in heard if isinstance(each, Foreign))
    return Survey(frames, tuple(each for each in frames if _is_command(each, master)))


def ask_round(ids: Sequence[int] = IDS) -> Talk[Survey]:
    """Ask each id once or twice whether it is there, then those that are for all that they tell."""
    there: set[int] = set()
    garbled = 0
    for _ in range(ROUNDS):
        for node in [each for each in ids if each not in there]:
            heard: tuple[Event, ...] = yield Put(node, ReadEncoder(), ASK_S)
            garbled += sum(isinstance(each, Garbled) for each in heard)
            if answer_of(heard) is not None:
                there.add(node)
            yield Hear(PAUSE_S)
    found = []
    for node in sorted(there):
        told = yield from known(node)
        if told is not None:
            found.append(told)
    return Survey(asked=tuple(ids), drives=tuple(found), garbled=garbled)


def _is_command(frame: Frame, master: int | None) -> bool:
    """Tell whether a frame can be nothing but a request to a drive, in either protocol."""
    if _reads(decode_answer, frame):
        return False
    return _reads(decode_request, frame) or canopen_survey.is_command(frame, master)


def _reads(decode: Callable[[Frame], object], frame: Frame) -> bool:
    try:
        decode(frame)
    except (ProtocolError, ValueError):
        return False
    return True
