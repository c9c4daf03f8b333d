"""The interface of every controller, and the bounds of its stops: what the engine relies on."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias

from armdrive.abilities import Abilities
from armdrive.dialects.exchange import Codec, H, Script, ScriptIO, ScriptLoop
from armdrive.dialects.words import plain
from armdrive.errors import Refused
from armdrive.tasks import (
    ClearFault,
    DeviceSettings,
    Done,
    Event,
    FixSetting,
    HomeDevice,
    ProtocolWarning,
    ReadSettings,
    Reply,
    Request,
    SwitchOn,
)
from kinematics.spaces import Motors

# Delay that this computer, an adapter, a network or other traffic may add to a message.
HOST_DELAY_S = 0.03

# A driver starts a motion only from a position that it read no longer ago than this. The driver's
# caller looks again sooner (`FRESH_S` in `motion.context`).
FRESH_POSITION_S = 0.3

# Why a motion is refused while the motors have no current.
MOTORS_OFF = "its motors are disabled: call `enable()`"

# A motor that homes turns by at most this share of its range. One that turns farther finds no
# switch.
OVERTRAVEL = 1.1

# A device that homes is awaited for this much longer than its homing lasts: ramps that it does not
# report, and lost or late reports. A search that passes its switch is ended sooner, by the device
# or by its motor's travel, so the margin only delays the error of a search that stands.
HOMING_MARGIN_S = 5.0


@dataclass(frozen=True, order=True, slots=True)
class HomingTime:
    """How long a homing lasts at most: computed from what the device reports, or else assumed.

    `assumed` is the key of the arm file that gave the time; empty if it was computed.
    """

    s: float
    assumed: str = ""

    @property
    def waited_s(self) -> float:
        """How long the device is awaited."""
        return self.s + HOMING_MARGIN_S

    @property
    def remedy(self) -> str:
        """How to allow more time, for the end of an error message; empty if no key does."""
        if not self.assumed:
            return ""
        return (
            "; the device does not report how fast it homes: if its motors need longer, raise "
            f"{self.assumed} in the arm file"
        )


def in_turn(times: Iterable[HomingTime]) -> HomingTime:
    """Return how long several homings last, one after the other."""
    each = list(times)
    assumed = (time.assumed for time in each if time.assumed)
    return HomingTime(math.fsum(time.s for time in each), next(assumed, ""))


NO_HOMING = HomingTime(0.0)


@dataclass(frozen=True, slots=True)
class Search:
    """A device's own homing: how long it goes on if the host falls silent, and how long it lasts.

    `time_s` is the time after the host has fallen silent, and `most_steps` how far any of the
    motors turns meanwhile; infinite if its speed is not known.
    """

    time_s: float
    most_steps: float = math.inf
    lasts: HomingTime = NO_HOMING


@dataclass(frozen=True, slots=True)
class StopPart:
    """A part of a planned motion at one speed: its duration and its busiest motor's rate."""

    duration_s: float
    rate_hz: float


@dataclass(frozen=True, slots=True)
class Stopping:
    """How long a motion continues after a stop request, and after the host has fallen silent.

    `asked_s` and `silent_s` are the times until the last step. `asked_motion_s` and
    `silent_motion_s` are how long the motion takes, at its own speed, for the distance covered
    meanwhile: less than those times, since it brakes. `asked_extra_steps` and `silent_extra_steps`
    are what each motor may turn on top: a drive that lags catches up, and a stop may end beyond the
    target.
    """

    asked_s: float
    asked_motion_s: float
    silent_s: float
    silent_motion_s: float
    asked_extra_steps: float = 0.0
    silent_extra_steps: float = 0.0


