"""Going through the motors of an arm, one after the other: turn it, say what was seen, go on.

It moves nothing by itself: `steps` says what the next turn would be, and `turned` that it was
made. A motor is brought back before the next one's turn.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.errors import BadRequest, Refused
from armdrive.interview.corrections import Look, Saw, Verdict, judge
from armdrive.interview.signs import Trial, roll_joint, trials
from kinematics import Joints, Transmission
from kinematics.geometry import ArmGeometry

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig


class Check:
    """Which motor's turn it is, and what was seen so far."""

    def __init__(self, arm: ArmGeometry, transmission: Transmission, posture: Joints) -> None:
        self.posture = posture
        self.transmission = transmission
        self.trials = trials(arm, transmission, posture)
        self.looks: tuple[Look, ...] = ()
        self.away = False
        """Whether the motor stands where it was turned to, and not yet where it was."""
        self.shown = False
        """Whether the motor was turned at all since its turn came."""
        self._roll = roll_joint(arm, posture)
        self._half: Saw | None = None

    @property
    def trial(self) -> Trial | None:
        """The motor whose turn it is, None at the end."""
        at = len(self.looks)
        if self.away and self.answered:
            at -= 1
        return self.trials[at] if at < len(self.trials) else None

    @property
    def answered(self) -> bool:
        """Whether a motor that is still away has been answered for: it only has to come back."""
        return self.away and not self.shown

    @property
    def asks_hand(self) -> bool:
        """Whether it is asked which way the hand turned about its own axis."""
        return self._half is not None

    @property
    def after(self) -> Joints | None:
        """The posture that the motor's turn would lead to, as the arm file has it."""
        trial = self.trial
        if trial is None:
            return None
        column = [row[trial.motor] for row in self.transmission.inverse]
        names = self.posture.names
        turning = zip(self.posture, column[: len(names)], strict=True)
        return Joints(tuple(angle + trial.steps * one for angle, one in turning), names)

    def steps(self, motors: int) -> tuple[int, ...]:
        """Return the steps of all motors of the next turn: there, or back."""
        trial = self.trial
        counts = [0] * motors
        if trial is not None:
            counts[trial.motor] = -trial.steps if self.away else trial.steps
        return tuple(counts)

    def turned(self) -> None:
        """Note that the turn was made."""
        if self.away:
            self.away = False
        else:
            self.away = self.shown = True

    def saw(self, what: Saw, instead: str = "") -> None:
        """Take what was seen. Raises `BadRequest` where nothing was turned yet."""
        trial = self.trial
        if trial is None:
            raise BadRequest("every motor has been answered for")
        if self.answered:
            raise BadRequest("it was answered already: bring it back first")
        if not self.shown and what is not Saw.NOT_AT_ALL:
            raise BadRequest("turn it first: nothing has been seen of it yet")
        told = what in (Saw.AS_SHOWN, Saw.OTHER_WAY)
        if told and trial.turns_hand and self._half is None:
            self._half = what
            return
        self._note(Look(trial, what, instead))

    def hand(self, word: str) -> None:
        """Take which way the hand turned about its own axis: a word, or "" for not seen."""
        trial = self.trial
        if self._half is None or trial is None:
            raise BadRequest("the hand's turning is not asked for now")
        half, self._half = self._half, None
        self._note(Look(trial, half, hand=word))

    def _note(self, look: Look) -> None:
        self.looks = (*self.looks, look)
        self.shown, self._half = False, None

    def others(self) -> tuple[str, ...]:
        """Return the names of the other motors, any of which may be behind this one's number."""
        now = self.trial
        return tuple(m.name for m in self.transmission.motors if now is None or m.name != now.name)

    def verdict(self) -> Verdict:
        """Return what all the looks so far say together."""
        return judge(self.looks, self._roll)


def check_of(config: ArmConfig, joints: Joints | None) -> Check:
    """Return the check of an arm that stands so, or, with None, as it is asked to be put.

    Raises `Refused` where nothing is known of its motors.
    """
    from armdrive.sim.found import found_posture

    transmission = config.model.transmission
    if transmission is None:
        raise Refused(
            "no motor steps are known of this arm: give steps_per_mm and [steps_per_turn] first"
        )
    arm = config.model.arm
    return Check(arm, transmission, joints or found_posture(arm))
