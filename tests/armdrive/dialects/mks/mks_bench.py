"""Drives on a bus of their own, each a codec's device on a simple motor, and a driver's end."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

from driver_bench import DriverBench

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.dialects.mks.controller import MksController
from armdrive.dialects.mks.settings import MksSettings
from armdrive.registry import DIALECTS
from armdrive.sim.mechanics.shafts import ShaftPoint
from armdrive.sim.mks.motion import state_of
from armdrive.tasks import MoveAlong, MoveBy
from firmware_protocol import mks
from firmware_protocol.frames import Frame, Unpacker, pack
from kinematics import Motors, preset

WIRE_S = 0.0003
LATEST = (1, 0, 9)
AHEAD_S = 0.3
SEGMENT_S = 0.1
BURSTS = {"segment_s": 0.0}
FAR_FROM_ZERO = (50_000,) * 6
"""Near zero a drive that was away may have restarted."""
WAY = (6000, -3000, 1500, 0, 700, 20)


class MksSetPoint(ShaftPoint):
    """A set-point in the drive's own measures."""

    def move_to(self, goal: int, rpm: float, acc: int, now_s: float) -> None:
        self.go_to(goal, rpm * mks.COUNTS_S_PER_RPM, mks.slope_of(acc), now_s)

    def run(self, rpm: float, acc: int, now_s: float) -> None:
        self.go_at(rpm * mks.COUNTS_S_PER_RPM, mks.slope_of(acc), now_s)


class Node:
    """A drive that does as the manual says; its faults are fields."""

    def __init__(self, node: int, firmware=LATEST, at: int = 0) -> None:
        self.device = mks.Device(node, firmware)
        self.firmware = firmware
        self.motor = MksSetPoint(at)
        self.settings = {
            mks.Code.MODE: mks.SetMode(mks.Mode.BUS_FOC),
            mks.Code.MICROSTEPS: mks.SetMicrosteps(16),
            mks.Code.REPLIES: mks.SetReplies(mks.ReplyMode.FULL),
            mks.Code.WATCHDOG: mks.SilenceWatchdog(0),
        }
        self.enabled = False
        self.stalled = self.mute = self.blocked = self.never_done = self.armed = False
        self.slipped = 0
        self.stored: mks.Asked | None = None
        self.moving: mks.Asked | None = None
        self.homing = mks.HomingState.DONE
        self.homes_in_s = 0.2
        self.home_at_s = math.inf
        self.heard_s = 0.0
        self.orders: list[tuple[float, mks.MoveAbsoluteAxis]] = []

    def at(self, now_s: float) -> int:
        return self.motor.at(now_s) + self.slipped

    def hear(self, data: bytes, now_s: float) -> bytes:
        self.device.receive_data(data)
        said = b""
        while (event := self.device.next_event()) is not None:
            if isinstance(event, mks.Asked) and not self.mute:
                said += self.carry_out(event, now_s)
        return said

    def advance(self, now_s: float) -> bytes:
        """Return what it says by itself: the ends of motions."""
        watchdog_s = self.settings[mks.Code.WATCHDOG].timeout_ms / 1000.0
        if watchdog_s and now_s > self.heard_s + watchdog_s and self.motor.moving(now_s):
            self.motor.run(0, 252, self.heard_s + watchdog_s)
        if self.home_at_s <= now_s:
            self.home_at_s, self.homing = math.inf, mks.HomingState.DONE
            self.motor.hold(0)
        asked = self.moving
        if asked is None or self.motor.moving(now_s):
            return b""
        self.moving = None
        done = not (self.never_done or self.mute)
        return self.device.tell(asked, mks.Outcome.DONE) if done else b""

    def next_s(self) -> float:
        return min(self.motor.end_s if self.moving else math.inf, self.home_at_s)

    def carry_out(self, asked: mks.Asked, now_s: float) -> bytes:
        self.heard_s = now_s
        tell = lambda outcome: self.device.tell(asked, outcome)  # noqa: E731
        match asked.request:
            case mks.ReadEncoder():
                return self.device.answer(asked, mks.EncoderRead(self.at(now_s)))
            case mks.ReadAngleError():
                error = round(-self.slipped * mks.ANGLE_ERROR_PER_TURN / mks.COUNTS_PER_TURN)
                return self.device.answer(asked, mks.AngleErrorRead(error))
            case mks.ReadState():
                state = mks.StateRead(state_of(self.motor, now_s))
                return self.device.answer(asked, state)
            case mks.ReadEnabled():
                return self.device.answer(asked, mks.EnabledRead(self.enabled))
            case mks.ReadStall():
                return self.device.answer(asked, mks.StallRead(self.stalled))
            case mks.ReadHoming():
                return self.device.answer(asked, mks.HomingRead(mks.HomingState.DONE, self.homing))
            case mks.ReadVersion():
                version = mks.VersionRead(calibrated=True, board=2, firmware=bytes(self.firmware))
                return self.device.answer(asked, version)
            case mks.ReadSetting(code):
                found = self.settings.get(code)
                value = None if found is None else found.payload
                return self.device.answer(asked, mks.SettingRead(code, value))
            case mks.Enable(on):
                if not self.works:
                    return tell(mks.Outcome.FAILED)
                self.enabled = on
                return tell(mks.Outcome.DONE)
            case mks.ClearStall():
                self.stalled = False
                return tell(mks.Outcome.DONE)
            case mks.ArmSynchronous(on):
                self.armed = on
                return tell(mks.Outcome.DONE)
            case mks.GoSynchronous():
                stored, self.stored = self.stored, None
                return b"" if stored is None else self.begin(stored, now_s)
            case mks.MoveAbsoluteAxis():
                return self.move(asked, now_s)
            case mks.Stop(_, acc):
                self.motor.run(0, acc, now_s)
                self.moving = asked
                return tell(mks.Outcome.STARTED)
            case mks.EmergencyStop():
                self.motor.run(0, 0, now_s)
                self.moving = None
                return tell(mks.Outcome.DONE)
            case mks.Home():
                self.home_at_s, self.homing = now_s + self.homes_in_s, mks.HomingState.UNDER_WAY
                return tell(mks.Outcome.STARTED)
            case setting:
                self.settings[setting.code] = setting
                return tell(mks.Outcome.DONE)

    @property
    def works(self) -> bool:
        return self.settings[mks.Code.MODE].mode.on_bus

    def move(self, asked: mks.Asked, now_s: float) -> bytes:
        self.orders.append((now_s, asked.request))
        retargets = mks.Ability.RETARGET in self.device.abilities
        if self.stalled or not (self.enabled and self.works):
            return self.device.tell(asked, mks.Outcome.FAILED)
        if self.motor.moving(now_s) and not retargets:
            return self.device.tell(asked, mks.Outcome.FAILED)
        if self.armed:
            self.stored = asked
            return self.device.tell(asked, mks.Outcome.STORED)
        return self.begin(asked, now_s)

    def begin(self, asked: mks.Asked, now_s: float) -> bytes:
        superseded = self.moving
        said = b""
        if superseded is not None and isinstance(superseded.request, mks.MoveAbsoluteAxis):
            said = self.device.tell(superseded, mks.Outcome.FAILED)
        order = asked.request
        if not self.blocked:
            self.motor.move_to(order.counts, order.speed_rpm, order.acc, now_s)
        self.moving = asked
        return said + self.device.tell(asked, mks.Outcome.STARTED)

    def reset(self) -> None:
        """Lose the power for a moment."""
        self.motor.hold(0)
        self.enabled, self.moving = False, None


