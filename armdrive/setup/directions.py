"""Finds the directions of motors from small motions: what should be seen, and what was seen.

A motion is described in mm at the finger tips, so that its directions can be compared; a turn of
the hand about its own axis counts as `ROLL_LEVER_MM` a radian. The user stands behind the arm: left
is counter-clockwise about the base axis from above, and clockwise is seen along the hand.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import partial
from types import MappingProxyType
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.dialog import About, Dialog, Question, WrongAnswer, choice, number, yes_or_no
from armdrive.errors import BadRequest, Refused
from armdrive.sim.world.body import found_posture
from armdrive.text.toml_amend import Change
from kinematics.geometry import ArmGeometry
from kinematics.limits import wrap
from kinematics.spaces import Joints
from kinematics.text import mm_text, shown_name
from kinematics.transmission import Transmission

ROLL_LEVER_MM = 40.0
# A direction with less than this share of the strongest one is not noticed.
SEEN_SHARE = 0.15
# A smaller motion is not noticed, whatever its share.
LEAST_MM = 0.05

# The words of each direction, the positive one first.
WAYS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "turn": ("left", "right"),
        "height": ("up", "down"),
        "reach": ("out", "in"),
        "roll": ("clockwise", "counter-clockwise"),
        "fingers": ("open", "close"),
    }
)


@dataclass(frozen=True, slots=True)
class Sight:
    """A motion as it looks: signed mm in each direction of `WAYS`."""

    way_mm: Mapping[str, float]

    @property
    def strongest_mm(self) -> float:
        """The motion in the strongest direction."""
        return max(map(abs, self.way_mm.values()))

    def visible(self) -> tuple[str, ...]:
        """Return the directions that are noticed, the strongest first."""
        least = max(SEEN_SHARE * self.strongest_mm, LEAST_MM)
        seen = [way for way, mm in self.way_mm.items() if abs(mm) >= least]
        return tuple(sorted(seen, key=lambda way: -abs(self.way_mm[way])))

    def word(self, way: str) -> str:
        """Return the word for the motion in one direction."""
        positive, negative = WAYS[way]
        return positive if self.way_mm[way] > 0.0 else negative

    def __str__(self) -> str:
        seen = [f"{self.word(way)} {mm_text(abs(self.way_mm[way]))}" for way in self.visible()]
        return ", ".join(seen) or "nothing"


@dataclass(frozen=True, slots=True)
class ArmMotion:
    """A motion of an arm: its joints and the opening of its fingers before and after."""

    arm: ArmGeometry
    before: Joints
    after: Joints
    opened_from_mm: float
    opened_to_mm: float

    @property
    def sight(self) -> Sight:
        """The motion as it looks."""
        return sight(self.arm, self.before, self.after, self.opened_mm)

    @property
    def opened_mm(self) -> float:
        """How far the fingers have opened."""
        return self.opened_to_mm - self.opened_from_mm

    def turned_deg(self, joint: str) -> float:
        """Return how far a joint has turned."""
        at = self.after.names.index(joint)
        return math.degrees(self.after[at] - self.before[at])


def sight(arm: ArmGeometry, before: Joints, after: Joints, opened_mm: float = 0.0) -> Sight:
    """Return how the motion from one posture to another looks."""
    (x0, y0, z0), (x1, y1, z1) = arm.points(before)[-1], arm.points(after)[-1]
    radius = math.hypot(x0, y0)
    turned = wrap(math.atan2(y1, x1) - math.atan2(y0, x0)) if radius > LEAST_MM else 0.0
    rolled = wrap(arm.fk(after).roll_rad - arm.fk(before).roll_rad)
    return Sight(
        {
            "turn": turned * radius,
            "height": z1 - z0,
            "reach": math.hypot(x1, y1) - radius,
            "roll": rolled * ROLL_LEVER_MM,
            "fingers": opened_mm,
        }
    )


# Trials, answers, and the conclusion about the directions of motors and joints.
#
# Each motor is turned alone, since the cables of a Mini-mover make one motor move several joints.
# The model says what should be seen; if the user saw the opposite, the motor counts the other way.
# The turn of the hand shows the two wrist motors together: if both turn it the other way than
# their pitch says, the roll joint is reversed.

TRIAL_MM = 10.0
TRIAL_RAD = math.radians(5.0)
# A trial ends at the first of these: the motion of the tip, of a joint, and of the fingers.
TRIAL_OPENING_MM = 3.0

# The share of the motors' speed at which they are tried.
TRIAL_SPEED = 0.1

NOTHING, OTHER, AGAIN = "nothing", "other", "again"
FINGERS = "fingers"


@dataclass(frozen=True, slots=True)
class Trial:
    """One motor turned alone by some steps, and what should be seen of it.

    `moves` is the joint, or the fingers, that it moves most: by `amount` degrees or mm if the arm
    file has its steps right.
    """

    motor: int
    name: str
    steps: int
    expected: Sight
    moves: str
    amount: float

    @property
    def unit(self) -> str:
        """The unit of `amount`."""
        return "mm" if self.moves == FINGERS else "°"

    def shown(self, amount: float) -> str:
        """Return an amount with its unit."""
        return f"{amount:.2g}{self.unit}" if self.unit == "°" else f"{amount:.2g} {self.unit}"

    def moved(self, motion: ArmMotion) -> float:
        """Return how far the joint or the fingers moved."""
        if self.moves == FINGERS:
            return abs(motion.opened_mm)
        return abs(motion.turned_deg(self.moves))

    @property
    def ways(self) -> tuple[str, ...]:
        """The directions to ask about; the hand's turn only if nothing else is visible."""
        seen = self.expected.visible()
        return tuple(way for way in seen if way != "roll") or seen

    @property
    def turns_hand(self) -> bool:
        """Whether the hand's turn has to be asked about in addition to another direction."""
        return "roll" in self.expected.visible() and self.ways != ("roll",)

    def words(self) -> tuple[str, ...]:
        """Return the words that are valid answers."""
        return tuple(word for way in self.ways for word in WAYS[way])

    def seen(self, word: str, roll: str = "") -> SeenMotion:
        """Return what the answers to `ask_way` mean.

        Raises `WrongAnswer` for a direction in which this motor moves nothing.
        """
        if word in (NOTHING, OTHER):
            return SeenMotion(self, SawMotion.NOT_AT_ALL if word == NOTHING else SawMotion.ANOTHER)
        if word not in self.words():
            raise WrongAnswer(
                f"the {self.name} motor should move the arm {' or '.join(self.words())}; if "
                f"something else moved, answer {OTHER}"
            )
        saw = SawMotion.AS_SHOWN if self._expects(word) else SawMotion.OTHER_WAY
        return SeenMotion(self, saw, self._expects(roll) if roll in WAYS["roll"] else None)

    def _expects(self, word: str) -> bool:
        return any(word in words and self.expected.word(way) == word for way, words in WAYS.items())


