"""Stray characters in a GRBL board's input line: the board executes no damaged line."""

import pytest
from faults import Rule, instead, lost, without_byte
from grbl_arm import config, found, ready, standing_as_said

from armdrive.errors import DeviceFault
from armdrive.status import State, Trust

SPOILER = b"))GG\n"
FLIPPED = [bytes([ord("?") ^ 1 << bit]) for bit in range(7)]
OTHERS = [b"(", b"$", b"G", b"X", b"M", b"%", b"0", b"~", b"$H", b"\r"]


def changed_poll(arm, to):
    """Damage the next `?` on the idle wire."""
    arm.sleep(1.0)
    arm.twin.link.to.append(Rule(rb"\?", instead(to)))
    arm.sleep(1.0)
    assert not any(rule.times for rule in arm.twin.link.to)
    arm.twin.link.sent.clear()


def spoilers(arm):
    return sum(piece == SPOILER for _, piece in arm.twin.link.sent)


@pytest.mark.parametrize("to", [*FLIPPED, *OTHERS], ids=repr)
def test_a_poll_that_was_changed_on_the_idle_wire_spoils_no_motion(to):
    arm = ready()
    changed_poll(arm, to)
    arm.move_j(base_deg=3, shoulder_deg=41)
    assert standing_as_said(arm)
    assert arm.status.trust is Trust.REFERENCED
    assert spoilers(arm) >= 1
    arm.twin.link.sent.clear()
    arm.jog_j(base_deg=2)
    assert standing_as_said(arm)
    assert spoilers(arm) == 0


@pytest.mark.parametrize("to", FLIPPED[::3], ids=repr)
def test_nor_a_jog_an_output_or_a_servo(to):
    arm = ready(config(gripper="servo"))
    changed_poll(arm, to)
    arm.jog_j(base_deg=2)
    changed_poll(arm, to)
    arm.set_outputs(1)
    changed_poll(arm, to)
    arm.gripper.open(76.0)
    assert standing_as_said(arm)
    assert arm.twin.board.details()["outputs"]["flood"]
    assert arm.twin.world.opening_mm == pytest.approx(76.0, abs=1.0)
    assert arm.status.state is State.STANDBY


def test_on_a_wire_that_is_well_nothing_more_is_said():
    arm = ready()
    for _ in range(3):
        arm.sleep(2.0)
        arm.move_j(base_deg=arm.joints.deg["base"] + 3)
    assert spoilers(arm) == 0


@pytest.mark.parametrize(
    ("noise", "gripper"),
    [(b"7", None), (b">", None), (b"$", None), (b"G", None), (b"X", None), (b"7", "servo")],
)
def test_a_line_that_noise_has_spoiled_is_refused_and_the_position_is_still_known(noise, gripper):
    arm = ready(config(gripper=gripper))
    arm.move_j(base_deg=1)  # sets the board's modes
    before = arm.twin.world.motors
    arm.twin.link.inner.write(noise, arm.status.time_s)
    with pytest.raises(DeviceFault, match="refused"):
        arm.move_j(base_deg=25, shoulder_deg=48)
    assert arm.status.trust is Trust.REFERENCED
    assert arm.twin.world.motors == before
    arm.reset()
    arm.move_j(base_deg=25, shoulder_deg=48)
    assert standing_as_said(arm)


@pytest.mark.parametrize("noise", [b";", b"("])
def test_a_line_that_noise_has_made_a_comment_leaves_no_false_position(noise):
    arm = ready()
    arm.move_j(base_deg=1)
    arm.twin.link.inner.write(noise, arm.status.time_s)
    try:
        arm.move_j(base_deg=25, shoulder_deg=48)
    except DeviceFault:
        arm.reset()
    assert arm.status.trust is not Trust.REFERENCED or standing_as_said(arm)


@pytest.mark.parametrize("disturbed", ["the line loses its end", "its ok is late"])
def test_a_disturbed_line_is_neither_carried_out_with_the_next_one_nor_answers_it(disturbed):
    arm = ready()
    if disturbed == "its ok is late":
        arm.twin.faults.add("delay", 1.1, "next", side="device")
    else:
        arm.twin.link.to.append(Rule(rb"M8", without_byte(-1)))
    with pytest.raises(DeviceFault):
        arm.set_outputs(1)
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    arm.move_j(base_deg=5)
    assert standing_as_said(arm)
    if disturbed == "its ok is late":
        assert arm.status.trust is Trust.REFERENCED
    else:
        assert not arm.twin.board.details()["outputs"]["flood"]


def test_a_spoiler_that_is_lost_is_said_again():
    arm = ready()
    changed_poll(arm, b"7")
    arm.twin.link.to.append(Rule(rb"\)\)GG", lost))
    arm.move_j(base_deg=5)
    assert standing_as_said(arm)
    assert arm.status.trust is Trust.REFERENCED


def test_contact_leaves_a_clean_line():
    arm = found()
    assert not arm.core.controller.board.polls.stray
