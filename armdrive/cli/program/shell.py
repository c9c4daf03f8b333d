"""Type the words of a program at a prompt: each is carried out at once.

Lines come from a person, with a history and completion where this system has readline, or from a
pipe.
"""

from __future__ import annotations

import argparse
import contextlib
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from types import MappingProxyType, ModuleType

from armdrive.arm import Arm
from armdrive.cli.chosen_arm import enable_if_settled
from armdrive.cli.presenter import agreed, as_json, complain, forget_typed, put
from armdrive.cli.program.run_arm import connect_to_run
from armdrive.cli.program.run_output import Display
from armdrive.cli.program.run_person import LOOK_EVERY_S, Pressed, RunTerminal, stopped_by_interrupt
from armdrive.cli.terminal_operator import ask_operator, settle_trust
from armdrive.dialog import PostureRequest
from armdrive.errors import ArmError, BadRequest, OperatorNeeded
from armdrive.errors.actions import SHELL
from armdrive.errors.printable import in_words
from armdrive.errors.table import tagged
from armdrive.programs.problems import ProgramError, SourceLines, SourceMark, mark_of
from armdrive.programs.program import Program
from armdrive.programs.shell import INPUT, Answers, Left, Shell, known_words
from armdrive.setup.keyboard import raw_terminal
from armdrive.status import IMMOBILE, WAYS_OUT, pose_view
from kinematics.errors import KinematicsError
from kinematics.text import sentence

READLINE: ModuleType | None
try:
    import readline
except ImportError:  # Windows
    READLINE = None
else:
    READLINE = readline

NOTHING: SourceLines = MappingProxyType({})

# What stands between two words.
BREAKS = ' \t\n(),=+-*/<>%"'


def complete_lines(words: Callable[[], Sequence[str]]) -> None:
    """Complete typed words on Tab, where this system has readline.

    `words` returns what there is to complete now.
    """
    if READLINE is None:
        return
    found: list[str] = []

    def complete(text: str, state: int) -> str | None:
        """Return the next word that begins like this one, as readline asks for them."""
        if state == 0:
            low = text.lower()
            found[:] = sorted({each for each in words() if each.lower().startswith(low)})
        return found[state] if state < len(found) else None

    READLINE.set_completer_delims(BREAKS)
    READLINE.set_completer(complete)
    libedit = "libedit" in (READLINE.__doc__ or "")
    READLINE.parse_and_bind("bind ^I rl_complete" if libedit else "tab: complete")


# What the person at the prompt answers, and what they are shown.

ENTER = (b"\r", b"\n")


@contextlib.contextmanager
def keys_at_prompt() -> Iterator[Pressed]:
    """Yield a test whether Enter was pressed, without reading a line, which readline would take."""
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


class ShellTerminal:
    """Takes lines for a shell on one arm, and shows what comes of them."""

    def __init__(self, arm: Arm, options: argparse.Namespace, *, typing: bool) -> None:
        self.shell = Shell(arm, agreed, typing=typing)
        self._as_json = as_json(options)

    def display(self, lines: SourceLines = NOTHING) -> Display:
        """Return what shows an entry with these lines."""
        rewrites = None if self.shell.typing else False
        return Display(lines, as_json=self._as_json, rewrites=rewrites, words=SHELL, prompt=True)

    def take(self, line: str, position: int = 1) -> None:
        """Take a line: an entry's, or one of the shell's own words.

        `position` is its number in the input. Raises what the entry does, and `Left` for `quit`.
        """
        answers = self.shell.own_word(line)
        if answers is not None:
            self._show(answers, position)
        elif (entry := self.shell.session.take(line, position)) is not None:
            self._carry_out(entry)

    def _show(self, answers: Answers, position: int) -> None:
        try:
            with self._stopped():
                for each in answers:
                    self.display().tell({"event": "reply", "text": each}, each)
        except ArmError:
            if not (self.shell.typing or self._as_json):
                complain(str(SourceMark(position, 1, INPUT)))
            raise

    def _carry_out(self, entry: Program) -> None:
        """Carry an entry out, shown as it is."""
        shell = self.shell
        machine = shell.machine(entry)
        shown = self.display(entry.lines)
        keys = keys_at_prompt if shell.typing else None  # lines of a pipe are no answers
        person = RunTerminal(shell.arm, shown, keys)
        with shown.shown(), self._stopped(ends=not shell.typing):
            shown.run.use(shell.arm)
            try:
                before, after = [shown.begins], [shown.ended]
                shell.carry_out(entry, machine, person, before=before, after=after)
            except BaseException as error:
                self._failed(entry, error, shown)
                raise

    def _stopped(self, *, ends: bool = True) -> contextlib.AbstractContextManager[None]:
        """Return what makes Ctrl-C stop the arm."""
        arms = [self.shell.arm]
        return stopped_by_interrupt(lambda: arms, ends=ends, as_json=self._as_json)

    def _failed(self, entry: Program, error: BaseException, shown: Display) -> None:
        """Show where an entry ended early, unless it is the only line, which was just typed."""
        at = self.shell.at
        mark = mark_of(error, None if at is None else at.mark)
        seen = mark is not None and mark.file == entry.file and "\n" not in entry.text
        if self._as_json or not (self.shell.typing and seen):
            shown.failed(mark, error, "")

    def complain(self, error: BaseException) -> None:
        """Say what went wrong, and what can be typed now."""
        said = in_words(error) if isinstance(error, OSError) else error
        complain(f"armdrive: {tagged(said)}", SHELL)
        state = self.shell.arm.status.state
        mistyped = isinstance(error, ProgramError)
        if state in IMMOBILE and not mistyped and WAYS_OUT[state] not in str(error):
            complain(sentence(WAYS_OUT[state]), SHELL)
        if self.shell.session.unfinished:
            complain("the line was not taken; Ctrl-C leaves the block")


