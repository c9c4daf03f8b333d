"""Type the words of a program at a prompt: each is carried out at once.

Lines come from a person, with a history and completion where this system has readline, or from a
pipe.
"""

from __future__ import annotations

import argparse
import contextlib
import signal
import sys
from collections.abc import Callable, Sequence
from types import FrameType, ModuleType, TracebackType
from typing import NoReturn, Self

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import as_json, put, put_error, tell
from armdrive.cli.program.run_common import make_ready, put_blocks, require_table
from armdrive.cli.program.shell_session import Left, Shell, ask_at_prompt, known_words
from armdrive.cli.terminal_person import settle_trust
from armdrive.errors import ArmError, BadRequest, OperatorNeeded
from armdrive.errors.actions import SHELL, presented
from armdrive.status import State, pose_view
from armdrive.storage import files as places
from armdrive.storage.files import DISK, replace_file
from kinematics.errors import KinematicsError

if sys.platform != "win32":
    import termios

READLINE: ModuleType | None
try:
    import readline
except ImportError:  # Windows
    READLINE = None
else:
    READLINE = readline

HISTORY = "shell_history"
LARGEST_BYTES = 1_000_000
LIBEDIT_MARK = "_HiStOrY_V2_"
"""The first line of a history that macOS's readline wrote itself, as it once did here."""
MOST_LINES = 1000
"""Lines that the history keeps."""

BREAKS = ' \t\n(),=+-*/<>%"'
"""What stands between two words."""


class TypedLines:
    """Asks for lines. `words` is what there is to complete now."""

    def __init__(self, words: Callable[[], Sequence[str]]) -> None:
        self.interrupted = ""
        self._words = words
        self._found: list[str] = []
        self._readline = READLINE

    def __enter__(self) -> Self:
        if self._readline is not None:
            _prepare(self._readline, self._complete)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._readline is not None:
            with contextlib.suppress(OSError):  # a full disk keeps no history, and nothing worse
                _write_history(self._readline)
            self._readline.set_completer(None)

    def read(self, prompt: str) -> str | None:
        """Return the next line; None at the end of the input.

        Raises `KeyboardInterrupt`; then `interrupted` is what had been typed.
        """
        before = signal.signal(signal.SIGINT, self._interrupt)
        try:
            return input(prompt)
        except EOFError:
            return None
        finally:
            signal.signal(signal.SIGINT, before)

    def forget(self) -> None:
        """Forget what was typed or pasted beyond the line that was taken last."""
        if sys.platform != "win32":
            with contextlib.suppress(termios.error, OSError, ValueError):
                termios.tcflush(sys.stdin.fileno(), termios.TCIFLUSH)

    def _interrupt(self, number: int, frame: FrameType | None) -> NoReturn:  # noqa: ARG002
        self.interrupted = "" if self._readline is None else self._readline.get_line_buffer()
        raise KeyboardInterrupt

    def _complete(self, text: str, state: int) -> str | None:
        """Return the next word that goes on like this one, as readline asks for them."""
        if state == 0:
            low = text.lower()
            self._found = sorted({each for each in self._words() if each.lower().startswith(low)})
        return self._found[state] if state < len(self._found) else None


def _prepare(readline: ModuleType, complete: Callable[[str, int], str | None]) -> None:
    _read_history(readline)
    readline.set_history_length(MOST_LINES)
    readline.set_completer_delims(BREAKS)
    readline.set_completer(complete)
    libedit = "libedit" in (readline.__doc__ or "")
    readline.parse_and_bind("bind ^I rl_complete" if libedit else "tab: complete")


def _read_history(readline: ModuleType) -> None:
    """Recall what was typed before. readline's own reading follows links and waits for pipes."""
    try:
        data = DISK.read_own(places.states() / HISTORY, LARGEST_BYTES, end=True)
    except OSError:
        return
    for line in data.decode("utf-8", errors="replace").splitlines():
        if line != LIBEDIT_MARK:
            readline.add_history(line)


def _write_history(readline: ModuleType) -> None:
    """Keep the last lines. Raises `OSError`. readline's own writing follows links."""
    last = readline.get_current_history_length()
    numbers = range(max(last - MOST_LINES, 0) + 1, last + 1)
    lines = [readline.get_history_item(number) or "" for number in numbers]
    text = "\n".join(lines).encode("utf-8", errors="replace")  # a terminal may send any bytes
    replace_file(places.states() / HISTORY, text.decode("utf-8"))


