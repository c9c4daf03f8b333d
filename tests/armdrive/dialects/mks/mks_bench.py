"""An MKS controller and simulated drives on free shafts, without an arm."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from itertools import pairwise

from driver_bench import BusBench

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import Connection
from armdrive.dialects.mks.controller import MksController
from armdrive.dialects.mks.settings import MksSettings
from armdrive.registry import DIALECTS
from armdrive.sim.bus.node import NodeMotor, switch_power
from armdrive.sim.device import SimDevice
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.mks import MksBoard
from armdrive.sim.mks.motion import TOP_RATE, Flash
from armdrive.sim.mks.node import MksNode
from armdrive.sim.mks.quirks import MksQuirks
from armdrive.sim.wire import MemoryLink
from armdrive.sim.world import World
from armdrive.sim.world.body import ArmBody
from armdrive.tasks import Alert, AlertKind, Done, Halted, MoveAlong, MoveBy, RequestRejected
from firmware_protocol import mks
from firmware_protocol.frames import Frame
from kinematics import Motors, preset

BITS_S = 500_000
LATEST = (1, 0, 9)
AHEAD_S = 0.3
SEGMENT_S = 0.1
BURSTS = {"segment_s": 0.0}
FAR_FROM_ZERO = (50_000,) * 6
"""Near zero, a drive without contact may have restarted unnoticed."""
WAY = (6000, -3000, 1500, 0, 700, 20)


class FreeWorld(World):
    """Motors that turn as far as they are driven: there is no arm to hinder them or to sag."""

    def drive(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        follows = [0 if motor in self.stalled else step for motor, step in enumerate(steps)]
        self._motors = self._motors + Motors(follows)

    def cut_current(self, time_s: float = 0.0) -> None:
        pass

    def give_way(self, steps: Sequence[int], time_s: float = 0.0) -> None:
        pass


class FreeShafts(ShaftDrive):
    """The shafts of these motors. `load_errors` is how far a load turns each off its set-point."""

    def __init__(self, count: int) -> None:
        self.load_errors = [0] * count
        model = preset("minimover5-mks")
        super().__init__(FreeWorld(ArmBody.of_preset(model), motors=[0] * count), TOP_RATE)

    def _errors(self, positions: Sequence[int]) -> tuple[int, ...]:
        errors = zip(super()._errors(positions), self.load_errors, self.holding, strict=True)
        return tuple(error + hang if held else 0 for error, hang, held in errors)

    def _sag(self, freed: Sequence[int]) -> list[int]:
        return [0] * len(self.load_errors)

    def push(self, motor: int, counts: int) -> None:
        """Turn a shaft at once, by force."""
        by = Motors(counts if each == motor else 0 for each in range(len(self.load_errors)))
        self.world._motors = self.world._motors + by


class BenchDrive:
    """A simulated drive on a free shaft, with what a test can do to it."""

    def __init__(self, index: int, shafts: FreeShafts, board: MksBoard) -> None:
        self.index, self._shafts, self._board = index, shafts, board

    @property
    def sim(self) -> MksNode:
        return self._board.node(self.index)

    @property
    def _now_s(self) -> float:
        return self._board.now_s

    @property
    def count(self) -> int:
        """The drive's count of its shaft."""
        self._shafts.look(self._now_s)
        return self.sim.motor.counts

    @property
    def set_point(self) -> int:
        """The set-point, counted from the drive's zero."""
        return self.sim.motor.point.at(self._now_s) - self.sim.motor.zero

    @property
    def mute(self) -> bool:
        """Whether the drive's cable is unplugged, so that it neither receives nor sends."""
        return not self.sim.port.plugged

    @mute.setter
    def mute(self, on: bool) -> None:
        self.sim.port.plugged = not on

    def block(self) -> None:
        """Block the shaft."""
        self._shafts.look(self._now_s)
        self._shafts.world.stalled.add(self.index)

    def free(self) -> None:
        """Free the shaft."""
        self._shafts.world.stalled.discard(self.index)

    def load(self, counts: int) -> None:
        """Turn the shaft off its set-point by a load, by a constant number of counts."""
        self._shafts.push(self.index, counts - self._shafts.load_errors[self.index])
        self._shafts.load_errors[self.index] = counts

    def enable(self, on: bool = True) -> None:
        """Switch the motor on or off, as the drive's own keys do."""
        self.sim.set_enabled(on, self._now_s)

    def receive(self, frame: Frame) -> None:
        """Receive a frame of another program."""
        self.sim.receive(frame, self._now_s)

    def set_mode(self, mode: mks.Mode) -> None:
        self.sim.set_mode(int(mode), self._now_s)

    def setting(self, kind: type) -> mks.Setting:
        return self.sim.flash.of(kind)

    def stall(self) -> None:
        """Make the stall protection release the shaft."""
        self.sim.motion.halt(self._now_s)
        self.sim.stalled = True
        self.enable(False)

    def lose_power(self) -> None:
        """Switch the supply off; the shaft does not turn meanwhile."""
        switch_power(self.sim, False, self._now_s)

    def restore_power(self, *, at: int = 0, holds: bool = True) -> None:
        """Switch the supply on; the drive counts from `at`."""
        switch_power(self.sim, True, self._now_s)
        self.sim.motor.count_from(at)
        self.enable(holds)

    def reset(self) -> None:
        """Switch the supply off and on: the drive counts from zero, and does not hold."""
        self.lose_power()
        self.restore_power(holds=False)


