"""Moves are values: each has a JSON form, means one thing once resolved, and is refused whole."""

import functools
import json
import math
from dataclasses import replace

import jsonschema
import pytest
from amounts import every_row
from faults import as_it_stands, ready_arm
from hypothesis import given
from hypothesis import strategies as st

from armdrive import Arm, Grasped, Jogged, Moved, Point
from armdrive.arm.moving import ground_of
from armdrive.errors import ArmError, BadArgument, BadRequest, OutOfBounds, Refused
from armdrive.errors.table import error_view
from armdrive.motion.resolve import park_pose, prepare, resolve
from armdrive.moves import (
    ArcMove,
    ContinuousJog,
    GraspMove,
    GripperMove,
    Jog,
    JogMove,
    JointMove,
    LineMove,
    MoveSequence,
    ParkMove,
    PathMove,
    PoseMove,
    jog_axes,
)
from armdrive.registry import DIALECTS
from armdrive.runtime.position import ArmCoordinates
from armdrive.status import status_view
from armdrive.text.json_forms import move_from_json, move_to_json, schema
from kinematics import JOINT_NAMES, ArcPart, JointPart, Joints, LinePart, Pose, PosePart

SCHEMA = schema()


@functools.cache
def validator(form):
    """Return what validates JSON data of a form, made once because the schema itself is checked."""
    made = {"$ref": f"#/$defs/{form}", "$defs": SCHEMA["$defs"]}
    jsonschema.Draft202012Validator.check_schema(made)
    return jsonschema.Draft202012Validator(made)


def valid(form, data):
    """Validate JSON data against the published schema of a form."""
    validator(form).validate(json.loads(json.dumps(data)))


SPEEDS = st.floats(0.01, 1.0)
ANGLES = st.floats(-180.0, 180.0)
FRAMES = st.sampled_from(("base", "tool"))
POSES = st.builds(
    lambda x, y, z, pitch, roll: Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=pitch, roll_deg=roll),
    *[st.floats(-500, 500)] * 3,
    *[ANGLES] * 2,
)
POSTURES = st.builds(Joints.of, *[ANGLES] * 5)
NAMED = st.dictionaries(
    st.sampled_from([f"{name}_deg" for name in JOINT_NAMES]), ANGLES, min_size=1
)
BLENDS = st.floats(0.0, 50.0)
PARTS = st.one_of(
    st.builds(LinePart, POSES, BLENDS),
    st.builds(PosePart, POSES, BLENDS),
    st.builds(JointPart, POSTURES, BLENDS),
    st.builds(ArcPart, POSES, POSES, BLENDS, st.none() | st.floats(-7.0, 7.0)),
)
SINGLE = st.one_of(
    st.builds(JointMove, POSTURES | NAMED, SPEEDS),
    st.builds(PoseMove, POSES, SPEEDS, FRAMES),
    st.builds(PoseMove, st.just("pick"), SPEEDS),
    st.builds(LineMove, POSES, SPEEDS, FRAMES),
    st.builds(LineMove, POSTURES | st.just("pick"), SPEEDS),
    st.builds(ArcMove, POSES, POSES, SPEEDS, FRAMES),
    st.builds(PathMove, st.lists(PARTS, min_size=1, max_size=3).map(tuple), SPEEDS),
    st.builds(GripperMove, st.none() | st.floats(0.0, 70.0), SPEEDS),
    st.builds(ParkMove, SPEEDS, st.none() | POSES),
)
MOVES = st.one_of(
    SINGLE,
    st.builds(GraspMove, st.floats(0.0, 20.0)),
    st.builds(
        lambda by, speed: JogMove(Jog.joint(**by), speed), st.just({"shoulder": 2.0}), SPEEDS
    ),
    st.builds(lambda moves: MoveSequence(tuple(moves)), st.lists(SINGLE, min_size=1, max_size=3)),
)


