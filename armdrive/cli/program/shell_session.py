"""Takes the lines of a prompt: carries entries out on the arm, and does the shell's own words."""

from __future__ import annotations

import argparse
import contextlib
import json
import re
import signal
import sys
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any, TypeAlias

from armdrive.arm import Arm
from armdrive.blocking import run_blocking
from armdrive.cli.presenter import put, put_error, say, say_lines
from armdrive.cli.program.run_common import (
    LOOK_EVERY_S,
    Display,
    Pressed,
    RunTerminal,
    failed_view,
    stopped_by_interrupt,
)
from armdrive.cli.terminal_person import ask_operator
from armdrive.dialog.operator import PostureRequest
from armdrive.errors import ArmError, NotReferenced, OperatorNeeded
from armdrive.errors.actions import SHELL, presented
from armdrive.errors.table import tagged
from armdrive.programs.acts import Say
from armdrive.programs.language.values import to_json
from armdrive.programs.problems import ProgramError, SourceMark
from armdrive.programs.program import ArmProgram, Machine
from armdrive.programs.running import Performer, ProgramRun
from armdrive.programs.session import PromptEntry, Session
from armdrive.setup.keyboard import raw_terminal
from armdrive.status import State

ENTER = (b"\r", b"\n")


@contextlib.contextmanager
def keys_at_prompt() -> Iterator[Pressed]:
    """Yield what tells whether Enter was pressed: not as a line, which readline would take."""
    with raw_terminal() as terminal:

        def pressed() -> bool:
            keys = terminal.read(LOOK_EVERY_S)
            return any(key in keys for key in ENTER)

        yield pressed


