"""`ArmWorld`: a table with blocks and simulated arms, for tests of programs.

Every connection of the tested program leads to these arms. The world is physical: it says where
blocks are, what the fingers really hold, and what was knocked over, whatever the program and its
controllers assume. All arms share one simulated clock.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from types import MappingProxyType, TracebackType
from typing import Any, Self

from armdrive.arm import Arm, override_connections
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import ConnectOptions, connect_simulated
from armdrive.connect.target import DEFAULT_TARGET, Target, find
from armdrive.errors import ArmFileError, ArmInUse, BadRequest
from armdrive.errors.arguments import BASIC, Rule, call, checked_calls, known_attributes, made_of
from armdrive.registry import simulate
from armdrive.runtime.clock import SimulatedClock
from armdrive.sim.faults import Faults
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.sim.world.table import Incident, Stand, Table, TableBlock
from armdrive.storage.record import RecordInMemory
from kinematics.spaces import Joints, Pose

ONLY = "arm"  # the name of the default arm, in a world to which no arm was added


@dataclass(slots=True)
class Placed:
    """A simulated arm at the table, with its record and its latest connection."""

    config: ArmConfig
    twin: SimulatedArm
    record: RecordInMemory = field(default_factory=RecordInMemory)
    arm: Arm | None = None

    @property
    def taken(self) -> bool:
        """Whether a connection to the arm is open."""
        return self.arm is not None and not self.arm.closed


def _known(target: str | None, dialect: str | None, baud: int | None) -> Target | None:
    """Return the program's target; None for an arm file that this computer does not have."""
    if target is None:
        return None
    try:
        return find(target, dialect_name=dialect, baud=baud)
    except (ArmFileError, BadRequest):
        if not target or target.startswith("sim:") or target.endswith(".toml"):
            raise
        return None


_NAME = made_of(str, "the name of an arm", f'"{DEFAULT_TARGET}"')
# The checks of the arguments of an `ArmWorld`'s calls, by annotation.
RULES: Mapping[str, Rule] = MappingProxyType(
    {
        **BASIC,
        "Callable[[], object]": call,
        "target: str": _NAME,
    }
)


