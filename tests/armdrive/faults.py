"""A wire that loses, garbles, repeats and delays messages by rule, and notes all that is sent.

Wraps any in-process link. A rule holds for whole messages of one direction, a line or a frame: it
matches once, or as often as it says, and turns the message into what arrives instead, each piece
after a delay.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace

from armdrive.arm import Arm
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import LinkLost
from armdrive.registry import simulate
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.status import State, Trust
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


def becoming(change: Callable[[bytes], bytes]) -> Change:
    return lambda message: [(0.0, change(message))]


@dataclass
class Rule:
    """What becomes of a message that a regular expression matches, after `skip` others."""

    starts: bytes
    change: Change
    skip: int = 0
    times: float = 1

    def applies(self, message: bytes) -> bool:
        if self.times <= 0 or not re.match(self.starts, message, re.DOTALL):
            return False
        if self.skip > 0:
            self.skip -= 1
            return False
        self.times -= 1
        return True


class DisturbedLink(Link):
    """A link with rules for the messages that go `to` the arm and come `back`.

    A dialect's link says which messages are `written` at once, and which whole ones stand at the
    beginning of what was `received`, with the bytes that are left over.
    """

    end = CR
    """What ends a line that comes back."""

    def __init__(self, inner):
        self.inner = inner
        self.to: list[Rule] = []
        self.back: list[Rule] = []
        self.sent: list[tuple[float, bytes]] = []
        self.on_write: Callable[[bytes], None] = lambda data: None
        self.arriving: Pieces = []
        self._leaving: Pieces = []
        self._half = b""
        self._cut = False

    def __getattr__(self, name):
        return getattr(self.inner, name)

    @property
    def description(self):
        return self.inner.description

    def written(self, data: bytes) -> list[bytes]:
        return [data]

    def received(self, data: bytes) -> tuple[list[bytes], bytes]:
        *whole, rest = data.split(self.end)
        return [line + self.end for line in whole], rest

    @property
    def messages(self) -> list[bytes]:
        return [message for _, message in self.sent]

    def named(self, name: bytes) -> list[bytes]:
        return [message for message in self.messages if message.startswith(name)]

    def write(self, data, now_s):
        self._check()
        for message in self.written(data):
            self.sent.append((now_s, message))
            self.on_write(message)
            self._leaving += _changed(self.to, message, now_s)
        self._deliver(now_s)

    def read(self, now_s):
        self._check()
        self._deliver(now_s)
        whole, self._half = self.received(self._half + self.inner.read(now_s))
        for message in whole:
            self.arriving += _changed(self.back, message, now_s)
        data = b"".join(piece for due_s, piece in self.arriving if due_s <= now_s)
        self.arriving = [entry for entry in self.arriving if entry[0] > now_s]
        return data

    def next_s(self):
        late = [due_s for due_s, _ in (*self.arriving, *self._leaving)]
        return min([self.inner.next_s(), *late])

    def cut(self):
        self._cut = True

    def wait(self, timeout_s):
        self.inner.wait(timeout_s)

    def wake(self):
        self.inner.wake()

    def close(self):
        self.inner.close()

    def _deliver(self, now_s):
        due = [piece for due_s, piece in self._leaving if due_s <= now_s]
        self._leaving = [entry for entry in self._leaving if entry[0] > now_s]
        for piece in due:
            self.inner.write(piece, now_s)

    def _check(self):
        if self._cut:
            raise LinkLost("the cable was pulled")


def _changed(rules: list[Rule], message: bytes, now_s: float) -> Pieces:
    """Return what arrives instead of a message, and when."""
    rule = next((each for each in rules if each.applies(message)), None)
    pieces = [(0.0, message)] if rule is None else rule.change(message)
    return [(now_s + delay_s, piece) for delay_s, piece in pieces]


class FaultyLink(DisturbedLink):
    """A TeachMover's wire, which also notes what was sent before the last answer had come."""

    def __init__(self, inner):
        super().__init__(inner)
        self.overlaps: list[bytes] = []
        self._lines_due = 0

    def write(self, data, now_s):
        self._check()
        if self._lines_due:
            self.overlaps.append(data)
        self._lines_due = 2 if data.startswith(b"@READ") else 1
        super().write(data, now_s)

    def read(self, now_s):
        data = super().read(now_s)
        self._lines_due = max(self._lines_due - data.count(CR), 0)
        if data.startswith((b"0", b"2")):
            self._lines_due = 0
        return data


