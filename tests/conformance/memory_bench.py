"""A bench within this process: the dialect's twin on simulated time, as fast as can be."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import assemble
from armdrive.connect.reconnect import NewLink
from armdrive.connect.target import simulated_config
from armdrive.dialog.operator import Operator
from armdrive.registry.simulate import simulate
from armdrive.runtime.clock import SimulatedClock, SimulatedPace
from armdrive.sim.faults.request import parse_words
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.storage.record import FileRecorder

from .bench import Bench
from .expected_errors import PROFILE, STRIKES_S
from .fitted import fitted_config
from .seen import Seen

WAKES_S = 0.001
BY_HAND = (7000, -4000, 2500, 1500, -1500, 900)
"""Counts: some degrees of each joint."""


@dataclass(frozen=True, slots=True)
class Variant:
    """An arm of a dialect with another board, other firmware or another way to drive it.

    `device` are settings of the dialect's section of the arm file, `board` those of the twin.
    """

    name: str
    dialect: str
    device: Mapping[str, Any] = field(default_factory=dict)
    board: Mapping[str, Any] = field(default_factory=dict)
    differs: tuple[str, ...] = ()
    """The families of rows in which it is unlike the dialect's other arms; of all, if empty."""

    def of(self, config: ArmConfig) -> ArmConfig:
        """Return the arm of a file, set up like this."""
        return replace(config, device=replace(config.device, **self.device))


class MemoryBench(Bench):
    """The twin in this process."""

    transport: ClassVar[str] = "memory"
    real_time: ClassVar[bool] = False
    on_bus: ClassVar[bool] = True
    look_s: ClassVar[float] = 0.02
    noise_s: ClassVar[float] = 0.021  # one look late
    knows_geometry: ClassVar[bool] = True
    moments_s: ClassVar[tuple[float, ...]] = (0.0, STRIKES_S)

    def __init__(self, dialect_name: str, variant: Variant | None = None) -> None:
        super().__init__(dialect_name)
        self._variant = variant or Variant(dialect_name, dialect_name)
        self._config = self._variant.of(simulated_config(dialect_name))
        self._folder = tempfile.TemporaryDirectory(prefix="conformance-")
        self._record_file = Path(self._folder.name) / "record.json"
        self.begin_anew()

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
        """The class of the twin's board."""
        return type(self.twin.board)

    def operator(self) -> Operator:
        """Return the twin's operator."""
        return self.twin.operator

    def _open(self, *, reconnect: bool = False, **options: Any) -> Arm:
        # by the constructor, since a later driver has to go on in the device's own time
        arm = Arm(
            assemble(
                self._config,
                self.twin.link,
                SimulatedPace(SimulatedClock(self._now_s)),
                simulated=True,
                recorder=FileRecorder(self._record_file),
                operator=self.twin.operator,
                rewiring=NewLink(self.twin.link.reopen, reconnect),
                **options,
            )
        )
        arm.twin = self.twin
        return arm

    def look(self) -> Seen:
        """Look at the twin's world, at the driver's present time."""
        self._keep_time()
        world = self.twin.world
        return Seen(
            self._now_s,
            world.motors,
            world.tip,
            world.opening_mm,
            world.energised,
            self.twin.device.powered,
        )

    def sleep(self, time_s: float) -> None:
        """Let the driver's time pass, and the device's own where no driver keeps it."""
        until_s = self._now_s + time_s
        if self.arm is not None:
            self.arm.sleep(time_s)
        self._now_s = max(self._now_s, until_s)
        self._keep_time()
        if self.arm is None or self.arm.engine.broken is not None:
            self.twin.link.line.advance(self._now_s)

    def begin_anew(self) -> None:
        """Put a new twin on the bench, of which nothing is recorded."""
        super().leave()
        self._record_file.unlink(missing_ok=True)
        self._now_s = 0.0
        self.twin: SimulatedArm = simulate(self._config, **self._variant.board)

    def fit(self, lines: str) -> None:
        """Put the twin of an arm file on the bench."""
        self._config = self._variant.of(fitted_config(self.row, lines, self._config.name))
        self.begin_anew()

    def turned_by_hand(self) -> bool:
        """Turn the shafts of drives on a bus, of which simulated motions take the longest."""
        if self.row.can:
            self.twin.device.jog(BY_HAND)
        return self.row.can

    def later(self, time_s: float, call: Callable[[], object]) -> None:
        """Have it done on the device's clock; the driver wakes a moment later, as in real time."""
        self._keep_time()
        self.twin.device.at(self._now_s + time_s, call)
        self.twin.device.at(self._now_s + time_s + WAKES_S, lambda: None)

    def leave(self) -> None:
        """Close the driver, and put a new wire in its place."""
        if (arm := self.arm) is not None:
            super().leave()
            self._now_s = max(self._now_s, arm.pace.now_s())
            self.twin = SimulatedArm.of(self._config, self.twin.device)

    def close(self) -> None:
        """Forget the twin and its record."""
        try:
            super().close()
        finally:
            self._folder.cleanup()

    def _keep_time(self) -> None:
        if self.arm is not None:
            self._now_s = max(self._now_s, self.arm.pace.now_s())

    def fault(self, words: str) -> None:
        """Have a fault, in the words of the console."""
        self.twin.faults.ask(parse_words(words.split()))

    def heal(self) -> None:
        """End every fault."""
        self.twin.faults.end()

    def replug_elsewhere(self) -> None:
        """Put the cable back."""
        self.fault("replug as elsewhere")


class ThoroughMemoryBench(MemoryBench):
    """The same with faults at more moments, for the whole table."""

    moments_s: ClassVar[tuple[float, ...]] = (0.0, 0.05, 0.11, 0.21, STRIKES_S, 0.45, 0.67)


MOTION, STOPS = ("move", "Cartesian", "gripper"), ("jog", "stop", "pause")
SLOW = {"speed_error": 0.4}
VARIANTS = (
    Variant("grbl on an ATmega328P", "grbl", board={"firmware": "grbl"},
            differs=(*MOTION, *STOPS, "speed", "homing by switches", "reconnect", "fault")),
    Variant("grblHAL", "grbl", board={"firmware": "grblhal"}, differs=(*MOTION, *STOPS)),
    Variant("FluidNC", "grbl", board={"firmware": "fluidnc"}, differs=(*MOTION, *STOPS)),
    Variant("grbl in degrees", "grbl", {"unit": "degrees"}, differs=MOTION),
    Variant("a Robko on an ESP32", "robko01",
            {"board": "esp32", "acceleration_steps_s2": 700.0},
            {"board": "esp32", "acceleration": 700.0}, (*MOTION, *STOPS)),
    Variant("a slow Robko", "robko01", board=SLOW, differs=STOPS),
    Variant("a slow Armdroid", "armdroid", board=SLOW, differs=STOPS),
    Variant("an Armdroid whose numbers are not checked", "armdroid", {"check_numbers": False},
            SLOW, STOPS),
    Variant("a slow TeachMover", "teachmover", board=SLOW, differs=STOPS),
    Variant("MKS drives in bursts", "mks", {"segment_s": 0.0}, differs=("fault",)),
    Variant(PROFILE, "cia402", {"strategy": "profile"}, differs=("fault",)),
)  # fmt: skip
"""Arms that the suite is held against besides the one of each dialect's preset."""
