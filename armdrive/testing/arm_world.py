"""`ArmWorld`: a table with blocks and simulated arms, to which every connection of a program leads.

Its truth is physical: what stands where, what the fingers really hold, and what was knocked over,
whatever the program and its controllers believe. All arms live on its one simulated clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from types import MappingProxyType, TracebackType
from typing import Any, Self

from armdrive.arm import Arm, standing_in
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import ConnectOptions, connect_simulated
from armdrive.connect.target import DEFAULT_TARGET, Target, find
from armdrive.dialog.operator import Operator
from armdrive.errors import ArmFileError, ArmInUse, BadRequest
from armdrive.registry.simulate import simulate
from armdrive.runtime.clock import SimulatedClock
from armdrive.sim.faults.table import Faults
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.sim.world.table import Incident, Stand, Table, TableBlock
from armdrive.storage.files import always
from armdrive.storage.record import Record
from kinematics.spaces import Joints, Pose

ONLY = "arm"
"""The name of the arm of a world in which nobody has placed any by name."""


class ReopenedArm:
    """What one arm's driver remembers between two connections, for as long as the world lasts."""

    def __init__(self) -> None:
        self._record: Record | None = None

    def load(self) -> Record | None:
        """Return what was saved last."""
        return self._record

    def refuse(self) -> None:
        """Take no notice: there is no file to be kept aside."""

    def save(self, record: Record, wanted: Callable[[], bool] = always) -> None:
        """Keep a record."""
        if wanted():
            self._record = record

    def remove(self) -> None:
        """Forget it."""
        self._record = None


@dataclass(slots=True)
class Placed:
    """One simulated arm at the table, and who holds it."""

    config: ArmConfig
    twin: SimulatedArm
    recorder: ReopenedArm = field(default_factory=ReopenedArm)
    arm: Arm | None = None

    @property
    def taken(self) -> bool:
        """Whether a connection to it is open."""
        return self.arm is not None and not self.arm.closed


def _known(target: str | None, dialect: str | None, baud: int | None) -> Target | None:
    """Return what a program asks for; None for a name that only its own computer knows."""
    if target is None:
        return None
    try:
        return find(target, dialect_name=dialect, baud=baud)
    except (ArmFileError, BadRequest):
        if target.startswith("sim:") or target.endswith(".toml"):
            raise
        return None


def _alike(asked: ArmConfig, here: ArmConfig) -> bool:
    """Tell whether an arm is what a program takes it for."""
    same_dialect = asked.connection.dialect == here.connection.dialect
    return same_dialect and asked.calibration == here.calibration