def ask_way(dialog: Dialog, trial: Trial) -> tuple[str, str]:
    """Ask which way a motor moved the arm, and which way the hand turned if it should turn.

    Return the words for both; the second is empty if it was not asked.
    """
    words = (*trial.words(), NOTHING, OTHER, AGAIN)
    way = Question(
        f"Which way did it go? {', '.join(words)}:",
        f"{OTHER}: something else moved, so this motor is wired in another one's place. {AGAIN}: "
        "show me again.",
        choice(words),
    )
    word = str(dialog.ask(way, About.WAY, by_eye=partial(_seen_word, trial)))
    if word in (NOTHING, OTHER, AGAIN) or not trial.turns_hand:
        return word, ""
    rolls = (*WAYS["roll"], NOTHING)
    roll = Question(
        f"And the hand turned about its own axis? {', '.join(rolls)}:",
        "Seen from behind the hand, looking towards the finger tips.",
        choice(rolls),
    )
    return word, str(dialog.ask(roll, by_eye=_seen_roll))


MOST_SEEN = 10_000.0  # degrees or mm: more is a slip of the finger
# The arm file's steps are right if the motion that was seen differs by at most this share.
TOLERANCE = 0.2
# A motion this many times as far as announced is noticed, however small it is.
MUCH_FARTHER = 2.5


