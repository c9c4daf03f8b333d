"""What a person and other programs see of a run, how they answer it, and how it begins and ends.

Program files, scripts and the entries of a prompt are run with it.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import queue
import re
import shutil
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager
from types import FrameType, TracebackType
from typing import TYPE_CHECKING, Any, Self

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import as_json, complain, put, put_error, tell
from armdrive.cli.terminal_person import ask_operator, settle_trust
from armdrive.connect.target import Target
from armdrive.errors import ArmError, ArmInUse, BadRequest, DeviceFault, LinkError, Stopped
from armdrive.errors.printable import printable
from armdrive.errors.table import error_view, tagged
from armdrive.programs.attended import put_blocks, silent_time_s, time_s
from armdrive.programs.problems import SourceMark, excerpt
from armdrive.programs.progress import Estimate, RunProgress
from armdrive.runtime.clock import PaceChoice
from armdrive.sim.world.table import TableBlock
from armdrive.status import State, pose_view

if TYPE_CHECKING:
    from armdrive.programs.acts import Answer
    from armdrive.programs.program import Machine
    from armdrive.programs.running import RunStep
    from armdrive.programs.session import Typed

# A person's answers while a program runs: Enter, `armdrive resume`, and Ctrl-C.

LOOK_EVERY_S = 0.05


class PromptLines:
    """Lines of standard input as they are typed, read by a thread that nobody waits for.

    Read by its number and not through Python's own buffer, whose lock a blocked thread would keep
    from a program that ends.
    """

    def __init__(self, number: int | None) -> None:
        self._number = number
        self._lines: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._begun = False

    def forget(self) -> None:
        """Forget what a person typed before being asked; what a pipe brings is an answer."""
        if self._number is not None and os.isatty(self._number):
            while self.take():
                pass

    def take(self) -> bool:
        """Tell whether a line has come, and take it."""
        if not self._begun:
            self._begun = True
            threading.Thread(target=self._read, name="lines", daemon=True).start()
        with contextlib.suppress(queue.Empty):
            self._lines.get_nowait()
            return True
        return False

    @contextlib.contextmanager
    def keys(self) -> Iterator[Pressed]:
        """Yield what tells whether a line comes from now on."""
        self.forget()
        yield lambda: self.take() or unpressed()

    def _read(self) -> None:
        if self._number is None:
            return
        with contextlib.suppress(OSError):
            while data := os.read(self._number, 4096):
                for _ in range(data.count(b"\n")):
                    self._lines.put("")


def standard_input() -> PromptLines:
    """Return the lines of standard input; none where there is none."""
    try:
        return PromptLines(sys.stdin.fileno())
    except (OSError, ValueError, AttributeError):
        return PromptLines(None)


Pressed = Callable[[], bool]
"""Waits a moment, and tells whether Enter was pressed meanwhile."""


def unpressed() -> bool:
    """Wait a moment in which nobody can press anything."""
    time.sleep(LOOK_EVERY_S)
    return False


class RunTerminal:
    """Shows what a program says; while it waits for a person the arm is paused, as by `pause`.

    `keys` gives what hears of Enter while a person is waited for; None where there is no Enter.
    `say` shows what is said, if not `shown`.
    """

    def __init__(
        self,
        arm: Arm,
        shown: Display,
        keys: Callable[[], AbstractContextManager[Pressed]] | None,
        say: Callable[[str], None] | None = None,
    ) -> None:
        self.say = say or shown.say
        self._arm = arm
        self._shown = shown
        self._keys = keys

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        """Wait for Enter, for `armdrive resume` from elsewhere, or until nobody waits any more."""
        self._arm.pause()
        with self._keys() if self._keys else contextlib.nullcontext(unpressed) as pressed:
            self._shown.waits(text, enter=self._keys is not None)
            while self._arm.paused and not over():
                if pressed():
                    self._arm.resume()
                    return


# The first Ctrl-C stops the arm; the second one leaves at once.

INTERRUPTED = 130


@contextlib.contextmanager
def stopped_by_interrupt(arms: Callable[[], Iterable[Arm]], *, ends: bool = True) -> Iterator[None]:
    """Have the first Ctrl-C stop every arm and end the program, and the next one leave at once.

    Without `ends` nothing but the arms is interrupted: who waits for one hears that it stopped.

    Whoever leaves at once closes nothing: what an arm was sent runs to its end, which its status
    announces, and nothing further is sent.
    """
    pressed = False

    def interrupt(number: int, frame: FrameType | None) -> None:  # noqa: ARG001
        nonlocal pressed
        if pressed:
            _leave(arms())
        pressed = True
        for arm in arms():
            arm.request_stop()
        _say("\nstopping the arm; Ctrl-C again leaves at once\n")
        if ends:
            raise KeyboardInterrupt

    try:
        before = signal.signal(signal.SIGINT, interrupt)
    except ValueError:  # not the main thread, which alone hears signals
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _leave(arms: Iterable[Arm]) -> None:
    _say(f"left: the arm may go on for {silent_time_s(arms):.1f} s, and nobody remembers where\n")
    os._exit(INTERRUPTED)


def _say(words: str) -> None:
    """Write past Python's buffer: a signal that came while that was written out may not enter it.

    The second of two quick presses comes as a rule while the words of the first are written.
    """
    try:
        os.write(sys.stderr.fileno(), words.encode())
    except (OSError, ValueError):  # closed, or none of the system's
        with contextlib.suppress(OSError, ValueError):
            sys.stderr.write(words)


# What a running program shows: a line that is rewritten, a line a motion, or JSON lines.
#
# The same picture is what other programs are told of the program (`armdrive status`, `watch`).

REDRAW_S = 0.2
CLEAR_LINE = "\r\x1b[K"
STANDARD_OUTPUT = 1
ASKING = ("home",)
"""Acts and calls that may ask the person something."""


class Display:
    """Shows one run. `lines` are the program's own, of which the one under way is shown.

    At a prompt, where a person has just typed what is `typed`, lines are found there, and an act
    is not worth a line of its own. Every method may be called from any thread.
    """

    def __init__(
        self,
        lines: list[str],
        emit: Callable[[dict[str, Any]], None] | None,
        *,
        rewrites: bool,
        typed: Typed | None = None,
    ) -> None:
        """With `emit`, events go there as plain data; else text goes to standard output."""
        self._lines = lines
        self._typed = typed
        self._emit = emit
        self._rewrites = rewrites and emit is None
        self._progress = RunProgress(())
        self._share = 1.0
        self._arm: Arm | None = None
        self._mark: SourceMark | None = None
        self._act = ""
        self._waiting = ""
        self._loop = 1
        self._loops = 1
        self._began_s = 0.0
        self._paused = False
        self._drawn = False
        self._lock = threading.RLock()
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look, name="progress", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._over.set()
        self._thread.join()
        with self._lock:
            self._wipe()

    def follow(self, progress: RunProgress, *, share: float = 1.0, loops: int = 1) -> None:
        """Estimate by a rehearsal, in which the arm went with `share` of its speed."""
        with self._lock:
            self._progress, self._share, self._loops = progress, share, loops

    # -- what happens -------------------------------------------------------------------------

    def begins(self, step: RunStep, machine: Machine) -> None:  # noqa: ARG002 - as every onlooker
        """Show an act of a program file."""
        self.at(
            None,
            step.stage.mark,
            step.act_name,
            loop=step.loop,
            loud=step.moves and self._typed is None,
            waiting=step.waiting,
        )

    def ended(self, step: RunStep, answer: Answer, took_s: float) -> None:
        """Tell programs what an act brought; at a prompt, say what a grasp found."""
        if self._emit is not None:
            brought = answer if isinstance(answer, bool | float | int) else None
            took = {"answer": brought, "took_s": round(took_s, 3)}
            self._write({"event": "done", **step.view(), **took})
        elif self._typed is not None and step.grasps and isinstance(answer, float):
            self.say(f"grasped: {answer:.1f} mm wide" if answer else "grasped nothing")

    def use(self, arm: Arm) -> None:
        """Look at this arm from now on, and let other programs know what it is at work on."""
        with self._lock:
            self._arm = arm
        arm.program = self.view

    def at(
        self,
        arm: Arm | None,
        mark: SourceMark,
        act: str,
        *,
        loop: int = 1,
        loud: bool = True,
        waiting: str = "",
    ) -> None:
        """Show where the program is, on a line of its own if it is `loud` or waits."""
        with self._lock:
            self._arm = arm or self._arm
            self._mark, self._act, self._loop, self._waiting = mark, act, loop, waiting
            self._progress.begins(mark, loop)
            self._began_s = 0.0 if self._arm is None else time_s(self._arm)
            view = self.view()
            if self._emit is not None:
                self._write({"event": "act", **view})
                if waiting:
                    self._write({"event": "wait", **view})
            elif self._draws:
                self._draw(view)
            elif waiting and self._typed is not None:
                self._print(waiting)
            elif loud or waiting:
                self._wipe()
                self._print(place_words(view))

    def say(self, text: str) -> None:
        """Show what the program says."""
        self.tell({"event": "say", "text": text}, text)

    def waits(self, text: str, *, enter: bool = True) -> None:
        """Show what a person is waited for, and how that is answered."""
        words = f"{text}: " * bool(text)
        goes_on = "Enter goes on, and so does `armdrive resume`"
        how = goes_on if enter else "`armdrive resume` lets it go on"
        self.tell({"event": "hold", "text": text}, f"{words}{how}")

    def tell(self, event: dict[str, Any], text: str) -> None:
        """Show something else: an event for programs, a line for people."""
        with self._lock:
            if self._emit is not None:
                self._write(event)
            else:
                self._wipe()
                self._print(text)

    # -- what is shown ------------------------------------------------------------------------

    def view(self) -> dict[str, Any]:
        """Return where the program is, as plain data."""
        with self._lock:
            if self._mark is None:
                return {}
            estimate = self._estimate()
            return {
                "file": self._mark.file,
                "line": self._mark.line or None,
                "column": self._mark.column,
                "text": self.source(self._mark.line),
                "act": self._act,
                "waiting": self._waiting or None,
                "loop": self._loop,
                "loops": self._loops,
                "percent": None if estimate.percent is None else round(estimate.percent, 1),
                "left_s": None if estimate.left_s is None else round(estimate.left_s, 1),
            }

    def source(self, line: int) -> str:
        """Return a line of the program."""
        if self._typed is not None and self._mark is not None:
            return self._typed.line_at(self._mark).strip()
        return self._lines[line - 1].strip() if 0 < line <= len(self._lines) else ""

    @property
    def _draws(self) -> bool:
        """Whether the line may be rewritten now: not where a question may stand in it."""
        return self._rewrites and self._act.lower() not in ASKING

    def _estimate(self) -> Estimate:
        if self._arm is None:
            return Estimate()
        share = self._arm.speed_override / self._share
        return self._progress.estimate(time_s(self._arm) - self._began_s, share)

    def _look(self) -> None:
        """Show now and then what changes between two acts, while anybody reads it."""
        with contextlib.suppress(OSError, Stopped):
            while not self._over.wait(REDRAW_S):
                with self._lock:
                    self._look_once()

    def _look_once(self) -> None:
        arm = self._arm
        if arm is None or self._mark is None:
            return
        if arm.paused is not self._paused:
            self._paused = arm.paused
            word = "paused" if self._paused else "going on"
            self.tell({"event": word.replace(" ", "-"), **self.view()}, word)
        if self._draws:
            self._draw(self.view())

    def _draw(self, view: Mapping[str, Any]) -> None:
        columns = shutil.get_terminal_size().columns
        arm = self._arm
        slowed = arm is not None and arm.speed_override < 1.0
        words = place_words(view) + "  slowed" * slowed + "  PAUSED" * self._paused
        self._put(printable(words)[: columns - 1], CLEAR_LINE)
        self._drawn = True

    def _wipe(self) -> None:
        if self._drawn:
            self._put("", CLEAR_LINE)
            self._drawn = False

    def _print(self, text: str) -> None:
        self._put(f"{text}\n")

    def _put(self, text: str, control: str = "") -> None:
        with _heard():
            put(text, control=control)

    def _write(self, event: dict[str, Any]) -> None:
        if self._emit is not None:
            with _heard():
                self._emit(event)


@contextlib.contextmanager
def _heard() -> Iterator[None]:
    """Turn a reader that has gone into a stop: a program does not end well because of that."""
    try:
        yield
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), STANDARD_OUTPUT)
        raise Stopped("nobody reads any more what the program says: it was ended") from None


# A running program's position and times as text.

_SAID = re.compile(r"""(?:"[^"]*"|'[^']*'|[^"'#])*(?=#)""")
"""What stands in a line before its comment; nothing where there is none."""


