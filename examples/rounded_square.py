"""Goes round a square with rounded corners, then round a circle, 120 mm above the table.

Runs unattended on the simulated arm. For a real one, write the name of its arm file instead of
`sim:grbl`, and clear the table: the way is checked against the arm's limits and guards, and not
against what stands there.
"""

from armdrive import ArcPart, Arm, LinePart, Pose

CORNER_MM = 15.0


def at(x_mm: float, y_mm: float) -> Pose:
    """Return a pose above the table, the fingers pointing down and a little outwards."""
    return Pose.of(x_mm=x_mm, y_mm=y_mm, z_mm=120, pitch_deg=-70)


with Arm.connect("sim:grbl") as arm:
    arm.home()
    arm.move_to(at(210, 0))

    corners = [at(210, 50), at(280, 50), at(280, -50), at(210, -50)]
    square = [LinePart(corner, blend_mm=CORNER_MM) for corner in corners]
    moved = arm.move_path([*square, LinePart(at(210, 0))], speed=0.5)
    print(f"the square took {moved.duration_s:.1f} s, {moved.note or 'all corners as asked'}")

    half = ArcPart(via=at(245, 35), goal=at(280, 0))
    other = ArcPart(via=at(245, -35), goal=at(210, 0))
    moved = arm.move_path([half, other], speed=0.5)
    print(f"the circle took {moved.duration_s:.1f} s and ended at {moved.pose}")
    assert abs(moved.pose.x_mm - 210) < 1.0, "a circle leads back to where it began"
