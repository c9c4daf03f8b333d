"""Shafts in a closed loop: the set-point of each, and the arm that follows them.

A drive gives its orders to its `ShaftPoint`, which knows the set-point at any time.
`ShaftDrive.look` turns the arm's motors towards all set-points, as far as position loops could
since the last look. The world may hold a motor back, by a mechanical stop or a fault; `errors` is
what its drive sees of that.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from armdrive.sim.mechanics.motors import MotorDrive
from armdrive.sim.mechanics.profiles import (
    AxisProfile,
    ProfilePiece,
    nearest,
    standing,
    to_goal,
    to_speed,
)
from armdrive.sim.world import World
from armdrive.sim.world.body import sagged
from kinematics.spaces import Motors

# --- The set-point of one shaft ------------------------------------------------------------------
# The set-point of a closed-loop shaft at any time, without ticking. Counts are the shaft's own,
# whatever zero was set. Times are in seconds, speeds in counts per second.

_HALVINGS = 60  # down to the resolution of a float


class ShaftPoint:
    """The set-point stands, or follows a profile that starts from its previous state."""

    def __init__(self, at: int) -> None:
        self.end_s = -math.inf
        """When the set-point comes to a stand; infinity if it runs without an end."""
        self.end = at
        """Where the set-point comes to a stand; meaningless if it runs without an end."""
        self._profile = standing(at)

    def moving(self, now_s: float) -> bool:
        """Return whether the set-point is moving."""
        return now_s < self.end_s

    def at(self, now_s: float) -> int:
        """Return the position in whole counts."""
        if now_s >= self._profile.end_s:  # most shafts stand most of the time
            return self.end
        return nearest(self._profile.at(now_s))

    def rate(self, now_s: float) -> float:
        """Return the speed, in counts per second."""
        return self._profile.speed_at(now_s)

    def gain(self, now_s: float) -> float:
        """Return the acceleration, in counts per second squared; negative while braking."""
        piece = self._profile.piece(now_s)
        if piece is None:
            return 0.0
        brakes = piece.acceleration * piece.speed_at(now_s) < 0.0
        return -abs(piece.acceleration) if brakes else abs(piece.acceleration)

    def hold(self, at: int) -> None:
        """Stand at a count."""
        self._profile, self.end, self.end_s = standing(at), at, -math.inf

    def go_to(
        self, goal: int, rate: float, slope: float, now_s: float, *, braking: float | None = None
    ) -> None:
        """Go to a count from the current motion; an infinite slope means no ramp.

        `braking` is the deceleration, if it differs from the acceleration.
        """
        position, speed = self._state(now_s)
        brakes = slope if braking is None else braking
        if math.isinf(slope):
            self._begin(dead(position, goal, rate, now_s), now_s)
        else:
            self._begin(to_goal(position, speed, goal, rate, slope, now_s, brakes), now_s)

    def go_at(self, rate: float, slope: float, now_s: float) -> None:
        """Run until the next command; a rate of 0 ends the motion."""
        position, speed = self._state(now_s)
        self._begin(at_rate(position, speed, rate, slope, now_s), now_s)

    def there_and_back(self, counts: int, rate: float, now_s: float) -> None:
        """Turn by `counts` and back again, without a ramp."""
        here = float(self.at(now_s))
        there = dead(here, here + counts, rate, now_s)
        back = dead(here + counts, here, rate, there.end_s)
        self._begin(AxisProfile((*there.pieces, *back.pieces), here), now_s)

    def glide_to(self, target: int, period_s: float, now_s: float, *, on: bool = False) -> None:
        """Go straight to a target in a period; with `on`, continue beyond it."""
        here = self._state(now_s)[0]
        rate = (target - here) / period_s
        lasts_s = math.inf if on and rate else period_s
        self._begin(AxisProfile([ProfilePiece(now_s, here, rate, 0.0, lasts_s)], target), now_s)

    def passes_s(self, count: int, way: int, now_s: float) -> float:
        """Return when the set-point reaches or passes a count in a direction; infinity for never.

        For motions that pass the count: a search, or a motion towards a switch.
        """
        if (self.at(now_s) - count) * way >= 0:
            return now_s
        late_s = self.end_s
        if math.isinf(late_s):
            speed = abs(self._profile.pieces[-1].speed) if self._profile.pieces else 0.0
            if not speed:
                return math.inf
            late_s = self._profile.pieces[-1].start_s
            late_s += (abs(self.at(late_s) - count) + 1) / speed
        if late_s <= now_s or (self.at(late_s) - count) * way < 0:
            return math.inf
        return self._between(count, way, now_s, late_s)

    def _between(self, count: int, way: int, early_s: float, late_s: float) -> float:
        for _ in range(_HALVINGS):
            half_s = (early_s + late_s) / 2
            if (self.at(half_s) - count) * way >= 0:
                late_s = half_s
            else:
                early_s = half_s
        return late_s

    def _state(self, now_s: float) -> tuple[float, float]:
        """Return position and speed; a standing shaft is at a whole count."""
        if not self.moving(now_s):
            return float(self.end), 0.0
        return self._profile.at(now_s), self._profile.speed_at(now_s)

    def _begin(self, profile: AxisProfile, now_s: float) -> None:
        self._profile, self.end = profile, nearest(profile.end)
        self.end_s = max(profile.end_s, now_s)


def dead(position: float, goal: float, rate: float, now_s: float) -> AxisProfile:
    """Go to a goal at full speed without a ramp, and stop there dead."""
    way = goal - position
    piece = ProfilePiece(now_s, position, math.copysign(rate, way), 0.0, abs(way) / rate)
    return AxisProfile((piece,), goal)


def at_rate(
    position: float, speed: float, wanted: float, slope: float, now_s: float
) -> AxisProfile:
    """Run at a speed for ever, or stand; an infinite slope means no ramp."""
    if not math.isinf(slope):
        return to_speed(position, speed, wanted, slope, now_s)
    if not wanted:
        return standing(position)
    return AxisProfile((ProfilePiece(now_s, position, wanted, 0.0, math.inf),), position)


# --- The shafts, and the arm that follows them ---------------------------------------------------
# A closed-loop motor makes up for what it has lost, as far as the arm lets it. Counts are those of
# the world's motors, or of their shafts where there is backlash between the two.

# How often a moving arm is updated so that its shafts follow.
LOOK_S = 0.02
# How old the shafts' positions may be when no caller asks for them.
SLACK_S = 0.005
# How often the arm is updated while a shaft is off its set-point.
WATCH_S = 0.01


class ShaftPoints:
    """The set-points of all drives, as a rack of motors."""

    def __init__(self, each: Sequence[ShaftPoint]) -> None:
        self.each = tuple(each)
        self.now_s = 0.0

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        return self.now_s < max([point.end_s for point in self.each])

    @property
    def done_s(self) -> float:
        """When the last motion under way ends; infinity if there is none."""
        ends = [point.end_s for point in self.each if point.moving(self.now_s)]
        return max(ends, default=math.inf)

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return all set-points."""
        return tuple([point.at(now_s) for point in self.each])

    def bends(self, start_s: float, end_s: float) -> tuple[float, ...]:  # noqa: ARG002
        """Return nothing: the device samples its arm often enough by itself."""
        return ()

    def settle(self, now_s: float) -> None:
        """Do nothing: a finished motion needs no bookkeeping."""

    def stop(self, now_s: float) -> None:
        """End all motion dead where it is now."""
        for point in self.each:
            point.hold(point.at(now_s))

    def count(self, deltas: Sequence[int]) -> None:
        """Shift the set-points that stand."""
        for point, delta in zip(self.each, deltas, strict=True):
            point.hold(point.end + delta)

    def zero(self) -> None:
        """Do nothing: a zero only changes what a drive reports; no shaft turns."""


