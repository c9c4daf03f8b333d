"""A small host on a simulated Robko's wire, a wire that spoils frames by rule, and ready arms."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

from armdrive.arm import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.registry.simulate import simulate
from armdrive.sim.device import SimDevice
from armdrive.sim.robko01.device import SimRobkoBoard
from armdrive.sim.simulated_arm import link_to
from armdrive.transports.link import Link
from firmware_protocol.robko01 import Answer, Answered, Axes, Enable, Host, Op, Request
from kinematics import Joints

AA = 0xAA
OVER_THE_TABLE = Joints.of(0.0, 40.0, -80.0, -40.0, 0.0)


@dataclass
class RobkoBench:
    """Sends one request at a time and lets simulated time pass until its answer."""

    board: SimRobkoBoard = field(default_factory=SimRobkoBoard)
    now_s: float = 0.0

    def __post_init__(self) -> None:
        self.device = SimDevice(self.board)
        self.link = link_to(self.device)
        self.host = Host()

    def begin(self, request: Request) -> None:
        self.link.write(self.host.send(request), self.now_s)

    def finish(self, longest_s: float = 1.0) -> Answer | None:
        """Let time pass until the request is answered; None where it never is."""
        until_s = self.now_s + longest_s
        while self.now_s < until_s:
            self.now_s = min(max(self.now_s, self.link.next_s()), until_s)
            self.host.receive_data(self.link.read(self.now_s))
            while (event := self.host.next_event()) is not None:
                if isinstance(event, Answered):
                    return event.answer
        self.host.forget()
        return None

    def ask(self, request: Request) -> Answer | None:
        self.begin(request)
        return self.finish()

    def enabled(self) -> RobkoBench:
        self.ask(Enable())
        return self

    def let_pass(self, seconds: float) -> bytes:
        """Let time pass and return what was said."""
        self.now_s += seconds
        return self.link.read(self.now_s)


def axes(*steps: int, speed: int = 100) -> Axes:
    """Return a motion of the first axes, all at one speed; those that rest get none."""
    steps = (*steps, *(0,) * (6 - len(steps)))
    return Axes(steps, tuple(speed if each else 0 for each in steps))


@dataclass
class FrameRule:
    op: Op
    change: Callable[[bytes], list[tuple[float, bytes]]]
    skip: int = 0
    times: float = 1

    def applies(self, op: int) -> bool:
        if op != self.op or self.times <= 0:
            return False
        if self.skip > 0:
            self.skip -= 1
            return False
        self.times -= 1
        return True


class FrameLink(Link):
    """A link with rules for the frames that go `to` the arm and come `back`; it spies on them."""

    def __init__(self, inner):
        self.inner = inner
        self.to: list[FrameRule] = []
        self.back: list[FrameRule] = []
        self.ops: list[Op] = []
        self.on_write: Callable[[Op], None] = lambda op: None
        self._half = b""
        self._arriving: list[tuple[float, bytes]] = []
        self._leaving: list[tuple[float, bytes]] = []

    @property
    def description(self):
        return self.inner.description

    def count(self, *ops: Op) -> int:
        return sum(op in ops for op in self.ops)

    def write(self, data, now_s):
        op = Op(data[data.index(AA) + 3])
        self.ops.append(op)
        self.on_write(op)
        self._leaving += [(now_s + late_s, piece) for late_s, piece in changed(self.to, op, data)]
        self._deliver(now_s)

    def read(self, now_s):
        self._deliver(now_s)
        self._half += self.inner.read(now_s)
        while len(self._half) >= 5 and len(self._half) >= (size := self._half[2] + 5):
            frame, self._half = self._half[:size], self._half[size:]
            pieces = changed(self.back, frame[3], frame)
            self._arriving += [(now_s + late_s, piece) for late_s, piece in pieces]
        ready = b"".join(piece for due_s, piece in self._arriving if due_s <= now_s)
        self._arriving = [entry for entry in self._arriving if entry[0] > now_s]
        return ready

    def next_s(self):
        waiting = [due_s for due_s, _ in (*self._arriving, *self._leaving)]
        return min([self.inner.next_s(), *waiting])

    def wait(self, timeout_s):
        self.inner.wait(timeout_s)

    def wake(self):
        self.inner.wake()

    def close(self):
        self.inner.close()

    def _deliver(self, now_s):
        due = [piece for at_s, piece in self._leaving if at_s <= now_s]
        self._leaving = [entry for entry in self._leaving if entry[0] > now_s]
        for piece in due:
            self.inner.write(piece, now_s)


def changed(rules, op, frame):
    for rule in rules:
        if rule.applies(op):
            return rule.change(frame)
    return [(0.0, frame)]


def robko_config(*, device=None, **motion):
    config = simulated_config("robko01")
    settings = replace(config.device, **(device or {}))
    return replace(config, motion=replace(config.motion, **motion), device=settings)


def robko_arm(config=None, **options) -> Arm:
    """Connect to a fresh twin that stands over the table, its motors still off."""
    config = config or robko_config()
    twin = simulate(config, **options)
    body = twin.world.body
    twin.world.drive_to(body.transmission.to_motors(OVER_THE_TABLE, 20.0))
    twin = replace(twin, link=FrameLink(twin.link))
    return Arm(connect_simulated(config, twin=twin))


def ready_robko(config=None, **options) -> Arm:
    """An arm that stands over the table, its motors on, referenced."""
    arm = robko_arm(config, **options)
    arm.enable()
    arm.declare_posture(OVER_THE_TABLE, opening_mm=20.0)
    arm.twin.link.ops.clear()
    return arm
