"""The limit switches of a simulated arm on a GRBL board: one for each motor, at one end of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from armdrive.sim.device import SwitchState
from armdrive.sim.world import World


@dataclass(frozen=True, slots=True)
class Switch:
    """The motor that it is on, the physical steps from which it is pressed, and which way."""

    motor: int
    trip_steps: int
    way: int


@dataclass(slots=True)
class Switches:
    """Switches by the number of their axis. What the registers say does not matter to them."""

    world: World
    by_axis: Mapping[int, Switch]
    stuck: dict[int, SwitchState] = field(default_factory=dict)
    """What is stuck, by motor."""

    def pressed(self, axis: int) -> bool:
        """Tell whether the board sees a switch pressed; an axis without a motor has none."""
        one = self.by_axis.get(axis)
        if one is None:
            return False
        state = self.stuck.get(one.motor, SwitchState.FREE)
        if state is not SwitchState.FREE:
            return state is SwitchState.CLOSED
        return (self.world.motors[one.motor] - one.trip_steps) * one.way >= 0

    def mask(self) -> int:
        """Return a bit for each switch that is seen pressed, the first axis lowest."""
        return sum(self.pressed(axis) << axis for axis in self.by_axis)

    def steps_to(self, axis: int, way: int) -> int | None:
        """Return how many steps in a direction press the switch; None where none ever do."""
        one = self.by_axis.get(axis)
        if self.pressed(axis):
            return 0
        if one is None or self.stuck.get(one.motor, SwitchState.FREE) is SwitchState.OPEN:
            return None
        missing = (one.trip_steps - self.world.motors[one.motor]) * way
        return missing if missing > 0 else None
