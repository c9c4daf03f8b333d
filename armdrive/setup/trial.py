"""Trying one motor out in the arm: by a little motion its direction and its gear are found.

The first motion is an eighth of the second, since a gear that is believed wrongly would turn the
joint as many times too far. The controller of the dialect turns the motor, as that of an arm that
is this motor alone, in pieces that each end by themselves within a quarter of a second.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from armdrive.dialects.bus.tools import CarryOut, DriveAtHand
from armdrive.dialects.controller import Controller
from armdrive.dialog.conversation import (
    About,
    NotePosture,
    Question,
    Talk,
    agreed,
    ask,
    choice,
    number,
    say,
)
from armdrive.setup.directions import AGAIN, NOTHING, OTHER, WAYS
from armdrive.setup.draft import ratio
from armdrive.setup.plan import CommissioningPlan, Notes, Planned
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

NUDGE = 8
"""The first motion is this part of the second."""
LIKE = 0.2
"""A gear is taken as it was told where what was seen differs by no more than this share."""
AS_SAID, MORE = "as announced", "more"
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
        yield NotePosture(drive.motor)
        trouble = yield from motor.turn_to(start + counts, counts)
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
    return str((yield from ask(question, About.SEEN, drive.motor)))


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
    yield NotePosture(drive.motor)
    trouble = yield from motor.turn_to(start + counts, counts)
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
    words = (*drive.trial.words(), NOTHING, OTHER, AGAIN)
    question = Question(
        "",
        f"Which way did it go? {', '.join(words)}:",
        f"{OTHER}: something else moved, so this drive sits on another motor. {AGAIN}: show me "
        "again.",
        choice(words),
        None,
    )
    word = str((yield from ask(question, About.WAY, drive.motor)))
    if word in (NOTHING, OTHER, AGAIN):
        return word, "", 0.0
    roll = ""
    if drive.trial.turns_hand:
        rolls = (*WAYS["roll"], NOTHING)
        turning = Question(
            "",
            f"And the hand turned about its own axis? {', '.join(rolls)}:",
            "Seen from behind the hand, looking towards the finger tips.",
            choice(rolls),
            None,
        )
        roll = str((yield from ask(turning, About.ROLL, drive.motor)))
    about = drive.amount
    far = Question(
        "",
        f"How far did the {drive.moves} move, in {drive.unit}?",
        "Measure it, or judge it by eye: a share of a fifth is near enough to find a wrong gear.",
        number(0.001, MOST, drive.unit),
        f"{about:.2g}",
    )
    return word, roll, float((yield from ask(far, About.AMOUNT, drive.motor)))


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
