"""What every screen says of the arm: which it is, what forbids motion, and the last remarks."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from armdrive.status import State, Status, Trust, coded
from tui.keys.keyboard import Keyboard
from tui.keys.table import titled

View = Mapping[str, Any]
"""What another program tells of its arm, or of what that is at work on, as plain data."""

UNKNOWN = "?"

TITLE_GAP = 2
"""Between the arm and the name of the screen, which stands at the right end."""


def title(status: Status, screen: str, width: int, program: str = "") -> str:
    """Say whether the arm is real, first lest it is cut off; then which, and which screen.

    `program` is what the arm is at work on, in a few words.
    """
    kind = "SIMULATED" if status.simulated else "REAL ARM"
    arm = f"{kind}: {status.arm} ({status.title}) on {status.link}"
    return parted(arm, TITLE_GAP, f"{program}  {screen.upper()}".lstrip(), width, len(kind))


def parted(left: str, gap: int, right: str, width: int, least: int) -> str:
    """Put two texts at both ends of a line; the left one is cut, but never below `least`."""
    room = max(width - len(right) - gap, least)
    if len(left) > room:
        left = left[: max(left.rfind(" ", 0, room + 1), least)]  # between two words
    return f"{left:<{room}}{' ' * gap}{right}"[:width]


def look_for_it(keys: Keyboard) -> str:
    """Say how a lost link is looked for, and how the desk is left without it."""
    return f"{keys.label('reconnect')} looks for it, {keys.label('quit')} leaves"


def banner(
    status: Status, keys: Keyboard, *, looked_for: bool = False, paused_here: bool = False
) -> str:
    """Say what forbids all motion, and what to do; nothing while nothing does.

    `looked_for` says that a lost link is looked for without anybody asking, `paused_here` that it
    was this desk that paused the arm.
    """
    reason = (
        coded(status.error, status.error_code)
        or coded(status.notice, status.notice_code)
        or coded(status.trust_reason, status.trust_code)
    )
    if status.state is State.DISCONNECTED:
        key, leave = keys.label("reconnect"), keys.label("quit")
        looking = f"It is being looked for: {key} looks at once, {leave} leaves"
        return f"LINK LOST: {reason.rstrip('.')}. {looking if looked_for else look_for_it(keys)}."
    if status.state is State.ERROR_STOP:
        return f"ERROR-STOP: {reason}. {keys.label('reset')} resets, and moves nothing."
    if status.paused:
        return _paused(keys, here=paused_here)
    if status.speed_override < 1.0:
        return (
            f"SLOWED from outside to {status.speed_override:.0%}: `armdrive slow 100%` ends that."
        )
    return ""


def _paused(keys: Keyboard, *, here: bool) -> str:
    """Say who has paused the arm, and how it goes on or ends."""
    stop = f"{keys.label('stop')} ends its motion"
    if here:
        where = f"{keys.label('points-pause')} on the {titled('points')} screen"
        return f"PAUSED at this desk: {where} lets the arm go on, {stop}."
    return f"PAUSED from outside: `armdrive resume` lets the arm go on, {stop}."


def link_back(status: Status, keys: Keyboard) -> str:
    """Say what a link that came back has ended in: what is trusted, why, and what to do next."""
    first = {
        State.ERROR_STOP: f"{keys.label('reset')} resets, then ",
        State.DISABLED: f"{keys.label('motors')} switches the motors on, then ",
    }
    restored = status.trust is Trust.RESTORED
    then = (
        f"{keys.label('confirm')} compares it"
        if restored
        else f"{keys.label('reference')} references it"
    )
    return (
        f"the link is back, and nothing was moved. The position is {status.trust.value}: "
        f"{status.trust_reason}. Look at the arm: {first.get(status.state, '')}{then}"
    )


def after_reset(status: Status, keys: Keyboard) -> str:
    """Say what a reset has led to."""
    off = status.state is State.DISABLED
    more = f"; {keys.label('motors')} switches the motors on" if off else ""
    return "reset: nothing was moved" + more


def remarks(status: Status, message: str, *, bannered: bool) -> str:
    """Say what the desk and the arm have to say, each remark once."""
    if message and message in status.notice:
        message = ""  # what the desk was told is what the arm noticed
    said = (message, status.notice, "" if bannered else status.error)
    return "\n".join(f"! {remark}" for remark in dict.fromkeys(said) if remark)


def at_work(program: View) -> str:
    """Name a program, and say how far it has come: a share, else steps; nothing of none."""
    if not program:
        return ""
    name, steps = Path(str(program.get("file", UNKNOWN))).name, program.get("steps")
    if (share := number_text(program.get("percent"), 0)) != UNKNOWN:
        return f"{name} {share} %"
    return f"{name} {program.get('line', UNKNOWN)}/{steps}" if steps else name


def number_text(value: object, digits: int = 1) -> str:
    """Return a number with so many digits, a question mark in the place of anything else."""
    number = isinstance(value, int | float) and not isinstance(value, bool)
    return f"{float(value) + 0.0:.{digits}f}" if number else UNKNOWN  # type: ignore[arg-type]
