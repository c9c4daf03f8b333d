"""Sets up one MKS drive after the other: its id, its settings, its calibration.

Its motor is turned by the controller of an arm that is this drive alone (`by_itself`): in bursts,
slowly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.dialects.bus.motors import one_motor
from armdrive.dialects.bus.tools import BusTools, CommissioningTools, DrivePlace, on_wire
from armdrive.dialects.dialect import DeviceTools
from armdrive.dialects.mks.compare import value_words, wanted_settings
from armdrive.dialects.mks.inquiry import is_shared
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.survey import (
    Known,
    answers,
    is_answer,
    is_request,
    known,
    scripts,
    survey_drives,
)
from armdrive.dialects.mks.wire import TRIES, Asking, MksWire
from armdrive.dialects.mks.words import TALK, MksEar
from armdrive.dialog.conversation import (
    About,
    Question,
    Talk,
    agreed,
    ask,
    say,
    whole,
)
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    NODE_DEFAULT,
    NODE_MAX,
    TARGET_MAX,
    Ability,
    Answered,
    Bitrate,
    Calibrate,
    Code,
    Done,
    EmergencyStop,
    Failed,
    Mode,
    MotorState,
    ReadState,
    Request,
    SetCurrent,
    SetId,
    Setting,
    SetZero,
    SilenceWatchdog,
    StateRead,
    needed_for,
)

ACC = 236
"""A motor that is tried goes by a ramp of 1000 rpm a second."""
REACHED = 80
"""Counts from its target at which it has arrived: under two degrees of its shaft."""


def order(wire: MksWire, node: int, message: Request) -> Asking[bool | None]:
    """Tell a drive once to do something; return whether it says that it did, None for silence."""
    heard = (yield from wire.ask({node: message}, tries=1)).get(node)
    return None if heard is None else isinstance(heard, Done)


# Calibrating a drive's encoder against its motor, which turns: only with nothing on the shaft.

LONGEST_S = 60.0
CALIBRATION_LOOK_S = 0.1
"""So often it is asked how it fares, which feeds the watchdog where that is on already."""
BEGUN_S = 0.5
"""A drive that stands so long after it was told to calibrate does not do it."""
_ALREADY = "It says that it is calibrated already. Do it all the same?"
STOPS = 3
"""A stop is said so often: a frame can be lost."""


def calibrate(wire: MksWire, node: int) -> Asking[bool]:
    """Have a drive calibrate its encoder; return whether it says that it did."""
    wire.put(node, Calibrate())
    try:
        return (yield from _calibrated(wire, node))
    except GeneratorExit:  # it is waited for no longer
        for _ in range(STOPS):
            wire.put(node, EmergencyStop())
        raise


def _calibrated(wire: MksWire, node: int) -> Asking[bool]:
    began_s = wire.now_s
    look_s, end_s = began_s + CALIBRATION_LOOK_S, began_s + LONGEST_S
    while wire.now_s < end_s:
        heard = yield min(look_s, end_s)
        if isinstance(heard, Done | Failed) and isinstance(heard.request, Calibrate):
            wire.host.settle(node)
            return isinstance(heard, Done)
        stands = isinstance(heard, Answered) and heard.answer == StateRead(MotorState.STOPPED)
        if stands and wire.now_s > began_s + BEGUN_S:
            end_s = min(end_s, wire.now_s + CALIBRATION_LOOK_S)  # the word that ends it may follow
        if heard is None and wire.now_s >= look_s:
            look_s = wire.now_s + CALIBRATION_LOOK_S
            wire.put(node, ReadState())
    return False


# The settings of a drive: what differs from what an arm needs is shown, agreed to, written, read.
#
# What a firmware does not let be read is written whatever it is, and proved by the first motion.


def write(wire: MksWire, node: int, setting: Setting, able: frozenset[Ability]) -> Asking[bool]:
    """Write a setting and read it back, where the firmware lets it be read."""
    for _ in range(TRIES):
        taken = yield from order(wire, node, setting)
        if Ability.READ_SETTINGS not in able:
            if taken is not None:
                return taken
            continue
        is_set = yield from wire.setting(node, setting.code)
        if is_set == setting or (is_set is None and taken):
            return True
    return False


# A drive that has come to the bus: set up, and calibrated.

FAR = TARGET_MAX // 4
"""A motor that counts beyond this is offered a new zero: at four times of it, none can be sent."""


@dataclass(frozen=True, slots=True)
class MksDriveAtHand:
    """A drive that is alone with its id, what it has told, and what its arm file says of it."""

    arm: ArmConfig
    drive: DrivePlace
    found: Known

    @property
    def firmware(self) -> str:
        """Its firmware in its own words; empty where it does not tell."""
        return str(self.found.firmware) if self.found.firmware.told else ""

    @property
    def keeps_settings(self) -> bool:
        """Whether it has not lost its mode since, as far as it tells."""
        return self.found.mode is None or self.found.mode.mode is Mode.BUS_FOC

    @property
    def watchdog_s(self) -> float:
        """When it stops by itself once the bus is silent (98, firmware 1.0.9 on); 0 for never."""
        return self.arm.device.watchdog_s if Ability.SILENCE_WATCHDOG in self.found.able else 0.0

    @property
    def by_itself(self) -> ArmConfig:
        """An arm that is this drive alone, and turns its one motor slowly, one step a count.

        It moves in bursts. Its watchdog is left as it is: it was agreed to before, or it was not.
        """
        device = replace(
            self.arm.device,
            ids=(self.drive.node,),
            firmware=str(self.found.firmware),
            watchdog_s=0.0,
            acceleration=ACC,
            segment_s=0.0,
            rest_counts=REACHED,
        )
        return one_motor(replace(self.arm, device=device), self.drive.name, COUNTS_PER_TURN)

    def settle(self) -> Talk[int]:
        """Set a drive up; return the current in mA that it has now, 0 where that was left alone."""
        current_ma = yield from self._current()
        wanted = [
            each
            for each in wanted_settings(self.arm.device, current_ma)
            if needed_for(each.setting) in (None, *self.found.able)
        ]
        differing = [
            each for each in wanted if self.found.settings.get(each.setting.code) != each.setting
        ]
        yield from self._tell_lacks()
        if not differing:
            yield from say(f"Its settings are right: {', '.join(each.what for each in wanted)}.")
            return current_ma
        for each in differing:
            is_set = value_words(self.found.settings.get(each.setting.code))
            before = f"now {is_set}" if is_set else "not told by this firmware"
            yield from say(f"  {each.what:<18} {before}  ({each.why})")
        many = f"these {len(differing)} settings" if len(differing) > 1 else "this setting"
        if not (
            yield from agreed(
                f"Write {many} to drive {self.drive.node}? Nothing turns; the motor may begin to "
                "hold.",
                "The drive keeps them without current. no leaves it as it is: `armdrive doctor "
                f"--arm {self.arm.name} --mend` can write them later.",
                motor=self.drive.motor,
            )
        ):
            return 0
        failed = []
        for each in differing:
            if not (yield from self._write(each.setting)):
                failed.append(each.what)  # noqa: PERF401 - a talk cannot be held in one
        if failed:
            yield from say(f"The drive did not take: {', '.join(failed)}.")
        else:
            reads = Ability.READ_SETTINGS in self.found.able
            read = "written, and read back" if reads else "written"
            yield from say(f"{', '.join(each.what for each in differing)}: {read}.")
        return current_ma

    def _write(self, setting: Setting) -> Talk[bool]:
        return (yield from on_wire(write, self.drive.node, setting, self.found.able))

    def set_watchdog(self, seconds: float) -> Talk[bool]:
        """Have it stop by itself when the bus is silent for so long; return whether it will."""
        return (yield from self._write(SilenceWatchdog(round(seconds * 1000))))

    def _current(self) -> Talk[int]:
        if self.arm.device.current_ma:
            return int(min(self.arm.device.current_ma, self.found.most_ma))
        present = self.found.settings.get(Code.CURRENT)
        default = str(present.current_ma) if isinstance(present, SetCurrent) else None
        most_ma = self.found.most_ma
        answer = yield from ask(
            Question(
                "",
                f"Current of the {self.drive.name} motor, in mA?",
                f"What its data sheet calls rated or phase current, up to {most_ma} mA for this "
                "board. Too little stalls, too much makes it hot: begin with less.",
                whole(1, most_ma, "mA"),
                default,
            ),
            About.NUMBER,
            self.drive.motor,
        )
        return int(answer)

    def _tell_lacks(self) -> Talk[None]:
        if self.arm.device.watchdog_s and Ability.SILENCE_WATCHDOG not in self.found.able:
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
        if (yield from on_wire(calibrate, self.drive.node)):
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
        taken = yield from on_wire(order, self.drive.node, SetZero())
        yield from say("It counts from here." if taken else "The drive did not take the zero.")


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


def arrive(arm: ArmConfig, drive: DrivePlace, others: bool) -> Talk[MksDriveAtHand | None]:
    """Bring a drive to its id; None where the person leaves it out."""
    found = yield from _recognised(drive, others)
    while found is None:
        if not (yield from _plug_in(drive)):
            return None
        ready: bool | None = yield from on_wire(answers, drive.node)
        if not ready:
            ready = yield from _give_id(drive)
        if ready is None:
            return None
        if ready:
            found = yield from _checked(drive)
    return MksDriveAtHand(arm, drive, found)


def _recognised(drive: DrivePlace, others: bool) -> Talk[Known | None]:
    """Return the drive where its id answers and nobody else can be meant by it."""
    if drive.node == NODE_DEFAULT and others:
        return None  # may be a new drive: the person has to say that it is this one
    if not (yield from on_wire(answers, drive.node)):
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
    found = yield from on_wire(known, drive.node)
    if found is None:
        yield from say(CHECKS)
        return None
    if found.doubled:
        yield from say(_two(drive.node))
        return None
    calibrated = "" if found.version is None else _calibrated_words(found.version.calibrated)
    yield from say(
        f"Drive {found.node} answers: {found.board}, {found.firmware_words}, "
        f"at {found.counts} counts{calibrated}."
    )
    return found


def _calibrated_words(is_so: bool) -> str:
    return ", calibrated" if is_so else ", its encoder not calibrated"


def _give_id(drive: DrivePlace) -> Talk[bool | None]:
    """Give the new drive, which answers as id 1, the id of its motor; None where nobody wants it.

    False where it did not work: the person may plug something else in, and try again.
    """
    if not (yield from on_wire(answers, NODE_DEFAULT)):
        yield from say(CHECKS)
        return False
    if (yield from on_wire(is_shared, NODE_DEFAULT)):
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
    taken = yield from on_wire(_take_id, drive.node)
    if not (yield from on_wire(answers, drive.node)):
        why = "The drive refused the id." if taken is False else "It does not answer by the new id."
        yield from say(f"{why} Switch its supply off and on, and try once more.")
        return False
    if (yield from on_wire(answers, NODE_DEFAULT)):
        yield from say(
            f"Id {drive.node} answers now, and so does id {NODE_DEFAULT} still: a second new drive "
            f"is on the bus, and it may have been made id {drive.node} too. Unplug all but one of "
            "them, and set the CanID of the others back in their menu if it has changed."
        )
        return False
    yield from say(f"It is drive {drive.node} now" + ("." if taken else ", though it did not say."))
    return True


def _take_id(wire: MksWire, node: int) -> Asking[bool | None]:
    """Give a new drive its id, and the time to take it; return what it says of that."""
    taken = yield from order(wire, NODE_DEFAULT, SetId(node))
    yield from wire.pause(wire.now_s + SETTLE_S)
    return taken


def _two(node: int) -> str:
    return f"More than one drive answers as id {node}. {ONE_AT_A_TIME}"


def alone(wire: MksWire, node: int) -> Asking[bool]:
    """Find out whether one drive, and no more, answers to an id."""
    return (yield from answers(wire, node)) and not (yield from is_shared(wire, node))


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
    scripts=scripts,
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
