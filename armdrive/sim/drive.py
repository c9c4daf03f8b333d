"""The controller's counting and the physical arm that follows it, kept in step on one clock.

A rack knows where its motors stand at any moment: `MotorRack` turns them in proportion,
`UncoordinatedRack` each by itself, `PathRack` along queued lines.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Generic, Protocol, TypeVar

from armdrive.sim.motors import MotorRack
from armdrive.sim.world import World
from kinematics.spaces import Motors


class Rack(Protocol):
    """Counts of all motors at any moment, without ticking."""

    @property
    def moving(self) -> bool:
        """Whether a motion is under way, or has ended and nobody has called `settle` since."""

    @property
    def done_s(self) -> float:
        """When the motion under way ends; infinity while there is none."""

    def positions(self, now_s: float) -> tuple[int, ...]:
        """Return the counts at a moment, which never comes before that of an earlier change."""

    def bends(self, start_s: float, end_s: float) -> Iterable[float]:
        """Return the moments in between at which the motors leave a straight way, in order."""

    def settle(self, now_s: float) -> None:
        """Take in what has ended by now."""

    def stop(self, now_s: float) -> None:
        """End all motion dead where it is now."""

    def count(self, deltas: Sequence[int]) -> None:
        """Count steps that were made apart from any motion, while standing."""

    def zero(self) -> None:
        """Begin to count anew; nothing turns."""


R = TypeVar("R", bound=Rack)


class Drive(Generic[R]):
    """Turns motors: the rack counts what was commanded, the world says what came of it.

    A dialect's device starts motions on `rack` itself, after `energise`.
    """

    def __init__(self, world: World, rack: R) -> None:
        self.world = world
        self.rack = rack
        self._driven = Motors(rack.positions(0.0))
        self._looked_s = 0.0

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        return self.rack.moving

    @property
    def done_s(self) -> float:
        """When the motion under way ends; infinity while there is none."""
        return self.rack.done_s

    @property
    def counts(self) -> Motors:
        """The commanded counts as of the last `follow`."""
        return self._driven

    def energise(self) -> None:
        """Switch the motors' current on."""
        self.world.energised = True

    def follow(self, now_s: float) -> None:
        """Bring the physical arm to where the motors have turned it by now.

        A device calls it whenever its clock goes on, standing or not, so that a motion's way is
        looked at from its very start.
        """
        if self.rack.moving:
            for bend_s in self.rack.bends(self._looked_s, now_s):
                self._follow(bend_s)
        self._follow(now_s)
        self._looked_s = now_s

    def settle(self, now_s: float) -> None:
        """Take in what has ended by now."""
        self.follow(now_s)
        self.rack.settle(now_s)

    def stop(self, now_s: float) -> None:
        """End the motion dead where it is now."""
        self.follow(now_s)
        self.rack.stop(now_s)

    def turn(self, steps: Sequence[int], now_s: float) -> None:
        """Turn motors by hand of the pendant: counted, with the current on, and at once."""
        self.stop(now_s)
        self.energise()
        self.rack.count(steps)
        self.follow(now_s)

    def set_counts(self, counts: Sequence[int], now_s: float) -> None:
        """Count from here on as if the motors stood at `counts`; nothing turns."""
        self.stop(now_s)
        self.rack.zero()
        self.rack.count(counts)
        self._driven = Motors(counts)

    def _follow(self, now_s: float) -> None:
        positions = self.rack.positions(now_s)
        if positions != self._driven:
            counts = Motors(positions)
            steps = counts - self._driven
            self._driven = counts
            self.world.drive(steps, now_s)


class CoordinatedDrive(Drive[MotorRack]):
    """All motors in proportion, at a constant rate."""

    def __init__(self, world: World) -> None:
        super().__init__(world, MotorRack((0,) * len(world.motors)))

    def start(self, steps: Sequence[int], rate_hz: float, now_s: float) -> None:
        """Begin to turn all motors in proportion, with the current on."""
        self.energise()
        self.rack.start(steps, rate_hz, now_s)
