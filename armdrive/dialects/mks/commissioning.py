"""Set up MKS drives one after the other: id, settings, calibration, and a trial of the watchdog."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.dialects import DeviceTools
from armdrive.dialects.bus.tools import BusTools, CommissioningTools, DriveDialog, DrivePlace
from armdrive.dialects.mks.compare import WantedSetting, value_words, wanted_settings
from armdrive.dialects.mks.contact import series_words
from armdrive.dialects.mks.drive import MksDrive
from armdrive.dialects.mks.exchange import MksExchange, MksScript, is_done
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.survey import (
    KnownDrive,
    answers,
    is_shared,
    known,
    scripts,
    survey_drives,
)
from armdrive.dialects.mks.words import TALK, MksFrameDescriber, read_answer, read_request
from armdrive.dialog import About, Question, whole
from armdrive.errors.printable import command_line
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    NODE_DEFAULT,
    NODE_MAX,
    Ability,
    Answered,
    Calibrate,
    Code,
    EmergencyStop,
    Enable,
    EncoderRead,
    Mode,
    MoveAbsoluteAxis,
    Outcome,
    ReadEncoder,
    ReadState,
    Request,
    SetCurrent,
    SetId,
    Setting,
    SilenceWatchdog,
    Status,
)
from kinematics.text import counted


def order(io: MksExchange, node: int, message: Request) -> MksScript[bool | None]:
    """Send a drive an order once; return whether it reports success, None if it is silent."""
    drive = io.drive(node)
    reply = (yield from io.ask({drive: message}, tries=1)).get(drive)
    return None if reply is None else is_done(reply)


# Calibrating a drive's encoder against its motor. The motor turns, so its shaft must be free.

# The longest time that a calibration is waited for; the manual states none (a guess).
LONGEST_S = 60.0
# How often a turning drive is read, which also feeds its watchdog.
LOOK_S = 0.1
_CALIBRATION_ENDS = tuple(
    Status(Code.CALIBRATE, outcome) for outcome in (Outcome.DONE, Outcome.FAILED)
)
_ALREADY = "It reports that it is already calibrated. Calibrate it again?"
# How often a stop is sent, because frames can be lost.
STOPS = 3


def calibrate(io: MksExchange, node: int) -> MksScript[bool]:
    """Calibrate a drive's encoder; return whether it reports success."""
    drive = io.drive(node)
    io.put(drive, Calibrate())
    try:
        return (yield from _calibrated(io, drive))
    except GeneratorExit:  # the caller has given up
        for _ in range(STOPS):
            io.put(drive, EmergencyStop())
        raise


def _calibrated(io: MksExchange, drive: MksDrive) -> MksScript[bool]:
    look_s, end_s = io.now_s, io.now_s + LONGEST_S
    while io.now_s < end_s:
        if io.now_s >= look_s:
            look_s = io.now_s + LOOK_S
            io.put(drive, ReadState())
        event = yield look_s
        if isinstance(event, Answered) and event.answer in _CALIBRATION_ENDS:
            return is_done(event.answer)
    return False


# The watchdog's trial: does a drive stop by itself if its bus falls silent while it moves?
#
# The manual promises it, but we know of no report that a drive did so. The motor turns so slowly,
# and so little, that this can be tried in any arm, whatever the motor's direction and gear.

# The watchdog's time while it is tried.
TRIAL_MS = 100
TRIAL_RPM = 4
# The turn takes this long if the watchdog does not stop it.
TRIAL_RUN_S = 0.8
# A twentieth of a turn of the shaft: with a gear of 20:1, a degree of the joint.
TRIAL_COUNTS = round(COUNTS_PER_TURN * TRIAL_RPM / 60.0 * TRIAL_RUN_S)
# The ramp: 1000 rpm a second.
TRIAL_ACC = 236
# Nothing is sent for this long, within which the turn ends in any case.
SILENCE_S = 1.2


