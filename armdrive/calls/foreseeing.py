"""Seeing a motion before it is asked for: the very plan that would be carried out, measured."""

from __future__ import annotations

from armdrive.calls.moving import Moving
from armdrive.calls.teaching import Place
from armdrive.errors import BadRequest, Refused
from armdrive.frames import BASE
from armdrive.goals import Goal, Ground, JointGoal
from armdrive.planning import speed_fraction
from armdrive.preview import Preview, Refusal, preview_goal
from armdrive.states import Event, after
from armdrive.status import Trust


class Foreseeing(Moving):
    """The call that plans and does not move."""

    def preview(
        self,
        goal: Place | None = None,
        *,
        line: bool = False,
        frame: str = BASE,
        speed: float = 1.0,
        **joints_deg: float,
    ) -> Preview:
        """Return what a motion would be, or why it is refused. Sends nothing, moves nothing.

        `preview(pose)` (or a named point) foresees `move_to`, `preview(pose, line=True)` foresees
        `move_l`, and `preview(shoulder_deg=40)` foresees `move_j`. A refusal is part of the answer:
        its typed error, and where the arm could go instead. Raises `BadRequest` for what is no
        goal.
        """
        fraction = speed_fraction(speed)
        if goal is None:
            if line or frame != BASE:
                raise BadRequest("a line and a frame are of a pose: give one")
            return self._foreseen(JointGoal(joints_deg), fraction)
        if joints_deg:
            raise BadRequest("give a pose or joint angles, not both")
        return self._foreseen(self.goal_of(goal, frame, line=line), fraction)

    def _foreseen(self, goal: Goal, fraction: float) -> Preview:
        with self.pace.lock:
            here, controller = self.core.coordinates, self.core.controller
            hindrance, known = self._hindrance(goal), self.core.belief.trust is not Trust.UNKNOWN
        if not known:
            return Preview(None, hindrance)
        ground = Ground(self.config, self.speeds, here)
        return preview_goal(ground, controller, goal, fraction, hindrance)

    def _hindrance(self, goal: Goal) -> Refusal | None:
        """Return why no motion to such a goal may begin now, whatever its way."""
        try:
            if goal.cartesian:
                self.core.require_geometry()
            self.core.require_reference()
            after(self.core.state, Event.MOVE)
            self.core.require_settings()
        except Refused as refusal:
            return refusal
        return None
