"""Motion along arcs, and along several moves as one, with blends between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Literal, overload

from armdrive.calls.moving import Moving
from armdrive.errors import BadRequest
from armdrive.flows.motion import Moved
from armdrive.frames import BASE, TOOL, goal_in_base
from armdrive.handle import Handle
from armdrive.planning import plan_route, speed_fraction
from kinematics import Joints, Pose
from kinematics.paths.parts import ArcMove, JointMove, Move

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig


class Routing(Moving):
    """The calls that move along a way of several parts, or a round one."""

    @overload
    def move_c(
        self,
        via: Pose,
        goal: Pose,
        *,
        speed: float = 1.0,
        frame: str = BASE,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    def move_c(
        self, via: Pose, goal: Pose, *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> Handle[Moved]: ...
    def move_c(
        self, via: Pose, goal: Pose, *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | Handle[Moved]:
        """Move the tip along the arc of a circle, through `via`, to a pose.

        Of `via` only x, y and z count; the hand turns evenly to the goal's pitch and roll. Raises
        `kinematics.NoArc` for points on one line, and `PathBroken` where the arc leaves the reach.
        """
        return self._along([ArcMove(via, goal)], speed, frame, wait)

    @overload
    def move_path(
        self,
        moves: Sequence[Move],
        *,
        speed: float = 1.0,
        frame: str = BASE,
        wait: Literal[True] = True,
    ) -> Moved: ...
    @overload
    def move_path(
        self, moves: Sequence[Move], *, speed: float = 1.0, frame: str = BASE, wait: Literal[False]
    ) -> Handle[Moved]: ...
    def move_path(
        self, moves: Sequence[Move], *, speed: float = 1.0, frame: str = BASE, wait: bool = True
    ) -> Moved | Handle[Moved]:
        """Move through several moves as one: `LineMove`, `ArcMove`, `PoseMove`, `JointMove`.

        A move with `blend_mm` is left for the next one so far before its end, without stopping;
        without, the arm stops there. The whole way is audited first, in one posture of the arm.
        `note` of the result tells of blends that had to be smaller.
        """
        return self._along(moves, speed, frame, wait)

    def _along(
        self, moves: Sequence[Move], speed: float, frame: str, wait: bool
    ) -> Moved | Handle[Moved]:
        self.core.require_geometry()
        fraction = speed_fraction(speed)
        if not moves:
            raise BadRequest("a path needs at least one move, for example LineMove(pose)")
        if frame == TOOL:
            raise BadRequest(
                "the tool's frame goes along with the arm: give a path in the base or in a frame "
                "of the arm file"
            )
        handle = self._start(
            lambda here: plan_route(
                self.config,
                self.speeds,
                here,
                [_in_base(self.config, here.joints, move, frame) for move in moves],
                fraction,
            )
        )
        return handle.wait() if wait else handle


def _in_base(config: ArmConfig, joints: Joints, move: Move, frame: str) -> Move:
    """Return a move with its poses as the base sees them."""
    if isinstance(move, JointMove):
        return move
    goal = goal_in_base(config, joints, move.goal, frame)
    if isinstance(move, ArcMove):
        return replace(move, goal=goal, via=goal_in_base(config, joints, move.via, frame))
    return replace(move, goal=goal)
