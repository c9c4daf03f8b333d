"""A simulated arm for one process: its world, its controller, the wire to it, and its operator."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Self

from armdrive.config.arm import ArmConfig
from armdrive.dialog.operator import PostureRequest
from armdrive.errors import BadRequest, StateFileError
from armdrive.sim.device import Board, Option, Options, SimDevice, Value
from armdrive.sim.wire import PacedDevice
from armdrive.sim.world.arm import World
from armdrive.sim.world.body import ArmBody, play_of
from armdrive.sim.world.saved import MEND, Json, Saved, world_from_json
from armdrive.sim.world.table import Stand, TableBlock
from armdrive.transports.in_process import MemoryLink
from kinematics.spaces import Joints, Motors

if TYPE_CHECKING:
    from armdrive.sim.faults.table import Faults

# --- The operator --------------------------------------------------------------------------------
#
# The operator does what a person would: looks at the physical posture, which no register knows,
# first lifts the hand over the mark, then lowers it, in steps of the arm's own motors through the
# driver. Motors with backlash are brought there from one side.

LIFT_MM = 60.0
LOOKS = 4
SIDE = 2
"""How many times its backlash he turns a motor away, and back again."""
SEEN_RAD = math.radians(1.0)
"""How well he can see whether an arm stands as it is drawn."""


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedOperator:
    """Answers `home` for a simulated arm. He cannot lift an arm whose motors have no current."""

    world: World
    speed: float = 1.0
    backlash_steps: tuple[int, ...] = ()
    """What the driver takes up, by the arm file."""

    def __call__(self, request: PostureRequest) -> bool:
        """Bring the arm to the posture; True when it stands there to the step."""
        arm = request.arm.model.arm
        pose = request.pose
        above = replace(pose, z_mm=pose.z_mm + LIFT_MM)
        self._bring(request, arm.ik(above))
        if widths := self.backlash_steps:
            request.arm.move_motors(*(-SIDE * width for width in widths), speed=self.speed)
            request.arm.move_motors(*(SIDE * width for width in widths), speed=self.speed)
        return any(not self._bring(request, request.joints).largest for _ in range(LOOKS))

    def stands_at(self, joints: Joints) -> bool:
        """Compare the physical arm with a drawn posture."""
        return all(
            abs(seen - drawn) <= SEEN_RAD
            for seen, drawn in zip(self.world.joints, joints, strict=True)
        )

    def _bring(self, request: PostureRequest, joints: Joints) -> Motors:
        """Jog towards a posture; return the steps that were missing."""
        transmission = self.world.body.transmission
        missing = transmission.to_motors(joints, request.opening_mm) - self.world.motors
        if missing.largest:
            request.arm.move_motors(*missing, speed=self.speed)
        return missing


# --- The device, made again from what `to_json` wrote --------------------------------------------


def recalled(
    data: object,
    make: Callable[[World], Board],
    body: ArmBody | None = None,
    *,
    what: str = "device",
) -> SimDevice:
    """Make the world and the device again; `StateFileError` for what no such device has saved."""
    saved = Saved(data, what)
    device = SimDevice(make(world_from_json(saved.table("world").data, body)))
    device.recall(saved)
    saved.end()
    return device


DIALECT = "dialect"
"""The entry of a saved world that names the dialect."""
TITLE = "simulated arm"
"""What links call the far end of their wire."""


@dataclass(slots=True, eq=False)
class SimulatedArm:
    """The simulated counterpart of a connected arm. `world` is the physical truth."""

    dialect: str
    device: SimDevice
    link: MemoryLink[PacedDevice]
    operator: SimulatedOperator
    wire: MemoryLink[PacedDevice]
    """What faults befall: the link itself, or the one that it was put in front of."""
    _faults: Faults | None = field(default=None, init=False)

    @classmethod
    def of(
        cls, config: ArmConfig, device: SimDevice, link: MemoryLink[PacedDevice] | None = None
    ) -> Self:
        """Return an arm's counterpart with a device, on a link of its own or on this one."""
        operator = SimulatedOperator(device.world, backlash_steps=config.backlash_steps)
        wire = link or link_to(device)
        return cls(config.connection.dialect, device, wire, operator, wire)

    @property
    def faults(self) -> Faults:
        """Makes things go wrong: `twin.faults.add("drop", 0.01, side="host")`."""
        from armdrive.sim.faults.table import Faults, link_cable  # nothing goes wrong by itself

        if self._faults is None:
            self._faults = Faults(self.device, self.wire.line, link_cable(self.wire))
        return self._faults

    @property
    def board(self) -> Board:
        """The board of its device."""
        return self.device.board

    @property
    def world(self) -> World:
        """The physical arm and what is around it."""
        return self.device.world

    def save(self) -> dict[str, Json]:
        """Return the dialect, the world and the controller's memory as plain data."""
        return {DIALECT: self.dialect, **self.device.to_json()}


def link_to(device: SimDevice) -> MemoryLink[PacedDevice]:
    """Return a wire within this process to a device."""
    return MemoryLink(device.line(), TITLE)


@dataclass(frozen=True, slots=True, eq=False)
class SimDeviceKind:
    """How the simulated device of one dialect is made, and what can be set of it.

    `make(config, world, options)` builds its board as it stands when its power has come; a saved
    one is made the same way and then recalls what it knew. `board` is the board's class, which
    tells what it is able to do.
    """

    title: str
    board: type[Board]
    make: Callable[[ArmConfig, World, Options], Board]
    options: tuple[Option, ...] = ()

    def twin(self, config: ArmConfig, device: SimDevice) -> SimulatedArm:
        """Return the counterpart of an arm, with its device on a wire within this process."""
        return SimulatedArm.of(config, device)

    def simulate(
        self,
        config: ArmConfig,
        saved: object = None,
        *,
        blocks: Iterable[TableBlock] = (),
        play: int | Sequence[int] | None = None,
        stand: Stand | None = None,
        settings: Mapping[str, Value] | None = None,
    ) -> SimDevice:
        """Build the simulated device: as it was saved, or as one finds it in the morning.

        `play` is the lost motion of every motor's train, or of each, in steps: without it, the
        backlash of the arm file, which is what the driver takes up. `stand` puts the arm on a table
        with others, which a saved world cannot be put on. `settings` are those of its device,
        `speed_error=0.2` say. Raises `StateFileError` where what was saved fits no such arm, and
        `BadRequest` for the rest.
        """
        body = ArmBody.of_preset(config.model)
        widths = (
            config.backlash_steps if play is None else play_of(play, len(body.transmission.motors))
        )
        body = replace(body, play=widths)
        chosen = Options(self.options, settings)
        if saved is None:
            return SimDevice(self.make(config, World(body, blocks=blocks, stand=stand), chosen))
        if stand is not None:
            raise BadRequest("a saved world has a table of its own: it cannot be put on another")
        known = _of_dialect(saved, config.connection.dialect)
        what = f"simulated {self.title}"
        return recalled(known, lambda world: self.make(config, world, chosen), body, what=what)


def _of_dialect(saved: object, dialect: str) -> object:
    """Return a saved world without its dialect, which must be this one."""
    if not isinstance(saved, Mapping):
        return saved
    spoken = saved.get(DIALECT)
    if spoken != dialect:
        raise StateFileError(
            f"the saved arm speaks {spoken!r}, not {dialect!r}: they have nothing in common; {MEND}"
        )
    return {key: value for key, value in saved.items() if key != DIALECT}
