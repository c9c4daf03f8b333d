"""The desk on its own terminal, with a line to the benchmark that began it: a program of its own.

`python desk_child.py LINE bare [RATE_HZ]` is an app that paints one word and tells of each key, the
floor; woken as often a second, it paints nothing then. `python desk_child.py LINE arm PORT DIALECT
MOTORS [RATE_HZ]` says that the arm on the port stands at these motors, brings it to the middle, and
is what `armdrive jog` is from then on; it looks at the status as often as it is told to.
`LINE` is the number of a socket, or -1. A word on it is answered by a JSON object; what is written
to the wire is told unasked.
"""

from __future__ import annotations

import contextlib
import fcntl
import itertools
import json
import socket
import sys
import termios
import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from armdrive.arm import Arm

ROOT = Path(__file__).parents[1]
SHOWN = "STOP"
"""What stands on the last row that is painted, of the desk and of the floor."""

SWEPT, SWEEP_DEG = ("base", "shoulder", "elbow"), 15.0

Answers = Mapping[str, Callable[[], dict[str, Any]]]


class Line:
    """Answers words with JSON objects, and says some unasked."""

    def __init__(self, number: int, answers: Answers) -> None:
        self._answers = {"spent": _spent, **answers}
        self._socket = socket.socket(fileno=number) if number >= 0 else None
        if self._socket is not None:
            threading.Thread(target=self._answer, daemon=True).start()

    def say(self, **words: Any) -> None:
        """Say something."""
        if self._socket is not None:
            self._socket.sendall(json.dumps(words).encode() + b"\n")

    def _answer(self) -> None:
        assert self._socket is not None
        for word in self._socket.makefile("r"):
            self.say(answer=self._answers[word.strip()]())


def _spent() -> dict[str, Any]:
    return {"cpu_s": time.process_time(), "now_s": time.monotonic()}


def bare(number: int, rate_hz: float) -> int:
    """Show one word."""
    from textual import events
    from textual.app import App, ComposeResult
    from textual.widgets import Static

    line = Line(number, {})

    class Bare(App[int]):
        ENABLE_COMMAND_PALETTE = False

        def compose(self) -> ComposeResult:
            yield Static(SHOWN)

        def on_mount(self) -> None:
            if rate_hz:
                self.set_interval(1.0 / rate_hz, lambda: None)

        def on_key(self, event: events.Key) -> None:
            line.say(wrote_s=time.monotonic(), head=event.key)

    Bare().run()
    return 0


def desk(number: int, port: str, dialect: str, motors: list[int], rate_hz: float) -> int:
    """Be the desk of an arm that stands in the middle, and return the exit code."""
    sys.path[:0] = [str(ROOT), str(ROOT / "tests/armdrive")]
    from feel_desk import MIDDLE, TappingDesk
    from forking import ready
    from releasing import promised
    from tapping import tap

    import tui.desk
    from armdrive.cli.runner import CommandEnded, _signals
    from kinematics import Motors

    desks: list[LinedDesk] = []

    class LinedDesk(TappingDesk):
        polls = 0

        def on_mount(self) -> None:  # the framework calls that of the desk as well
            self.call_after_refresh(self.watch_taps)
            desks.append(self)

        def poll(self) -> None:
            super().poll()
            self.polls += 1

    def look() -> dict[str, Any]:
        shown, status = desks[-1], arm.status
        return {
            "promise": asdict(promised(arm)),
            "silent_s": status.silent_time_s,
            "silent_mm": status.silent_distance_mm,
            "stop_s": status.stop_time_s,
            "stop_mm": status.stop_distance_mm,
            "polls": shown.polls,
            "armed": shown.jog.armed,
            "tapped_s": max(shown.tapped_s, 0.0),
            "state": status.state.value,
            "message": shown.message,
        }

    tui.desk.Desk = LinedDesk  # type: ignore[misc]
    if rate_hz:
        tui.desk.POLL_S = 1.0 / rate_hz  # type: ignore[attr-defined]
    try:
        with _signals(), ready(port, dialect, Motors(motors)) as arm:
            arm.move_j(MIDDLE)
            line = Line(number, {"look": look, "sweep": lambda: sweep(arm)})
            tap(arm, lambda data: line.say(wrote_s=time.monotonic(), head=data.decode("latin-1")))
            return tui.run_desk(arm)
    except CommandEnded as ended:
        return 128 + ended.number


def sweep(arm: Arm) -> dict[str, Any]:
    """Have the arm swing from one side of where it stands to the other until it is stopped."""
    from armdrive.errors import ArmError

    here = arm.joints.deg

    def swing() -> None:
        with contextlib.suppress(ArmError):
            for sign in itertools.cycle((1.0, -1.0)):
                arm.move_j({f"{name}_deg": here[name] + sign * SWEEP_DEG for name in SWEPT})

    threading.Thread(target=swing, daemon=True).start()
    return {}


def main(line: str, what: str, *words: str) -> int:
    """Be one or the other, told by a signal when the terminal is closed."""
    fcntl.ioctl(0, termios.TIOCSCTTY, 0)
    if what == "bare":
        return bare(int(line), float(words[0]) if words else 0.0)
    port, dialect, motors, *rate = words
    return desk(int(line), port, dialect, json.loads(motors), float(rate[0]) if rate else 0.0)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
