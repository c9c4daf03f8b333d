"""The status of an arm: a page for `armdrive status`, a line for each change for `watch`.

If another program drives the arm, that program answers. Both texts are made from the JSON form of a
status, so that an arm looks the same whether this command is connected to it or another program
tells about it.
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
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.drive.control_requests import ask, one_holder
from armdrive.cli.presenter import Ink, Inked, Line, Result, require_screen, show, tell, with_arm
from armdrive.connect.target import find
from armdrive.errors import ArmError, ArmInUse
from armdrive.errors.actions import COMMAND_LINE, presented
from armdrive.errors.table import by_code
from armdrive.status import Current, State, Trust, coded, status_view, trust_words
from armdrive.storage.lock_client import holder_words, watch_holder


def status(options: argparse.Namespace) -> Result:
    """Return the status; nothing is switched on."""
    try:
        with contextlib.closing(connect_chosen(options)) as arm:
            view: Mapping[str, Any] = status_view(arm.status)
    except ArmInUse:
        name = chosen_target(options).config.name
        view = ask(name, "status")
        held = f"{holder_words(name)} is driving this arm."
        return Result(view, itertools.chain((held, ""), status_lines(view, options)))
    return Result(view, status_lines(view, options))


def watch(options: argparse.Namespace) -> int:
    """Print a line whenever something changes in an arm that another program drives."""
    name = one_holder(options)
    if options.screen:
        return watch_on_screen(name)
    watched = Watched()
    tell(options, f"watching {name}; Ctrl-C ends the watching and stops nothing")
    with contextlib.suppress(KeyboardInterrupt):
        for view in watch_holder(name, options.every):
            if "state" not in view:
                raise ArmError(str(view.get("error", "the program does not let itself be watched")))
            show(Result(view, watched.lines(view)), options)
    return 0


def watch_on_screen(name: str, *, ascii_only: bool = False) -> int:
    """Draw an arm that another program drives until the user leaves; return the exit code."""
    require_screen("watching on a screen", "leave out --screen for lines of text")
    return tui.run_watch(name, find(name).config.model, ascii_only=ascii_only)


# A status in words.

View = Mapping[str, Any]

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
"""The colours of the words for a state and for how far a position is trusted."""

MOTORS: Mapping[str, str] = MappingProxyType(
    {
        Current.HELD.value: "on: they hold the arm",
        Current.OFF.value: "off",
        Current.UNKNOWN.value: "on or off: the controller does not say",
    }
)
"""The motor current in words."""

LABEL = 10
"""The width of the first column of the page."""


def inked(word: str, width: int = 0) -> Inked:
    """Return the word for a state or a trust in its colour."""
    return Inked(f"{word:<{width}}", INKS[word])


def status_lines(view: View, options: argparse.Namespace) -> Iterator[Line]:
    """Yield the page of a status: state, position, tip, joints, gripper, and what to do next."""
    kind = "SIMULATED" if view["simulated"] else "REAL"
    yield f"{view['arm']} ({view['title']}), {kind}, {view['link']}"
    yield ""
    yield _row("state", inked(view["state"]), _conduct(view))
    yield _row("motors", MOTORS[view["current"]])
    if program := program_line(view):
        yield _row("program", program + _progress(view))
    reason = trust_words(view["trust"], view["trust_reason"], view["trust_code"])
    yield _row("position", inked(view["trust"]), f": {reason}")
    if view["pose"] is not None:
        yield _row("tip", ", ".join(_coordinates(view["pose"])))
    yield from _joint_rows(view["joints"] or {})
    if view["gripper_mm"] is not None:
        grip = ", gripping" if view["gripping"] else ""
        yield _row("gripper", f"{view['gripper_mm']:.1f} mm open{grip}")
    if view["inputs"] is not None:
        yield _row("inputs", _inputs(view["inputs"]))
    yield _row("stop", _stopping(view))
    if (torque := view["torque"]) is not None:
        yield _row("disable", f"the arm {torque['disable']}")
        yield _row("estop", f"the arm {torque['estop']}")
    if view["underruns"]:
        yield _row("underruns", f"{view['underruns']}: the arm stood still in mid-motion")
    for word, ink in (("notice", Ink.CAUTION), ("error", Ink.BAD)):
        if view[word]:
            yield _row(word, Inked(coded(view[word], view[f"{word}_code"]), ink))
    yield ""
    yield _row("next", with_arm(presented(next_step(view), COMMAND_LINE), options))


def next_step(view: View) -> str:
    """Return what a person does next with an arm in this state."""
    state, trust, paused = State(view["state"]), Trust(view["trust"]), view["paused"]
    if state is State.ERROR_STOP or (trust is Trust.SUSPECT and not view["error_code"]):
        code = view["error_code"] or view["trust_code"]
        return by_code(code).remedy if code else "Look at the arm, then call `reset()`."
    if paused:
        return "`armdrive resume` lets the arm go on."
    if state in (State.MOVING, State.HOMING, State.STOPPING):
        return "`armdrive stop` stops the arm, `armdrive pause` pauses it."
    if trust is Trust.RESTORED and view["simulated"]:
        return "`armdrive move` or `armdrive jog`: a simulated arm confirms its position by itself."
    if trust is not Trust.REFERENCED and view["trust_code"]:
        return by_code(view["trust_code"]).remedy
    if state is State.DISABLED:
        return "`armdrive enable` switches the motors on."
    return "`armdrive move`, `armdrive jog` or `armdrive run PROGRAM`."


def _row(label: str, *parts: str | Inked) -> Line:
    return (f"{label:<{LABEL}}", *parts)


def _conduct(view: View) -> str:
    override = view["speed_override"]
    return ", PAUSED" * bool(view["paused"]) + (
        f", slowed to {override:.0%}" if override < 1.0 else ""
    )


def _joint_rows(joints: Mapping[str, float]) -> Iterator[Line]:
    """Yield a row for each joint, the angles below each other."""
    names = [key.removesuffix("_deg").replace("_", " ") for key in joints]
    width = max(map(len, names), default=0)
    for at, (name, angle) in enumerate(zip(names, joints.values(), strict=True)):
        yield _row("" if at else "joints", f"{name:<{width}}{angle + 0.0:>8.1f}°")


def _coordinates(pose: Mapping[str, float]) -> Iterator[str]:
    for key, value in pose.items():
        name, unit = key.rsplit("_", 1)
        yield f"{name} {round(value, 1) + 0.0:.1f}{' mm' if unit == 'mm' else '°'}"


def _inputs(bits: int) -> str:
    on = [str(number + 1) for number in range(bits.bit_length()) if bits >> number & 1]
    return f"on: {', '.join(on)}" if on else "all off"


def _stopping(view: View) -> str:
    words = f"takes at most {view['stop_time_s']:.2f} s and {view['stop_distance_mm']:.0f} mm"
    if view["silent_time_s"] > view["stop_time_s"]:
        words += (
            f"; without this program, {view['silent_time_s']:.2f} s and "
            f"{view['silent_distance_mm']:.0f} mm"
        )
    return words


def program_line(view: View) -> str:
    """Return which line of which program an arm runs; nothing if it runs none."""
    program = view.get("program")
    if not isinstance(program, dict) or not program:
        return ""
    return f"{program.get('file')}, line {program.get('line')}: {program.get('text')}"


def _progress(view: View) -> str:
    """Return how far a program has come, where that is known."""
    program = view.get("program") or {}
    percent, left_s = program.get("percent"), program.get("left_s")
    if not isinstance(percent, int | float) or not isinstance(left_s, int | float):
        return ""
    return f" ({percent:.0f} %, {left_s:.0f} s left)"


# `armdrive watch`: a line for each change.

STATE_WIDTH, TRUST_WIDTH = 14, 12
COLUMNS: Mapping[str, str] = MappingProxyType(
    {"x_mm": "x mm", "y_mm": "y mm", "z_mm": "z mm", "pitch_deg": "pitch°", "roll_deg": "roll°",
     "yaw_deg": "yaw°"}
)  # fmt: skip


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
            names = "".join(f"{COLUMNS[key]:>8}" for key in keys)
            yield f"{'time':<10}{'state':<{STATE_WIDTH}}{'position':<{TRUST_WIDTH}}{names}  gripper"
        news, place = tuple(self._news(view)), self._place(view)
        yield from (line for line in news if line not in self._last)
        if place not in self._last:
            yield (f"{time.strftime('%H:%M:%S'):<10}", *place)
        self._last = (*news, place)

    def _news(self, view: View) -> Iterator[Line]:
        if program := program_line(view):
            yield f"{'':<10}{program}"
        for word, ink in (("notice", Ink.CAUTION), ("error", Ink.BAD)):
            if view[word]:
                yield (f"{'':<10}", Inked(coded(view[word], view[f"{word}_code"]), ink))

    def _place(self, view: View) -> tuple[str | Inked, ...]:
        pose = view["pose"] or {}
        numbers = [f"{round(pose[key], 1) + 0.0:.1f}" if pose else "-" for key in self._keys]
        opening = "" if view["gripper_mm"] is None else f"{view['gripper_mm']:>6.1f} mm"
        state = "paused" if view["paused"] else view["state"]
        return (
            Inked(f"{state:<{STATE_WIDTH}}", INKS[view["state"]]),
            inked(view["trust"], TRUST_WIDTH),
            "".join(f"{number:>8}" for number in numbers) + opening,
        )
