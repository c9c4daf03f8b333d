"""The boundary and the points that an arm reaches, against its own answers place by place."""

import math
from itertools import pairwise

from amounts import every_row
from kinematics_cases import TEACHMOVER, UNEVEN

from kinematics import FiveAxisArm, JointRange, Pose
from kinematics.five_axis.workspace import NUDGE_MM, section

FREE = FiveAxisArm(150.0, 120.0, 80.0, 60.0, (JointRange.of(-180, 180),) * 5)


def points_of(found):
    return [point for curve in found.boundary for point in curve]


def from_curves(found, x, z):
    """How far a place is from the boundary, measured to the chords between its points."""
    return min(to_chord(x, z, a, b) for curve in found.boundary for a, b in pairwise(curve))


def to_chord(x, z, a, b):
    dx, dz = b[0] - a[0], b[1] - a[1]
    square = dx * dx + dz * dz
    along = 0.0 if square == 0.0 else ((x - a[0]) * dx + (z - a[1]) * dz) / square
    along = min(max(along, 0.0), 1.0)
    return math.hypot(x - a[0] - along * dx, z - a[1] - along * dz)


@every_row("arm, pitch_deg", [(TEACHMOVER, -90), (UNEVEN, 35)])
def test_between_what_is_reached_and_what_is_not_lies_the_boundary(arm, pitch_deg):
    found = section(arm, math.radians(pitch_deg), step_mm=8.0)
    spacing = 31.0
    lattice = [
        (column * spacing + 7.0, row * spacing)
        for column in range(-16, 17)
        for row in range(-14, 22)
    ]
    held = {place: found.holds(*place) for place in lattice}
    crossings = 0
    for (x, z), inside in held.items():
        for beside in ((x + spacing, z), (x, z + spacing)):
            if held.get(beside, inside) != inside:
                crossings += 1
                edge = crossing(found, (x, z), beside)
                assert from_curves(found, *edge) < 0.3, edge
    assert crossings > 20


def crossing(found, a, b):
    """The place between two where reach begins, by halving."""
    inside = found.holds(*a)
    for _ in range(30):
        middle = (a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0
        if found.holds(*middle) == inside:
            a = middle
        else:
            b = middle
    return a


def test_the_boundary_s_points_lie_close_together_and_on_the_edge():
    found = section(TEACHMOVER, 0.0, step_mm=10.0)
    for curve in found.boundary:
        for a, b in pairwise(curve):
            assert math.dist(a, b) < 10.5
    for x, z in points_of(found)[::7]:
        around = [
            found.holds(x + 2 * NUDGE_MM * math.cos(t), z + 2 * NUDGE_MM * math.sin(t))
            for t in (k * math.pi / 8 for k in range(16))
        ]
        assert any(around)
        assert not all(around)


def test_without_limits_the_reach_is_the_ring_between_stretched_and_folded():
    found = section(FREE, -math.pi / 2, step_mm=4.0)
    centre = 150.0 - 60.0  # the hand points down
    radii = {round(math.hypot(x, z - centre), 1) for x, z in points_of(found)}
    assert radii == {40.0, 200.0}


def test_the_points_are_those_of_a_lattice_that_ik_reaches():
    pitch = math.radians(-90)
    found = section(TEACHMOVER, pitch, math.radians(30))
    points = found.points(60.0)
    assert len(points) > 15
    for x, z in points:
        assert (x % 60.0, z % 60.0) == (0.0, 0.0)
        goal = Pose(x * math.cos(math.pi / 6), x * math.sin(math.pi / 6), z, pitch)
        assert TEACHMOVER.solve(goal) is not None
    assert (180.0, 120.0) in points
    assert (600.0, 120.0) not in points


def test_a_pitch_that_is_never_held_reaches_nothing():
    still = FiveAxisArm(100, 100, 100, 50, (JointRange.of(0, 0),) * 5)
    found = section(still, 1.0)
    assert found.boundary == ()
    assert found.points(50.0) == ()
    assert found.box_mm == (0.0, 0.0, 0.0, 0.0)
