"""Jogging: increments and holds, for programs (which wait) and for the desk (which never does)."""

from __future__ import annotations

from typing import Unpack

from armdrive.arm.connected import Connected
from armdrive.connect.parts import PATIENCE_S
from armdrive.errors import BadRequest, Refused, WrongState
from armdrive.motion.jog.session import Jogged, check_jog, jog_session
from armdrive.motion.plan import speed_fraction
from armdrive.moves import (
    BASE_FRAME,
    GRIPPER_AXIS,
    Angles,
    ContinuousJog,
    IncrementalJog,
    Jog,
    JointJog,
    Space,
    TipJog,
    by_name,
)
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


class JogCalls(Connected):
    """The calls that jog."""

    _session: Task[Jogged] | None = None

    def jog_j(
        self,
        amounts: Angles | None = None,
        /,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        **axes: Unpack[JointJog],
    ) -> Jogged:
        """Jog joints: by increments, `shoulder_deg=2, gripper_mm=5`, or for a time.

        With `duration_s` the axes are directions from -1 to 1, `shoulder=1`, that share the
        speed. Limits are met by stopping at them; `note` of the result says so. Allowed without
        a reference, then slow and without limits. Joints that a model file names otherwise are
        given in a mapping, `{"turret_deg": 2}`.
        """
        named = _axes(by_name(amounts, axes), in_steps=duration_s is None)
        return self._jog(Jog(Space.JOINT, named), speed, duration_s)

    def jog_l(
        self,
        amounts: Angles | None = None,
        /,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        frame: str = BASE_FRAME,
        **axes: Unpack[TipJog],
    ) -> Jogged:
        """Jog the tip: by increments, `x_mm=5, pitch_deg=-2`, or for a time, `x=1`.

        x, y and z are those of the `frame`: "base", "tool", which goes with the hand, or a frame
        of the arm file. `jog_l(frame="tool", z=1, duration_s=1)` goes where the hand points.
        """
        named = _axes(by_name(amounts, axes), in_steps=duration_s is None)
        return self._jog(Jog(Space.CARTESIAN, named, frame), speed, duration_s)

    def hold(self, jog: Jog, *, speed: float, for_s: float) -> None:
        """Jog for `for_s` seconds and no longer unless called again; never waits.

        A refusal is the `notice` of the status.
        """
        with self.pace.lock:
            until_s = self.pace.now_s() + min(for_s, LONGEST_HOLD_S)
            hold = ContinuousJog(jog, speed_fraction(speed), until_s)
            if self._may_jog(jog):
                self.core.hold = hold
                self.core.holds += 1
        self.pace.wake()

    def nudge(self, jog: Jog, *, speed: float) -> None:
        """Jog by one increment; at most one more waits behind the one under way. Never waits.

        One that has not begun within a second is dropped.
        """
        with self.pace.lock:
            nudge = IncrementalJog(jog, speed_fraction(speed), self.pace.now_s() + LONGEST_WAIT_S)
            if not self.core.nudges and self._may_jog(jog):
                self.core.nudges.append(nudge)
        self.pace.wake()

    def release(self) -> None:
        """End a held jog: what is queued is given up; a burst under way is the last."""
        self.core.hold = None
        self.pace.wake()

    def _jog(self, jog: Jog, speed: float, duration_s: float | None) -> Jogged:
        fraction = speed_fraction(speed)
        with self.pace.lock:
            check_jog(self.core, jog)
            if self.core.state is not State.HOMING:
                after(self.core.state, Event.MOVE)
            if duration_s is None:
                if self.core.nudges:
                    raise WrongState("an increment is waiting already: wait for its end")
                task = self._join_session()
                self.core.nudges.append(IncrementalJog(jog, fraction))
            else:
                if not finite("duration_s", duration_s) > 0.0:
                    raise BadRequest(f"duration_s must be above 0, not {duration_s!r}")
                hold = ContinuousJog(jog, fraction, self.pace.now_s() + duration_s)
                task = self._join_session()
                self.core.hold = hold
                self.core.holds += 1
        return self.finish(task, (duration_s or 0.0) + PATIENCE_S * 10)

    def _may_jog(self, jog: Jog) -> bool:
        """Have a session ready to take up a jog; where that is refused, say so in the notice."""
        alive = self._session is not None and not self._session.done
        try:
            check_jog(self.core, jog)
            if not alive and self.core.state is not State.HOMING:
                after(self.core.state, Event.MOVE)
            self._join_session()
        except Refused as refusal:
            self.core.notify(str(refusal), refusal)
            return False
        return True

    def _join_session(self) -> Task[Jogged]:
        """Return the jogging under way, which takes up what was just asked, or begin one."""
        if self._session is None or self._session.done:
            self._session = self.submit(jog_session(self.wire, self.speeds), alone=True)
        return self._session


def _axes(words: Angles, *, in_steps: bool) -> tuple[tuple[str, float], ...]:
    return tuple((_axis(word, in_steps), value) for word, value in words.items())


def _axis(word: str, in_steps: bool) -> str:
    """Turn `shoulder_deg` or `x_mm` into the axis it names; directions have no unit."""
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