@given(MOVES)
def test_a_move_is_read_as_it_was_written(move):
    data = json.loads(json.dumps(move_to_json(move)))
    valid("move", data)
    again = move_from_json(data)
    assert type(again) is type(move)
    assert approximately(move_to_json(again)) == data


def approximately(data):
    """Angles are radians inside, so that degrees may differ in their last digits."""
    if isinstance(data, float):
        return pytest.approx(data, abs=1e-9)
    if isinstance(data, dict):
        return {key: approximately(each) for key, each in data.items()}
    return [approximately(each) for each in data] if isinstance(data, list) else data


@every_row(
    "data, said",
    [
        (3, "move must be an object, not 3"),
        ({}, "move.move must be one of joint, pose, line, .*, sequence, not None"),
        ({"move": "lin"}, "did you mean 'line'"),
        ({"move": "line"}, "move has no 'goal'"),
        ({"move": "line", "goal": {"x_mm": 1}}, "move.goal has no 'y_mm'"),
        ({"move": "joint", "goal": {"shoulder_deg": "40"}}, "goal.shoulder_deg must be a number"),
        ({"move": "joint", "goal": {"shoulder": 40}}, "a joint is named as shoulder_deg"),
        ({"move": "park", "sped": 1}, "'sped'; known are .*; did you mean 'speed'"),
        ({"move": "park", "speed": 2}, "a fraction of the limits"),
        (
            {"move": "sequence", "moves": [{"move": "park", "goal": 1}]},
            r"move.moves\[0\].goal must",
        ),
        ({"move": "jog", "space": "round", "by": {"x_mm": 1}}, "move.space must be joint or"),
        ({"move": "jog", "space": "joint", "by": {"x": 1}}, "names no increment"),
        ({"move": "hold", "space": "joint"}, "move.move must be one of"),
    ],
)
def test_wrong_json_is_refused_with_where_it_stands(data, said):
    with pytest.raises(BadRequest, match=said):
        move_from_json(data)


def test_a_hold_is_no_move():
    """It is a lease that expires: nothing writes it down, queues it or does it once more."""
    arm, hold = ready_arm(), ContinuousJog(Jog.joint(base=1), 0.5, math.inf)
    sent = len(arm.twin.link.sent)
    with pytest.raises(BadArgument, match="cannot be written as JSON"):
        move_to_json(hold)
    for call in (arm.run, arm.start, arm.preview):
        with pytest.raises(BadArgument, match="move must be a move"):
            call(hold)
    with pytest.raises(BadArgument, match="must be a move"):
        MoveSequence((hold,))
    assert len(arm.twin.link.sent) == sent


# -- resolving --------------------------------------------------------------------------------

PLACES = st.builds(
    lambda base, shoulder, elbow: Joints.of(base, shoulder, elbow, -60.0, 0.0),
    st.floats(-80, 80),
    st.floats(20, 90),
    st.floats(-120, -20),
)


@pytest.fixture(scope="module")
def ground():
    arm = ready_arm()
    arm.points["pick"] = Point(Joints.of(10.0, 50.0, -70.0, -60.0, 5.0))
    return ground_of(arm.parts, arm.points)


RELATIVE = st.one_of(
    st.builds(JointMove, NAMED, SPEEDS),
    st.builds(JointMove, POSTURES, SPEEDS),
    st.builds(PoseMove, st.just("pick"), SPEEDS),
    st.builds(LineMove, st.just("pick") | POSTURES, SPEEDS),
    st.builds(PoseMove, POSES, SPEEDS, FRAMES),
    st.builds(LineMove, POSES, SPEEDS, FRAMES),
    st.builds(ArcMove, POSES, POSES, SPEEDS, FRAMES),
    st.builds(PathMove, st.lists(PARTS, min_size=1, max_size=3).map(tuple), SPEEDS),
    st.builds(GripperMove, st.none() | st.floats(0.0, 70.0), SPEEDS),
)