def try_watchdog(
    io: MksExchange, node: int, usual: SilenceWatchdog, able: frozenset[Ability]
) -> MksScript[tuple[float | None, bool]]:
    """Begin a turn, fall silent as a program that dies does, and turn back.

    Return the share of the turn that was made, None if it is not known, and whether the watchdog
    has its usual time again: with the short one, the drive would stop in the middle of motions.
    """
    drive, share = io.drive(node), None
    try:
        start = yield from io.reading(drive, ReadEncoder())
        ready = (yield from order(io, node, Enable(on=True))) and (
            yield from write(io, node, SilenceWatchdog(TRIAL_MS), able)
        )
        if ready and isinstance(start, EncoderRead):
            there = MoveAbsoluteAxis(start.counts + TRIAL_COUNTS, TRIAL_RPM, TRIAL_ACC)
            yield from order(io, node, there)
            yield from io.pause(io.now_s + SILENCE_S)
            at = yield from io.reading(drive, ReadEncoder())
            if isinstance(at, EncoderRead):
                share = abs(at.counts - start.counts) / TRIAL_COUNTS
        restored = yield from write(io, node, usual, able)
        if share is not None:
            back = MoveAbsoluteAxis(start.counts, TRIAL_RPM, TRIAL_ACC)  # type: ignore[union-attr]
            yield from order(io, node, back)
            yield from io.pause(io.now_s + SILENCE_S)
    except GeneratorExit:  # the caller has given up
        for _ in range(STOPS):
            io.put(drive, EmergencyStop())
            io.put(drive, usual)
        raise
    return share, restored


# The settings of a drive: what differs from the arm's needs is shown, confirmed and written.
#
# Settings that the firmware does not report are always written; the first motion proves them.


def write(
    io: MksExchange, node: int, setting: Setting, able: frozenset[Ability]
) -> MksScript[bool]:
    """Write a setting, and read it back if the firmware reports it."""
    drive = io.drive(node)
    reply = yield from io.ask({drive: setting})
    if Ability.READ_SETTINGS not in able:
        return is_done(reply.get(drive))
    return (yield from io.setting(drive, setting.code)) == setting


# A drive that is on the bus: settings, calibration, watchdog.


