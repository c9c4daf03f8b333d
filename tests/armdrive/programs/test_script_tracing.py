"""The path of a rehearsed script is the tip's own, through arcs and jogs as well."""

import math
from itertools import pairwise

import pytest

from armdrive.connect.target import simulated_config
from armdrive.programs.rehearsal import RehearsedPlan
from armdrive.programs.script_rehearsal import rehearse_script

CENTRE = """
from armdrive import Arm, Pose

def at(x, y):
    return Pose.of(x_mm=x, y_mm=y, z_mm=60, pitch_deg=-90)

with Arm.connect() as arm:
    arm.park()
    arm.move_to(at(215, 0))
"""
ROUND = f"""{CENTRE}
    arm.move_c(via=at(250, 35), goal=at(285, 0))
    arm.move_c(via=at(250, -35), goal=at(215, 0))
"""


@pytest.fixture
def traced(tmp_path):
    def trace(text, *, wanted=True):
        script = tmp_path / "script.py"
        script.write_text(text, encoding="utf-8")
        plan = RehearsedPlan(source=None, settle=True, traced=wanted)
        found = rehearse_script(script, (), simulated_config("teachmover"), None, plan)
        assert found.refusal is None
        return found.path

    return trace


def test_the_path_of_an_arc_is_round(traced):
    straight, whole = traced(CENTRE), traced(ROUND)
    circle = whole[len(straight) :]
    assert len(circle) > 30
    for x, y, z in circle:
        assert math.hypot(x - 250.0, y) == pytest.approx(35.0, abs=1.5)
        assert z == pytest.approx(60.0, abs=1.0)
    assert max(x for x, _, _ in circle) == pytest.approx(285.0, abs=2.0)


def test_the_path_begins_where_the_arm_stood_and_has_no_point_twice(traced):
    path = traced(CENTRE)
    assert path[0] == pytest.approx((127.0, 0.0, 0.0), abs=1.0)
    assert all(math.dist(a, b) > 0.5 for a, b in pairwise(path))


def test_nothing_is_kept_unless_it_is_wanted(traced):
    assert traced(ROUND, wanted=False) == ()
