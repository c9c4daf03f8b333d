"""Turning one motor a little, in pieces that each end by themselves within a quarter of a second.

Targets are absolute (F5), so that a request whose answer was lost may be put once more.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from armdrive.dialects.mks.survey import (
    TRIES,
    Known,
    answer_of,
    answers,
    doubled,
    known,
    reading,
    setting_of,
)
from armdrive.dialog import (
    About,
    Hear,
    Put,
    Question,
    Stands,
    Talk,
    agreed,
    ask,
    say,
    whole_or_empty,
)
from armdrive.setup.plan import Plan, Planned
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    NODE_DEFAULT,
    TARGET_MAX,
    Ability,
    Calibrate,
    Code,
    Done,
    EncoderRead,
    Event,
    Failed,
    Mode,
    MotorState,
    MoveAbsoluteAxis,
    ReadEncoder,
    ReadStall,
    ReadState,
    ReplyMode,
    SetCurrent,
    SetId,
    SetMicrosteps,
    SetMode,
    SetReplies,
    Setting,
    SilenceWatchdog,
    StallRead,
    Started,
    StateRead,
    needed_for,
)

PIECE_S = 0.25
"""No motion is commanded further ahead."""
WHOLE_S = 1.6
"""A trial takes about so long."""
MOST_RPM = 60
ACC = 236
"""A ramp of 1000 rpm a second."""
LOOK_S = 0.03
PATIENCE_S = 1.0
"""A piece that has not arrived so long after its time never will."""
REACHED = 80
"""Counts from its target at which a motor has arrived: under two degrees of its shaft."""


@dataclass(frozen=True, slots=True)
class Turned:
    """Where a motor stands, in counts, and why it is not where it should be; empty where it is."""

    counts: int
    trouble: str = ""


def speed_rpm(counts: int, seconds: float = WHOLE_S) -> int:
    """Return the speed at which so many counts take about so long; never a fast one."""
    turns = abs(counts) / COUNTS_PER_TURN
    return max(1, min(math.ceil(turns * 60.0 / seconds), MOST_RPM))


def where(node: int) -> Talk[int | None]:
    """Read where a drive is."""
    found = yield from reading(node, ReadEncoder())
    return found.counts if isinstance(found, EncoderRead) else None


def turn_to(node: int, target: int, rpm: int) -> Talk[Turned]:
    """Turn a motor to a count, piece by piece. The drive holds it from then on."""
    at = yield from where(node)
    if at is None:
        return Turned(target, "it does not answer")
    if abs(target) > TARGET_MAX:
        return Turned(at, "it is beyond the 512 turns that can be commanded: set its zero anew")
    most = max(1, int(rpm / 60.0 * COUNTS_PER_TURN * PIECE_S))
    pieces = math.ceil(abs(target - at) / most)
    begin = at
    for number in range(1, pieces + 1):
        goal = begin + round((target - begin) * number / pieces)
        turned = yield from _piece(node, goal, rpm)
        if turned.trouble:
            return turned
        at = turned.counts
    return Turned(at)


def _piece(node: int, goal: int, rpm: int) -> Talk[Turned]:
    for _ in range(TRIES):
        heard: tuple[Event, ...] = yield Put(node, MoveAbsoluteAxis(goal, rpm, ACC))
        if any(isinstance(each, Failed) for each in heard):
            yield Stands(node)
            return Turned((yield from where(node)) or 0, (yield from refusal(node)))
        arrived = yield from _arrived(node, goal)
        if arrived is not None:
            yield Stands(node)
            return Turned(arrived)
        if any(isinstance(each, Started | Done) for each in heard):
            break
    at = yield from where(node)
    return Turned(at or 0, (yield from refusal(node)) if at is not None else "it does not answer")


def _arrived(node: int, goal: int) -> Talk[int | None]:
    """Wait until a motor stands at its goal; None where it does not get there."""
    waited_s = 0.0
    while waited_s < PIECE_S + PATIENCE_S:
        yield Hear(LOOK_S)
        waited_s += LOOK_S
        at = yield from where(node)
        if at is not None and abs(at - goal) <= REACHED and (yield from stands(node)):
            return at
    return None


def stands(node: int) -> Talk[bool]:
    """Tell whether a drive says that its motor stands."""
    found = yield from reading(node, ReadState())
    return isinstance(found, StateRead) and found.state is MotorState.STOPPED


def refusal(node: int) -> Talk[str]:
    """Say why a motor may not have turned."""
    stalled = yield from reading(node, ReadStall())
    if isinstance(stalled, StallRead) and stalled.on:
        return "its protection has let the shaft go: something blocks it, or its current is too low"
    return (
        "the drive does not do it: it is blocked, its mode is none of the bus, or its encoder is "
        "not calibrated"
    )


# Calibrating a drive's encoder against its motor, which turns: only with nothing on the shaft.

LONGEST_S = 60.0
CALIBRATION_LOOK_S = 0.1
"""So often it is asked how it fares, which feeds the watchdog where that is on already."""
BEGUN_S = 0.5
"""A drive that stands so long after it was told to calibrate does not do it."""
_ALREADY = "It says that it is calibrated already. Do it all the same?"


def calibrate(drive: Planned, found: Known) -> Talk[bool]:
    """Offer a calibration; return whether the encoder is calibrated, as far as is known."""
    known = found.version is not None
    already = found.version is not None and found.version.calibrated
    if already:
        wanted = yield from agreed(
            _ALREADY, "Only after a drive was put on another motor.", About.FREE, drive.motor, "no"
        )
    else:
        told = "says that it is not" if known else "does not tell whether it is"
        yield from say(
            f"Drive {drive.node} {told} calibrated. Calibration turns the motor by itself, for up "
            f"to {LONGEST_S:g} s, and nothing but its supply stops it for certain: nothing may be "
            "on its shaft, no belt, no gear, no arm. One sold on its motor mostly is calibrated."
        )
        wanted = yield from agreed(
            f"Is the shaft of the {drive.name} motor free, and may it turn now?",
            "no leaves it out; calibrate before the motor is built in.",
            About.FREE,
            drive.motor,
        )
    if not wanted:
        return already or not known
    return (yield from _carry_out(drive))


def _carry_out(drive: Planned) -> Talk[bool]:
    heard: tuple[Event, ...] = yield Put(drive.node, Calibrate())
    ended, waited_s = _ending(heard), 0.0
    while ended is None and waited_s < LONGEST_S:
        heard = yield Hear(CALIBRATION_LOOK_S)
        heard += yield Put(drive.node, ReadState())
        waited_s += CALIBRATION_LOOK_S
        ended = _ending(heard)
        if ended is None and waited_s > BEGUN_S and _stands(heard):
            heard = yield Hear(CALIBRATION_LOOK_S)  # the word that ends it may be on its way
            ended = _ending(heard) is True
    yield Stands(drive.node)
    if ended:
        yield from say(f"Drive {drive.node} is calibrated.")
        return True
    yield from say(
        f"Drive {drive.node} did not calibrate. Look at the supply (12 V at least), at the motor's "
        "two phases, and that the magnet sits on the shaft's end; then try once more."
    )
    return False


def _ending(heard: tuple[Event, ...]) -> bool | None:
    """Return how it ended; None while it goes on."""
    for each in heard:
        if isinstance(each, Done | Failed) and isinstance(each.request, Calibrate):
            return isinstance(each, Done)
    return None


def _stands(heard: tuple[Event, ...]) -> bool:
    """Tell whether a drive says that its motor stands; one that is busy may say nothing."""
    found = answer_of(heard)
    return isinstance(found, StateRead) and found.state is MotorState.STOPPED


# The settings of a drive: what differs from what an arm needs is shown, agreed to, written, read.
#
# One table says which settings matter, and why. What a firmware does not let be read is written
# whatever it is, and proved by the first motion.


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


# One drive comes to the bus: it is recognised by its id, or given it. Nothing turns.

SETTLE_S = 0.3
"""A drive that was given an id has taken it by then."""

ONE_AT_A_TIME = (
    "Every drive is shipped as id 1. Two of one id obey one command both, and spoil each other's "
    "answers: so plug in one new drive at a time."
)
CHECKS = (
    "Nobody answers. Check that the drive has its motor supply, that CAN H and L are not swapped, "
    "that both ends of the cable have their resistor of 120 ohm, and that its bit rate (CanRate in "
    "its menu, 500K as shipped) is that of the adapter. `armdrive doctor --can` tells what is "
    "known of the bus."
)


def arrive(plan: Plan, drive: Planned) -> Talk[Known | None]:
    """Bring a drive to its id; None where the person leaves it out."""
    found = yield from _recognised(plan, drive)
    while found is None:
        if not (yield from _plug_in(drive)):
            return None
        ready: bool | None = yield from answers(drive.node)
        if not ready:
            ready = yield from _give_id(drive)
        if ready is None:
            return None
        if ready:
            found = yield from _checked(drive)
    return found


def _recognised(plan: Plan, drive: Planned) -> Talk[Known | None]:
    """Return the drive where its id answers and nobody else can be meant by it."""
    if drive.node == NODE_DEFAULT and len(plan.drives) > 1:
        return None  # may be a new drive: the person has to say that it is this one
    if not (yield from answers(drive.node)):
        return None
    return (yield from _checked(drive))


def _plug_in(drive: Planned) -> Talk[bool]:
    words = f"Is the drive of the {drive.name} plugged in, and no other new one?"
    yield from say(
        f"Plug the CAN cable of the {drive.name} drive in. Drives that have their ids may stay."
    )
    return (
        yield from agreed(
            words,
            f"{ONE_AT_A_TIME} no leaves the {drive.name} out for now.",
            About.CONNECT,
            drive.motor,
        )
    )


def _checked(drive: Planned) -> Talk[Known | None]:
    """Look at a drive that answers; None where two do, or it is gone again."""
    found = yield from known(drive.node)
    if found is None:
        yield from say(CHECKS)
        return None
    if found.doubled:
        yield from say(_two(drive.node))
        return None
    calibrated = "" if found.version is None else _calibrated(found.version.calibrated)
    yield from say(
        f"Drive {found.node} answers: {found.board}, {found.firmware_words}, "
        f"at {found.counts} counts{calibrated}."
    )
    return found


def _calibrated(is_so: bool) -> str:
    return ", calibrated" if is_so else ", its encoder not calibrated"


def _give_id(drive: Planned) -> Talk[bool | None]:
    """Give the new drive, which answers as id 1, the id of its motor; None where nobody wants it.

    False where it did not work: the person may plug something else in, and try again.
    """
    if not (yield from answers(NODE_DEFAULT)):
        yield from say(CHECKS)
        return False
    if (yield from doubled(NODE_DEFAULT)):
        yield from say(_two(NODE_DEFAULT))
        return False
    if not (
        yield from agreed(
            f"A new drive answers as id {NODE_DEFAULT}. Make it id {drive.node}, for the "
            f"{drive.name}? Nothing turns.",
            "It keeps the id without current (8B). no leaves it as it is.",
            motor=drive.motor,
        )
    ):
        return None
    heard: tuple[Event, ...] = yield Put(NODE_DEFAULT, SetId(drive.node))
    yield Hear(SETTLE_S)
    if not (yield from answers(drive.node)):
        refused = any(isinstance(each, Failed) for each in heard)
        why = "The drive refused the id." if refused else "It does not answer by the new id."
        yield from say(f"{why} Switch its supply off and on, and try once more.")
        return False
    if (yield from answers(NODE_DEFAULT)):
        yield from say(
            f"Id {drive.node} answers now, and so does id {NODE_DEFAULT} still: a second new drive "
            f"is on the bus, and it may have been made id {drive.node} too. Unplug all but one of "
            "them, and set the CanID of the others back in their menu if it has changed."
        )
        return False
    said = any(isinstance(each, Done) for each in heard)
    yield from say(f"It is drive {drive.node} now" + ("." if said else ", though it did not say."))
    return True


def _two(node: int) -> str:
    return f"More than one drive answers as id {node}. {ONE_AT_A_TIME}"


def all_there(plan: Plan) -> Talk[tuple[Planned, ...]]:
    """Return the drives of a plan that do not answer, or not alone."""
    wrong = []
    for drive in plan.drives:
        if not (yield from answers(drive.node)) or (yield from doubled(drive.node)):
            wrong.append(drive)  # noqa: PERF401 - a talk cannot be held in a comprehension
    return tuple(wrong)