class MksBench(DriverBench):
    """A controller and its drives on simulated time; frames take a while."""

    def __init__(self, firmware=LATEST, settings=None, starts=(0,) * 6) -> None:
        device = MksSettings(**(settings or {}))
        config = ArmConfig(
            "bench", "bench", preset("minimover5-mks"), Connection("grbl"), device=device
        )
        self.nodes = [
            Node(node, firmware, at) for node, at in zip(device.ids, starts, strict=False)
        ]
        super().__init__(MksController(DIALECTS["mks"].abilities, config))
        self.to: list[tuple[float, bytes]] = []
        self.back: list[tuple[float, bytes]] = []
        self.loses: Callable[[Frame, bool], bool] = lambda frame, host: False

    @property
    def positions(self) -> Motors:
        return Motors(node.at(self.now_s) for node in self.nodes)

    def node(self, number: int) -> Node:
        return self.nodes[number - 1]

    def _step(self, end_s: float) -> None:
        on_the_way = [at_s for at_s, _ in (*self.to, *self.back)]
        self._pass_to(end_s, [*on_the_way, *(node.next_s() for node in self.nodes)])
        for data in _due(self.to, self.now_s):
            for node in self.nodes:
                self._answer(node.hear(data, self.now_s))
        for node in self.nodes:
            self._answer(node.advance(self.now_s))
        for data in _due(self.back, self.now_s):
            if not self.dead:
                self.controller.receive(data, self.now_s)
        self._speak()

    def _answer(self, data: bytes) -> None:
        for frame in Unpacker().feed(data):
            if not self.loses(frame, False):
                self.back.append((self.now_s + WIRE_S, pack(frame)))

    def _speak(self) -> None:
        if self.dead:
            return
        for number, frame in enumerate(Unpacker().feed(self.controller.advance(self.now_s))):
            self.sent.append((self.now_s, frame))
            if not self.loses(frame, True):
                self.to.append((self.now_s + (number + 1) * WIRE_S, pack(frame)))