def place_words(view: Mapping[str, Any]) -> str:
    """Return where a program is, as a line for people."""
    percent, left_s = view["percent"], view["left_s"]
    share = "    " if percent is None else f"{percent:3.0f}%"
    left = "" if left_s is None else f"  {duration(left_s)} left"
    several = view["loops"] != 1
    loop = f"loop {view['loop']}  " if several else ""
    waiting = f"  {view['waiting']}" if view["waiting"] else ""
    line = line_words(view["line"], view["text"] or view["act"])
    return f"{share}  {loop}{line}{waiting}{left}"


def line_words(line: int | None, text: str) -> str:
    """Return a line of a program with its number, where anybody knows that, and no comment."""
    said = _SAID.match(text)
    text = said.group().rstrip() if said else text
    return f"line {line}: {text}" if line else text


def duration(time_s: float) -> str:
    """Return a time for people: seconds, or minutes and seconds, or hours and minutes."""
    if time_s < 60.0:
        return f"{time_s:.1f} s" if time_s < 10.0 else f"{time_s:.0f} s"
    minutes, seconds = divmod(round(time_s), 60)
    if minutes < 60:
        return f"{minutes} min {seconds} s"
    return f"{minutes // 60} h {minutes % 60} min"


# What running a program file and running a script have in common: arms, pictures, ends.


