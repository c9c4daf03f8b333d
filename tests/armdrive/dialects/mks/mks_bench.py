"""Simulated MKS drives on free shafts and on a bus of their own, and a driver's end."""

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
from armdrive.sim.bus.board import switch_power
from armdrive.sim.bus.node import NodeMotor
from armdrive.sim.device import Options
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.mks import KIND
from armdrive.sim.mks.motion import MAKES_UP, Flash
from armdrive.sim.mks.node import MksNode
from armdrive.sim.world.arm import World
from armdrive.sim.world.body import ArmBody
from armdrive.tasks import Alert, AlertKind, Done, Halted, MoveAlong, MoveBy, RequestRejected
from firmware_protocol import mks
from firmware_protocol.frames import Frame, Unpacker, pack
from kinematics import Motors, preset

WIRE_S, BITS_S = 0.0003, 500_000
LATEST = (1, 0, 9)
AHEAD_S = 0.3
SEGMENT_S = 0.1
BURSTS = {"segment_s": 0.0}
FAR_FROM_ZERO = (50_000,) * 6
"""Near zero a drive that was away may have restarted."""
WAY = (6000, -3000, 1500, 0, 700, 20)


class FreeWorld(World):
    """Motors that turn as far as they are driven: no arm hinders them, and none sags."""

    def drive(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        follows = [0 if motor in self.stalled else step for motor, step in enumerate(steps)]
        self._motors = self._motors + Motors(follows)

    def cut_current(self, time_s: float = 0.0) -> None:
        pass

    def give_way(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        pass


class FreeShafts(ShaftDrive):
    """The shafts of those motors. `hangs` is how far each one's load holds it off its set-point."""

    def __init__(self, count: int) -> None:
        self.hangs = [0] * count
        model = preset("minimover5-mks")
        super().__init__(FreeWorld(ArmBody.of_preset(model), motors=[0] * count), MAKES_UP)

    def _errors(self, positions: Sequence[int]) -> tuple[int, ...]:
        errors = zip(super()._errors(positions), self.hangs, self.holding, strict=True)
        return tuple(error + hang if held else 0 for error, hang, held in errors)

    def _sag(self, freed: Sequence[int]) -> list[int]:
        return [0] * len(self.hangs)

    def push(self, motor: int, counts: int) -> None:
        """Turn a shaft by force, at once."""
        by = Motors(counts if each == motor else 0 for each in range(len(self.hangs)))
        self.world._motors = self.world._motors + by


class BenchDrive:
    """A simulated drive on a free shaft, and what a test does to it."""

    def __init__(self, sim: MksNode, shafts: FreeShafts) -> None:
        self.sim, self._shafts = sim, shafts
        self.orders: list[tuple[float, mks.MoveAbsoluteAxis]] = []

    @property
    def index(self) -> int:
        return self.sim.motor.index

    def at(self, now_s: float) -> int:
        """Return where the drive says that its shaft is."""
        self._shafts.look(now_s)
        return self.sim.motor.counts

    def turned_to(self, now_s: float) -> int:
        """Return where its set-point is, from its zero."""
        return self.sim.motor.point.at(now_s) - self.sim.motor.zero

    @property
    def mute(self) -> bool:
        """Whether its cable is unplugged: it hears nothing, and says nothing."""
        return not self.sim.port.plugged

    @mute.setter
    def mute(self, on: bool) -> None:
        self.sim.port.plugged = not on

    def receive(self, frame: Frame, now_s: float) -> list[bytes]:
        """Take a frame; return what the drive says."""
        if not self.sim.listens(frame.can_id):
            return []
        if frame.data[0] == mks.Code.ABSOLUTE_AXIS and frame.can_id:
            request = mks.decode_request(frame)
            if isinstance(request, mks.MoveAbsoluteAxis):
                self.orders.append((now_s, request))
        self.sim.receive(frame, now_s)
        return self.says()

    def live(self, now_s: float) -> list[bytes]:
        """Do what is due; return what the drive says by itself."""
        if now_s < self.due_s():
            return []
        self._shafts.look(now_s)
        self.sim.live(now_s)
        return self.says()

    def says(self) -> list[bytes]:
        said, self.sim.port.outgoing = self.sim.port.outgoing, []
        return said

    def due_s(self) -> float:
        return min(self.sim.due_s(), self._shafts.look_s)

    # What a test does to it.

    def block(self, now_s: float) -> None:
        """Have its shaft stand where it is."""
        self._shafts.look(now_s)
        self._shafts.world.stalled.add(self.index)

    def free(self) -> None:
        """Have its shaft turn again."""
        self._shafts.world.stalled.discard(self.index)

    def hang(self, counts: int) -> None:
        """Have a load hold its shaft so far from its set-point, whatever that is."""
        self._shafts.push(self.index, counts - self._shafts.hangs[self.index])
        self._shafts.hangs[self.index] = counts

    def set_mode(self, mode: mks.Mode, now_s: float) -> None:
        self.sim.set_mode(int(mode), now_s)

    def setting(self, kind: type) -> mks.Setting:
        return self.sim.flash.of(kind)

    def stall(self, now_s: float) -> None:
        """Have its protection let the shaft go."""
        self.sim.motion.halt(now_s)
        self.sim.stalled = True
        self.sim.set_enabled(False, now_s)

    def lose_power(self, now_s: float) -> None:
        """Take its supply; nothing turns its shaft meanwhile."""
        switch_power(self.sim, False, now_s)

    def find_power(self, now_s: float, *, at: int = 0, holds: bool = True) -> None:
        """Give its supply back: it counts from there."""
        switch_power(self.sim, True, now_s)
        self.sim.motor.count_from(at)
        self.sim.set_enabled(holds, now_s)

    def reset(self, now_s: float) -> None:
        """Take its supply for no time: it counts from zero, and holds nothing."""
        self.lose_power(now_s)
        self.find_power(now_s, holds=False)


SWITCH = 3000
"""How far from where it starts a drive finds its switch, in counts."""
HOMES_RPM = 60


def bench_drives(shafts, ids, firmware, starts) -> list[BenchDrive]:
    """Return drives that are set up for an arm, hold nothing yet, and count from their starts."""
    quirks = Options(KIND.options, {"enabled_on": False})
    drives = []
    for index, (node, start) in enumerate(zip(ids, starts, strict=False)):
        motor = NodeMotor(shafts, index, SWITCH)
        own = Flash((mks.SetId(node), mks.SetMode(mks.Mode.BUS_FOC), homing_at(HOMES_RPM)))
        drives.append(BenchDrive(MksNode(motor, firmware, own, quirks, BITS_S), shafts))
        motor.count_from(start)
    return drives


def homing_at(rpm: int) -> mks.SetHoming:
    """Return the setting of a drive that searches for its switch at a speed."""
    return mks.SetHoming(
        active_high=False, counter_clockwise=True, speed_rpm=rpm, limits=False, method=0
    )


class MksBench(DriverBench):
    """A controller and its drives on simulated time; frames take a while."""

    def __init__(self, firmware=LATEST, settings=None, starts=(0,) * 6) -> None:
        device = MksSettings(**(settings or {}))
        config = ArmConfig(
            "bench", "bench", preset("minimover5-mks"), Connection("grbl"), device=device
        )
        self.shafts = FreeShafts(len(device.ids))
        self.nodes = bench_drives(self.shafts, device.ids, firmware, starts)
        super().__init__(MksController(DIALECTS["mks"].abilities, config))
        self.to: list[tuple[float, bytes]] = []
        self.back: list[tuple[float, bytes]] = []
        self.loses: Callable[[Frame, bool], bool] = lambda frame, host: False

    @property
    def positions(self) -> Motors:
        return Motors(node.at(self.now_s) for node in self.nodes)

    def node(self, number: int) -> BenchDrive:
        return self.nodes[number - 1]

    def _step(self, end_s: float) -> None:
        on_the_way = [at_s for at_s, _ in (*self.to, *self.back)]
        dues_s = [node.sim.due_s() for node in self.nodes]
        self._pass_to(end_s, [*on_the_way, *dues_s, self.shafts.look_s])
        if heard := _due(self.to, self.now_s):
            for frame in Unpacker().feed(b"".join(heard)):
                for node in self.nodes:
                    self._answer(node.receive(frame, self.now_s))
        if heard or self.now_s >= min(self.shafts.look_s, *dues_s):
            for node in self.nodes:
                self._answer(node.live(self.now_s))
        for data in _due(self.back, self.now_s):
            if not self.dead:
                self.controller.receive(data, self.now_s)
        self._speak()

    def _answer(self, said: list[bytes]) -> None:
        for frame in Unpacker().feed(b"".join(said)) if said else ():
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


# -- what a motion comes to ------------------------------------------------------------------------


def ends_well(bench: MksBench) -> None:
    """Check that the motion is carried out, and that no drive is blamed."""
    reply = bench.finish()
    assert isinstance(reply, Done), str(reply)
    assert not bench.alerts()


def is_halted(bench: MksBench, *, hard: bool = False) -> None:
    """Stop the motion; check that it is halted, and that no drive is blamed."""
    bench.controller.stop(hard=hard)
    assert isinstance(bench.finish(), Halted)
    assert not bench.alerts()


def blamed(
    bench: MksBench,
    who: str = "drive 1 (base)",
    kind: AlertKind | None = None,
    reply: object = None,
) -> Alert:
    """Check that one drive, and no other, is blamed for the end of the motion."""
    assert isinstance(reply or bench.finish(), RequestRejected)
    (alert,) = bench.alerts()
    assert who in alert.text
    assert kind in (None, alert.kind)
    return alert


def stands(bench: MksBench, for_s: float = 2.0) -> None:
    """Check that nothing turns for a while."""
    stood = bench.positions
    bench.run(for_s)
    assert bench.positions == stood


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


def send_late(bench: MksBench, for_s: float) -> None:
    """Suspend the program as it writes: what it says comes late, and so does it itself."""
    said = len(bench.sent)
    while len(bench.sent) == said:
        bench._step(bench.now_s + 1.0)
    bench.to[:] = [(at_s + for_s, data) for at_s, data in bench.to]
    suspend(bench, for_s)


def restart(bench: MksBench, number: int, *, dead_s=0.0, keeps_angle=False) -> Callable[[], int]:
    """Restart a drive's firmware; return what tells where its shaft really is."""
    node = bench.node(number)
    stood, motor = node.at(bench.now_s), node.sim.motor
    zero, angle = motor.zero, stood % mks.COUNTS_PER_TURN if keeps_angle else 0
    node.lose_power(bench.now_s)
    if dead_s:
        bench.at_s[bench.now_s + dead_s] = lambda: node.find_power(bench.now_s, at=angle)
    else:
        node.find_power(bench.now_s, at=angle)

    def shaft() -> int:
        node.at(bench.now_s)
        return motor.shaft - zero

    return shaft