def _due(queue: list[tuple[float, bytes]], now_s: float) -> list[bytes]:
    ready = [data for at_s, data in queue if at_s <= now_s]
    queue[:] = [entry for entry in queue if entry[0] > now_s]
    return ready


# -- motions ---------------------------------------------------------------------------------------


def segments(*ways, duration_s=SEGMENT_S) -> list[MoveBy]:
    """Return segments of the same duration, however long each is."""
    return [MoveBy(Motors(way), Motors(way).largest / duration_s) for way in ways]


def straight(count=10, way=WAY) -> list[MoveBy]:
    """Return the same segment several times."""
    return segments(*([way] * count))


def total(moves: Iterable[MoveBy]) -> Motors:
    """Return the sum of all segments."""
    return sum((move.steps for move in moves), Motors([0] * 6))


def along(moves, **options) -> MoveAlong:
    """Return the request to move along segments."""
    return MoveAlong(iter(moves), AHEAD_S, **options)


def begun(moves, after_s=0.0, ahead_s=AHEAD_S, starts=FAR_FROM_ZERO, **settings) -> MksBench:
    """Return drives that have been moving for a while."""
    bench = MksBench(starts=starts, settings=settings).ready()
    bench.begin(MoveAlong(iter(moves), ahead_s))
    bench.run(after_s)
    return bench


def requests(bench: MksBench, *kinds) -> list[tuple[int, mks.Request]]:
    """Return the requests of some kinds that were sent so far, each with its drive."""
    found = ((frame.can_id, mks.decode_request(frame)) for _, frame in bench.sent)
    return [(node, each) for node, each in found if isinstance(each, kinds)]


def off_path(corners: Sequence[tuple[float, Motors]], time_s: float, positions: Motors) -> float:
    """Return how far motors are off a path, in counts, if all may be a little late."""
    return min(
        max(abs(a - b) for a, b in zip(_place(corners, time_s - late_s), positions, strict=True))
        for late_s in (0.0, 0.01, 0.02, 0.03, 0.04, 0.05)
    )


def _place(corners: Sequence[tuple[float, Motors]], time_s: float) -> list[float]:
    for (from_s, start), (to_s, end) in pairwise(corners):
        if time_s < to_s:
            share = max(time_s - from_s, 0.0) / (to_s - from_s)
            return [a + share * (b - a) for a, b in zip(start, end, strict=True)]
    return list(corners[-1][1])


# -- faults ----------------------------------------------------------------------------------------

BOTH, ORDERS, ANSWERS = (True, True), (True, False), (False, True)


def hold_up(bench: MksBench, for_s: float, sides=BOTH) -> None:
    """Make the bus keep all frames for a time; then all pass at once."""
    end_s, step = bench.now_s + for_s, bench._step
    queues = [queue for queue, held in zip((bench.to, bench.back), sides, strict=True) if held]

    def keep():
        for queue in queues:
            queue[:] = [(max(at_s, end_s + i * 1e-5), data) for i, (at_s, data) in enumerate(queue)]

    def held(until_s):
        if bench.now_s >= end_s:
            step(until_s)
            return
        keep()
        step(min(until_s, end_s))
        keep()

    bench._step = held


def suspend(bench: MksBench, for_s: float) -> None:
    """Suspend the program; afterwards it receives all frames of that time at once."""
    controller, held = bench.controller, []
    controller.receive = lambda data, _now_s: held.append(data)
    controller.next_s, controller.advance = lambda: math.inf, lambda _now_s: b""
    bench.run(for_s)
    del controller.receive, controller.next_s, controller.advance
    controller.receive(b"".join(held), bench.now_s)
    bench._speak()


def restart(bench: MksBench, number: int, *, dead_s=0.0, keeps_angle=False) -> Callable[[], int]:
    """Restart a drive's firmware; return what tells where its shaft really is."""
    node = bench.node(number)
    stood = node.at(bench.now_s)
    angle = stood % mks.COUNTS_PER_TURN if keeps_angle else 0
    lost = stood - angle
    node.moving, node.mute = None, bool(dead_s)
    node.motor.hold(stood)

    def count_from_zero():
        node.mute, node.enabled = False, True
        node.motor.hold(angle)

    if dead_s:
        bench.at_s[bench.now_s + dead_s] = count_from_zero
    else:
        count_from_zero()
    return lambda: node.at(bench.now_s) + (0 if node.mute else lost)
