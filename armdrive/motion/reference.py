"""How an arm gets its position: from its record, its own switches or a person; how far it is off.

A reference is the controller's registers plus an offset that is kept here.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any

from armdrive.abilities import Switching
from armdrive.config.sections import HomingSettings
from armdrive.errors import DeviceFault, LinkLost, NoAnswer, NotReferenced, StateFileError
from armdrive.motion.context import (
    MotionContext,
    be_remembered,
    leave_standstill,
    weigh_difference,
    without_reset,
)
from armdrive.motion.device import compare_again, compare_settings
from armdrive.runtime.arm_state import Core
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.states import Belief, Event, after
from armdrive.status import Current, Evidence, State, Trust
from armdrive.tasks import (
    ClearFault,
    Done,
    DropCurrent,
    Halted,
    HomeDevice,
    Registers,
    SwitchOn,
    TaskBody,
)
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Motors
from kinematics.transmission import Transmission


def connect(wire: MotionContext) -> TaskBody[None]:
    """Find the controller, take up its record, and end in stand-still. Moves nothing."""
    try:
        yield from _connect(wire)
    except NoAnswer as error:  # there is no arm yet that could be reset
        raise NoAnswer(f"{without_reset(error)}, then connect again") from None


def _connect(wire: MotionContext) -> TaskBody[None]:
    core = wire.core
    registers = yield from wire.ask_registers()
    switched = core.controller.abilities.current is Switching.BOTH
    core.happen(Event.OPENED_SWITCHED if switched else Event.OPENED_HELD)
    _take_up_record(wire, registers)
    _heed_what_came_before(wire)
    yield from compare_settings(wire)
    core.memory.taken_up()  # from here on: a connection that failed leaves the record as it was
    if core.belief.trust is Trust.SUSPECT:
        core.remember()  # else registers that come back by chance would be believed once more
    core.still_since_s = wire.now_s


def _take_up_record(wire: MotionContext, registers: Registers) -> None:
    core = wire.core
    core.position.found(registers)
    try:
        record = core.memory.load(
            core.config.name, core.config.calibration, len(registers.positions)
        )
    except StateFileError as error:
        core.learn(Evidence.RECORD_UNUSABLE, wire.now_s, str(error))
        return
    if record is None or record.trust == Trust.UNKNOWN.value:
        core.learn(Evidence.NO_RECORD, wire.now_s)
    else:
        same = core.position.restore(record, registers.positions)
        core.learn(Evidence.RECORD_MATCHES, wire.now_s)
        if record.trust == Trust.SUSPECT.value:
            core.belief = Belief(Trust.SUSPECT, record.reason, wire.now_s)
        if not same:
            core.learn(Evidence.RECORD_DIFFERS, wire.now_s)
        elif record.in_motion:
            core.learn(Evidence.ENDED_IN_MOTION, wire.now_s)


def _heed_what_came_before(wire: MotionContext) -> None:
    """Weigh an alert that came before there was a record to be doubted: it speaks against it."""
    core = wire.core
    if core.early_evidence is not None:
        evidence, words = core.early_evidence
        core.learn(evidence, wire.now_s, words)
        core.diagnostics.error = ""  # nothing is latched by connecting
        core.diagnostics.notify(f"{evidence.value} ({words})", evidence)


def begin_home(wire: MotionContext) -> TaskBody[None]:
    """Enter the state in which an operator brings the arm to its posture."""
    wire.core.happen(Event.HOME)
    yield from ()


def home_device(
    wire: MotionContext, homing: HomingSettings, told: Callable[[int], None] = lambda _: None
) -> TaskBody[None]:
    """Have the device find its switches, in the arm file's order; it stands at them afterwards.

    `told` hears of each group of the arm file, by its index, when it has been homed.
    """
    core = wire.core
    core.require_settings()
    if not (yield from leave_standstill(wire)):
        raise wire.stopped("homing was stopped before it began")
    core.happen(Event.HOME)
    core.readings.current = Current.HELD
    groups = tuple(tuple(motor - 1 for motor in group) for group in homing.groups)
    try:
        for index, group in enumerate(groups):
            yield from _home_group(wire, HomeDevice((group,)))
            told(index)
        if not groups:
            yield from _home_group(wire, HomeDevice())
    except LinkLost:
        core.learn(Evidence.LOST_IN_MOTION, wire.now_s)
        raise
    registers = yield from wire.ask_registers()
    core.position.slack.doubt()  # the device does not tell which way it came off its switches
    core.position.refer(registers.positions, ArmCoordinates(homing.joints, homing.opening_mm))
    core.learn(Evidence.HOMED_BY_SWITCHES, wire.now_s)
    core.clear_diagnostics()
    core.still_since_s = wire.now_s
    yield from _settled(wire)


def _settled(wire: MotionContext) -> TaskBody[None]:
    """Stand with what is believed by now, and wait until that is on the disk."""
    wire.core.settle()
    wire.core.mark_still()
    yield from be_remembered(wire)


def _home_group(wire: MotionContext, request: HomeDevice) -> TaskBody[None]:
    """Have some of the motors homed; whatever ends it early leaves nothing referenced."""
    core, began_s = wire.core, wire.now_s
    reply = yield from wire.request(request, Evidence.ANSWER_LOST)
    if isinstance(reply, Done) and not wire.stopping:
        return
    core.learn(Evidence.HOMING_FAILED, wire.now_s)
    if wire.stopping:
        raise wire.stopped("homing was stopped: nothing was referenced")
    late = f"it had not ended after {wire.now_s - began_s:.0f} s, {wire.engine.received}"
    why = late if isinstance(reply, Halted) else reply  # nobody stopped it: its time was over
    words = f"homing failed: {why}. Look at the switches and the arm, then call `reset()`"
    raise wire.fault(DeviceFault(words))


def confirm_record(wire: MotionContext) -> TaskBody[None]:
    """Let a restored position count as referenced: the operator compared it with the arm."""
    core = wire.core
    yield from wire.look()
    if core.belief.trust is not Trust.RESTORED:
        raise NotReferenced(
            f"there is no restored position to confirm, this one is {core.belief.trust.value}: "
            f"{core.belief.reason}. To fix this, call `home()`"
        )
    core.learn(Evidence.CONFIRMED, wire.now_s)
    core.mark_still()
    yield from be_remembered(wire)


def disable(wire: MotionContext) -> TaskBody[None]:
    """Drop the motor current: the arm can sag, so its position is suspect from then on."""
    core = wire.core
    after(core.state, Event.DISABLE)
    core.learn(Evidence.CURRENT_DROPPED, wire.now_s)  # whatever the answer will be
    yield from be_remembered(wire)  # no mark: a full disk does not keep the motors on
    core.happen(Event.DISABLE)
    core.readings.current = Current.UNKNOWN
    reply = yield from wire.request(DropCurrent())
    if not isinstance(reply, Done):
        words = "the controller did not say that it switched the motor current off: look at it"
        raise wire.fault(DeviceFault(words))
    core.readings.current = Current.OFF
    registers = yield from wire.ask_registers()
    core.position.rebase(registers.positions)  # they may have been zeroed, which moves nothing
    core.readings.sense(registers)
    core.mark_still()
    yield from be_remembered(wire)


def enable(wire: MotionContext) -> TaskBody[None]:
    """Switch the motor current on where that can be done, and allow motion. Moves nothing."""
    core = wire.core
    after(core.state, Event.ENABLE)
    able = core.controller.abilities.current
    if able is Switching.BOTH or (able is Switching.DROPS and core.readings.current is Current.OFF):
        reply = yield from wire.request(SwitchOn())
        if not isinstance(reply, Done):
            words = f"the controller did not switch the motors on: {reply}"
            raise wire.fault(DeviceFault(words))
        wire.require_no_fault()  # it may have let the arm sag before it understood
        if able is Switching.BOTH:
            core.readings.current = Current.HELD
    yield from compare_again(wire)
    core.happen(Event.ENABLE)


def reset(wire: MotionContext) -> TaskBody[None]:
    """Leave error-stop: listen until the line is quiet, and take up what the registers say.

    A device that may have switched its motors off is disabled then: `enable` is a call of its own.
    """
    core = wire.core
    yield from wire.quiet()
    reply = yield from wire.request(ClearFault())
    if not isinstance(reply, Done):
        raise DeviceFault(f"the controller stays in its fault: {reply}")
    registers = yield from wire.ask_registers()
    if wire.stopping:
        raise wire.stopped("a stop came during the reset: call `reset()` again")
    core.diagnostics.error = core.diagnostics.notice = ""
    weigh_difference(wire, core.position.compare(registers))
    yield from compare_again(wire)
    switched = core.controller.abilities.current is Switching.BOTH
    off = switched and core.readings.current is not Current.HELD
    core.happen(Event.RESET_SWITCHED if off else Event.RESET)
    core.still_since_s = wire.now_s


def poll(wire: MotionContext) -> TaskBody[None]:
    """Look at a standing arm: inputs, and whether its registers are still what they were."""
    yield from wire.look()


# Taking a reference from somebody who looks at the arm, unless it has changed since he looked.
#
# Nothing below moves the arm, and nothing asks the controller to zero its registers, which would
# drop its motor current.

PROMPT_S = 0.3
"""Registers that are read this soon show the arm as it was vouched for."""


@dataclass(frozen=True, slots=True)
class Vouched:
    """A posture that somebody vouches for, and what was known of the arm when he did."""

    there: ArmCoordinates
    evidence: Evidence
    belief: Belief
    registers: Motors
    at_s: float


def vouched(core: Core, there: ArmCoordinates, evidence: Evidence, now_s: float) -> Vouched:
    """Note that somebody vouches for a posture now."""
    return Vouched(there, evidence, core.belief, core.position.expected, now_s)


def take_reference(wire: MotionContext, word: Vouched) -> TaskBody[None]:
    """Let the present registers mean a posture that somebody vouches for.

    Raises `DeviceFault` where the arm may have changed since: there is worse news of it, or the
    registers have fallen to zero (the controller was restarted, and the arm may have sagged), or
    they have changed and could not be read at once. Registers that were read at once may have
    changed before he looked: somebody has just brought the arm there.
    """
    core = wire.core
    difference = yield from wire.read()
    if wire.stopping or core.state not in (State.STANDBY, State.HOMING):
        raise wire.stopped("a stop came between: nothing was referenced")
    registers = core.position.counts
    changed = registers != word.registers
    late = wire.now_s > word.at_s + PROMPT_S
    doubted = core.belief is not word.belief and core.belief.trust is Trust.SUSPECT
    if doubted or (changed and (late or not registers.largest)):
        weigh_difference(wire, difference)
        why = core.belief.reason if doubted or not registers.largest else _MOVED
        raise DeviceFault(
            f"nothing was referenced, because of what was seen a moment ago: {why}. Look at the "
            "arm, and vouch for its posture again"
        )
    core.position.refer(registers, word.there)
    core.learn(word.evidence, wire.now_s)
    core.clear_diagnostics()
    yield from _settled(wire)


_MOVED = "the wire was disturbed, and the registers have changed meanwhile"


# Measuring an arm at its mark: nothing here moves it, its operator has brought it there.


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
    yield from _settled(wire)


def doubt_position(wire: MotionContext, detail: str) -> TaskBody[None]:
    """Say that the position is off, where nobody wants to take the mark for the new reference."""
    core = wire.core
    _require_homing(wire)
    core.learn(Evidence.OFF_ITS_MARK, wire.now_s, detail)
    yield from _settled(wire)


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
