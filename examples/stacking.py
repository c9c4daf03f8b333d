"""Take blocks from the squares of a grid and build a tower of them: stacking.arm, in Python.

Runs unattended on the simulated arm, which gets its blocks first, and on an arm of yours by its
name: reference it (`armdrive home`), lay four cubes of 25 mm out as the table says, and

    armdrive run stacking.py --arm NAME --check        on a simulated arm first
    armdrive run stacking.py --arm NAME

    block    column  row     x     y     the middle of each block, in mm from the arm's base
    A        1       1     190    50
    B        2       1     240    50
    C        1       2     190   100
    D        2       2     240   100
    tower                  240  -100
"""

from armdrive import Arm, Pose, Trust
from armdrive.sim.world.table import TableBlock

COLUMNS = ROWS = 2
SIDE_MM = 25.0  # of a block
GRID_MM = 50.0  # from one square to the next
EDGE_MM = 140.0  # from the base axis to column 0
LIFT_MM = 50.0  # so far up and down on a straight line, clear of what stands there
TOWER_MM = (240.0, -100.0)


def down(x_mm: float, y_mm: float, z_mm: float) -> Pose:
    """Return a pose with the fingers pointing down."""
    return Pose.of(x_mm=x_mm, y_mm=y_mm, z_mm=z_mm, pitch_deg=-90)


def square(column: int, row: int) -> tuple[float, float]:
    """Return x and y of the middle of a square."""
    return EDGE_MM + column * GRID_MM, row * GRID_MM


def take(arm: Arm, x_mm: float, y_mm: float) -> None:
    """Take the block that stands there."""
    arm.gripper.open(SIDE_MM + 15)
    arm.move_to(down(x_mm, y_mm, SIDE_MM / 2 + LIFT_MM))
    arm.move_l(down(x_mm, y_mm, SIDE_MM / 2))
    arm.gripper.close(SIDE_MM - 2)  # 2 mm less than the block: so the fingers press on it
    arm.move_l(down(x_mm, y_mm, SIDE_MM / 2 + LIFT_MM))


def put(arm: Arm, x_mm: float, y_mm: float, level: int) -> None:
    """Put the block there, on so many others."""
    z_mm = SIDE_MM / 2 + level * SIDE_MM
    arm.move_to(down(x_mm, y_mm, z_mm + LIFT_MM))
    arm.move_l(down(x_mm, y_mm, z_mm))
    arm.gripper.open(SIDE_MM + 15)
    arm.move_l(down(x_mm, y_mm, z_mm + LIFT_MM))


squares = [square(column, row) for row in range(1, ROWS + 1) for column in range(1, COLUMNS + 1)]

with Arm.connect() as arm:
    if arm.twin is not None:  # a simulated arm: lay the blocks out
        for name, place in zip("ABCD", squares, strict=False):
            arm.twin.world.put(TableBlock(name, *place, width_mm=SIDE_MM, height_mm=SIDE_MM))
    if arm.status.trust is Trust.UNKNOWN:
        arm.home()  # the simulated arm has a simulated operator
    for level, place in enumerate(squares):
        take(arm, *place)
        put(arm, *TOWER_MM, level)
    arm.park()
    print(f"a tower of {len(squares)} blocks, {len(squares) * SIDE_MM:g} mm high")
