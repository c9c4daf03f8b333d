"""The whole walk-through: every drive of an arm, one after the other, left and taken up at will."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

from armdrive.dialects.bus.tools import (
    CarryOut,
    DriveAtHand,
    DrivePlace,
    Listened,
    frame_scripts,
    listen,
    on_wire,
)
from armdrive.dialects.controller import Controller
from armdrive.dialog.conversation import (
    About,
    Keep,
    Look,
    Question,
    Talk,
    agreed,
    ask,
    choice,
    number,
    say,
)
from armdrive.setup.directions import AGAIN, NOTHING, OTHER, ArmMotion, ask_way
from armdrive.setup.draft import ratio
from armdrive.setup.plan import CommissioningPlan, Notes, Planned
from armdrive.setup.prober import is_command
from armdrive.tasks import (
    Done,
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

# Trying one motor out in the arm: by a little motion its direction and its gear are found.
#
# The first motion is an eighth of the second, since a gear that is believed wrongly would turn the
# joint as many times too far. The controller of the dialect turns the motor, as that of an arm
# that
# is this motor alone, in pieces that each end by themselves within a quarter of a second.

NUDGE = 8
"""The first motion is this part of the second."""
LIKE = 0.2
"""A gear is taken as it was told where what was seen differs by no more than this share."""
AS_SAID, MORE = "as announced", "more"
MUCH = 2.5
"""A motion this many times as far as announced is "more"."""
MOST = 10_000.0

PIECE_S = 0.25
"""No motion is commanded further ahead."""
WHOLE_S = 1.6
"""A trial takes about so long."""
RUN_S = 0.8
"""A run of the watchdog's trial would take so long, were it not stopped."""
LED_S = 0.1
"""So long it is led like any other; then nothing more is said."""
MOST_RPM = 60
GIVE = 32
"""No motor is sent back by more than it was sent, and this part of a turn."""


@dataclass(frozen=True, slots=True)
class TriedMotor:
    """One motor and the controller that turns it; a turn of its shaft has so many counts."""

    controller: Controller
    turn: int

    def switch_on(self) -> Talk[bool]:
        """Have it hold; return whether it does, and say so where it does not."""
        reply = yield from self._ask(SwitchOn())
        if not isinstance(reply, Done):
            yield from say(f"The drive did not switch its motor on: {_why(reply)}.")
        return isinstance(reply, Done)

    def where(self) -> Talk[int | None]:
        """Read where it stands."""
        reply = yield from self._ask(ReadPosition())
        return reply.positions[0] if isinstance(reply, Registers) else None

    def turn_to(self, target: int, counts: int) -> Talk[str]:
        """Turn to a count, as slowly as a motion of so many counts is to be watched; no farther.

        Return what is wrong; empty where it is there.
        """
        reply = yield from self._ask(ReadPosition())
        if not isinstance(reply, Registers):
            return (yield from self._astray(reply))
        at = reply.positions[0]
        if abs(target - at) > abs(counts) + self.turn // GIVE:
            return f"stands at {at} counts, too far from {target}: it was reset, or turned by force"
        rate_hz = self._rate_hz(counts, WHOLE_S)
        pieces = math.ceil(abs(target - at) / max(1, int(rate_hz * PIECE_S)))
        begin = at
        for piece in range(1, pieces + 1):
            goal = begin + round((target - begin) * piece / pieces)
            reply = yield from self._ask(MoveBy(Motors((goal - at,)), rate_hz))
            if not isinstance(reply, Done):
                return (yield from self._astray(reply))
            at = goal
        return ""

    def run_unled(self, counts: int) -> Talk[tuple[int, int | None]]:
        """Begin a run of about so many counts, and fall silent in its midst as a dead program does.

        Return how far it was to go, and where it was found to stand.
        """
        least = self.turn / 60.0 * RUN_S  # at one rpm
        way = round(min(max(counts, least), MOST_RPM * least))
        run = MoveBy(Motors((way,)), self._rate_hz(way, RUN_S))
        yield CarryOut(self.controller, run, LED_S)
        return way, (yield from self.where())

    def _astray(self, reply: Reply) -> Talk[str]:
        at = yield from self.where()
        lost = "is not where it should be"
        stands = lost if at is None else f"stands at {at} counts, where it should not"
        return f"{stands}: {_why(reply)}"

    def _rate_hz(self, counts: int, seconds: float) -> float:
        """Return the rate at which so many counts take about so long: whole rpm, never fast."""
        rpm = round(abs(counts) / self.turn * 60.0 / seconds)
        return max(1, min(rpm, MOST_RPM)) * self.turn / 60.0

    def _ask(self, request: Request) -> Talk[Reply]:
        reply: Reply = yield CarryOut(self.controller, request)
        return reply