def ask_small(dialog: Dialog, trial: Trial, about: float) -> bool:
    """Ask whether a small motion was no larger than announced; it may be too small to be seen."""
    question = Question(
        f"Was that about {trial.shown(about)}, or too little to see?",
        "no: it was much more than that. Then its steps in the arm file are wrong, and it makes "
        "no larger motion.",
        yes_or_no,
        "yes",
    )

    def by_eye(motion: ArmMotion) -> str:
        return "no" if trial.moved(motion) > MUCH_FARTHER * about else "yes"

    return bool(dialog.ask(question, by_eye=by_eye))


def ask_share(dialog: Dialog, trial: Trial, about: float) -> float:
    """Ask how far a motor moved; return it as a share of what was expected, 1 if it is right."""
    unit = "mm" if trial.moves == FINGERS else "degrees"
    question = Question(
        f"How far did the {shown_name(trial.moves)} move, in {unit}?",
        "Measure it, or judge it by eye: an error of a fifth is small enough to find a wrong gear.",
        number(0.001, MOST_SEEN, trial.unit),
        f"{about:.2g}",
    )
    moved = float(dialog.ask(question, by_eye=lambda motion: f"{trial.moved(motion):.3g}"))
    share = moved / about
    return 1.0 if abs(share - 1.0) <= TOLERANCE else float(f"{share:.3g}")


def _seen_word(trial: Trial, motion: ArmMotion) -> str:
    seen = motion.sight
    ways = [way for way in seen.visible() if way in trial.ways]
    if ways:
        return seen.word(ways[0])
    return OTHER if seen.visible() else NOTHING


def _seen_roll(motion: ArmMotion) -> str:
    seen = motion.sight
    return seen.word("roll") if "roll" in seen.visible() else NOTHING


class SawMotion(Enum):
    """What was seen of one motor, compared with what should be seen."""

    AS_SHOWN = "it moved as shown"
    OTHER_WAY = "it moved the other way"
    NOT_AT_ALL = "nothing moved"
    ANOTHER = "another motor's part moved"
    TWICE = "about twice as far"
    HALF = "about half as far"
    ELSE_FAR = "it moved much farther"


# How far the motor moved, as a share of what the arm file says, by answers that say no number.
SHARES: Mapping[SawMotion, float] = MappingProxyType({SawMotion.TWICE: 2.0, SawMotion.HALF: 0.5})

# The answers about the turn of the hand: whether it was the expected one; None if not seen.
HAND: Mapping[SawMotion, bool | None] = MappingProxyType(
    {SawMotion.AS_SHOWN: True, SawMotion.OTHER_WAY: False, SawMotion.NOT_AT_ALL: None}
)


@dataclass(frozen=True, slots=True)
class SeenMotion:
    """What the user saw of a trial.

    `hand` is whether the hand turned as expected, None if that was not asked or not seen. `instead`
    names the motor whose part moved, if the user said which. `share` is how far the motor moved, as
    a share of the expected distance.
    """

    trial: Trial
    saw: SawMotion
    hand: bool | None = None
    instead: str = ""
    share: float = 1.0


@dataclass(frozen=True, slots=True)
class Signs:
    """The motors and joints that are reversed or unclear, and other mistakes that were seen.

    `farther` has the share of the expected distance by motor; `order` has the motor that moved, by
    the motor that was turned. Both leave out the motors that are right.
    """

    motors: tuple[str, ...] = ()
    joints: tuple[str, ...] = ()
    unclear: tuple[str, ...] = ()
    farther: Mapping[str, float] = field(default_factory=dict)
    order: Mapping[str, str] = field(default_factory=dict)


