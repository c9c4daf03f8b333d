"""Gripping: closing in short bursts, with the grip switch read in between.

The controller's own closing command takes seconds and cannot be aborted; short bursts can be
stopped. The fingers close in coarse steps until the switch trips, open until it releases, and close
again in fine steps: the opening at which the switch trips gives the object's width. Beyond that
point, a known number of steps adds a known force.
"""

from __future__ import annotations

from dataclasses import dataclass

from armdrive.config.sections import OUTPUT
from armdrive.errors import BadRequest, DeviceFault, Refused
from armdrive.motion.context import MotionContext
from armdrive.motion.execute import Moved, drive_legs, in_motion, report
from armdrive.motion.plan import SpeedLimits, audit_opening
from armdrive.runtime.arm_state import Core
from armdrive.runtime.position import ArmCoordinates, MotionSegment
from armdrive.tasks import Done, SetGripper, SleepUntil, TaskBody

FINE_STEPS = 2  # of the closing that measures the object: 0.14 mm on a TeachMover


@dataclass(frozen=True, slots=True)
class Grasped:
    """The result of a grasp: the object's width in mm (0: no object), and the force in N."""

    width_mm: float
    force_n: float

    @property
    def holding(self) -> bool:
        """Whether an object is between the fingers."""
        return self.width_mm > NOTHING_MM


NOTHING_MM = 1.0  # if the switch trips at this opening or less, the fingers have met each other


def require_gripper(core: Core) -> None:
    """Raise `Refused` for an arm without a driven gripper."""
    if not core.transmission.has_gripper and not core.config.gripper.commanded:
        raise Refused(
            f"the {core.config.title} has no gripper motor: if the arm has one, add a motor with "
            "steps_per_mm to its arm file; for a servo or an output, set gripper.kind"
        )


def require_finger_motor(core: Core) -> None:
    """Raise `Refused` for an arm whose fingers are not driven by a stepper motor."""
    require_gripper(core)
    if not core.transmission.has_gripper:
        raise Refused(
            f"the gripper of the {core.config.title} has no stepper motor and cannot be jogged: "
            "call `gripper.open()` or `gripper.close()`"
        )


def check_opening(core: Core, opening_mm: float) -> None:
    """Raise `OutOfBounds` or `BadRequest` for an opening that a servo or an output cannot do."""
    audit_opening(core.config, opening_mm)
    low, high = core.config.model.gripper_range_mm
    if core.config.gripper.kind == OUTPUT and opening_mm not in (low, high):
        raise BadRequest(
            f"this gripper is switched by an output: it can only be open ({high:g} mm) or closed "
            f"({low:g} mm)"
        )


def set_gripper(context: MotionContext, opening_mm: float) -> TaskBody[Moved]:
    """Command a servo or an output, and wait as long as the fingers take to get there."""
    core = context.core
    check_opening(core, opening_mm)
    low, high = core.config.model.gripper_range_mm
    share = (opening_mm - low) / (high - low)
    before = core.fingers.share
    began_s, requests = context.now_s, context.engine.requests_sent
    with in_motion(context):
        core.fingers.share = None  # unknown until the command is acknowledged
        reply = yield from context.request(SetGripper(share))
        if not isinstance(reply, Done):
            raise DeviceFault(f"the controller did not take the gripper's command: {reply}")
        core.fingers.share = share
        way = 1.0 if before is None else abs(share - before)
        yield SleepUntil(context.now_s + way * (high - low) / core.config.model.gripper_speed_mm_s)
    return report(context, core.position.coordinates, began_s, requests)


