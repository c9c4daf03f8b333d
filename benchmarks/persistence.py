"""What it costs to remember a position: `python benchmarks/persistence.py [SECTION ...] [--json]`.

The same moves with a record and without one, in turn: processor time of a move that leaves
stand-still and of one that does not, the delay of the first byte of motion in real time, and what
a stop has to wait for while the disk is slow.
"""

from __future__ import annotations

import math
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from measuring import Row, Section, timing
from reporting import report

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import Stopped
from armdrive.motion import connecting
from armdrive.storage.files import StateFiles
from armdrive.storage.record import FileRecorder, PositionRecorder

REST_S = 3.0
"""On the arm's clock: longer than the mark stays."""

SLOW_S = 0.5
"""What a worn SD card takes at its worst."""

MOVE_DEG = 3.0


class SlowDisk(StateFiles):
    """Takes its time to bring anything to the disk."""

    def __init__(self) -> None:
        self.entered = threading.Event()

    def sync(self, handle: int) -> None:
        """Wait, then bring it there."""
        self.entered.set()
        time.sleep(SLOW_S)
        super().sync(handle)


@contextmanager
def connected(recorder: PositionRecorder | None, pace: str) -> Iterator[Arm]:
    """Connect to a new simulated arm, referenced."""
    with Arm(
        connect_simulated(simulated_config("teachmover"), pace=pace, recorder=recorder)
    ) as arm:
        arm.home()
        arm.move_j(shoulder_deg=40.0)
        yield arm


def back_and_forth(arm: Arm, times: int, rest_s: float) -> Callable[[], None]:
    """Return what moves an arm so often, each time after a rest."""

    def work() -> None:
        for index in range(times):
            arm.move_j(base_deg=MOVE_DEG * (index % 2))
            if rest_s:
                arm.sleep(rest_s)

    return work


def cpu_of(cases: dict[str, Callable[[], None]], rounds: int) -> dict[str, list[float]]:
    """Call every case in turn; return the seconds of processor time that each call took."""
    taken_s: dict[str, list[float]] = {name: [] for name in cases}
    for index in range(rounds + 1):
        for name, case in cases.items():
            began_s = time.process_time()
            case()
            if index:  # the first warms up
                taken_s[name].append(time.process_time() - began_s)
    return taken_s


def processor(rounds: int = 15, times: int = 20) -> Section:
    """Measure moves on simulated time, where everything is done on one thread."""
    rows: list[Row] = []
    kinds = {"from stand-still, and a rest": REST_S, "one of many in a row": 0.0}
    for what, rest_s in kinds.items():
        with ExitStack() as stack, tempfile.TemporaryDirectory() as folder:
            file = FileRecorder(Path(folder) / "arm.json")
            without = stack.enter_context(connected(None, "simulated"))
            with_file = stack.enter_context(connected(file, "simulated"))
            taken = cpu_of(
                {
                    "without": back_and_forth(without, times, rest_s),
                    "with": back_and_forth(with_file, times, rest_s),
                },
                rounds,
            )
        bare = taken["without"]
        rows += [
            timing(f"{what}, no record", bare, per=times),
            timing(f"{what}, a record", taken["with"], per=times, beside={"without": bare}),
        ]
    return Section(
        "Processor time of a move",
        tuple(rows),
        f"{rounds} rounds of {times} moves each in turn, on simulated time; a record is written "
        "twice a move that leaves stand-still: the mark, and its clearing",
    )


class FirstByte:
    """Tells how long after a call its first byte of motion goes out."""

    def __init__(self, arm: Arm) -> None:
        self._arm = arm
        self._at_s = 0.0
        link = arm.engine.link
        write = link.write

        def timed(data: bytes, now_s: float) -> None:
            if data.startswith(b"@STEP") and not self._at_s:
                self._at_s = time.perf_counter()
            write(data, now_s)

        link.write = timed  # type: ignore[method-assign]

    def after_s(self, angle_deg: float) -> float:
        """Move, and return the delay."""
        self._at_s = 0.0
        began_s = time.perf_counter()
        self._arm.move_j(base_deg=angle_deg)
        return self._at_s - began_s


def latency(rounds: int = 30) -> Section:
    """Measure in real time: motions before which the registers are read, and others."""
    rest_s, connecting.STILL_S = 0.2, 0.1  # so that each motion leaves stand-still, and soon
    rows: list[Row] = []
    with ExitStack() as stack, tempfile.TemporaryDirectory() as folder:
        file = FileRecorder(Path(folder) / "arm.json")
        arms = {
            "without": stack.enter_context(connected(None, "real")),
            "with": stack.enter_context(connected(file, "real")),
        }
        clocks = {name: FirstByte(arm) for name, arm in arms.items()}
        for what, looked in (("registers read first", False), ("registers known", True)):
            taken: dict[str, list[float]] = {name: [] for name in arms}
            for index in range(rounds):
                for name, clock in clocks.items():
                    arms[name].sleep(rest_s)
                    _pretend_looked(arms[name], looked=looked)
                    taken[name].append(clock.after_s(MOVE_DEG * (index % 2 + 1)))
            bare = taken["without"]
            rows += [
                timing(f"{what}, no record", bare),
                timing(f"{what}, a record", taken["with"], beside={"without": bare}),
            ]
        saves_s = [_save_s(file) for _ in range(rounds)]
    rows.append(timing("this disk: one record, durably", saves_s))
    return Section(
        "From the call to the first byte of a motion that leaves stand-still",
        tuple(rows),
        f"{rounds} motions each in turn, in real time at 9600 baud; the mark is written while the "
        "registers are being read, which an arm that has just been looked at does without",
    )


def _pretend_looked(arm: Arm, *, looked: bool) -> None:
    with arm.pace.lock:
        arm.context.looked_s = arm.engine.now_s if looked else -math.inf


def _save_s(recorder: FileRecorder) -> float:
    record = recorder.load()
    assert record is not None
    began_s = time.perf_counter()
    recorder.save(record)
    return time.perf_counter() - began_s


def slow_disk(rounds: int = 5) -> Section:
    """Stop a motion that waits for a slow disk."""
    stops: list[float] = []
    with tempfile.TemporaryDirectory() as folder:
        disk = SlowDisk()
        recorder = FileRecorder(Path(folder) / "arm.json", disk)
        with connected(recorder, "real") as arm:
            for _ in range(rounds):
                arm.sleep(connecting.STILL_S + SLOW_S * 2)
                disk.entered.clear()
                handle = arm.move_j(base_deg=MOVE_DEG, wait=False)
                disk.entered.wait()
                began_s = time.perf_counter()
                arm.stop()
                stops.append(time.perf_counter() - began_s)
                _expect_stopped(handle.wait)
    return Section(
        "A slow disk",
        (
            Row("the disk takes", SLOW_S * 1e3, "ms"),
            timing("a stop meanwhile", stops, beside={"the disk": [SLOW_S]}),
        ),
        f"{rounds} stops of motions that wait for their mark",
    )  # fmt: skip


def _expect_stopped(wait: Callable[[], object]) -> None:
    try:
        wait()
    except Stopped:
        return
    raise RuntimeError("the motion was not stopped")


SECTIONS = {"processor": processor, "latency": latency, "slow-disk": slow_disk}


def main(argv: list[str] | None = None) -> int:
    """Measure all sections, or those that are asked for."""
    return report(argv, __doc__, SECTIONS)


if __name__ == "__main__":
    sys.exit(main())