def _why(reply: Reply) -> str:
    """Say why something was not carried out."""
    if isinstance(reply, Timeout):
        return "it does not answer"
    return reply.reason if isinstance(reply, RequestRejected) else str(reply)


def try_out(plan: CommissioningPlan, drive: Planned, motor: TriedMotor, notes: Notes) -> Talk[bool]:
    """Find direction and gear of a motor; return whether that was done. Moves after each yes."""
    mounted = yield from agreed(
        f"Is the {drive.name} motor built into the arm, with space for a small motion? Then its "
        "direction and gear can be found now.",
        f"no leaves that for later: run `armdrive can setup {plan.name}` again, or `armdrive "
        f"config signs {plan.name}` when the whole arm is there.",
        About.MOUNTED,
        drive.motor,
    )
    if not mounted:
        return False
    if not (
        yield from agreed(
            f"Switch the {drive.name} motor on? It holds from then on, and moves nothing.",
            "F3. The switch of its supply lets it go.",
            motor=drive.motor,
        )
    ):
        return False
    if not (yield from motor.switch_on()):
        return False
    gear = yield from _gear(drive, notes.gear or drive.gear)
    start = yield from motor.where()
    while start is not None:
        gear = yield from _nudged(drive, motor, start, gear)
        if not gear:
            break
        word = yield from _shown(drive, motor, start, gear, notes)
        if word == AGAIN:
            continue
        return bool(word)
    yield from say(f"The {drive.name} is left for later.")
    return False


def counts_of(drive: Planned, gear: float) -> int:
    """Return the counts of the trial where a motor has a gear."""
    return max(round(drive.trial.steps * gear / drive.gear), NUDGE)


def _gear(drive: Planned, default: float) -> Talk[float]:
    question = Question(
        "",
        f"How many turns of the motor are {drive.gear_words}?",
        "20:1, teeth 60/16, a product of such, or a number. If you do not know, take what stands "
        "in brackets: the first motion is very small, and shows whether it is about right.",
        lambda line: ratio(line).turns,
        f"{default:.6g}",
    )
    told = float((yield from ask(question, About.NUMBER, drive.motor)))
    return default if math.isclose(told, default, rel_tol=1e-5) else told  # brackets round


