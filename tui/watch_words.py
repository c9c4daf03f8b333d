"""What is said of an arm that another program drives, from the plain data of its status."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from armdrive.errors.actions import COMMAND_LINE, presented
from tui.panels import TITLE_GAP, parted

View = Mapping[str, Any]

UNKNOWN = "?"

TEMPOS = (10, 25, 50, 75, 100)
"""Percent of the speed that is asked for."""


def title(name: str, view: View, width: int) -> str:
    """Say which arm is watched, and whether it is real, the latter first lest it is cut off."""
    if not view:
        return f"WATCHING {name}"[:width].ljust(width)
    kind = "SIMULATED" if view.get("simulated") else "REAL ARM"
    arm = f"{name} ({view.get('title', '?')}) on {view.get('link', '?')}"
    told = view.get("program")
    program = at_work(told) if isinstance(told, Mapping) else ""
    gap = TITLE_GAP if program else 0
    return parted(f"{kind}, WATCHED: {arm}", gap, program, width, len(kind))


def at_work(program: View) -> str:
    """Name a program, and say how far it has come: a share, else steps; nothing of none."""
    if not program:
        return ""
    name, steps = Path(str(program.get("file", UNKNOWN))).name, program.get("steps")
    if (share := _number(program.get("percent"), 0)) != UNKNOWN:
        return f"{name} {share} %"
    return f"{name} {program.get('line', UNKNOWN)}/{steps}" if steps else name


def lines(view: View) -> str:
    """Say how the arm is, in words and numbers: first what a small terminal must not cut off."""
    if not view:
        return "nothing is known of it yet"
    joints, pose = view.get("joints"), view.get("pose")
    conduct = f"state {view.get('state', '?')}{', PAUSED' if view.get('paused') else ''}"
    time_s = _number(view.get("stop_time_s"), 2)
    way = f"{_number(view.get('stop_distance_mm'))} mm, {time_s} s"
    texts = (
        f"{conduct}  speed {percent(view)} %",
        program_words(view),
        *(_remark(view[word]) for word in ("notice", "error") if view.get(word)),
        f"position {view.get('trust', '?')}: {view.get('trust_reason', '?')}",
        "",
        *_named(joints, "_deg", "\N{DEGREE SIGN}"),
        "" if joints else "the joints are not known",
        *_named(pose, "", ""),
        "" if pose is None else f"gripper {_number(view.get('gripper_mm'))} mm",
        f"motor current {view.get('current', '?')}",
        f"stop: {way} at most",
    )
    return "\n".join(text for text in texts if text is not None)


def _remark(sentence: object) -> str:
    """Return a remark in the words of the command line: no key of this app acts on the arm."""
    return f"! {presented(str(sentence), COMMAND_LINE)}"


def program_words(view: View) -> str | None:
    """Say which program the arm is at work on, and how far it has come; None of none."""
    program = view.get("program")
    if not isinstance(program, dict) or not program:
        return None
    loop, loops = program.get("loop"), program.get("loops", 1)
    several = "" if loops == 1 else f", loop {loop} of {loops}" if loops else f", loop {loop}"
    line, act = program.get("line"), program.get("text") or program.get("act") or ""
    share, left_s = (_number(program.get(word), 0) for word in ("percent", "left_s"))
    texts = (
        f"program {Path(str(program.get('file', UNKNOWN))).name}{several}",
        f"line {line}: {act}" if line else act,
        "" if UNKNOWN in (share, left_s) else f"{share} %, {left_s} s left",
    )
    return "\n".join(str(text) for text in texts if text)


def percent(view: View) -> int:
    """Return the speed that the arm may go at, in percent of what it is asked for."""
    share = view.get("speed_override", 1.0)
    return round(share * 100) if isinstance(share, int | float) else 100


def tempo(now: int, steps: int) -> int:
    """Return the next tempo below or above; the ends hold."""
    others = [each for each in TEMPOS if (each - now) * steps > 0]
    if not others:
        return min(TEMPOS) if steps < 0 else max(TEMPOS)
    return max(others) if steps < 0 else min(others)


def _named(values: object, ending: str, unit: str) -> list[str]:
    if not isinstance(values, dict):
        return []
    return [
        f"{str(name).removesuffix(ending).replace('_', ' '):<12}{_number(value):>8}{unit}"
        for name, value in values.items()
    ]


def _number(value: object, digits: int = 1) -> str:
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return f"{float(value) + 0.0:.{digits}f}" if number else UNKNOWN  # type: ignore[arg-type]
