"""What a jog may move, how fast, on which terms: where an arm's state meets its jog's course."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.abilities import Abort
from armdrive.errors import BadRequest, NotReferenced, WrongState
from armdrive.flows.gripping import require_finger_motor
from armdrive.frames import axes_of
from armdrive.intents import BASE_FRAME, GRIPPER_AXIS, Jog, Space
from armdrive.jog_course import JogCourse, Terms, Wish
from armdrive.jog_scale import axis_names
from armdrive.planning import audit

if TYPE_CHECKING:
    from armdrive.core import Core
    from armdrive.intents import Hold
    from armdrive.legs import Leg, Speeds


def check_jog(core: Core, jog: Jog) -> None:
    """Raise for a jog that names no axis of this arm, or needs a position that is not known."""
    if core.tempo.paused:
        raise WrongState("the arm is paused and is not jogged: resume it first (`armdrive resume`)")
    known = axis_names(core.config, jog.space)
    for name, _ in jog.axes:
        if name not in known:
            raise BadRequest(
                f"no {jog.space.value} axis is called {name!r}; known are {', '.join(known)}"
            )
    if jog.amount(GRIPPER_AXIS):
        require_finger_motor(core)
    if jog.space is Space.CARTESIAN:
        core.require_geometry()
    if jog.frame != BASE_FRAME:
        axes_of(core.config, core.coordinates.joints, jog.frame)
    if jog.space is Space.CARTESIAN and not core.position_known:
        raise NotReferenced(
            "jogging in Cartesian space needs a known position, and this one is "
            f"{core.belief.trust.value}: {core.belief.reason}. Jog joint by joint, or reference "
            "the arm first (`armdrive home`)"
        )


def capped(core: Core, speed: float) -> float:
    """Return the speed, slowed where the position is not known."""
    return speed if core.position_known else min(speed, core.config.motion.unreferenced_speed)


def wish_of(core: Core, hold: Hold) -> Wish:
    """Return what somebody who holds a jog wants of the arm as it is now. Raises as `check_jog`."""
    check_jog(core, hold.jog)
    speed = capped(core, hold.speed) * core.tempo.override
    return Wish(hold.jog, speed, known=core.position_known)


def course_of(core: Core, speeds: Speeds) -> JogCourse:
    """Return the course of a jog that begins."""
    queued = bool(core.controller.abilities.queued_segments)
    terms = Terms(core.config.motion.jog_ramp_s, queued, runs_on_s(core))
    return JogCourse(core.config, speeds, terms)


def runs_on_s(core: Core) -> float:
    """Return how long the arm may run on while it stops, where it does not end by itself.

    A device without an abort ends each burst where it was audited to end.
    """
    if core.controller.abilities.abort is Abort.NONE:
        return 0.0
    return core.controller.stopping(core.config.motion.jog_burst_s).asked_motion_s


def require_audit(core: Core, *legs: Leg) -> None:
    """Raise `OutOfBounds` for legs that would pass a limit or a guard: nothing goes unaudited."""
    if core.position_known and legs:
        audit(core.config, [legs[0].start.joints, *(leg.end.joints for leg in legs)])