def trials(arm: ArmGeometry, transmission: Transmission, posture: Joints) -> tuple[Trial, ...]:
    """Return a trial of each motor, the gripper's first, which makes room for the fingers."""
    order = list(range(len(transmission.motors)))
    if transmission.has_gripper:
        order = [order[-1], *order[:-1]]  # it is the controller's last motor
    return tuple(trial_of(arm, transmission, posture, motor) for motor in order)


def trial_of(arm: ArmGeometry, transmission: Transmission, posture: Joints, motor: int) -> Trial:
    """Return the trial of one motor."""
    column = [row[motor] for row in transmission.inverse]
    count = len(transmission.joint_names)
    turning = column[:count]
    pulling = column[count] if transmission.has_gripper else 0.0
    # so short that what is seen grows in proportion to the steps
    probe = 1e-3 / max(*map(abs, turning), abs(pulling) * 1e-2)
    one = _seen(arm, posture, turning, pulling, probe)
    steps = min(
        TRIAL_MM * probe / max(one.strongest_mm, 1e-9),
        TRIAL_RAD / max(*map(abs, turning), 1e-12),
        TRIAL_OPENING_MM / abs(pulling) if pulling else math.inf,
    )
    whole = max(round(steps), 1)
    expected = _seen(arm, posture, turning, _own_pull(turning, pulling), whole)
    # behind cables a motor moves several joints: the person watches the one that moves most
    most = max(range(count), key=lambda at: abs(turning[at]))
    if turning[most]:
        moves, amount = transmission.joint_names[most], math.degrees(abs(turning[most])) * whole
    else:
        moves, amount = FINGERS, abs(pulling) * whole
    return Trial(motor, transmission.motors[motor].name, whole, expected, moves, amount)


def _own_pull(turning: list[float], pulling: float) -> float:
    """Return the fingers' motion by the gripper's own motor alone, without what follows a joint."""
    return pulling if max(map(abs, turning)) == 0.0 else 0.0


def _seen(
    arm: ArmGeometry, posture: Joints, turning: list[float], pulling: float, steps: float
) -> Sight:
    angles = tuple(angle + steps * one for angle, one in zip(posture, turning, strict=True))
    return sight(arm, posture, Joints(angles, posture.names), pulling * steps)


def conclude(seen: Iterable[SeenMotion], roll_joint: str) -> Signs:
    """Return what is wrong; `roll_joint` is the joint that the two wrist motors turn together.

    A motor that moved another one's part shows nothing about directions.
    """
    motors, unclear, rolls = [], [], []
    farther, order = {}, {}
    for each in seen:
        name = each.trial.name
        if each.instead:
            order[name] = each.instead
            continue
        if each.saw in (SawMotion.NOT_AT_ALL, SawMotion.ANOTHER):
            unclear.append(name)
            continue
        if each.share != 1.0:
            farther[name] = each.share
        if each.saw in (SawMotion.AS_SHOWN, SawMotion.OTHER_WAY):
            right = each.saw is SawMotion.AS_SHOWN
            if not right:
                motors.append(name)
            if each.trial.turns_hand and each.hand is not None:
                rolls.append(right == each.hand)
    if len(set(rolls)) > 1:
        unclear.append(roll_joint)
    joints = (roll_joint,) if rolls and not any(rolls) else ()
    return Signs(tuple(motors), joints, tuple(unclear), farther, order)


def roll_joint(arm: ArmGeometry, posture: Joints) -> str:
    """Return the last joint whose turn looks like a turn of the hand alone."""
    found = posture.names[-1]
    for index, name in enumerate(posture.names):
        angles = [angle + (0.01 if at == index else 0.0) for at, angle in enumerate(posture)]
        seen = sight(arm, posture, Joints(tuple(angles), posture.names))
        if seen.visible() == ("roll",):
            found = name
    return found


# The keys of an arm file that have to change.


def written_steps(steps: float) -> float:
    """Return steps for a turn or a mm as an arm file has them: no arm is measured as exactly."""
    return float(f"{steps:.9g}")