def ask_at_prompt(request: PostureRequest) -> bool:
    """Ask whether the arm stands in a posture; Ctrl-C is a no."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        return ask_operator(request)
    except KeyboardInterrupt:
        put("\n")
        return False
    finally:
        signal.signal(signal.SIGINT, before)


INPUT = "standard input"
"""What the lines of a pipe are called."""

WAYS_OUT: Mapping[State, str] = MappingProxyType(
    {
        State.ERROR_STOP: "look at the arm; `reset` leaves the error, and moves nothing",
        State.DISABLED: "`enable` switches the motors on",
        State.DISCONNECTED: "`reconnect` looks for the wire; `save` and `quit` need none",
    }
)
"""What is to be typed where the arm stands in a state that nothing moves in."""

REFERENCE = "`home` references the arm"

_LINE = re.compile(r"\s*([a-z]+)(?:\s+([^\s=(].*?))?\s*", re.IGNORECASE)
"""A word and what stands behind it; `list = 3` gives a name a value."""


class Left(Exception):
    """The person is done."""


Deed: TypeAlias = Callable[["Shell", str], None]
"""What does a word of the shell, with what stands behind it."""


def own_word(line: str, words: Mapping[str, Deed]) -> tuple[Deed, str] | None:
    """Return what does the word of the shell that a line is, and what stands behind the word."""
    match = _LINE.fullmatch(line)
    deed = None if match is None else words.get(match[1].lower())
    return None if deed is None or match is None else (deed, match[2] or "")


class Shell:
    """A prompt's session on one arm.

    `words` are the shell's own; `typing` tells that a person types, and not a pipe.
    """

    def __init__(
        self,
        arm: Arm,
        options: argparse.Namespace,
        words: Mapping[str, Deed],
        *,
        typing: bool,
    ) -> None:
        self.arm = arm
        self.words = words
        self.json = bool(options.json)
        self.typing = typing
        self.saved: set[str] = set()
        self.done = 0
        self._stops = arm.stops
        self._outputs = 0
        self.begin_anew()

    def begin_anew(self) -> None:
        """Forget all that was typed; what the arm does stays."""
        self.session = Session("" if self.typing else INPUT)

    def tell(self, event: dict[str, Any], text: str) -> None:
        """Say something: an event for programs, lines for people."""
        if self.json:
            self.emit(event)
        elif text:
            say_lines(presented(text, SHELL))

    def emit(self, event: dict[str, Any]) -> None:
        """Print an event, in the words of the prompt."""
        say(presented(json.dumps(event), SHELL))

    def take(self, line: str, position: int = 1) -> None:
        """Take a line: an entry's, or one of the shell's own words.

        `position` is its number in the input. Raises what the entry does, and `Left` for `quit`.
        """
        own = None if self.session.unfinished else own_word(line, self.words)
        if own is not None:
            self._do(*own, position)
            return
        self.session.book = frozenset(self.arm.points)
        entry = self.session.take(line, position)
        if entry is not None:
            self.carry_out(entry)

    def _do(self, deed: Deed, rest: str, position: int) -> None:
        try:
            with stopped_by_interrupt(lambda: [self.arm]):
                deed(self, rest)
        except ArmError as error:
            if not (self.typing or self.json or isinstance(error, ProgramError)):
                put_error(f"{SourceMark(position, 1, INPUT)}\n")
            raise

    def carry_out(self, entry: PromptEntry) -> None:
        """Carry an entry out, and learn what it brought, also where it broke off."""
        try:
            machine = ArmProgram(entry.program, self.arm.config).machine()
            self._perform(entry, machine)
        except ProgramError as error:
            raise self.session.typed.shown(error) from None
        self.done += 1

    def _perform(self, entry: PromptEntry, machine: Machine) -> None:
        rewrites = self.typing and sys.stdout.isatty()
        emit = self.emit if self.json else None
        shown = Display([], emit, rewrites=rewrites, typed=self.session.typed)
        with shown, stopped_by_interrupt(lambda: [self.arm], ends=not self.typing):
            self._forget_stops()
            keys = keys_at_prompt if self.typing else None  # lines of a pipe are no answers
            said = partial(self._say_values, machine) if entry.says else None
            person = RunTerminal(self.arm, shown, keys, said)
            performer = Performer(self.arm, person, since=self._stops, outputs=self._outputs)
            shown.use(self.arm)
            onlookers = [] if entry.says else [shown]
            run = ProgramRun(lambda: machine, performer, onlookers)
            self._carry_out(entry, machine, run)
            self._outputs = performer.outputs

    def _say_values(self, machine: Machine, text: str) -> None:
        """Say values: to programs as such."""
        stage = machine.next()
        values = stage.act.values if stage is not None and isinstance(stage.act, Say) else ()
        view = {"event": "value", "values": list(map(to_json, values)), "text": text}
        self.tell(view, text)

    def _forget_stops(self) -> None:
        """Take a stop between two entries of a person for one of neither; a pipe it ends."""
        if self.typing and self.arm.stops != self._stops:
            # a stop that the engine has not seen yet would end the next motion
            run_blocking(self.arm.runner.stand_still())
            self._stops = self.arm.stops

    def _carry_out(self, entry: PromptEntry, machine: Machine, run: ProgramRun) -> None:
        done = False
        try:
            run.carry_out()
            done = True
        except BaseException as error:
            self._tell_place(entry, run, error)
            raise
        finally:
            self.session.learn(entry, machine, done=done)
            self.arm.program = None

    def _tell_place(self, entry: PromptEntry, run: ProgramRun, error: BaseException) -> None:
        """Say at which line an entry broke off, where the person would not know."""
        mark = None if run.at is None else run.at.stage.mark
        if self.json:
            self.emit(failed_view(getattr(error, "mark", None) or mark, error, ""))
        elif mark is not None and not isinstance(error, ProgramError):
            line = self.session.typed.line_at(mark).strip()
            if not self.typing:
                put_error(f"{mark}\n    {line}\n")
            elif entry.lines > 1 or mark.file != entry.program.file:
                put_error(f"at `{line}`:\n")

    def complain(self, error: BaseException) -> None:
        """Say what went wrong, and what can be typed now."""
        put_error(f"armdrive: {presented(tagged(error), SHELL)}\n")
        ways = [WAYS_OUT.get(self.arm.status.state, "")]
        ways += [REFERENCE] * isinstance(error, NotReferenced | OperatorNeeded)
        put_error("".join(f"{way}\n" for way in ways if way))
        if self.session.unfinished:
            put_error("the line was not taken; Ctrl-C leaves the block\n")