@known_attributes
@checked_calls(RULES)
class ArmWorld:
    """A world for tests. Inside `with world:`, every `connect` of this process leads to its arms.

    `arm_world.put("A", 250, 0)` places a block on the table; positions are in mm from the first
    arm's base. `pose`, `joints`, `opening_mm`, `held` and `faults` describe the first arm;
    `arms["right"]` gives access to another one. If no arm was added, one is created when needed.
    """

    def __init__(self, target: str | None = None) -> None:
        """`target` describes the default arm, as in `Arm.connect`.

        Without it, the default arm is the one that the program connects to, or the simulated
        TeachMover if this computer has no arm file of that name. Raises `BadRequest`, or
        `ArmFileError` for an unusable arm file.
        """
        self.clock = SimulatedClock()
        self._table = Table()
        # Found here and not at the first connection: a test may never connect.
        self._chosen = None if target is None else find(str(_NAME("target", target))).config
        self._placed: dict[str, Placed] = {}
        self._open = ExitStack()

    def __enter__(self) -> Self:
        self._open.enter_context(override_connections(self._connected))
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._open.close()
        for placed in self._placed.values():
            if placed.arm is not None:
                placed.arm.close()

    # -- arms and blocks ----------------------------------------------------------------------

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
        """Place an arm at the table; `name` is the target with which the program connects.

        `target` is a simulated arm such as `"sim:grbl"`, or an arm file. The base stands at (x, y)
        and is turned about the vertical axis. `options` go to the simulated controller. Raises
        `BadRequest`.
        """
        if name in self._placed:
            raise BadRequest(f"an arm called {name!r} already stands at the table")
        chosen = self._chosen if target is None else None
        config = chosen or find(DEFAULT_TARGET if target is None else target).config
        stand = Stand(self._table, x_mm, y_mm, math.radians(turned_deg))
        return self._place(name, config, stand, **options).twin

    def _place(self, name: str, config: ArmConfig, stand: Stand, **options: Any) -> Placed:
        self._placed[name] = Placed(config, simulate(config, stand=stand, **options))
        return self._placed[name]

    @property
    def arms(self) -> Mapping[str, SimulatedArm]:
        """The simulated arms by name; `.world` of each is its physical state."""
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
        """Put a block down, with its bottom's centre at x, y, z; return the block at rest.

        A block of that name is moved there, even out of the fingers.
        """
        return self._table.put(TableBlock(name, x_mm, y_mm, z_mm, width_mm, height_mm))

    def take(self, name: str) -> TableBlock:
        """Remove and return a block, even out of the fingers. Raises `BadRequest` if none is it."""
        return self._table.take(name)

    @property
    def blocks(self) -> Mapping[str, TableBlock]:
        """The blocks by name, at their real positions."""
        return MappingProxyType(self._table.blocks)

    @property
    def incidents(self) -> tuple[Incident, ...]:
        """The incidents of all arms, such as a block knocked over, in order of time."""
        found = [each for twin in self.arms.values() for each in twin.world.incidents]
        return tuple(sorted(found, key=lambda each: each.time_s))

    # -- the first arm ------------------------------------------------------------------------

    @property
    def twin(self) -> SimulatedArm:
        """The first simulated arm: its controller, its wire and its world."""
        return self._first().twin

    def _first(self) -> Placed:
        """Return the first arm; create it if there is none."""
        if not self._placed:
            self.add(ONLY)
        return next(iter(self._placed.values()))

    @property
    def pose(self) -> Pose:
        """The tip's real pose, in the frame of the arm's base."""
        return self.twin.world.pose

    @property
    def joints(self) -> Joints:
        """The real joint angles."""
        return self.twin.world.joints

    @property
    def opening_mm(self) -> float:
        """The real distance between the fingers."""
        return self.twin.world.opening_mm

    @property
    def held(self) -> str | None:
        """The name of the block that the fingers really hold."""
        return self.twin.world.scene.held

    @property
    def faults(self) -> Faults:
        """The injected faults of the arm and its wire: `arm_world.faults.add("drop", 0.01)`."""
        return self.twin.faults

    def set_input(self, number: int, on: bool = True) -> None:
        """Switch an input of the controller, counted from 1. Raises `BadRequest`."""
        self.twin.device.set_input(number - 1, on)

    def after(self, by_s: float, action: Callable[[], object]) -> None:
        """Run `action` after a delay: `arm_world.after(5, lambda: world.take("A"))`."""
        device = self.twin.device
        device.at(max(device.now_s, self.clock.now_s) + by_s, action)

    # -- connections --------------------------------------------------------------------------

    def connect(self) -> Arm:
        """Connect as a program does that names no arm."""
        return self._connected(None, ConnectOptions())

    def _connected(self, target: str | None, options: ConnectOptions) -> Arm:
        """Connect to an arm of this world, in the place of `Arm.connect`."""
        placed = self._meant(target, options)
        if placed.taken:
            raise ArmInUse(
                f"the arm for {target or 'this program'} is in use by another connection of this "
                "test: close that connection, or place a second arm with arm_world.add(NAME)"
            )
        # the same physical arm as before: a new connection finds it where the last one left it
        placed.twin.link.reopen()
        placed.arm = Arm(
            connect_simulated(
                placed.config,
                twin=placed.twin,
                pace=self.clock,
                operator=options.operator,
                record_store=placed.record,
                allow_restored=options.allow_restored,
                reconnect=options.reconnect,
            )
        )
        return placed.arm

    def _meant(self, target: str | None, options: ConnectOptions) -> Placed:
        """Return the arm for a program's connection. Raises `BadRequest`."""
        if target in self._placed:
            return self._placed[target or ""]
        if self._placed and ONLY not in self._placed:
            raise BadRequest(
                f"no arm of this test is called {target!r}: {', '.join(self._placed)}; place it "
                f"with arm_world.add({target!r})"
            )
        asked = _known(target, options.dialect, options.baud)
        if not self._placed and self._chosen is None and asked is not None:
            return self._place(ONLY, asked.config, Stand(self._table))
        only = self._first()
        if asked is not None:
            theirs, ours = asked.config, only.config
            spoken, here = theirs.connection.dialect, ours.connection.dialect
            if (spoken, theirs.calibration) != (here, ours.calibration):
                raise BadRequest(
                    f"the program connects to {theirs.title} ({spoken}), but this test has "
                    f'{ours.title} ({here}): mark it with @pytest.mark.armdrive(dialect="...") or '
                    '(file="...")'
                )
        return only
