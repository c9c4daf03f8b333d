"""The inputs and outputs of an arm's controller, the program in its memory, and its settings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from armdrive.arm.arguments import RULES
from armdrive.arm.connected import ArmPart
from armdrive.blocking import blocking, coroutine_of
from armdrive.connect.runner import PATIENCE_S
from armdrive.errors import BadRequest, InputTimeout
from armdrive.errors.arguments import checked_calls, known_attributes
from armdrive.motion import device as device_tasks
from armdrive.motion.device import require_inputs, require_outputs
from armdrive.registry import pendant_of
from armdrive.runtime.arm_state import Core
from armdrive.runtime.overrides import LONGEST_SIMULATED_WAIT_S
from armdrive.runtime.states import Event
from armdrive.status import BELIEVED, State
from armdrive.tasks import DeviceSettings
from armdrive.trace.recorder import traced

if TYPE_CHECKING:
    from armdrive.registry.pendant import PendantProgram

# One input or output, or several, counted from 1.
Lines = int | Iterable[int]


def input_bits(core: Core, lines: Lines) -> int:
    """Return the bits of an arm's inputs.

    Raises `BadRequest` for a number out of range, and `Refused` if the arm has no inputs.
    """
    most = require_inputs(core)
    return _bits(lines, f"the inputs of the {core.config.title}", most)


def output_bits(core: Core, lines: Lines) -> int:
    """Return the bits of an arm's outputs, with the same errors."""
    most = require_outputs(core)
    return _bits(lines, f"the outputs of the {core.config.title}", most)


def _bits(lines: Lines, what: str, most: int) -> int:
    bits = 0
    for number in [lines] if isinstance(lines, int) else lines:
        whole = isinstance(number, int) and not isinstance(number, bool)
        if not whole or not 1 <= number <= most:
            raise BadRequest(f"{what} are counted from 1 to {most}, not {number!r}")
        bits |= 1 << number - 1
    return bits


# Inputs and outputs of the arm's controller: reading, waiting and switching.

WAITING = "waiting for inputs"
# The states in which an arm's inputs are not read.
_NOT_POLLED = (State.DISCONNECTED, State.DISABLED, State.ERROR_STOP)


@known_attributes
@traced("io")
@checked_calls(RULES)
class InputsOutputs(ArmPart):
    """The inputs and outputs of an arm, counted from 1. Nothing here moves it."""

    @blocking
    async def read(self) -> int:
        """Read the input bits now. Raises `Refused` if the arm has no inputs."""
        require_inputs(self._core)
        await coroutine_of(self._parts.look)()
        return self._core.readings.inputs or 0

    @blocking
    async def wait(
        self, *, high: Lines = (), low: Lines = (), within_s: float | None = None
    ) -> int:
        """Wait until the given inputs, counted from 1, are high or low; return the input bits.

        `wait(high=3, low=(1, 2), within_s=10)` waits on the arm's own clock, not counting pauses,
        and other calls may run meanwhile. While the arm stands, its inputs are read 20 times a
        second; while it moves, as often as the controller reports them.

        Raises `InputTimeout` at the deadline (in simulated time after 600 s at the latest),
        `Stopped` if the arm is stopped or the program was suspended, `LinkLost`, `WrongState` if
        the arm is disabled or in error-stop, and `Refused` if it has no inputs.
        """
        want, shun = input_bits(self._core, high), input_bits(self._core, low)
        patience_s = self._patience_s(within_s)
        if want & shun or not want | shun:
            raise BadRequest(
                "name at least one input as high or low, and none as both: high=1, low=2"
            )
        core, runner = self._core, self._parts.runner
        stops = runner.known_stops
        with self._parts.pace.lock:
            if core.state in _NOT_POLLED:
                runner.require(Event.MOVE, WAITING)
            core.readings.awaiting += 1
            seen = core.readings.sensed
            absences = runner.absences()

        def ended() -> bool:
            if runner.interrupted(stops, absences) or core.state in _NOT_POLLED:
                return True
            bits = core.readings.inputs or 0
            return core.readings.sensed != seen and bits & want == want and not bits & shun

        self._parts.pace.wake()
        try:
            met = await runner.wait_unpaused(ended, patience_s)
        finally:
            with self._parts.pace.lock:
                core.readings.awaiting -= 1
        runner.require_no_stop(stops, "while the program waited for inputs")
        if core.state in _NOT_POLLED:
            runner.require(Event.MOVE, WAITING)
        runner.require_present(absences)
        if not met:
            simulated = within_s is None and patience_s < math.inf
            limit = ", the most in simulated time," if simulated else ""
            raise InputTimeout(
                f"waited {patience_s:g} s{limit} for {_words(want, shun)}: the inputs still read "
                f"{core.readings.inputs or 0:08b} (the last digit is input 1)"
            )
        return core.readings.inputs or 0

    @blocking
    async def set(self, number: int, on: bool = True) -> None:
        """Switch one output, counted from 1; the others stay. Moves nothing.

        Controllers do not report their outputs. Outputs that this connection has not written are
        assumed to be off, as they are after the controller is switched on.
        """
        bit = output_bits(self._core, number)
        bits = self._core.readings.outputs or 0
        await coroutine_of(self.write)(bits | bit if on else bits & ~bit)

    @blocking
    async def write(self, bits: int) -> None:
        """Write all the output bits. Moves nothing."""
        self._parts.runner.require(Event.MOVE, "switching an output")
        await self._parts.runner.perform(device_tasks.set_outputs(self._parts.context, bits))

    def _patience_s(self, within_s: float | None) -> float:
        if within_s is None or within_s == math.inf:
            return math.inf if self._parts.pace.real_time else LONGEST_SIMULATED_WAIT_S
        return within_s