def check_grasp(core: Core, force_n: float) -> float:
    """Return the gripper motor's steps per N of force.

    Raises `Refused` if the arm has no grip switch, and `BadRequest` for a force out of range.
    """
    require_gripper(core)
    if not core.controller.abilities.grip_switch:
        raise Refused(
            "this arm has no grip switch: call `gripper.close()` with a width instead; in a "
            "program file, use open_now WIDTH"
        )
    require_finger_motor(core)
    settings = core.config.gripper
    if not 0.0 <= force_n <= settings.max_force_n:
        raise BadRequest(
            f"the gripper presses with 0 to {settings.max_force_n:g} N, not {force_n:g}"
        )
    steps_per_n = core.config.model.grip_steps_per_n
    if steps_per_n is None:
        raise Refused(
            "the grip force of this arm is not known: call `gripper.close()` with a width"
        )
    return steps_per_n


def grasp(context: MotionContext, speeds: SpeedLimits, force_n: float) -> TaskBody[Grasped]:
    """Close until an object is gripped, and press with about `force_n`."""
    core, settings = context.core, context.core.config.gripper
    steps_per_n = check_grasp(core, force_n)
    coarse, per_mm = settings.approach_steps, core.fingers.steps_per_mm
    depth_mm = settings.trip_force_n * steps_per_n / per_mm  # of cable between touch and switch
    # Beyond these openings the switch is broken. Closing: the fingers have met at 0, and the cable
    # that trips the switch was pulled in, with two bursts to spare. Opening: more cable was let out
    # than the firmest grasp and the last coarse burst had pulled in.
    closed_mm = -depth_mm - 2.0 * coarse / per_mm
    firmest_mm = (settings.max_force_n * steps_per_n + coarse) / per_mm
    with in_motion(context):
        yield from context.look_before_motion()
        core.require_reference()
        yield from _slide_until_switch(context, speeds, -coarse, closed_mm)
        free_mm = core.position.coordinates.opening_mm + firmest_mm
        yield from _slide_until_switch(context, speeds, FINE_STEPS, free_mm)
        yield from _slide_until_switch(context, speeds, -FINE_STEPS, closed_mm)
        width_mm = max(core.position.coordinates.opening_mm + depth_mm, 0.0)
        core.fingers.touch_mm = width_mm = width_mm if width_mm > NOTHING_MM else 0.0
        extra_n = max(force_n - settings.trip_force_n, 0.0)
        yield from _slide(context, speeds, -round(extra_n * steps_per_n))
        yield from context.verify()
        _raise_if_stopped(context)
    return Grasped(width_mm, core.fingers.force_n(core.position.coordinates.opening_mm))


def _slide_until_switch(
    context: MotionContext, speeds: SpeedLimits, steps: int, furthest_mm: float
) -> TaskBody[None]:
    """Close in bursts until the switch trips, or open (`steps` above 0) until it releases.

    An opening beyond `furthest_mm` shows that the switch is broken.
    """
    core, closing = context.core, steps < 0
    while bool(core.readings.gripping) is not closing:
        _raise_if_stopped(context)
        if (core.position.coordinates.opening_mm - furthest_mm) * steps > 0.0:
            raise DeviceFault(_broken_switch_words(core, closing=closing))
        yield from _slide(context, speeds, steps)
        yield from context.verify(midway=True)


def _broken_switch_words(core: Core, *, closing: bool) -> str:
    key = f"{core.config.connection.dialect}.grip_bit"
    if closing:
        return (
            f"the gripper is closed and its switch did not trip: check {key} and "
            "gripper.trip_force_n in the arm file"
        )
    return (
        "the gripper is open and its switch did not release: look at the switch, and "
        f"check {key} in the arm file"
    )


def _slide(context: MotionContext, speeds: SpeedLimits, steps: int) -> TaskBody[None]:
    """Move the fingers by motor steps; positive opens."""
    if steps == 0:
        return
    core = context.core
    here = core.position.coordinates
    there = ArmCoordinates(here.joints, here.opening_mm + steps / core.fingers.steps_per_mm)
    leg = MotionSegment(here, there, speeds.duration_s(here, there, 1.0))
    yield from drive_legs(context, (leg,), core.config.motion.jog_burst_s)


def _raise_if_stopped(context: MotionContext) -> None:
    if context.stopping:
        raise context.stopped("the grasp was stopped; the fingers stay where they are")
