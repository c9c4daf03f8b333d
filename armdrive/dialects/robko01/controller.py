"""The driver's end of the Robko 01's SUPER protocol: neutral requests to exchanges of frames.

A motion is one move to absolute positions; where the motors are is asked until they have arrived.
The board drops what it does not understand in silence, so after a lost answer it is first brought
back into step and looked at, and a motion is sent once more only where nothing of it was seen.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Sequence
from dataclasses import replace
from typing import TypeAlias

from armdrive.abilities import Abilities
from armdrive.dialects.controller import StopPart, Stopping
from armdrive.dialects.dialect import Driver
from armdrive.dialects.robko01.motion import OVERSHOOT_STEPS, RobkoMotion
from armdrive.dialects.robko01.settings import RobkoSettings
from armdrive.dialects.robko01.words import RECOGNITION, TALK
from armdrive.errors import Refused
from armdrive.tasks import (
    Alert,
    AlertKind,
    ClearFault,
    DeviceSettings,
    Done,
    DropCurrent,
    MoveBy,
    ProtocolWarning,
    ReadPosition,
    ReadSettings,
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
    Inputs,
    InputsRead,
    Outputs,
    Pong,
    Status,
    Stray,
)
from firmware_protocol.robko01 import Event as HostEvent
from firmware_protocol.robko01 import Request as Message
from kinematics.spaces import Motors

Script: TypeAlias = Generator[float, HostEvent | None, Reply]

HOST_S = 0.03
"""What the operating system, an adapter or a network may add to a message's way."""
LOOKS_S = 0.12
"""How long it takes at most to see that the motors stand, once they do."""
FEEDS = 3.0
"""A watchdog is fed so many times in the time that it grants."""
LONGEST_MOVE_BYTES = 32


class RobkoController(RobkoMotion):
    """One Robko 01, seen from the driver."""

    def __init__(self, abilities: Abilities, settings: RobkoSettings, baud: int) -> None:
        super().__init__(replace(abilities, resets_on_open=settings.resets_on_open), settings, baud)
        self._feeding_s = -math.inf

    def script(self, request: Request) -> Script:
        """Carry out a request, unless the firmware's watchdog has run out meanwhile."""
        if self._starved() and not isinstance(request, SwitchOn):
            self._on = False
            silent_s = self.now_s - self._fed_s
            words = f"the controller heard nothing for {silent_s:.1f} s, so its watchdog has"
            self.tell(Alert(AlertKind.SWITCHED_OFF, f"{words} switched the motors off"))
            if isinstance(request, MoveBy):
                return RequestRejected("its watchdog has switched the motors off", moved=False)
        return (yield from self._carry_out(request))

    def _carry_out(self, request: Request) -> Script:
        match request:
            case MoveBy(steps, rate_hz, let_go):
                return (yield from self._move(steps, rate_hz, let_go))
            case ReadPosition():
                return (yield from self._registers())
            case SetOutputs(bits):
                return (yield from self._simple(Outputs(bits)))
            case SwitchOn():
                return (yield from self._switch(Enable(), on=True))
            case DropCurrent():
                return (yield from self._switch(Disable(), on=False))
            case ReadSettings():
                return DeviceSettings()
            case ClearFault():
                return Done()  # it has no alarm of its own
            case _:
                raise Refused(f"a Robko 01 knows no {type(request).__name__}")

    def unasked(self, heard: HostEvent) -> None:
        """Tell of what answers nothing, apart from late answers to what keeps the watchdog fed."""
        if isinstance(heard, Answered):
            self._heed(heard)
        elif not (isinstance(heard, Stray) and isinstance(heard.answer, Pong)):
            self.tell(ProtocolWarning(str(heard)))

    # -- what the engine calls ----------------------------------------------------------------

    def advance(self, now_s: float) -> bytes:
        """Do what is due by now; between requests, keep the watchdog fed."""
        data = super().advance(now_s)
        if now_s < self._feed_s():
            return data
        self._feeding_s = now_s
        self._host.forget()
        return data + self._host.send(self._token())

    def next_s(self) -> float:
        """Tell when something is due."""
        return min(super().next_s(), self._feed_s())

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate that an axis really has, at or below the one wanted."""
        return self._pacing.usable_hz(rate_hz)

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long so many steps take on an arm that is as slow as it may be."""
        return self._pacing.lasts_s(steps, rate_hz) * self._meter.doubt

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Return a burst behind its message, whoever stops: the stop may be lost.

        Its way is that of the steps that fit into a burst, ramps included, at the speed that the
        axis comes to: far fewer than at that speed all the time.
        """
        lasts_s = max(burst_s, self.duration_s(1.0, math.inf))  # a single step is the least
        rate_hz = max((part.rate_hz for part in parts), default=math.inf)
        usable_hz = self.usable_rate_hz(rate_hz)
        motion_s = self._pacing.most_steps(burst_s, rate_hz) / min(rate_hz, usable_hz)
        stands_s = HOST_S + LONGEST_MOVE_BYTES * self._byte_s + lasts_s
        return Stopping(stands_s, motion_s, stands_s, motion_s, stands_s + LOOKS_S, OVERSHOOT_STEPS)

    def strays_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:
        """Bound how many steps an axis strays from the straight way in such a motion."""
        return self._pacing.strays_steps(tuple(steps), rate_hz)

    # -- small requests -----------------------------------------------------------------------

    def _registers(self) -> Script:
        """Read inputs, then positions: those are no older than any silence on the way."""
        began_s, before = self.now_s, self._seen
        inputs = yield from self._ask(Inputs())
        if not isinstance(inputs, InputsRead):
            return self.silence(began_s)
        positions = yield from self._look("POSITION")
        if positions is None:
            return self.silence(began_s)
        if self._on and before is not None and before.largest and not positions.largest:
            self.restarted("the controller was reset or lost its power: its positions are zero")
        return Registers(positions, inputs.value)

    def _simple(self, message: Message) -> Script:
        """Send what may be sent twice."""
        began_s = self.now_s
        answer = yield from self._ask(message, text=str(message))
        if answer is None:
            return self.silence(began_s)
        if isinstance(answer, Acknowledged) and answer.status is not Status.OK:
            return RequestRejected(f"it answered {answer.status.name}", moved=False)
        return Done()

    def _switch(self, message: Enable | Disable, *, on: bool) -> Script:
        self._on = False
        reply = yield from self._simple(message)
        if isinstance(reply, Done):
            self._on = on
            self._fed_s = max(self._fed_s, self.now_s)
        return reply

    # -- the firmware's watchdog --------------------------------------------------------------

    def _starved(self) -> bool:
        watchdog_s = self._settings.watchdog_s
        return bool(watchdog_s) and self._on and self.now_s > self._fed_s + watchdog_s

    def _feed_s(self) -> float:
        """Tell when to feed it next; a request feeds it by itself."""
        if not self._settings.watchdog_s or not self._on or self.busy or self._starved():
            return math.inf
        return max(self._fed_s, self._feeding_s) + self._settings.watchdog_s / FEEDS


DRIVER = Driver(
    RobkoSettings,
    lambda abilities, config: RobkoController(abilities, config.device, config.connection.baud),
    TALK,
    RECOGNITION,
)
