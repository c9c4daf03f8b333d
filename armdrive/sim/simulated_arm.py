"""A simulated arm in one process: its world, its controller, the link to it and its operator."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Self

from armdrive.config.arm import ArmConfig
from armdrive.dialog import PostureRequest
from armdrive.errors import BadRequest
from armdrive.sim.device import Board, NoSettings, SavedDevice, SimDevice, Value, chosen
from armdrive.sim.wire import MemoryLink
from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody, play_of
from armdrive.sim.world.saved import Json, restored, unfit, world_from_json
from armdrive.sim.world.table import Stand, TableBlock
from kinematics.spaces import Joints, Motors

if TYPE_CHECKING:
    from armdrive.sim.faults import Faults

# --- The operator --------------------------------------------------------------------------------
# The operator does what a person would: looks at the physical posture, which no register holds,
# raises the hand over the mark, and then lowers it, jogging through the driver. Motors with
# backlash approach the posture from one side.

LIFT_MM = 60.0  # above the mark, before the hand is lowered onto it
LOOKS = 4  # how often the operator looks and corrects
# How far past the goal to jog a motor before coming back, in multiples of its backlash.
SIDE = 2
# The posture error that an operator can see.
SEEN_RAD = math.radians(1.0)


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedOperator:
    """Answers `home` for a simulated arm. It cannot lift an arm whose motors have no current."""

    world: World
    backlash_steps: tuple[int, ...] = ()
    """The backlash that the driver compensates, from the arm file."""

    def __call__(self, request: PostureRequest) -> bool:
        """Bring the arm to the posture. Returns True once it stands there to the step."""
        arm = request.arm.model.arm
        pose = request.pose
        above = replace(pose, z_mm=pose.z_mm + LIFT_MM)
        self._bring(request, arm.ik(above))
        if widths := self.backlash_steps:
            request.arm.move_motors(*(-SIDE * width for width in widths), speed=1.0)
            request.arm.move_motors(*(SIDE * width for width in widths), speed=1.0)
        return any(not self._bring(request, request.joints).largest for _ in range(LOOKS))

    def stands_at(self, joints: Joints) -> bool:
        """Return whether the physical arm stands in a drawn posture."""
        return all(
            abs(seen - drawn) <= SEEN_RAD
            for seen, drawn in zip(self.world.joints, joints, strict=True)
        )

    def _bring(self, request: PostureRequest, joints: Joints) -> Motors:
        """Jog towards a posture; return the number of steps still missing."""
        transmission = self.world.body.transmission
        missing = transmission.to_motors(joints, request.opening_mm) - self.world.motors
        if missing.largest:
            request.arm.move_motors(*missing, speed=1.0)
        return missing


# --- The device, made again from what `to_json` wrote --------------------------------------------


def recalled(
    data: object,
    make: Callable[[World], Board],
    body: ArmBody,
    what: str = "device",
) -> SimDevice:
    """Recreate the world and the device. Raises `StateFileError` if the saved data do not fit."""
    if not isinstance(data, Mapping):
        raise unfit(f"the saved {what} is no table")
    names = {each.name for each in fields(SavedDevice)}
    of_device = {key: value for key, value in data.items() if key in names}
    of_board = {key: value for key, value in data.items() if key not in names}
    saved = restored(SavedDevice, of_device, what)
    board = make(world_from_json(saved.world, body))
    device = SimDevice(board)
    device.recall(saved, restored(board.saved_as, of_board, what))
    return device


# The key of a saved world that names the dialect.
DIALECT = "dialect"
# The name that links give to the far end of the wire.
TITLE = "simulated arm"


@dataclass(slots=True, eq=False)
class SimulatedArm:
    """The simulated counterpart of a connected arm. `world` is the physical truth."""

    dialect: str
    device: SimDevice
    link: MemoryLink
    operator: SimulatedOperator
    device_link: MemoryLink
    """The link on which faults act: `link` itself, or the one behind it if a test replaces that."""
    _faults: Faults | None = field(default=None, init=False)

    @classmethod
    def of(cls, config: ArmConfig, device: SimDevice, link: MemoryLink | None = None) -> Self:
        """Return the counterpart of an arm, on a new link or on the given one."""
        operator = SimulatedOperator(device.world, backlash_steps=config.backlash_steps)
        link = link or link_to(device)
        return cls(config.connection.dialect, device, link, operator, link)

    @property
    def faults(self) -> Faults:
        """Makes things go wrong: `twin.faults.add("drop", 0.01, side="host")`."""
        from armdrive.sim.faults import Faults, link_cable  # loaded only for faults

        if self._faults is None:
            link = self.device_link
            self._faults = Faults(self.device, link.line, link_cable(link))
        return self._faults

    @property
    def board(self) -> Board:
        """The board of the device."""
        return self.device.board

    @property
    def world(self) -> World:
        """The physical arm and its surroundings."""
        return self.device.world

    def save(self) -> dict[str, Json]:
        """Return the dialect, the world and the controller's memory as plain data."""
        return {DIALECT: self.dialect, **self.device.to_json()}


def link_to(device: SimDevice) -> MemoryLink:
    """Return an in-process link to a device."""
    return MemoryLink(device.line(), TITLE)


@dataclass(frozen=True, slots=True, eq=False)
class SimDeviceKind:
    """How to build the simulated device of one dialect, and its settings: a dataclass.

    `make(config, world, settings)` builds the board as it is just after power-on. A saved board is
    built the same way and then restored. `board` is the board's class, which states what abilities
    it has.
    """

    board: type[Board]
    make: Callable[[ArmConfig, World, Any], Board]
    settings: type[Any] = NoSettings

    def simulate(
        self,
        config: ArmConfig,
        saved: object = None,
        *,
        blocks: Iterable[TableBlock] = (),
        play: int | Sequence[int] | None = None,
        stand: Stand | None = None,
        settings: Mapping[str, Value] | None = None,
    ) -> SimulatedArm:
        """Build the counterpart of an arm: restored from `saved`, or as after a cold start.

        `play` is the backlash in steps, for every motor or for each; by default it is the backlash
        that the arm file has the driver compensate. `stand` places the arm on a table shared with
        others, which is not possible for a saved world. `settings` are the device's own, such as
        `speed_error=0.2`. Raises `StateFileError` if the saved data do not fit this arm, and
        `BadRequest` for any other mistake.
        """
        body = ArmBody.of_preset(config.model)
        widths = (
            config.backlash_steps if play is None else play_of(play, len(body.transmission.motors))
        )
        body = replace(body, play=widths)
        own = chosen(self.settings, settings or {})
        if saved is None:
            board = self.make(config, World(body, blocks=blocks, stand=stand), own)
            return SimulatedArm.of(config, SimDevice(board))
        if stand is not None:
            raise BadRequest("a saved world has a table of its own: it cannot be put on another")
        known = _of_dialect(saved, config.connection.dialect)
        what = f"simulated {self.board.title}"
        device = recalled(known, lambda world: self.make(config, world, own), body, what)
        return SimulatedArm.of(config, device)


def _of_dialect(saved: object, dialect: str) -> object:
    """Return a saved world without its dialect entry. Raises unless the dialect is this one."""
    if not isinstance(saved, Mapping):
        return saved
    spoken = saved.get(DIALECT)
    if spoken != dialect:
        raise unfit(f"the saved arm speaks {spoken!r}, not {dialect!r}: they share nothing")
    return {key: value for key, value in saved.items() if key != DIALECT}
