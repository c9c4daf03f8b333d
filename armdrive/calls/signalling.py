"""Inputs and outputs of the arm's controller, one by one: read, waited for, switched."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from armdrive.calls.connected import Connected
from armdrive.errors import BadRequest, InputTimeout, Stopped
from armdrive.flows import idling, referencing
from armdrive.lines import Lines, input_bits, output_bits
from armdrive.pace import RealPace
from armdrive.states import Event, after
from armdrive.status import State
from kinematics.errors import finite

if TYPE_CHECKING:
    from armdrive.engine import Engine

SIMULATED_S = 3600.0
"""A wait without a deadline ends after so long on simulated time, where nobody could interrupt it.
"""

_ASLEEP = (State.DISCONNECTED, State.DISABLED, State.ERROR_STOP)
"""The states in which nobody looks at an arm."""


class Signalling(Connected):
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
        self._require_present(absences)
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