@dataclass(frozen=True, slots=True)
class MksDriveAtHand:
    """A drive that is alone with its id, its answers, and its arm."""

    dialog: DriveDialog
    arm: ArmConfig
    drive: DrivePlace
    found: KnownDrive

    @property
    def ready_ma(self) -> int:
        """The motor current of a drive that has all its settings; 0 if not, or not reported."""
        present = self.found.settings.get(Code.CURRENT)
        reported = present.current_ma if isinstance(present, SetCurrent) else 0
        current_ma = int(self.arm.device.current_ma or reported)
        ready = self.found.firmware.calibrated is not False and not self._differing(current_ma)
        return current_ma if ready else 0

    def _wanted(self, current_ma: int) -> list[WantedSetting]:
        """Return the settings that this drive needs and its firmware has."""
        return [
            each
            for each in wanted_settings(self.arm.device, current_ma)
            if each.setting.needs in (None, *self.found.able)
        ]

    def _differing(self, current_ma: int) -> list[WantedSetting]:
        """Return those that it does not report to have."""
        settings = self.found.settings
        wanted = self._wanted(current_ma)
        return [each for each in wanted if settings.get(each.setting.code) != each.setting]

    def settle(self) -> int:
        """Write the settings; return the motor current in mA, 0 if the drive does not have them."""
        current_ma = self._current()
        differing = self._differing(current_ma)
        self._report_lacks()
        if not differing:
            right = ", ".join(each.what for each in self._wanted(current_ma))
            self.dialog.say(f"Its settings are right: {right}.")
            return current_ma
        for each in differing:
            is_set = value_words(self.found.settings.get(each.setting.code))
            before = f"now {is_set}" if is_set else "not reported by this firmware"
            self.dialog.say(f"  {each.what:<18} {before}  ({each.why})")
        if not self.dialog.agreed(
            f"Write these settings to drive {self.drive.node}? Nothing turns; the motor may begin "
            "to hold.",
            "The drive keeps them without power. no leaves it as it is: "
            f"`{command_line('doctor', '--arm', self.arm.name, '--fix')}` can write them later.",
        ):
            return 0
        failed = [each.what for each in differing if not self._write(each.setting)]
        if failed:
            self.dialog.say(f"The drive did not accept: {', '.join(failed)}.")
            return 0
        self.dialog.say(f"Written: {', '.join(each.what for each in differing)}.")
        return current_ma

    def _write(self, setting: Setting) -> bool:
        return self.dialog.on_wire(write, self.drive.node, setting, self.found.able)

    def _current(self) -> int:
        if self.arm.device.current_ma:
            return int(min(self.arm.device.current_ma, self.found.most_ma))
        present = self.found.settings.get(Code.CURRENT)
        default = str(present.current_ma) if isinstance(present, SetCurrent) else None
        most_ma = self.found.most_ma
        answer = self.dialog.ask(
            Question(
                f"Current of the {self.drive.name} motor, in mA?",
                f"What its data sheet calls rated or phase current, up to {most_ma} mA for this "
                "board. Too little stalls, too much makes it hot: begin with less.",
                whole(1, most_ma, "mA"),
                default,
            ),
        )
        return int(answer)

    def _report_lacks(self) -> None:
        if self.arm.device.watchdog_s and Ability.SILENCE_WATCHDOG not in self.found.able:
            self.dialog.say(
                "Its firmware has no watchdog (98, from 1.0.9 on): if the computer dies, it runs "
                "on to its last target, which is never more than 0.3 s ahead."
            )

    def calibrate(self) -> bool:
        """Offer a calibration; return whether the encoder is calibrated, as far as is known."""
        calibrated = self.found.firmware.calibrated
        if calibrated:
            wanted = self.dialog.agreed(
                _ALREADY,
                "Needed only after the drive was mounted on another motor.",
                About.FREE,
                default="no",
            )
        else:
            self.dialog.say(
                f"Drive {self.drive.node} does not report that it is calibrated. Calibration turns "
                f"the motor by itself, for up to {LONGEST_S:g} s, and only switching its supply "
                "off is certain to stop it. So the shaft must be free: no belt, no gear, no arm. A "
                "drive that was sold with its motor usually is calibrated."
            )
            wanted = self.dialog.agreed(
                f"Is the shaft of the {self.drive.name} motor free, and may it turn now?",
                "no skips it; calibrate before the motor is built in.",
                About.FREE,
            )
        if not wanted:
            return calibrated is not False
        if self.dialog.on_wire(calibrate, self.drive.node):
            self.dialog.say(f"Drive {self.drive.node} is calibrated.")
            return True
        self.dialog.say(
            f"Drive {self.drive.node} did not calibrate. Look at the supply (12 V at least), at "
            "the motor's two phases, and that the magnet sits on the shaft's end. A current that "
            "cannot turn the motor leaves it calibrating for ever, and it may lower its current: "
            "switch its supply off and on, start again, and give it more (one owner needed 3000 mA "
            "for a SERVO42D)."
        )
        return False

    def try_watchdog(self) -> None:
        """Offer to try whether it stops by itself on a silent bus, and report what it did."""
        usual_ms = round(self.arm.device.watchdog_s * 1000)
        if not usual_ms or Ability.SILENCE_WATCHDOG not in self.found.able:
            return
        node, degrees = self.drive.node, 360.0 * TRIAL_COUNTS / COUNTS_PER_TURN
        if not self.dialog.agreed(
            f"Try the watchdog? The {self.drive.name} motor is switched on, its shaft turns by up "
            f"to {degrees:.0f}° and back, and the bus falls silent: the drive should stop early by "
            "itself. If it does not, only the supply's switch ends the turn early. Now?",
            f"The watchdog is set to {TRIAL_MS} ms for the trial, and back to {usual_ms} ms "
            "afterwards. no leaves it untried.",
        ):
            return
        share, restored = None, False
        try:
            share, restored = self.dialog.on_wire(
                try_watchdog, node, SilenceWatchdog(usual_ms), self.found.able
            )
        finally:
            if not restored:
                self.dialog.say(
                    f"The watchdog of drive {node} may still be at {TRIAL_MS} ms, which stops the "
                    "drive in the middle of motions. Check its supply and cable, then run "
                    f"`{command_line('can', 'setup', self.arm.name)}` again, which sets it back."
                )
        self.dialog.say(_watchdog_words(share))


