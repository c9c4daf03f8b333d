"""Watching an arm that another program drives: its status, a stop, a pause, a lower speed.

Leaving stops nothing: another program drives the arm. A thread receives and keeps the latest view;
the screen looks at that, so that neither waits for the other.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import ClassVar, cast

from textual.app import ComposeResult, SystemCommand
from textual.binding import BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.screen import Screen

from armdrive.errors import ArmError, BadRequest
from armdrive.errors.actions import COMMAND_LINE, presented
from armdrive.render.canvas import draws_braille
from armdrive.render.scene import Moment
from armdrive.status import LABEL, STATUS_FIELDS, Current, State, Status, Trust, status_rows
from armdrive.storage.lock_client import ask_holder, watch_holder
from kinematics.presets import ArmModel
from kinematics.spaces import Joints
from tui.app import POLL_S, KeyApp
from tui.arm_view import SpaceView
from tui.keys.keyboard import DEFAULT_KEYS, Keyboard, bindings, keyboard_of
from tui.keys.table import STOP
from tui.safety import (
    NO_STOP,
    QUIET,
    WRONG,
    SafetyPanel,
    View,
    badge_of,
    progress_of,
    stopping_text,
    titled_arm,
)
from tui.settings import memory_file, neighbour, recall
from tui.widgets import fill_frame, framed, panels, show_panel, text_of

# What the screen says about the arm, made from the plain data of its status.

# Percent of the speed that is asked for.
PERCENTS = (10, 25, 50, 75, 100)


# What a status and a report have under the same name and in the same unit.
SHOWN_ALIKE = (
    "arm", "title", "link", "dialect", "simulated", "trust_reason", "gripper_mm", "paused",
    "speed_override", "stop_time_s", "stop_distance_mm", "silent_time_s", "silent_distance_mm",
)  # fmt: skip


def status_of(view: View, model: ArmModel) -> Status:
    """Return the status that another program reports, as far as it is shown here.

    The posture is not known if it is of another arm than the file here describes.
    """
    names, angles = model.arm.joint_names, view["joints"] or {}
    joints = None
    if set(angles) == {f"{name}_deg" for name in names}:
        joints = Joints(tuple(math.radians(angles[f"{name}_deg"]) for name in names), names)
    return Status(
        **{name: view[name] for name in SHOWN_ALIKE},
        state=State(view["state"]),
        trust=Trust(view["trust"]),
        current=Current(view["current"]),
        joints=joints,
    )


# The rows of a status that the safety panel has.
IN_SAFETY_PANEL = ("state", "position", "stop")

# The rows that a small terminal must not cut off.
FIRST = ("program", "notice", "error")


def lines(view: View) -> str:
    """Say what the safety panel does not."""
    if not view:
        return "waiting for its status"
    rows = [row for row in status_rows(view) if row.label not in IN_SAFETY_PANEL]
    rows.sort(key=lambda row: row.label not in FIRST)
    # in the words of the command line: no key of this app acts on the arm
    words = (presented(str(row), COMMAND_LINE) for row in rows)
    return "\n".join((f"{'speed':<{LABEL}}{percent(view)}%", *words))


def percent(view: View) -> int:
    """Return the speed that the arm may go at, in percent of what it is asked for."""
    override: float = view.get("speed_override", 1.0)
    return round(override * 100)


# The screen, on which nothing moves the arm, and its app.


class WatchScreen(Screen[None]):
    """A picture and words of what another program says of its arm."""

    AUTO_FOCUS = ""
    place = "watch"

    @property
    def watching(self) -> Watching:
        """The app that the screen belongs to."""
        return cast("Watching", self.app)

    def compose(self) -> ComposeResult:
        """Lay the screen out: the arm on the left, words and numbers on the right."""
        yield from framed([SafetyPanel(self.watching.keys)], self._body())

    def _body(self) -> ComposeResult:
        app = self.watching
        with Horizontal():
            yield SpaceView(app.model, braille=app.braille, id="space")
            with VerticalScroll(id="panels", can_focus=False):
                yield from panels(program="Program", watched="Status")

    def on_mount(self) -> None:
        """Show what arrived before the screen was laid out."""
        self.call_after_refresh(self.watching.poll)

    def show(self) -> None:
        """Show what is known, why it is no longer new, and the last message."""
        app, view, ended = self.watching, self.watching.view, self.watching.ended
        status, program = status_of(view, app.model) if view else None, view.get("program") or {}
        panel = self.query_one(SafetyPanel)
        if status is None:
            panel.show(
                f"WATCHING {app.arm_name}", ("LOST", WRONG) if ended else ("WAITING", QUIET), ended
            )
        else:
            reason = "" if status.trust is Trust.REFERENCED else f": {status.trust_reason}"
            panel.show(
                titled_arm(replace(status, arm=app.arm_name), progress_of(program), ", WATCHED"),
                ("NOT WATCHED", WRONG) if ended else badge_of(status),
                ended or "another program drives it",
                status.trust,
                f"position {status.trust.value}{reason}",
                NO_STOP if ended else stopping_text(status),
                real=not status.simulated,
            )
        line = ""
        if program.get("line"):
            line = f"{program['line']}  {program.get('text') or program.get('act') or ''}"
        show_panel(self, "program", line)
        text_of(self, "watched").show(lines(view))
        fill_frame(self, app.message, app.keys.next_keys(self.place, app.idle))
        shown = Moment() if status is None else Moment(status.joints, status.gripper_mm)
        self.query_one(SpaceView).show(shown)


GIVEN_BACK = "the program has released the arm"
ANOTHER_VERSION = "its program is another version of armdrive, whose reports differ"
# The rows of the desk that count here too.
COMMON = (STOP, "quit", "look")


class Watching(KeyApp):
    """An app that shows an arm that another program drives."""

    TITLE = "armdrive"
    BINDINGS: ClassVar[list[BindingType]] = bindings("watch", COMMON)

    def __init__(
        self,
        name: str,
        model: ArmModel,
        views: Iterable[View],
        ask: Callable[..., View],
        *,
        braille: bool,
        keys: Keyboard = DEFAULT_KEYS,
        look: str = "",
    ) -> None:
        """`views` are the reports of the program that drives the arm, `ask` what it is asked by."""
        super().__init__(keys.only("watch", COMMON), braille=braille, look=look)
        self.arm_name = name
        self.model = model
        self.view: View = {}
        self.ended = ""
        self.message = "watching: no key here begins a motion, and leaving does not stop the arm"
        self._views = views
        self._ask_holder = ask

    def get_default_screen(self) -> Screen[None]:
        """Return the one screen."""
        return WatchScreen()

    def on_mount(self) -> None:
        """Begin to receive views, and to show them."""
        threading.Thread(target=self._receive, name="armdrive-watch", daemon=True).start()
        self.set_interval(POLL_S, self.poll)
        self.call_after_refresh(self.poll)

    def _receive(self) -> None:
        try:
            ended = GIVEN_BACK
            for view in self._views:
                if not view.keys() >= STATUS_FIELDS.keys():
                    ended = ANOTHER_VERSION
                    break
                self.view = view
        except ArmError as error:
            ended = str(error)
        self.message = ""  # it was about a program that drove the arm
        self.ended = ended

    @property
    def idle(self) -> tuple[str, ...]:
        """The rows of keys that would change nothing now."""
        if self.ended:
            return tuple(row.id for row in self.keys.rows if row.id != "quit")
        return ("watch-pause" if self.view.get("paused") else "watch-resume",)

    def poll(self) -> None:
        """Show the latest view, and ask for what a press has confirmed."""
        self.input.alive()
        self.act_on_confirmed()
        self.show()

    def get_system_commands(self, screen: Screen[object]) -> Iterable[SystemCommand]:
        """Offer nothing of the framework's own."""
        del screen
        return ()

    # -- what may be asked --------------------------------------------------------------------

    def action_stop_arm(self) -> None:
        """Ask for a stop, which is legal at any time."""
        self.say("asking for a STOP ...")
        self._ask("stop", "the arm was asked to stop")

    def action_ask(self, request: str) -> None:
        """Ask for a pause."""
        self._ask(request, f"asked to {request}")

    def action_resume(self) -> None:
        """Ask for the end of a pause, once no other key has followed: then the arm moves."""
        self.confirmation.press("resumes", partial(self.action_ask, "resume"), needed=1)

    def action_change_speed(self, by: int) -> None:
        """Ask for a lower or higher speed."""
        wanted = neighbour(PERCENTS, percent(self.view), by)
        self._ask("slow", f"asked to move at {wanted} % of its speed", percent=wanted)

    def action_leave(self) -> None:
        """Stop watching, and nothing else."""
        self.exit(0)

    def _ask(self, request: str, done: str, **words: object) -> None:
        if self.ended and request != "stop":  # a stop is tried whatever is known
            raise BadRequest(f"no key but {self.keys.label('quit')} does anything: {self.ended}")
        self.calls.make(partial(self._asked, request, done, words))

    def _asked(self, request: str, done: str, words: Mapping[str, object]) -> str:
        try:
            answer = self._ask_holder(request, **words)
        except ArmError as error:
            return f"{request.upper()} WAS NOT RECEIVED: {error}. Use the arm's power switch"
        return str(answer.get("error", done))


def run_watch(name: str, model: ArmModel, *, ascii_only: bool = False) -> int:
    """Show an arm that another program drives, until the user leaves; return the exit code.

    Nothing here moves the arm, and leaving does not stop it.
    """
    braille = draws_braille(ascii_only=ascii_only)
    left = recall(memory_file())
    keys = keyboard_of(left.layout)
    views, ask = watch_holder(name, POLL_S), partial(ask_holder, name)
    app = Watching(name, model, views, ask, braille=braille, keys=keys, look=left.look)
    app.run_or_raise()
    return app.return_code or 0
