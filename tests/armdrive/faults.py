"""A wire that loses, garbles, repeats and delays lines by rule, and a spy on all that passes.

Wraps any in-process link. A rule holds for whole lines of one direction: it matches once, or as
often as it says, and turns the line into what arrives instead, each piece after a delay.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from armdrive.arm import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import LinkLost
from armdrive.registry.simulate import simulate
from armdrive.transports.link import Link
from kinematics import Joints

CR = b"\r"
Pieces = list[tuple[float, bytes]]
Change = Callable[[bytes], Pieces]
OVER_THE_TABLE = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)


def lost(line: bytes) -> Pieces:
    return []


def twice(line: bytes) -> Pieces:
    return [(0.0, line), (0.0, line)]


def echoed_after(delay_s: float) -> Change:
    return lambda line: [(0.0, line), (delay_s, line)]


def late_by(delay_s: float) -> Change:
    return lambda line: [(delay_s, line)]


def instead(*lines: bytes) -> Change:
    return lambda line: [(0.0, each) for each in lines]


def without_byte(index: int) -> Change:
    return lambda line: [(0.0, line[:index] + line[index + 1 :])]


def garbled(index: int, byte: int = 0x5A) -> Change:
    return lambda line: [(0.0, line[:index] + bytes([byte]) + line[index + 1 :])]


@dataclass
class Rule:
    starts: bytes
    change: Change
    skip: int = 0
    times: float = 1

    def applies(self, line: bytes) -> bool:
        if not line.startswith(self.starts) or self.times <= 0:
            return False
        if self.skip > 0:
            self.skip -= 1
            return False
        self.times -= 1
        return True


class FaultyLink(Link):
    """A link with rules for what goes `to` the arm and what comes `back`."""

    def __init__(self, inner):
        self.inner = inner
        self.to: list[Rule] = []
        self.back: list[Rule] = []
        self.sent: list[tuple[float, bytes]] = []
        self.overlaps: list[bytes] = []
        self.now_s = 0.0
        self._cut = False
        self._half = b""
        self._lines_due = 0
        self._arriving: Pieces = []
        self._leaving: Pieces = []
        self.on_write: Callable[[bytes], None] = lambda data: None

    @property
    def description(self):
        return self.inner.description

    @property
    def lines(self) -> list[bytes]:
        return [line for _, line in self.sent]

    def named(self, name: bytes) -> list[bytes]:
        return [line for line in self.lines if line.startswith(name)]

    def write(self, data, now_s):
        self._check(now_s)
        if self._lines_due:
            self.overlaps.append(data)
        self._lines_due = 2 if data.startswith(b"@READ") else 1
        self.sent.append((now_s, data))
        self.on_write(data)
        self._leaving += [(now_s + delay, piece) for delay, piece in _changed(self.to, data)]
        self._deliver(now_s)

    def read(self, now_s):
        self._check(now_s)
        self._deliver(now_s)
        *whole, self._half = (self._half + self.inner.read(now_s)).split(CR)
        for line in whole:
            pieces = _changed(self.back, line + CR)
            self._arriving += [(now_s + delay, piece) for delay, piece in pieces]
        ready = [piece for due, piece in self._arriving if due <= now_s]
        self._arriving = [entry for entry in self._arriving if entry[0] > now_s]
        data = b"".join(ready)
        self._lines_due = max(self._lines_due - data.count(CR), 0)
        if data.startswith((b"0", b"2")):
            self._lines_due = 0
        return data

    def next_s(self):
        waiting = [due for due, _ in (*self._arriving, *self._leaving)]
        return min([self.inner.next_s(), *waiting], default=math.inf)

    def forget_answers(self):
        """Tell the spy that the driver has given up on what it asked."""
        self._lines_due = 0

    def cut(self):
        self._cut = True

    def wait(self, timeout_s):
        self.inner.wait(timeout_s)

    def wake(self):
        self.inner.wake()

    def close(self):
        self.inner.close()

    def _deliver(self, now_s):
        due = [piece for at, piece in self._leaving if at <= now_s]
        self._leaving = [entry for entry in self._leaving if entry[0] > now_s]
        for piece in due:
            self.inner.write(piece, now_s)

    def _check(self, now_s):
        self.now_s = now_s
        if self._cut:
            raise LinkLost("the cable was pulled")


def _changed(rules: list[Rule], line: bytes) -> Pieces:
    for rule in rules:
        if rule.applies(line):
            return rule.change(line)
    return [(0.0, line)]


def sim_config(**motion):
    config = simulated_config("teachmover")
    return replace(config, motion=replace(config.motion, **motion))


def sim_arm(config=None, *, speed_error=0.0, blocks=(), at=None, **options) -> Arm:
    """Connect to a fresh twin over a faulty wire (`arm.twin.link`); `at` puts and references it."""
    config = config or simulated_config("teachmover")
    twin = simulate(config, blocks=blocks, speed_error=speed_error)
    if at is not None:
        twin.world.drive_to(twin.world.body.transmission.to_motors(at, 20.0))
    twin = replace(twin, link=FaultyLink(twin.link))
    arm = Arm(connect_simulated(config, twin=twin, **options))
    if at is not None:
        arm.declare_posture(at, opening_mm=20.0)
    return arm


def ready_arm(config=None, **options) -> Arm:
    """An arm that stands over the table, referenced."""
    return sim_arm(config, at=OVER_THE_TABLE, **options)


def as_it_stands(arm: Arm) -> Arm:
    """Reference an arm where its world has it, which takes no homing."""
    world = arm.twin.world
    arm.declare_posture(world.joints, opening_mm=world.opening_mm)
    return arm


def stand_still_s(arm, look_s=0.005):
    """Let time pass until the motors have stood still for a while; return when they stopped."""
    last, since_s = arm.twin.world.motors, arm.status.time_s
    while arm.status.time_s < since_s + 1.0:
        arm.sleep(look_s)
        if arm.twin.world.motors != last:
            last, since_s = arm.twin.world.motors, arm.status.time_s
    return since_s
