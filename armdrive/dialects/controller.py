"""The face of every controller, and how long it lets a motion go on: what the engine stands on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from armdrive.abilities import Abilities
from armdrive.tasks import Event, Request
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


class Controller(Protocol):
    """The driver's end of one dialect. Sans-IO: the engine carries its bytes and has the clock."""

    @property
    def abilities(self) -> Abilities:
        """What the device can do."""

    @property
    def last_said(self) -> str:
        """The text of the message sent last, for people."""

    @property
    def look_at(self) -> str:
        """What a person does about a device that does not answer."""

    @property
    def busy(self) -> bool:
        """Tell whether a request is unanswered."""

    @property
    def underruns(self) -> int:
        """How often a device that queues ran out of motion while more of it was to come."""

    def begin(self, request: Request, now_s: float) -> None:
        """Take up a request; raises `ValueError` where the dialect cannot express it."""

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the device."""

    def advance(self, now_s: float) -> bytes:
        """Do what is due by now, and return the bytes to be written."""

    def next_s(self) -> float:
        """Tell when to be called again even if nothing is heard; infinity if never."""

    def next_event(self) -> Event | None:
        """Return the next thing heard, or None when more bytes are needed."""

    def stop(self, *, hard: bool) -> None:
        """End the motion under way as soon as the device can; `hard` at the price of position."""

    def forget(self) -> None:
        """Give up on the unanswered request and on half a message that was received."""

    def farewell(self) -> bytes:
        """Return what the device should hear before its wire is given back in good order."""

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate that the device really offers, at or below the one wanted."""

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long the device may take for so many steps: ramps and doubts included."""

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound how long motion goes on, if at most `burst_s` of it is sent ahead.

        Of a planned motion, `parts` are what it is made of, in their order. Without them the bound
        holds for whatever may be commanded next, at any speed.
        """

    def strays_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:
        """Bound how many steps each motor strays from the straight way in such a motion."""

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Undo the registers' wrap-around, for a position near the given one."""
