"""Rows of the older Robko 01 program, position and speed by turns, run as raw motor steps.

Runs unattended on the simulated arm. For a real one, write the name of its arm file instead of
`sim:robko01`, stand beside it with a hand on its power switch, and begin with the arm raised:
raw steps know neither limits nor the table.
"""

from armdrive import Arm

ROWS = [  # relative: base, shoulder, elbow, left and right differential, gripper
    [450, 0, 600, 0, -400, 0, 200, 0, -200, 0, 400, 0],
    [0, 0, 0, 0, 0, 0, 110, 0, 110, 0, 0, 0],
    [0, 0, 100, 0, 0, 0, 0, 0, 0, 0, 0, 0],
    [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -100, 0],
    [0, 0, -100, 0, 0, 0, 0, 0, 0, 0, 0, 0],
    [-450, 0, -600, 0, 400, 0, -310, 0, 90, 0, -300, 0],
]


def steps(row: list[int]) -> list[int]:
    """Take the positions of a row; the speeds between them are computed anew."""
    return row[::2]


with Arm.connect("sim:robko01") as arm:
    began = arm.status.acknowledged
    for row in ROWS:
        moved = arm.move_motors(*steps(row), speed=1.0)
        print(f"{steps(row)}: {moved.duration_s:.1f} s in {moved.bursts} exchanges")
    assert arm.status.acknowledged == began, "the rows lead back to where they began"
    print(f"a stop took at most {arm.status.stop_time_s:.2f} s at any moment of it")
