"""Closed forms against other people's: EAIK's branches, and poses of the Robotics Toolbox."""

import warnings

import pytest
from chain_cases import gap, turn_gap
from hypothesis import given
from hypothesis import strategies as st
from named_arms import ARMS

from kinematics.chains.closed_form import closed_form
from kinematics.chains.generated import generated
from kinematics.chains.goals import frame_goal
from kinematics.chains.jacobians import condition
from kinematics.chains.structure import axes_of
from kinematics.frames.transforms import position_of
from kinematics.frames.vectors import subtract

np = pytest.importorskip("numpy")
eaik = pytest.importorskip("eaik.IK_HP", reason="the oracle EAIK is not installed")

SIX = sorted(name for name, chain in ARMS.items() if len(chain) == 6)
angles = st.tuples(*[st.floats(-3.0, 3.0)] * 6)


def its_robot(chain):
    """The same arm by its axes; EAIK's last frame is not turned."""
    axes = axes_of(chain)
    points = [(0.0, 0.0, 0.0), *map(position_of, axes.frames), position_of(axes.hand)]
    ways = [subtract(points[index + 1], points[index]) for index in range(len(points) - 1)]
    directions = [(frame[0][2], frame[1][2], frame[2][2]) for frame in axes.frames]
    return eaik.HPRobot(np.array(directions), np.array(ways)), np.array(axes.hand)


@pytest.mark.parametrize("name", SIX)
@given(values=angles)
def test_eaik_finds_no_posture_that_is_not_found_here(name, values):
    chain = ARMS[name]
    if condition(chain, values).smallest < 1e-3:
        return
    robot, hand = its_robot(chain)
    frame = np.array(chain.fk(values))
    asked = frame.copy()
    asked[:3, :3] = frame[:3, :3] @ hand[:3, :3].T
    theirs = robot.IK(asked)
    found = closed_form(chain).branches(frame_goal(chain.fk(values)), values)
    for one, rough in zip(theirs.Q, theirs.is_LS, strict=True):
        posture = tuple(map(float, one))
        if rough or gap(generated(chain).fk(posture), frame.tolist()) > 1e-6:
            continue
        if condition(chain, posture).smallest < 1e-3:
            continue
        assert min(turn_gap(posture, each) for each in found) < 1e-5


with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # the library's own imports warn
    pinocchio = pytest.importorskip("pinocchio", reason="the oracle pinocchio is not installed")


@pytest.mark.parametrize("name", SIX)
@given(values=angles)
def test_pinocchio_confirms_where_every_posture_holds_the_hand(name, values):
    chain = ARMS[name]
    axes = axes_of(chain)
    model, parent, before = pinocchio.Model(), 0, pinocchio.SE3.Identity()
    for index, frame in enumerate(axes.frames):
        placed = pinocchio.SE3(np.array(frame))
        joint = pinocchio.JointModelRZ()
        parent = model.addJoint(parent, joint, before.actInv(placed), f"joint_{index}")
        before = placed
    hand = before.actInv(pinocchio.SE3(np.array(axes.hand)))
    data = model.createData()
    frame = chain.fk(values)
    for one in closed_form(chain).branches(frame_goal(frame), values):
        pinocchio.forwardKinematics(model, data, np.array(one))
        held = (data.oMi[parent] * hand).homogeneous
        assert gap(held.tolist(), frame) < 2e-5
