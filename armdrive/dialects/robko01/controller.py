"""The Robko 01 controller: turns the driver's requests into frames of the SUPER protocol.

A motion is one move to absolute positions. The driver then polls the positions until the motors
arrive. The board silently drops frames that it cannot parse, so after a lost answer the driver
resynchronizes, reads the positions, and resends the motion only if the motors have not moved.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from armdrive.abilities import Abilities
from armdrive.config.arm import ArmConfig
from armdrive.dialects import Driver
from armdrive.dialects.controller import (
    HOST_DELAY_S,
    ScriptRunner,
    StopPart,
    Stopping,
    answer_without_device,
)
from armdrive.dialects.exchange import Script
from armdrive.dialects.robko01.exchange import MotorPower, RobkoExchange
from armdrive.dialects.robko01.motion import OVERSHOOT_STEPS, RobkoMotion
from armdrive.dialects.robko01.settings import SLACK_S, TOLD_BY_S, Pacing, RobkoSettings
from armdrive.dialects.speed_table import PaceMeter
from armdrive.tasks import (
    AlertKind,
    Done,
    DropCurrent,
    MoveBy,
    ReadPosition,
    Registers,
    Reply,
    Request,
    RequestRejected,
    SetOutputs,
    SwitchOn,
)
from firmware_protocol.robko01 import (
    Acknowledged,
    Answered,
    Disable,
    Enable,
    Host,
    Inputs,
    InputsRead,
    Outputs,
    Status,
)
from firmware_protocol.robko01 import Event as HostEvent
from firmware_protocol.robko01 import Request as Message
from kinematics.spaces import Motors

LONGEST_MOVE_BYTES = 32


class RobkoController(ScriptRunner[HostEvent]):
    """One Robko 01, seen from the driver."""

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        settings: RobkoSettings = config.device
        host = Host()
        super().__init__(replace(abilities, resets_on_open=settings.resets_on_open), host)
        self._byte_s = config.connection.byte_s
        self._pacing = Pacing(settings.known)
        self._meter = PaceMeter(settings.speed_margin, TOLD_BY_S, SLACK_S, SLACK_S)
        self._power = MotorPower(self.io, settings.watchdog_s)
        self._exchange = RobkoExchange(self.io, host, self._power, settings, self._byte_s)
        self._motion = RobkoMotion(self.io, self._exchange, self._power, self._pacing, self._meter)

    def script(self, request: Request) -> Script[HostEvent, Reply]:
        """Carry out a request, after an alert if the firmware's watchdog has expired."""
        if self._power.starved:
            silent_s = self.io.now_s - self._power.fed_s
            words = f"the controller heard nothing for {silent_s:.1f} s, so its watchdog has"
            self._power.lost(AlertKind.SWITCHED_OFF, f"{words} switched the motors off")
        match request:
            case MoveBy(steps, rate_hz, released):
                return (yield from self._motion.move(steps, rate_hz, released))
            case ReadPosition():
                return (yield from self._registers())
            case SetOutputs(bits):
                return (yield from self._simple(Outputs(bits)))
            case SwitchOn():
                return (yield from self._switch(Enable(), on=True))
            case DropCurrent():
                return (yield from self._switch(Disable(), on=False))
            case _:
                return answer_without_device(request)

    def unsolicited(self, event: HostEvent) -> None:
        """Take the answer to a ping that feeds the watchdog, and report any other frame."""
        if isinstance(event, Answered):
            self._exchange.heed(event)
        else:
            super().unsolicited(event)

    def give_up(self) -> None:
        """Give up on the unanswered request."""
        self._exchange.give_up()

    # -- what the engine calls ----------------------------------------------------------------

    def advance(self, now_s: float) -> bytes:
        """Advance the current request; between requests, keep the watchdog fed."""
        data = super().advance(now_s)
        if self.busy or now_s < self._power.due_s:
            return data
        return data + self._exchange.feed()

    def next_s(self) -> float:
        """Return when to call `advance` next; requests feed the watchdog by themselves."""
        due_s = math.inf if self.busy else self._power.due_s
        return min(super().next_s(), due_s)

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the highest rate at or below `rate_hz` that the board can produce."""
        return self._pacing.usable_hz(rate_hz)

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return the longest time that the steps may take, allowing for a slow arm."""
        return self._pacing.lasts_s(steps, rate_hz) * self._meter.doubt

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Assume a whole burst after its message, because the stop message itself may be lost.

        The distance counts the steps that fit into a burst with its ramps, which are far fewer
        than at constant speed.
        """
        lasts_s = max(burst_s, self.duration_s(1.0, math.inf))  # a burst has at least one step
        rate_hz = max((part.rate_hz for part in parts), default=math.inf)
        usable_hz = self.usable_rate_hz(rate_hz)
        motion_s = self._pacing.most_steps(burst_s, rate_hz) / min(rate_hz, usable_hz)
        stands_s = HOST_DELAY_S + LONGEST_MOVE_BYTES * self._byte_s + lasts_s
        return Stopping(stands_s, motion_s, stands_s, motion_s, OVERSHOOT_STEPS)

    def deviation_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:
        """Bound each axis's deviation from the straight path, in steps."""
        return self._pacing.deviation_steps(tuple(steps), rate_hz)

    # -- small requests -----------------------------------------------------------------------

    def _registers(self) -> Script[HostEvent, Reply]:
        """Read the inputs, then the positions, so that the positions are as fresh as possible."""
        before = self._exchange.seen
        inputs = yield from self._exchange.reading(Inputs(), InputsRead)
        positions = yield from self._exchange.look("POSITION")
        if self._power.on and before is not None and before.largest and not positions.largest:
            words = "the controller was reset or lost its power: its positions are zero"
            self._power.lost(AlertKind.RESTARTED, words)
        return Registers(positions, inputs.value)

    def _simple(self, message: Message) -> Script[HostEvent, Reply]:
        """Send a message that is safe to repeat."""
        answer = yield from self._exchange.ask(message, str(message))
        if isinstance(answer, Acknowledged) and answer.status is not Status.OK:
            return RequestRejected(f"it answered {answer.status.name}", moved=False)
        return Done()

    def _switch(self, message: Enable | Disable, *, on: bool) -> Script[HostEvent, Reply]:
        self._power.on = False
        reply = yield from self._simple(message)
        if isinstance(reply, Done):
            self._power.on = on
            self._power.fed()
        return reply


DRIVER = Driver(RobkoSettings, RobkoController)
