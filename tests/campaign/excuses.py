"""What the laws excuse because no driver can know or prevent it. Each excuse is bounded in time.

An excuse sees only the motors or joints that it is about; every other motion is judged as usual.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field

from armdrive.config.arm import ArmConfig
from armdrive.dialects.cia402.leading import LOST_CYCLES
from armdrive.dialects.cia402.settings import Cia402Settings
from kinematics import Motors, Transmission

NOISE_S = 0.03
"""The longest time between an event and the next look at the arm."""

SPRINGS_BACK_S = 0.1
"""A shaft that comes free reaches its set-point within this time."""
HOLDS_WITHIN_S = 0.7
"""A drive whose shaft is blocked in a motion holds at the shaft's place within this time: the
driver notices the block within 0.6 s, and the order takes 0.1 s. In a slow CiA 402 motion it
notices later (docs/controllers/can.md), but meanwhile the command allows the motion."""


@dataclass(slots=True)
class SpringBack:
    """Excuses a blocked shaft that comes free and turns to its drive's set-point.

    The set-point of a drive whose shaft is blocked in a motion runs ahead of the shaft. The driver
    notices that and orders the drive to hold where the shaft is. It cannot do so while it does not
    receive the drive's position: an order to hold at the last known place would turn the shaft
    back. Motors count from 0.
    """

    can_hold: Callable[[int, float], bool] = lambda _motor, _time_s: True
    """Whether the driver can order a motor's drive to hold, at a time in s."""
    _noted_s: dict[int, float] = field(default_factory=dict)
    """When each motor was last blocked."""
    _blocked_s: dict[int, float] = field(default_factory=dict)
    """When each motor was last blocked while its drive did not hold yet."""
    _until_s: dict[int, float] = field(default_factory=dict)
    """By when the drive of a motor that was blocked in a motion holds."""

    def note_blocked(
        self, motors: Collection[int], time_s: float, *, in_motion: bool = False
    ) -> None:
        """Note motors that are driven and do not turn; `in_motion`: a command may move them.

        The driver's time begins with the block, and does not begin again while the block lasts.
        """
        for motor in motors:
            if in_motion and time_s > self._noted_s.get(motor, -math.inf) + SPRINGS_BACK_S:
                self._until_s[motor] = time_s + HOLDS_WITHIN_S
            self._noted_s[motor] = time_s
            if not self.can_hold(motor, time_s) or time_s <= self._until_s.get(motor, -math.inf):
                self._blocked_s[motor] = time_s

    def excuses(self, motors: Collection[int], time_s: float) -> bool:
        """Return whether all motors that turn were blocked a moment ago."""
        return all(
            time_s <= self._blocked_s.get(motor, -math.inf) + SPRINGS_BACK_S for motor in motors
        )


STALE_PERIODS = 4.0
"""The last reading is up to one period old when the order to hold goes out, and the drive needs one
period to get there. The next reading may be of the place that the hand chose, and the order after
it may bring the shaft back there: two more periods."""


@dataclass(frozen=True, slots=True)
class TurnedByHand:
    """Excuses a CiA 402 drive that turns its shaft back after a hand has turned it.

    A drive is ordered to hold where it was read last, at the previous SYNC. If a hand turns the
    shaft after this reading, the drive turns it back. The next reading may be of the new place, and
    the shaft returns there. So the shaft may move between the two places, for a few periods.
    """

    before: Motors
    """Where the motors stood before the hand turned some of them."""
    after: Motors
    """Where they stood afterwards."""
    until_s: float

    @classmethod
    def of(
        cls, config: ArmConfig, before: Motors, after: Motors, now_s: float
    ) -> TurnedByHand | None:
        """Return the excuse for a turn that ends now; None for drives that follow no target.

        Steppers stay wherever a hand turns them.
        """
        settings = config.device
        if not isinstance(settings, Cia402Settings):
            return None
        until_s = now_s + STALE_PERIODS * settings.period_ms / 1000.0 + NOISE_S
        return cls(before, after, until_s)

    def excuses(self, motors: Collection[int], there: Motors, time_s: float) -> bool:
        """Return whether only turned motors move, and only between the two places."""
        return time_s <= self.until_s and all(
            a != b and min(a, b) <= there[motor] <= max(a, b)
            for motor, (a, b) in enumerate(zip(self.before, self.after, strict=True))
            if motor in motors
        )