def _words(want: int, shun: int) -> str:
    named = [(want, "high"), (shun, "low")]
    return " and ".join(
        f"{name} {', '.join(str(bit + 1) for bit in range(bits.bit_length()) if bits >> bit & 1)}"
        for bits, name in named
        if bits
    )


# What the controller stores: a program of its pendant, and its settings.

# at 110 baud a program takes many minutes; every single request has its own, shorter deadline
PROGRAM_PATIENCE_S = 3600.0


@known_attributes
@traced("controller")
@checked_calls(RULES)
class ControllerMemory(ArmPart):
    """The program and the settings that an arm's controller stores. Nothing here moves the arm."""

    @blocking
    async def read_program(self) -> PendantProgram:
        """Read the program in the arm's own memory; takes a few seconds and moves nothing.

        The memory is read until two readings agree. If the position is trusted, the program's
        `origin` ties its rows to the current reference. Raises `Refused` if the arm stores no
        program, and `DeviceFault`.
        """
        programs = self._own_programs()
        body = device_tasks.read_program(self._parts.context)
        rows = await self._parts.runner.perform(body, PROGRAM_PATIENCE_S)
        return programs.from_words(rows, self._origin())

    @blocking
    async def write_program(self, program: PendantProgram, *, leave_others: bool = False) -> int:
        """Write a program into the arm's memory and read it back; moves nothing.

        Returns the number of rows that had to be written. Raises `Refused` if the program was read
        under a different reference, so that its rows now mean other places (`moved_to` shifts
        them), or if the arm has rows that the program does not replace, unless `leave_others`. If
        writing ends early, raises `ProgramHalfWritten`.
        """
        self._own_programs()
        program.require_fitting(self._core.controller.abilities.program_rows)
        program.require_origin(self._origin())
        body = device_tasks.write_program(
            self._parts.context, program.words, leave_others=leave_others
        )
        return await self._parts.runner.perform(body, PROGRAM_PATIENCE_S)

    @blocking
    async def fix_settings(self, lines: Sequence[str] | None = None) -> DeviceSettings:
        """Write the lines that set the device as the arm file expects. Moves nothing.

        Without `lines`, write all those that `status.notice` and `armdrive doctor` show.
        """
        shown = [each.fix for each in self._core.differences if each.fix]
        chosen = tuple(shown if lines is None else lines)
        body = device_tasks.fix_settings(self._parts.context, chosen)
        return await self._parts.runner.perform(body, PATIENCE_S)

    def _own_programs(self) -> type[PendantProgram]:
        """Return the class of the arm's programs. Raises `Refused` if it has no memory for them."""
        programs = pendant_of(self._parts.config)
        self._parts.runner.require(Event.MOVE, "using the arm's own program memory")
        return programs

    def _origin(self) -> tuple[int, ...] | None:
        """Return the offset from registers to motor positions; None if it is not trusted."""
        return tuple(self._core.position.offset) if self._core.belief.trust in BELIEVED else None
