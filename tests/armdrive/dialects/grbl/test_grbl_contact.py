"""First contact with a GRBL board: the driver learns its axes, and nothing moves."""

import itertools
from dataclasses import replace

import pytest
from amounts import in_pairs
from faults import Rule, becoming, garbled, instead
from grbl_arm import FIRMWARES, Disturbed, config, found, ready

from armdrive.arm import Arm
from armdrive.connect.parts import assemble, connect_simulated
from armdrive.errors import DeviceFault
from armdrive.registry import simulate
from armdrive.runtime.clock import SimulatedPace
from armdrive.status import State

# The axes of the board.


@pytest.mark.parametrize("firmware", FIRMWARES)
@pytest.mark.parametrize("letters", ["XYZABC", "XZYBA", "XYZAC"])
def test_a_board_may_have_more_axes_than_the_arm_has_motors(firmware, letters):
    made = config(gripper="servo", device={"axes": letters})
    arm = ready(made, firmware=firmware, axes="XYZABC")
    assert arm.core.differences == ()
    arm.move_motors(5, -4, 3, -2, 1)
    assert arm.twin.world.motors == arm.status.acknowledged == arm.status.read_back


@pytest.mark.parametrize("banner", [True, False])
def test_the_axes_are_learnt_whether_the_board_begins_anew_or_not(banner):
    arm = found(config(gripper="servo"), firmware="fluidnc", axes="XYZABC")
    if banner:
        arm.twin.board.reset()
        arm.sleep(3.0)
        arm.reset()
    assert arm.status.state is State.STANDBY
    assert len(arm.status.read_back) == 5


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_a_board_with_too_few_axes_is_told_of_in_words(firmware):
    twin = simulate(config(gripper="servo", device={"axes": "XYZAB"}), firmware=firmware)
    with pytest.raises(DeviceFault, match=r"the board has 5 axes \(XYZAB\).* on C:"):
        connect_simulated(config(), twin=twin)


# A board that another program has used.

HALF_LINES = ["G1G91X10F300", "G1G91X10F300(a", "G1G91X10F300 (a) Y", "$J=G91X10F300", "$H", "$C"]
IN_A_COMMENT = "G1G91X10F300;a"


def left(made, said, **options):
    """Return an arm whose board another program has used, and the board's counts by then."""
    twin = simulate(made, **options)
    twin.link.read(0.05)
    for number, data in enumerate(said):
        twin.link.write(data.encode("latin-1"), 1.0 + 9.0 * number)
        twin.link.read(9.0 + 9.0 * number)
    before = twin.world.motors, twin.world.opening_mm, twin.device.registers
    pace = SimulatedPace()
    pace.clock.now_s = 9.0 * len(said)
    arm = Arm(assemble(made, twin.link, pace, simulated=True))
    arm.twin = twin
    return arm, before


def now(arm):
    return arm.twin.world.motors, arm.twin.world.opening_mm, arm.twin.device.registers


@pytest.mark.parametrize("half", ["", *HALF_LINES, IN_A_COMMENT])
def test_a_locked_board_stays_locked_until_a_reset_and_forgets_a_half_line(half):
    arm, before = left(config(), ["G1G91X7F600\n", half], homing=True)
    with pytest.raises(DeviceFault, match="reset"):  # the board was locked, and still is
        arm.move_motors(1, 0, 0, 0, 0, 0)
    arm.reset()
    arm.sleep(3.0)
    assert now(arm) == before
    assert before[2][0] == 0
    assert arm.status.state is State.STANDBY
    arm.move_motors(1, 0, 0, 0, 0, 0)


@pytest.mark.parametrize(
    ("firmware", "half"),
    [
        *(("grbl", half) for half in ["", *HALF_LINES, IN_A_COMMENT]),
        *itertools.product(FIRMWARES[1:], ["", "G1G91X10F300(a", "$J=G91X10F300"]),
    ],
)
def test_no_half_line_is_carried_out_and_position_current_and_state_are_kept(firmware, half):
    said = ["$X\n", "G1G91X7F600\n", half]
    arm, before = left(config(), said, firmware=firmware, homing=True)
    arm.sleep(3.0)
    assert now(arm) == before
    assert before[2][0] == 7
    assert arm.status.read_back[0] == 7
    assert arm.status.state is State.STANDBY
    assert arm.twin.world.energised
    arm.move_motors(3, 0, 0, 0, 0, 0)
    assert arm.twin.device.registers[0] == 10


GRIPPERS = [
    ("servo", {}, "M3S1000"),
    ("servo", {"servo": "M67E0"}, "M67E0Q1000"),
    ("output", {"gripper_closes": False}, "M8"),
    ("output", {"gripper_closes": False, "outputs": ("mist",)}, "M7"),
    ("output", {"gripper_closes": False, "outputs": ("P1",)}, "M64P1"),
]


