"""Measure the driver against real firmware: rows and stops.

    python -m tests.firmware --mega5x mega.elf --robko robko.elf
    python -m tests.firmware --mega5x mega.elf --rows --only "a joint motion"
    python -m tests.firmware --mega5x mega.elf --stops
    python -m tests.firmware --port /dev/ttyUSB0 --dialect grbl --rows

Images are ELF files that you have built; the project contains none. Without --rows or
--stops, both run. See docs/background/testing.md. Exit code 1: something was not as promised;
2: nothing could be measured.
"""

import argparse
import contextlib
import sys
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar

from armdrive.errors import ArmError
from armdrive.registry import DIALECTS
from tests.conformance.running import BEHAVIOURS, Verdict, run_row

from . import report
from .boards import BOARDS
from .control import NoSimulator
from .grbl_setup import SetUpFailed
from .measuring import stops
from .rigs import Rig, of_image, of_port, own_home, simulated

AXES = "XYZABC"
T = TypeVar("T")


def options(words: Sequence[str] | None) -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.firmware", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    add, flag = parser.add_argument, partial(parser.add_argument, action="store_true")
    for board in BOARDS.values():
        add(f"--{board.name}", metavar="ELF", type=Path, help=board.firmware)
    add("--simavr", metavar="DIR", type=Path, help="a simavr checkout that is built")
    add("--port", help="a device on a port, instead of an image")
    add("--dialect", choices=list(DIALECTS), help="the dialect that the device speaks")
    add("--control", metavar="HOST:PORT", help="its control port, if it has one")
    add("--axes", default=AXES, help="the names of its motors at the control port")
    flag("--yes", help="do not ask whether the real arm is ready")
    add("--simulated", choices=list(DIALECTS), help="the simulated board, in simulated time")
    flag("--rows", help="the rows of the conformance table")
    add("--only", default="", metavar="TEXT", help="rows whose name contains TEXT")
    flag("--stops", help="how soon the arm stands after a stop")
    chosen = parser.parse_args(words)
    if chosen.port and not chosen.dialect:
        parser.error("--port needs --dialect: nothing is sent to find out")
    if not (chosen.port or chosen.simulated or any(_images(chosen))):
        parser.error(f"name an image (--{', --'.join(BOARDS)}), a --port, or --simulated")
    if not (chosen.rows or chosen.only or chosen.stops):
        chosen.rows = chosen.stops = True
    return chosen


def _images(chosen: argparse.Namespace) -> dict[str, Path]:
    found = {name: getattr(chosen, name) for name in BOARDS}
    return {name: image for name, image in found.items() if image is not None}


def rigs(chosen: argparse.Namespace) -> Iterator[Rig]:
    """Make the rigs, one after the other."""
    if chosen.simulated:
        yield simulated(chosen.simulated)
    if chosen.port:
        yield of_port(chosen.dialect, chosen.port, chosen.control, chosen.axes)
    for name, image in _images(chosen).items():
        yield of_image(BOARDS[name], image, chosen.simavr)


class Run:
    """The measurements of one rig, printed as they arrive."""

    def __init__(self, rig: Rig, chosen: argparse.Namespace) -> None:
        self._rig, self._chosen = rig, chosen
        self.broken = False

    def all(self) -> None:
        """Run the chosen measurements."""
        say(f"== {self._rig.name}")
        if self._rig.real and not self._chosen.yes and not confirmed():
            say("not run: not confirmed")
            return
        try:
            # a real arm keeps its records: only the first measurement needs its reference posture
            with own_home() if self._rig.real else contextlib.nullcontext():
                self._with_a_driver()
        except ArmError as error:
            say(f"ended: {error}")
            self.broken = True

    def _with_a_driver(self) -> None:
        if self._chosen.rows or self._chosen.only:
            self.rows()
            if self._rig.real and self.broken:
                say("ended: look at the arm, bring it to its reference posture, and start again")
                return
        if self._chosen.stops:
            self.stops()

    def rows(self) -> None:
        """Run the rows of the conformance table."""
        say("-- rows")
        results = []
        for row in BEHAVIOURS:
            # a row for another transport only is left out
            fits = row.runs_over(self._rig.transport) or row.runs_over("pty")
            if not fits or self._chosen.only not in row.name:
                continue
            with self._rig.home():
                rig = self._rig
                result = run_row(row, rig.dialect, rig.transport, lambda _: self._rig.make())
            results.append(result)
            say(report.row_line(result))
            self._pace(quiet=True)
            if self._rig.real and result.verdict is Verdict.BROKEN:
                break
        say(report.row_summary(results))
        self.broken |= any(each.verdict is Verdict.BROKEN for each in results)

    def stops(self) -> None:
        """Stop motions at several rates, on the device and on the simulated board."""
        say("-- stops")
        if self._rig.real:
            say("not applicable: without a control port the last step cannot be seen")
            return
        with self._rig.home(), self._rig.make() as bench:
            device = list(counted(stops(bench)))
        say(report.stop_table(device))
        self._pace()
        with self._rig.home(), self._rig.twin() as bench:
            twin = list(stops(bench))
        say("simulated board:")
        say(report.stop_table(twin))
        self.broken |= not all(each.kept for each in device)

    def _pace(self, *, quiet: bool = False) -> None:
        ratio = self._rig.pace.taken()
        if ratio is None:
            return
        if not quiet or ratio < report.KEEPS_PACE:
            say(report.pace_line(ratio))


def confirmed() -> bool:
    """Ask whether the real arm is ready."""
    say(
        "This moves a real arm. It must stand in its reference posture with room on all sides, and "
        "you must stand beside it with a hand on the switch of its power supply."
    )
    return input("Type yes to begin: ").strip().lower() == "yes"


def counted(measurements: Iterable[T]) -> Iterator[T]:
    """Show progress on a terminal, because a slow motion takes half a minute."""
    shown = sys.stderr.isatty()
    for number, each in enumerate(measurements, 1):
        if shown:
            sys.stderr.write(f"\r{number} \r")
            sys.stderr.flush()
        yield each


def say(words: str) -> None:
    """Print a line immediately."""
    sys.stdout.write(f"{words}\n")
    sys.stdout.flush()


def main(words: Sequence[str] | None = None) -> int:
    """Measure what is asked for."""
    chosen = options(words)
    runs = []
    try:
        for rig in rigs(chosen):
            runs.append(Run(rig, chosen))
            try:
                runs[-1].all()
            finally:
                rig.close()
    except (NoSimulator, SetUpFailed, ArmError) as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return int(any(run.broken for run in runs))
