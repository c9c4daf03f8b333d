"""Inputs and outputs of the arm's controller, one by one: read, waited for, switched."""

from __future__ import annotations

import math

from armdrive.blocking import Wait
from armdrive.connect.parts import Parts
from armdrive.errors import BadRequest, InputTimeout, Stopped
from armdrive.motion import idle as idling
from armdrive.motion import reference as referencing
from armdrive.runtime.drive import RealPace
from armdrive.runtime.engine import Engine
from armdrive.runtime.io_lines import Lines, input_bits, output_bits
from armdrive.runtime.states import Event, after
from armdrive.status import State
from kinematics.errors import finite

SIMULATED_S = 3600.0
"""A wait without a deadline ends after so long on simulated time, where nobody could interrupt it.
"""

_ASLEEP = (State.DISCONNECTED, State.DISABLED, State.ERROR_STOP)
"""The states in which nobody looks at an arm."""


class InputsOutputs:
    """The inputs and outputs of one arm. Nothing here moves it."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._core = parts.core

    async def set_outputs(self, bits: int) -> None:
        """Write the output bits. Moves nothing."""
        after(self._core.state, Event.MOVE)
        await self._parts.runner.perform(idling.set_outputs(self._parts.wire, bits))

    async def set_output(self, number: int, on: bool = True) -> None:
        """Switch one output, counted from 1; the others stay. Moves nothing.

        Outputs that this connection has not written yet are taken to be off, as they are when the
        controller is switched on: no such controller tells how they are.
        """
        bit = output_bits(number)
        bits = self._core.readings.outputs or 0
        await self.set_outputs(bits | bit if on else bits & ~bit)

    async def read_inputs(self) -> int:
        """Read the input bits now."""
        await self._parts.runner.perform(referencing.poll(self._parts.wire))
        return self._core.readings.inputs or 0

    async def wait_inputs(
        self, *, high: Lines = (), low: Lines = (), within_s: float | None = None
    ) -> int:
        """Wait until inputs, counted from 1, are high and low; return the input bits.

        `wait_inputs(high=3, low=(1, 2), within_s=10)`, on the arm's own clock. Other calls may go
        on meanwhile: a standing arm is looked at 20 times a second, one in motion as often as its
        controller tells. Raises `InputTimeout` at the deadline, `Stopped` where the arm is stopped
        or this program was suspended, what broke where its wire is lost, `WrongState` for an arm
        that nobody looks at, and `Refused` for one that has no inputs.
        """
        want, shun = input_bits(self._core, high), input_bits(self._core, low)
        patience_s = self._patience_s(within_s)
        if want & shun or not want | shun:
            raise BadRequest("name inputs that shall be high or low, none as both: high=1, low=2")
        core, stops = self._core, self._parts.runner.stops
        with self._parts.pace.lock:
            if core.state in _ASLEEP:
                after(core.state, Event.MOVE)
            core.readings.awaiting += 1
            seen = core.readings.sensed
            absences = self._parts.engine.absences

        def ended() -> bool:
            if self._parts.runner.stops != stops or core.state in _ASLEEP:
                return True
            bits = core.readings.inputs or 0
            return core.readings.sensed != seen and bits & want == want and not bits & shun

        self._parts.pace.wake()
        try:
            met = await Wait(self._parts.pace, ended, patience_s)
        finally:
            with self._parts.pace.lock:
                core.readings.awaiting -= 1
        self._require_looking(self._parts.engine, stops)
        self._parts.runner.require_present(absences)
        if not met:
            raise InputTimeout(
                f"after {patience_s:g} s {_words(want, shun)} is not so: the inputs read "
                f"{core.readings.inputs or 0:08b}, the last digit is input 1"
            )
        return core.readings.inputs or 0

    def _require_looking(self, engine: Engine, stops: int) -> None:
        """Raise what keeps anybody from seeing the inputs."""
        if engine.broken is not None:
            raise engine.broken
        if self._parts.runner.stops != stops:
            raise Stopped("a stop was asked for while the program waited for inputs")
        if self._core.state in _ASLEEP:
            after(self._core.state, Event.MOVE)

    def _patience_s(self, within_s: float | None) -> float:
        if within_s is None:
            return math.inf if isinstance(self._parts.pace, RealPace) else SIMULATED_S
        return max(finite("within_s", within_s), 0.0)


def _words(want: int, shun: int) -> str:
    named = [(want, "high"), (shun, "low")]
    return " and ".join(
        f"{name} {', '.join(str(bit + 1) for bit in range(bits.bit_length()) if bits >> bit & 1)}"
        for bits, name in named
        if bits
    )