# A motor that made less than the first share of its turn did not run, less than the second was
# stopped.
STILL_SHARE, STOPPED_SHARE = 0.02, 0.7


def _watchdog_words(share: float | None) -> str:
    if share is None:
        return "The drive did not take part in the trial: check its supply and cable."
    if share < STILL_SHARE:
        return "The motor did not move at all, so the trial shows nothing."
    if share <= STOPPED_SHARE:
        return f"The watchdog works: it stopped after {share:.0%} of the way."
    return (
        "The watchdog did not stop it. If this computer dies, the drive goes on to its last "
        "target, which armdrive keeps at most 0.3 s ahead."
    )


# A drive joins the bus: it already has its id, or gets it. Nothing turns.

# A drive has adopted a new id after this time.
SETTLE_S = 0.3

ONE_AT_A_TIME = (
    "Every drive is shipped as id 1. Two drives with one id both obey a command and garble each "
    "other's answers, so plug in one new drive at a time."
)
CHECKS = (
    "No drive answers. Check that it has its motor supply, that CAN H and L are not swapped, "
    "that both ends of the cable have their resistor of 120 ohm, and that its bit rate (CanRate in "
    "its menu, 500K as shipped) is that of the adapter. `armdrive doctor --can` examines the bus."
)


def set_up(dialog: DriveDialog, arm: ArmConfig, drive: DrivePlace, again: bool) -> int | None:
    """Take a drive through its steps; return its motor current in mA, None if it is not ready."""
    found = _arrived(dialog, drive, others=len(arm.device.ids) > 1)
    if found is None:
        return None
    at_hand = MksDriveAtHand(dialog, arm, drive, found)
    if at_hand.ready_ma and not again:
        dialog.say("It has its id and its settings: nothing to do.")
        return at_hand.ready_ma
    # the current first: without enough of it, a calibration never ends
    current_ma = at_hand.settle()
    calibrated = at_hand.calibrate()
    if not (current_ma and calibrated):
        return None
    # last, since only a calibrated motor turns as ordered
    at_hand.try_watchdog()
    return current_ma


def _arrived(dialog: DriveDialog, drive: DrivePlace, *, others: bool) -> KnownDrive | None:
    """Bring a drive to its id; None if the person skips it."""
    found = _recognised(dialog, drive, others)
    while found is None:
        if not _plug_in(dialog, drive):
            return None
        ready: bool | None = dialog.on_wire(answers, drive.node)
        if not ready:
            ready = _give_id(dialog, drive)
        if ready is None:
            return None
        if ready:
            found = _checked(dialog, drive.node)
    return found


def _recognised(dialog: DriveDialog, drive: DrivePlace, others: bool) -> KnownDrive | None:
    """Return the drive if its id answers and can only be this one."""
    if drive.node == NODE_DEFAULT and others:
        return None  # may be a new drive, so the person has to confirm it
    if not dialog.on_wire(answers, drive.node):
        return None
    return _checked(dialog, drive.node)


def _plug_in(dialog: DriveDialog, drive: DrivePlace) -> bool:
    words = f"Is the drive of the {drive.name} plugged in, and no other new one?"
    dialog.say(
        f"Plug the CAN cable of the {drive.name} drive in. Drives that have their ids may stay."
    )
    return dialog.agreed(
        words,
        f"{ONE_AT_A_TIME} no skips the {drive.name} for now.",
        About.CONNECT,
        drive.motor,
    )