class ScriptRunner(ABC, Generic[H]):
    """A dialect's controller. Sans-IO: the engine carries its bytes and has the clock.

    It answers requests with scripts. A dialect adds `script` and its numbers.
    """

    def __init__(
        self, abilities: Abilities, codec: Codec[H], io: ScriptIO[H] | None = None
    ) -> None:
        self.abilities = abilities
        self.io = io or ScriptIO(self.unsolicited)
        self._loop = ScriptLoop(codec, self.io)

    @property
    def last_said(self) -> str:
        """The last command sent, as text for people."""
        return self.io.last_command

    @property
    def look_at(self) -> str:
        """What to check if the device does not answer."""
        return self.io.look_at

    @property
    def underruns(self) -> int:
        """How often a device that queues stood still although more of its motion was to come."""
        return 0

    @property
    def busy(self) -> bool:
        """Whether a request is unanswered."""
        return self._loop.busy

    # -- what a dialect supplies --------------------------------------------------------------

    @abstractmethod
    def script(self, request: Request) -> Script[H, Reply]:
        """Return the script that carries out a request."""

    def unsolicited(self, message: H) -> None:
        """Take a message that no script waits for: warn of it, or send an `Alert`."""
        self.io.notify(ProtocolWarning(plain(message)))

    def give_up(self) -> None:
        """Stop waiting for answers, and drop half-received messages: a part of `abandon`."""

    @abstractmethod
    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate that the device offers, at or below the one wanted."""

    @abstractmethod
    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long the device may take for these steps, with ramps and uncertainty."""

    @abstractmethod
    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Bound how long motion continues, if at most `burst_s` of it is sent ahead.

        `parts` are those of a planned motion, in order. Without them the bound holds for any
        command, at any speed.
        """

    # -- what the engine calls ----------------------------------------------------------------

    def begin(self, request: Request, now_s: float) -> None:
        """Begin a request. Raises `ValueError` if the dialect cannot express it."""
        self._loop.begin(lambda: self.script(request), now_s)

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the device."""
        self._loop.receive(data, now_s)

    def advance(self, now_s: float) -> bytes:
        """Do what is due, and return the bytes to write."""
        return self._loop.advance(now_s)

    def next_s(self) -> float:
        """Return when to continue if no message comes first."""
        return self._loop.next_s()

    def next_event(self) -> Event | None:
        """Return the next event for the engine, or None."""
        event: Event | None = self._loop.next_event()
        return event

    def stop(self, *, hard: bool) -> None:
        """End the present motion as soon as possible; `hard` may cost the position."""
        self._loop.stop(hard=hard)

    def abandon(self) -> None:
        """End the request that is being carried out without a reply."""
        self._loop.abandon()
        self.io.out.clear()
        self.give_up()

    # -- what most dialects share -------------------------------------------------------------

    def whole_burst(self, burst_s: float, parts: Sequence[StopPart], sent_s: float) -> Stopping:
        """Bound a stop if no message ends a burst early, or if that message may be lost.

        A burst begins `sent_s` after it was sent, and may also be a single step at any speed.
        """
        slowest_hz = min((part.rate_hz for part in parts), default=0.0)
        motion_s = max(burst_s, self.duration_s(1.0, slowest_hz))
        stands_s = sent_s + motion_s
        return Stopping(stands_s, motion_s, stands_s, motion_s)

    def search(self, request: HomeDevice) -> Search:  # noqa: ARG002
        """Bound the device's own homing, and how long it goes on if the host falls silent.

        The switches have to work. By default a device does not home by itself.
        """
        return Search(0.0, 0.0)

    @property
    def opening_reset(self) -> bool:
        """Whether opening the port may have reset the device, by all that it has said."""
        return self.abilities.resets_on_open

    def deviation_steps(self, steps: Motors, rate_hz: float) -> tuple[float, ...]:  # noqa: ARG002
        """Bound each motor's deviation from the straight path in such a motion.

        A device that coordinates its motors stays on it.
        """
        return (0.0,) * len(steps)

    def shutdown_frames(self) -> bytes:
        """Return the bytes to send before the wire is closed; usually none."""
        return b""

    def unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Undo the wrap-around of registers, for a position near the given one."""
        span = 1 << self.abilities.register_bits
        half = span // 2
        return Motors(
            there + (count - there + half) % span - half
            for count, there in zip(registers, near, strict=True)
        )


def answer_without_device(request: Request) -> Reply:
    """Answer a request for which a dialect has no message.

    Without alarms, a switch for the current and settings there is nothing to do. Raises `Refused`
    for all other requests.
    """
    match request:
        case ClearFault() | SwitchOn():
            return Done()
        case ReadSettings():
            return DeviceSettings()
        case FixSetting():
            raise Refused("this controller has no settings that can be written")
    raise Refused(f"this controller does not support {type(request).__name__}")


# The controller of any dialect, as the engine uses it.
Controller: TypeAlias = ScriptRunner[Any]
