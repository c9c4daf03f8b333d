"""The whole walk-through: every drive of an arm, one after the other, left and taken up at will."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from armdrive.dialects.bus.tools import (
    CarryOut,
    DrivePlace,
    Listened,
    frame_scripts,
    listen,
    on_wire,
)
from armdrive.dialog.conversation import About, AskPerson, Keep, Talk, agreed, say
from armdrive.setup.directions import NOTHING, OTHER, Sight, sight
from armdrive.setup.finding import is_command
from armdrive.setup.plan import MM, CommissioningPlan, Notes, Planned
from armdrive.setup.trial import (
    AS_SAID,
    MORE,
    NUDGE,
    TriedMotor,
    counts_of,
    try_out,
    try_watchdog,
)
from armdrive.sim.device import DrivesOnBus
from armdrive.sim.simulated_arm import SimulatedArm


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


# Commissioning practised on a simulated arm: hands that plug in, eyes that see.

MUCH = 2.5
"""So many times as far as announced is "more"."""
_SEEN = frozenset({About.SEEN, About.WAY, About.ROLL, About.AMOUNT})


class Practice:
    """A person beside a simulated arm, who does and sees what one would beside a real one.

    Without `ask` he answers everything himself; with it a person does, and is told what was seen.
    """

    def __init__(
        self,
        twin: SimulatedArm,
        plan: CommissioningPlan,
        tell: Callable[[str], None],
        ask: Callable[[AskPerson], Any] | None = None,
    ) -> None:
        """Begin with every drive's CAN cable pulled."""
        self.tell = tell
        self._ask = ask
        self._twin = twin
        self._plan = plan
        self._before = (twin.world.joints, twin.world.opening_mm)
        for motor in range(len(plan.drives)):
            self._plug(motor, on=False)

    def watch(self, motor: int) -> None:  # noqa: ARG002 - the eyes are on the whole arm
        """Look how the arm stands."""
        self._before = (self._twin.world.joints, self._twin.world.opening_mm)

    def answer(self, asked: AskPerson) -> Any:
        """Do what a question is about, then answer it or have it answered."""
        if asked.about is About.CONNECT:
            self._plug(asked.motor, on=True)
        seen = self._seen(asked) if asked.about in _SEEN else ""
        if self._ask is None:
            word = seen or asked.question.default or "yes"
            self.tell(f"{asked.question.words} {word}")
            return asked.question.read(word)
        if seen:
            self.tell(f"  (seen on the simulated arm: {seen})")
            asked = replace(asked, question=replace(asked.question, default=seen))
        return self._ask(asked)

    def _plug(self, motor: int, *, on: bool) -> None:
        device: Any = self._twin.device
        if isinstance(device, DrivesOnBus):
            device.drives().plug(motor, on)

    def _seen(self, asked: AskPerson) -> str:
        drive = self._plan.drives[asked.motor]
        if asked.about is About.AMOUNT:
            return f"{self._moved(drive):.3g}"
        if asked.about is About.SEEN:
            return MORE if self._moved(drive) > MUCH * drive.amount / NUDGE else AS_SAID
        seen = self._sight()
        if asked.about is About.ROLL:
            return seen.word("roll") if "roll" in seen.visible() else NOTHING
        ways = [way for way in seen.visible() if way in drive.trial.ways]
        if ways:
            return seen.word(ways[0])
        return OTHER if seen.visible() else NOTHING

    def _sight(self) -> Sight:
        world, (joints, opening_mm) = self._twin.world, self._before
        return sight(world.body.arm, joints, world.joints, world.opening_mm - opening_mm)

    def _moved(self, drive: Planned) -> float:
        world, (joints, opening_mm) = self._twin.world, self._before
        if drive.unit == MM:
            return abs(world.opening_mm - opening_mm)
        at = joints.names.index(drive.moves.replace(" ", "_"))
        return abs(math.degrees(world.joints[at] - joints[at]))
