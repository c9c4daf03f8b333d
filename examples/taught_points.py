"""Teach points, look at a motion before it begins, and go from point to point.

Runs unattended on the simulated TeachMover. The points go into a folder of their own here; without
that they are kept beside the arm files, and `armdrive points list` shows where.
"""

import os
import tempfile

from armdrive import Arm, LineMove, Pose

with tempfile.TemporaryDirectory() as home:
    os.environ["ARMDRIVE_HOME"] = home
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        arm.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90))
        arm.points.teach("above", note="over the block")
        arm.move_l(Pose.of(x_mm=250, y_mm=0, z_mm=40, pitch_deg=-90))
        arm.points.teach("pick")

        print(arm.preview(LineMove("above")))  # sends nothing, moves nothing

        arm.move_to("above", speed=0.5)
        arm.gripper.open()
        arm.move_l("pick", speed=0.3)
        arm.move_l("above")
        for name, point in arm.points.items():
            print(name, point.joints)
        print(arm.points.path.read_text(encoding="utf-8"))
