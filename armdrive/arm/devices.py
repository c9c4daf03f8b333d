"""Inputs and outputs of the arm's controller, one by one: read, waited for, switched."""

from __future__ import annotations

import math
from datetime import datetime
from functools import cached_property

from armdrive.arm.connected import Connected
from armdrive.dialects.pendant import PendantTools
from armdrive.errors import BadRequest, InputTimeout, Stopped
from armdrive.motion import device as program_memory
from armdrive.motion import idle as idling
from armdrive.motion import reference as referencing
from armdrive.motion.resolve import BASE, LineGoal, PoseGoal, PostureGoal, ResolvedGoal
from armdrive.registry.pendant import PendantProgram, pendant_of
from armdrive.runtime.drive import RealPace
from armdrive.runtime.engine import Engine
from armdrive.runtime.io_lines import Lines, input_bits, output_bits
from armdrive.runtime.states import Event, after
from armdrive.status import State, Trust
from armdrive.storage.point_file import Points, points_of
from armdrive.storage.points import Point
from kinematics.errors import finite
from kinematics.spaces import Pose

SIMULATED_S = 3600.0
"""A wait without a deadline ends after so long on simulated time, where nobody could interrupt it.
"""

_ASLEEP = (State.DISCONNECTED, State.DISABLED, State.ERROR_STOP)
"""The states in which nobody looks at an arm."""


class IoCalls(Connected):
    """The calls that read and switch single lines. None of them moves the arm."""

    def set_outputs(self, bits: int) -> None:
        """Write the output bits. Moves nothing."""
        after(self.core.state, Event.MOVE)
        self.perform(idling.set_outputs(self.wire, bits))

    def set_output(self, number: int, on: bool = True) -> None:
        """Switch one output, counted from 1; the others stay. Moves nothing.

        Outputs that this connection has not written yet are taken to be off, as they are when the
        controller is switched on: no such controller tells how they are.
        """
        bit = output_bits(number)
        bits = self.core.outputs or 0
        self.set_outputs(bits | bit if on else bits & ~bit)

    def read_inputs(self) -> int:
        """Read the input bits now."""
        self.perform(referencing.poll(self.wire))
        return self.core.inputs or 0

    def wait_inputs(
        self, *, high: Lines = (), low: Lines = (), within_s: float | None = None
    ) -> int:
        """Wait until inputs, counted from 1, are high and low; return the input bits.

        `wait_inputs(high=3, low=(1, 2), within_s=10)`, on the arm's own clock. Other calls may go
        on meanwhile: a standing arm is looked at 20 times a second, one in motion as often as its
        controller tells. Raises `InputTimeout` at the deadline, `Stopped` where the arm is stopped
        or this program was suspended, what broke where its wire is lost, `WrongState` for an arm
        that nobody looks at, and `Refused` for one that has no inputs.
        """
        want, shun = input_bits(self.core, high), input_bits(self.core, low)
        patience_s = self._patience_s(within_s)
        if want & shun or not want | shun:
            raise BadRequest("name inputs that shall be high or low, none as both: high=1, low=2")
        core, stops = self.core, self.stops
        with self.pace.lock:
            if core.state in _ASLEEP:
                after(core.state, Event.MOVE)
            core.awaiting += 1
            seen = core.sensed
            absences = self.engine.absences

        def ended() -> bool:
            if self.stops != stops or core.state in _ASLEEP:
                return True
            bits = core.inputs or 0
            return core.sensed != seen and bits & want == want and not bits & shun

        self.pace.wake()
        try:
            met = self.pace.wait(ended, patience_s)
        finally:
            with self.pace.lock:
                core.awaiting -= 1
        self._require_looking(self.engine, stops)
        self.runner.require_present(absences)
        if not met:
            raise InputTimeout(
                f"after {patience_s:g} s {_words(want, shun)} is not so: the inputs read "
                f"{core.inputs or 0:08b}, the last digit is input 1"
            )
        return core.inputs or 0

    def _require_looking(self, engine: Engine, stops: int) -> None:
        """Raise what keeps anybody from seeing the inputs."""
        if engine.broken is not None:
            raise engine.broken
        if self.stops != stops:
            raise Stopped("a stop was asked for while the program waited for inputs")
        if self.core.state in _ASLEEP:
            after(self.core.state, Event.MOVE)

    def _patience_s(self, within_s: float | None) -> float:
        if within_s is None:
            return math.inf if isinstance(self.pace, RealPace) else SIMULATED_S
        return max(finite("within_s", within_s), 0.0)


def _words(want: int, shun: int) -> str:
    named = [(want, "high"), (shun, "low")]
    return " and ".join(
        f"{name} {', '.join(str(bit + 1) for bit in range(bits.bit_length()) if bits >> bit & 1)}"
        for bits, name in named
        if bits
    )


# The program that an arm keeps in a memory of its own, for its pendant: read, and written.

PATIENCE_S = 3600.0
"""Every request in it has a deadline from its bytes: at 110 baud they add up to many minutes."""


class PendantCalls(Connected):
    """The calls about the arm's own program. None of them moves anything."""

    def read_pendant_program(self) -> PendantProgram:
        """Read the program in the arm's own memory; takes some seconds, and moves nothing.

        It is read until two readings agree. Where the position is trusted, the program says as
        well what its rows mean (`origin`). Raises `Refused` for an arm that keeps no program, and
        `DeviceFault`.
        """
        memory = self._memory()
        rows = self.perform(program_memory.read_program(self.wire), PATIENCE_S)
        return memory.from_words(rows, self._origin())

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
        self._memory()
        program.require_fitting(self.abilities.program_rows)
        program.require_origin(self._origin())
        flow = program_memory.write_program(
            self.wire, program.words, leave_others=leave_others, told=told
        )
        return self.perform(flow, PATIENCE_S)

    def _memory(self) -> PendantTools[PendantProgram]:
        """Return how its memory is read; raises `Refused` for an arm that has none."""
        memory = pendant_of(self.config)
        after(self.core.state, Event.MOVE)
        return memory

    def _origin(self) -> tuple[int, ...] | None:
        """Return what the registers have to be added to now; None where nobody knows it."""
        if self.core.belief.trust in (Trust.REFERENCED, Trust.RESTORED):
            return tuple(self.core.offset)
        return None


# Named points: those of the arm's file, and the goals that they are.

Place = Pose | Point | str
"""A pose, a point, or the name of a point."""


class PointCalls(Connected):
    """The calls that name places, and find them again."""

    @cached_property
    def points(self) -> Points:
        """The named points of this arm, a mapping over its file: `arm.points["pick"]`."""
        return points_of(self.config.name, self.config.model.arm, self._here)

    def _here(self) -> Point:
        """Return where the arm stands, on whole steps; raises `NotReferenced`."""
        status = self.status
        self.core.require_reference()
        now = datetime.now().replace(microsecond=0)
        return Point(self.known(status.joints), status.gripper_mm, taught=now)

    def goal_of(self, place: Place, frame: str = BASE, *, line: bool = False) -> ResolvedGoal:
        """Return the goal that a place is. Raises `UnknownPoint` and `BadRequest`."""
        if isinstance(place, Pose):
            return LineGoal(place, frame) if line else PoseGoal(place, frame)
        if frame != BASE:
            raise BadRequest("a point says its joints, which are the same in every frame")
        point = self.points[place] if isinstance(place, str) else place
        if point.joints.names != self.config.model.arm.joint_names:
            raise BadRequest(f"this is a point of an arm with {', '.join(point.joints.names)}")
        if line:
            return LineGoal(self.config.model.arm.fk(point.joints), posture=point.joints)
        return PostureGoal(point.joints)
