"""What the arm view costs a desk at 30 pictures a second: the processor, and bytes to the terminal.

Each case is a Textual app of its own on a pty of 120 by 40, which drives an arm's picture along a
joint motion for some seconds. The floor is the same app, woken as often, that paints nothing; the
ratios are to what each case takes above it. `spans` is the desk's own widget; `rows` repaints each
row that changed, `whole` all of the widget; `left` asks for spans, and leaves them to the
framework, which paints each row from its beginning. `orbit` goes round the arm instead.
"""

from __future__ import annotations

import argparse
import fcntl
import json
import os
import pty
import resource
import select
import struct
import subprocess
import sys
import termios
import time
from dataclasses import dataclass
from statistics import median

WIDTH, HEIGHT = 120, 40
RATE_HZ = 30
CASES = ("floor", "spans", "left", "rows", "whole", "orbit")
GOAL_PERCENT = 12.0


# -- the app, in a process of its own ----------------------------------------------------------


def run_case(case: str, seconds: float, report: int) -> None:
    """Run one case on this terminal, and write what it took to a file descriptor."""
    from itertools import count

    from textual.app import App, ComposeResult
    from textual.screen import Screen

    from armdrive.render.scene import Moment
    from kinematics import Joints, preset
    from tui.arm_view import SpaceView
    from tui.painting import send_spans_alone

    model = preset("teachmover")
    goal = Joints.of(-40.0, 50.0, -70.0, -60.0, 0.0)

    class Repainting(SpaceView):
        def refresh(self, *regions, **more):
            if case == "rows" and regions:
                rows = {region.y for region in regions}
                regions = tuple(type(regions[0])(0, y, self.size.width, 1) for y in rows)
            elif case == "whole":
                regions = ()
            return super().refresh(*regions, **more)

    class Bench(App[None]):
        ENABLE_COMMAND_PALETTE = False

        def get_default_screen(self) -> Screen:
            screen = super().get_default_screen()
            if case != "left":
                send_spans_alone(screen)
            return screen

        def compose(self) -> ComposeResult:
            yield Repainting(model, braille=True, id="view")

        def on_mount(self) -> None:
            self.ticks = count()
            self.pictures = 0
            self.set_timer(1.0, self.begin)

        def begin(self) -> None:
            self.view = self.query_one(SpaceView)
            self.view.show(moment(0))
            self.set_timer(0.5, self.measure)

        def measure(self) -> None:
            self.began_s, self.used_s = time.perf_counter(), used_s()
            os.write(report, b"begin\n")
            self.set_interval(1 / RATE_HZ, self.tick)
            self.set_timer(seconds, self.finish)

        def tick(self) -> None:
            number = next(self.ticks)
            self.pictures += 1
            if case == "orbit":
                self.view.camera = self.view.camera.orbited(2)
                self.view.look("up" if number % 40 < 20 else "down")
            elif case != "floor":
                self.view.show(moment(number))

        def finish(self) -> None:
            took_s = time.perf_counter() - self.began_s
            found = {
                "cpu_s": used_s() - self.used_s,
                "took_s": took_s,
                "pictures": self.pictures,
            }
            os.write(report, json.dumps(found).encode() + b"\n")
            self.exit()

    def moment(number: int) -> Moment:
        """Sweep base, shoulder, elbow and wrist to and fro, 60 degrees in 2 s."""
        share = abs(number % (4 * RATE_HZ) - 2 * RATE_HZ) / (2 * RATE_HZ)
        joints = Joints.of(-30 + 60 * share, 40 + 30 * share, -40 - 60 * share, -60.0, 90 * share)
        return Moment(joints, 20.0 + 20.0 * share, goal=goal, goal_opening_mm=30.0)

    Bench().run()


def used_s() -> float:
    own = resource.getrusage(resource.RUSAGE_SELF)
    return own.ru_utime + own.ru_stime


