"""Commissions the drives of an arm, one after the other; the user may stop and go on later.

New MKS drives get their ids and settings. CiA 402 drives have theirs from their makers' programs:
of them, the units of speed and ramps are measured.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TypeVar

from armdrive.config.arm import ArmConfig
from armdrive.dialects.bus.tools import (
    DriveAtHand,
    DriveDialog,
    DrivePlace,
    Listened,
    frame_scripts,
    listen,
)
from armdrive.dialects.controller import Controller
from armdrive.dialog import About, Question, choice, number
from armdrive.errors import BadRequest
from armdrive.errors.printable import command_line
from armdrive.runtime.clock import SignalsBetweenSteps
from armdrive.setup.directions import AGAIN, NOTHING, OTHER, ArmMotion, ask_way, trial_of
from armdrive.setup.draft import ratio
from armdrive.setup.plan import CommissioningPlan, Notes, Planned
from armdrive.setup.prober import is_command
from armdrive.sim.world.body import found_posture
from armdrive.tasks import (
    Done,
    MeasuredUnits,
    MeasureUnits,
    MoveBy,
    ReadPosition,
    Registers,
    Reply,
    Request,
    RequestRejected,
    SwitchOn,
    Timeout,
)
from kinematics.spaces import Motors
from kinematics.text import counted

T = TypeVar("T")

# One motor is tried out in the arm: a small motion shows its direction and its gear.
#
# The first motion is an eighth of the second, since a wrong gear would turn the joint that many
# times too far. The dialect's controller turns the motor as if it were a whole arm, in pieces that
# each end by themselves within a quarter of a second.

FIRST_PART = 8
"""The first motion is this part of the second."""
GEAR_TOLERANCE = 0.2
"""The user's gear is kept if the motion seen differs from the expected by at most this share."""
AS_SAID, MORE = "as announced", "more"
MUCH_FURTHER = 2.5
"""A motion this many times as far as announced is "more"."""
MOST_SEEN = 10_000.0  # degrees or mm: more is a slip of the finger

PIECE_S = 0.25
"""No motion is commanded further ahead."""
WHOLE_S = 1.6
"""A trial motion takes about this long."""
RUN_S = 0.8
"""The motion of the watchdog's trial takes this long if the watchdog does not stop it."""
SENT_S = 0.1
"""That motion is sent like any other for this long; then nothing more is sent."""
MOST_RPM = 60
"""A motor's shaft makes at most one turn a second in a trial."""
GIVES_WAY_PART = 32
"""A motor is sent back at most as far as it was sent, plus one turn divided by this."""


@dataclass(frozen=True, slots=True)
class TriedMotor:
    """One motor and the controller that turns it; `turn` is the counts of a turn of its shaft."""

    dialog: DriveDialog
    controller: Controller
    turn: int

    def switch_on(self) -> bool:
        """Make the motor hold; return whether it does, and tell the user if not."""
        reply = self._ask(SwitchOn())
        if not isinstance(reply, Done):
            self.dialog.say(f"The drive did not switch its motor on: {_why(reply)}.")
        return isinstance(reply, Done)

    def where(self) -> int | None:
        """Return the motor's position; None if the drive does not tell it."""
        reply = self._ask(ReadPosition())
        return reply.positions[0] if isinstance(reply, Registers) else None

    def turn_to(self, target: int, counts: int) -> str:
        """Turn to `target`, no further than `counts`, slowly enough to be watched.

        Return what went wrong; empty if the motor is there.
        """
        reply = self._ask(ReadPosition())
        if not isinstance(reply, Registers):
            return self._off_target(reply)
        at = reply.positions[0]
        if abs(target - at) > abs(counts) + self.turn // GIVES_WAY_PART:
            return f"stands at {at} counts, too far from {target}: it was reset, or turned by force"
        rate_hz = self._rate_hz(counts, WHOLE_S)
        pieces = math.ceil(abs(target - at) / max(1, int(rate_hz * PIECE_S)))
        begin = at
        for piece in range(1, pieces + 1):
            # each goal is computed from the beginning, so that rounding does not add up
            goal = begin + round((target - begin) * piece / pieces)
            reply = self._ask(MoveBy(Motors((goal - at,)), rate_hz))
            if not isinstance(reply, Done):
                return self._off_target(reply)
            at = goal
        return ""

    def run_and_fall_silent(self, counts: int) -> tuple[int, int | None]:
        """Begin to turn by about `counts`, and fall silent halfway as a program that dies does.

        Return how far the motor was to turn, and its position afterwards.
        """
        least = self.turn / 60.0 * RUN_S  # at one rpm
        way = round(min(max(counts, least), MOST_RPM * least))
        run = MoveBy(Motors((way,)), self._rate_hz(way, RUN_S))
        self.dialog.carry_out(self.controller, run, SENT_S)
        return way, self.where()

    def _off_target(self, reply: Reply) -> str:
        at = self.where()
        lost = "is not where it should be"
        stands = lost if at is None else f"stands at {at} counts, where it should not"
        return f"{stands}: {_why(reply)}"

    def _rate_hz(self, counts: int, seconds: float) -> float:
        """Return the rate at which `counts` take about `seconds`: whole rpm, never fast."""
        rpm = round(abs(counts) / self.turn * 60.0 / seconds)
        return max(1, min(rpm, MOST_RPM)) * self.turn / 60.0

    def _ask(self, request: Request) -> Reply:
        reply: Reply = self.dialog.carry_out(self.controller, request, math.inf)
        return reply


