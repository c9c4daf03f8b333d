"""Turning one motor a little, in pieces that each end by themselves within a quarter of a second.

Targets are absolute (F5), so that a request whose answer was lost may be put once more.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from armdrive.commissioning.acts import Hear, Put, Stands, Talk
from armdrive.commissioning.drives import TRIES, reading
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    TARGET_MAX,
    Done,
    EncoderRead,
    Event,
    Failed,
    MotorState,
    MoveAbsoluteAxis,
    ReadEncoder,
    ReadStall,
    ReadState,
    StallRead,
    Started,
    StateRead,
)

PIECE_S = 0.25
"""No motion is commanded further ahead."""
WHOLE_S = 1.6
"""A trial takes about so long."""
MOST_RPM = 60
ACC = 236
"""A ramp of 1000 rpm a second."""
LOOK_S = 0.03
PATIENCE_S = 1.0
"""A piece that has not arrived so long after its time never will."""
REACHED = 80
"""Counts from its target at which a motor has arrived: under two degrees of its shaft."""


@dataclass(frozen=True, slots=True)
class Turned:
    """Where a motor stands, in counts, and why it is not where it should be; empty where it is."""

    counts: int
    trouble: str = ""


def speed_rpm(counts: int, seconds: float = WHOLE_S) -> int:
    """Return the speed at which so many counts take about so long; never a fast one."""
    turns = abs(counts) / COUNTS_PER_TURN
    return max(1, min(math.ceil(turns * 60.0 / seconds), MOST_RPM))


def where(node: int) -> Talk[int | None]:
    """Read where a drive is."""
    found = yield from reading(node, ReadEncoder())
    return found.counts if isinstance(found, EncoderRead) else None


def turn_to(node: int, target: int, rpm: int) -> Talk[Turned]:
    """Turn a motor to a count, piece by piece. The drive holds it from then on."""
    at = yield from where(node)
    if at is None:
        return Turned(target, "it does not answer")
    if abs(target) > TARGET_MAX:
        return Turned(at, "it is beyond the 512 turns that can be commanded: set its zero anew")
    most = max(1, int(rpm / 60.0 * COUNTS_PER_TURN * PIECE_S))
    pieces = math.ceil(abs(target - at) / most)
    begin = at
    for number in range(1, pieces + 1):
        goal = begin + round((target - begin) * number / pieces)
        turned = yield from _piece(node, goal, rpm)
        if turned.trouble:
            return turned
        at = turned.counts
    return Turned(at)


def _piece(node: int, goal: int, rpm: int) -> Talk[Turned]:
    for _ in range(TRIES):
        heard: tuple[Event, ...] = yield Put(node, MoveAbsoluteAxis(goal, rpm, ACC))
        if any(isinstance(each, Failed) for each in heard):
            yield Stands(node)
            return Turned((yield from where(node)) or 0, (yield from refusal(node)))
        arrived = yield from _arrived(node, goal)
        if arrived is not None:
            yield Stands(node)
            return Turned(arrived)
        if any(isinstance(each, Started | Done) for each in heard):
            break
    at = yield from where(node)
    return Turned(at or 0, (yield from refusal(node)) if at is not None else "it does not answer")


def _arrived(node: int, goal: int) -> Talk[int | None]:
    """Wait until a motor stands at its goal; None where it does not get there."""
    waited_s = 0.0
    while waited_s < PIECE_S + PATIENCE_S:
        yield Hear(LOOK_S)
        waited_s += LOOK_S
        at = yield from where(node)
        if at is not None and abs(at - goal) <= REACHED and (yield from stands(node)):
            return at
    return None


def stands(node: int) -> Talk[bool]:
    """Tell whether a drive says that its motor stands."""
    found = yield from reading(node, ReadState())
    return isinstance(found, StateRead) and found.state is MotorState.STOPPED


def refusal(node: int) -> Talk[str]:
    """Say why a motor may not have turned."""
    stalled = yield from reading(node, ReadStall())
    if isinstance(stalled, StallRead) and stalled.on:
        return "its protection has let the shaft go: something blocks it, or its current is too low"
    return (
        "the drive does not do it: it is blocked, its mode is none of the bus, or its encoder is "
        "not calibrated"
    )
