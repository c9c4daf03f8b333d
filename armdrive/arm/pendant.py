"""The program that an arm keeps in a memory of its own, for its pendant: read, and written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.connect.parts import Parts
from armdrive.motion import device as program_memory
from armdrive.registry import pendant_of
from armdrive.runtime.states import Event, after
from armdrive.status import Trust

if TYPE_CHECKING:  # few arms keep a program
    from armdrive.dialects.pendant import PendantTools
    from armdrive.registry.pendant import PendantProgram

PATIENCE_S = 3600.0
"""Every request in it has a deadline from its bytes: at 110 baud they add up to many minutes."""


class PendantMemory:
    """The program in one arm's own memory. Nothing here moves it."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts

    async def read(self) -> PendantProgram:
        """Read the program in the arm's own memory; takes some seconds, and moves nothing.

        It is read until two readings agree. Where the position is trusted, the program says as
        well what its rows mean (`origin`). Raises `Refused` for an arm that keeps no program, and
        `DeviceFault`.
        """
        memory = self._memory()
        body = program_memory.read_program(self._parts.wire)
        rows = await self._parts.runner.perform(body, PATIENCE_S)
        return memory.from_words(rows, self._origin())

    async def write(
        self,
        program: PendantProgram,
        *,
        leave_others: bool = False,
        told: program_memory.RowTold = program_memory.unheard,
    ) -> int:
        """Write a program into the arm's memory, and read it back; moves nothing.

        Returns how many rows were not there already; `told` is called by the engine's thread with
        the number of each as it is in the arm, and must not wait for anything. Raises `Refused`
        where the program's rows were read under another reference, so that they mean other places
        now (`moved_to` shifts them), or where rows of other numbers would stay, unless
        `leave_others`. An end before the end raises `ProgramHalfWritten`, which names the rows
        that are in the arm.
        """
        self._memory()
        program.require_fitting(self._parts.core.controller.abilities.program_rows)
        program.require_origin(self._origin())
        body = program_memory.write_program(
            self._parts.wire, program.words, leave_others=leave_others, told=told
        )
        return await self._parts.runner.perform(body, PATIENCE_S)

    def _memory(self) -> PendantTools[PendantProgram]:
        """Return how its memory is read; raises `Refused` for an arm that has none."""
        memory = pendant_of(self._parts.config)
        after(self._parts.core.state, Event.MOVE)
        return memory

    def _origin(self) -> tuple[int, ...] | None:
        """Return what the registers have to be added to now; None where nobody knows it."""
        if self._parts.core.belief.trust in (Trust.REFERENCED, Trust.RESTORED):
            return tuple(self._parts.core.position.offset)
        return None
