"""Type the words of a program at a prompt: each is carried out at once."""

from __future__ import annotations

import argparse
import contextlib
import sys

from armdrive.arm import Arm
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.presenter import put, put_error, say
from armdrive.cli.program.run_common import make_ready, put_blocks, require_table
from armdrive.cli.program.shell_lines import TypedLines
from armdrive.cli.program.shell_person import ask_at_prompt
from armdrive.cli.program.shell_session import Left, Shell
from armdrive.cli.program.shell_words import OWN_WORDS, known_words
from armdrive.cli.terminal_person import settle_trust
from armdrive.errors import ArmError, BadRequest, OperatorNeeded
from armdrive.errors.actions import SHELL, presented
from armdrive.status import State, pose_view
from kinematics.errors import KinematicsError

PROMPT, MORE = "> ", "... "


def run(options: argparse.Namespace) -> int:
    """Take lines until they end."""
    at_terminal = sys.stdin.isatty() and not options.json
    require_table(chosen_target(options), options.put)
    arm = connect_chosen(options, pace=options.pace, allow_restored=options.allow_restored)
    with contextlib.closing(arm):
        put_blocks(arm, options.put)
        if not options.json:
            say(arm.status.which)
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
    shell = Shell(arm, options, OWN_WORDS, typing=False)
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
    shell.tell({"event": "end", "entries": shell.done, "pose": pose}, "")
    return 0


def from_a_terminal(arm: Arm, options: argparse.Namespace) -> int:
    """Take lines at a prompt until the person leaves."""
    shell = Shell(arm, options, OWN_WORDS, typing=True)
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
        except KeyboardInterrupt:  # while nothing could hear it as a stop
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