@dataclass(slots=True)
class LostTargets:
    """Excuses a shared joint off its path, and the speed of a drive that catches up.

    A CiA 402 drive gets a target with every SYNC. If the bus loses targets, the drive stands at the
    last one while the others go on, until the driver notices: after three readings that do not
    change, or after `LOST_CYCLES` periods without a reply (docs/controllers/can.md). By then a
    joint that several motors turn is off its path, and may be beyond its limit. The drive turns to
    the next target that it gets within one period, however far that is. If it is stopped just then,
    or loses the program's heartbeat, it brakes from that speed by its ramp.

    So a drive is never more than `missed_s` behind the targets, and in any time span it turns no
    farther than in a span that is longer by that. Only a drive that brakes may turn farther.
    """

    missed_s: float = 0.0
    """How much of its path one drive may miss; 0 for drives that do not need every target."""
    deviation_rad: Mapping[str, float] = field(default_factory=dict)
    """How far each shared joint may leave its path at full speed."""
    quick_stop_s: float = 0.0
    """How long a drive takes to stop from full speed."""
    brakes: Callable[[], bool] = lambda: False
    """Whether a drive is in its quick stop now."""
    _until_s: float = -math.inf
    _braked_s: float = -math.inf
    """When a drive was last seen in its quick stop."""

    @classmethod
    def of(cls, config: ArmConfig) -> LostTargets:
        """Return the excuse for an arm, which has not begun yet."""
        settings = config.device
        if not isinstance(settings, Cia402Settings):
            return cls()
        missed_s = LOST_CYCLES * settings.period_ms / 1000.0
        rates = one_motor_rates_rad_s(config)
        shared = {name: missed_s * rates[name] for name in shared_joints(config)}
        return cls(missed_s, shared, settings.quick_stop_s)

    def begin(self, now_s: float, for_s: float) -> None:
        """Begin the excuse: from now on the bus may lose targets for `for_s`."""
        if self.missed_s:
            self._until_s = max(self._until_s, now_s + for_s + self.missed_s)

    def ahead_s(self, time_s: float, window_s: float) -> float:
        """Return how much longer than `window_s`, which ends now, joints may seem to have turned.

        Drives that catch up add `missed_s`. A drive that brakes from several times its speed covers
        the square of that, times what it covers as it stops from full speed; but it is never faster
        than that speed.
        """
        brakes_s = LOST_CYCLES * self.quick_stop_s
        if time_s <= self._until_s + brakes_s and self.brakes():
            self._braked_s = time_s
        if time_s <= self._braked_s + window_s:
            return min(LOST_CYCLES**2 * self.quick_stop_s / 2.0, (LOST_CYCLES - 1) * window_s)
        return self.missed_s if time_s <= self._until_s + window_s else 0.0

    def allowed_rad(self, joint: str, time_s: float) -> float:
        """Return how far a joint may be off its path at a time, at full speed."""
        return self.deviation_rad.get(joint, 0.0) if time_s <= self._until_s else 0.0


def shared_joints(config: ArmConfig) -> frozenset[str]:
    """Return the joints that several motors turn."""
    transmission = config.model.transmission
    rows = zip(transmission.joint_names, transmission.inverse, strict=False)
    return frozenset(name for name, row in rows if sum(map(bool, row)) > 1)


def fastest_hz(transmission: Transmission, speeds_rad_s: Sequence[float]) -> list[float]:
    """Return the greatest speed of each motor, with every joint at its greatest speed."""
    return [
        math.fsum(abs(share) * speed for share, speed in zip(row, speeds_rad_s, strict=False))
        for row in transmission.matrix
    ]


def one_motor_rates_rad_s(config: ArmConfig) -> dict[str, float]:
    """Return how fast one motor alone turns each joint at most, at the joints' greatest speeds."""
    transmission = config.model.transmission
    motors_hz = fastest_hz(transmission, config.model.joint_speeds_rad_s)
    return {
        name: max(abs(share) * hz for share, hz in zip(row, motors_hz, strict=True))
        for name, row in zip(transmission.joint_names, transmission.inverse, strict=False)
    }


@dataclass(slots=True)
class MissedOrders:
    """Excuses joints that leave their path, and their limits, while a drive does not get orders.

    The other drives go on until the driver notices, and a joint that the drive was to turn the
    other way is faster than planned. Only joints that the drive turns are excused, only until all
    drives can stand, and only as far and as fast as one motor alone turns them. `missed_orders`
    tells when that happens. Times in s.
    """

    rates_rad_s: Mapping[str, float]
    """The joints that the drive turns, and how fast one motor alone turns each at most."""
    fault_ends_s: float
    noticed_s: float
    """The time from the arm's first motion without the drive to when all drives stand."""
    stands_by_s: float = math.inf
    """By when all drives stand, however late that first motion is."""
    apart_s: float = math.inf
    """For how long a drive misses orders at most, before no drive gets any more."""
    _since_s: float = math.inf
    _until_s: float = math.inf
    _most_rad: dict[str, float] = field(default_factory=dict)
    """How far each joint may be beyond its limit; empty before any is."""

    def begin(self) -> None:
        """Start again for a new command, whose driver has to notice the fault by itself."""
        self._since_s = self._until_s = math.inf
        self._most_rad.clear()

    @property
    def joints(self) -> frozenset[str]:
        """The joints that the drive turns."""
        return frozenset(self.rates_rad_s)

    def excuses(self, time_s: float) -> bool:
        """Return whether the driver cannot know yet that the joints leave their path."""
        if math.isinf(self._until_s) and time_s <= self.fault_ends_s:
            self._since_s = time_s
            self._until_s = min(time_s + self.noticed_s, self.stands_by_s)
        return math.isfinite(self._until_s) and time_s <= self._until_s

    def missed_s(self, time_s: float) -> float:
        """Return for how long a drive has missed its orders in this command."""
        return max(min(time_s, self.fault_ends_s) - self._since_s, 0.0)

    def faster_rad_s(self, time_s: float, window_s: float) -> Mapping[str, float]:
        """Return how fast joints may have turned during the last `window_s`, at full speed."""
        lasts = self.excuses(time_s) or time_s <= self._until_s + window_s < math.inf
        return self.rates_rad_s if lasts else {}

    def allow_excess(
        self, allowed: dict[str, float], beyond: Mapping[str, float], speed: float
    ) -> None:
        """Allow the joints to stay as far beyond their limits as they are now, and no further.

        That is no more than one motor turns them at this share of full speed until all stand, or
        until none gets any more orders.
        """
        lasts_s = min(self._until_s - self._since_s, self.apart_s)
        for joint in self.joints & beyond.keys():
            before, further = allowed.get(joint, 0.0), speed * self.rates_rad_s[joint] * lasts_s
            most = self._most_rad.setdefault(joint, before + further)
            allowed[joint] = max(before, min(beyond[joint], most))
