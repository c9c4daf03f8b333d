"""Finds the directions of motors from small motions: what should be seen, and what was seen.

Each motor is turned alone, since the cables of a Mini-mover make one motor move several joints. The
model says what should be seen; if the user saw the opposite, the motor counts the other way. The
turn of the hand shows the two wrist motors together: if both turn it the other way than their pitch
says, the roll joint is reversed.

A motion is described in mm at the finger tips, so that its directions can be compared; a turn of
the hand about its own axis counts as `ROLL_LEVER_MM` a radian. The user stands behind the arm: left
is counter-clockwise about the base axis from above, and clockwise is seen along the hand.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from types import MappingProxyType
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.world.body import found_posture
from armdrive.text.toml_amend import Change
from kinematics.geometry import ArmGeometry
from kinematics.limits import wrap
from kinematics.spaces import Joints
from kinematics.text import mm_text
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


# A trial: one motor turned alone by some steps.

# It ends at the first of these: the motion of the tip, of a joint, and of the fingers.
TRIAL_MM = 10.0
TRIAL_RAD = math.radians(5.0)
TRIAL_OPENING_MM = 3.0

# The share of the motors' speed at which they are tried.
TRIAL_SPEED = 0.1

FINGERS = "fingers"


@dataclass(frozen=True, slots=True)
class Trial:
    """One motor turned alone by some steps, and what should be seen of it.

    `moves` is the joint, or the fingers, that it moves most: by `amount` degrees or mm if the arm
    file has its steps right. `after` is the posture that it leads to then.
    """

    motor: int
    name: str
    steps: int
    expected: Sight
    moves: str
    amount: float
    after: Joints

    def shown(self, amount: float) -> str:
        """Return an amount with its unit."""
        return f"{amount:.2g} mm" if self.moves == FINGERS else f"{amount:.2g}°"

    @property
    def ways(self) -> tuple[str, ...]:
        """The directions to ask about; the hand's turn only if nothing else is visible."""
        seen = self.expected.visible()
        return tuple(way for way in seen if way != "roll") or seen

    @property
    def turns_hand(self) -> bool:
        """Whether the hand's turn has to be asked about in addition to another direction."""
        return "roll" in self.expected.visible() and self.ways != ("roll",)

    def expects(self, word: str) -> bool:
        """Return whether a word says the direction in which the motor should move the arm."""
        return any(word in words and self.expected.word(way) == word for way, words in WAYS.items())


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
    turning, pulling = column[:count], column[count] if transmission.has_gripper else 0.0

    def turned(steps: float) -> Joints:
        angles = (angle + steps * one for angle, one in zip(posture, turning, strict=True))
        return Joints(tuple(angles), posture.names)

    def seen(steps: float, pulling: float) -> Sight:
        return sight(arm, posture, turned(steps), pulling * steps)

    # behind cables a motor moves several joints: the person watches the one that moves most
    most = max(range(count), key=lambda at: abs(turning[at]))
    fastest = abs(turning[most])
    # so short that what is seen grows in proportion to the steps
    probe = 1e-3 / max(fastest, abs(pulling) * 1e-2)
    strongest_mm = seen(probe, pulling).strongest_mm
    steps = min(
        TRIAL_MM * probe / max(strongest_mm, 1e-9),
        TRIAL_RAD / max(fastest, 1e-12),
        TRIAL_OPENING_MM / abs(pulling) if pulling else math.inf,
    )
    whole = max(round(steps), 1)
    name = transmission.motors[motor].name
    if fastest:
        joint, amount = transmission.joint_names[most], math.degrees(fastest) * whole
        pulling = 0.0  # the fingers that follow its cable are no sign of its direction
    else:
        joint, amount = FINGERS, abs(pulling) * whole
    return Trial(motor, name, whole, seen(whole, pulling), joint, amount, turned(whole))


# What was seen of the trials, and the conclusion about the directions of motors and joints.


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


def conclude(seen: Iterable[SeenMotion], roll_joint: str) -> Signs:
    """Return what is wrong; `roll_joint`, the last one, turns the hand about its own axis.

    A motor that moved another one's part shows nothing about directions.
    """
    motors, unclear, rolls = [], [], []
    farther, order = {}, {}
    for each in seen:
        name = each.trial.name
        if each.instead:
            order[name] = each.instead
        elif each.saw in (SawMotion.NOT_AT_ALL, SawMotion.ANOTHER):
            unclear.append(name)
        elif each.share != 1.0:
            farther[name] = each.share
        reversed_motor = each.saw is SawMotion.OTHER_WAY
        if reversed_motor:
            motors.append(name)
        if each.hand is not None and each.trial.turns_hand:
            rolls.append(reversed_motor != each.hand)
    if len(set(rolls)) > 1:
        unclear.append(roll_joint)
    joints = (roll_joint,) if rolls and not any(rolls) else ()
    return Signs(tuple(motors), joints, tuple(unclear), farther, order)


