"""Print how soon a stop is on the wire, and how soon the arm stands.

    python benchmarks/stop_latency.py [DIALECT ...] [--times N] [--quick] [--json]

In real time, on a twin in another process over a pty. Of a device that obeys a stop in motion: from
`arm.request_stop()`, called in another thread than the engine's, to the return of the write that
carried the stop; while the device's queue is full, where it has one, its position is asked for as
often as the arm file may have it, and another thread reads the status all the time. Of all of them:
how long and how far the physical arm goes on when a motion is stopped, a jog is let go and the
program is killed. The bound is what the status announced for it. Exit code 1 where one is broken.
"""

from __future__ import annotations

import contextlib
import itertools
import sys
import threading
import time
from collections.abc import Callable, Iterator

from feel import Figures, Measured, Options, report
from feel_benches import DensePtyBench, chance
from overrun import ENDINGS, StopMeasurement
from overrun import measure as overruns
from tapping import tap

from armdrive.abilities import Abort
from armdrive.arm import Arm
from armdrive.blocking import run_blocking
from armdrive.errors import ArmError
from armdrive.registry import DIALECTS
from armdrive.status import State, Trust
from armdrive.tasks import MoveAlong, MoveBy, Reply, TaskBody
from firmware_protocol.canopen import COMMAND_PDO, Command, Service, service_of
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, Unpacker
from firmware_protocol.mks import EmergencyStop, decode_request
from firmware_protocol.mks import Stop as DriveStop
from firmware_protocol.robko01 import Stop
from firmware_protocol.robko01.messages import encode_request
from kinematics import Motors
from tests.conformance.motions import begin_sweep

TIMES, QUICK_TIMES = 1000, 5
STANDING_TIMES, QUICK_STANDING = 60, 1
"""A stand-still takes a second or two to wait for, so that it is measured less often."""

PORTION = 10
"""So often is an arm stopped until it begins anew: what is left of each way leads it to a limit."""

OFTEN = {"grbl": "[grbl]\npoll_s = 0.01\n", "mks": "[mks]\npoll_s = 0.02\n"}
"""A position is asked for in motion as often as an arm file may have it."""
STATUS_S = 0.002
SEGMENT_S = 0.02
SEGMENT_STEPS = {"grbl": 4, "mks": 400, "cia402": 250}
MOMENTS_S = (0.1, 0.4)
"""When the stop is asked for, after the motion has begun: the queue is full within a tenth."""
SWEEP_DEG = 40.0
PATIENCE_S = 10.0


def is_drive_stop(data: bytes) -> bool:
    """Tell whether frames carry a drive's stop."""
    return any(
        isinstance(_asked(frame), DriveStop | EmergencyStop) for frame in Unpacker().feed(data)
    )


def _asked(frame: Frame) -> object:
    try:
        return decode_request(frame)
    except RemoteProtocolError:
        return None


def is_quick_stop(data: bytes) -> bool:
    """Tell whether frames order a CiA 402 drive to stop quickly."""
    return any(_quick_stops(frame) for frame in Unpacker().feed(data))


def _quick_stops(frame: Frame) -> bool:
    service, _ = service_of(frame.can_id) or (None, 0)
    if service is not Service.RPDO1:
        return False
    word = int(COMMAND_PDO.unpack(frame.data)[0])
    return word & Command.QUICK_STOP.mask == Command.QUICK_STOP.wanted


STOPS: dict[str, Callable[[bytes], bool]] = {
    "grbl": lambda data: b"!" in data,
    "robko01": lambda data: encode_request(Stop()) in data,
    "mks": is_drive_stop,
    "cia402": is_quick_stop,
}
"""How a stop looks on the wire, of the devices that obey one."""


class Watched:
    """A driver's link that remembers when a stop had been written."""

    def __init__(self, arm: Arm, is_stop: Callable[[bytes], bool]) -> None:
        self.written = threading.Event()
        self.written_s = 0.0
        tap(arm, self._said)
        self._is_stop = is_stop

    def _said(self, data: bytes) -> None:
        if self._is_stop(data) and not self.written.is_set():
            self.written_s = time.perf_counter()
            self.written.set()

    def begin(self) -> None:
        """Forget what was seen."""
        self.written.clear()