def connect_to_run(options: argparse.Namespace, *, pace: PaceChoice = None) -> Arm:
    """Connect to the arm that the options name, and settle whether its position can be trusted."""
    require_table(chosen_target(options), options.put)
    arm = connect_chosen(options, pace=options.pace or pace, allow_restored=options.allow_restored)
    try:
        put_blocks(arm, options.put)
        options.put = []  # once, however often a script connects
        tell(options, arm.status.which)
        if arm.simulated or not options.check:
            settle_trust(arm)
        if not arm.simulated and sys.stdin.isatty() and not as_json(options):
            arm.operator = ask_operator  # for a program that references the arm
    except BaseException:
        arm.close()
        raise
    return arm


def connect_to_check(options: argparse.Namespace) -> tuple[Arm | None, str]:
    """Connect to ask where the arm stands; return why not, where that cannot be."""
    try:
        return connect_to_run(options), ""
    except (LinkError, ArmInUse, DeviceFault) as error:
        which = chosen_target(options).config.title
        return None, f"the {which} cannot be asked where it stands ({error})"


def require_table(target: Target, blocks: list[TableBlock]) -> None:
    """Raise `BadRequest` where blocks are to be put on the table of a real arm."""
    if blocks and not target.simulated:
        raise BadRequest(
            f"--put puts blocks on the table of a simulated arm, and {target.config.name} is a "
            "real one: lay them out by hand"
        )


