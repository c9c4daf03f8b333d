"""The twin of an arm on a bus, and whoever is at the other end of it: simulated time passes."""

from types import SimpleNamespace
from typing import Any, Generic, TypeVar

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection, HomingSettings
from armdrive.registry import simulate
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.simulated_arm import SimulatedArm
from kinematics import preset

IDS = (1, 2, 3, 4, 5, 6)
LONG_S = 0.01
"""Longer than any answer takes."""
H = TypeVar("H")


def bus_arm(dialect: str, homing: HomingSettings | None = None, **section: Any) -> ArmConfig:
    """Return an arm on six drives; `section` is what its file's section says."""
    device = SimpleNamespace(**({"ids": IDS} | section))
    connection = Connection(dialect=dialect, port="", baud=500_000)
    model = preset(f"minimover5-{dialect}")
    return ArmConfig("bench", model.title, model, connection, device=device, homing=homing)


class BusSim(Generic[H]):
    """A twin whose bus is written to and read. What is heard carries its time."""

    def __init__(self, config: ArmConfig, saved: object = None, **settings: Any) -> None:
        self.twin: SimulatedArm = simulate(config, saved, **settings)
        assert isinstance(self.twin.board, DrivesBoard)
        self.device = self.twin.device
        self.board: Any = self.twin.board
        self.world = self.twin.world
        self.link = self.twin.link
        self.now_s = 0.0
        self.heard: list[tuple[float, H]] = []

    def run(self, seconds: float = LONG_S) -> list[H]:
        """Let time pass; return what was heard meanwhile."""
        end_s, before = self.now_s + seconds, len(self.heard)
        while self.link.next_s() <= end_s:
            self.now_s = max(self.now_s, self.link.next_s())
            self._read()
        self.now_s = end_s
        self._read()
        return [heard for _, heard in self.heard[before:]]

    def _read(self) -> None:
        raise NotImplementedError
