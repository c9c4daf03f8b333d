"""The outputs of a GRBL board and the gripper on one of them, which a reset switches off."""

from __future__ import annotations

from collections.abc import Generator

from armdrive.dialects.grbl.exchange import Answering, GrblExchange, refusal
from armdrive.dialects.grbl.settings import GrblSettings
from armdrive.errors import Refused
from armdrive.tasks import Done, RequestRejected
from firmware_protocol.grbl import Acknowledged, Coolant, DigitalOutput, Line
from firmware_protocol.grbl.events import Event as HostEvent

TOLD = {"M3", "flood", "mist"}
"""The outputs of which a status report says that they are on (gnea/grbl grbl/report.c)."""

Switching = Generator[float, HostEvent | None, RequestRejected | None]


class GrblOutputs:
    """Switches outputs and drives a gripper that is no stepper; knows what was last asked of them.

    `reset_lets_go` says that a reset can switch off what the gripper hangs on, and `reported` that
    a status report tells whether that is on.
    """

    def __init__(self, exchange: GrblExchange, settings: GrblSettings, gripper: str) -> None:
        self._exchange = exchange
        self._settings = settings
        self._gripper = gripper
        self._bits: int | None = None
        self._share: float | None = None
        self.reset_lets_go = gripper in ("servo", "output")
        outputs = settings.outputs[settings.gripper_output :][:1]
        hangs_on = (settings.servo,) if gripper == "servo" else outputs
        self.reported = set(hangs_on) <= TOLD

    def check(self, bits: int) -> None:
        """Raise `Refused` where the arm file names no output for one of the bits."""
        if bits >> len(self._settings.outputs):
            raise Refused(
                f"this board has {len(self._settings.outputs)} outputs, {bits} needs more: "
                "name them in grbl.outputs"
            )

    def check_gripper(self) -> None:
        """Raise `Refused` where the gripper is driven by a motor."""
        if not self.reset_lets_go:
            raise Refused("this arm's gripper is driven by a motor, not by a servo or output")

    def set(self, bits: int) -> Answering:
        """Switch the outputs."""
        refused = yield from self._switch(bits)
        if refused is None:
            self._bits = bits
        return refused or Done()

    def set_gripper(self, share: float) -> Answering:
        """Open the gripper so far: 0 is closed, 1 is open."""
        if self._gripper == "output":
            bit = 1 << self._settings.gripper_output
            closed = share < 0.5  # the driver asks for 0 or 1 alone
            before = self._bits or 0
            on = closed == self._settings.gripper_closes
            return (yield from self.set(before | bit if on else before & ~bit))
        refused = yield from self._turn_servo(share)
        if refused is None:
            self._share = share
        return refused or Done()

    def restore(self) -> Generator[float, HostEvent | None, None]:
        """Switch on again what a reset switches off: a valve or a servo must not drop its load."""
        if self._share is not None:
            yield from self._turn_servo(self._share)
        if self._bits:
            yield from self._switch(self._bits)

    def _turn_servo(self, share: float) -> Switching:
        span = self._settings.servo_open - self._settings.servo_closed
        value = self._settings.servo_closed + span * share
        word = "S" if self._settings.servo == "M3" else "Q"
        line = Line(f"{self._settings.servo}{word}{value:.3f}".rstrip("0").rstrip("."))
        return (yield from self._carry_out((line,), "the gripper's servo"))

    def _switch(self, bits: int) -> Switching:
        """Switch the outputs; flood and mist have one word to switch both off."""
        words = self._settings.outputs
        on = {word for bit, word in enumerate(words) if bits >> bit & 1}
        commands: list[Line | Coolant | DigitalOutput] = []
        if {"flood", "mist"} & set(words) - on:
            commands.append(Coolant(on=False))
        commands += [Coolant(on=True)] * ("flood" in on)
        commands += [Line("M7")] * ("mist" in on)
        commands += [
            DigitalOutput(int(word[1:]), word in on, at_once=True)
            for word in words
            if word.startswith("P")
        ]
        return (yield from self._carry_out(tuple(commands), "the outputs"))

    def _carry_out(
        self, commands: tuple[Line | Coolant | DigitalOutput, ...], what: str
    ) -> Switching:
        """Say lines one at a time; return why one was refused."""
        for command in commands:
            heard = yield from self._exchange.ask(command, self._settings.answer_s)
            if not isinstance(heard, Acknowledged):
                return refusal(heard, what)
        return None