def _nudged(drive: Planned, motor: TriedMotor, start: int, gear: float) -> Talk[float]:
    """Move a very little and back; return the gear that is right so far, 0 to leave it."""
    while True:
        counts = max(counts_of(drive, gear) // NUDGE, 1)
        about = drive.amount / NUDGE
        if not (
            yield from agreed(
                f"The motor turns the {drive.moves} by about {drive.shown(about)} and back. "
                "A hand at the supply's switch. Now?",
                "In pieces of a quarter of a second; Ctrl-C stops it. no leaves this motor out.",
                motor=drive.motor,
            )
        ):
            return 0.0
        yield Look(moved=False)
        trouble = yield from motor.turn_to(start + counts, counts)
        yield Look(moved=True)
        seen = "" if trouble else (yield from _compared(drive, about))
        if (yield from _brought_back(drive, motor, start, counts, trouble)):
            return 0.0
        if seen != MORE:
            return gear
        gear = yield from _gear(drive, gear / NUDGE)


def _compared(drive: Planned, about: float) -> Talk[str]:
    words = (AS_SAID, MORE, NOTHING)
    question = Question(
        "",
        f"Was that about {drive.shown(about)}? {', '.join(words)}:",
        f"{MORE}: much more than that, so that the gear is another. {NOTHING}: too little to see, "
        "which is no harm; a larger motion follows after your yes.",
        choice(words),
        None,
    )

    def by_eye(motion: ArmMotion) -> str:
        return MORE if drive.moved(motion) > MUCH * about else AS_SAID

    return str((yield from ask(question, About.SEEN, drive.motor, by_eye)))


def _shown(drive: Planned, motor: TriedMotor, start: int, gear: float, notes: Notes) -> Talk[str]:
    """Make the whole trial; note what was seen of it, and return the word for it."""
    counts = counts_of(drive, gear)
    if not (
        yield from agreed(
            f"Now by about {drive.shown(drive.amount)}; it waits there for your answers, then "
            "goes back. Go?",
            "Stand behind the arm: left and right are yours as you look along it.",
            motor=drive.motor,
        )
    ):
        return ""
    yield Look(moved=False)
    trouble = yield from motor.turn_to(start + counts, counts)
    yield Look(moved=True)
    word, roll, measured = "", "", 0.0
    if not trouble:
        word, roll, measured = yield from _asked(drive)
        yield from say("It goes back.")
    if (yield from _brought_back(drive, motor, start, counts, trouble)):
        return ""
    if word in (NOTHING, OTHER):
        yield from say(_UNCLEAR[word].format(name=drive.name))
        return ""
    if word != AGAIN:
        notes.way, notes.roll = word, roll
        notes.gear = yield from _concluded(drive, gear, measured)
    return word


def _asked(drive: Planned) -> Talk[tuple[str, str, float]]:
    word, roll = yield from ask_way(drive.trial)
    if word in (NOTHING, OTHER, AGAIN):
        return word, "", 0.0
    about = drive.amount
    far = Question(
        "",
        f"How far did the {drive.moves} move, in {drive.unit}?",
        "Measure it, or judge it by eye: to within a fifth is good enough to find a wrong gear.",
        number(0.001, MOST, drive.unit),
        f"{about:.2g}",
    )
    by_eye = lambda motion: f"{drive.moved(motion):.3g}"  # noqa: E731
    return word, roll, float((yield from ask(far, About.AMOUNT, drive.motor, by_eye)))


def _concluded(drive: Planned, gear: float, measured: float) -> Talk[float]:
    """Return the gear: as it was told, where what was seen is about that."""
    about = drive.amount
    if abs(measured / about - 1.0) <= LIKE:
        return gear
    by_sight = gear * about / measured
    yield from say(
        f"It moved {drive.shown(measured)}, and {drive.shown(about)} were expected: by that the "
        f"gear is about {by_sight:.3g}, not {gear:.6g}."
    )
    return (yield from _gear(drive, float(f"{by_sight:.3g}")))


def _brought_back(
    drive: Planned, motor: TriedMotor, start: int, counts: int, trouble: str
) -> Talk[bool]:
    """Turn back to the start; tell whether that, or what came before, went wrong, and say so."""
    back = yield from motor.turn_to(start, counts)
    if trouble or back:
        yield from say(f"The {drive.name} motor {trouble or back}.")
    return bool(trouble or back)


_UNCLEAR = {
    NOTHING: "Nothing moved that you could see: look at the gear's or belt's seat on the {name} "
    "motor's shaft, or tell a smaller number of turns, and try again.",
    OTHER: "Another motor moved: this drive does not sit on the {name}. Exchange the cables, or "
    "the ids in the arm file's [mks], and begin this drive again.",
}


# Whether a drive stops by itself when its bus falls silent: its motor runs, and nobody says a word.

TRIAL_S = 0.1
"""What the watchdog is set to while it is tried."""
STILL_SHARE = 0.01
"""One that has come no farther did not run at all."""
STOPPED_SHARE = 0.7
"""It was stopped where it has come no farther than this share of its way."""


def try_watchdog(
    drive: Planned, at_hand: DriveAtHand, motor: TriedMotor, counts: int
) -> Talk[bool | None]:
    """Try by a run of so many counts whether a drive stops by itself when its bus is silent.

    Return whether it stopped the motor, None where that was not tried.
    """
    if not at_hand.watchdog_s:
        return None
    if not (
        yield from agreed(
            f"Try the watchdog? The {drive.name} runs as far as before, and the bus is "
            f"silent: it should stop early by itself. For {RUN_S:g} s only the supply's switch "
            "could stop it otherwise. Now?",
            f"The watchdog is set to {TRIAL_S * 1000:.0f} ms meanwhile, and back to "
            f"{at_hand.watchdog_s:g} s afterwards. no trusts it untried.",
            motor=drive.motor,
        )
    ):
        return None
    if not (yield from motor.switch_on()):
        return None
    start = yield from motor.where()
    if start is None or not (yield from at_hand.set_watchdog(TRIAL_S)):
        yield from say("The drive does not take the watchdog.")
        return False
    way, at = yield from motor.run_unled(counts)
    kept = yield from at_hand.set_watchdog(at_hand.watchdog_s)
    yield from motor.turn_to(start, counts)
    if at is None or not kept:
        yield from say(f"Drive {drive.node} stopped answering: look at its supply and cable.")
        return False
    share = abs(at - start) / way
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


@dataclass(frozen=True, slots=True)
class CommissioningOutcome:
    """What came of it: notes by motor, the motors that were left out, and who is missing at last.

    `finished` says whether every drive has been met and settled.
    """

    notes: Mapping[str, Notes]
    left_out: tuple[str, ...]
    missing: tuple[str, ...] = ()

    @property
    def finished(self) -> bool:
        """Whether nothing is left to be done."""
        return not self.left_out and not self.missing


def walk(
    plan: CommissioningPlan, notes: dict[str, Notes], *, again: bool = False
) -> Talk[CommissioningOutcome]:
    """Commission every drive of an arm; what was noted before is not asked again, unless `again`.

    Ended at any question, it goes on there with the notes that were kept by then.
    """
    yield from _introduce(plan, notes, again=again)
    if (yield from _others_command()):
        return CommissioningOutcome(notes, tuple(each.name for each in plan.drives))
    left_out = []
    for drive in plan.order:
        yield from say("", f"--- {drive.title}")
        if not (yield from one(plan, drive, notes, again=again)):
            left_out.append(drive.name)
    missing = yield from together(plan)
    return CommissioningOutcome(notes, tuple(left_out), missing)


def _introduce(plan: CommissioningPlan, notes: Mapping[str, Notes], *, again: bool) -> Talk[None]:
    listed = ", ".join(f"{each.node} {each.name}" for each in plan.drives)
    yield from say(
        f"Commissioning the {len(plan.drives)} drives of {plan.name}: {listed}.",
        "For each of them:",
        *(f"  {number}  {step}" for number, step in enumerate(plan.tools.steps, 1)),
        "Nothing is written and nothing turns without your yes, and each question says what will "
        "happen. Ctrl-C leaves at any time: what is done stays done, and the same command goes on "
        "there.",
        plan.tools.caution,
    )
    done = [each.name for each in plan.drives if notes.get(each.name, Notes()).done]
    if done and not again:
        yield from say(f"Done in an earlier run: {', '.join(done)}; --again does them once more.")


def _others_command() -> Talk[bool]:
    """Tell whether another program is heard to command drives: two would set and move the same."""
    frames = frame_scripts()
    heard: Listened = yield CarryOut(frames, partial(listen, frames.io, is_command))
    if heard.commands:
        yield from say(
            "Another program commands drives on this bus: end it first, then begin again. "
            "`armdrive can monitor` shows what it says. Nothing was asked or set."
        )
    return bool(heard.commands)


def one(
    plan: CommissioningPlan, drive: Planned, notes: dict[str, Notes], *, again: bool
) -> Talk[bool]:
    """Take one drive through its steps, keeping notes after each; return whether it is ready."""
    others = len(plan.drives) > 1
    place = DrivePlace(drive.motor, drive.name, drive.node)
    at_hand = yield from plan.tools.arrive(plan.config, place, others)
    if at_hand is None:
        return False
    noted = notes.setdefault(drive.name, Notes())
    noted.firmware = at_hand.firmware or noted.firmware
    if noted.done and not again and at_hand.keeps_settings:
        yield from say("It has its id and its settings: nothing is to be done.")
        return True
    noted.current_ma = yield from at_hand.settle()
    yield Keep(notes)
    noted.calibrated = yield from at_hand.calibrate()
    yield from at_hand.offer_zero()
    motor = TriedMotor(plan.controller(at_hand.by_itself), plan.tools.counts_per_turn)
    tried = bool(noted.way or noted.done) and not again
    tried = tried or (yield from try_out(plan, drive, motor, noted))
    yield Keep(notes)
    if tried and noted.gear and (again or noted.watchdog is None):
        counts = counts_of(drive, noted.gear)
        noted.watchdog = yield from try_watchdog(drive, at_hand, motor, counts)
    noted.done = tried and bool(noted.current_ma)
    yield Keep(notes)
    return noted.done


def together(plan: CommissioningPlan) -> Talk[tuple[str, ...]]:
    """Ask all drives, once all are plugged in; return who does not answer alone."""
    yield from say("", "--- all together")
    while True:
        if not (
            yield from agreed(
                f"Are all {len(plan.drives)} drives plugged in, to be asked together? Nothing "
                "turns.",
                "no ends here: the arm file can be written all the same.",
            )
        ):
            return tuple(each.name for each in plan.drives)
        wrong = []
        for drive in plan.drives:
            if not (yield from on_wire(plan.tools.alone, drive.node)):
                wrong.append(drive)  # noqa: PERF401 - a talk cannot be held in a comprehension
        if not wrong:
            yield from say(f"All {len(plan.drives)} answer, each alone.")
            return ()
        named = ", ".join(each.title for each in wrong)
        yield from say(
            f"Not there, or two of one id: {named}. With all of them on it the bus needs its "
            "resistors of 120 ohm at the two ends, and nowhere else."
        )
