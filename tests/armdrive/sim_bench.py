"""Hosts of simulated devices on a serial line, and functions that move a simulated arm."""

from __future__ import annotations

import math
from typing import Any

from armdrive.sim.device import SimDevice
from armdrive.sim.robko01 import SimRobkoBoard
from armdrive.sim.simulated_arm import link_to
from armdrive.sim.teachmover import TeachMoverBoard
from armdrive.sim.wire import MemoryLink
from armdrive.sim.world import World
from firmware_protocol import robko01, teachmover
from kinematics.spaces import Pose

BYTE_S = 10 / 9600
GRASP_PITCH_DEG = -90.0


class SilentDevice:
    """A device that sends nothing, and keeps what it receives with the time."""

    def __init__(self) -> None:
        self.received: list[tuple[float, bytes]] = []

    def receive(self, data: bytes, now_s: float) -> None:
        self.received.append((now_s, data))

    def transmit(self, now_s: float) -> bytes:
        return b""

    def next_s(self) -> float:
        return math.inf


class WireBench:
    """A simulated device on its wire, in simulated time."""

    def __init__(self, device: SimDevice, link: MemoryLink | None = None) -> None:
        self.device, self.board, self.link = device, device.board, link or link_to(device)
        self.now_s = 0.0

    def send(self, data: bytes) -> None:
        self.link.write(data, self.now_s)

    def pass_time(self, seconds: float) -> bytes:
        """Let time pass; return the bytes that arrived."""
        self.now_s += seconds
        return self.link.read(self.now_s)


class TextBench(WireBench):
    """A simulated device that is told characters, and whose characters are read."""

    def send(self, text: str) -> None:
        super().send(text.encode("ascii"))

    def hear(self, seconds: float = 2.0) -> str:
        return self.pass_time(seconds).decode("ascii")

    def ask(self, text: str, seconds: float = 2.0) -> str:
        self.send(text)
        return self.hear(seconds)


class HostBench(WireBench):
    """A host at the other end: it sends one command at a time, and waits for the reply."""

    host: Any

    def begin(self, command: Any) -> None:
        self.send(self.host.send(command))

    def finish(self) -> Any:
        """Let time pass until the reply, and return it."""
        raise NotImplementedError

    def ask(self, command: Any) -> Any:
        self.begin(command)
        return self.finish()


class TeachMoverBench(HostBench):
    """A simulated TeachMover and its host."""

    def __init__(self, board: TeachMoverBoard | None = None) -> None:
        super().__init__(SimDevice(board or TeachMoverBoard()))
        self.host = teachmover.Host()

    def finish(self) -> teachmover.Completed:
        """Let time pass until the reply, and return it; fail if no event is left."""
        while True:
            event = self.host.next_event()
            if isinstance(event, teachmover.Completed):
                return event
            assert event is None, event
            self.now_s = max(self.now_s, self.link.next_s())
            if math.isinf(self.now_s):
                outstanding = self.host.outstanding
                assert isinstance(outstanding, teachmover.QDump), "the device never answers"
                (completed,) = self.host.end_dump()
                return completed
            self.host.receive_data(self.link.read(self.now_s))


class RobkoBench(HostBench):
    """A simulated Robko 01 and its host."""

    def __init__(self, board: SimRobkoBoard | None = None) -> None:
        super().__init__(SimDevice(board or SimRobkoBoard()))
        self.host = robko01.Host()

    def finish(self, longest_s: float = 1.0) -> robko01.Answer | None:
        """Let time pass until the reply, and return it; None without one."""
        until_s = self.now_s + longest_s
        while self.now_s < until_s:
            self.now_s = min(max(self.now_s, self.link.next_s()), until_s)
            self.host.receive_data(self.link.read(self.now_s))
            while (event := self.host.next_event()) is not None:
                if isinstance(event, robko01.Answered):
                    return event.answer
        self.host.forget()
        return None

    def enabled(self) -> RobkoBench:
        self.ask(robko01.Enable())
        return self


def axes(*steps: int, speed: int = 100) -> robko01.Axes:
    """Return a motion of the first axes at one speed; axes that stand get no speed."""
    steps = (*steps, *(0,) * (6 - len(steps)))
    return robko01.Axes(steps, tuple(speed if each else 0 for each in steps))


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