# -- the terminal ------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Taken:
    """One run: milliseconds of the processor and KiB for each picture, and pictures a second.

    A busy computer shows fewer pictures than were asked for: what one costs is still comparable.
    """

    cost_ms: float
    kib: float
    pictures_s: float

    @property
    def percent(self) -> float:
        """The share of a core at the rate that was asked for."""
        return self.cost_ms * RATE_HZ / 10.0


def measured(case: str, seconds: float) -> Taken:
    """Run a case in a child on a pty, and count what it writes while it measures."""
    parent, child = pty.openpty()
    fcntl.ioctl(child, termios.TIOCSWINSZ, struct.pack("HHHH", HEIGHT, WIDTH, 0, 0))
    heard, says = os.pipe()
    environ = os.environ | {"TERM": "xterm-256color", "COLORTERM": "truecolor"}
    command = [sys.executable, __file__, "--case", case, "--seconds", str(seconds)]
    process = subprocess.Popen(
        [*command, "--report", str(says)],
        stdin=child,
        stdout=child,
        stderr=child,
        env=environ,
        pass_fds=(says,),
        start_new_session=True,
    )
    os.close(child)
    os.close(says)
    told, painted, before = b"", 0, 0
    while True:
        ready, _, _ = select.select([parent, heard], [], [], 60.0)
        if heard in ready:
            piece = os.read(heard, 4096)
            if b"begin" in piece:
                before = painted
            told += piece
            if not piece or told.count(b"\n") == 2:
                break
        if parent in ready:
            painted += len(os.read(parent, 65536))
        if not ready:
            process.kill()
            raise RuntimeError(f"the case {case} says nothing")
    drain(parent, process)
    found = json.loads(told.splitlines()[1])
    return Taken(
        1000.0 * found["cpu_s"] / found["pictures"],
        (painted - before) / 1024.0 / found["pictures"],
        found["pictures"] / found["took_s"],
    )


def drain(parent: int, process: subprocess.Popen[bytes]) -> None:
    """Let the child leave its screen and end."""
    while process.poll() is None:
        if select.select([parent], [], [], 0.2)[0]:
            try:
                os.read(parent, 65536)
            except OSError:
                break
    process.wait()
    os.close(parent)


def main(argv: list[str] | None = None) -> int:
    """Measure every case in turn, some rounds, and print medians and ratios."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("cases", nargs="*", default=[], help=", ".join(CASES))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--case", help=argparse.SUPPRESS)
    parser.add_argument("--report", type=int, help=argparse.SUPPRESS)
    options = parser.parse_args(argv)
    if options.case:
        run_case(options.case, options.seconds, options.report)
        return 0
    cases = ["floor", *(case for case in options.cases or CASES if case != "floor")]
    runs: dict[str, list[Taken]] = {case: [] for case in cases}
    for _ in range(options.rounds):
        for case in cases:
            runs[case].append(measured(case, options.seconds))
    show(runs)
    return 0


def show(runs: dict[str, list[Taken]]) -> None:
    """Print a line for each case, and how much more than the span's each takes above the floor."""
    middle = {case: median(run.percent for run in taken) for case, taken in runs.items()}
    floor, own = middle["floor"], middle.get("spans", middle["floor"])
    print(f"arm view, {WIDTH}x{HEIGHT}, at {RATE_HZ} pictures a second")
    for case, taken in runs.items():
        kib_s = median(run.kib for run in taken) * RATE_HZ
        cost_ms = median(run.cost_ms for run in taken)
        rate = median(run.pictures_s for run in taken)
        line = f"  {case:<7}{middle[case]:6.1f} % of a core{kib_s:8.1f} KiB/s"
        line += f"{cost_ms:7.2f} ms each ({rate:.0f}/s shown)"
        if case != "floor":
            line += f", {middle[case] / floor:.2f} x floor"
            if own > floor:
                line += f", {(middle[case] - floor) / (own - floor):.2f} x spans above it"
        print(line)
    verdict = "within" if own <= GOAL_PERCENT else "ABOVE"
    if "spans" in middle:
        print(f"  spans: {verdict} the goal of {GOAL_PERCENT:.0f} % of a core")


if __name__ == "__main__":
    sys.exit(main())
