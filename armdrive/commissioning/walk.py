"""The whole walk-through: every drive of an arm, one after the other, left and taken up at will."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from armdrive.commissioning.acts import Keep, Put, Talk, agreed, say
from armdrive.commissioning.arriving import ONE_AT_A_TIME, all_there, arrive
from armdrive.commissioning.calibrating import calibrate
from armdrive.commissioning.drives import Known
from armdrive.commissioning.guarding import try_watchdog
from armdrive.commissioning.notes import Notes
from armdrive.commissioning.plan import Plan, Planned
from armdrive.commissioning.setting import settle
from armdrive.commissioning.trying import try_out
from armdrive.doctor.can_survey import listen
from firmware_protocol.mks import COUNTS_PER_TURN, TARGET_MAX, Ability, Done, Event, Mode, SetZero

FAR = TARGET_MAX // 4
"""A motor that counts beyond this is offered a new zero: at four times of it, none can be sent."""

STEPS = (
    "its id, and whether it is alone with it",
    "its settings: mode 5 (SR_vFOC), replies, microsteps, current, watchdog",
    "its encoder's calibration, if it has none: with a free shaft",
    "in the arm: direction and gear by a small motion, and the watchdog by another",
)
"""What is done with each drive, in this order."""


@dataclass(frozen=True, slots=True)
class Outcome:
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


def walk(plan: Plan, notes: dict[str, Notes], *, again: bool = False) -> Talk[Outcome]:
    """Commission every drive of an arm; what was noted before is not asked again, unless `again`.

    Ended at any question, it goes on there with the notes that were kept by then.
    """
    yield from _introduce(plan, notes, again=again)
    if (yield from _others_command()):
        return Outcome(notes, tuple(each.name for each in plan.drives))
    left_out = []
    for drive in plan.order:
        yield from say("", f"--- {drive.title}")
        if not (yield from one(plan, drive, notes, again=again)):
            left_out.append(drive.name)
    missing = yield from together(plan)
    return Outcome(notes, tuple(left_out), missing)


def _introduce(plan: Plan, notes: Mapping[str, Notes], *, again: bool) -> Talk[None]:
    listed = ", ".join(f"{each.node} {each.name}" for each in plan.drives)
    yield from say(
        f"Commissioning the {len(plan.drives)} drives of {plan.name}: {listed}.",
        "For each of them:",
        *(f"  {number}  {step}" for number, step in enumerate(STEPS, 1)),
        "Nothing is written and nothing turns without your yes, and each question says what will "
        "happen. Ctrl-C leaves at any time: what is done stays done, and the same command goes on "
        "there.",
        ONE_AT_A_TIME,
    )
    done = [each.name for each in plan.drives if notes.get(each.name, Notes()).done]
    if done and not again:
        yield from say(f"Done in an earlier run: {', '.join(done)}; --again does them once more.")


def _others_command() -> Talk[bool]:
    """Tell whether another program is heard to command drives: two would set and move the same."""
    heard = yield from listen()
    if heard.commands:
        yield from say(
            "Another program commands drives on this bus: end it first, then begin again. "
            "`armdrive can monitor` shows what it says. Nothing was asked or set."
        )
    return bool(heard.commands)


def one(plan: Plan, drive: Planned, notes: dict[str, Notes], *, again: bool) -> Talk[bool]:
    """Take one drive through its steps, keeping notes after each; return whether it is ready."""
    found = yield from arrive(plan, drive)
    if found is None:
        return False
    noted = notes.setdefault(drive.name, Notes())
    noted.firmware = ".".join(map(str, found.firmware)) if found.told else noted.firmware
    if noted.done and not again and _still_right(found):
        yield from say("It has its id and its settings: nothing is to be done.")
        return True
    noted.current_ma = yield from settle(plan, drive, found)
    yield Keep(notes)
    noted.calibrated = yield from calibrate(drive, found)
    yield from _zero(drive, found)
    tried = bool(noted.way or noted.done) and not again
    tried = tried or (yield from try_out(plan, drive, noted))
    yield Keep(notes)
    if tried and noted.gear and (again or noted.watchdog is None):
        noted.watchdog = yield from try_watchdog(plan, drive, found, noted.gear)
    noted.done = tried and bool(noted.current_ma)
    yield Keep(notes)
    return noted.done


def _still_right(found: Known) -> bool:
    """Tell whether a drive that was done has not lost its mode since."""
    return found.mode is None or found.mode.mode is Mode.BUS_FOC


def _zero(drive: Planned, found: Known) -> Talk[None]:
    """Offer a new zero to a drive that counts far from it."""
    if found.counts is None or abs(found.counts) < FAR or Ability.ZERO not in found.able:
        return
    turns = abs(found.counts) / COUNTS_PER_TURN
    if not (
        yield from agreed(
            f"It stands {turns:.0f} turns from its zero, and can be sent 512 at most. Call where "
            "it stands now zero? Nothing turns; the arm has to be referenced afterwards.",
            "92. A drive counts from where it was switched on, or from where it was homed.",
            motor=drive.motor,
        )
    ):
        return
    heard: tuple[Event, ...] = yield Put(drive.node, SetZero())
    taken = any(isinstance(each, Done) for each in heard)
    yield from say("It counts from here." if taken else "The drive did not take the zero.")


def together(plan: Plan) -> Talk[tuple[str, ...]]:
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
        wrong = yield from all_there(plan)
        if not wrong:
            yield from say(f"All {len(plan.drives)} answer, each alone.")
            return ()
        named = ", ".join(each.title for each in wrong)
        yield from say(
            f"Not there, or two of one id: {named}. With all of them on it the bus needs its "
            "resistors of 120 ohm at the two ends, and nowhere else."
        )
