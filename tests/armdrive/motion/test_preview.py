"""A preview is the motion itself before it begins: same plan, same refusal, and nothing is sent."""

import math
from dataclasses import replace
from itertools import combinations, pairwise

import pytest
from amounts import amount
from chain_files import connected, five_joints
from faults import OVER_THE_TABLE, ready_arm, sim_arm, sim_config
from hypothesis import given, settings
from hypothesis import strategies as st

from armdrive.config.sections import MotionSettings
from armdrive.errors import NotReferenced, OutOfBounds, Refused, WrongState
from armdrive.motion.preview import Preview, clearance_words, preview_view
from armdrive.moves import JointMove, LineMove, PoseMove
from kinematics import JointRange, Joints, Pose, Unreachable
from kinematics.guards.path import Clearance

GOAL = Pose.of(x_mm=250, y_mm=100, z_mm=120, pitch_deg=-80)
FAR = Pose.of(x_mm=600, y_mm=0, z_mm=120, pitch_deg=-80)
UNDER = Pose.of(x_mm=220, y_mm=10, z_mm=-60, pitch_deg=-90)


@pytest.fixture
def arm():
    return ready_arm(sim_config(planned_burst_s=2.0))


def asked(arm, goal, **how):
    """Ask for the motion that a preview is of."""
    if isinstance(goal, Pose):
        line = how.pop("line", False)
        return (arm.move_l if line else arm.move_to)(goal, **how)
    return arm.move_j(**goal, **how)


def foreseen(arm, goal, *, line=False, **how):
    if not isinstance(goal, Pose):
        return arm.preview(JointMove(goal, **how))
    return arm.preview(LineMove(goal, **how) if line else PoseMove(goal, **how))


GOALS = [
    (GOAL, {}),
    (GOAL, {"line": True, "speed": 0.5}),
    ({"base_deg": 40.0, "elbow_deg": -60.0}, {"speed": 0.3}),
    (Pose.of(x_mm=0, y_mm=0, z_mm=-30, pitch_deg=0), {"frame": "tool", "line": True}),
]


@pytest.mark.parametrize(("clearance_mm", "shown"), [(-0.3, "0"), (0.3, "0"), (-0.7, "-1")])
def test_a_clearance_of_nothing_has_no_sign(clearance_mm, shown):
    near = Clearance("table", "tip z", clearance_mm, 0, Joints.of(0.0, 0.0, 0.0, 0.0, 0.0))
    assert clearance_words(Preview(None), near) == f"table: {shown} mm (tip z), at the goal"


@pytest.mark.parametrize(("goal", "how"), GOALS)
def test_the_motion_does_what_its_preview_showed(arm, goal, how):
    before = len(arm.twin.link.sent)
    preview = foreseen(arm, goal, **how)
    assert len(arm.twin.link.sent) == before
    assert preview.possible
    began = arm.parts.core.position.coordinates
    moved = asked(arm, goal, **how)
    assert preview.start == began.joints
    assert preview.end == arm.parts.core.position.coordinates.joints
    assert math.dist(preview.path[-1], arm.model.arm.points(moved.joints)[-1]) < 1.0
    assert preview.duration_s <= moved.duration_s <= preview.slowest_s * 1.1 + 1.0


@pytest.mark.parametrize(
    ("goal", "how", "kind"),
    [
        (FAR, {}, Unreachable),
        (FAR, {"line": True}, Unreachable),
        (UNDER, {}, OutOfBounds),
        ({"shoulder_deg": 300.0}, {}, OutOfBounds),
        ({"shoulder_deg": -30.0}, {}, OutOfBounds),
    ],
)
def test_a_preview_gives_the_motions_refusal_and_a_pose_that_can_be_reached(arm, goal, how, kind):
    preview = foreseen(arm, goal, **how)
    assert isinstance(preview.refusal, kind)
    sent = len(arm.twin.link.sent)
    with pytest.raises(kind) as refused:
        asked(arm, goal, **how)
    assert len(arm.twin.link.sent) == sent
    assert str(preview.refusal) == str(refused.value)
    assert preview.plan is None
    assert preview.nearest is not None
    named = {f"{name}_deg": angle for name, angle in preview.nearest.joints.deg.items()}
    arm.move_j(**named)
    assert math.dist(arm.twin.world.tip, arm.model.arm.points(preview.nearest.joints)[-1]) < 1.5


