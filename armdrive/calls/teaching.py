"""Named points: those of the arm's file, and the goals that they are."""

from __future__ import annotations

from datetime import datetime
from functools import cached_property

from armdrive.calls.connected import Connected
from armdrive.errors import BadRequest
from armdrive.frames import BASE
from armdrive.goals import Goal, LineGoal, PoseGoal, PostureGoal
from armdrive.pointbook import Points, points_of
from armdrive.points import Point
from kinematics import Pose

Place = Pose | Point | str
"""A pose, a point, or the name of a point."""


class Teaching(Connected):
    """The calls that name places, and find them again."""

    @cached_property
    def points(self) -> Points:
        """The named points of this arm, a mapping over its file: `arm.points["pick"]`."""
        return points_of(self.config, self._here)

    def _here(self) -> Point:
        """Return where the arm stands, on whole steps; raises `NotReferenced`."""
        status = self.status
        self.core.require_reference()
        now = datetime.now().replace(microsecond=0)
        return Point(self.known(status.joints), status.gripper_mm, taught=now)

    def goal_of(self, place: Place, frame: str = BASE, *, line: bool = False) -> Goal:
        """Return the goal that a place is. Raises `UnknownPoint` and `BadRequest`."""
        if isinstance(place, Pose):
            return LineGoal(place, frame) if line else PoseGoal(place, frame)
        if frame != BASE:
            raise BadRequest("a point says its joints, which are the same in every frame")
        point = self.points[place] if isinstance(place, str) else place
        if point.joints.names != self.config.model.arm.joint_names:
            raise BadRequest(f"this is a point of an arm with {', '.join(point.joints.names)}")
        if line:
            return LineGoal(self.config.model.arm.fk(point.joints), posture=point.joints)
        return PostureGoal(point.joints)
