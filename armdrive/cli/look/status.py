"""The status of an arm: a page for `armdrive status`, a line for each change for `watch`.

If another program drives the arm, that program answers. Both texts are made from the JSON form of a
status, so that an arm looks the same whether this command is connected to it or another program
reports it.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import time
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Any

import tui
from armdrive.cli.arm_files import chosen_target
from armdrive.cli.chosen_arm import connect_chosen, held_config
from armdrive.cli.holders import ask, held_name, one_holder
from armdrive.cli.presenter import Ink, Inked, Line, Result, require_screen, show, tell, with_arm
from armdrive.config.arm import ArmConfig
from armdrive.errors import ArmInUse, SettingsDiffer, StateFileError
from armdrive.errors.actions import COMMAND_LINE, presented
from armdrive.errors.table import by_code, named
from armdrive.status import (
    IMMOBILE,
    IN_MOTION,
    LABEL,
    WAYS_OUT,
    WAYS_TO_TRUST,
    State,
    StatusRow,
    Trust,
    coded,
    program_line,
    status_rows,
    status_view,
    which_arm,
)
from armdrive.storage.lock_client import holder_words, is_held, watch_holder
from kinematics.text import mm_text, sentence, tenths


def status(options: argparse.Namespace) -> Result:
    """Return the status; nothing is switched on."""
    try:
        with contextlib.closing(connect_chosen(options, reads=True)) as arm:
            view: Mapping[str, Any] = status_view(arm.status)
    except (ArmInUse, StateFileError):
        # on a disk that has become read-only, a program may drive the arm all the same
        name, own = held_name(options), chosen_target(options).config.name
        if not is_held(name):
            raise
        view = ask(name, "status")
        which = "this arm" if name == own else f"{name} on the port of {own}"
        held = f"{holder_words(name)} is driving {which}."
        lines = status_lines(view, options, held_step(view))
        return Result(view, itertools.chain((held, ""), lines))
    return Result(view, status_lines(view, options, next_step(view)))


def watch(options: argparse.Namespace) -> int:
    """Print a line whenever something changes in an arm that another program drives."""
    name = one_holder(options)
    if options.screen:
        return watch_on_screen(name, held_config(options, name))
    lines = Watched()
    tell(options, f"watching {name}; Ctrl-C ends this command and does not stop the arm")
    with contextlib.suppress(KeyboardInterrupt):
        for view in watch_holder(name, options.every):
            show(Result(view, lines.lines(view)), options)
    return 0


def watch_on_screen(name: str, config: ArmConfig, *, ascii_only: bool = False) -> int:
    """Draw an arm that another program holds by a name, until the user leaves.

    Return the exit code.
    """
    require_screen("watching on a screen", "leave out --screen for lines of text")
    return tui.run_watch(name, config.model, ascii_only=ascii_only)


# A status in words.

View = Mapping[str, Any]

# The colours of the words for a state and for how far a position is trusted.
INKS: Mapping[str, Ink] = MappingProxyType(
    {
        State.STANDBY.value: Ink.GOOD,
        State.MOVING.value: Ink.GOOD,
        State.HOMING.value: Ink.CAUTION,
        State.STOPPING.value: Ink.CAUTION,
        State.DISABLED.value: Ink.CAUTION,
        State.DISCONNECTED.value: Ink.BAD,
        State.ERROR_STOP.value: Ink.BAD,
        Trust.REFERENCED.value: Ink.GOOD,
        Trust.RESTORED.value: Ink.CAUTION,
        Trust.UNKNOWN.value: Ink.CAUTION,
        Trust.SUSPECT.value: Ink.BAD,
    }
)

# The colours of the messages of a status.
MESSAGE_INKS: Mapping[str, Ink] = MappingProxyType({"notice": Ink.CAUTION, "error": Ink.BAD})


def inked(word: str, width: int = 0) -> Inked:
    """Return the word for a state or a trust in its colour."""
    return Inked(f"{word:<{width}}", INKS[word])


def status_lines(view: View, options: argparse.Namespace, step: str) -> Iterator[Line]:
    """Yield the page of a status: which arm it is, its status, and the next step."""
    yield which_arm(view)
    yield ""
    for label, word, rest in status_rows(view):
        ink = MESSAGE_INKS.get(label) or INKS.get(word)
        yield (f"{label:<{LABEL}}", word if ink is None else Inked(word, ink), rest)
    yield ""
    next_words = with_arm(presented(step, COMMAND_LINE), options)
    yield str(StatusRow("next", next_words))


# The codes of notices that say why nothing moves.
_BLOCKED = (SettingsDiffer.code, named("LOCKED").code, named("ALARM_VOUCHED").code)


def _remedy(code: str, state: State) -> str:
    """Return what to do about an error; another program's may have a code unknown here."""
    row = by_code(code)
    return sentence(WAYS_OUT[state]) if row is None else row.remedy


