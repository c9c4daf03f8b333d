"""The state machine of a CiA 402 drive: one table, which the drive obeys and the master plans by.

    0, 1  NOT_READY -> DISABLED -> READY -> SWITCHED_ON -> ENABLED -> QUICK_STOP
    13    any state -> FAULT_REACTION -> FAULT -> DISABLED

Source: CiA 402-2 (IEC 61800-7-201), the finite state automaton and its transitions 0 to 16.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import Enum
from typing import TypeAlias

from firmware_protocol.canopen.drive_words import Command, DriveState


class Happening(Enum):
    """What changes a drive's state without a command."""

    INITIALISED = "its self-test is done"
    QUICK_STOPPED = "the quick stop has ended, and its option says to disable"
    FAULT = "something is wrong"
    REACTED = "the reaction to a fault has ended"


Cause: TypeAlias = Command | Happening


@dataclass(frozen=True, slots=True)
class Transition:
    """A row of the table. `number` is CiA 402's."""

    number: int
    begin: DriveState
    cause: Cause
    end: DriveState

    @property
    def drops_current(self) -> bool:
        """Whether the motor holds before and not behind it: an arm without brakes sags."""
        return self.begin.holds and not self.end.holds


_NOT_READY, _DISABLED, _READY = DriveState.NOT_READY, DriveState.DISABLED, DriveState.READY
_ON, _ENABLED, _QUICK = DriveState.SWITCHED_ON, DriveState.ENABLED, DriveState.QUICK_STOP
_REACTION, _FAULT = DriveState.FAULT_REACTION, DriveState.FAULT

TRANSITIONS: tuple[Transition, ...] = (
    Transition(1, _NOT_READY, Happening.INITIALISED, _DISABLED),
    Transition(2, _DISABLED, Command.SHUT_DOWN, _READY),
    Transition(3, _READY, Command.SWITCH_ON, _ON),
    Transition(3, _READY, Command.ENABLE_OPERATION, _ON),  # and from there by 4, at once
    Transition(4, _ON, Command.ENABLE_OPERATION, _ENABLED),
    Transition(5, _ENABLED, Command.SWITCH_ON, _ON),
    Transition(6, _ON, Command.SHUT_DOWN, _READY),
    Transition(7, _READY, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(7, _READY, Command.QUICK_STOP, _DISABLED),
    Transition(8, _ENABLED, Command.SHUT_DOWN, _READY),
    Transition(9, _ENABLED, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(10, _ON, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(10, _ON, Command.QUICK_STOP, _DISABLED),
    Transition(11, _ENABLED, Command.QUICK_STOP, _QUICK),
    Transition(12, _QUICK, Command.DISABLE_VOLTAGE, _DISABLED),
    Transition(12, _QUICK, Happening.QUICK_STOPPED, _DISABLED),
    Transition(13, _NOT_READY, Happening.FAULT, _REACTION),
    Transition(13, _DISABLED, Happening.FAULT, _REACTION),
    Transition(13, _READY, Happening.FAULT, _REACTION),
    Transition(13, _ON, Happening.FAULT, _REACTION),
    Transition(13, _ENABLED, Happening.FAULT, _REACTION),
    Transition(13, _QUICK, Happening.FAULT, _REACTION),
    Transition(14, _REACTION, Happening.REACTED, _FAULT),
    Transition(15, _FAULT, Command.FAULT_RESET, _DISABLED),
    Transition(16, _QUICK, Command.ENABLE_OPERATION, _ENABLED),  # not every drive has it
)

_BY_CAUSE = {(row.begin, row.cause): row for row in TRANSITIONS}
RESUMES, RESETS = 16, 15
"""Transitions that the master takes only when it is told to."""


def transition(state: DriveState, cause: Cause) -> Transition | None:
    """Return what a cause does in a state; None where it does nothing."""
    return _BY_CAUSE.get((state, cause))


def way(
    state: DriveState, goal: DriveState, *, reset: bool = False, resume: bool = False
) -> tuple[Transition, ...] | None:
    """Return the commands that lead from a state to another, the shortest way; None for no way.

    Out of a fault only with `reset`, and from a quick stop back only with `resume`, which not every
    drive has. No way to a state that holds the arm leads through one that drops it. What a drive
    does by itself is waited for: no way leads out of NOT_READY or FAULT_REACTION.
    """
    refused = {RESETS: not reset, RESUMES: not resume}
    found: dict[DriveState, tuple[Transition, ...]] = {state: ()}
    ahead = deque((state,))
    while ahead:
        here = ahead.popleft()
        if here is goal:
            return found[here]
        for row in TRANSITIONS:
            if row.begin is not here or row.end in found or isinstance(row.cause, Happening):
                continue
            if refused.get(row.number, row.drops_current and goal.holds):
                continue
            found[row.end] = (*found[here], row)
            ahead.append(row.end)
    return None