def _why(reply: Reply) -> str:
    """Return why a request was not carried out."""
    if isinstance(reply, Timeout):
        return "it does not answer"
    return reply.reason if isinstance(reply, RequestRejected) else str(reply)


_UNCLEAR = {
    NOTHING: "You saw nothing move: check that the gear or belt sits firmly on the {name} motor's "
    "shaft, or give a smaller number of turns, and try again.",
    OTHER: "Another motor moved: this drive is not connected to the {name} motor. Exchange the "
    "cables, or the two ids in the arm file, and begin this drive again.",
}


# The watchdog is tried: does a drive stop by itself if its bus falls silent while it moves?

_SILENT = "stopped answering: check its supply and cable"

TRIAL_S = 0.1
"""The watchdog's time while it is tried."""
STILL_SHARE = 0.01
"""A motor that came no further than this share of its way did not run at all."""
STOPPED_SHARE = 0.7
"""A motor that came no further than this share of its way was stopped."""


@dataclass(frozen=True, slots=True)
class MotorTrial:
    """Tries a motor out in the arm named `arm`, with a person who watches; fills in the notes."""

    dialog: DriveDialog
    arm: str
    drive: Planned
    motor: TriedMotor
    notes: Notes

    def counts(self, gear: float) -> int:
        """Return the counts of the trial if the motor has this gear."""
        return max(round(self.drive.trial.steps * gear / self.drive.gear), FIRST_PART)

    def try_out(self) -> bool:
        """Find the motor's direction and gear; return whether that worked.

        Asks before each motion.
        """
        mounted = self.dialog.agreed(
            f"Is the {self.drive.name} motor built into the arm, with space for a small motion? "
            "Then its direction and gear can be found now.",
            f"no leaves that for later: run `{command_line('can', 'setup', self.arm)}` again, or "
            f"`{command_line('config', 'signs', self.arm)}` when the whole arm is there.",
            About.MOUNTED,
            self.drive.motor,
        )
        if not mounted:
            return False
        if not self.dialog.agreed(
            f"Switch the {self.drive.name} motor on? It holds from then on, and moves nothing.",
            "F3. The switch of its supply lets it go.",
        ):
            return False
        if not self.motor.switch_on():
            return False
        gear = self._gear(self.notes.gear or self.drive.gear)
        start = self.motor.where()
        while start is not None:
            gear = self._nudged(start, gear)
            if not gear:
                break
            word = self._shown(start, gear)
            if word == AGAIN:
                continue
            return bool(word)
        self.dialog.say(f"The {self.drive.name} is left for later.")
        return False

    def _gear(self, default: float) -> float:
        question = Question(
            f"How many turns of the motor are {self.drive.gear_words}?",
            "20:1, teeth 60/16, a product of such, or a number. If you do not know, press Enter: "
            "the first motion is very small, and shows whether the default is about right.",
            lambda line: ratio(line).turns,
            f"{default:.6g}",
        )
        gear = float(self.dialog.ask(question))
        # the default is shown rounded
        return default if math.isclose(gear, default, rel_tol=1e-5) else gear

    def _nudged(self, start: int, gear: float) -> float:
        """Move very little and back; return a gear that fits, or 0 to leave the motor out."""
        while True:
            counts = max(self.counts(gear) // FIRST_PART, 1)
            about = self.drive.amount / FIRST_PART
            if not self.dialog.agreed(
                f"The motor turns the {self.drive.moves} by about {self.drive.shown(about)} and "
                "back. Keep a hand at the supply's switch. Now?",
                "It turns in pieces of a quarter of a second, and Ctrl-C stops it. no leaves this "
                "motor out.",
            ):
                return 0.0
            trouble = self._turned(start, counts)
            seen = "" if trouble else self._while_away(partial(self._compared, about))
            if self._brought_back(start, counts, trouble):
                return 0.0
            if seen != MORE:
                return gear
            gear = self._gear(gear / FIRST_PART)

    def _compared(self, about: float) -> str:
        words = (AS_SAID, MORE, NOTHING)
        question = Question(
            f"Was that about {self.drive.shown(about)}? {', '.join(words)}:",
            f"{MORE}: much more than that, so the gear is wrong. {NOTHING}: too little to see, "
            "which is fine; a larger motion follows after your yes.",
            choice(words),
        )

        def by_eye(motion: ArmMotion) -> str:
            return MORE if self.drive.moved(motion) > MUCH_FURTHER * about else AS_SAID

        return str(self.dialog.ask(question, by_eye=by_eye))

    def _shown(self, start: int, gear: float) -> str:
        """Make the whole trial motion; note what the user saw, and return the word for it."""
        counts = self.counts(gear)
        if not self.dialog.agreed(
            f"Now by about {self.drive.shown(self.drive.amount)}; the motor waits there for your "
            "answers, then goes back. Go?",
            "Stand behind the arm: left and right are yours as you look along it.",
        ):
            return ""
        trouble = self._turned(start, counts)
        word, roll, measured = "", "", 0.0
        if not trouble:
            word, roll, measured = self._while_away(self._asked)
            self.dialog.say("It goes back.")
        if self._brought_back(start, counts, trouble):
            return ""
        if word in (NOTHING, OTHER):
            self.dialog.say(_UNCLEAR[word].format(name=self.drive.name))
            return ""
        if word != AGAIN:
            self.notes.way, self.notes.roll = word, roll
            self.notes.gear = self._concluded(gear, measured)
        return word

    def _asked(self) -> tuple[str, str, float]:
        word, roll = ask_way(self.dialog, self.drive.trial)
        if word in (NOTHING, OTHER, AGAIN):
            return word, "", 0.0
        about = self.drive.amount
        far = Question(
            f"How far did the {self.drive.moves} move, in {self.drive.unit_words}?",
            "Measure it, or judge it by eye: an error of a fifth is small enough to find a wrong "
            "gear.",
            number(0.001, MOST_SEEN, self.drive.unit),
            f"{about:.2g}",
        )
        by_eye = lambda motion: f"{self.drive.moved(motion):.3g}"  # noqa: E731
        return word, roll, float(self.dialog.ask(far, by_eye=by_eye))

    def _concluded(self, gear: float, measured: float) -> float:
        """Return the gear: the user's if the motion agrees with it, else ask for it again."""
        about = self.drive.amount
        if abs(measured / about - 1.0) <= GEAR_TOLERANCE:
            return gear
        by_sight = gear * about / measured
        self.dialog.say(
            f"It moved {self.drive.shown(measured)} instead of {self.drive.shown(about)}, so the "
            f"gear is about {by_sight:.3g}, not {gear:.6g}."
        )
        return self._gear(float(f"{by_sight:.3g}"))

    def _turned(self, start: int, counts: int) -> str:
        """Turn while the person watches; return what went wrong."""
        self.dialog.person.look(moved=False)
        trouble = self.motor.turn_to(start + counts, counts)
        self.dialog.person.look(moved=True)
        return trouble

    def _while_away(self, ask: Callable[[], T]) -> T:
        """Ask the person about a motor that is away from its start; say so if the person leaves."""
        try:
            return ask()
        except BaseException:  # it is not turned back, since the person may have seen a danger
            self.dialog.say(f"The {self.drive.name} motor was not turned back to where it began.")
            raise

    def _brought_back(self, start: int, counts: int, trouble: str) -> bool:
        """Turn back to the start; return whether this or the last motion failed."""
        back = self.motor.turn_to(start, counts)
        if trouble or back:
            self.dialog.say(f"The {self.drive.name} motor {trouble or back}.")
        return bool(trouble or back)

    def try_watchdog(self, at_hand: DriveAtHand, counts: int) -> bool | None:
        """Try whether the drive stops by itself on a silent bus, by a motion of some `counts`.

        Return whether the drive stopped; None if that was not tried.
        """
        if not at_hand.watchdog_s:
            return None
        if not self.dialog.agreed(
            f"Try the watchdog? The {self.drive.name} runs as far as before, and the bus falls "
            "silent: the drive should stop early by itself. If it does not, only the supply's "
            f"switch stops it for {RUN_S:g} s. Now?",
            f"The watchdog is set to {TRIAL_S * 1000:.0f} ms for the trial, and back to "
            f"{at_hand.watchdog_s:g} s afterwards. no leaves it untried.",
        ):
            return None
        if not self.motor.switch_on():
            return None
        start = self.motor.where()
        if start is None:
            self.dialog.say(f"Drive {self.drive.node} {_SILENT}.")
            return False
        # restored in any case: a drive with the short time would stop in the middle of motions
        restored = False
        try:
            if not at_hand.set_watchdog(TRIAL_S):
                self.dialog.say("The drive refuses the watchdog's time.")
                return False
            way, at = self.motor.run_and_fall_silent(counts)
        finally:
            restored = self._restore_watchdog(at_hand)
        # the motor goes back from wherever it stopped, before its report
        self.motor.turn_to(start, counts)
        if at is None:
            self.dialog.say(f"Drive {self.drive.node} {_SILENT}.")
        if at is None or not restored:
            return False
        share = abs(at - start) / way
        if share < STILL_SHARE:
            self.dialog.say("The motor did not move at all, so the trial shows nothing.")
            return None
        works = share <= STOPPED_SHARE
        self.dialog.say(
            f"The watchdog works: it stopped after {share:.0%} of the way."
            if works
            else "The watchdog did not stop it. If this computer dies, the drive goes on to its "
            "last target, which armdrive keeps at most 0.3 s ahead."
        )
        return works

    def _restore_watchdog(self, at_hand: DriveAtHand) -> bool:
        """Set the drive's watchdog as it was before the trial; return whether it is.

        Ctrl-C waits until this is done. If it fails, the user gets a message.
        """
        restored = False
        try:
            with SignalsBetweenSteps():
                restored = at_hand.set_watchdog(at_hand.watchdog_s)
        finally:
            if not restored:
                self.dialog.say(
                    f"The watchdog of drive {self.drive.node} may still be at "
                    f"{TRIAL_S * 1000:.0f} ms, which stops the drive in the middle of motions. "
                    "Check its supply and cable, then run "
                    f"`{command_line('can', 'setup', self.arm)}` again, which sets it back."
                )
        return restored


@dataclass(frozen=True, slots=True)
class CommissioningOutcome:
    """The result: notes by motor, the motors left out, and the drives missing at the end."""

    notes: Mapping[str, Notes]
    left_out: tuple[str, ...]
    missing: tuple[str, ...] = ()

    @property
    def finished(self) -> bool:
        """Whether every drive is set up and answers."""
        return not self.left_out and not self.missing


def commission(
    dialog: DriveDialog, plan: CommissioningPlan, notes: dict[str, Notes], *, again: bool = False
) -> CommissioningOutcome:
    """Commission every drive of an arm; steps noted earlier are skipped, unless `again`.

    The user can leave at any question; the next run goes on there with the notes kept so far.
    """
    _introduce(dialog, plan, notes, again=again)
    if _others_command(dialog):
        return CommissioningOutcome(notes, tuple(each.name for each in plan.drives))
    left_out = []
    for drive in plan.order:
        dialog.say("", f"--- {drive.title}")
        if not commission_drive(dialog, plan, drive, notes, again=again):
            left_out.append(drive.name)
    missing = ask_together(dialog, plan)
    return CommissioningOutcome(notes, tuple(left_out), missing)


def _introduce(
    dialog: DriveDialog, plan: CommissioningPlan, notes: Mapping[str, Notes], *, again: bool
) -> None:
    listed = ", ".join(f"{each.node} {each.name}" for each in plan.drives)
    dialog.say(
        f"Commissioning {counted(len(plan.drives), 'drive')} of {plan.name}: {listed}.",
        "For each of them:",
        *(f"  {number}  {step}" for number, step in enumerate(plan.tools.steps, 1)),
        "Nothing is written and nothing turns without your yes, and each question says what will "
        "happen. Ctrl-C leaves at any time: finished steps stay done, and the same command "
        "continues from there.",
        plan.tools.caution,
    )
    done = [each.name for each in plan.drives if notes.get(each.name, Notes()).done]
    if done and not again:
        dialog.say(f"Done in an earlier run: {', '.join(done)}; --again repeats them.")


def _others_command(dialog: DriveDialog) -> bool:
    """Return whether another program commands drives on this bus, and tell the user."""
    frames = frame_scripts()
    look = partial(listen, frames.io, is_command)
    traffic: Listened = dialog.carry_out(frames, look, math.inf)
    if traffic.commands:
        dialog.say(
            "Another program commands drives on this bus: end it first, then begin again. "
            "`armdrive can monitor` shows what it sends. Nothing was asked or set."
        )
    return bool(traffic.commands)


def commission_drive(
    dialog: DriveDialog,
    plan: CommissioningPlan,
    drive: Planned,
    notes: dict[str, Notes],
    *,
    again: bool,
) -> bool:
    """Take one drive through its steps and keep notes after each; return whether it is ready."""
    others = len(plan.drives) > 1
    place = DrivePlace(drive.motor, drive.name, drive.node)
    at_hand = plan.tools.arrive(dialog, plan.config, place, others)
    if at_hand is None:
        return False
    noted = notes.setdefault(drive.name, Notes())
    noted.firmware = at_hand.firmware or noted.firmware
    if noted.done and not again and at_hand.keeps_settings:
        dialog.say("It has its id and its settings: nothing to do.")
        return True
    tried = bool(noted.way or noted.done) and not again
    # if the user leaves in the middle, the next run has to look at this drive again
    noted.done = False
    noted.current_ma = at_hand.settle()
    dialog.keep(notes)
    noted.calibrated = at_hand.calibrate()
    at_hand.offer_zero()
    motor = TriedMotor(dialog, plan.controller(at_hand.by_itself), plan.tools.counts_per_turn)
    trial = MotorTrial(dialog, plan.name, drive, motor, noted)
    tried = tried or trial.try_out()
    dialog.keep(notes)
    if tried and noted.gear and (again or noted.watchdog is None):
        noted.watchdog = trial.try_watchdog(at_hand, trial.counts(noted.gear))
    noted.done = tried and bool(noted.current_ma)
    dialog.keep(notes)
    return noted.done


def ask_together(dialog: DriveDialog, plan: CommissioningPlan) -> tuple[str, ...]:
    """Ask all drives once they are plugged in; return the names of those that do not answer."""
    dialog.say("", "--- all together")
    while True:
        if not dialog.agreed(
            f"Is everything plugged in, {counted(len(plan.drives), 'drive')} in all? Then they are "
            "asked together; nothing turns.",
            "no ends here; the arm file can still be written.",
        ):
            return tuple(each.name for each in plan.drives)
        alone = partial(dialog.on_wire, plan.tools.alone)
        wrong = [drive for drive in plan.drives if not alone(drive.node)]
        if not wrong:
            dialog.say(f"All answer: {counted(len(plan.drives), 'drive')}, each under its own id.")
            return ()
        named = ", ".join(each.title for each in wrong)
        dialog.say(
            f"Not there, or two drives with one id: {named}. The whole bus needs a resistor of 120 "
            "ohm at each of its two ends, and nowhere else."
        )


# The units in which drives count speeds and ramps: each motor turns a little, slowly, and back.


def measure_units(
    dialog: DriveDialog, config: ArmConfig, controller: Controller
) -> tuple[MeasuredUnits, ...]:
    """Measure the units of every drive of an arm, in the order of its motors.

    Returns none at all if the user declines, or if one of them cannot be measured. The motors stay
    on. One question comes before all turns, since drives stop once this program has not sent its
    heartbeat for a while.
    """
    arm, transmission = config.model.arm, config.model.transmission
    if transmission is None:
        raise BadRequest(f"{config.name} has no motors: its model file has no [transmission]")
    posture, motors = found_posture(arm), range(len(transmission.motors))
    tried = [trial_of(arm, transmission, posture, motor) for motor in motors]
    dialog.say(
        f"Measuring in which units the {counted(len(tried), 'drive')} of {config.name} count "
        "speeds and ramps. One motor after the other turns slowly, for about ten seconds: by 5° "
        "of its joint at most, usually far less, and back. The others hold. Have the arm stand "
        "clear of everything, and keep a hand at the power switch. Ctrl-C stops.",
    )
    if not dialog.agreed(
        "Switch the motors on and begin?", "Anything but yes leaves the arm alone."
    ):
        return ()
    reply = dialog.carry_out(controller, SwitchOn(), math.inf)
    found: list[MeasuredUnits] = []
    if not isinstance(reply, Done):
        dialog.say(f"The motors were not switched on: {_why(reply)}.")
        return ()
    for trial in tried:
        reply = dialog.carry_out(controller, MeasureUnits(trial.motor, trial.steps), math.inf)
        if not isinstance(reply, MeasuredUnits):
            dialog.say(f"The {trial.name} was not measured: {_why(reply)}.")
            return ()
        dialog.say(f"{trial.name}: {reply}.")
        found.append(reply)
    return tuple(found)
