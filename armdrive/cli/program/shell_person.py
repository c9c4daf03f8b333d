"""The person at the prompt: what an entry says, what is shown of it, and what is waited for."""

from __future__ import annotations

import contextlib
import signal
import time
from collections.abc import Callable, Iterator
from typing import Any

from armdrive.arm import Arm
from armdrive.cli.presenter import put
from armdrive.cli.program.run_display import Display
from armdrive.cli.terminal_person import ask_operator
from armdrive.dialog.operator import PostureRequest
from armdrive.moves import GraspMove
from armdrive.programs.acts import Answer, Say
from armdrive.programs.language.values import to_json
from armdrive.programs.program import Machine
from armdrive.programs.running import RunStep
from armdrive.programs.session import Typed
from armdrive.setup.keyboard import raw_terminal

LOOK_EVERY_S = 0.05
ENTER = (b"\r", b"\n")


class ShellShown(Display):
    """Shows an entry while it is carried out: its lines are found where they were typed."""

    def __init__(
        self, typed: Typed, emit: Callable[[dict[str, Any]], None] | None, *, rewrites: bool
    ) -> None:
        super().__init__([], emit, rewrites=rewrites)
        self._typed = typed

    def source(self, line: int) -> str:
        """Return the line that is carried out."""
        return self._typed.line_at(self._mark).strip() if self._mark else super().source(line)

    def begins(self, step: RunStep, machine: Machine) -> None:  # noqa: ARG002 - as every onlooker
        """Show an act, but not on a line of its own: the person has just typed it."""
        act = step.act_name
        self.at(None, step.stage.mark, act, loop=step.loop, loud=False)

    def ended(self, step: RunStep, answer: Answer, took_s: float) -> None:
        """Say what a grasp found; tell programs what every act brought."""
        super().ended(step, answer, took_s)
        grasped = isinstance(step.move, GraspMove)
        if grasped and isinstance(answer, float) and self._emit is None:
            self.say(f"grasped: {answer:.1f} mm wide" if answer else "grasped nothing")


class ShellSaid:
    """Says values: to programs as such."""

    def __init__(self, tell: Callable[[dict[str, Any], str], None]) -> None:
        self._tell = tell
        self._values: object = []

    def begins(self, step: RunStep, machine: Machine) -> None:  # noqa: ARG002 - as every onlooker
        """Look at the values that are about to be said."""
        if isinstance(step.stage.act, Say):
            self._values = [to_json(value) for value in step.stage.act.values]

    def ended(self, step: RunStep, answer: Answer, took_s: float) -> None:
        """Hear of the end of an act."""

    def say(self, text: str) -> None:
        """Say them."""
        self._tell({"event": "value", "values": self._values, "text": text}, text)


class AtPrompt:
    """Hands on what a program says, and waits for Enter where there is a terminal for it."""

    def __init__(
        self, arm: Arm, display: Display, say: Callable[[str], None], *, typing: bool
    ) -> None:
        self._arm = arm
        self._display = display
        self._say = say
        self._typing = typing

    def say(self, text: str) -> None:
        """Show a line of text."""
        self._say(text)

    def hold(self, text: str, over: Callable[[], bool]) -> None:
        """Pause the arm until Enter, `armdrive resume` from elsewhere, or a stop.

        Lines that a pipe brings are entries and no answers: there, Enter does not count.
        """
        self._arm.pause()
        with _keys(self._typing) as pressed:
            self._tell(text)
            while self._arm.paused and not over():
                if pressed():
                    self._arm.resume()
                    return

    def _tell(self, text: str) -> None:
        if self._typing:
            self._display.waits(text)
            return
        words = f"{text}: " * bool(text)
        self._display.tell(
            {"event": "hold", "text": text}, f"{words}`armdrive resume` lets it go on"
        )


@contextlib.contextmanager
def _keys(typing: bool) -> Iterator[Callable[[], bool]]:
    """Yield what waits a moment and tells whether Enter was pressed."""
    if not typing:

        def never() -> bool:
            time.sleep(LOOK_EVERY_S)
            return False

        yield never
        return

    with raw_terminal() as terminal:

        def entered() -> bool:
            keys = terminal.read(LOOK_EVERY_S)
            return any(key in keys for key in ENTER)

        yield entered


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