SWITCH = 3000
"""The distance of a drive's switch from where it starts, in counts."""
HOMES_RPM = 60


def homing_at(rpm: int) -> mks.SetHoming:
    """Return the homing setting of a drive that seeks its switch at a speed."""
    return mks.SetHoming(
        active_high=False, counter_clockwise=True, speed_rpm=rpm, limits=False, method=0
    )


class MksBench(BusBench):
    """A controller and its drives on free shafts; `firmware` is one version, or one per drive."""

    def __init__(self, firmware=LATEST, settings=None, starts=(0,) * 6) -> None:
        device = MksSettings(**(settings or {}))
        self.config = config = ArmConfig(
            "bench", "bench", preset("minimover5-mks"), Connection("grbl"), device=device
        )
        count, quirks = len(device.ids), MksQuirks(enabled_on=False)
        versions = firmware if isinstance(firmware, list) else [firmware] * count
        shafts, nodes = FreeShafts(count), []
        for index, node in enumerate(device.ids):
            motor = NodeMotor(shafts, index, SWITCH)
            own = Flash((mks.SetId(node), mks.SetMode(mks.Mode.BUS_FOC), homing_at(HOMES_RPM)))
            nodes.append(MksNode(motor, versions[index], own, quirks, BITS_S))
            motor.count_from(starts[index])
        board = MksBoard(shafts.world, shafts, nodes, BITS_S)
        self.nodes = [BenchDrive(index, shafts, board) for index in range(len(nodes))]
        sim = SimDevice(board)
        controller = MksController(DIALECTS["mks"].abilities, config)
        super().__init__(controller, sim, MemoryLink(sim.line(), "simulated drives"))

    @property
    def positions(self) -> Motors:
        return Motors(node.count for node in self.nodes)

    def node(self, number: int) -> BenchDrive:
        return self.nodes[number - 1]


# -- motions ---------------------------------------------------------------------------------------


def segments(*ways, duration_s=SEGMENT_S) -> list[MoveBy]:
    """Return segments of equal duration."""
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
    """Return a bench whose drives have been moving for a while."""
    bench = MksBench(starts=starts, settings=settings).ready()
    bench.begin(MoveAlong(iter(moves), ahead_s))
    bench.run(after_s)
    return bench


def requests(
    bench: MksBench, *kinds, node: int = 0, since_s: float = 0.0
) -> list[tuple[float, int, mks.Request]]:
    """Return the requests of some kinds to a drive (0: to all) since a time, with time and id."""
    found = [
        (at_s, frame.can_id, mks.decode_request(frame))
        for at_s, frame in bench.sent
        if at_s >= since_s and node in (0, frame.can_id)
    ]
    return [row for row in found if isinstance(row[2], kinds)]


def off_path(corners: Sequence[tuple[float, Motors]], time_s: float, positions: Motors) -> float:
    """Return how far motors are off a path, in counts; all together may be a little late."""
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


# -- how a motion ends -----------------------------------------------------------------------------


def check_done(bench: MksBench) -> None:
    """Check that the motion succeeds, without an alert."""
    reply = bench.finish()
    assert isinstance(reply, Done), str(reply)
    assert not bench.alerts()


def check_halted(bench: MksBench, *, hard: bool = False) -> None:
    """Stop the motion; check that it is halted, without an alert."""
    bench.controller.stop(hard=hard)
    assert isinstance(bench.finish(), Halted)
    assert not bench.alerts()


def check_blamed(
    bench: MksBench,
    who: str = "drive 1 (base)",
    kind: AlertKind | None = None,
    reply: object = None,
) -> Alert:
    """Check that the motion is rejected with one alert, about one drive; return the alert."""
    assert isinstance(reply or bench.finish(), RequestRejected)
    (alert,) = bench.alerts()
    assert who in alert.text
    assert kind in (None, alert.kind)
    return alert


# -- faults ----------------------------------------------------------------------------------------


def send_late(bench: MksBench, for_s: float) -> None:
    """Suspend the program while it writes: its frames arrive late, and so do its next ones."""
    said, bench.waits_s = len(bench.sent), lambda _frame, host: for_s * host
    while len(bench.sent) == said:
        bench._step(bench.now_s + 1.0)
    bench.waits_s = lambda _frame, _host: 0.0
    bench.suspend(for_s)


def restart(bench: MksBench, number: int, *, dead_s=0.0, keeps_angle=False) -> Callable[[], int]:
    """Restart a drive's firmware; return a function that tells where its shaft really is."""
    node = bench.node(number)
    stood, motor = node.count, node.sim.motor
    zero, angle = motor.zero, stood % mks.COUNTS_PER_TURN if keeps_angle else 0
    node.lose_power()
    if dead_s:
        bench.at_s[bench.now_s + dead_s] = lambda: node.restore_power(at=angle)
    else:
        node.restore_power(at=angle)
    return lambda: node.count + motor.zero - zero
