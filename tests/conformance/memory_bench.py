"""A bench in this process: the dialect's simulated device, in simulated time."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.target import simulated_config
from armdrive.dialog import Operator
from armdrive.sim.faults import parse_words
from kinematics import Motors
from tests.scenarios.stage import Stage

from .bench import Bench
from .custom_arm import custom_config
from .faults import PROFILE, STRIKES_S
from .observation import Observation

BY_HAND = (7000, -4000, 2500, 1500, -1500, 900)
"""The counts by which a hand turns the motors: some degrees of each joint."""


@dataclass(frozen=True, slots=True)
class Variant:
    """An arm of a dialect with another board, other firmware or another way to drive it.

    `device` has settings of the dialect's section in the arm file, `board` those of the simulated
    device.
    """

    name: str
    dialect: str
    device: Mapping[str, Any] = field(default_factory=dict)
    board: Mapping[str, Any] = field(default_factory=dict)
    differs: tuple[str, ...] = ()
    """The families of rows in which this arm behaves in its own way; all if empty."""

    def of(self, config: ArmConfig) -> ArmConfig:
        """Return a configuration with the settings of this variant."""
        return replace(config, device=replace(config.device, **self.device))


class MemoryBench(Bench):
    """The simulated device in this process."""

    transport: ClassVar[str] = "memory"
    real_time: ClassVar[bool] = False
    on_bus: ClassVar[bool] = True
    look_s: ClassVar[float] = 0.02
    noise_s: ClassVar[float] = 0.021  # one look late
    trusts_geometry: ClassVar[bool] = True
    fault_moments_s: ClassVar[tuple[float | None, ...]] = (None, 0.0, STRIKES_S)

    def __init__(self, dialect_name: str, variant: Variant | None = None) -> None:
        super().__init__(dialect_name)
        self._variant = variant or Variant(dialect_name, dialect_name)
        self._config = self._variant.of(simulated_config(dialect_name))
        self.start_afresh()

    @property
    def names(self) -> tuple[str, ...]:
        """The variant's name, and the dialect's."""
        return self._variant.name, self.row.name

    @property
    def config(self) -> ArmConfig:
        """The simulated arm of the dialect."""
        return self._config

    @property
    def board(self) -> type:
        """The class of the simulated board."""
        return type(self.stage.twin.board)

    def operator(self) -> Operator:
        """Return the operator of the simulated arm."""
        return self.stage.twin.operator

    def _open(self, *, reconnect: bool = False, **options: Any) -> Arm:
        return self.stage.connect(automatic=reconnect, **options)

    def look(self) -> Observation:
        """Observe the simulated arm at the driver's present time."""
        stage = self.stage
        motors, world = stage.look(), stage.world
        powered = stage.twin.device.powered
        tip, opening_mm = world.tip, world.opening_mm
        return Observation(stage.now_s, motors, tip, opening_mm, world.energised, powered)

    def sleep(self, time_s: float) -> None:
        """Let time pass for the driver, and for a device without a driver."""
        self.stage.sleep(time_s)

    def start_afresh(self) -> None:
        """Use a new simulated device, and forget all records."""
        if self.arm is not None:
            super().disconnect()
        self.stage = Stage(self._config, self._variant.board)

    def use_arm_file(self, lines: str) -> None:
        """Use the simulated device of an arm file with more lines."""
        self._config = self._variant.of(custom_config(self.row, lines, self._config.name))
        self.start_afresh()

    def turn_by_hand(self) -> bool:
        """Turn the shafts of drives on a bus, whose simulated motions take the longest."""
        return self.row.can and self.stage.turn_by_hand(Motors(BY_HAND))

    def call_later(self, time_s: float, call: Callable[[], object]) -> None:
        """Call a function in simulated time, before the driver's next step."""
        self.stage.timeline.at(self.stage.now_s + time_s, call)

    def disconnect(self) -> None:
        """Close the driver."""
        super().disconnect()
        self.stage.program_ended()

    def fault(self, words: str) -> None:
        """Inject a fault, in the words of the console."""
        self.stage.look()
        self.stage.twin.faults.ask(parse_words(words.split()))

    def heal(self) -> None:
        """End every fault."""
        self.stage.twin.faults.end()

    def replug_elsewhere(self) -> None:
        """Put the cable back."""
        self.fault("replug as elsewhere")


class ThoroughMemoryBench(MemoryBench):
    """The same bench with faults at more moments, for the whole table."""

    fault_moments_s: ClassVar[tuple[float | None, ...]] = (
        None, 0.0, 0.05, 0.11, 0.21, STRIKES_S, 0.45, 0.67,
    )  # fmt: skip


MOTION, STOPS = ("move", "Cartesian", "gripper"), ("jog", "stop", "pause")
SLOW = {"speed_error": 0.4}
VARIANTS = (
    Variant("grbl on an ATmega328P", "grbl", board={"firmware": "grbl"},
            differs=(*MOTION, *STOPS, "speed", "homing by switches", "reconnect", "fault")),
    Variant("grblHAL", "grbl", board={"firmware": "grblhal"}, differs=(*MOTION, *STOPS)),
    Variant("FluidNC", "grbl", board={"firmware": "fluidnc"},
            differs=(*MOTION, *STOPS, "homing by switches")),
    Variant("grbl in degrees", "grbl", {"unit": "degrees"}, differs=MOTION),
    Variant("a Robko on an ESP32", "robko01",
            {"board": "esp32", "acceleration_steps_s2": 700.0},
            {"board": "esp32", "acceleration": 700.0}, (*MOTION, *STOPS)),
    Variant("a slow Robko", "robko01", board=SLOW, differs=STOPS),
    Variant("a slow Armdroid", "armdroid", board=SLOW, differs=STOPS),
    Variant("a slow TeachMover", "teachmover", board=SLOW, differs=STOPS),
    Variant("MKS drives in bursts", "mks", {"segment_s": 0.0}, differs=("fault",)),
    Variant(PROFILE, "cia402", {"strategy": "profile"}, differs=("fault",)),
)  # fmt: skip
"""The arms that the suite tests besides each dialect's preset."""
