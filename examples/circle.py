"""Draw a circle on a sheet of paper with a pen: down, two arcs, up.

Runs unattended on the simulated arm, and on an arm of yours by its name:

    armdrive run circle.py --arm NAME --check        on a simulated arm first
    armdrive run circle.py --arm NAME

Hold a pen in the fingers, point down, and say in the arm file how far it stands out of them
(`[tool]`, `along_mm`). Then every pose is that of its point: take the reference with the pen's
point on the mark (`armdrive home`), on the sheet of paper if it is a thick one.

    the paper       x from 200 to 300, y from -50 to 50, mm from the arm's base
"""

import math

from armdrive import Arm, Pose, Trust

CENTRE_MM = (250.0, 0.0)
RADIUS_MM = 35.0
PAPER_MM = 0.0  # its height above the reference mark
UP_MM = 15.0  # the pen is lifted so far between strokes
SPEED = 0.5


def on_circle(angle_deg: float, above_mm: float = 0.0) -> Pose:
    """Return the pose with the pen's point on the circle, or straight above it."""
    angle_rad = math.radians(angle_deg)
    return Pose.of(
        x_mm=CENTRE_MM[0] + RADIUS_MM * math.cos(angle_rad),
        y_mm=CENTRE_MM[1] + RADIUS_MM * math.sin(angle_rad),
        z_mm=PAPER_MM + above_mm,
        pitch_deg=-90,
    )


with Arm.connect() as arm:
    if arm.status.trust is Trust.UNKNOWN:
        arm.home()  # the simulated arm has a simulated operator
    arm.park()  # off the mark, and clear of the paper
    arm.move_to(on_circle(180, above_mm=UP_MM))
    arm.move_l(on_circle(180), speed=SPEED)
    arm.move_c(via=on_circle(90), goal=on_circle(0), speed=SPEED)
    arm.move_c(via=on_circle(270), goal=on_circle(180), speed=SPEED)
    arm.move_l(on_circle(180, above_mm=UP_MM))
    arm.park()
    print(f"drew a circle with a radius of {RADIUS_MM:g} mm")