@given(RELATIVE, PLACES, PLACES)
def test_a_resolved_move_means_the_same_from_anywhere(ground, move, here, there):
    resolved = resolve(move, ground.at(ArmCoordinates(here, 30.0)))
    assert resolve(resolved, ground.at(ArmCoordinates(there, 10.0))) == resolved


def test_a_change_that_is_resolved_is_made_once_however_often_it_is_run():
    arm = ready_arm()
    back = LineMove(Pose.of(x_mm=0, y_mm=0, z_mm=-20, pitch_deg=0), frame="tool")
    resolved = arm.preview(back).resolved
    arm.run(resolved)
    there = arm.status.acknowledged
    arm.run(resolved)
    assert arm.status.acknowledged == there
    arm.run(back)
    assert arm.status.acknowledged != there


def test_a_place_that_this_arm_does_not_have_is_named(ground):
    with pytest.raises(BadRequest, match="a goal for this arm needs the joints base, shoulder"):
        resolve(JointMove(Joints((1.0,), ("turret",))), ground)
    with pytest.raises(BadRequest, match="a saved point is a set of joint angles"):
        resolve(LineMove("pick", frame="tool"), ground)


# -- sequences --------------------------------------------------------------------------------

ABOVE, NEXT = (Pose.of(x_mm=220, y_mm=y, z_mm=120, pitch_deg=-80) for y in (0, 40))
BEYOND = Pose.of(x_mm=900, y_mm=0, z_mm=120, pitch_deg=-80)


@pytest.mark.parametrize(
    "last",
    [PoseMove(BEYOND), LineMove(BEYOND), GripperMove(500.0), GraspMove(900.0)],
)
def test_a_sequence_is_refused_whole_before_its_first_byte(last):
    arm = ready_arm()
    before, sent = arm.status.acknowledged, len(arm.twin.link.sent)
    with pytest.raises(ArmError):
        arm.run(MoveSequence((PoseMove(ABOVE), last)))
    assert arm.status.acknowledged == before
    assert len(arm.twin.link.sent) == sent
    assert not arm.preview(MoveSequence((PoseMove(ABOVE), last))).possible


def test_a_sequence_does_what_its_moves_do_one_after_another():
    one, other = ready_arm(), ready_arm()
    moves = (PoseMove(ABOVE), GripperMove(40.0), LineMove(NEXT, 0.5), JointMove({"base_deg": -5.0}))
    foreseen = one.preview(MoveSequence(moves))
    together = one.run(MoveSequence(moves))
    apart = [other.run(move) for move in moves]
    assert isinstance(together, Moved)
    assert one.status.acknowledged == other.status.acknowledged
    assert together.bursts >= sum(each.bursts for each in apart) - len(moves)
    assert foreseen.duration_s == pytest.approx(
        sum(plan.duration_s for plan in prepare(MoveSequence(moves), ready_ground()).plans)
    )


def ready_ground():
    return ground_of((arm := ready_arm()).parts, arm.points)


def test_a_stop_ends_all_of_a_sequence():
    arm = ready_arm()
    handle = arm.start(
        MoveSequence((JointMove({"base_deg": 30.0}), JointMove({"base_deg": -30.0})))
    )
    arm.sleep(0.4)
    arm.stop()
    with pytest.raises(ArmError, match="stopped"):
        handle.wait()
    standing = arm.status.acknowledged
    arm.sleep(3.0)
    assert arm.status.acknowledged == standing


def test_a_sequence_may_end_with_a_grasp_and_with_nothing_behind_it():
    arm = ready_arm()
    found = arm.run(MoveSequence((PoseMove(ABOVE), GraspMove())))
    assert isinstance(found, Grasped)
    with pytest.raises(BadRequest, match="last move"):
        MoveSequence((GraspMove(), PoseMove(ABOVE)))
    with pytest.raises(BadRequest, match="cannot contain a jog"):
        MoveSequence((JogMove(Jog.joint(base=2)),))
    with pytest.raises(BadRequest, match="at least one move"):
        MoveSequence(())