def _checked(dialog: DriveDialog, node: int) -> KnownDrive | None:
    """Examine the drive with an id; None if none has it, two have, or it is of another series."""
    found = dialog.on_wire(known, node)
    if found is None:
        dialog.say(CHECKS)
        return None
    if found.doubled:
        dialog.say(f"More than one drive answers as id {node}. {ONE_AT_A_TIME}")
        return None
    if found.firmware.e_series:
        dialog.say(series_words(f"drive {node}") + ".")
        return None
    words = {None: "", True: ", calibrated", False: ", its encoder not calibrated"}
    calibrated = words[found.firmware.calibrated]
    at = "" if found.counts is None else f", at {counted(found.counts, 'count')}"
    dialog.say(
        f"Drive {found.node} answers: {found.board}, {found.firmware_words}{at}{calibrated}."
    )
    return found


def _give_id(dialog: DriveDialog, drive: DrivePlace) -> bool | None:
    """Give the new drive, which has id 1, the id of its motor; None if the person declines.

    False means that it failed: the person may plug in another drive and try again.
    """
    if _checked(dialog, NODE_DEFAULT) is None:
        return False
    if not dialog.agreed(
        f"A new drive answers as id {NODE_DEFAULT}. Make it id {drive.node}, for the "
        f"{drive.name}? Nothing turns.",
        "It keeps the id without power (8B). no leaves it as it is.",
    ):
        return None
    dialog.on_wire(_take_id, drive.node)
    if not dialog.on_wire(answers, drive.node):
        dialog.say(
            "It does not answer to the new id. Switch its supply off and on, then try again."
        )
        return False
    if dialog.on_wire(answers, NODE_DEFAULT):
        dialog.say(
            f"Id {drive.node} answers now, but id {NODE_DEFAULT} still does as well: a second new "
            f"drive is on the bus, and may have become id {drive.node} too. Unplug all but one of "
            "them, and set the CanID of the others back in their menu if it has changed."
        )
        return False
    dialog.say(f"It is drive {drive.node} now.")
    return True


def _take_id(io: MksExchange, node: int) -> MksScript[None]:
    """Give a new drive its id and time to adopt it."""
    yield from order(io, NODE_DEFAULT, SetId(node))
    yield from io.pause(io.now_s + SETTLE_S)


def alone(io: MksExchange, node: int) -> MksScript[bool]:
    """Find out whether exactly one drive answers to an id."""
    return (yield from answers(io, node)) and not (yield from is_shared(io, node))


def section(device: MksSettings, ids: Sequence[int], current_ma: int) -> dict[str, Any]:
    """Return the arm file's section [mks]; a current of 0 is left out."""
    known: dict[str, Any] = {
        "ids": list(ids),
        "watchdog_s": device.watchdog_s,
        "microsteps": device.microsteps,
    }
    return known | ({"current_ma": current_ma} if current_ma else {})


# The steps for each drive, in order.
STEPS = (
    "its id, and whether it is alone with it",
    f"its settings: mode {Mode.BUS_FOC.title}, replies, microsteps, current, watchdog",
    "its encoder's calibration, if it has none: with a free shaft",
    "its watchdog: a small turn, which has to end when the bus falls silent",
)

# The MKS protocol on a bus.
BUS = BusTools(
    name="mks",
    dialect="mks",
    most=NODE_MAX,
    scripts=scripts,
    ask=survey_drives,
    reads_command=lambda frame, _master: read_request(frame) is not None,
    reads_answer=lambda frame: read_answer(frame) is not None,
    connects=True,
    next=("can", "setup", "NAME"),
    hint="does more: it writes the arm file, and sets the drives up one by one",
    commissioning=CommissioningTools(
        new_id=NODE_DEFAULT,
        steps=STEPS,
        caution=ONE_AT_A_TIME,
        set_up=set_up,
        alone=alone,
        section=section,
    ),
)

TOOLS = DeviceTools(TALK, bus=BUS, describer=MksFrameDescriber)