class ShaftDrive(MotorDrive[ShaftPoints]):
    """Six closed loops and one arm; drives that are not `holding` turn freely.

    `top_rate` is how many counts a second a shaft turns at most. The shafts' places may be
    `SLACK_S` old; a caller who needs the present ones calls `look`.
    """

    def __init__(self, world: World, top_rate: float) -> None:
        super().__init__(world, ShaftPoints([ShaftPoint(count) for count in world.motors]))
        self._top_rate = top_rate
        self.holding = [False] * len(world.motors)
        world.energised = False  # found at rest: the arm sagged long ago
        self.astray = False
        """Whether a shaft was off its set-point at the last look."""
        self._seen: Motors | None = None
        self.hold_shafts()

    @property
    def shafts(self) -> Motors:
        """The physical shaft positions: ahead of the joints they drive by the backlash taken up."""
        if not self.world.play.any:
            return self.world.motors
        return self.world.motors + Motors(self.world.play.ahead)

    def errors(self, now_s: float) -> tuple[int, ...]:
        """Return how far each shaft is from its set-point; 0 for a shaft that nothing holds."""
        return self._errors(self.rack.positions(now_s))

    def _errors(self, positions: Sequence[int]) -> tuple[int, ...]:
        points = zip(positions, self.shafts, self.holding, strict=True)
        return tuple([wanted - shaft if held else 0 for wanted, shaft, held in points])

    def hold_shafts(self) -> None:
        """Move every set-point to where its shaft is."""
        for point, shaft in zip(self.rack.each, self.shafts, strict=True):
            point.hold(shaft)

    @property
    def look_s(self) -> float:
        """When to update the arm next; infinity if all shafts stand at their set-points."""
        if self.astray:
            return self._looked_s + WATCH_S
        return self._looked_s + LOOK_S if self.rack.moving else math.inf

    def follow(self, now_s: float) -> None:
        """Advance to now; frames arrive so close together that not every one is worth an update."""
        self.rack.now_s = now_s
        if self.astray or now_s - self._looked_s >= SLACK_S:
            self.look(now_s)

    def look(self, now_s: float) -> None:
        """Move the shafts to their set-points as far as they can follow by now."""
        since_s = now_s - self._looked_s
        if not since_s or self._stands():
            self._looked_s = self.rack.now_s = now_s
            return
        self._looked_s = self.rack.now_s = now_s
        wanted = self.rack.positions(now_s)
        errors = self._errors(wanted)
        if any(errors):
            most = math.ceil(self._top_rate * since_s)
            self.world.drive([min(max(error, -most), most) for error in errors], now_s)
            errors = self._errors(wanted)
        self.astray = any(errors)
        self._free()
        self._seen = self.world.motors

    def _stands(self) -> bool:
        """Return whether nothing has turned since the last update and nothing is about to."""
        # Another object means that something else has turned the motors: a hand, or a sag.
        if self.astray or self.world.motors is not self._seen:
            return False
        return max([point.end_s for point in self.rack.each]) <= self._looked_s

    def turn(self, steps: Sequence[int], now_s: float) -> None:
        """Turn shafts by hand, and have the drives hold them there."""
        self.look(now_s)
        self.world.drive(steps, now_s)
        self.hold_shafts()

    def set_counts(self, counts: Sequence[int], now_s: float) -> None:  # noqa: ARG002
        """Stand where the shafts are: counts are not a motor's business."""
        self.look(now_s)
        self.hold_shafts()

    def release(self, motors: Sequence[int], now_s: float) -> None:
        """Cut the current of some motors, so that their loads sag."""
        self.look(now_s)
        freed = [motor for motor in motors if self.holding[motor]]
        if not freed:
            return
        if all(self.holding) and len(freed) == len(self.holding):
            self.world.cut_current(now_s)
        else:
            self.world.give_way(self._sag(freed), now_s)
        for motor in freed:
            self.holding[motor] = False
        self.world.energised = False
        self._free()

    def release_all(self, now_s: float) -> None:
        """Cut the current of all motors."""
        self.release(range(len(self.holding)), now_s)

    def hold(self, motor: int, now_s: float) -> None:
        """Switch a motor's current on at its present position."""
        self.look(now_s)
        self.rack.each[motor].hold(self.shafts[motor])
        self.holding[motor] = True
        self.world.energised = all(self.holding)

    def _sag(self, freed: Sequence[int]) -> list[int]:
        """Return the steps by which motors sag on an arm that the others still hold."""
        body, world = self.world.body, self.world
        rest = sagged(body.arm, world.joints)
        away = body.transmission.to_motors(rest, world.opening_mm) - world.motors
        return [step if motor in freed else 0 for motor, step in enumerate(away)]

    def _free(self) -> None:
        """Have the set-points of motors without current follow their shafts."""
        if not all(self.holding):
            for point, shaft, held in zip(self.rack.each, self.shafts, self.holding, strict=True):
                if not held:
                    point.hold(shaft)
