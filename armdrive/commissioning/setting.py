"""The settings of a drive: what differs from what an arm needs is shown, agreed to, written, read.

One table says which settings matter, and why. What a firmware does not let be read is written
whatever it is, and proved by the first motion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from armdrive.commissioning.acts import About, Put, Talk, agreed, ask, say, whole_or_empty
from armdrive.commissioning.drives import TRIES, Known, setting_of
from armdrive.commissioning.plan import Plan, Planned
from armdrive.interview.readers import Question
from firmware_protocol.mks import (
    Ability,
    Code,
    Done,
    Event,
    Mode,
    ReplyMode,
    SetCurrent,
    SetMicrosteps,
    SetMode,
    SetReplies,
    Setting,
    SilenceWatchdog,
    needed_for,
)


@dataclass(frozen=True, slots=True)
class Wanted:
    """One setting that an arm needs, and why."""

    setting: Setting
    what: str
    why: str


def _wanted(plan: Plan, current_ma: int) -> tuple[Wanted, ...]:
    device = plan.device
    watchdog_ms = round(device.watchdog_s * 1000)
    return (
        Wanted(SetMode(Mode.BUS_FOC), "mode 5 (SR_vFOC)", "outside it no bus motion is obeyed"),
        Wanted(SetReplies(ReplyMode.FULL), "replies on", "the driver hears what is done"),
        Wanted(
            SetMicrosteps(device.microsteps),
            f"{device.microsteps} microsteps",
            "with 16, 32 or 64 the drive's speeds are rpm",
        ),
        Wanted(SetCurrent(current_ma), f"{current_ma} mA", "the motor's own rating"),
        Wanted(
            SilenceWatchdog(watchdog_ms),
            f"watchdog {watchdog_ms} ms",
            "the motor stops when the computer has died or the cable is pulled",
        ),
    )


def settle(plan: Plan, drive: Planned, found: Known) -> Talk[int]:
    """Set a drive up; return the current in mA that it has now, 0 where that was left alone."""
    current_ma = yield from _current(plan, drive, found)
    wanted = [each for each in _wanted(plan, current_ma) if _able(each.setting, found)]
    differing = [each for each in wanted if found.settings.get(each.setting.code) != each.setting]
    yield from _tell_lacks(plan, found)
    if not differing:
        yield from say(f"Its settings are right: {', '.join(each.what for each in wanted)}.")
        return current_ma
    for each in differing:
        yield from say(f"  {each.what:<18} {_before(found, each.setting)}  ({each.why})")
    many = f"these {len(differing)} settings" if len(differing) > 1 else "this setting"
    if not (
        yield from agreed(
            f"Write {many} to drive {drive.node}? Nothing turns; the motor may begin to hold.",
            "The drive keeps them without current. no leaves it as it is: `armdrive doctor --arm "
            f"{plan.name} --mend` can write them later.",
            motor=drive.motor,
        )
    ):
        return 0
    failed = []
    for each in differing:
        if not (yield from write(drive.node, each.setting, found)):
            failed.append(each.what)  # noqa: PERF401 - a talk cannot be held in one
    if failed:
        yield from say(f"The drive did not take: {', '.join(failed)}.")
    else:
        read = "written, and read back" if Ability.READ_SETTINGS in found.able else "written"
        yield from say(f"{', '.join(each.what for each in differing)}: {read}.")
    return current_ma


def write(node: int, setting: Setting, found: Known) -> Talk[bool]:
    """Write a setting and read it back, where the firmware lets it be read."""
    for _ in range(TRIES):
        heard: tuple[Event, ...] = yield Put(node, setting)
        taken = any(isinstance(each, Done) for each in heard)
        if Ability.READ_SETTINGS not in found.able:
            if taken or heard:
                return taken
            continue
        is_set = yield from setting_of(node, setting.code)
        if is_set == setting or (is_set is None and taken):
            return True
    return False


def _current(plan: Plan, drive: Planned, found: Known) -> Talk[int]:
    if plan.device.current_ma:
        return min(plan.device.current_ma, found.most_ma)
    present = found.settings.get(Code.CURRENT)
    default = str(present.current_ma) if isinstance(present, SetCurrent) else None
    answer = yield from ask(
        Question(
            "",
            f"Current of the {drive.name} motor, in mA?",
            f"What its data sheet calls rated or phase current, up to {found.most_ma} mA for this "
            "board. Too little stalls, too much makes it hot: begin with less.",
            whole_or_empty(1, found.most_ma, "mA"),
            default,
        ),
        About.NUMBER,
        drive.motor,
    )
    return int(answer)


def _able(setting: Setting, found: Known) -> bool:
    needed = needed_for(setting)
    return needed is None or needed in found.able


def _before(found: Known, setting: Setting) -> str:
    present = found.settings.get(setting.code)
    if present is None:
        return "not told by this firmware"
    return f"now {_WORDS[type(present)](present)}"


def _tell_lacks(plan: Plan, found: Known) -> Talk[None]:
    if plan.device.watchdog_s and Ability.SILENCE_WATCHDOG not in found.able:
        yield from say(
            "Its firmware has no watchdog (98, from 1.0.9 on): when the computer dies it ends at "
            "its last target, which armdrive keeps no further ahead than 0.3 s."
        )


_WORDS: dict[type, Callable[..., str]] = {
    SetMode: lambda one: f"{int(one.mode)} ({one.mode.name})",
    SetReplies: lambda one: one.mode.name.lower(),
    SetMicrosteps: lambda one: str(one.microsteps),
    SetCurrent: lambda one: f"{one.current_ma} mA",
    SilenceWatchdog: lambda one: f"{one.timeout_ms} ms" if one.timeout_ms else "off",
}
