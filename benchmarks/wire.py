"""One READ over a pty, through the whole driver to another process; beside it, a bare echo."""

from __future__ import annotations

import contextlib
import os
import select
import subprocess
import sys
import tempfile
import tty
from collections.abc import Iterator
from pathlib import Path
from statistics import median

from measuring import Row, Section, interleaved, p99, timing
from sim_process import SimProcess

from armdrive import Arm

BITS_A_BYTE = 10
QUESTION = b"@READ\r"
ECHO = "import os, sys\nend = int(sys.argv[1])\nwhile True: os.write(end, os.read(end, 4096))\n"


class Counted:
    """Counts the bytes that pass a driver's wire, each way."""

    def __init__(self, arm: Arm) -> None:
        self.sent = self.heard = 0
        link = arm.engine.link
        write, read = link.write, link.read

        def counted_write(data: bytes, now_s: float) -> None:
            self.sent += len(data)
            write(data, now_s)

        def counted_read(now_s: float) -> bytes:
            data = read(now_s)
            self.heard += len(data)
            return data

        link.write, link.read = counted_write, counted_read  # type: ignore[method-assign]


class Echo:
    """A pseudo-terminal whose far end, another process, sends back whatever comes."""

    def __init__(self) -> None:
        far, self._near = os.openpty()
        tty.setraw(self._near)
        self._process = subprocess.Popen(
            [sys.executable, "-S", "-c", ECHO, str(far)], pass_fds=(far,)
        )
        os.close(far)

    def exchange(self) -> bytes:
        """Send a question and wait until all of it is back."""
        os.write(self._near, QUESTION)
        heard = b""
        while len(heard) < len(QUESTION):
            select.select([self._near], [], [])
            heard += os.read(self._near, 4096)
        return heard

    def close(self) -> None:
        """End the other process."""
        self._process.kill()
        self._process.wait()
        os.close(self._near)


@contextlib.contextmanager
def _both_ends() -> Iterator[tuple[Arm, Echo]]:
    with (
        tempfile.TemporaryDirectory() as folder,
        SimProcess(Path(folder) / "arm") as sim,
        Arm.connect(sim.port, dialect="teachmover") as arm,
        contextlib.closing(Echo()) as echo,
    ):
        yield arm, echo


def wire(rounds: int = 200) -> Section:
    """Measure both in turn."""
    with _both_ends() as (arm, echo):
        counted = Counted(arm)
        arm.read_inputs()
        exchanged = counted.sent + counted.heard
        baud = arm.config.connection.baud
        taken = interleaved({"read": arm.read_inputs, "echo": echo.exchange}, rounds)
    floor_s = exchanged * BITS_A_BYTE / baud
    reads, echoes = taken["read"], taken["echo"]
    floor = Row(f"floor: {exchanged} bytes at {baud} baud", floor_s * 1e3, "ms")
    bare = timing(f"a bare echo of {len(QUESTION)} bytes", echoes)
    read = timing(
        "READ through the driver",
        reads,
        beside={"the floor": [floor_s], "the bare echo": echoes},
    )
    above = Row(
        "above the floor",
        (median(reads) - floor_s) * 1e3,
        "ms",
        (p99(reads) - floor_s) * 1e3,
    )
    return Section(
        "The wire",
        (floor, bare, read, above),
        f"a pty to another process and back, {rounds} exchanges each; the simulated arm paces its "
        "bytes like the line. The slowest met the driver's own idle poll, and waited for it",
    )
