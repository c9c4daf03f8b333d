"""The inputs and outputs of an arm's controller, and the program in its memory."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

from armdrive.abilities import OUTPUTS
from armdrive.connect.parts import Parts
from armdrive.errors import BadRequest, InputTimeout, Refused
from armdrive.motion import device as device_tasks
from armdrive.registry import pendant_of
from armdrive.runtime.arm_state import Core
from armdrive.runtime.clock import RealPace
from armdrive.runtime.states import Event
from armdrive.status import BELIEVED, State

if TYPE_CHECKING:
    from armdrive.dialects import PendantTools
    from armdrive.registry.pendant import PendantProgram

Lines = int | Iterable[int]
"""One input or output, or several, counted from 1."""


def output_bits(lines: Lines) -> int:
    """Return the bits of outputs. Raises `BadRequest` for a number out of range."""
    return _bits(lines, "outputs", OUTPUTS)


def input_bits(core: Core, lines: Lines) -> int:
    """Return the bits of an arm's inputs.

    Raises `BadRequest` for a number out of range, and `Refused` if the arm has no inputs, because
    waiting for one would never end.
    """
    most = core.controller.abilities.inputs
    if not most:
        raise Refused(
            f"the controller of the {core.config.title} has no inputs to read or to wait for"
        )
    return _bits(lines, f"the inputs of the {core.config.title}", most)


def _bits(lines: Lines, what: str, most: int) -> int:
    bits = 0
    for number in [lines] if isinstance(lines, int) else lines:
        whole = isinstance(number, int) and not isinstance(number, bool)
        if not whole or not 1 <= number <= most:
            raise BadRequest(f"{what} are counted from 1 to {most}, not {number!r}")
        bits |= 1 << number - 1
    return bits


# Inputs and outputs of the arm's controller: reading, waiting and switching.

# limit of a wait without a deadline in simulated time, where Ctrl-C could not end it
SIMULATED_S = 3600.0

WAITING = "waiting for inputs"
_NOT_POLLED = (State.DISCONNECTED, State.DISABLED, State.ERROR_STOP)
"""The states in which an arm's inputs are not read."""


class InputsOutputs:
    """The inputs and outputs of one arm. Nothing here moves it."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._core = parts.core

    async def set_outputs(self, bits: int) -> None:
        """Write the output bits. Moves nothing."""
        self._parts.runner.require(Event.MOVE, "switching an output")
        await self._parts.runner.perform(device_tasks.set_outputs(self._parts.context, bits))

    async def set_output(self, number: int, on: bool = True) -> None:
        """Switch one output, counted from 1; see `Arm.set_output`."""
        bit = output_bits(number)
        bits = self._core.readings.outputs or 0
        await self.set_outputs(bits | bit if on else bits & ~bit)

    async def read_inputs(self) -> int:
        """Read the input bits now."""
        await self._parts.runner.perform(self._parts.context.look())
        return self._core.readings.inputs or 0

    async def wait_inputs(
        self, *, high: Lines = (), low: Lines = (), within_s: float | None = None
    ) -> int:
        """Wait until inputs are high or low, and return all bits; see `Arm.wait_inputs`."""
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
            absences = self._parts.engine.suspend_count

        def ended() -> bool:
            if runner.stops != stops or core.state in _NOT_POLLED:
                return True
            bits = core.readings.inputs or 0
            return core.readings.sensed != seen and bits & want == want and not bits & shun

        self._parts.pace.wake()
        try:
            met = await runner.wait(ended, patience_s)
        finally:
            with self._parts.pace.lock:
                core.readings.awaiting -= 1
        runner.require_no_stop(stops, "while the program waited for inputs")
        if core.state in _NOT_POLLED:
            runner.require(Event.MOVE, WAITING)
        runner.require_present(absences)
        if not met:
            raise InputTimeout(
                f"waited {patience_s:g} s for {_words(want, shun)}: the inputs still read "
                f"{core.readings.inputs or 0:08b} (the last digit is input 1)"
            )
        return core.readings.inputs or 0

    def _patience_s(self, within_s: float | None) -> float:
        if within_s is None or within_s == math.inf:
            return math.inf if isinstance(self._parts.pace, RealPace) else SIMULATED_S
        return within_s


def _words(want: int, shun: int) -> str:
    named = [(want, "high"), (shun, "low")]
    return " and ".join(
        f"{name} {', '.join(str(bit + 1) for bit in range(bits.bit_length()) if bits >> bit & 1)}"
        for bits, name in named
        if bits
    )


# The pendant's program in an arm's own memory: reading and writing.

# at 110 baud a program takes many minutes; every single request has its own, shorter deadline
PATIENCE_S = 3600.0


async def read_pendant_program(parts: Parts) -> PendantProgram:
    """Read the program in the arm's own memory; see `Arm.read_pendant_program`."""
    memory = _pendant_memory(parts)
    rows = await parts.runner.perform(device_tasks.read_program(parts.context), PATIENCE_S)
    return memory.from_words(rows, _origin(parts.core))


async def write_pendant_program(
    parts: Parts, program: PendantProgram, leave_others: bool, report: device_tasks.RowReport
) -> int:
    """Write a program into the arm's memory; see `Arm.write_pendant_program`."""
    _pendant_memory(parts)
    program.require_fitting(parts.core.controller.abilities.program_rows)
    program.require_origin(_origin(parts.core))
    body = device_tasks.write_program(
        parts.context, program.words, leave_others=leave_others, report=report
    )
    return await parts.runner.perform(body, PATIENCE_S)


def _pendant_memory(parts: Parts) -> PendantTools[PendantProgram]:
    """Return the dialect's pendant tools. Raises `Refused` if the arm has no such memory."""
    memory = pendant_of(parts.config)
    parts.runner.require(Event.MOVE, "using the arm's own program memory")
    return memory


def _origin(core: Core) -> tuple[int, ...] | None:
    """Return the offset from registers to motor positions; None if it is not trusted."""
    return tuple(core.position.offset) if core.belief.trust in BELIEVED else None
