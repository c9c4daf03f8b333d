"""The simulated device of a bench as a process of its own, over any of the doors it has."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
from sim_process import SimProcess

ROOT = Path(__file__).parents[2]
SCHEMES = {"--pty": "", "--slcan": "", "--tcp": "socket://", "--udp": "udp://"}
"""What a program opens, before the address that the device names."""


class DeviceProcess(SimProcess):
    """`program` with one door, `--pty PATH` say; its `port` is what a driver opens."""

    def __init__(self, program: Sequence[str], door: tuple[str, str], dialect: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", *program, *door],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        where, _ = door
        told = self._heard().partition(f" speaks {dialect} at ")[2].partition(";")[0]
        self.port = SCHEMES[where] + told
