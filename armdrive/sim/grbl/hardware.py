"""What a simulated GRBL board has besides motors: spindle, coolant, ports, gripper, switches."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from armdrive.sim.device import SwitchState
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import Json
from firmware_protocol.grbl import Modal


@dataclass(frozen=True, slots=True)
class OutputWiring:
    """Which output moves the fingers: spindle, flood, mist, digital or analog, or none of them.

    At the value `closed` the fingers are shut, at `opened` wide open, in between in proportion.
    """

    what: str = ""
    port: int = 0
    closed: float = 0.0
    opened: float = 1.0

    def share(self, value: float) -> float:
        """Return how far a value opens the fingers, from 0 to 1."""
        return min(max((value - self.closed) / (self.opened - self.closed), 0.0), 1.0)


@dataclass(slots=True)
class BoardOutputs:
    """The state of every output."""

    spindle: str = "M5"
    speed: float = 0.0
    flood: bool = False
    mist: bool = False
    digital: dict[int, bool] = field(default_factory=dict)
    analog: dict[int, float] = field(default_factory=dict)

    def spin(self, modal: Modal, least_speed: float, most_speed: float) -> None:
        """Have the spindle as the modes say, as slow and as fast as `$31` and `$30` allow."""
        self.spindle = modal.spindle
        turns = modal.spindle != "M5" and modal.speed > 0.0
        self.speed = min(max(modal.speed, least_speed), most_speed) if turns else 0.0

    def cool(self, word: str) -> None:
        """Switch coolant: M7 and M8 add to one another, M9 ends both."""
        self.mist = word != "M9" and (self.mist or word == "M7")
        self.flood = word != "M9" and (self.flood or word == "M8")

    def put(self, word: str, port: int, value: float) -> None:
        """Set a port, digital or analog."""
        if word in ("M67", "M68"):
            self.analog[port] = value
        else:
            self.digital[port] = bool(value)

    def off(self) -> None:
        """Stop spindle and coolant, as every reset does; ports stay."""
        self.spindle, self.speed = "M5", 0.0
        self.flood = self.mist = False

    def forget(self) -> None:
        """Switch everything off, as without power."""
        self.off()
        self.digital.clear()
        self.analog.clear()

    @property
    def letters(self) -> str:
        """The accessories as a status report names them."""
        turning = {"M3": "S", "M4": "C"}.get(self.spindle, "")
        return turning + "F" * self.flood + "M" * self.mist

    def value(self, wiring: OutputWiring) -> float | None:
        """Return what a gripper on this wiring is told; None for a servo that is told nothing."""
        match wiring.what:
            case "spindle":
                return self.speed if self.spindle != "M5" else None
            case "flood":
                return float(self.flood)
            case "mist":
                return float(self.mist)
            case "digital":
                return float(self.digital.get(wiring.port, False))
            case "analog":
                return self.analog.get(wiring.port)
        return None

    def to_json(self) -> dict[str, Json]:
        """Return the outputs for people and for programs."""
        digital: dict[str, Json] = {str(port): on for port, on in sorted(self.digital.items())}
        analog: dict[str, Json] = {str(port): v for port, v in sorted(self.analog.items())}
        return {
            "spindle": self.spindle,
            "speed": self.speed,
            "flood": self.flood,
            "mist": self.mist,
            "digital": digital,
            "analog": analog,
        }


# --- Limit switches: one for each motor, at one end of its travel --------------------------------


@dataclass(frozen=True, slots=True)
class LimitInput:
    """The motor that it is on, the physical steps from which it is pressed, and which way."""

    motor: int
    trip_steps: int
    way: int


@dataclass(slots=True)
class Switches:
    """Switches by the number of their axis. What the registers say does not matter to them."""

    world: World
    by_axis: Mapping[int, LimitInput]
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