class Stream:
    """Short segments without end, so that every place of the device's queue is taken."""

    def __init__(self, arm: Arm, direction: int) -> None:
        self._arm = arm
        steps = SEGMENT_STEPS[arm.config.connection.dialect]
        self._piece = MoveBy(Motors((direction * steps, 0, 0, 0, 0, 0)), steps / SEGMENT_S)
        self.drawn = 0
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _segments(self) -> Iterator[MoveBy]:
        while True:
            self.drawn += 1
            yield self._piece

    def _run(self) -> None:
        with contextlib.suppress(ArmError):
            run_blocking(self._arm.parts.runner.perform(self._flow(), within_s=PATIENCE_S))

    def _flow(self) -> TaskBody[Reply]:
        ahead_s = self._arm.config.motion.planned_burst_s
        return (yield from self._arm.parts.context.request(MoveAlong(self._segments(), ahead_s)))

    def wait(self) -> None:
        """Wait for its end."""
        self._thread.join(PATIENCE_S)


class Sweep:
    """A planned motion, for a device that queues nothing."""

    def __init__(self, arm: Arm, direction: int) -> None:
        self._handle = begin_sweep(arm, direction * SWEEP_DEG)
        self.drawn = 0

    def wait(self) -> None:
        """Wait for its end, which is a stop."""
        with contextlib.suppress(ArmError):
            self._handle.wait()


@contextlib.contextmanager
def status_read(arm: Arm) -> Iterator[None]:
    """Have another thread read the status all the time."""
    end = threading.Event()

    def read() -> None:
        while not end.wait(STATUS_S):
            _ = arm.status

    thread = threading.Thread(target=read, daemon=True)
    thread.start()
    try:
        yield
    finally:
        end.set()
        thread.join()


def make_ready(bench: DensePtyBench, arm: Arm) -> None:
    """Mend what a computer too busy to answer in time has led to: a motion that went unanswered."""
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    if arm.status.trust is not Trust.REFERENCED:
        bench.reference(arm)


def to_the_wire(dialect: str, times: int) -> Iterator[Figures]:
    """Stop a device that can be stopped, again and again."""
    luck = chance("stop", dialect)
    found: list[Measured] = []
    queued: list[Measured] = []
    needless = 0
    with DensePtyBench(dialect) as bench:
        if dialect in OFTEN:
            bench.use_arm_file(OFTEN[dialect])
        arm = bench.ready()
        kind = Stream if arm.abilities.queued_segments else Sweep
        watched = Watched(arm, STOPS[dialect])
        with status_read(arm):
            for direction in itertools.islice(itertools.cycle((1, -1)), times):
                make_ready(bench, arm)
                watched.begin()
                motion = kind(arm, direction)
                bench.wait_until_moving()
                began_s = time.perf_counter()
                time.sleep(luck.uniform(*MOMENTS_S))
                driven = (time.perf_counter() - began_s) / SEGMENT_S
                bound_s = arm.status.stop_time_s
                drawn = motion.drawn
                asked_s = time.perf_counter()
                arm.request_stop()
                motion.wait()
                if not watched.written.is_set():
                    needless += 1
                    continue
                found.append(Measured((watched.written_s - asked_s) * 1e3, bound_s * 1e3))
                queued.append(Measured(drawn - driven))
    yield Figures(dialect, "from request_stop to the stop on the wire", "ms", found)
    if needless:
        what = "  stops between two bursts, which needed none"
        yield Figures(dialect, what, "", [Measured(needless)])
    if kind is Stream:
        yield Figures(dialect, "  segments that the device had queued", "", queued)


def figures(dialect: str, what: str, found: list[StopMeasurement]) -> Iterator[Figures]:
    """Give times and ways, each beside what was announced."""
    times = [Measured(each.time_s * 1e3, each.announced_s * 1e3) for each in found]
    yield Figures(dialect, what, "ms", times)
    yield Figures(dialect, what, "mm", [Measured(each.way_mm, each.announced_mm) for each in found])


def to_stand_still(dialect: str, times: int) -> Iterator[Figures]:
    """End motions in every way, and watch the physical arm."""
    portions = [min(PORTION, times - done) for done in range(0, times, PORTION)]
    for ending in ENDINGS:
        found = [each for portion in portions for each in overruns(dialect, ending, portion)]
        yield from figures(dialect, ending.what, found)


def measure(options: Options, dialect: str) -> Iterator[Figures]:
    """Measure one dialect in the way that it allows."""
    standing = min(options.times, QUICK_STANDING if options.quick else STANDING_TIMES)
    if DIALECTS[dialect].abilities.abort is not Abort.NONE:
        yield from to_the_wire(dialect, options.times)
    yield from to_stand_still(dialect, standing)


def main(argv: list[str] | None = None) -> int:
    """Measure every dialect, or those that are asked for."""
    return report(argv, __doc__, measure, times=TIMES, quick_times=QUICK_TIMES)


if __name__ == "__main__":
    sys.exit(main())
