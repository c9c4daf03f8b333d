"""A simulated arm on a pseudo-terminal or a TCP port, in a process of its own, and questions."""

from __future__ import annotations

import contextlib
import json
import math
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Self

from armdrive.registry import DIALECTS

LOOK_S = 0.002
"""How often the arm is looked at while it comes to rest: the resolution of what is measured."""

QUIET_S = 0.3
"""An arm that has not moved for this long stands."""

PATIENCE_S = 30.0


class SimProcess:
    """`armdrive sim DIALECT --pty PORT`; a program opens `port` as it would a real arm's.

    Drives on a CAN bus are behind a serial adapter there.
    """

    def __init__(self, port: Path | None, dialect: str = "teachmover", *options: str) -> None:
        """Start it, and wait until the port is there; without a path, one of TCP."""
        door = "--slcan" if DIALECTS[dialect].can else "--pty"
        where = ["--tcp", "127.0.0.1:0"] if port is None else [door, str(port)]
        self.process = subprocess.Popen(
            [sys.executable, "-m", "armdrive", "sim", dialect, *where, *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            bufsize=1,
        )
        self.port = self.told_port(dialect)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        try:
            with contextlib.suppress(BrokenPipeError):
                self.process.communicate("quit\n", timeout=PATIENCE_S)
        finally:
            self.process.kill()

    def told_port(self, dialect: str) -> str:
        """Return the port that the first line tells programs to open."""
        return self._heard().partition(f" speaks {dialect} at ")[2].partition(";")[0]

    def state(self) -> dict[str, Any]:
        """Return the physical state of the arm at this moment."""
        _, state = self.look()
        return state

    def look(self) -> tuple[float, dict[str, Any]]:
        """Return the time on the simulated arm's own clock, and its physical state then."""
        answer = json.loads(self.say("state --json"))
        if not isinstance(answer, dict):
            return math.nan, {}
        return answer.pop("time_s", math.nan), answer

    def say(self, line: str) -> str:
        """Give a one-line command and return the line that answers it."""
        if self.process.stdin is None:
            raise RuntimeError("the simulation was started without an input")
        self.process.stdin.write(line + "\n")
        return self._heard().rstrip("\n")

    def wait_until_moving(self) -> None:
        """Wait until a motor turns."""
        end_s = time.monotonic() + PATIENCE_S
        while not self.state()["moving"]:
            if time.monotonic() > end_s:
                raise TimeoutError("the simulated arm never began to move")
            time.sleep(LOOK_S)

    def rest_after_s(self, since_s: float) -> float:
        """Return how long after `since_s` (monotonic) the arm first stood where it then stayed."""
        motors, changed_s, quiet_s = None, since_s, since_s
        while (now_s := time.monotonic()) < quiet_s + QUIET_S:
            seen = self.state()["motors"]
            if seen != motors:
                # an answer that came late says nothing of how long the arm has stood since
                motors, changed_s, quiet_s = seen, now_s, time.monotonic()
            time.sleep(LOOK_S)
        return changed_s - since_s

    def _heard(self) -> str:
        line = self.process.stdout.readline() if self.process.stdout else ""
        if not line:
            raise RuntimeError("the simulation has ended")
        return line
