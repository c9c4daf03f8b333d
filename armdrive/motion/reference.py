"""How an arm gets its reference: from its home switches, or from its operator.

Referencing sets an offset to the controller's registers. Verification measures how far the position
has drifted.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import HomingSettings
from armdrive.errors import ArmError, DeviceFault, NotReferenced
from armdrive.motion.context import (
    MotionContext,
    be_remembered,
    leave_standstill,
    weigh_difference,
)
from armdrive.runtime.arm_state import Core
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.states import Belief, Event
from armdrive.status import Current, Evidence, State, Trust
from armdrive.tasks import (
    Done,
    Halted,
    HomeDevice,
    TaskBody,
)
from kinematics.spaces import Joints, Motors
from kinematics.text import shown_name
from kinematics.transmission import Transmission

STOPPED_BEFORE = "homing was stopped before it began"


def begin_home(context: MotionContext) -> TaskBody[None]:
    """Enter the state HOMING, in which the operator brings the arm to its reference posture."""
    if context.stopping:  # while another task ran
        raise context.stopped(STOPPED_BEFORE)
    context.core.happen(Event.HOME)
    yield from ()


def home_device(
    context: MotionContext, homing: HomingSettings, report: Callable[[int], None] = lambda _: None
) -> TaskBody[None]:
    """Home the device to its switches, in the order of the arm file.

    `report` is called with the index of each group of the arm file when it has been homed.
    """
    core = context.core
    core.require_settings(homing=True)
    if not (yield from leave_standstill(context)):
        raise context.stopped(STOPPED_BEFORE)
    core.happen(Event.HOME)
    core.readings.current = Current.HELD
    try:
        for index, request in enumerate(homing.requests()):
            yield from _home_group(context, request)
            if homing.groups:
                report(index)
    except ArmError:
        core.position.believe_registers()  # it has left its posture: show where it was seen last
        raise
    registers = yield from context.ask_registers()
    _require_no_fault(context)
    core.position.slack.doubt()  # the direction in which it left its switches is not known
    core.position.refer(registers.positions, ArmCoordinates(homing.joints, homing.opening_mm))
    core.learn(Evidence.HOMED_BY_SWITCHES, context.now_s)
    core.clear_messages()
    core.still_since_s = context.now_s
    yield from _settled(context)


def _settled(context: MotionContext) -> TaskBody[None]:
    """End the motion and wait until the position is on the disk."""
    context.core.settle()
    context.core.mark_still()
    yield from be_remembered(context)


def _home_group(context: MotionContext, request: HomeDevice) -> TaskBody[None]:
    """Home some of the motors; if homing ends early, nothing is referenced."""
    core, began_s = context.core, context.now_s
    lasts = core.controller.search(request).lasts
    core.stops.home(request)
    reply = yield from context.driven(request)
    core.stops.end()
    if isinstance(reply, Done) and not context.stopping:
        _require_no_fault(context)
        return
    core.learn(Evidence.HOMING_FAILED, context.now_s)
    if context.stopping:
        raise context.stopped("homing was stopped: nothing was referenced")
    late = f"it had not ended after {context.now_s - began_s:.0f} s{lasts.remedy}"
    why = late if isinstance(reply, Halted) else reply  # without a stop, a halt is a timeout
    words = f"homing failed: {why}. Look at the switches and the arm, then call `reset()`"
    raise context.fault(DeviceFault(words))


def _require_no_fault(context: MotionContext) -> None:
    """Raise what the device has reported meanwhile: the next group must not move."""
    if context.core.state is State.ERROR_STOP:
        context.core.learn(Evidence.HOMING_FAILED, context.now_s)
        context.require_no_fault()


def confirm_record(context: MotionContext) -> TaskBody[None]:
    """Turn a restored position into a referenced one: the operator has compared it with the arm."""
    core = context.core
    yield from context.look()
    trust = core.belief.trust
    if trust is not Trust.RESTORED:
        todo = f": {core.belief.reason}. To fix this, call `home()`"
        raise NotReferenced(
            f"there is no restored position to confirm; the position is {trust.value}"
            f"{'' if trust is Trust.REFERENCED else todo}"
        )
    core.learn(Evidence.CONFIRMED, context.now_s)
    core.mark_still()
    yield from be_remembered(context)


# Manual reference: the operator confirms a posture. It is refused if the arm has changed since.
#
# Nothing here moves the arm, and the controller is never asked to zero its registers, because some
# controllers drop the motor current when they do.

PROMPT_S = 0.3  # registers read this soon after the confirmation show the confirmed posture


@dataclass(frozen=True, slots=True)
class ConfirmedPosture:
    """A posture that the operator confirms, with the state of the arm at that moment."""

    there: ArmCoordinates
    evidence: Evidence
    belief: Belief
    registers: Motors
    at_s: float


def confirmed_posture(
    core: Core, there: ArmCoordinates, evidence: Evidence, now_s: float
) -> ConfirmedPosture:
    """Return the operator's confirmation of a posture at this moment."""
    return ConfirmedPosture(there, evidence, core.belief, core.position.expected, now_s)


def take_reference(context: MotionContext, confirmed: ConfirmedPosture) -> TaskBody[None]:
    """Set the reference: the present registers stand for the confirmed posture.

    Raises `DeviceFault` if the arm may have changed since the confirmation: its position has become
    suspect, its registers are zero (the controller restarted, and the arm may have sagged), or they
    have changed and could not be read promptly. A change that is read promptly is fine: it happened
    before the operator looked, when the arm was brought into the posture.
    """
    core = context.core
    difference = yield from context.read()
    context.require_no_fault()
    if context.stopping or core.state not in (State.STANDBY, State.HOMING):
        raise context.stopped("a stop interrupted this: nothing was referenced")
    registers = core.position.counts
    changed = registers != confirmed.registers
    late = context.now_s > confirmed.at_s + PROMPT_S
    doubted = core.belief is not confirmed.belief and core.belief.trust is Trust.SUSPECT
    if doubted or (changed and (late or not registers.largest)):
        weigh_difference(context, difference)
        why = core.belief.reason if doubted or not registers.largest else _MOVED
        raise DeviceFault(
            f"the arm was not referenced, because it may have changed a moment ago: {why}. Look at "
            "the arm, and confirm its posture again"
        )
    core.position.refer(registers, confirmed.there)
    core.learn(confirmed.evidence, context.now_s)
    core.clear_messages()
    yield from _settled(context)


