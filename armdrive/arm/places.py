"""Named points: those of the arm's file, and the goals that they are."""

from __future__ import annotations

from datetime import datetime

from armdrive.arm.connected import StatusView
from armdrive.connect.parts import Parts
from armdrive.errors import BadRequest
from armdrive.motion.resolve import BASE, LineGoal, PoseGoal, PostureGoal, ResolvedGoal
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point
from kinematics.spaces import Pose

Place = Pose | Point | str
"""A pose, a point, or the name of a point."""


class Places:
    """The places of one arm that have a name."""

    def __init__(self, parts: Parts, view: StatusView) -> None:
        self._core = parts.core
        self._view = view
        self._arm = parts.config.model.arm
        self.points = points_of(parts.config.name, self._arm, self._here)

    def _here(self) -> Point:
        """Return where the arm stands, on whole steps; raises `NotReferenced`."""
        status = self._view.status
        self._core.require_reference()
        now = datetime.now().replace(microsecond=0)
        return Point(self._view.known(status.joints), status.gripper_mm, taught=now)

    def goal(self, place: Place, frame: str = BASE, *, line: bool = False) -> ResolvedGoal:
        """Return the goal that a place is. Raises `UnknownPoint` and `BadRequest`."""
        if isinstance(place, Pose):
            return LineGoal(place, frame) if line else PoseGoal(place, frame)
        if frame != BASE:
            raise BadRequest("a point says its joints, which are the same in every frame")
        point = self.points[place] if isinstance(place, str) else place
        if point.joints.names != self._arm.joint_names:
            raise BadRequest(f"this is a point of an arm with {', '.join(point.joints.names)}")
        if line:
            return LineGoal(self._arm.fk(point.joints), posture=point.joints)
        return PostureGoal(point.joints)
