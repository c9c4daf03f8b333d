"""Sets up one MKS drive after the other: its id, settings, calibration, and a little motion.

A motor turns in pieces that each end by themselves within a quarter of a second. Targets are
absolute (F5), so that a request whose answer was lost may be put once more.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from armdrive.dialects.bus.tools import BusTools, CommissioningTools, DrivePlace, Turned
from armdrive.dialects.dialect import DeviceTools
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.survey import (
    TRIES,
    Known,
    MksHost,
    answer_of,
    answers,
    doubled,
    is_answer,
    is_request,
    known,
    reading,
    setting_of,
    survey_drives,
)
from armdrive.dialects.mks.words import TALK, MksEar
from armdrive.dialog.conversation import (
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
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    NODE_DEFAULT,
    NODE_MAX,
    TARGET_MAX,
    Ability,
    Bitrate,
    Calibrate,
    Code,
    Done,
    Enable,
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
    SetZero,
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
class WantedSetting:
    """One setting that an arm needs, and why."""

    setting: Setting
    what: str
    why: str


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


def _able(setting: Setting, found: Known) -> bool:
    needed = needed_for(setting)
    return needed is None or needed in found.able


def _before(found: Known, setting: Setting) -> str:
    present = found.settings.get(setting.code)
    if present is None:
        return "not told by this firmware"
    return f"now {_WORDS[type(present)](present)}"


_WORDS: dict[type, Callable[..., str]] = {
    SetMode: lambda one: f"{int(one.mode)} ({one.mode.name})",
    SetReplies: lambda one: one.mode.name.lower(),
    SetMicrosteps: lambda one: str(one.microsteps),
    SetCurrent: lambda one: f"{one.current_ma} mA",
    SilenceWatchdog: lambda one: f"{one.timeout_ms} ms" if one.timeout_ms else "off",
}


# A drive that has come to the bus: set up, calibrated, turned, its watchdog tried.

FAR = TARGET_MAX // 4
"""A motor that counts beyond this is offered a new zero: at four times of it, none can be sent."""
TRIAL_MS = 100
"""What the watchdog is set to while it is tried."""
RUN_S = 0.8
"""A motion that would take so long, were it not stopped."""
SILENCE_S = 1.2
STILL_SHARE = 0.01
"""One that has come no farther did not run at all."""
STOPPED_SHARE = 0.7
"""It was stopped where it has come no farther than this share of its way."""


@dataclass(frozen=True, slots=True)
class MksDriveAtHand:
    """A drive that is alone with its id, what it has told, and what its arm file says of it."""

    arm: str
    device: MksSettings
    drive: DrivePlace
    found: Known

    @property
    def firmware(self) -> str:
        """Its firmware in its own words; empty where it does not tell."""
        return ".".join(map(str, self.found.firmware)) if self.found.told else ""

    @property
    def keeps_settings(self) -> bool:
        """Whether it has not lost its mode since, as far as it tells."""
        return self.found.mode is None or self.found.mode.mode is Mode.BUS_FOC

    def settle(self) -> Talk[int]:
        """Set a drive up; return the current in mA that it has now, 0 where that was left alone."""
        current_ma = yield from self._current()
        wanted = [each for each in self._wanted(current_ma) if _able(each.setting, self.found)]
        differing = [
            each for each in wanted if self.found.settings.get(each.setting.code) != each.setting
        ]
        yield from self._tell_lacks()
        if not differing:
            yield from say(f"Its settings are right: {', '.join(each.what for each in wanted)}.")
            return current_ma
        for each in differing:
            yield from say(f"  {each.what:<18} {_before(self.found, each.setting)}  ({each.why})")
        many = f"these {len(differing)} settings" if len(differing) > 1 else "this setting"
        if not (
            yield from agreed(
                f"Write {many} to drive {self.drive.node}? Nothing turns; the motor may begin to "
                "hold.",
                "The drive keeps them without current. no leaves it as it is: `armdrive doctor "
                f"--arm {self.arm} --mend` can write them later.",
                motor=self.drive.motor,
            )
        ):
            return 0
        failed = []
        for each in differing:
            if not (yield from write(self.drive.node, each.setting, self.found)):
                failed.append(each.what)  # noqa: PERF401 - a talk cannot be held in one
        if failed:
            yield from say(f"The drive did not take: {', '.join(failed)}.")
        else:
            reads = Ability.READ_SETTINGS in self.found.able
            read = "written, and read back" if reads else "written"
            yield from say(f"{', '.join(each.what for each in differing)}: {read}.")
        return current_ma

    def _wanted(self, current_ma: int) -> tuple[WantedSetting, ...]:
        device = self.device
        watchdog_ms = round(device.watchdog_s * 1000)
        return (
            WantedSetting(
                SetMode(Mode.BUS_FOC), "mode 5 (SR_vFOC)", "outside it no bus motion is obeyed"
            ),
            WantedSetting(
                SetReplies(ReplyMode.FULL), "replies on", "the driver hears what is done"
            ),
            WantedSetting(
                SetMicrosteps(device.microsteps),
                f"{device.microsteps} microsteps",
                "with 16, 32 or 64 the drive's speeds are rpm",
            ),
            WantedSetting(SetCurrent(current_ma), f"{current_ma} mA", "the motor's own rating"),
            WantedSetting(
                SilenceWatchdog(watchdog_ms),
                f"watchdog {watchdog_ms} ms",
                "the motor stops when the computer has died or the cable is pulled",
            ),
        )

    def _current(self) -> Talk[int]:
        if self.device.current_ma:
            return min(self.device.current_ma, self.found.most_ma)
        present = self.found.settings.get(Code.CURRENT)
        default = str(present.current_ma) if isinstance(present, SetCurrent) else None
        most_ma = self.found.most_ma
        answer = yield from ask(
            Question(
                "",
                f"Current of the {self.drive.name} motor, in mA?",
                f"What its data sheet calls rated or phase current, up to {most_ma} mA for this "
                "board. Too little stalls, too much makes it hot: begin with less.",
                whole_or_empty(1, most_ma, "mA"),
                default,
            ),
            About.NUMBER,
            self.drive.motor,
        )
        return int(answer)

    def _tell_lacks(self) -> Talk[None]:
        if self.device.watchdog_s and Ability.SILENCE_WATCHDOG not in self.found.able:
            yield from say(
                "Its firmware has no watchdog (98, from 1.0.9 on): when the computer dies it ends "
                "at its last target, which armdrive keeps no further ahead than 0.3 s."
            )

    def calibrate(self) -> Talk[bool]:
        """Offer a calibration; return whether the encoder is calibrated, as far as is known."""
        known = self.found.version is not None
        already = self.found.version is not None and self.found.version.calibrated
        if already:
            wanted = yield from agreed(
                _ALREADY,
                "Only after a drive was put on another motor.",
                About.FREE,
                self.drive.motor,
                "no",
            )
        else:
            told = "says that it is not" if known else "does not tell whether it is"
            yield from say(
                f"Drive {self.drive.node} {told} calibrated. Calibration turns the motor by "
                f"itself, for up to {LONGEST_S:g} s, and nothing but its supply stops it for "
                "certain: nothing may be on its shaft, no belt, no gear, no arm. One sold on its "
                "motor mostly is calibrated."
            )
            wanted = yield from agreed(
                f"Is the shaft of the {self.drive.name} motor free, and may it turn now?",
                "no leaves it out; calibrate before the motor is built in.",
                About.FREE,
                self.drive.motor,
            )
        if not wanted:
            return already or not known
        return (yield from self._carry_out())

    def _carry_out(self) -> Talk[bool]:
        heard: tuple[Event, ...] = yield Put(self.drive.node, Calibrate())
        ended, waited_s = _ending(heard), 0.0
        while ended is None and waited_s < LONGEST_S:
            heard = yield Hear(CALIBRATION_LOOK_S)
            heard += yield Put(self.drive.node, ReadState())
            waited_s += CALIBRATION_LOOK_S
            ended = _ending(heard)
            if ended is None and waited_s > BEGUN_S and _stands(heard):
                heard = yield Hear(CALIBRATION_LOOK_S)  # the word that ends it may be on its way
                ended = _ending(heard) is True
        yield Stands(self.drive.node)
        if ended:
            yield from say(f"Drive {self.drive.node} is calibrated.")
            return True
        yield from say(
            f"Drive {self.drive.node} did not calibrate. Look at the supply (12 V at least), at "
            "the motor's two phases, and that the magnet sits on the shaft's end; then try once "
            "more."
        )
        return False

    def offer_zero(self) -> Talk[None]:
        """Offer a new zero to a drive that counts far from it."""
        counts = self.found.counts
        if counts is None or abs(counts) < FAR or Ability.ZERO not in self.found.able:
            return
        turns = abs(counts) / COUNTS_PER_TURN
        if not (
            yield from agreed(
                f"It stands {turns:.0f} turns from its zero, and can be sent 512 at most. Call "
                "where it stands now zero? Nothing turns; the arm has to be referenced afterwards.",
                "92. A drive counts from where it was switched on, or from where it was homed.",
                motor=self.drive.motor,
            )
        ):
            return
        heard: tuple[Event, ...] = yield Put(self.drive.node, SetZero())
        taken = any(isinstance(each, Done) for each in heard)
        yield from say("It counts from here." if taken else "The drive did not take the zero.")

    def switch_on(self) -> Talk[bool]:
        """Have its motor hold after a yes; return whether it does."""
        if not (
            yield from agreed(
                f"Switch the {self.drive.name} motor on? It holds from then on, and moves nothing.",
                "F3. The switch of its supply lets it go.",
                motor=self.drive.motor,
            )
        ):
            return False
        heard: tuple[Event, ...] = yield Put(self.drive.node, Enable(on=True))
        if any(isinstance(each, Done) for each in heard):
            return True
        yield from say(
            "The drive did not switch its motor on: its mode is none of the bus (write the "
            "settings first), or a protection has let the shaft go (switch its supply off and on)."
        )
        return False

    def where(self) -> Talk[int | None]:
        """Read where it stands."""
        return (yield from where(self.drive.node))

    def turn_to(self, target: int, counts: int) -> Talk[Turned]:
        """Turn to a count, as slowly as a motion of so many counts is to be watched."""
        return (yield from turn_to(self.drive.node, target, speed_rpm(counts)))

    def try_watchdog(self, counts: int) -> Talk[bool | None]:
        """Try whether it stops by itself when its bus falls silent (98, firmware 1.0.9 on).

        Returns whether it stopped the motor, None where that was not tried.
        """
        watchdog_s, node, found = self.device.watchdog_s, self.drive.node, self.found
        if not watchdog_s or Ability.SILENCE_WATCHDOG not in found.able:
            return None
        counts, rpm = _run(counts)
        if not (
            yield from agreed(
                f"Try the watchdog? The {self.drive.name} runs as far as before, and the bus is "
                f"silent: it should stop early by itself. For {RUN_S:g} s only the supply's switch "
                "could stop it otherwise. Now?",
                f"The watchdog is set to {TRIAL_MS} ms meanwhile, and back to "
                f"{watchdog_s:g} s afterwards. no trusts it untried.",
                motor=self.drive.motor,
            )
        ):
            return None
        start = yield from where(node)
        final = SilenceWatchdog(round(watchdog_s * 1000))
        if start is None or not (yield from write(node, SilenceWatchdog(TRIAL_MS), found)):
            yield from say("The drive does not take the watchdog.")
            return False
        yield Put(node, MoveAbsoluteAxis(start + counts, rpm, ACC))
        yield Hear(SILENCE_S)
        at = yield from where(node)
        yield Stands(node)
        kept = yield from write(node, final, found)
        yield from turn_to(node, start, rpm)
        if at is None or not kept:
            yield from say(f"Drive {node} stopped answering: look at its supply and cable.")
            return False
        share = abs(at - start) / counts
        if share < STILL_SHARE:
            yield from say("The motor did not move at all, so that this tells nothing.")
            return None
        works = share <= STOPPED_SHARE
        yield from say(
            f"The watchdog works: it stopped after {share:.0%} of the way."
            if works
            else "The watchdog did not stop it. The drive ends at its last target when the "
            "computer dies, which armdrive keeps no further ahead than 0.3 s."
        )
        return works


def _run(counts: int) -> tuple[int, int]:
    """Return counts and speed of a run that takes as long as it should, and is not too short."""
    rpm = round(counts / COUNTS_PER_TURN * 60.0 / RUN_S)
    if 1 <= rpm <= MOST_RPM:
        return counts, rpm
    rpm = min(max(rpm, 1), MOST_RPM)
    return round(rpm / 60.0 * COUNTS_PER_TURN * RUN_S), rpm


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


def arrive(
    arm: str, device: MksSettings, drive: DrivePlace, others: bool
) -> Talk[MksDriveAtHand | None]:
    """Bring a drive to its id; None where the person leaves it out."""
    found = yield from _recognised(drive, others)
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
    return MksDriveAtHand(arm, device, drive, found)


def _recognised(drive: DrivePlace, others: bool) -> Talk[Known | None]:
    """Return the drive where its id answers and nobody else can be meant by it."""
    if drive.node == NODE_DEFAULT and others:
        return None  # may be a new drive: the person has to say that it is this one
    if not (yield from answers(drive.node)):
        return None
    return (yield from _checked(drive))


def _plug_in(drive: DrivePlace) -> Talk[bool]:
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


def _checked(drive: DrivePlace) -> Talk[Known | None]:
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


def _give_id(drive: DrivePlace) -> Talk[bool | None]:
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


def alone(node: int) -> Talk[bool]:
    """Tell whether one drive, and no more, answers to an id."""
    return (yield from answers(node)) and not (yield from doubled(node))


def section(device: MksSettings, ids: Sequence[int], current_ma: int) -> dict[str, Any]:
    """Return what [mks] of the arm file says of the drives; a current of 0 is not said."""
    known: dict[str, Any] = {
        "ids": list(ids),
        "watchdog_s": device.watchdog_s,
        "microsteps": device.microsteps,
    }
    return known | ({"current_ma": current_ma} if current_ma else {})


STEPS = (
    "its id, and whether it is alone with it",
    "its settings: mode 5 (SR_vFOC), replies, microsteps, current, watchdog",
    "its encoder's calibration, if it has none: with a free shaft",
    "in the arm: direction and gear by a small motion, and the watchdog by another",
)
"""What is done with each drive, in this order."""

BUS = BusTools(
    name="mks",
    dialect="mks",
    most=NODE_MAX,
    host=MksHost,
    ask=survey_drives,
    reads_command=is_request,
    reads_answer=is_answer,
    bit_rates=tuple(each.bits_s for each in Bitrate),
    connects=True,
    next="armdrive can setup NAME --port '{port}'",
    hint="`armdrive can setup NAME --port '{port}'` does more: it writes the arm file, and sets "
    "the drives up and tries them one by one",
    commissioning=CommissioningTools(
        new_id=NODE_DEFAULT,
        counts_per_turn=COUNTS_PER_TURN,
        steps=STEPS,
        caution=ONE_AT_A_TIME,
        arrive=arrive,
        alone=alone,
        section=section,
    ),
)
"""The MKS protocol on a bus, by ids of one frame each."""

TOOLS = DeviceTools(TALK, bus=BUS, ear=MksEar)
