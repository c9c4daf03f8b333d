"""Measuring an arm at its mark: nothing here moves it, its operator has brought it there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

from armdrive.motion.context import MotionContext
from armdrive.runtime.registers import be_remembered
from armdrive.status import Evidence, State, Trust
from armdrive.tasks import TaskBody
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Motors
from kinematics.transmission import Transmission


def read_at_mark(wire: MotionContext) -> TaskBody[Motors]:
    """Return where the registers say that the motors are, while an operator is at work."""
    core = wire.core
    yield from wire.read()
    _require_homing(wire)
    return core.position.read_back or core.position.acknowledged


def believe_mark(wire: MotionContext) -> TaskBody[None]:
    """Take a restored position for confirmed: the mark has shown that it is right."""
    core = wire.core
    _require_homing(wire)
    if core.belief.trust is Trust.RESTORED:
        core.learn(Evidence.CONFIRMED, wire.now_s)
    core.settle()
    core.mark_still()
    yield from be_remembered(wire)


def doubt_position(wire: MotionContext, detail: str) -> TaskBody[None]:
    """Say that the position is off, where nobody wants to take the mark for the new reference."""
    core = wire.core
    _require_homing(wire)
    core.learn(Evidence.OFF_ITS_MARK, wire.now_s, detail)
    core.settle()
    core.mark_still()
    yield from be_remembered(wire)


def _require_homing(wire: MotionContext) -> None:
    if wire.stopping or wire.core.state is not State.HOMING:
        raise wire.stopped("a stop came between: nothing was changed")


# How far an arm's position is from the truth, measured where the truth is known: at its mark.
#
# An arm without encoders counts steps and hopes. When somebody has brought the finger tips onto the
# table's mark, the registers should read what the reference posture reads; what they read beyond it
# is the drift. Steps are the motors' own, angles in rad, lengths in mm.

ROUNDING_STEPS = 1
"""Two counts of the same place may differ by a step: both are rounded."""

EYE_MM, EYE_STEPS = 0.5, 3
"""What nobody sees at the mark; more steps than that are no matter of the eye on any motor."""

GROSS_RAD = math.radians(10.0)
"""No arm that was driven with care loses so much between two looks at its mark."""

FROM_ELSEWHERE = (Evidence.DECLARED.value, Evidence.HOMED_BY_SWITCHES.value)
"""References that were not taken at the mark: lengths and steps a turn lie between."""

SHOWN_RAD = math.radians(0.005)


class Verdict(Enum):
    """What a difference means."""

    ROUNDING = "within rounding and what an eye sees: the position is right"
    DRIFT = "a drift: lost steps, or slack in cables and gears"
    CALIBRATION = "no lost steps: wrong numbers in the arm file, or tips that are not on the mark"


@dataclass(frozen=True, slots=True)
class Drift:
    """How far the registers are beyond what the posture reads in which the arm really stands.

    `turned` holds the differences of the joints, `opening_mm` that of the fingers, `tip_mm` how far
    apart the tip is said to be and is.
    """

    steps: Motors
    turned: Joints
    opening_mm: float
    tip_mm: float

    @property
    def largest_rad(self) -> float:
        """The angle of the joint that is furthest off."""
        return max(map(abs, self.turned))

    def words(self, transmission: Transmission) -> str:
        """Say how many steps each motor and how many degrees each joint is off."""
        motors = zip(transmission.motors, self.steps, strict=True)
        off = [f"{motor.name} {count:+d}" for motor, count in motors if count]
        angles = zip(self.turned.names, self.turned, strict=True)
        turned = [
            f"{name.replace('_', ' ')} {math.degrees(angle):+.2f}°"
            for name, angle in angles
            if abs(angle) > SHOWN_RAD
        ]
        return (
            f"steps: {', '.join(off) or 'none'}; joints: {', '.join(turned) or 'none'}; "
            f"{self.tip_mm:.1f} mm at the tip"
        )


def drift_between(model: ArmModel, position: Motors, truth: Motors) -> Drift:
    """Compare where the registers say that the motors are with where they are."""
    if model.transmission is None:
        raise ValueError("an arm without motors does not drift")
    said, said_mm = model.transmission.to_joints(position)
    true, true_mm = model.transmission.to_joints(truth)
    turned = Joints(tuple(a - b for a, b in zip(said, true, strict=True)), said.names)
    one, other = model.arm.fk(said), model.arm.fk(true)
    tip_mm = math.dist((one.x_mm, one.y_mm, one.z_mm), (other.x_mm, other.y_mm, other.z_mm))
    return Drift(position - truth, turned, said_mm - true_mm, tip_mm)


def judge(drift: Drift, reference: str) -> Verdict:
    """Say what a drift means, by its size and by the words of how the reference was taken.

    A reference that was taken at the mark itself reads the same there whatever lengths and gearing
    the arm file gives: only lost steps and slack are left to blame, unless it is beyond all reason.
    """
    unseen = drift.tip_mm <= EYE_MM and drift.steps.largest <= EYE_STEPS
    if unseen or drift.steps.largest <= ROUNDING_STEPS:
        return Verdict.ROUNDING
    if drift.largest_rad > GROSS_RAD or reference.startswith(FROM_ELSEWHERE):
        return Verdict.CALIBRATION
    return Verdict.DRIFT


@dataclass(frozen=True, slots=True)
class Verified:
    """What a verification found, and whether the present posture is the new reference."""

    verdict: Verdict
    drift: Drift
    accepted: bool
    found: str
    note: str = ""

    def __str__(self) -> str:
        parts = [self.verdict.value, self.found]
        if self.accepted:
            parts.append("this posture is the new reference")
        return "; ".join([*parts, *[self.note] * bool(self.note)])


def verified_view(verified: Verified) -> dict[str, Any]:
    """Return a verification as plain data, with units in the names."""
    drift = verified.drift
    return {
        "verdict": verified.verdict.name.lower(),
        "steps": list(drift.steps),
        "joints_deg": {name: round(angle, 4) for name, angle in drift.turned.deg.items()},
        "opening_mm": round(drift.opening_mm, 3),
        "tip_mm": round(drift.tip_mm, 3),
        "accepted": verified.accepted,
        "note": verified.note,
    }
