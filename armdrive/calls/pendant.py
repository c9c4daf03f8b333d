"""The program that an arm keeps in a memory of its own, for its pendant: read, and written."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.calls.connected import Connected
from armdrive.errors import Refused
from armdrive.flows import program_memory
from armdrive.states import Event, after
from armdrive.status import Trust

if TYPE_CHECKING:
    from armdrive.teaching.pendantrows import PendantProgram

PATIENCE_S = 3600.0
"""Every request in it has a deadline from its bytes: at 110 baud they add up to many minutes."""


class Pendant(Connected):
    """The calls about the arm's own program. None of them moves anything."""

    def read_pendant_program(self) -> PendantProgram:
        """Read the program in the arm's own memory; takes some seconds, and moves nothing.

        It is read until two readings agree. Where the position is trusted, the program says as
        well what its rows mean (`origin`). Raises `Refused` for an arm that keeps no program, and
        `DeviceFault`.
        """
        from armdrive.teaching.pendantrows import PendantProgram

        self._require_memory()
        rows = self.perform(program_memory.read_program(self.wire), PATIENCE_S)
        return PendantProgram.from_words(rows, self._origin())

    def write_pendant_program(
        self,
        program: PendantProgram,
        *,
        leave_others: bool = False,
        told: program_memory.Told = program_memory.unheard,
    ) -> int:
        """Write a program into the arm's memory, and read it back; moves nothing.

        Returns how many rows were not there already; `told` is called by the engine's thread with
        the number of each as it is in the arm, and must not wait for anything. Raises `Refused`
        where the program's rows were read under another reference, so that they mean other places
        now (`moved_to` shifts them), or where rows of other numbers would stay, unless
        `leave_others`. An end before the end raises `ProgramHalfWritten`, which names the rows
        that are in the arm.
        """
        self._require_memory()
        program.require_fitting(self.abilities.program_rows)
        program.require_origin(self._origin())
        flow = program_memory.write_program(
            self.wire, program.words, leave_others=leave_others, told=told
        )
        return self.perform(flow, PATIENCE_S)

    def _require_memory(self) -> None:
        if not self.abilities.program_rows:
            raise Refused(f"the {self.config.title} keeps no program in a memory of its own")
        after(self.core.state, Event.MOVE)

    def _origin(self) -> tuple[int, ...] | None:
        """Return what the registers have to be added to now; None where nobody knows it."""
        if self.core.belief.trust in (Trust.REFERENCED, Trust.RESTORED):
            return tuple(self.core.offset)
        return None