def make_ready(arm: Arm, options: argparse.Namespace) -> None:
    """Switch an arm on that is about to be moved, and slow it down as asked for."""
    if arm.status.state is State.DISABLED:
        arm.enable()
    slow_down(arm, options)


def slow_down(arm: Arm, options: argparse.Namespace) -> None:
    """Slow an arm down to the speed that the person asked for."""
    if options.speed is not None:
        arm.speed_override = options.speed


def display_for(options: argparse.Namespace, lines: list[str]) -> Display:
    """Return what shows the run, as the person or the program that reads it wants it."""
    output = sys.stdout  # kept: what a script prints may be led elsewhere meanwhile

    def write(event: dict[str, Any]) -> None:
        put(f"{json.dumps(event)}\n", output=output)

    return Display(lines, write if as_json(options) else None, rewrites=output.isatty())


def show_place(mark: SourceMark | None, lines: list[str], error: BaseException) -> None:
    """Show a line of the program with a caret under the place, where the error does not do so."""
    if mark is None or getattr(error, "mark", None) is not None:
        return
    put_error(f"{mark}\n")
    if 0 < mark.line <= len(lines):
        put_error(f"{excerpt(lines[mark.line - 1], mark.column)}\n")


def tell_failure(
    display: Display,
    mark: SourceMark | None,
    error: BaseException,
    how_far: str,
    resume: str = "",
) -> None:
    """Say how far a run came that did not end well."""
    display.tell(failed_view(mark, error, resume), f"ended early: {how_far}")


def failed_view(mark: SourceMark | None, error: BaseException, resume: str) -> dict[str, Any]:
    """Return the end of a run that did not end well, as plain data."""
    return {
        "event": "failed",
        "line": None if mark is None else mark.line,
        "column": None if mark is None else mark.column,
        "error": error_view(error),
        "resume": resume or None,
    }


def stands_at(arm: Arm) -> str:
    """Say where an arm stands, as far as anybody knows."""
    status = arm.status
    return "nobody knows where the arm stands" if status.pose is None else f"tip {status.pose}"


def ended_view(arm: Arm | None, acts: int, took_s: float) -> dict[str, Any]:
    """Return the end of a run that went well, as plain data."""
    pose = None if arm is None else pose_view(arm.status.pose)
    return {"event": "end", "acts": acts, "took_s": round(took_s, 3), "pose": pose}


def keep_recording(arm: Arm, options: argparse.Namespace) -> None:
    """Write the recording of a run, if one is wanted; how the run ended counts for more."""
    if options.record is None:
        return
    try:
        arm.save_recording(options.record)
    except ArmError as error:
        complain(f"armdrive: {tagged(error)}")
