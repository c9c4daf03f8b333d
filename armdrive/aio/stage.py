"""Carries calls of arms out for an event loop: in threads, on one simulated clock for them all."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import TypeVar

from armdrive.aio.conductor import Conductor
from armdrive.aio.strand import ThreadStrand
from armdrive.arm import Arm
from armdrive.clock import SimulatedClock
from armdrive.pace import RealPace

R = TypeVar("R")

UNCERTAIN = "the arm did not confirm that it stands; look at it"


class Stage:
    """What one event loop has: a simulated clock, and who drives which clock."""

    def __init__(self, loop: asyncio.AbstractEventLoop) -> None:
        self.loop = loop
        self.clock = SimulatedClock()
        self._conductors: dict[SimulatedClock, Conductor] = {}

    def conductor(self, clock: SimulatedClock) -> Conductor:
        """Return who drives a clock for this loop."""
        return self._conductors.setdefault(clock, Conductor(clock, self.loop))

    async def carry(self, call: Callable[[], R], arm: Arm) -> R:
        """Carry out a call of an arm.

        Where its task is cancelled, the arm is stopped and has come to rest before that goes on.
        """
        strand = self._begun(call, in_turn=goes_in_turn(arm))
        try:
            await ended(strand)
        except asyncio.CancelledError as cancelled:
            arm.request_stop()  # before anything that takes time
            strand.give_up()
            await ended(strand, whatever_comes=True)
            if not await self._stands(arm):
                cancelled.add_note(UNCERTAIN)
            raise
        return strand.result()

    async def carry_to_its_end(self, call: Callable[[], R], *, in_turn: bool) -> R:
        """Carry out what has to be done whoever cancels it; that goes on afterwards."""
        strand = self._begun(call, in_turn=in_turn)
        cancelled = await ended(strand, whatever_comes=True)
        if cancelled is not None:
            raise cancelled
        return strand.result()

    async def connect(self, call: Callable[[], Arm], *, in_turn: bool) -> Arm:
        """Carry out a call that connects; where that is cancelled, nothing stays connected."""
        strand = self._begun(call, in_turn=in_turn)
        try:
            await ended(strand)
        except asyncio.CancelledError:
            strand.give_up()
            await ended(strand, whatever_comes=True)
            if strand.error is None:
                arm = strand.result()
                await self.carry_to_its_end(arm.close, in_turn=goes_in_turn(arm))
            raise
        return strand.result()

    async def _stands(self, arm: Arm) -> bool:
        """Stop an arm once more, and tell whether it was seen to stand."""
        if arm.closed:
            return True
        strand = self._begun(arm.stand_still, in_turn=goes_in_turn(arm))
        await ended(strand, whatever_comes=True)
        return strand.error is None and strand.result()

    def _begun(self, call: Callable[[], R], *, in_turn: bool) -> ThreadStrand[R]:
        strand = ThreadStrand(call, self, in_turn=in_turn)
        strand.begin()
        return strand


async def ended(
    strand: ThreadStrand[R], *, whatever_comes: bool = False
) -> asyncio.CancelledError | None:
    """Wait for the end of a strand; with `whatever_comes`, return the cancelling that came."""
    cancelled = None
    while not strand.ended.done():
        try:
            await asyncio.wait({strand.ended})
        except asyncio.CancelledError as error:
            if not whatever_comes:
                raise
            cancelled = error
    return cancelled


def goes_in_turn(arm: Arm) -> bool:
    """Tell whether an arm lives in simulated time, which the loop drives."""
    return not isinstance(arm.pace, RealPace)


_STAGES: dict[asyncio.AbstractEventLoop, Stage] = {}
"""What belongs to a loop and ends with it. A loop has nowhere else to keep it."""


def stage() -> Stage:
    """Return the stage of the running event loop."""
    loop = asyncio.get_running_loop()
    if loop not in _STAGES:
        for ended_loop in [each for each in _STAGES if each.is_closed()]:
            del _STAGES[ended_loop]
        _STAGES[loop] = Stage(loop)
    return _STAGES[loop]
