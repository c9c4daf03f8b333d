"""The face of every controller, and how long it lets a motion go on: what the engine stands on."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias

from armdrive.abilities import Abilities
from armdrive.dialects.exchange import Codec, H, Script, ScriptIO, ScriptLoop
from armdrive.tasks import SWITCHED_ON, Event, Reply, Request
from kinematics.spaces import Motors


@dataclass(frozen=True, slots=True)
class StopPart:
    """A part of a planned motion at one speed: its duration and its busiest motor's steps/s."""

    duration_s: float
    rate_hz: float


@dataclass(frozen=True, slots=True)
class Stopping:
    """How long a motion goes on: after a stop was asked for, and after the host has fallen silent.

    `asked_s` and `silent_s` last until the last step. `asked_motion_s` and `silent_motion_s` are
    how long the motion takes at its own speed for the way that it makes meanwhile, which is less
    where it brakes. `asked_extra_steps` and `silent_extra_steps` are what each motor may turn
    besides: a drive that lags catches up, and a stop may end beyond the target. `confirmed_s` is
    until the driver knows that the motors stand after a stop.
    """

    asked_s: float
    asked_motion_s: float
    silent_s: float
    silent_motion_s: float
    confirmed_s: float
    asked_extra_steps: float = 0.0
    silent_extra_steps: float = 0.0


class ScriptRunner(ABC, Generic[H]):
    """The driver's end of one dialect. Sans-IO: the engine carries its bytes and has the clock.

    It answers requests by scripts. A dialect adds `script`, `unasked` and numbers.
    """

    look_at = SWITCHED_ON
    """What a person does about a device that does not answer."""

    def __init__(
        self, abilities: Abilities, codec: Codec[H], io: ScriptIO[H] | None = None
    ) -> None:
        self.abilities = abilities
        self.io = io or ScriptIO(self.unasked)
        self._loop = ScriptLoop(codec, self.io, self.unasked)

    @property
    def last_said(self) -> str:
        """The text of the message sent last, for people."""
        return self.io.said

    @property
    def underruns(self) -> int:
        """How often a device that queues stood still although more of its motion was to come."""
        return 0

    @property
    def busy(self) -> bool:
        """Tell whether a request is unanswered."""
        return self._loop.busy

    # -- what a dialect says ------------------------------------------------------------------

    @abstractmethod
    def script(self, request: Request) -> Script[H, Reply]:
        """Return the script that carries out a request."""

    @abstractmethod
    def unasked(self, heard: H) -> None:
        """Weigh what no script was waiting for: tell a `ProtocolWarning` or an `Alert`."""

    def give_up(self) -> None:
        """Have the codec forget what it waits for, and half a message."""

    @abstractmethod
    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate that the device really offers, at or below the one wanted."""

    @abstractmethod
    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long the device may take for so many steps: ramps and doubts included."""

    @abstractmethod
    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound how long motion goes on, if at most `burst_s` of it is sent ahead.

        Of a planned motion, `parts` are what it is made of, in their order. Without them the bound
        holds for whatever may be commanded next, at any speed.
        """

    # -- what the engine calls ----------------------------------------------------------------

    def begin(self, request: Request, now_s: float) -> None:
        """Take up a request; raises `ValueError` where the dialect cannot express it."""
        self._loop.begin(lambda: self.script(request), now_s)

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the device."""
        self._loop.receive(data, now_s)

    def advance(self, now_s: float) -> bytes:
        """Do what is due by now, and return the bytes to be written."""
        return self._loop.advance(now_s)

    def next_s(self) -> float:
        """Tell when the script wants to go on even if nothing is heard."""
        return self._loop.next_s()

    def next_event(self) -> Event | None:
        """Return the next thing that the engine should know."""
        event: Event | None = self._loop.next_event()
        return event

    def stop(self, *, hard: bool) -> None:
        """End the motion under way as soon as the device can; `hard` at the price of position."""
        self._loop.stop(hard=hard)

    def forget(self) -> None:
        """Give up on the unanswered request and on half a message that was received."""
        self._loop.forget()
        self.io.out.clear()
        self.give_up()

    # -- what most dialects share -------------------------------------------------------------

    def strays_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:  # noqa: ARG002
        """Bound how many steps each motor strays from the straight way in such a motion.

        A device that coordinates its motors keeps to it.
        """
        return (0.0,) * len(steps)

    def farewell(self) -> bytes:
        """Return what the device should hear before its wire is given back: nothing, mostly."""
        return b""

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Undo the registers' wrap-around, for a position near the given one."""
        span = 1 << self.abilities.register_bits
        half = span // 2
        return Motors(
            there + (count - there + half) % span - half
            for count, there in zip(registers, near, strict=True)
        )


Controller: TypeAlias = ScriptRunner[Any]
"""The driver's end of whatever dialect: what the engine stands on."""