def test_a_preview_lists_every_posture_and_why_the_others_were_not_chosen(arm):
    preview = arm.preview(PoseMove(GOAL))
    for before, behind in pairwise(map(arm.model.arm.points, preview.postures)):
        assert max(map(math.dist, before, behind)) <= 2.0
    first, *others = preview.ways
    assert first.taken
    assert first.name == "base front, elbow up"
    assert len(others) == 3
    assert all(way.against and not way.taken and not way.allowed for way in others)
    assert not arm.preview(JointMove({"base_deg": 10})).ways


def test_a_farther_allowed_posture_is_marked_and_can_be_reached_by_its_joints():
    config = sim_config(planned_burst_s=2.0)
    wide = tuple(JointRange.of(-180, 180) for _ in config.model.arm.limits)
    model = replace(config.model, arm=replace(config.model.arm, limits=wide))
    arm = ready_arm(replace(config, model=model))
    preview = arm.preview(PoseMove(GOAL))
    second = [way for way in preview.ways if way.allowed and not way.taken]
    assert second
    assert "farther" in second[0].against
    line = arm.preview(LineMove(GOAL))
    assert any("straight line keeps" in way.against for way in line.ways if not way.taken)
    assert "in another posture" in arm.preview(LineMove(second[0].joints)).plan.note
    assert line.plan.note == arm.preview(LineMove(line.end)).plan.note == ""
    named = {f"{name}_deg": angle for name, angle in second[0].joints.deg.items()}
    assert arm.model.arm.fk(second[0].joints).x_mm == pytest.approx(GOAL.x_mm)
    assert arm.preview(JointMove(named)).possible
    arm.move_j(**named)
    assert math.dist(arm.twin.world.tip, (250, 100, 120)) < 1.5


def test_margins_and_clearances_are_the_least_on_the_way(arm):
    preview = arm.preview(LineMove(Pose.of(x_mm=250, y_mm=60, z_mm=20, pitch_deg=-80)))
    table = next(each for each in preview.clearances if each.guard == "table")
    heights = [
        min(point[2] for point in arm.model.arm.points(joints)[-3:]) for joints in preview.postures
    ]
    assert table.clearance_mm == pytest.approx(min(heights))
    assert table.quantity == "tip z"
    shoulder = next(one for one in preview.margins if one.joint == "shoulder")
    bounds = arm.model.arm.limits[1]
    margins = [min(j[1] - bounds.low_rad, bounds.high_rad - j[1]) for j in preview.postures]
    assert shoulder.margin_rad == pytest.approx(min(margins))
    assert preview.margin is preview.margins[0]
    assert [one.clearance_mm for one in preview.clearances] == sorted(
        one.clearance_mm for one in preview.clearances
    )


def test_where_no_motor_turns_there_is_nothing_to_stop(arm):
    arm.move_to(GOAL)
    preview = arm.preview(PoseMove(GOAL))
    assert (preview.duration_s, preview.stop_time_s, preview.stop_distance_mm) == (0.0, 0.0, 0.0)
    assert "the arm stands there already" in str(preview)
    assert "a stop" not in str(preview)


def test_an_unreferenced_arm_has_no_preview():
    arm = sim_arm()
    preview = arm.preview(PoseMove(GOAL))
    assert isinstance(preview.refusal, NotReferenced)
    assert preview.start is None
    assert preview.path == ()
    assert "refused" in str(preview)


def test_an_arm_in_motion_shows_the_plan_and_the_reason_why_not_now(arm):
    handle = arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.5)
    preview = arm.preview(JointMove({"base_deg": 0}))
    assert isinstance(preview.refusal, WrongState)
    assert preview.plan is not None
    handle.wait()
    assert arm.preview(JointMove({"base_deg": 0})).possible


def test_an_arm_of_a_template_refuses_poses_and_shows_joints(arm):
    arm.parts.core.geometry_known = False
    assert isinstance(arm.preview(PoseMove(GOAL)).refusal, Refused)
    assert arm.preview(JointMove({"base_deg": 10})).possible


