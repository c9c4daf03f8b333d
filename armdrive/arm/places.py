"""Named points: those of the arm's file, and the moves to them."""

from __future__ import annotations

from datetime import datetime

from armdrive.arm.connected import StatusView
from armdrive.connect.parts import Parts
from armdrive.errors import BadRequest
from armdrive.motion.resolve import SAME_IN_EVERY_FRAME
from armdrive.moves import BASE_FRAME, JointMove, LineMove, Motion, PoseMove
from armdrive.storage.point_file import points_of
from armdrive.storage.points import Point
from kinematics.spaces import Joints, Pose

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

    def joints(self, name: str) -> Joints:
        """Return the joint angles of a named point. Raises `UnknownPoint`."""
        return self.points[name].joints


def move_to_place(place: Place, *, line: bool, speed: float, frame: str) -> Motion:
    """Return the move to a place: by a joint motion, or along a straight line."""
    if not isinstance(place, Point):
        return LineMove(place, speed, frame) if line else PoseMove(place, speed, frame)
    if frame != BASE_FRAME:
        raise BadRequest(SAME_IN_EVERY_FRAME)
    return LineMove(place.joints, speed) if line else JointMove(place.joints, speed)