def _motion_step(view: View) -> str:
    """Return what any program may do about a motion; empty if there is none."""
    if view["paused"]:
        return "`armdrive resume` continues the motion."
    if State(view["state"]) in IN_MOTION:
        return "`armdrive stop` stops the arm, `armdrive pause` pauses it."
    return ""


def held_step(view: View) -> str:
    """Return what a person does next with an arm that another program drives."""
    return _motion_step(view) or (
        "`armdrive watch` follows the arm; only the program that drives it can do more."
    )


def next_step(view: View) -> str:
    """Return what a person does next with an arm in this state."""
    state, trust = State(view["state"]), Trust(view["trust"])
    if state in (State.ERROR_STOP, State.DISCONNECTED):
        return _remedy(view["error_code"] or view["trust_code"], state)
    if view["notice_code"] in _BLOCKED:
        return _remedy(view["notice_code"], state)
    if trust is Trust.SUSPECT and not view["error_code"]:
        return sentence(WAYS_TO_TRUST[trust])  # after the reset that the remedy begins with
    if step := _motion_step(view):
        return step
    if trust is Trust.RESTORED:
        own = "a simulated arm confirms its position by itself"
        asked = "on a terminal, each asks first whether the arm still stands as it was left"
        return f"`armdrive move` or `armdrive jog`: {own if view['simulated'] else asked}."
    if trust is not Trust.REFERENCED and view["trust_code"]:
        return _remedy(view["trust_code"], state)
    if state is State.DISABLED:
        return sentence(WAYS_OUT[state])
    return "`armdrive move`, `armdrive jog` or `armdrive run PROGRAM`."


# `armdrive watch`: a line for each change.

STATE_WIDTH, TRUST_WIDTH = 14, 12


def _column(key: str) -> str:
    """Return the heading of a coordinate, with its unit."""
    axis, _, unit = key.partition("_")
    return f"{axis} mm" if unit == "mm" else f"{axis}°"


class Watched:
    """Turns the statuses of a watched arm into lines: what has not changed is not repeated."""

    def __init__(self) -> None:
        self._last: tuple[Line, ...] = ()
        self._keys: tuple[str, ...] = ()

    def lines(self, view: View) -> Iterator[Line]:
        """Yield the lines that a status adds: headings first, then news, then where the arm is."""
        keys = tuple(view["pose"] or self._keys)
        if keys != self._keys or not self._last:
            self._keys = keys
            names = "".join(f"{_column(key):>8}" for key in keys)
            yield f"{'time':<10}{'state':<{STATE_WIDTH}}{'position':<{TRUST_WIDTH}}{names}  gripper"
        news, place = tuple(self._news(view)), self._place(view)
        yield from (line for line in news if line not in self._last)
        if place not in self._last:
            yield (f"{time.strftime('%H:%M:%S'):<10}", *place)
        self._last = (*news, place)

    def _news(self, view: View) -> Iterator[Line]:
        if program := program_line(view):
            yield f"{'':<10}{program}"
        for label, ink in MESSAGE_INKS.items():
            if view[label]:
                yield (f"{'':<10}", Inked(coded(view[label], view[f"{label}_code"]), ink))

    def _place(self, view: View) -> tuple[str | Inked, ...]:
        pose = view["pose"] or {}
        numbers = [tenths(pose[key]) if pose else "-" for key in self._keys]
        opening = "" if view["gripper_mm"] is None else f"{mm_text(view['gripper_mm']):>9}"
        paused = view["paused"] and State(view["state"]) not in IMMOBILE
        state = "paused" if paused else view["state"]
        return (
            Inked(f"{state:<{STATE_WIDTH}}", INKS[view["state"]]),
            inked(view["trust"], TRUST_WIDTH),
            "".join(f"{number:>8}" for number in numbers) + opening,
        )
