"""One simulated CiA 402 drive: its firmware's quirks, its set-point, and what it knows.

`messages` is what it hears and says, `objects` and `writes` its objects, `states` its states, and
`motion` how it moves.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum

from armdrive.sim.bus.drives import LimitSwitch, ShaftDrive, ShaftPoint
from armdrive.sim.cia402.objects import COMMUNICATION, SERIAL_NUMBER, Pdos
from armdrive.sim.mechanics.profiles import AxisProfile, ProfilePiece, nearest
from firmware_protocol.canopen import (
    PRODUCER_HEARTBEAT_MS,
    AbortCode,
    Dictionary,
    DriveDevice,
    DriveState,
    Happening,
    NmtNode,
    ObjectStore,
    OperationMode,
    Place,
    SdoServer,
)
from firmware_protocol.frames import Frame, pack

# --- What CiA 402 leaves to the maker of a drive, and how far homing has come --------------------


class Homing(Enum):
    """How far a drive has come on its way home."""

    NONE = "not begun, or broken off"
    SEEKING = "on its way to its switch"
    LEAVING = "on its way off its switch"
    DONE = "home"
    FAILED = "failed"

    @property
    def searches(self) -> bool:
        """Whether it is on its way."""
        return self in (Homing.SEEKING, Homing.LEAVING)

    @property
    def given_up(self) -> Homing:
        """What is left of it when it is broken off."""
        return Homing.DONE if self is Homing.DONE else Homing.NONE


@dataclass(frozen=True, slots=True)
class Cia402Quirks:
    """What CiA 402 leaves to the maker; `kind.KIND` says what each means."""

    modes: frozenset[OperationMode]
    extrapolates: bool = False
    limits: bool = False
    keeps_position: bool = False
    answer_s: float = 0.0005
    boot_s: float = 0.5
    reset_s: float = 0.02


# --- The set-point: what the motor can follow of its commands ------------------------------------
#
# Increments are the shaft's own, whatever zero was set. Times are in seconds, speeds in increments
# a second.


class ServoPoint(ShaftPoint):
    """A point that glides from target to target, no faster than its motor can turn."""

    def __init__(self, at: int) -> None:
        super().__init__(at)
        self._demand: ProfilePiece | None = None

    def demand(self, now_s: float) -> int:
        """Return where it was told to be: ahead of where it is, of what it cannot follow."""
        return self.at(now_s) if self._demand is None else nearest(self._demand.at(now_s))

    def glide_to(
        self, target: int, period_s: float, most_rate: float, now_s: float, *, on: bool = False
    ) -> None:
        """Go straight to a target within a period, and stand there; or go `on` beyond it."""
        told, here = self.demand(now_s), self._state(now_s)[0]
        rate = (target - told) / period_s
        self._demand = ProfilePiece(now_s, told, rate, 0.0, period_s)
        way = target - here
        able = math.copysign(min(abs(way) / period_s, most_rate), way)
        pieces = [ProfilePiece(now_s, here, able, 0.0, abs(way / able) if able else 0.0)]
        if on and able:
            self._demand = ProfilePiece(now_s, told, rate, 0.0, math.inf)
            pieces.append(ProfilePiece(pieces[0].end_s, target, able, 0.0, math.inf))
        self._profile = AxisProfile(pieces, target)
        self._end_s = max(self._profile.end_s, now_s)

    def hold(self, at: int) -> None:
        """Stand dead at an increment."""
        super().hold(at)
        self._demand = None

    def _begin(self, profile: AxisProfile, now_s: float) -> None:
        super()._begin(profile, now_s)
        self._demand = None


_ROUNDING = 1e-6


class Cia402Node:
    """A drive on the motor of its index. Its owner calls `messages.live` once time has passed."""

    def __init__(
        self,
        index: int,
        number: int,
        dictionary: Dictionary,
        drive: ShaftDrive[ServoPoint],
        switch: LimitSwitch,
        quirks: Cia402Quirks,
    ) -> None:
        self.index = index
        self.number = number
        """Its node id."""
        self.dictionary = dictionary
        self.drive = drive
        self.switch = switch
        self.quirks = quirks
        self.powered = self.plugged = True
        self.mute = False
        self.withheld = False
        """Whether it does not say that a target is reached."""
        self.ailing: set[int] = set()
        """Error codes of what is wrong with it until somebody mends it."""
        self.zero = drive.shafts[index]
        self.said: list[bytes] = []
        """What its owner has to bring to the bus."""
        self.store = self._fresh(number)
        self._forget()

    def _fresh(self, number: int) -> ObjectStore:
        store = ObjectStore(self.dictionary, number)
        if self.dictionary.find(SERIAL_NUMBER):
            store.set(SERIAL_NUMBER, self.index + 1)
        self._numbers: dict[Place, int] = {}
        self._unstored: set[Place] = set()
        return store

    def _forget(self) -> None:
        """Know nothing of what was before the firmware began."""
        self.machine = DriveDevice()
        self.machine.happen(Happening.INITIALISED)
        self.mode: int = OperationMode.NONE
        self.boots_s = -math.inf
        self.homing = Homing.NONE
        self.goal = 0
        """Where the last set-point leads, as it counts."""
        self.ends = False
        """Whether something waits for the end of a motion."""
        self.switch_s = math.inf
        """When the set-point comes to where the switch changes, as far as that is minded."""
        self.waits = False
        """Whether the set-point has come to its end, and the shaft has not."""
        self.astray_s = math.inf
        """Since when the shaft has been farther from its set-point than the window."""
        self.astray = False
        """Whether that has been a fault."""
        self.limited = False
        """Whether a target was cut off at a software limit."""
        self.watch_stops = 0
        """How often the silence of its master has made it react."""
        self._forget_talk()

    def _forget_talk(self) -> None:
        self.nmt, self.sdo = NmtNode(self.number), SdoServer(self.number)
        self.pdos = Pdos(self.store, self.dictionary)
        self.beat_s = math.inf
        """When its next heartbeat is due: all drives beat together."""
        self.silent_s = math.inf
        """When its master's silence is too long; infinity until that has been heard once."""
        self.forsaken = False
        """Whether its master has been silent for too long."""

    # What it is.

    @property
    def answer_s(self) -> float:
        """How long it takes to have a frame ready."""
        return self.quirks.answer_s

    @property
    def point(self) -> ServoPoint:
        """Its set-point."""
        return self.drive.rack.each[self.index]

    @property
    def shaft(self) -> int:
        """Where its shaft is."""
        return self.drive.shafts[self.index]

    @property
    def counts(self) -> int:
        """Where it says that its shaft is."""
        return self.shaft - self.zero

    @property
    def holding(self) -> bool:
        """Whether its motor has current."""
        return self.drive.holding[self.index]

    @property
    def booting(self) -> bool:
        """Whether its communication has not begun yet."""
        return self.boots_s > -math.inf

    @property
    def state(self) -> DriveState:
        """What its state machine says."""
        return self.machine.state

    @property
    def enabled(self) -> bool:
        """Whether it does what it is told."""
        return self.machine.state is DriveState.ENABLED

    # Its objects. What they hold is asked for far too often to be unpacked every time.

    def number_of(self, place: Place, default: int) -> int:
        """Return what an object holds; the default where there is none, or nothing in it."""
        known = self._numbers.get(place)
        if known is not None:
            return known
        value = self.store.value(place) if self.dictionary.find(place) else None
        self._numbers[place] = default if value is None else int(value)
        return self._numbers[place]

    def keep(self, place: Place, value: int) -> None:
        """Have an object hold a number, if there is such an object."""
        if self.dictionary.find(place):
            self._numbers[place] = value
            self._unstored.add(place)

    def stored(self) -> ObjectStore:
        """Return the objects, all of them as they are."""
        for place in self._unstored:
            self.store.set(place, self._numbers[place])
        self._unstored.clear()
        return self.store

    def write(self, place: Place, data: bytes, *, exact: bool) -> AbortCode | None:
        """Have a master write an object; returns why not, or None."""
        refused = self.stored().write(place, data, exact=exact)
        self._numbers.pop(place, None)
        return refused

    # What it says.

    def beat_on(self, now_s: float) -> None:
        """Have its next heartbeat be due, all drives of a period with one: few wakes for all."""
        period_s = self.number_of(PRODUCER_HEARTBEAT_MS, 0) / 1000
        beats = math.floor(now_s / period_s + _ROUNDING) + 1 if period_s else 0
        self.beat_s = beats * period_s if period_s else math.inf

    def say(self, frames: Iterable[Frame | None]) -> None:
        """Have frames brought to the bus."""
        if self.powered and self.plugged and not self.mute:
            self.said += [pack(frame) for frame in frames if frame is not None]

    # Power.

    def fall_silent(self, now_s: float) -> None:
        """Lose power or be reset: the shaft is free, and all that was under way is forgotten."""
        self.drive.release((self.index,), now_s)
        self.renew()

    def renew(self) -> None:
        """Know nothing but what it is."""
        self.said.clear()
        self.store = self._fresh(self.number)
        self._forget()

    def begin(self, now_s: float) -> None:
        """Begin, the power having come: it takes a while until it says so."""
        self.renew()
        self.boots_s = now_s + self.quirks.boot_s
        if not self.quirks.keeps_position:
            self.zero = self.shaft

    def restart(self, now_s: float) -> None:
        """Begin anew, as after a loss of power."""
        self.fall_silent(now_s)
        self.begin(now_s)

    def renew_talk(self, number: int, now_s: float) -> None:
        """Have the communication begin anew, perhaps with another node id; the motor goes on."""
        before = self.stored()
        self.number, self.store = number, self._fresh(number)
        for entry in self.dictionary:
            value = before.value(entry.place)
            if value is not None and entry.place.index not in COMMUNICATION:
                self.store.set(entry.place, value)
        self._forget_talk()
        self.boots_s = now_s + self.quirks.reset_s