def _known_steps(table: Mapping[str, Any], transmission: Transmission | None) -> dict[str, float]:
    """Return each motor's steps for a turn or a mm, from an arm file or its preset."""
    if "motors" in table:
        return {each["name"]: each[_steps_key(each)] for each in table["motors"]}
    known: dict[str, float] = {}
    if transmission is not None:
        for motor in transmission.motors[: len(transmission.joint_names)]:
            own = abs(motor.steps_per_unit) * math.tau
            known[motor.name] = table.get("steps_per_turn", {}).get(motor.name, own)
        for motor in transmission.motors[len(transmission.joint_names) :]:
            known[motor.name] = table.get("steps_per_mm", abs(motor.steps_per_unit))
    return known


def _steps_key(motor: Mapping[str, Any]) -> str:
    return "steps_per_mm" if "steps_per_mm" in motor else "steps_per_turn"


def changes(
    table: Mapping[str, Any],
    transmission: Transmission | None,
    signs: Signs,
) -> tuple[Change, ...]:
    """Return the changes to an arm file's keys."""
    known = _known_steps(table, transmission)
    found = {name: written_steps(known[name] / share) for name, share in signs.farther.items()}
    if "motors" in table:
        return tuple(_of_motors(table["motors"], signs, found))
    return tuple(_of_preset(table, transmission, signs, found))


def _far(share: float) -> str:
    return f"it moved {share:g} times as far as it should have"


def _of_preset(
    table: Mapping[str, Any],
    transmission: Transmission | None,
    signs: Signs,
    steps: Mapping[str, float],
) -> Iterator[Change]:
    gripper = transmission.motors[-1].name if transmission and transmission.has_gripper else ""
    for name, each in steps.items():
        path = ("steps_per_mm",) if name == gripper else ("steps_per_turn", name)
        yield Change(path, each, _far(signs.farther[name]))
    for section, names in (("motor_signs", signs.motors), ("joint_signs", signs.joints)):
        for name in names:
            known = table.get(section, {}).get(name, 1)
            yield Change((section, name), -known, SawMotion.OTHER_WAY.value)


def _of_motors(
    motors: list[Mapping[str, Any]],
    signs: Signs,
    steps: Mapping[str, float],
) -> Iterator[Change]:
    """Give the changes to [[motors]]; a motor that follows another follows its direction too."""
    turned = dict.fromkeys(signs.motors, -1)
    joints = dict.fromkeys(signs.joints, -1)
    for index, motor in enumerate(motors):
        name = str(motor.get("name"))
        own = turned.get(name, 1)
        sees = {key: one * own * joints.get(key, 1) for key, one in motor.get("sees", {}).items()}
        if "sees" not in motor and own < 0:
            sees = {"opening": -1}  # the default of a gripper's motor
        if sees and sees != motor.get("sees"):
            yield Change(("motors", index, "sees"), sees, SawMotion.OTHER_WAY.value)
        if name in steps:
            yield Change(
                ("motors", index, _steps_key(motor)), steps[name], _far(signs.farther[name])
            )
        follows = motor.get("follows", {})
        now = {other: ratio * own * turned.get(other, 1) for other, ratio in follows.items()}
        mine = signs.farther.get(name, 1.0)
        exact = {other: one * signs.farther.get(other, 1.0) / mine for other, one in now.items()}
        if all(one == int(one) for one in exact.values()):  # only whole steps can be added
            now = {other: int(one) for other, one in exact.items()}
        if now != follows:
            yield Change(("motors", index, "follows"), now, "its motors were corrected")


# The check goes through the motors of an arm: turn one, answer what was seen, turn the next.
#
# It moves nothing itself: `steps` returns the next motion, and the caller reports it by `turned`.
# Each motor is brought back before the next one turns. A motor is in one of these states:
#
#     not shown            its turn has come; it may be turned, or left out (`NOT_AT_ALL`)
#     away and shown       it stands at the end of its motion; the desk takes the answer here
#     back and shown       it was brought back first; the terminal takes the answer here
#     away, `answered`     the answer is known, and the motor has to be brought back
#
# `asks_hand` stands between two answers: the way of the arm is known, the turn of the hand is not.


