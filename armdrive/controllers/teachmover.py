"""The driver's end of the TeachMover dialect: neutral requests to lines, status lines to replies.

A burst is one `@STEP`; nothing can end it early, and its answer comes when the motion has ended.
"""

from __future__ import annotations

from dataclasses import dataclass

from armdrive.abilities import Abilities
from armdrive.controllers.requests import (
    Denied,
    Done,
    DropCurrent,
    Interrupted,
    MoveBy,
    Oddity,
    ReadPosition,
    Registers,
    Reply,
    Request,
    Sent,
    SetOutputs,
)
from armdrive.controllers.speed import SpeedMeter, SpeedTable
from armdrive.sections import within
from firmware_protocol.teachmover import (
    SPEED_MAX,
    Command,
    Completed,
    Host,
    Key,
    Read,
    Reset,
    Status,
    Step,
)
from kinematics.spaces import Motors

BITS_A_BYTE = 10
LONGEST_LINE = len("@STEP 245,-32768,-32768,-32768,-32768,-32768,-32768,255\r") + len("1\r")
LONGEST_REGISTERS = len("1\r-32768,-32768,-32768,-32768,-32768,-32768,65535\r")
STILL = (0, 0, 0, 0, 0, 0)


@dataclass(frozen=True, slots=True)
class TeachMoverSettings:
    """What was never published, or differs from arm to arm, as settings of the arm file.

    `speed_table` pairs SP with half-steps a second; `speed_doubt` is how much slower the arm may
    be until it has been measured; `grip_bit` is the input bit of the grip switch;
    `answer_margin_s` is added to every deadline.
    """

    speed_table: tuple[tuple[int, float], ...] = (
        (0, 30.0),
        (140, 150.0),
        (190, 250.0),
        (240, 470.0),
    )
    speed_doubt: float = 2.0
    grip_bit: int = 0
    answer_margin_s: float = 0.5

    def __post_init__(self) -> None:
        within("teachmover.speed_doubt", self.speed_doubt, 1.0, 20.0)
        within("teachmover.grip_bit", self.grip_bit, 0, 7)
        within("teachmover.answer_margin_s", self.answer_margin_s, 0.1, 10.0)
        for setting, rate_hz in SpeedTable(self.speed_table).points:
            within("teachmover.speed_table's setting", setting, 0, SPEED_MAX)
            within("teachmover.speed_table's rate", rate_hz, 1.0, 20_000.0)


class TeachMoverController:
    """One TeachMover, seen from the driver."""

    def __init__(self, abilities: Abilities, settings: TeachMoverSettings, baud: int) -> None:
        self.abilities = abilities
        self._settings = settings
        self._byte_s = BITS_A_BYTE / baud
        self._host = Host()
        self._table = SpeedTable(settings.speed_table)
        self._meter = SpeedMeter(self._table, settings.speed_doubt)
        self._outputs: int | None = None

    def encode(self, request: Request) -> Sent:
        """Turn a request into one line."""
        command = self._command(request)
        data = self._host.send(command)
        motion_s, patient_s = self._motion_s(command)
        answer = LONGEST_REGISTERS if isinstance(command, Read) else len("1\r")
        wire_s = (len(data) + answer) * self._byte_s
        return Sent(
            request,
            data,
            motion_s,
            wire_s,
            patience_s=patient_s + wire_s + self._settings.answer_margin_s,
            text=data.decode("ascii").strip(),
        )

    def receive(self, data: bytes) -> None:
        """Take bytes from the arm."""
        self._host.receive_data(data)

    def next_event(self) -> Reply | Oddity | None:
        """Return the next reply in neutral words."""
        event = self._host.next_event()
        if event is None:
            return None
        return self._reply(event) if isinstance(event, Completed) else Oddity(str(event))

    def answered(self, sent: Sent, elapsed_s: float) -> bool:
        """Measure a burst against the speed table; False where no such burst takes so long."""
        if not isinstance(sent.request, MoveBy):
            return True
        setting = self._table.setting(sent.request.rate_hz)
        moved_s = elapsed_s - sent.wire_s
        believable = self._meter.believable(setting, sent.motion_s, moved_s)
        self._meter.learn(setting, sent.motion_s, moved_s)
        return believable

    def forget(self) -> None:
        """Give up on the unanswered command."""
        self._host.give_up()
        self._host.discard()

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate of the fastest setting that is no faster; the slowest one's otherwise."""
        return self._table.rate_hz(self._table.setting(rate_hz))

    def doubt(self, rate_hz: float) -> float:
        """Return how much slower the arm may be at that rate."""
        return self._meter.doubt(self._table.setting(rate_hz))

    def stop_overhead_s(self) -> float:
        """Return how long a burst's line and its answer are on the wire."""
        return LONGEST_LINE * self._byte_s

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Undo the wrap of the 16-bit registers."""
        span = 1 << self.abilities.register_bits
        half = span // 2
        return Motors(
            there + (count - there + half) % span - half
            for count, there in zip(registers, near, strict=True)
        )

    def _command(self, request: Request) -> Command:
        match request:
            case MoveBy(steps, rate_hz):
                return Step(self._table.setting(rate_hz), tuple(steps), self._outputs)
            case ReadPosition():
                return Read()
            case SetOutputs(bits):
                step = Step(self._table.points[0][0], STILL, bits)
                self._outputs = bits
                return step
            case DropCurrent():
                return Reset()

    def _motion_s(self, command: Command) -> tuple[float, float]:
        """Return how long the motion should take, and how long it may."""
        if not isinstance(command, Step):
            return 0.0, 0.0
        busiest = max(abs(steps) for steps in command.steps)
        motion_s = busiest / self._table.rate_hz(command.speed)
        return motion_s, motion_s * max(self._meter.doubt(command.speed), 1.0) * SLOWEST_ANSWER

    def _reply(self, event: Completed) -> Reply:
        if event.status is Status.STOPPED:
            return Interrupted()
        if event.status is Status.FAILED:
            return Denied()
        registers = event.registers
        if registers is None:
            return Done()
        return Registers(
            Motors(registers.positions),
            registers.inputs,
            gripping=bool(registers.inputs >> self._settings.grip_bit & 1),
            key=registers.key.name if isinstance(registers.key, Key) else str(registers.key),
        )


SLOWEST_ANSWER = 2.0
"""An answer this many times later than the doubtful arm's is no longer waited for."""
