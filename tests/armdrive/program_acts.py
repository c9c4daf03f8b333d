"""The acts of programs, in the words of the tests."""

from armdrive.moves import (
    GraspMove,
    GripperMove,
    JointMove,
    LineMove,
    MoveSequence,
    ParkMove,
    PoseMove,
)
from armdrive.programs.acts import Go, act_name
from kinematics import Joints, Pose


def go(goal, *, line=False, speed=1.0, opening_mm=None, name=""):
    """Go to a pose or to joint angles in degrees by name, the fingers first."""
    if isinstance(goal, Pose):
        move = LineMove(goal, speed) if line else PoseMove(goal, speed)
    else:
        joints = Joints.of(*goal.values(), names=tuple(goal))
        move = LineMove(joints, speed) if line else JointMove(joints, speed)
    if opening_mm is not None:
        move = MoveSequence((GripperMove(opening_mm, speed), move))
    return Go(move, name)


def fingers(opening_mm, speed=1.0):
    return Go(GripperMove(opening_mm, speed))


def grasp():
    return Go(GraspMove())


def ready(speed=1.0):
    return Go(ParkMove(speed))


def travels(act):
    """Tell whether an act takes the hand to a place of the program."""
    return isinstance(act, Go) and act_name(act) == "Go"


def goal_of(act):
    """Return the place that an act leads to: a pose, or joint angles in degrees by name."""
    move = act.move.moves[-1] if isinstance(act.move, MoveSequence) else act.move
    if isinstance(move.goal, Pose):
        return move.goal
    return {name: round(angle, 9) for name, angle in move.goal.deg.items()}
