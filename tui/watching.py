"""Watching an arm that another program drives: its status, a stop, a pause, a slower tempo.

Leaving stops nothing: the arm is somebody else's. A thread hears of it and keeps the latest view;
the screen looks at that, so that neither waits for the other.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from textual.app import SystemCommand
from textual.binding import BindingType
from textual.screen import Screen

from armdrive.errors import ArmError
from tui import watch_words
from tui.framework import FirstKeys
from tui.keyboard import DEFAULT_KEYS, Keyboard
from tui.keys import STOP
from tui.layout import CSS, bindings
from tui.screens.watch import WatchScreen
from tui.themes import look_after, put_on

if TYPE_CHECKING:
    from kinematics import ArmModel

POLL_S = 0.05
GIVEN_BACK = "the program has given the arm back"
COMMON = (STOP, "quit", "look")
"""The rows of the desk that count here too."""


class Holder(Protocol):
    """The program that drives the arm."""

    def views(self) -> Iterator[Mapping[str, Any]]:
        """Yield its status whenever it has changed, until it gives the arm back."""

    def ask(self, request: str, **words: object) -> Mapping[str, Any]:
        """Ask for something; raises `ArmError` where nobody answers."""


class Watching(FirstKeys):
    """An app that shows somebody else's arm."""

    ENABLE_COMMAND_PALETTE = False
    TITLE = "armdrive"
    ABSENT_S = 1.0
    CSS = CSS
    BINDINGS: ClassVar[list[BindingType]] = [
        *bindings("watch"),
        *(each for each in bindings("") if getattr(each, "id", "") in COMMON),
    ]

    def __init__(
        self,
        name: str,
        model: ArmModel,
        holder: Holder,
        *,
        braille: bool,
        keys: Keyboard = DEFAULT_KEYS,
        look: str = "",
    ) -> None:
        super().__init__()
        self.arm_name = name
        self.model = model
        self.braille = braille
        self.keys = Keyboard(tuple(row for row in keys.rows if row.place or row.id in COMMON))
        self.view: Mapping[str, Any] = {}
        self.ended = ""
        self.message = "watching: nothing here moves the arm, and leaving does not stop it"
        self.look_name = look
        self._holder = holder

    def get_default_screen(self) -> Screen[None]:
        """Return the one screen."""
        return WatchScreen()

    def on_mount(self) -> None:
        """Begin to hear, and to show what was heard."""
        self.look_name = put_on(self, self.look_name)
        self.set_keymap(self.keys.keymap())
        threading.Thread(target=self._hear, name="armdrive-watch", daemon=True).start()
        self.set_interval(POLL_S, self.poll)
        self.call_after_refresh(self.poll)

    def _hear(self) -> None:
        try:
            for view in self._holder.views():
                if "state" not in view:
                    self.ended = str(view.get("error", "it does not let itself be watched"))
                    return
                self.view = view
            self.ended = GIVEN_BACK
        except ArmError as error:
            self.ended = str(error)

    def poll(self) -> None:
        """Show the latest view."""
        self.alive()
        if self.is_running and self.screen_stack and isinstance(self.screen, WatchScreen):
            self.screen.show(self.view, self.ended, self.message)

    def say(self, message: str) -> None:
        """Say something."""
        self.message = message
        self.poll()

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Offer nothing of the framework's own."""
        del screen
        return ()

    # -- what may be asked --------------------------------------------------------------------

    def first_keys(self) -> Mapping[str, Callable[[], None]]:
        """Return what no widget may keep for itself: the stop."""
        return dict.fromkeys(self.keys.of(STOP), self.action_stop_arm)

    def action_stop_arm(self) -> None:
        """Ask for a stop, which is legal at any time."""
        self.say("asking for a STOP ...")
        self._ask("stop", "the arm was told to stop")

    def action_ask(self, request: str) -> None:
        """Ask for a pause, or its end."""
        self._ask(request, f"asked to {request}")

    def action_tempo(self, steps: int) -> None:
        """Ask for a slower tempo, or a less slow one."""
        wanted = watch_words.tempo(watch_words.percent(self.view), steps)
        self._ask("slow", f"asked to go at {wanted} % of the speed", percent=wanted)

    def action_next_look(self) -> None:
        """Put on the next colours."""
        self.look_name = put_on(self, look_after(self.look_name).name)
        self.say(f"look: {self.look_name}")

    def action_leave(self) -> None:
        """Stop watching, and nothing else."""
        self.exit(0)

    def _ask(self, request: str, done: str, **words: object) -> None:
        work = partial(self._asked, request, done, words)
        self.run_worker(work, thread=True, exit_on_error=False)

    def _asked(self, request: str, done: str, words: Mapping[str, object]) -> None:
        try:
            answer = self._holder.ask(request, **words)
            said = str(answer["error"]) if "error" in answer else done
        except ArmError as error:
            said = f"{request.upper()} WAS NOT HEARD: {error}. Use the arm's own switch"
        self.call_from_thread(self.say, said)