def test_a_preview_works_for_an_arm_of_a_model_file(tmp_path):
    config = replace(five_joints(tmp_path), motion=MotionSettings(planned_burst_s=2.0))
    with connected(config) as arm:
        arm.home()
        goal = Pose.of(x_mm=250, y_mm=-60, z_mm=140, pitch_deg=-80)
        preview = arm.preview(PoseMove(goal))
        assert preview.possible
        taken, *others = preview.ways
        assert taken.taken
        assert len(others) == 3
        assert all(other.against for other in others)
        assert taken.name.startswith("solution ")
        arm.move_to(goal)
        assert preview.end == arm.parts.core.position.coordinates.joints


@settings(max_examples=amount(12, 1000))
@given(
    st.floats(-300, 450), st.floats(-300, 300), st.floats(-80, 450), st.floats(-120, 60),
    st.booleans(),
)  # fmt: skip
def test_a_preview_shows_where_every_goal_would_end(x, y, z, pitch, line):
    arm = ready_arm(sim_config(planned_burst_s=10.0))
    goal = Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=pitch)
    preview = foreseen(arm, goal, line=line)
    if preview.possible:
        asked(arm, goal, line=line)
        assert preview.end == arm.parts.core.position.coordinates.joints
        least = -arm.model.guards.tolerance_mm - 1e-6
        assert all(each.clearance_mm >= least for each in preview.clearances)
        return
    with pytest.raises(type(preview.refusal)):
        asked(arm, goal, line=line)
    if preview.nearest is not None:
        assert arm.model.arm.violations(preview.nearest.joints) == ()
        assert arm.model.guards.violation(arm.model.arm, preview.nearest.joints) is None


def test_a_preview_is_plain_data_too(arm):
    view = preview_view(arm.preview(PoseMove(GOAL)))
    assert view["possible"] is True
    assert view["refusal"] is None
    assert view["ways"][0]["taken"] is True
    assert view["path_mm"][0] == [
        round(each, 2) for each in arm.model.arm.points(OVER_THE_TABLE)[-1]
    ]
    refused = preview_view(arm.preview(PoseMove(FAR)))
    assert refused["possible"] is False
    assert refused["refusal"]["code"].startswith("E")
    assert refused["nearest"]["pose"]["x_mm"] < 450


def test_the_command_shows_and_moves_nothing(call):
    call("home", code=0)
    before = call("status", "--json", code=0).json
    seen = call("move", "--x", "250", "--z", "120", "--pitch", "-90", "--preview", code=0).out
    assert "-> base front, elbow up" in seen
    assert "table:" in seen
    view = call("move", "--x", "250", "--z", "120", "--preview", "--json", code=0).json
    assert view["possible"] is True
    assert call("status", "--json", code=0).json["joints"] == before["joints"]


def test_the_command_ends_with_the_code_of_the_refusal(call):
    call("home", code=0)
    far = ("--x", "900", "--z", "120", "--preview")
    seen = call("move", *far, code=3)
    assert seen.err.startswith("armdrive: [E604]")
    assert "possible instead:" not in seen.out, "a hundredth of the way is as good as none"
    call("move", "--shoulder", "60", "--elbow", "-60", code=0)
    assert "possible instead:" in call("move", *far, code=3).out
    view = call("move", "--shoulder", "900", "--preview", "--json", code=3).json
    assert view["refusal"]["code"] == "E205"
    assert "leads to" in call("move", "--park", "--preview", code=0).out
    assert "the arc" in call("move", "--x", "250", "--via", "240,10,120", "--preview", code=3).err


def test_at_the_edge_of_reach_one_posture_is_taken_and_named_once(arm):
    """Elbow up and elbow down are the same where the arm is stretched out."""
    model = arm.model.arm
    stretched = model.fk(
        arm.parts.core.position.coordinates.joints.replace(shoulder=0.5, elbow=0.0)
    )
    preview = arm.preview(PoseMove(stretched))
    assert [way.taken for way in preview.ways].count(True) <= 1
    for way, other in combinations(preview.ways, 2):
        turns = zip(way.joints, other.joints, strict=True)
        assert max(abs(a - b) for a, b in turns) > 1e-4, (way.name, other.name)
