"""What the laws excuse because no driver can know or prevent it. Each excuse is bounded in time.

An excuse sees only the motors or joints that it is about; every other motion is judged as usual.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field

from armdrive.config.arm import ArmConfig
from armdrive.dialects.cia402.leading import LOST_CYCLES
from armdrive.dialects.cia402.settings import Cia402Settings
from kinematics import Motors

NOISE_S = 0.03
"""The longest time between an event and the next look at the arm."""

SPRINGS_BACK_S = 0.1
"""A shaft that comes free reaches its set-point within this time."""
HOLDS_WITHIN_S = 0.7
"""A drive whose shaft is blocked in a motion holds at the shaft's place within this time: the
driver notices the block within 0.6 s (docs/controllers/mks.md, docs/controllers/can.md), and the
order takes 0.1 s."""


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
    _blocked_s: dict[int, float] = field(default_factory=dict)
    """When each motor was last blocked while its drive did not hold yet."""
    _until_s: dict[int, float] = field(default_factory=dict)
    """By when the drive of a motor that was blocked in a motion holds."""

    def note_blocked(
        self, motors: Collection[int], time_s: float, *, in_motion: bool = False
    ) -> None:
        """Note motors that are driven and do not turn; `in_motion`: a command may move them."""
        for motor in motors:
            if in_motion and time_s > self._blocked_s.get(motor, -math.inf) + SPRINGS_BACK_S:
                self._until_s[motor] = time_s + HOLDS_WITHIN_S
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
    the next target that it gets within one period, however far that is. If it loses the program's
    heartbeat just then, it brakes from that speed by its ramp.
    """

    missed_s: float = 0.0
    """How much of its path one drive may miss; 0 for drives that do not need every target."""
    deviation_rad: Mapping[str, float] = field(default_factory=dict)
    """How far each shared joint may leave its path at full speed."""
    brakes_s: float = 0.0
    """How long a drive may take to stop from the speed at which it catches up."""
    _until_s: float = -math.inf

    @classmethod
    def of(cls, config: ArmConfig) -> LostTargets:
        """Return the excuse for an arm, which has not begun yet."""
        settings = config.device
        if not isinstance(settings, Cia402Settings):
            return cls()
        missed_s = LOST_CYCLES * settings.period_ms / 1000.0
        brakes_s = LOST_CYCLES * settings.quick_stop_s
        return cls(missed_s, _deviation_rad(config, missed_s), brakes_s)

    def begin(self, now_s: float, for_s: float) -> None:
        """Begin the excuse: from now on the bus may lose targets for `for_s`."""
        if self.missed_s:
            self._until_s = max(self._until_s, now_s + for_s + self.missed_s)

    def may_catch_up(self, time_s: float) -> bool:
        """Return whether a drive may turn faster than its limit, or brake from such a speed."""
        return time_s <= self._until_s + self.brakes_s

    def allowed_rad(self, joint: str, time_s: float) -> float:
        """Return how far a joint may be off its path at a time, at full speed."""
        return self.deviation_rad.get(joint, 0.0) if time_s <= self._until_s else 0.0


def _deviation_rad(config: ArmConfig, missed_s: float) -> dict[str, float]:
    """Return the largest angle that one motor alone turns each shared joint by in `missed_s`."""
    transmission, speeds = config.model.transmission, config.model.joint_speeds_rad_s
    fastest_hz = [
        math.fsum(abs(share) * speed for share, speed in zip(row, speeds, strict=False))
        for row in transmission.matrix
    ]
    return {
        name: missed_s * max(abs(share) * hz for share, hz in zip(row, fastest_hz, strict=True))
        for name, row in zip(transmission.joint_names, transmission.inverse, strict=False)
        if sum(map(bool, row)) > 1
    }


@dataclass(slots=True)
class MissedOrders:
    """Excuses joints that leave their path, and their limits, while a drive does not get orders.

    The other drives go on until the driver notices, and a joint that the drive was to turn the
    other way is faster than planned. Only joints that the drive turns are excused, and only until
    all drives can stand. `missed_orders` tells when that happens. Times in s.
    """

    joints: frozenset[str]
    """The joints that the drive turns."""
    fault_ends_s: float
    noticed_s: float
    """The time from the arm's first motion without the drive to when all drives stand."""
    _until_s: float = math.inf

    def begin(self) -> None:
        """Start again for a new command, whose driver has to notice the fault by itself."""
        self._until_s = math.inf

    def excuses(self, time_s: float) -> bool:
        """Return whether the driver cannot know yet that the joints leave their path."""
        if math.isinf(self._until_s) and time_s <= self.fault_ends_s:
            self._until_s = time_s + self.noticed_s
        return math.isfinite(self._until_s) and time_s <= self._until_s

    def excuses_speed(self, time_s: float, window_s: float) -> bool:
        """Return whether a mean speed over the last `window_s` is of joints that it excuses."""
        return self.excuses(time_s) or time_s <= self._until_s + window_s < math.inf

    def allow_excess(self, allowed: dict[str, float], beyond: Mapping[str, float]) -> None:
        """Allow the joints to stay as far beyond their limits as they are now, and no further."""
        for joint in self.joints & beyond.keys():
            allowed[joint] = max(allowed.get(joint, 0.0), beyond[joint])