# The keys of an arm file that have to change.


def written_steps(steps: float) -> float:
    """Return steps for a turn or a mm as an arm file has them: no arm is measured as exactly."""
    return float(f"{steps:.9g}")


def changes(
    table: Mapping[str, Any], transmission: Transmission | None, signs: Signs
) -> Iterator[Change]:
    """Yield the changes to the keys of an arm file, which describes this transmission."""
    rows = table.get("motors")
    joints = () if transmission is None else transmission.joint_names
    for index, motor in enumerate(() if transmission is None else transmission.motors):
        share = signs.farther.get(motor.name)
        if share is None:
            continue
        turns = index < len(joints)
        key, scale = ("steps_per_turn", math.tau) if turns else ("steps_per_mm", 1.0)
        of_preset = (key, motor.name) if turns else (key,)
        yield Change(
            of_preset if rows is None else ("motors", index, key),
            written_steps(abs(motor.steps_per_unit) * scale / share),
            f"it moved {share:g} times as far as it should have",
        )
    if rows is not None:
        yield from _turned(rows, signs)
        return
    for section, names in (("motor_signs", signs.motors), ("joint_signs", signs.joints)):
        for name in names:
            known = table.get(section, {}).get(name, 1)
            yield Change((section, name), -known, SawMotion.OTHER_WAY.value)


def _turned(rows: list[Mapping[str, Any]], signs: Signs) -> Iterator[Change]:
    """Yield the changes to [[motors]]; a motor that follows another follows its direction too."""
    motors = dict.fromkeys(signs.motors, -1)
    joints = dict.fromkeys(signs.joints, -1)
    for index, row in enumerate(rows):
        own = motors.get(row["name"], 1)
        # a gripper's motor may leave out what it sees
        for key, others in (("sees", joints), ("follows", motors)):
            before = row.get(key, {"opening": 1} if key == "sees" else {})
            after = {name: each * own * others.get(name, 1) for name, each in before.items()}
            if after != before:
                yield Change(("motors", index, key), after, SawMotion.OTHER_WAY.value)


# The check goes through the motors of an arm: turn one, bring it back, answer what was seen.
#
# It moves nothing itself: `steps` returns the next motion, and the caller reports it by `turned`. A
# motor is answered for, or left out (`NOT_AT_ALL`), while it stands where it began. `asks_hand`
# stands between two answers: the way of the arm is known, the turn of the hand is not.


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
        self._half: SeenMotion | None = None

    @property
    def trial(self) -> Trial | None:
        """The motor whose turn it is, None at the end."""
        at = len(self.looks)
        return self.trials[at] if at < len(self.trials) else None

    @property
    def asks_hand(self) -> bool:
        """Whether the next answer is which way the hand turned about its own axis."""
        return self._half is not None

    @property
    def after(self) -> Joints | None:
        """The posture after the motor's turn, according to the arm file."""
        return None if self.trial is None else self.trial.after

    def steps(self, motors: int) -> tuple[int, ...]:
        """Return the steps of all motors for the next motion, there or back."""
        counts = [0] * motors
        if self.trial is not None:
            counts[self.trial.motor] = -self.trial.steps if self.away else self.trial.steps
        return tuple(counts)

    def turned(self) -> None:
        """Note that the motion was made."""
        self.away, self.shown = not self.away, True

    def saw(self, what: SawMotion, instead: str = "") -> None:
        """Take what was seen of the motor, or of the hand if `asks_hand`. Raises `BadRequest`."""
        trial = self.trial
        if trial is None:
            raise BadRequest("every motor has its answer")
        if self.away:
            raise BadRequest("bring it back first, then say what was seen")
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
        return conclude(self.looks, self.posture.names[-1])


def check_of(config: ArmConfig, joints: Joints | None) -> DirectionCheck:
    """Return the check of an arm with these joints; with None, in the posture that users are shown.

    Raises `Refused` if the arm's motor steps are unknown.
    """
    arm = config.model.arm
    return DirectionCheck(arm, config.transmission, joints or found_posture(arm))