# Taking lines until they end: of a pipe up to the first error, at a prompt through every error.

PROMPT, MORE = "> ", "... "


def run(options: argparse.Namespace) -> int:
    """Take lines until they end."""
    take = from_a_terminal if _at_terminal(options) else from_a_pipe
    with contextlib.closing(connect_to_run(options, settle=_settle)) as arm:
        return take(arm, options)


def _at_terminal(options: argparse.Namespace) -> bool:
    return sys.stdin.isatty() and not as_json(options)


def _settle(arm: Arm, options: argparse.Namespace) -> None:
    """Settle whether the position can be trusted; at a terminal a no leaves the prompt there."""
    at_terminal = _at_terminal(options)
    try:
        settle_trust(arm)
    except OperatorNeeded:
        if not at_terminal:
            raise
    if at_terminal and not arm.simulated:
        arm.operator = ask_at_prompt
    enable_if_settled(arm)


def from_a_pipe(arm: Arm, options: argparse.Namespace) -> int:
    """Carry out all lines of standard input; the first error ends it, and is raised."""
    options.interface = SHELL  # what an error tells to do is a line before the one that failed
    terminal = ShellTerminal(arm, options, typing=False)
    shell, tell_event = terminal.shell, terminal.display().tell
    tell_event({"event": "begin", "arm": arm.config.name, "simulated": arm.simulated}, "")
    try:
        for position, line in enumerate(sys.stdin, 1):
            terminal.take(line.removeprefix("\ufeff").rstrip("\r\n"), position)
        shell.session.end()
    except Left:
        shell.session.abandon()
    except UnicodeDecodeError as error:
        raise BadRequest(f"the input is not UTF-8 text: {error.reason}") from None
    pose = pose_view(arm.status.pose)
    tell_event({"event": "end", "entries": shell.done, "pose": pose}, "")
    return 0


def from_a_terminal(arm: Arm, options: argparse.Namespace) -> int:
    """Take lines at a prompt until the person leaves."""
    terminal = ShellTerminal(arm, options, typing=True)
    complete_lines(lambda: known_words(terminal.shell))
    put("`help` lists the words; Ctrl-D or `quit` leaves\n")
    shown = ""
    with contextlib.suppress(Left):
        while True:
            shown = _tell_news(arm, shown)
            _take_typed(terminal)
    return 0


def _take_typed(terminal: ShellTerminal) -> None:
    """Take what is typed next, or pasted, and show what went wrong. Raises `Left` at the end."""
    session = terminal.shell.session
    try:
        text = input(MORE if session.unfinished else PROMPT)
        for line in text.splitlines() or [""]:
            terminal.take(line)
    except EOFError:  # Ctrl-D leaves the block first
        put("\n")
        if not session.unfinished:
            raise Left from None
        session.abandon()
    except KeyboardInterrupt:  # nothing moves: a running entry catches Ctrl-C itself
        put("\n")
        session.abandon()
    except (ArmError, KinematicsError, OSError) as error:
        forget_typed()  # the rest of what was pasted goes on from a line that failed
        terminal.complain(error)


def _tell_news(arm: Arm, shown: str) -> str:
    """Say what happened to the arm while nothing was typed; return it, so that it is said once."""
    status = arm.status
    news = f"the arm is {status.state.where}: {status.error}" if status.error else ""
    if news and news != shown:
        complain(news, SHELL)
    return news
