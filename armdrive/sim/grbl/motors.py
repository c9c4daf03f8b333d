"""The motors of a simulated GRBL board: its axes' queue of lines, and the arm that follows it.

Counts of the board are in the order of its axes, those of the arm in the order of its motors. A
board can have more axes than the arm has motors; what is left over turns nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from armdrive.sim.grbl.firmware import BoardBuild
from armdrive.sim.mechanics.motors import MotorDrive
from armdrive.sim.mechanics.planner import PathLimits, PathRack
from armdrive.sim.world.arm import World
from kinematics.spaces import Motors


class BoardDrive(MotorDrive[PathRack]):
    """A path in the space of the board's axes; the build gives the axis of each motor."""

    def __init__(self, world: World, build: BoardBuild, limits: PathLimits) -> None:
        axes = len(build.axes)
        super().__init__(world, PathRack((0,) * axes, limits, build.firmware.stepping))
        self._followed_s = math.nan
        self._axes = axes
        self._order = tuple(build.order)

    @property
    def registers(self) -> Motors:
        """The counts of the axes that are motors."""
        return self._of_motors(self.counts)

    def set_counts(self, counts: Sequence[int], now_s: float) -> None:
        """Count from here on as if the motors stood there; nothing turns."""
        self.set_axes(self._of_axes(counts), now_s)

    def set_axes(self, counts: Sequence[int], now_s: float) -> None:
        """Count from here on as if the axes stood there; nothing turns."""
        super().set_counts(counts, now_s)

    def turn(self, steps: Sequence[int], now_s: float) -> None:
        """Turn motors by hand: counted, with the current on, and at once."""
        self.stop(now_s)
        self.energise()
        self.rack.count(self._of_axes(steps))
        self._follow(now_s)

    def follow(self, now_s: float) -> None:
        """Bring the arm to where its motors are by now, once for each moment."""
        if now_s != self._followed_s:
            super().follow(now_s)
            self._followed_s = now_s

    def steps_of(self, target: Sequence[float]) -> Motors:
        """Return where a target in units lies in steps: rounded once, as it is absolute."""
        per_unit = self.rack.limits.steps_per_unit
        return Motors(
            math.floor(abs(unit * per) + 0.5) * (1 if unit >= 0 else -1)
            for unit, per in zip(target, per_unit, strict=True)
        )

    def units_of(self, counts: Sequence[int]) -> tuple[float, ...]:
        """Return steps in units."""
        per_unit = self.rack.limits.steps_per_unit
        return tuple(count / per for count, per in zip(counts, per_unit, strict=True))

    def queue_to(
        self, target: Sequence[float], rate: float, now_s: float, *, rapid: bool = False
    ) -> bool:
        """Queue a line to a target in units; False where it is no way at all."""
        self.follow(now_s)
        deltas = self.steps_of(target) - self.rack.goal
        return self.rack.queue(deltas, rate, now_s, rapid=rapid)

    @property
    def next_s(self) -> float:
        """When a line ends; infinity while none is under way."""
        return self.rack.next_line_s

    def live(self, now_s: float) -> bool:
        """Do what is due; True where the motors have come to a stand."""
        if self.rack.next_line_s <= now_s:
            self.settle(now_s)
            return not self.moving
        return False

    def brake(self, now_s: float) -> None:
        """Slow down along the path to a stand-still, behind the segments that are computed."""
        self.follow(now_s)
        self.rack.hold(now_s)

    def queued(self, now_s: float) -> int:
        """Return how many lines wait: one whose last segment is computed does no longer."""
        return self.rack.waiting - self.rack.ending_by(self.rack.computed_s(now_s))

    def speed(self, now_s: float) -> float:
        """Return the speed of the segment that was computed last, in units a second."""
        return self.rack.speed(self.rack.computed_s(now_s))

    def kill(self, now_s: float, coast: float) -> None:
        """Stop dead, all lines lost; the arm runs on for a share of the ramp that is not made."""
        self.follow(now_s)
        here = there = Motors(self.rack.positions(now_s))
        if self.moving:
            self.rack.hold(now_s, dead=True)
            if self.moving:
                there = Motors(self.rack.positions(self.done_s))
        self.stop(now_s)
        ramp = [round(count * coast) for count in there - here]
        self.world.force(self._of_motors(ramp), now_s)

    def _of_motors(self, counts: Sequence[int]) -> Motors:
        return Motors([counts[axis] for axis in self._order])

    def _of_axes(self, counts: Sequence[int]) -> Motors:
        turned = dict(zip(self._order, counts, strict=True))
        return Motors([turned.get(axis, 0) for axis in range(self._axes)])

    def _follow(self, now_s: float) -> None:
        counts = Motors(self.rack.positions(now_s))
        if counts != self._driven:
            steps = counts - self._driven
            self._driven = counts
            self.world.drive(self._of_motors(steps), now_s)