@pytest.mark.parametrize("half", ["", "G1G91X10F300", "G1G91X10F300(a", "$H"])
@pytest.mark.parametrize(("kind", "device", "opens"), GRIPPERS)
def test_contact_does_not_let_go_of_what_a_gripper_on_an_output_holds(kind, device, opens, half):
    said = [opens + "\n", half]
    firmware = "grblhal" if opens.startswith("M6") else "mega5x"
    arm, before = left(config(gripper=kind, device=device), said, firmware=firmware)
    arm.sleep(3.0)
    assert now(arm) == before
    assert before[1] == pytest.approx(76.0, abs=1.0)


TOLD = [each for each in GRIPPERS if each[2].startswith(("M3", "M7", "M8"))]
WITH_COMMENTS = [IN_A_COMMENT, "$J=G91X10F300;a", "M3S700;a", "M8;", "$H;"]


@in_pairs("gripper, half, firmware", TOLD, WITH_COMMENTS, FIRMWARES)
def test_where_the_gripper_is_told_to_be_off_no_half_line_is_carried_out(gripper, half, firmware):
    kind, device, opens = gripper
    said = [opens + "\n", "M5\nM9\nG1G91X7F600\n", half]
    arm, before = left(config(gripper=kind, device=device), said, firmware=firmware)
    arm.sleep(3.0)
    assert now(arm) == before
    assert before[2][0] == 7
    outputs = arm.twin.board.details()["outputs"]
    assert (outputs["spindle"], outputs["flood"], outputs["mist"]) == ("M5", False, False)


def test_one_false_report_of_outputs_that_are_off_lets_go_of_nothing():
    made = config(gripper="servo")
    twin = simulate(made)
    twin.link.write(b"M3S1000\n", 0.1)
    twin.link.read(9.0)
    link = Disturbed(twin.link)
    link.back.append(Rule(rb"<.*\|A:S", becoming(lambda line: line.replace(b"|A:S", b"|C:S"))))
    pace = SimulatedPace()
    pace.clock.now_s = 9.0
    Arm(assemble(made, link, pace, simulated=True))
    assert not link.back[0].times
    assert not link.pressed(b"\x18")
    assert twin.board.details()["outputs"]["spindle"] == "M3"


# The delay before the board brakes.


def segments(arm):
    """Return the segments of 10 ms that the board may drive before it starts to brake."""
    return arm.core.controller.board.segment_buffer.segments


@pytest.mark.parametrize(
    ("firmware", "wanted"), [("grbl", 5), ("mega5x", 9), ("grblhal", 10), ("fluidnc", 12)]
)
def test_what_a_board_computes_ahead_is_that_of_its_firmware(firmware, wanted):
    assert segments(found(firmware=firmware)) == wanted
    told = found(config(device={"segments": 20}), firmware=firmware)
    assert segments(told) == 20
    assert told.status.stop_time_s > found(firmware=firmware).status.stop_time_s


@pytest.mark.parametrize(("times", "wanted"), [(1, 10), (2, 10), (99, 12)])
def test_a_firmware_that_is_not_read_without_a_flaw_counts_as_the_slowest(times, wanted):
    made = config()
    twin = simulate(made, firmware="grblhal")
    link = Disturbed(twin.link)
    link.back.append(Rule(rb"\[FIRMWARE", garbled(4, 0x7F), times=times))
    arm = Arm(connect_simulated(made, twin=replace(twin, link=link)))
    assert segments(arm) == wanted


# A damaged answer to `$I`: a line has no checksum.


def disturbed_build(pattern, changed, times=1, **options):
    made = config()
    twin = simulate(made, **options)
    link = Disturbed(twin.link)
    link.back.append(Rule(pattern, instead(changed), times=times))
    return Arm(connect_simulated(made, twin=replace(twin, link=link)))


@pytest.mark.parametrize("ring", [b"2", b"12", b"28", b"0", b"65536"])
def test_no_ring_that_is_told_brings_a_motion_to_wait_for_ever(ring):
    arm = disturbed_build(rb"\[OPT", b"[OPT:V,15," + ring + b"]\r\n", 99, firmware="grbl")
    arm.declare_posture(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)
    arm.move_j(base_deg=10, elbow_deg=arm.joints.deg["elbow"] + 5, wait=False).wait(20.0)
    assert arm.twin.world.motors == arm.status.read_back


def test_a_letter_that_was_damaged_is_asked_for_again():
    arm = disturbed_build(rb"\[AXS", b"[AXS:6:XYZABV]\r\n", firmware="mega5x")
    assert arm.status.state is State.STANDBY


def test_a_line_for_which_there_is_never_room_ends_the_motion_in_words():
    arm = ready()
    arm.core.controller.board.blocks = 0
    with pytest.raises(DeviceFault, match="makes no progress"):
        arm.move_j(base_deg=3, wait=False).wait(20.0)