# Taking lines until they end: of a pipe up to the first error, at a prompt through every error.

PROMPT, MORE = "> ", "... "


def run(options: argparse.Namespace) -> int:
    """Take lines until they end."""
    at_terminal = sys.stdin.isatty() and not as_json(options)
    require_table(chosen_target(options), options.put)
    arm = connect_chosen(options, pace=options.pace, allow_restored=options.allow_restored)
    with contextlib.closing(arm):
        put_blocks(arm, options.put)
        tell(options, arm.status.which)
        _settle(arm, at_terminal)
        make_ready(arm, options)
        return (from_a_terminal if at_terminal else from_a_pipe)(arm, options)


def _settle(arm: Arm, at_terminal: bool) -> None:
    """Settle whether the position can be trusted; at a terminal a no leaves the prompt there."""
    try:
        settle_trust(arm)
    except OperatorNeeded:
        if not at_terminal:
            raise
    if at_terminal and not arm.simulated:
        arm.operator = ask_at_prompt


def from_a_pipe(arm: Arm, options: argparse.Namespace) -> int:
    """Carry out all lines of standard input; the first error ends it, and is raised."""
    shell = Shell(arm, options, typing=False)
    shell.tell(
        {"event": "begin", "arm": arm.config.name, "simulated": arm.simulated},
        "",
    )
    try:
        for position, line in enumerate(sys.stdin, 1):
            shell.take(line.rstrip("\r\n"), position)
        shell.session.end()
    except Left:
        shell.session.abandon()
    except UnicodeDecodeError as error:
        raise BadRequest(f"the input is no text in UTF-8: {error.reason}") from None
    pose = pose_view(arm.status.pose)
    shell.tell({"event": "end", "entries": shell.on_arm.done, "pose": pose}, "")
    return 0


def from_a_terminal(arm: Arm, options: argparse.Namespace) -> int:
    """Take lines at a prompt until the person leaves."""
    shell = Shell(arm, options, typing=True)
    with TypedLines(lambda: known_words(shell)) as lines:
        put("`help` lists the words; Ctrl-D or `quit` leaves\n")
        _PromptLoop(shell, lines).run()
    return 0


class _PromptLoop:
    """Asks for line after line, and shows what went wrong without ending."""

    def __init__(self, shell: Shell, lines: TypedLines) -> None:
        self._shell = shell
        self._lines = lines
        self._leaving = False
        self._told = ""

    def run(self) -> None:
        """Take lines until the person leaves."""
        while True:
            self._tell_news()
            session = self._shell.session
            try:
                text = self._lines.read(MORE if session.unfinished else PROMPT)
            except KeyboardInterrupt:
                if self._left_by_interrupt():
                    return
                continue
            self._leaving = False
            if text is None:
                put("\n")
                if not session.unfinished:
                    return
                session.abandon()
            elif not self._took(text):
                return

    def _left_by_interrupt(self) -> bool:
        """Forget the line, then the block; Ctrl-C twice where there is neither leaves."""
        put("\n")
        session = self._shell.session
        anything = bool(self._lines.interrupted) or session.unfinished
        session.abandon()
        if anything:
            self._leaving = False
            return False
        if self._leaving:
            return True
        self._leaving = True
        put("Ctrl-C again leaves, as `quit` does\n")
        return False

    def _took(self, text: str) -> bool:
        """Take what was typed, or pasted; after an error the rest of it is forgotten."""
        try:
            for line in text.splitlines() or [""]:
                self._shell.take(line)
        except Left:
            return False
        except (ArmError, KinematicsError, OSError) as error:
            self._lines.forget()
            self._shell.complain(error)
        except KeyboardInterrupt:  # while no arm was there to stop
            put("\n")
        return True

    def _tell_news(self) -> None:
        """Say what happened to the arm while nothing was typed."""
        status = self._shell.arm.status
        bad = status.state in (State.ERROR_STOP, State.DISCONNECTED)
        news = f"the arm is in {status.state.value}: {status.error}" if bad else ""
        if news and news != self._told:
            put_error(f"{presented(news, SHELL)}\n")
        self._told = news