class DirectionCheck:
    """The motor whose turn it is, and the answers so far."""

    def __init__(self, arm: ArmGeometry, transmission: Transmission, posture: Joints) -> None:
        self.posture = posture
        self.transmission = transmission
        self.trials = trials(arm, transmission, posture)
        self.looks: tuple[SeenMotion, ...] = ()
        self.away = False
        """Whether the motor has been turned and not yet brought back."""
        self.shown = False
        """Whether the motor has been turned since its turn came."""
        self._roll = roll_joint(arm, posture)
        self._half: SeenMotion | None = None

    @property
    def trial(self) -> Trial | None:
        """The motor whose turn it is, None at the end."""
        at = len(self.looks)
        if self.away and self.answered:
            at -= 1  # answered for, and its turn lasts until it is back
        return self.trials[at] if at < len(self.trials) else None

    @property
    def answered(self) -> bool:
        """Whether the motor has its answer, and only has to be brought back."""
        return self.away and not self.shown

    @property
    def asks_hand(self) -> bool:
        """Whether the next answer is which way the hand turned about its own axis."""
        return self._half is not None

    @property
    def after(self) -> Joints | None:
        """The posture after the motor's turn, according to the arm file."""
        trial = self.trial
        if trial is None:
            return None
        column = [row[trial.motor] for row in self.transmission.inverse]
        names = self.posture.names
        turning = zip(self.posture, column[: len(names)], strict=True)
        return Joints(tuple(angle + trial.steps * one for angle, one in turning), names)

    def steps(self, motors: int) -> tuple[int, ...]:
        """Return the steps of all motors for the next motion, there or back."""
        trial = self.trial
        counts = [0] * motors
        if trial is not None:
            counts[trial.motor] = -trial.steps if self.away else trial.steps
        return tuple(counts)

    def turned(self) -> None:
        """Note that the motion was made."""
        if self.away:
            self.away = False
        else:
            self.away = self.shown = True

    def saw(self, what: SawMotion, instead: str = "") -> None:
        """Take what was seen of the motor, or of the hand if `asks_hand`. Raises `BadRequest`."""
        trial = self.trial
        if trial is None:
            raise BadRequest("every motor has its answer")
        if self.answered:
            raise BadRequest("this motor has its answer: bring it back first")
        if self._half is not None:
            if what not in HAND:
                raise BadRequest("only which way the hand turned is asked now")
            self.note(replace(self._half, hand=HAND[what]))
            return
        if not self.shown and what is not SawMotion.NOT_AT_ALL:
            raise BadRequest("turn it first: it has not moved yet")
        seen = SeenMotion(trial, what, instead=instead, share=SHARES.get(what, 1.0))
        if what in (SawMotion.AS_SHOWN, SawMotion.OTHER_WAY) and trial.turns_hand:
            self._half = seen
        else:
            self.note(seen)

    def note(self, seen: SeenMotion) -> None:
        """Take all that was seen of the motor."""
        self.looks = (*self.looks, seen)
        self.shown, self._half = False, None

    def others(self) -> tuple[str, ...]:
        """Return the names of the other motors, any of which may have moved instead."""
        now = self.trial
        return tuple(m.name for m in self.transmission.motors if now is None or m.name != now.name)

    def signs(self) -> Signs:
        """Return the conclusion from all answers so far."""
        return conclude(self.looks, self._roll)


def check_of(config: ArmConfig, joints: Joints | None) -> DirectionCheck:
    """Return the check of an arm with these joints; with None, in the posture that users are shown.

    Raises `Refused` if the arm's motor steps are unknown.
    """
    transmission = config.model.transmission
    if transmission is None:
        raise Refused(
            "the motor steps of this arm are not known: give steps_per_mm and [steps_per_turn] "
            "first"
        )
    arm = config.model.arm
    return DirectionCheck(arm, transmission, joints or found_posture(arm))
