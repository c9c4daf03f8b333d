"""The controller's counting and the physical arm that follows it, kept in step on one clock."""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.sim.motors import MotorRack
from armdrive.sim.world import World
from kinematics.spaces import Motors


class Drive:
    """Turns motors: the rack counts what was commanded, the world says what came of it."""

    def __init__(self, world: World) -> None:
        self.world = world
        self._rack = MotorRack((0,) * len(world.motors))
        self._driven = Motors(self._rack.positions(0.0))

    @property
    def moving(self) -> bool:
        """Whether a motion is under way."""
        return self._rack.moving

    @property
    def done_s(self) -> float:
        """When the motion under way ends; infinity while there is none."""
        return self._rack.done_s

    @property
    def counts(self) -> Motors:
        """The commanded counts as of the last `follow`."""
        return self._driven

    def start(self, steps: Sequence[int], rate_hz: float, now_s: float) -> None:
        """Begin to turn all motors in proportion, with the current on."""
        self.world.energised = True
        self._rack.start(steps, rate_hz, now_s)

    def follow(self, now_s: float) -> None:
        """Bring the physical arm to where the motors have turned it by now."""
        counts = self._rack.positions(now_s)
        if counts != self._driven:
            steps = Motors(counts) - self._driven
            self._driven = Motors(counts)
            self.world.drive(steps, now_s)

    def stop(self, now_s: float) -> None:
        """End the motion where it is now."""
        self.follow(now_s)
        self._rack.stop(now_s)

    def turn(self, steps: Sequence[int], now_s: float) -> None:
        """Turn motors by hand of the pendant: counted, with the current on, and at once."""
        self.stop(now_s)
        self.world.energised = True
        self._rack.count(steps)
        self.follow(now_s)

    def set_counts(self, counts: Sequence[int], now_s: float) -> None:
        """Count from here on as if the motors stood at `counts`; nothing turns."""
        self.stop(now_s)
        self._rack.zero()
        self._rack.count(counts)
        self._driven = Motors(counts)
