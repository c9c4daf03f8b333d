"""Takes the lines of a prompt: carries entries out on the arm, and does the shell's own words."""

from __future__ import annotations

import argparse
import contextlib
import re
import signal
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from types import MappingProxyType
from typing import Any, TypeAlias

from armdrive.arm import Arm
from armdrive.cli.presenter import put, put_error
from armdrive.cli.program.run_common import (
    LOOK_EVERY_S,
    Pressed,
    RunTerminal,
    stopped_by_interrupt,
)
from armdrive.cli.program.run_output import Display, RunOutput
from armdrive.cli.terminal_person import ask_operator
from armdrive.dialog.operator import PostureRequest
from armdrive.errors import ArmError, NotReferenced, OperatorNeeded
from armdrive.errors.actions import SHELL, presented
from armdrive.errors.table import tagged
from armdrive.programs.acts import Say
from armdrive.programs.interpreter import to_json
from armdrive.programs.problems import ProgramError, SourceMark, mark_of
from armdrive.programs.program import Machine
from armdrive.programs.session import INPUT, ArmSession, PromptEntry, Session
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


ShellAction: TypeAlias = Callable[["Shell", str], None]
"""What does a word of the shell, with what stands behind it."""


def own_word(line: str, words: Mapping[str, ShellAction]) -> tuple[ShellAction, str] | None:
    """Return what does the word of the shell that a line is, and what stands behind the word."""
    match = _LINE.fullmatch(line)
    action = None if match is None else words.get(match[1].lower())
    return None if action is None or match is None else (action, match[2] or "")


class Shell:
    """A prompt's session on one arm.

    `words` are the shell's own; `typing` tells that a person types, and not a pipe.
    """

    def __init__(
        self,
        arm: Arm,
        options: argparse.Namespace,
        words: Mapping[str, ShellAction],
        *,
        typing: bool,
    ) -> None:
        self.arm = arm
        self.words = words
        self.typing = typing
        self._output = RunOutput(
            as_json=bool(options.json), rewrites=None if typing else False, words=SHELL
        )
        self.on_arm = ArmSession(arm, typing=typing)

    @property
    def session(self) -> Session:
        """What has been typed so far."""
        return self.on_arm.session

    @property
    def json(self) -> bool:
        """Whether events are printed instead of text."""
        return self._output.as_json

    def tell(self, event: Mapping[str, Any] | None, text: str) -> None:
        """Say something: an event for programs, lines for people."""
        self._output.tell(event, text)

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

    def _do(self, action: ShellAction, rest: str, position: int) -> None:
        try:
            with stopped_by_interrupt(lambda: [self.arm]):
                action(self, rest)
        except ArmError as error:
            if not (self.typing or self.json or isinstance(error, ProgramError)):
                put_error(f"{SourceMark(position, 1, INPUT)}\n")
            raise

    def carry_out(self, entry: PromptEntry) -> None:
        """Carry an entry out, shown as it is."""
        machine = self.on_arm.machine(entry)
        shown = Display(self._output, entry.program.lines, prompt=True)
        keys = keys_at_prompt if self.typing else None  # lines of a pipe are no answers
        show_values = partial(self._say_values, machine) if entry.says else None
        person = RunTerminal(self.arm, shown, keys, show_values)
        with shown, stopped_by_interrupt(lambda: [self.arm], ends=not self.typing):
            shown.run.use(self.arm)
            try:
                self.on_arm.carry_out(entry, machine, person, [] if entry.says else [shown])
            except BaseException as error:
                self._failed(entry, error, shown)
                raise

    def _say_values(self, machine: Machine, text: str) -> None:
        """Say values: to programs as such."""
        stage = machine.next()
        values = stage.act.values if stage is not None and isinstance(stage.act, Say) else ()
        view = {"event": "value", "values": list(map(to_json, values)), "text": text}
        self.tell(view, text)

    def _failed(self, entry: PromptEntry, error: BaseException, shown: Display) -> None:
        """Show where an entry ended early, unless it is the only line, which was just typed."""
        at = self.on_arm.at
        mark = mark_of(error, None if at is None else at.mark)
        program = entry.program
        seen = mark is not None and mark.file == program.file and "\n" not in program.text
        if self.json or not (self.typing and seen):
            shown.failed(mark, error, "")

    def complain(self, error: BaseException) -> None:
        """Say what went wrong, and what can be typed now."""
        put_error(f"armdrive: {presented(tagged(error), SHELL)}\n")
        ways = [WAYS_OUT.get(self.arm.status.state, "")]
        ways += [REFERENCE] * isinstance(error, NotReferenced | OperatorNeeded)
        put_error("".join(f"{way}\n" for way in ways if way))
        if self.session.unfinished:
            put_error("the line was not taken; Ctrl-C leaves the block\n")