class ArmWorld:
    """A world for tests; within `with world:` every `connect` of this process leads into it.

    `arm_world.put("A", 250, 0)` places a block, in mm on the table, where the first arm's base is
    the origin. `pose`, `joints`, `opening_mm`, `held`, `faults` are those of the first arm; of
    others, those of `arms["right"]`. An arm that nobody has placed is made when it is needed.
    """

    def __init__(self, target: str | None = None) -> None:
        """`target` is what the arm is that nobody places by name: as `Arm.connect` takes it.

        Without it, what the program asks for, and the simulated TeachMover where the program's own
        name is not known on this computer.
        """
        self.clock = SimulatedClock()
        self._table = Table()
        self._target = target
        self._placed: dict[str, Placed] = {}
        self._open = ExitStack()

    def __enter__(self) -> Self:
        self._open.enter_context(standing_in(self._connected))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._open.close()
        for placed in self._placed.values():
            if placed.arm is not None and placed.taken:
                placed.arm.close()

    # -- what there is ------------------------------------------------------------------------

    def add(
        self,
        name: str,
        target: str | None = None,
        *,
        x_mm: float = 0.0,
        y_mm: float = 0.0,
        turned_deg: float = 0.0,
        **options: Any,
    ) -> SimulatedArm:
        """Place an arm at the table under the name by which the program connects to it.

        `target` says what it is, `"sim:grbl"` or an arm file; the base stands at (x, y), turned
        about the vertical. Options are those of the simulated controller. Raises `BadRequest`.
        """
        if name in self._placed:
            raise BadRequest(f"an arm called {name!r} stands at the table already")
        config = find(target or self._target or DEFAULT_TARGET).config
        stand = Stand(self._table, x_mm, y_mm, math.radians(turned_deg))
        return self._place(name, config, stand, **options).twin

    def _place(self, name: str, config: ArmConfig, stand: Stand, **options: Any) -> Placed:
        self._placed[name] = Placed(config, simulate(config, stand=stand, **options))
        return self._placed[name]

    @property
    def arms(self) -> Mapping[str, SimulatedArm]:
        """The simulated arms by their names; `.world` of each is its physical truth."""
        return MappingProxyType({name: each.twin for name, each in self._placed.items()})

    def put(
        self,
        name: str,
        x_mm: float,
        y_mm: float,
        z_mm: float = 0.0,
        *,
        width_mm: float = 25.0,
        height_mm: float = 25.0,
    ) -> TableBlock:
        """Set a block down, by the centre of its bottom; return where it came to rest."""
        return self._table.put(TableBlock(name, x_mm, y_mm, z_mm, width_mm, height_mm))

    def take(self, name: str) -> TableBlock | None:
        """Take a block away; None where there is none of that name."""
        return self._table.take(name)

    @property
    def blocks(self) -> Mapping[str, TableBlock]:
        """Every block by its name, where it really is on the table."""
        return MappingProxyType(self._table.blocks)

    @property
    def incidents(self) -> tuple[Incident, ...]:
        """What went wrong, of all arms, in the order in which it happened."""
        found = [each for twin in self.arms.values() for each in twin.world.incidents]
        return tuple(sorted(found, key=lambda each: each.time_s))

    # -- the first arm ------------------------------------------------------------------------

    @property
    def twin(self) -> SimulatedArm:
        """The first arm: its controller, its wire and its world."""
        return self._first().twin

    def _first(self) -> Placed:
        """Return the first arm, made now where nobody has placed any."""
        if not self._placed:
            self.add(ONLY)
        return next(iter(self._placed.values()))

    @property
    def pose(self) -> Pose:
        """Where the tip really is, in its base's frame."""
        return self.twin.world.pose

    @property
    def joints(self) -> Joints:
        """How the joints really stand."""
        return self.twin.world.joints

    @property
    def opening_mm(self) -> float:
        """How far apart the fingers really are."""
        return self.twin.world.opening_mm

    @property
    def held(self) -> str | None:
        """The block that the fingers really hold."""
        return self.twin.world.scene.held

    @property
    def faults(self) -> Faults:
        """What goes wrong with the arm and its wire: `arm_world.faults.add("drop", 0.01)`."""
        return self.twin.faults

    def set_input(self, number: int, on: bool = True) -> None:
        """Switch an input of its controller, counted from 1. Raises `BadRequest`."""
        if isinstance(number, bool) or not isinstance(number, int):
            raise BadRequest(f"inputs are counted from 1, not {number!r}")
        self.twin.device.set_input(number - 1, on)

    def after(self, by_s: float, action: Callable[[], object]) -> None:
        """Have something happen so much later: `arm_world.after(5, lambda: world.take("A"))`."""
        device = self.twin.device

        def act() -> None:
            action()

        device.at(max(device.now_s, self.clock.now_s) + by_s, act)

    # -- connections --------------------------------------------------------------------------

    def connect(
        self,
        target: str | None = None,
        *,
        dialect: str | None = None,
        baud: int | None = None,
        allow_restored: bool = False,
        operator: Operator | None = None,
        reconnect: bool | None = None,
    ) -> Arm:
        """Connect as a program does whose `Arm.connect` leads here."""
        options = ConnectOptions(
            dialect=dialect,
            baud=baud,
            allow_restored=allow_restored,
            operator=operator,
            reconnect=reconnect,
        )
        return self._connected(target, options)

    def _connected(self, target: str | None, options: ConnectOptions) -> Arm:
        placed = self._meant(target, options)
        if placed.taken:
            raise ArmInUse(
                f"the arm that {target or 'this program'} means is held by another connection of "
                "this test: close that one, or place a second arm: arm_world.add(NAME)"
            )
        placed.twin.link.reopen()
        placed.arm = Arm(
            connect_simulated(
                placed.config,
                twin=placed.twin,
                pace=self.clock,
                operator=options.operator,
                recorder=placed.recorder,
                allow_restored=options.allow_restored,
                reconnect=options.reconnect,
            )
        )
        return placed.arm

    def _meant(self, target: str | None, options: ConnectOptions) -> Placed:
        """Return the arm that a program's connection leads to. Raises `BadRequest`."""
        if target in self._placed:
            return self._placed[target or ""]
        if self._placed and ONLY not in self._placed:
            raise BadRequest(
                f"no arm of this test is called {target!r}: {', '.join(self._placed)}; place it "
                f"with arm_world.add({target!r})"
            )
        asked = _known(target, options.dialect, options.baud)
        if not self._placed and self._target is None and asked is not None:
            return self._place(ONLY, asked.config, Stand(self._table))
        only = self._first()
        if asked is not None and not _alike(asked.config, only.config):
            raise BadRequest(
                f"the program connects to {asked.config.title} ({asked.config.connection.dialect}),"
                f" but this test has {only.config.title} ({only.config.connection.dialect}): mark "
                'it with @pytest.mark.armdrive(dialect="...") or (file="...")'
            )
        return only
