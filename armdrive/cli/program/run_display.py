"""What a running program shows: a line that is rewritten, a line a motion, or JSON lines.

The same picture is what other programs are told of the program (`armdrive status`, `watch`).
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import threading
from collections.abc import Callable, Iterator, Mapping
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self

from armdrive.arm import Arm
from armdrive.cli.presenter import put
from armdrive.errors import Stopped
from armdrive.errors.printable import printable
from armdrive.programs.problems import SourceMark
from armdrive.programs.progress import Estimate, RunProgress

if TYPE_CHECKING:  # a script has no acts
    from armdrive.programs.acts import Answer
    from armdrive.programs.program import Machine
    from armdrive.programs.running import RunStep

REDRAW_S = 0.2
CLEAR_LINE = "\r\x1b[K"
STANDARD_OUTPUT = 1
ASKING = ("home",)
"""Acts and calls that may ask the person something."""


class Display:
    """Shows one run. `lines` are the program's own, of which the one under way is shown.

    Every method may be called from any thread.
    """

    def __init__(
        self,
        lines: list[str],
        emit: Callable[[dict[str, Any]], None] | None,
        *,
        rewrites: bool,
    ) -> None:
        """With `emit`, events go there as plain data; else text goes to standard output."""
        self._lines = lines
        self._emit = emit
        self._rewrites = rewrites and emit is None
        self._progress = RunProgress(())
        self._share = 1.0
        self._arm: Arm | None = None
        self._mark: SourceMark | None = None
        self._act = ""
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
        self.at(None, step.stage.mark, step.act_name, loop=step.loop, loud=step.moves)

    def ended(self, step: RunStep, answer: Answer, took_s: float) -> None:
        """Tell programs what an act brought."""
        if self._emit is not None:
            brought = answer if isinstance(answer, bool | float | int) else None
            self._write(
                {
                    "event": "done",
                    **step.view(),
                    "answer": brought,
                    "took_s": round(took_s, 3),
                }
            )

    def use(self, arm: Arm) -> None:
        """Look at this arm from now on, and let other programs know what it is at work on."""
        with self._lock:
            self._arm = arm
        arm.program = self.view

    def at(
        self, arm: Arm | None, mark: SourceMark, act: str, *, loop: int = 1, loud: bool = True
    ) -> None:
        """Show where the program is; `loud` is worth a line of its own."""
        with self._lock:
            self._arm = arm or self._arm
            self._mark, self._act, self._loop = mark, act, loop
            self._progress.begins(mark, loop)
            self._began_s = 0.0 if self._arm is None else self._arm.pace.now_s()
            view = self.view()
            if self._emit is not None:
                self._write({"event": "act", **view})
            elif self._draws:
                self._draw(view)
            elif loud:
                self._wipe()
                self._print(place_words(view))

    def say(self, text: str) -> None:
        """Show what the program says."""
        self._tell({"event": "say", "text": text}, text)

    def waits(self, text: str) -> None:
        """Show what a person is waited for."""
        words = f"{text}: " * bool(text)
        self._tell(
            {"event": "hold", "text": text}, f"{words}Enter goes on, and so does `armdrive resume`"
        )

    def tell(self, event: dict[str, Any], text: str) -> None:
        """Show something else: an event for programs, a line for people."""
        self._tell(event, text)

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
                "loop": self._loop,
                "loops": self._loops,
                "percent": None if estimate.percent is None else round(estimate.percent, 1),
                "left_s": None if estimate.left_s is None else round(estimate.left_s, 1),
            }

    def source(self, line: int) -> str:
        """Return a line of the program."""
        return self._lines[line - 1].strip() if 0 < line <= len(self._lines) else ""

    @property
    def _draws(self) -> bool:
        """Whether the line may be rewritten now: not where a question may stand in it."""
        return self._rewrites and self._act.lower() not in ASKING

    def _estimate(self) -> Estimate:
        if self._arm is None:
            return Estimate()
        share = self._arm.speed_override / self._share
        return self._progress.estimate(self._arm.pace.now_s() - self._began_s, share)

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
            self._tell({"event": word.replace(" ", "-"), **self.view()}, word)
        if self._draws:
            self._draw(self.view())

    def _tell(self, event: dict[str, Any], text: str) -> None:
        with self._lock:
            if self._emit is not None:
                self._write(event)
            else:
                self._wipe()
                self._print(text)

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
    return f"{share}  {loop}{line_words(view['line'], view['text'] or view['act'])}{left}"


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
