"""The safety panel of every screen: which arm, its state, its position, what a stop takes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from textual.app import ComposeResult
from textual.containers import Horizontal, Vertical
from textual.content import Content
from textual.widgets import Static

from armdrive.errors.printable import printable
from armdrive.registry import DIALECTS
from armdrive.status import (
    IMMOBILE,
    WAYS_OUT,
    Current,
    State,
    Status,
    Trust,
    coded,
    farthest,
    longest,
    motors_words,
    trust_words,
)
from kinematics.text import sentence
from tui.keys.keyboard import Keyboard
from tui.keys.table import PAUSE, STOP, Needs
from tui.widgets import UNKNOWN, PlainText, Span, text_of

# What another program reports about its arm, or about the program it runs, as plain data.
View = Mapping[str, Any]

# Green is well, blue the arm at work, amber near or armed, red stop or wrong, none ignorable.
#
# These fill the ground of a word. Text on the ground of the screen has the theme's `$text-warning`
# and so on, which can be read in a light look too.
GOOD, BUSY, CAREFUL, WRONG, QUIET = "$success", "$primary", "$warning", "$error", ""

# The one word for each state, and its colour.
BADGES: Mapping[State, Span] = {
    State.DISCONNECTED: ("LINK LOST", WRONG),
    State.ERROR_STOP: ("ERROR", WRONG),
    State.DISABLED: ("DISABLED", QUIET),
    State.STANDBY: ("READY", GOOD),
    State.HOMING: ("HOMING", BUSY),
    State.MOVING: ("MOVING", BUSY),
    State.STOPPING: ("STOPPING", CAREFUL),
}

# Stands for the state of a disabled arm that is known to have no current.
MOTORS_OFF: Span = ("MOTORS OFF", QUIET)

# The row of the table of keys that leads out of each state in which nothing can move the arm.
LEADS_OUT: Mapping[State, str] = {
    State.DISCONNECTED: "reconnect",
    State.ERROR_STOP: "reset",
    State.DISABLED: "motors",
}

ARMED: Span = ("ARMED", CAREFUL)
PAUSED: Span = ("PAUSED", CAREFUL)

DOTS: Mapping[Trust, Span] = {
    Trust.REFERENCED: ("\N{BLACK CIRCLE}", "$text-success"),
    Trust.RESTORED: ("\N{BLACK CIRCLE}", "$text-warning"),
    Trust.SUSPECT: ("\N{BLACK CIRCLE}", "$text-error"),
    Trust.UNKNOWN: ("\N{WHITE CIRCLE}", QUIET),
}


def badge_of(status: Status, *, armed: bool = False) -> Span:
    """Return the badge of a state; a pause is shown only where the arm could move without it."""
    if status.state is State.DISABLED and status.current is Current.OFF:
        return MOTORS_OFF
    if status.paused and status.state not in IMMOBILE:
        return PAUSED
    return ARMED if armed and status.state is State.STANDBY else BADGES[status.state]


def titled_arm(status: Status, program: str, watched: str = "") -> str:
    """Say whether the arm is real, which it is, how a real one is linked, and what it runs.

    An arm that is named by its port is named only once.
    """
    kind, link = ("SIMULATED", "") if status.simulated else ("REAL ARM", status.link)
    named_by_port = bool(link) and link.startswith(status.arm.partition("?")[0])
    name = status.title if named_by_port else f"{status.arm} ({status.title})"
    return f"{kind}{watched}: {name}{f' on {link}' if link else ''}  {program}".rstrip()


def position_text(status: Status, keys: Keyboard) -> str:
    """Say how far the position can be trusted, and which key makes it trusted now, if one does."""
    trust = status.trust
    if trust is Trust.REFERENCED:
        return f"position referenced {status.trust_age.removeprefix('for ')} ago"
    if status.state is State.ERROR_STOP:
        return f"position {trust.value}"  # the line above says why, and what comes first
    reference = keys.label("reference")
    if trust is Trust.UNKNOWN and can_reference(status.state):
        return f"position unknown: press {reference} to reference the arm"
    way = ""
    if trust is Trust.RESTORED and status.state is not State.DISCONNECTED:
        way = f"{keys.label('confirm')} confirms it"
    elif can_reference(status.state):
        way = f"{reference} references the arm"
    reason = f"{way} ({status.trust_reason})" if way else status.trust_reason
    return f"position {trust.value}: {reason}"


def can_reference(state: State) -> bool:
    """Return whether a key references the arm in this state."""
    return state not in (*IMMOBILE, State.HOMING)


# What can be said of an arm whose program has ended.
NO_STOP = "no stop reaches the arm: use its own stop or power switch"


def bound_text(distance_mm: float, time_s: float) -> str:
    """Say how far and how long something goes on at most."""
    return f"{farthest(distance_mm)}, {longest(time_s)}"


def stopping_text(status: Status) -> str:
    """Say how far and how long the tip goes on at most, after a stop or after a lost link.

    That is for the motion under way, or for the fastest one while none is planned. The present
    speed is known to the controller alone.
    """
    if status.state is State.DISCONNECTED:
        silent = bound_text(status.silent_distance_mm, status.silent_time_s)
        return f"NO STOP REACHES IT; it ends by itself within {silent}"
    return f"a stop takes up to {bound_text(status.stop_distance_mm, status.stop_time_s)}"


def without_link(status: Status) -> str:
    """Say what stops an arm that no key reaches."""
    row = DIALECTS.get(status.dialect)
    return "" if row is None else row.quick_stop


def way_out(state: State, keys: Keyboard) -> str:
    """Say what leads out of a state in which nothing can move the arm; empty in others."""
    if state not in IMMOBILE:
        return ""
    return keys.presented(WAYS_OUT[state])


def why_immobile(status: Status, keys: Keyboard) -> str:
    """Say why no key can move the arm now, and what to do; empty if one can."""
    motors = motors_words(status.state.value, status.current.value)
    why = {
        State.DISCONNECTED: "there is no link to the arm, and no key moves it",
        State.ERROR_STOP: "the arm is in error-stop",
        State.DISABLED: f"the motors are {motors}",
    }
    way = way_out(status.state, keys)
    return f"{why[status.state]}: {way}" if way else ""


NEEDS_POSITION = "this needs a position that can be trusted"


def hindrance(needs: Needs, status: Status, keys: Keyboard) -> str:
    """Say why a key that needs this of the arm would do nothing now; empty if nothing hinders it.

    A restored position counts once the operator has confirmed it.
    """
    least = Needs.LINK if status.state is State.DISCONNECTED else Needs.MOTORS
    if needs >= least and (why := why_immobile(status, keys)):
        return why
    if needs < Needs.POSITION or status.trust is Trust.REFERENCED:
        return ""
    if not can_reference(status.state):
        return f"{NEEDS_POSITION}: wait until the arm stands"
    key = keys.label("confirm" if status.trust is Trust.RESTORED else "reference")
    return f"{NEEDS_POSITION}: press {key} first"


def banner(status: Status, keys: Keyboard, *, reconnects: bool, place: str) -> str:
    """Say on the screen `place` what forbids all motion, and what to do; empty if nothing does."""
    if status.state in (State.DISCONNECTED, State.ERROR_STOP):
        reason = (
            coded(status.error, status.error_code)
            or coded(status.notice, status.notice_code)
            or trust_words(status.trust.value, status.trust_reason, status.trust_code)
        )
        trying = "The desk keeps trying to reconnect. " if reconnects else ""
        known = WAYS_OUT[status.state] in reason
        way = "" if known else f"{sentence(way_out(status.state, keys))} "
        tail = f"{keys.label('quit')} leaves."
        if status.state is State.ERROR_STOP:
            trying, tail = "", "That moves nothing."
        return f"{reason.rstrip('.')}. {trying}{way}{tail}"
    if status.paused:
        where = "" if keys.row(PAUSE).counts_at(place) else " on the move screen"
        return f"{keys.label(PAUSE)}{where} resumes it, {keys.label(STOP)} ends the motion."
    if status.speed_override < 1.0:
        share = f"{status.speed_override:.0%}"
        return f"SLOWED from outside to {share}: `armdrive slow 100%` ends that."
    return ""


def after_reset(status: Status, keys: Keyboard) -> str:
    """Say what a reset has led to."""
    way = way_out(status.state, keys)
    return "reset: nothing was moved" + (f"; {way}" if way else "")


def progress_of(program: View) -> str:
    """Name a program, and how far it has come; empty without a program."""
    if not program:
        return ""
    name, percent = Path(str(program.get("file", UNKNOWN))).name, program.get("percent")
    return f"{name} {percent:.0f}%" if isinstance(percent, int | float) else name


# Between two facts on one line.
FACT_GAP = "   "


class StopButton(Static, can_focus=False):
    """Stops the arm. The app takes a mouse button that is pressed on it before anything else."""

    def __init__(self, keys: Keyboard) -> None:
        super().__init__(Content(f"   STOP   \n          \n{keys.label(STOP):^10}"), id="stop")


class SafetyPanel(Horizontal):
    """The one place for the arm's state, how far its position can be trusted, and the stop."""

    def __init__(self, keys: Keyboard) -> None:
        super().__init__(id="safety", classes="panel")
        self.arm = ""
        """Which arm the title of the panel names."""
        self._keys = keys

    def compose(self) -> ComposeResult:
        """Lay the panel out: the button on the left, three lines on the right."""
        yield StopButton(self._keys)
        with Vertical(id="safety-lines"):
            yield PlainText(id="state")
            yield PlainText(id="trust")
            yield PlainText(id="stopping")

    def show(
        self,
        arm: str,
        badge: Span,
        says: str,
        trust: Trust = Trust.UNKNOWN,
        position: str = "",
        stopping: str = "",
        *,
        real: bool = False,
    ) -> None:
        """Show which arm it is, its state, its position, and what a stop takes."""
        word, colour = badge
        dot, dot_colour = DOTS[trust]
        lost = badge == BADGES[State.DISCONNECTED]
        text_of(self, "state").show((f" {word} ", f"bold reverse {colour}"), f" {says}")
        text_of(self, "trust").show((f"{dot} ", dot_colour), position)
        text_of(self, "stopping").show((stopping, "bold" if lost else "dim"))
        self.set_class(real, "-real")
        self.set_class(lost, "-lost")
        if arm != self.arm:
            self.arm = arm
            colour = " reverse $error" if real else ""
            self.border_title = Content.styled(f" {printable(arm)} ", f"bold{colour}")