def arm_config(
    dialect: str, device: dict | None = None, *, gripper: str = "", **motion
) -> ArmConfig:
    """Return a dialect's arm with other settings; a gripper of another kind has no motor."""
    made = simulated_config(dialect)
    if gripper:
        transmission = made.model.transmission
        assert transmission is not None
        made = replace(
            made,
            gripper=replace(made.gripper, kind=gripper),
            model=replace(made.model, transmission=transmission.without_gripper()),
        )
    return replace(
        made,
        motion=replace(made.motion, **motion),
        device=replace(made.device, **device) if device else made.device,
    )


def placed(twin: SimulatedArm, joints: Joints, opening_mm: float = 20.0) -> SimulatedArm:
    """Put a simulated arm into a posture. Drives on a bus count their shafts themselves."""
    if isinstance(twin.board, DrivesBoard):
        twin.device.bring_to(joints, opening_mm)
    else:
        twin.world.drive_to(twin.world.body.transmission.to_motors(joints, opening_mm))
    return twin


def driven(
    config: ArmConfig,
    *,
    at: Joints | None = OVER_THE_TABLE,
    referenced: bool = True,
    link: type[DisturbedLink] | None = None,
    connect: dict | None = None,
    **options,
) -> Arm:
    """Connect to a fresh twin in a posture; switch it on and reference it there.

    `link` is put before the driver, as `arm.twin.link`, and forgets what contact has sent.
    `connect` are options of the connection, the others are those of the twin.
    """
    twin = simulate(config, **options)
    if at is not None:
        placed(twin, at)
    if link is not None:
        twin = replace(twin, link=link(twin.link))
    arm = Arm(connect_simulated(config, twin=twin, **(connect or {})))
    if at is not None and referenced:
        if arm.status.state is State.DISABLED:
            arm.enable()
        arm.reference.declare(at, opening_mm=20.0)
        if link is not None:
            arm.twin.link.sent.clear()
    return arm


def sim_config(**motion) -> ArmConfig:
    return arm_config("teachmover", **motion)


def sim_arm(config=None, *, speed_error=0.0, blocks=(), at=None, **connect) -> Arm:
    """Connect to a fresh TeachMover over a faulty wire; `at` puts and references it."""
    options = {"link": FaultyLink, "connect": connect, "speed_error": speed_error}
    return driven(config or sim_config(), at=at, blocks=blocks, **options)


def ready_arm(config=None, **options) -> Arm:
    """A TeachMover that stands over the table, referenced."""
    return sim_arm(config, at=OVER_THE_TABLE, **options)


def honest(arm: Arm) -> bool:
    """Tell whether an arm stands where it is said to stand, or is not believed to."""
    status = arm.status
    return status.trust is not Trust.REFERENCED or arm.twin.world.motors == status.acknowledged


def as_it_stands(arm: Arm) -> Arm:
    """Switch an arm on, and reference it where its world has it, which takes no homing."""
    if arm.status.state is State.DISABLED:
        arm.enable()
    world = arm.twin.world
    arm.reference.declare(world.joints, opening_mm=world.opening_mm)
    return arm


def standing(dialect: str) -> Arm:
    """Return a simulated arm of a dialect, referenced where it stands."""
    return as_it_stands(Arm.connect(f"sim:{dialect}"))


def stand_still_s(arm, look_s=0.005, quiet_s=1.0):
    """Let time pass until the motors have stood still for a while; return when they stopped."""
    last, since_s = arm.twin.world.motors, arm.status.time_s
    while arm.status.time_s < since_s + quiet_s:
        arm.sleep(look_s)
        if arm.twin.world.motors != last:
            last, since_s = arm.twin.world.motors, arm.status.time_s
    return since_s
