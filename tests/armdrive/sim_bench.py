"""A small host for a simulated TeachMover, and functions that move a simulated arm."""

import math
from dataclasses import dataclass, field

from armdrive.sim.device import SimDevice
from armdrive.sim.simulated_arm import link_to
from armdrive.sim.teachmover import TeachMoverBoard
from armdrive.sim.world import World
from firmware_protocol.teachmover import Command, Completed, Host, QDump
from kinematics.spaces import Pose

BYTE_S = 10 / 9600
GRASP_PITCH_DEG = -90.0


class SilentDevice:
    """A device that sends nothing, and keeps what it receives with the time."""

    byte_gap_s = 0.0

    def __init__(self) -> None:
        self.received: list[tuple[float, bytes]] = []

    def receive(self, data: bytes, now_s: float) -> None:
        self.received.append((now_s, data))

    def transmit(self, now_s: float) -> bytes:
        return b""

    def next_s(self) -> float:
        return math.inf


@dataclass
class Bench:
    """Sends one command at a time, and lets simulated time pass until the reply."""

    board: TeachMoverBoard = field(default_factory=TeachMoverBoard)
    now_s: float = 0.0

    def __post_init__(self) -> None:
        self.device = SimDevice(self.board)
        self.link = link_to(self.device)
        self.host = Host()

    def begin(self, command: Command) -> None:
        self.link.write(self.host.send(command), self.now_s)

    def finish(self) -> Completed:
        """Let time pass until the reply, and return it; fail if no event is left."""
        while True:
            event = self.host.next_event()
            if isinstance(event, Completed):
                return event
            assert event is None, event
            self.now_s = max(self.now_s, self.link.next_s())
            if math.isinf(self.now_s):
                assert isinstance(self.host.outstanding, QDump), "the device never answers"
                self.host.end_dump()
            else:
                self.host.receive_data(self.link.read(self.now_s))

    def ask(self, command: Command) -> Completed:
        self.begin(command)
        return self.finish()

    def pass_time(self, seconds: float) -> bytes:
        """Let time pass; return the bytes that arrived."""
        self.now_s += seconds
        return self.link.read(self.now_s)


def reach(world: World, x: float, y: float, z: float, opening: float | None = None) -> None:
    """Move the physical arm to a point with the hand down, and the fingers if asked to."""
    pose = Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=GRASP_PITCH_DEG)
    joints = world.body.arm.ik(pose, world.joints)
    _, pulled = world.body.transmission.to_joints(world.motors)
    wanted = pulled if opening is None else opening
    world.drive_to(world.body.transmission.to_motors(joints, wanted))


def descend(world: World, x: float, y: float, z: float, opening: float | None = None) -> None:
    """Lower the tip to a point from 100 mm above it, in a straight line."""
    reach(world, x, y, z + 100, opening)
    for step in range(1, 11):
        reach(world, x, y, z + 100 - 10 * step)


def grasp(world: World) -> None:
    """Close the fingers until the switch trips."""
    world.drive(world.steps_to_trip())


def spread(world: World, opening: float) -> None:
    """Open the fingers without moving anything else."""
    world.drive_to(world.body.transmission.to_motors(world.joints, opening))


def lift(world: World, height: float) -> None:
    """Raise the tip straight up; the fingers stay."""
    x, y, z = world.tip
    for step in range(1, 6):
        reach(world, x, y, z + height * step / 5)
