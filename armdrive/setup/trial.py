"""Trying one motor out in the arm: by a little motion its direction and its gear are found.

The first motion is an eighth of the second, since a gear that is believed wrongly would turn the
joint as many times too far.
"""

from __future__ import annotations

import math

from armdrive.dialects.bus.tools import DriveAtHand, Turned
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

NUDGE = 8
"""The first motion is this part of the second."""
LIKE = 0.2
"""A gear is taken as it was told where what was seen differs by no more than this share."""
AS_SAID, MORE = "as announced", "more"
MOST = 10_000.0


def try_out(
    plan: CommissioningPlan, drive: Planned, at_hand: DriveAtHand, notes: Notes
) -> Talk[bool]:
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
    if not (yield from at_hand.switch_on()):
        return False
    gear = yield from _gear(drive, notes.gear or drive.gear)
    start = yield from at_hand.where()
    while start is not None:
        gear = yield from _nudged(drive, at_hand, start, gear)
        if not gear:
            break
        word = yield from _shown(drive, at_hand, start, gear, notes)
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


def _nudged(drive: Planned, at_hand: DriveAtHand, start: int, gear: float) -> Talk[float]:
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
        turned = yield from at_hand.turn_to(start + counts, counts)
        seen = "" if turned.trouble else (yield from _compared(drive, about))
        back = yield from at_hand.turn_to(start, counts)
        if turned.trouble or back.trouble:
            yield from _failed(drive, turned if turned.trouble else back)
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


def _shown(
    drive: Planned, at_hand: DriveAtHand, start: int, gear: float, notes: Notes
) -> Talk[str]:
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
    turned = yield from at_hand.turn_to(start + counts, counts)
    word, roll, measured = "", "", 0.0
    if not turned.trouble:
        word, roll, measured = yield from _asked(drive)
        yield from say("It goes back.")
    back = yield from at_hand.turn_to(start, counts)
    if turned.trouble or back.trouble:
        yield from _failed(drive, turned if turned.trouble else back)
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


def _failed(drive: Planned, turned: Turned) -> Talk[None]:
    yield from say(
        f"The {drive.name} motor stands at {turned.counts} counts, where it should not: "
        f"{turned.trouble}."
    )


_UNCLEAR = {
    NOTHING: "Nothing moved that you could see: look at the gear's or belt's seat on the {name} "
    "motor's shaft, or tell a smaller number of turns, and try again.",
    OTHER: "Another motor moved: this drive does not sit on the {name}. Exchange the cables, or "
    "the ids in the arm file's [mks], and begin this drive again.",
}