def test_a_stop_that_came_since_a_move_was_decided_on_keeps_it_from_beginning():
    arm = ready_arm()
    decided, sent = arm.stops, len(arm.twin.link.sent)
    arm.stop()
    with pytest.raises(ArmError, match="before the motion started"):
        arm.start(JointMove({"base_deg": 30.0}), stops=decided)
    assert arm.twin.link.named(b"@STEP") == []
    assert len(arm.twin.link.sent) >= sent
    arm.run(JointMove({"base_deg": 10.0}))


def test_a_park_rises_first_where_the_table_is_in_the_way():
    arm = ready_arm()
    low = Pose.of(x_mm=330, y_mm=0, z_mm=1, pitch_deg=0)
    arm.move_to(replace(low, z_mm=60.0))
    arm.move_l(low)
    straight = arm.preview(PoseMove(park_pose(arm.config)))
    assert "below the table" in str(straight.problem)
    rise, park = arm.preview(ParkMove()).resolved.moves
    assert isinstance(rise, LineMove)
    assert (rise.goal.x_mm, rise.goal.y_mm) == (
        pytest.approx(low.x_mm, abs=1.0),
        pytest.approx(low.y_mm, abs=1.0),
    )
    assert rise.goal.z_mm > low.z_mm + 10.0
    assert park == PoseMove(park_pose(arm.config))
    arm.park()
    assert arm.pose.z_mm == pytest.approx(park.goal.z_mm, abs=1.0)


def test_an_increment_is_foreseen_and_run_as_far_as_the_bounds_allow():
    arm = ready_arm()
    move = JogMove(Jog.joint(base=400.0), 1.0)
    foreseen = arm.preview(move)
    jogged = arm.run(move)
    assert isinstance(jogged, Jogged)
    assert "ended" in jogged.note or "limit" in jogged.note
    assert foreseen.end.base_deg == pytest.approx(jogged.joints.base_deg, abs=0.2)
    assert arm.start(JogMove(Jog.joint(base=-2.0))).wait().joints.base_deg < jogged.joints.base_deg


@pytest.mark.parametrize(
    ("jog", "kind"), [(Jog.joint(elbow=2.0), JointMove), (Jog.cartesian(z=5.0), LineMove)]
)
def test_an_increment_is_resolved_to_the_motion_that_it_makes(jog, kind):
    arm = ready_arm()
    resolved = arm.preview(JogMove(jog)).resolved
    assert type(resolved) is kind
    assert arm.run(JogMove(jog)).joints.deg == pytest.approx(resolved.goal.deg, abs=0.3)


# -- one JSON ---------------------------------------------------------------------------------


@every_row(
    "axes",
    [
        {"x_mm": 1},
        {"gripper_mm": 1},
        {"pitch_deg": 1},
        {"wrist_pitch_deg": 1},
    ],
)
def test_an_increment_in_the_place_of_a_direction_is_named_with_the_way_out(axes):
    axis = next(iter(axes)).rpartition("_")[0]
    said = f"needs directions from -1 to 1: write {axis}=1, or leave out duration_s"
    with pytest.raises(BadRequest, match=said):
        jog_axes(axes, in_steps=False)
    assert jog_axes(axes, in_steps=True) == jog_axes({axis: 1}, in_steps=False) == ((axis, 1),)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_the_status_of_every_dialect_has_the_published_form(dialect):
    with Arm.connect(f"sim:{dialect}") as arm:
        valid("status", status_view(arm.status))
        as_it_stands(arm)
        valid("status", status_view(arm.status))


@pytest.mark.parametrize(
    "error", [OutOfBounds("no", name="a", value=1.0, bound=0.0), Refused("no")]
)
def test_an_error_has_the_published_form(error):
    valid("error", error_view(error))
