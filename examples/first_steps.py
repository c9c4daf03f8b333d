"""The first steps with an arm: reference it, move it in three ways, grasp, and look at it.

Runs unattended on the simulated TeachMover. For a real one, write the name of its arm file, or
`Arm.connect("/dev/ttyUSB0", dialect="teachmover")`, and reference it first with `armdrive home`.
"""

from armdrive import Arm, Pose

with Arm.connect("sim:teachmover") as arm:
    arm.home()  # the simulated arm has a simulated operator
    arm.move_j(shoulder_deg=40, elbow_deg=-60, speed=0.5)  # joints not named stay
    arm.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90))  # a joint motion to a pose
    arm.move_l(Pose.of(x_mm=250, y_mm=80, z_mm=120, pitch_deg=-90))  # along a straight line
    width_mm = arm.gripper.grasp()  # there is nothing to grasp here
    print(arm.status, arm.joints, arm.pose)
    print(f"between the fingers: {width_mm:.1f} mm")
