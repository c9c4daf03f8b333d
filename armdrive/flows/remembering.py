"""Waiting for the disk, while the engine goes on listening and a stop ends the wait.

On simulated time the disk takes no time, and nothing here waits.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from armdrive.controllers.requests import never
from armdrive.flow import Flow, Until

if TYPE_CHECKING:
    from armdrive.flows.exchange import Wire

FIRST_LOOK_S = 0.001
LAST_LOOK_S = 0.05
SLOWER = 1.5
"""The disk is looked at often at first, as most need a few milliseconds, then less and less."""

LONGEST_S = 5.0
"""A reference is good without its record: a disk that takes longer is not waited for."""


def leave_standstill(wire: Wire, let_go: Callable[[], bool] = never) -> Flow[bool]:
    """Wait until the mark of motion is on the disk; raises `StateFileError` where it cannot be.

    False where a stop was asked for meanwhile, or `let_go()` became true: nothing may move then.
    """
    memory = wire.core.memory
    memory.begin_mark()
    look_s = FIRST_LOOK_S
    while not memory.mark_stands():
        if wire.stopping or let_go():
            return False
        yield Until(wire.now_s + look_s)
        look_s = min(look_s * SLOWER, LAST_LOOK_S)
    return True


def be_remembered(wire: Wire) -> Flow[None]:
    """Wait until what was asked for is on the disk or has failed, which the notice tells then."""
    end_s = wire.now_s + LONGEST_S
    look_s = FIRST_LOOK_S
    while not (wire.core.memory.settled or wire.stopping or wire.now_s >= end_s):
        yield Until(wire.now_s + look_s)
        look_s = min(look_s * SLOWER, LAST_LOOK_S)
    wire.core.hear_memory()
