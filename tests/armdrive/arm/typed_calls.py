"""Calls as a type checker sees them: mypy checks this file, and nothing executes it.

Each `type: ignore` marks a wrong line, and mypy reports the mark if the line is not wrong after
all. Every other line has to be right.
"""

import armdrive
from armdrive import (
    Arm,
    AsyncArm,
    Grasped,
    GraspMove,
    Handle,
    Jog,
    Jogged,
    JointMove,
    LineMove,
    Moved,
    Pose,
    SimulatedClock,
)
from armdrive.moves import ContinuousJog
from armdrive.testing import ArmWorl  # type: ignore[attr-defined]  # noqa: F401
from kinematics import nonsense  # type: ignore[attr-defined]  # noqa: F401

missing = armdrive.Armm  # type: ignore[attr-defined]
clock = SimulatedClock()
goal = Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90)
arm: Arm = Arm.connect("bench", dialect="grbl", baud=115200, pace="real", reconnect=True)
Arm.connect(pace=clock, allow_restored=True, operator=lambda request: True)
Arm.connect("bench", baud="9600")  # type: ignore[arg-type]
Arm.connect("bench", dialct="grbl")  # type: ignore[call-arg]
Arm.connect(5)  # type: ignore[arg-type]
AsyncArm.connect("bench", pace=clock)
AsyncArm.connect("bench", pase=clock)  # type: ignore[call-arg]

moved: Moved = arm.move_j(base_deg=1, shoulder_deg=2, elbow_deg=3.5, speed=0.5)
handle: Handle[Moved] = arm.move_j(forearm_roll_deg=1, wrist_pitch_deg=2, wait=False)
arm.move_j(wrist_roll_deg=3, wait=True)
arm.move_j({"turret_deg": 30}, speed=0.5)
arm.move_j(elbw_deg=1)  # type: ignore[call-overload]
arm.move_j(elbow=1)  # type: ignore[call-overload]
arm.move_j(elbow_deg="1")  # type: ignore[call-overload]
arm.move_j(30)  # type: ignore[call-overload]
arm.preview(JointMove({"shoulder_deg": 40}))
arm.preview({"turret_deg": 40})  # type: ignore[arg-type]
arm.preview(LineMove(goal))
there: Moved = arm.run(LineMove(goal, speed=0.5))
held: Grasped = arm.run(GraspMove())
began: Handle[Moved] = arm.start(JointMove({"turret_deg": 30}))
arm.run(LineMove(goal, sped=0.5))  # type: ignore[call-arg]
arm.run(ContinuousJog(Jog.joint(shoulder=1), 0.5, 1.0))  # type: ignore[call-overload]
arm.move_to((1, 2, 3))  # type: ignore[call-overload]
arm.move_to("pick")

jogged: Jogged = arm.jog_j(shoulder_deg=2, gripper_mm=5)
arm.jog_j(shoulder=1, elbow=-0.5, duration_s=1)
arm.jog_j({"turret_deg": 2})
arm.jog_j(sholder=1, duration_s=1)  # type: ignore[call-arg]
arm.jog_l(x_mm=5, pitch_deg=-2)
arm.jog_l(frame="tool", z=1, duration_s=1)
arm.jog_l(w_mm=5)  # type: ignore[call-arg]

angle: float = arm.joints.base_deg + arm.joints.wrist_roll_rad
wrong_name = arm.joints.elbw_deg  # type: ignore[attr-defined]
arm.speed_override = 0.5
arm.speed_overide = 0.5  # type: ignore[attr-defined]


async def main() -> None:
    async with AsyncArm.connect("sim:grbl") as left:
        await left.move_j(base_deg=1)
        await left.move_j(bse_deg=1)  # type: ignore[call-overload]
        await left.jog_l(x_mm=5)
        await left.jog_l(x_m=5)  # type: ignore[call-arg]
        left.speed_override = 0.5
        left.speed_overide = 0.5  # type: ignore[attr-defined]