_MOVED = "the line was noisy, and the registers changed meanwhile"


# Verification: measuring an arm at its reference mark, where the operator has brought it.


def read_at_mark(context: MotionContext) -> TaskBody[Motors]:
    """Return the position that the registers show, while the operator is at work."""
    core = context.core
    yield from context.read()
    _require_homing(context)
    return core.position.read_back or core.position.acknowledged


def believe_mark(context: MotionContext) -> TaskBody[None]:
    """Confirm a restored position: the mark has shown that it is right."""
    core = context.core
    _require_homing(context)
    if core.belief.trust is Trust.RESTORED:
        core.learn(Evidence.CONFIRMED, context.now_s)
    yield from _settled(context)


def doubt_position(context: MotionContext, detail: str) -> TaskBody[None]:
    """Make the position suspect: it is off, and the operator does not want a new reference."""
    core = context.core
    _require_homing(context)
    core.learn(Evidence.OFF_ITS_MARK, context.now_s, detail)
    yield from _settled(context)


def _require_homing(context: MotionContext) -> None:
    context.require_no_fault()
    if context.stopping or context.core.state is not State.HOMING:
        raise context.stopped("a stop interrupted this: nothing was changed")


# Drift: the difference between the position and the truth, measured at the reference mark.
#
# An arm without encoders only counts steps. When the operator has brought the fingertips onto the
# mark, the registers should show the reference posture; their difference is the drift. Steps are
# those of the motors, angles in rad, lengths in mm.

ROUNDING_STEPS = 1  # two readings of the same place may differ by a step, because both are rounded

# The smallest misalignment visible at the mark. A motor that is off by more steps is noticed by
# its count, however little the tip moves.
EYE_MM, EYE_STEPS = 0.5, 3

GROSS_RAD = math.radians(10.0)  # more than an arm loses between two verifications in normal use

# References taken away from the mark, so that errors of lengths and gear ratios show there.
FROM_ELSEWHERE = (Evidence.DECLARED.value, Evidence.HOMED_BY_SWITCHES.value)

SHOWN_RAD = math.radians(0.005)


class Verdict(Enum):
    """The meaning of a difference."""

    ROUNDING = "within rounding and visual accuracy: the position is right"
    DRIFT = "drift: lost steps, or slack in cables and gears"
    CALIBRATION = "no lost steps: wrong values in the arm file, or fingertips off the mark"


@dataclass(frozen=True, slots=True)
class Drift:
    """The position minus the true position: in steps, joint angles, opening and tip distance."""

    steps: Motors
    turned: Joints
    opening_mm: float
    tip_mm: float

    @property
    def largest_rad(self) -> float:
        """The largest joint error."""
        return max(map(abs, self.turned))

    def words(self, transmission: Transmission) -> str:
        """Return the errors of motors in steps, joints in degrees, and the tip in mm."""
        motors = zip(transmission.motors, self.steps, strict=True)
        off = [f"{motor.name} {count:+d}" for motor, count in motors if count]
        angles = zip(self.turned.names, self.turned, strict=True)
        turned = [
            f"{shown_name(name)} {math.degrees(angle):+.2f}°"
            for name, angle in angles
            if abs(angle) > SHOWN_RAD
        ]
        return (
            f"steps: {', '.join(off) or 'none'}; joints: {', '.join(turned) or 'none'}; "
            f"{self.tip_mm:.1f} mm at the tip"
        )


def drift_between(config: ArmConfig, position: Motors, truth: Motors) -> Drift:
    """Return the difference between a position and the true one."""
    shown, shown_mm = config.transmission.to_joints(position)
    true, true_mm = config.transmission.to_joints(truth)
    turned = Joints(tuple(a - b for a, b in zip(shown, true, strict=True)), shown.names)
    arm = config.model.arm
    one, other = arm.fk(shown), arm.fk(true)
    tip_mm = math.dist((one.x_mm, one.y_mm, one.z_mm), (other.x_mm, other.y_mm, other.z_mm))
    return Drift(position - truth, turned, shown_mm - true_mm, tip_mm)


def judge(drift: Drift, reference: str) -> Verdict:
    """Return the verdict on a drift, given its size and how the reference was taken.

    If the reference was taken at the mark itself, wrong lengths and gear ratios in the arm file do
    not show there. That leaves lost steps and slack, unless the drift is implausibly large.
    """
    unseen = drift.tip_mm <= EYE_MM and drift.steps.largest <= EYE_STEPS
    if unseen or drift.steps.largest <= ROUNDING_STEPS:
        return Verdict.ROUNDING
    if drift.largest_rad > GROSS_RAD or reference.startswith(FROM_ELSEWHERE):
        return Verdict.CALIBRATION
    return Verdict.DRIFT


@dataclass(frozen=True, slots=True)
class Verified:
    """The result of a verification, and whether the present posture is the new reference."""

    verdict: Verdict
    drift: Drift
    accepted: bool
    found: str

    def __str__(self) -> str:
        parts = [self.verdict.value, self.found]
        if self.accepted:
            parts.append("this posture is the new reference")
        return "; ".join(parts)


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
    }
