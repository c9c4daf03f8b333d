"""A simulated arm whose wire delays and loses messages, and whose tip is recorded.

Everything runs in simulated time, so each figure is the same on every computer.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import assemble
from armdrive.registry import simulated_kind
from armdrive.runtime.clock import SimulatedPace
from armdrive.runtime.stop_bounds import StopBound
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.device import SimDevice, Value, chosen
from armdrive.sim.simulated_arm import TITLE, SimulatedArm
from armdrive.sim.wire import MemoryLink, Rule, Share, late
from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody
from armdrive.status import State
from kinematics import Joints, Motors

OPENING_MM = 20.0


class RecordingWorld(World):
    """A physical arm that records when it last moved, and how far its tip got from a point."""

    def __init__(self, body: ArmBody) -> None:
        self.moved_s = -math.inf
        self.mark: tuple[float, float, float] | None = None
        self.furthest_mm = 0.0
        self.sags = False
        super().__init__(body)

    def cut_current(self, time_s: float = 0.0) -> None:
        """Let the arm sag; no bound holds for a sag, which depends on the arm's weight."""
        self.sags = True
        super().cut_current(time_s)

    def _shift(self, steps: Motors, time_s: float) -> None:
        before = self._motors
        super()._shift(steps, time_s)
        if self._motors == before:
            return
        self.moved_s = time_s
        if self.mark is not None and not self.sags:
            self.furthest_mm = max(self.furthest_mm, math.dist(self.mark, self.tip))


class LossyLink(MemoryLink):
    """A wire that loses the messages that `loses` picks, and reports each."""

    loses: Callable[[bytes], bool] = staticmethod(lambda data: False)
    on_message: Callable[[bytes], None] = staticmethod(lambda data: None)

    def write(self, data: bytes, now_s: float) -> None:
        """Send bytes, unless they are lost."""
        self.on_message(data)
        super().write(b"" if self.loses(data) else data, now_s)

    def delay(self, by_s: float) -> None:
        """Delay all messages from now on."""
        every = Share(1.1, random.Random(0))
        self.line.faults.host.rules.append(Rule(late(by_s), every))


@dataclass(frozen=True, slots=True)
class StopResult:
    """The bounds announced when the cause struck, and what the physical arm did after it."""

    bound: StopBound
    time_s: float
    way_mm: float
    announced_s: float
    announced_mm: float

    @property
    def silent(self) -> StopResult:
        """The same with the bounds of a silent host."""
        bound = self.bound
        return replace(self, announced_s=bound.silent_time_s, announced_mm=bound.silent_distance_mm)

    @property
    def time_share(self) -> float:
        """The share of the announced time that the arm took."""
        return self.time_s / self.announced_s

    @property
    def way_share(self) -> float:
        """The share of the announced distance that the tip went."""
        return self.way_mm / self.announced_mm


class Stand:
    """One arm on its wire, switched on and referenced in a posture."""

    def __init__(self, config: ArmConfig, at: Joints, **options: Value) -> None:
        kind = simulated_kind(config.connection.dialect)
        self.world = RecordingWorld(ArmBody.of_preset(config.model))
        transmission = self.world.body.transmission
        there = transmission.to_motors(at, OPENING_MM)
        device = SimDevice(kind.make(config, self.world, chosen(kind.settings, options)))
        if isinstance(device.board, DrivesBoard):
            device.bring_to(at, OPENING_MM)
        else:
            self.world.drive_to(there)
        self.link = LossyLink(device.line(), TITLE)
        self.device = device
        self.pace = SimulatedPace()
        self.arm = Arm(assemble(config, self.link, self.pace, simulated=True))
        self.arm.twin = SimulatedArm.of(config, device, self.link)
        if self.arm.status.state is State.DISABLED:
            self.arm.enable()
        joints, opening_mm = transmission.to_joints(self.world.motors)
        self.arm.reference.declare(joints, opening_mm=opening_mm)

    @property
    def now_s(self) -> float:
        """The time of the driver's clock."""
        return self.pace.now_s()

    def mark(self) -> StopBound:
        """Start to measure here and now; return the announced bounds."""
        self.link.line.advance(self.now_s)
        self.world.mark, self.world.furthest_mm = self.world.tip, 0.0
        self.marked_s = self.world.moved_s = self.now_s
        return self.arm.parts.core.stop_bound()

    def stopped(self, bound: StopBound) -> StopResult:
        """Return how long and how far the arm has gone since `mark`."""
        return StopResult(
            bound,
            self.world.moved_s - self.marked_s,
            self.world.furthest_mm,
            bound.time_s,
            bound.distance_mm,
        )

    def abandon(self, for_s: float) -> None:
        """Let time pass for the arm alone, while its program is dead or suspended."""
        self.link.line.advance(self.now_s + for_s)
