"""Teach points, look at a motion before it begins, and run a sequence over the points.

Runs unattended on the simulated TeachMover. The points go into a folder of their own here; without
that they are kept beside the arm files, and `armdrive points list` shows where.
"""

import os
import tempfile

from armdrive import Arm, LineMove, Pose, Step, StepList, Stepper

with tempfile.TemporaryDirectory() as home:
    os.environ["ARMDRIVE_HOME"] = home
    with Arm.connect("sim:teachmover") as arm:
        arm.home()
        arm.move_to(Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90))
        arm.points.teach("above", note="over the block")
        arm.move_l(Pose.of(x_mm=250, y_mm=0, z_mm=40, pitch_deg=-90))
        arm.points.teach("pick")

        print(arm.preview(LineMove("above")))  # sends nothing, moves nothing

        fetch = StepList(
            (
                Step("above"),
                Step(gripper="open"),
                Step("pick", how="line", speed=0.5),
                Step("above", how="line"),
            )
        )
        arm.points.put_sequence("fetch", fetch, instead_of=None)
        stepper = Stepper(arm, fetch, arm.points)
        stepper.run(print)
        print("and back to", stepper.backward())
        print(arm.points.path.read_text(encoding="utf-8"))
