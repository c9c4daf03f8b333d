"""`ArmWorld`: a table with blocks and simulated arms, to which every connection of a program leads.

Its truth is physical: what stands where, what the fingers really hold, and what was knocked over,
whatever the program and its controllers believe. All arms live on its one simulated clock.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import ExitStack
from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Any, Self

from armdrive.clock import SimulatedClock
from armdrive.connecting import connect_simulated
from armdrive.errors import ArmInUse, BadRequest
from armdrive.sim.blocks import Block
from armdrive.sim.table import Table
from armdrive.standins import standing_in
from armdrive.testing.places import Placed, Places

if TYPE_CHECKING:
    from armdrive.arm import Arm
    from armdrive.sim.faults import Faults
    from armdrive.sim.incidents import Incident
    from armdrive.sim.twin import Twin
    from kinematics import Joints, Pose


class ArmWorld:
    """A world for tests; within `with world:` every `connect` of this process leads into it.

    `arm_world.put("A", 250, 0)` places a block, in mm on the table, where the first arm's base is
    the origin. `pose`, `joints`, `opening_mm`, `held`, `faults` are those of the first arm; of
    others, those of `arms["right"]`.
    """

    def __init__(self, target: str | None = None) -> None:
        """`target` is what the arm is that nobody places by name: as `Arm.connect` takes it."""
        self.clock = SimulatedClock()
        self._table = Table()
        self._places = Places(self._table, target)
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
        for placed in self._places.all.values():
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
    ) -> Twin:
        """Place an arm at the table under the name by which the program connects to it.

        `target` says what it is, `"sim:grbl"` or an arm file; the base stands at (x, y), turned
        about the vertical. Options are those of the simulated controller. Raises `BadRequest`.
        """
        return self._places.add(name, target, (x_mm, y_mm, turned_deg), **options).twin

    @property
    def arms(self) -> Mapping[str, Twin]:
        """The simulated arms by their names; `.world` of each is its physical truth."""
        return MappingProxyType({name: each.twin for name, each in self._places.all.items()})

    def put(
        self,
        name: str,
        x_mm: float,
        y_mm: float,
        z_mm: float = 0.0,
        *,
        width_mm: float = 25.0,
        height_mm: float = 25.0,
    ) -> Block:
        """Set a block down, by the centre of its bottom; return where it came to rest."""
        return self._table.put(Block(name, x_mm, y_mm, z_mm, width_mm, height_mm))

    def take(self, name: str) -> Block | None:
        """Take a block away; None where there is none of that name."""
        return self._table.take(name)

    @property
    def blocks(self) -> Mapping[str, Block]:
        """Every block by its name, where it really is on the table."""
        return MappingProxyType(self._table.blocks)

    @property
    def incidents(self) -> tuple[Incident, ...]:
        """What went wrong, of all arms, in the order in which it happened."""
        found = [each for twin in self.arms.values() for each in twin.world.incidents]
        return tuple(sorted(found, key=lambda each: each.time_s))

    # -- the first arm ------------------------------------------------------------------------

    @property
    def twin(self) -> Twin:
        """The first arm: its controller, its wire and its world."""
        return self._places.first().twin

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

    def connect(self, target: str | None = None, **options: Any) -> Arm:
        """Connect as a program does whose `Arm.connect` leads here."""
        return self._connected(target, options)

    def _connected(self, target: str | None, options: Mapping[str, Any]) -> Arm:
        placed = self._places.meant(target, options.get("dialect"), options.get("baud"))
        if placed.taken:
            raise ArmInUse(
                f"the arm that {target or 'this program'} means is held by another connection of "
                "this test: close that one, or place a second arm: arm_world.add(NAME)"
            )
        return self._join(placed, options)

    def _join(self, placed: Placed, options: Mapping[str, Any]) -> Arm:
        placed.twin.link.reopen()
        placed.arm = connect_simulated(
            placed.config,
            twin=placed.twin,
            pace=self.clock,
            operator=options.get("operator"),
            recorder=placed.recorder,
            allow_restored=bool(options.get("allow_restored")),
            reconnect=options.get("reconnect"),
        )
        return placed.arm
