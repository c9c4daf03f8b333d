"""Jogging: increments and holds, for programs (which wait) and for the desk (which never does)."""

from __future__ import annotations

from armdrive.arm.connected import StatusView
from armdrive.connect.parts import PATIENCE_S, Parts
from armdrive.errors import BadRequest, Refused, WrongState
from armdrive.motion.jog.session import Jogged, check_jog, jog_session
from armdrive.motion.plan import speed_fraction
from armdrive.moves import GRIPPER_AXIS, Angles, ContinuousJog, IncrementalJog, Jog
from armdrive.runtime.states import Event, after
from armdrive.status import State
from armdrive.tasks import Task
from kinematics.errors import finite, suggestion

OPTIONS = ("speed", "duration_s", "frame")
"""What a misspelt word may mean where axes are named."""

LONGEST_HOLD_S = 1.0
"""A held jog is renewed at least this often, or it ends."""

LONGEST_WAIT_S = 1.0
"""An increment that could not begin within this time is one that nobody expects any more."""


class Jogging:
    """The jogs of one arm: one session at a time takes up what is asked of it."""

    def __init__(self, parts: Parts, view: StatusView) -> None:
        self._parts = parts
        self._view = view
        self._session: Task[Jogged] | None = None

    def jog(self, jog: Jog, speed: float, duration_s: float | None) -> Jogged:
        """Jog by an increment, or for a time, and wait for the end."""
        core, pace = self._parts.core, self._parts.pace
        fraction = speed_fraction(speed)
        with pace.lock:
            check_jog(core, jog)
            if core.state is not State.HOMING:
                after(core.state, Event.MOVE)
            if duration_s is None:
                if core.nudges:
                    raise WrongState("an increment is waiting already: wait for its end")
                task = self._join_session()
                core.nudges.append(IncrementalJog(jog, fraction))
            else:
                if not finite("duration_s", duration_s) > 0.0:
                    raise BadRequest(f"duration_s must be above 0, not {duration_s!r}")
                hold = ContinuousJog(jog, fraction, pace.now_s() + duration_s)
                task = self._join_session()
                core.hold = hold
                core.holds += 1
        return self._parts.runner.finish(task, (duration_s or 0.0) + PATIENCE_S * 10)

    def hold(self, jog: Jog, speed: float, for_s: float) -> None:
        """Jog for a time and no longer unless called again; never waits."""
        core, pace = self._parts.core, self._parts.pace
        with pace.lock:
            until_s = pace.now_s() + min(for_s, LONGEST_HOLD_S)
            hold = ContinuousJog(jog, speed_fraction(speed), until_s)
            if self._may_jog(jog):
                core.hold = hold
                core.holds += 1
        pace.wake()

    def nudge(self, jog: Jog, speed: float) -> None:
        """Jog by one increment, unless one is waiting already; never waits."""
        core, pace = self._parts.core, self._parts.pace
        with pace.lock:
            nudge = IncrementalJog(jog, speed_fraction(speed), pace.now_s() + LONGEST_WAIT_S)
            if not core.nudges and self._may_jog(jog):
                core.nudges.append(nudge)
        pace.wake()

    def release(self) -> None:
        """End a held jog."""
        self._parts.core.hold = None
        self._parts.pace.wake()

    def _may_jog(self, jog: Jog) -> bool:
        """Have a session ready to take up a jog; where that is refused, say so in the notice."""
        core = self._parts.core
        alive = self._session is not None and not self._session.done
        try:
            check_jog(core, jog)
            if not alive and core.state is not State.HOMING:
                after(core.state, Event.MOVE)
            self._join_session()
        except Refused as refusal:
            core.diagnostics.notify(str(refusal), refusal)
            return False
        return True

    def _join_session(self) -> Task[Jogged]:
        """Return the jogging under way, which takes up what was just asked, or begin one."""
        if self._session is None or self._session.done:
            body = jog_session(self._parts.wire, self._view.speeds)
            self._session = self._parts.runner.submit(body, alone=True)
        return self._session


def jog_axes(words: Angles, *, in_steps: bool) -> tuple[tuple[str, float], ...]:
    """Return the axes that keywords such as `shoulder_deg=2` or `x_mm=5` name.

    Directions, which are not `in_steps`, have no unit. Raises `BadRequest`.
    """
    return tuple((_axis(word, in_steps), value) for word, value in words.items())


def _axis(word: str, in_steps: bool) -> str:
    if not in_steps:
        return word
    for unit in ("_deg", "_mm"):
        axis = word.removesuffix(unit)
        if axis != word and (unit == "_mm") == (axis in ("x", "y", "z", GRIPPER_AXIS)):
            return axis
    raise BadRequest(
        f"{word!r} names no increment: write for example shoulder_deg=2, x_mm=5 or gripper_mm=3, "
        f"or give duration_s= with directions such as shoulder=1{suggestion(word, OPTIONS)}"
    )
