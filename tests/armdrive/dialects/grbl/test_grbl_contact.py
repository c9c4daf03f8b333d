"""A driven GRBL board apart from motion: contact, alarms, resets, settings, outputs."""

import re
from dataclasses import replace

import pytest
from amounts import each_value
from faults import (
    OVER_THE_TABLE,
    Rule,
    as_it_stands,
    becoming,
    garbled,
    instead,
    lost,
    without_byte,
)
from grbl_arm import (
    FIRMWARES,
    Disturbed,
    config,
    found,
    over,
    ready,
    standing_as_said,
)

from armdrive import Arm, Jog
from armdrive.connect.parts import assemble, connect_simulated
from armdrive.errors import DeviceFault, NoAnswer, PendantStop, Refused, SettingsDiffer
from armdrive.registry import simulate
from armdrive.runtime.clock import SimulatedPace
from armdrive.sim.mechanics.motors import SwitchState
from armdrive.sim.simulated_arm import link_to
from armdrive.status import State, Trust

HOLD_PIN = 2


# -- First contact: nothing that another program left is carried out -------------------------------

HALF_LINES = ["", "G1G91X10F300", "G1G91X10F300(a", "G1G91X10F300 (a) Y", "$J=G91X10F300", "$H"]
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


@each_value("half, firmware", [*HALF_LINES, IN_A_COMMENT], FIRMWARES)
def test_no_half_line_is_carried_out_and_position_current_and_state_are_kept(firmware, half):
    said = ["$X\n", "G1G91X7F600\n", half]
    check_kept(*left(config(), said, firmware=firmware, homing=True))


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_no_line_that_waits_in_a_hold_is_carried_out_when_an_arm_connects(firmware):
    """FluidNC reads one line while it stands in a hold, and a reset carries that line out."""
    said = ["G1G91X7F600\n", "!", "G1G91X10F300\nG1G91X20F300\n"]
    check_kept(*left(config(), said, firmware=firmware))


def check_kept(arm, before):
    """Check that contact has carried out nothing that was left in the board, and that it moves."""
    arm.sleep(3.0)
    assert now(arm) == before
    assert before[2][0] == 7
    assert arm.status.read_back[0] == 7
    assert arm.status.state is State.STANDBY
    assert arm.twin.world.energised
    arm.move_motors(3, 0, 0, 0, 0, 0)
    assert arm.twin.device.registers[0] == 10


@pytest.mark.parametrize("half", ["", HALF_LINES[2], IN_A_COMMENT])
def test_a_locked_board_stays_locked_until_a_reset_and_forgets_a_half_line(half):
    arm, before = left(config(), ["G1G91X7F600\n", half], homing=True)
    with pytest.raises(DeviceFault, match="reset"):  # the board was locked, and still is
        arm.move_motors(1, 0, 0, 0, 0, 0)
    arm.reset()
    arm.sleep(3.0)
    assert now(arm) == before
    assert arm.status.state is State.STANDBY
    arm.move_motors(1, 0, 0, 0, 0, 0)


GRIPPERS = [
    ("servo", {}, "M3S1000"),
    ("output", {"gripper_closes": False}, "M8"),
    ("output", {"gripper_closes": False, "outputs": ("mist",)}, "M7"),
    ("servo", {"servo": "M67E0"}, "M67E0Q1000"),
    ("output", {"gripper_closes": False, "outputs": ("P1",)}, "M64P1"),
]


@each_value("gripper, half", GRIPPERS, HALF_LINES)
def test_contact_does_not_let_go_of_what_a_gripper_on_an_output_holds(gripper, half):
    kind, device, opens = gripper
    firmware = "grblhal" if opens.startswith("M6") else "mega5x"
    made = config(gripper=kind, device=device)
    arm, before = left(made, [opens + "\n", half], firmware=firmware)
    arm.sleep(6.0)  # the fingers take four seconds to close
    assert now(arm) == before
    assert before[1] == pytest.approx(76.0, abs=1.0)


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_connecting_ends_a_jog_and_an_echo_that_another_program_left(firmware):
    twin = simulate(config(), firmware=firmware)
    before = twin.world.motors
    twin.link.write(b"\x0b\n$J=G91F3000X2000\n", 0.0)
    twin.link.read(1.0)
    assert twin.device.moving
    arm = Arm(connect_simulated(config(), twin=twin))
    arm.sleep(1.0)
    assert not arm.twin.device.moving
    assert 0 < (arm.twin.world.motors - before).largest < 400
    assert arm.twin.board.details()["state"] == "Idle"
    garbled_lines = arm.parts.core.controller.board.garbled
    arm.move_motors(3, 0, 0, 0, 0, 0)
    assert arm.parts.core.controller.board.garbled == garbled_lines


def test_a_board_asleep_is_woken_by_connecting_and_moves_nothing():
    arm = found()
    arm.disable()
    arm.sleep(1.0)  # meanwhile the arm sags
    arm.close()
    before = arm.twin.world.motors
    twin = replace(arm.twin, link=Disturbed(link_to(arm.twin.device)))
    again = Arm(connect_simulated(arm.config, twin=twin))
    assert again.status.state is State.STANDBY
    assert twin.world.motors == before
    assert twin.link.pressed(b"\x90")  # an override would break the announced bounds


def test_a_board_that_never_answers_is_reported():
    made = config()
    twin = simulate(made)
    link = Disturbed(twin.link)
    link.to.append(Rule(b"", lost, times=1e9))
    with pytest.raises(NoAnswer, match="switched on"):
        connect_simulated(made, twin=replace(twin, link=link))
    assert not link.motions


@each_value("firmware, letters", FIRMWARES, ["XYZABC", "XZYBA", "XYZAC"])
def test_a_board_may_have_more_axes_than_the_arm_has_motors_but_not_fewer(firmware, letters):
    made = config(gripper="servo", device={"axes": letters})
    arm = ready(made, firmware=firmware, axes="XYZABC")
    assert arm.parts.core.differences == ()
    arm.move_motors(5, -4, 3, -2, 1)
    assert arm.twin.world.motors == arm.status.acknowledged == arm.status.read_back
    few = simulate(config(gripper="servo", device={"axes": "XYZAB"}), firmware=firmware)
    with pytest.raises(DeviceFault, match=r"the board has 5 axes \(XYZAB\).* on C:"):
        connect_simulated(config(), twin=few)


def test_axis_letters_that_were_damaged_are_asked_for_again():
    for letters in (b"XYZABV", b"XYZABQ", b""):
        arm = over(Rule(rb"\[AXS", instead(b"[AXS:6:" + letters + b"]\r\n")), firmware="mega5x")
        assert arm.status.state is State.STANDBY


@pytest.mark.parametrize(
    ("firmware", "wanted", "named"),
    [
        ("grbl", 9, "Grbl 1.1h.20190830"),
        ("mega5x", 9, "Grbl 1.1q.20210103"),
        ("grblhal", 9, "GrblHAL 1.1f.20260817"),
        ("fluidnc", 11, "4.0 FluidNC v4.0.5-pre2 (esp32-wifi)"),
    ],
)
def test_the_firmware_is_named_and_so_are_the_segments_that_it_computes_ahead(
    firmware, wanted, named
):
    arm = found(firmware=firmware)
    assert arm.parts.core.controller.board.segment_buffer.segments == wanted
    assert arm.controller.fix_settings([]).firmware == named
    told = found(config(device={"segments": 20}), firmware=firmware)
    assert told.parts.core.controller.board.segment_buffer.segments == 20
    assert told.status.stop_time_s > arm.status.stop_time_s


def test_a_firmware_that_is_not_read_without_a_flaw_counts_as_the_slowest():
    for times, wanted in ((1, 9), (99, 11)):
        arm = over(Rule(rb"\[FIRMWARE", garbled(4, 0x7F), times=times), firmware="grblhal")
        assert arm.parts.core.controller.board.segment_buffer.segments == wanted


# -- Alarms, holds and greetings -------------------------------------------------------------------


def run_into_a_switch(arm):
    """End a motion of the base by a limit switch, which is free again afterwards."""
    handle = arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.6)
    arm.twin.board.set_switch(0, SwitchState.CLOSED)
    with pytest.raises(DeviceFault, match="alarm 1"):
        handle.wait(8.0)
    arm.twin.board.set_switch(0, SwitchState.FREE)


def test_a_board_that_starts_locked_because_a_switch_is_pressed_says_which():
    made = config(device={"hard_limits": True})
    twin = simulate(made, firmware="mega5x")
    twin.board.set_switch(1, SwitchState.CLOSED)
    arm = Arm(connect_simulated(made, twin=twin))
    locked = r"locked.*limit switch is pressed \(Y\).*`reset\(\)`"
    assert re.search(locked, arm.status.notice)
    assert arm.status.notice_code == "E506"
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    with pytest.raises(DeviceFault, match=locked):
        arm.move_j(base_deg=3)
    arm.reset()
    assert not arm.status.notice
    arm.move_j(base_deg=3)


@pytest.mark.parametrize("code", [1, 2])
def test_an_alarm_while_connecting_latches_no_error_but_is_said(code):
    """After ALARM:2 the board vouches for its position, after ALARM:1 it does not."""
    arm = over(Rule(rb"\$0=", instead(b"ALARM:%d\r\n" % code)))
    assert (arm.status.state, arm.status.error) == (State.STANDBY, "")
    assert f"the board is in alarm {code}" in arm.status.notice
    assert arm.status.notice_code


@pytest.mark.parametrize(
    ("firmware", "homing"),
    [("grbl", False), ("grblhal", False), ("fluidnc", True), ("fluidnc", False)],
)
def test_a_limit_alarm_makes_the_position_suspect_and_is_left_by_a_reset(firmware, homing):
    """GRBL is mute then. FluidNC raises another alarm, or reports a motion that it does not do."""
    arm = found(config(device={"hard_limits": True, "homing": homing}), firmware=firmware)
    arm.reset()  # with homing it boots locked
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    run_into_a_switch(arm)
    assert "even if the cable is fine" in arm.status.error
    motors = arm.twin.world.motors
    arm.reset()
    arm.sleep(1.0)
    if firmware == "fluidnc":  # the others sag until the reset
        assert arm.twin.world.motors == motors
    assert (arm.status.state, arm.status.trust) == (State.STANDBY, Trust.SUSPECT)


def test_a_limit_alarm_whose_message_is_lost_ends_the_motion():
    arm = ready(config(device={"hard_limits": True}), firmware="grblhal")
    arm.twin.link.back.append(Rule(rb"ALARM", lost))
    handle = arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.6)
    arm.twin.board.set_switch(0, SwitchState.CLOSED)
    with pytest.raises(DeviceFault, match="locked by an alarm"):
        handle.wait(8.0)
    assert arm.status.trust is Trust.SUSPECT


def test_a_limit_alarm_of_an_arm_that_stands_makes_its_position_suspect():
    arm = ready(config(device={"hard_limits": True}), firmware="grbl")
    arm.twin.board.set_switch(0, SwitchState.CLOSED)
    arm.sleep(2.0)
    assert (arm.status.state, arm.status.trust) == (State.ERROR_STOP, Trust.SUSPECT)


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_a_late_feed_hold_does_not_keep_the_arm_in_its_error(firmware):
    for later_s in (0.001, 0.005, 0.009):
        arm = ready(firmware=firmware)
        arm.estop()
        arm.sleep(2.0)
        arm.twin.device.set_input(HOLD_PIN, on=True)
        assert arm.twin.board.state == "Hold"
        resets = 2 if firmware == "fluidnc" else 1  # the last one is followed by the hold
        late = Rule(
            rb"\x18", lambda message, s=later_s: [(0.0, message), (s, b"!")], skip=resets - 1
        )
        arm.twin.link.to.append(late)
        arm.reset()
        assert not late.times
        assert arm.status.state is State.STANDBY


@each_value("firmware, later_s", FIRMWARES, [0.0, 0.015, 0.03])
def test_a_stop_key_stops_the_arm_for_good_and_keeps_its_position(firmware, later_s):
    """Also when it is pressed as a line arrives."""
    arm = ready(firmware=firmware)
    handle = arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.5 + later_s)
    arm.twin.device.set_input(HOLD_PIN, on=True)
    seen = []
    for _ in range(300):
        arm.sleep(0.005)
        seen.append(str(arm.twin.board.state))
    assert "Run" not in seen[seen.index("Hold") :]
    with pytest.raises(PendantStop):
        handle.wait()
    arm.twin.device.set_input(HOLD_PIN, on=False)
    assert arm.status.trust is Trust.REFERENCED
    assert standing_as_said(arm)
    arm.reset()
    arm.move_j(base_deg=0)
    assert standing_as_said(arm)


def at_zeros(**options):
    """Return an arm whose counts are zero, so that only the greeting shows a reset."""
    arm = as_it_stands(found(**options))
    assert not arm.twin.device.registers.largest
    arm.twin.link.sent.clear()
    return arm


@each_value("firmware, after_s", FIRMWARES, [0.006, 0.012])
def test_a_greeting_that_comes_late_is_no_answer_to_a_stop(firmware, after_s):
    """The board's own button is pressed just as the driver sends its reset."""
    arm = at_zeros(firmware=firmware)
    handle = arm.move_j(base_deg=40, wait=False)
    arm.sleep(after_s)
    arm.twin.link.to.append(Rule(rb"\x18", lambda _: arm.twin.board.reset() or []))
    arm.stop()
    arm.sleep(3.0)
    assert handle.done
    assert arm.twin.link.pressed(b"\x18") == 1
    assert (arm.status.state, arm.status.trust) == (State.ERROR_STOP, Trust.SUSPECT)
    assert "reset, or lost its power" in arm.status.error
    arm.reset()
    assert arm.status.state is State.STANDBY


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_a_greeting_in_time_keeps_the_position_and_a_second_one_does_not(firmware):
    for after_s in (0.003, 0.2, 0.6):
        arm = at_zeros(firmware=firmware)
        arm.move_j(base_deg=40, wait=False)
        arm.sleep(after_s)
        arm.stop()
        arm.sleep(2.0)
        assert arm.status.trust is Trust.REFERENCED
        assert standing_as_said(arm)
    arm.twin.board.reset()
    arm.sleep(2.0)
    assert arm.status.trust is Trust.SUSPECT


def test_a_greeting_that_was_lost_is_not_awaited_for_ever():
    arm = at_zeros()
    arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.3)
    arm.twin.link.back.append(Rule(rb"Grbl", without_byte(2)))
    arm.estop()
    arm.sleep(4.0)
    arm.reset()
    as_it_stands(arm)
    arm.move_motors(*(-count for count in arm.twin.device.registers))
    arm.twin.board.reset()  # its counts were zero, and are zero again
    arm.sleep(2.0)
    assert arm.status.trust is Trust.SUSPECT


def test_a_greeting_of_a_silent_board_during_its_reset_makes_it_suspect():
    arm = at_zeros()
    arm.estop()
    arm.sleep(0.6)
    assert arm.status.trust is Trust.REFERENCED
    arm.twin.board.reset()  # its start takes longer than the timeout of a report
    arm.reset()
    assert (arm.status.state, arm.status.trust) == (State.STANDBY, Trust.SUSPECT)


def test_a_board_that_resets_while_it_is_stopped_is_no_kept_position():
    arm = at_zeros()
    arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.1)
    arm.twin.board.reset()
    with pytest.raises(NoAnswer):
        arm.stop()
    assert arm.status.trust is Trust.SUSPECT


# -- Settings --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("firmware", "fixes"),
    [
        ("mega5x", {"$1=255", "$10=3", "$100=1", "$105=1", "$11=1"}),
        (
            "fluidnc",
            {
                "$/stepping/idle_ms=255",
                "$10=3",
                "$/axes/x/steps_per_mm=1",
                "$/junction_deviation_mm=1",
            },
        ),
    ],
)
def test_a_board_from_the_factory_moves_nothing_until_it_is_mended(firmware, fixes):
    arm = found(factory=True, firmware=firmware)
    motors = arm.twin.world.motors
    assert {each.fix for each in arm.parts.core.differences} >= fixes
    arm.jogging.hold(Jog.joint(base=1.0), speed=0.1, for_s=0.2)
    arm.sleep(1.0)
    assert arm.status.notice_code == "E206"
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    with pytest.raises(SettingsDiffer, match=r"idle_ms=255|\$1=255"):
        arm.move_j(base_deg=3)
    assert arm.twin.world.motors == motors
    arm.controller.fix_settings()
    assert arm.parts.core.differences == ()
    arm.move_j(base_deg=3)
    assert standing_as_said(arm)


def test_a_board_that_reports_no_machine_position_says_what_to_set():
    made = config()
    twin = simulate(made)
    twin.board.settings.values[10] = 2.0
    with pytest.raises(DeviceFault, match=r"send `\$10=3`"):
        connect_simulated(made, twin=twin)


@pytest.mark.parametrize(("number", "what"), [(110, "highest rate"), (121, "acceleration")])
def test_an_axis_that_its_settings_keep_from_ever_arriving_moves_nothing(number, what):
    """grbl-Mega-5X and grblHAL accept the zero, and a motion of that axis never ends."""
    made = config()
    twin = simulate(made, firmware="mega5x")
    wanted, twin.board.settings.values[number] = twin.board.settings.values[number], 0.0
    arm = Arm(connect_simulated(made, twin=twin))
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    motors = twin.world.motors
    refusal = rf"the {what} of .*: a motion would never end\) is 0, expected .*`\${number}="
    for move in (lambda: arm.move_j(base_deg=3), lambda: arm.jog_j(base_deg=3)):
        with pytest.raises(SettingsDiffer, match=refusal):
            move()
    assert twin.world.motors == motors
    arm.controller.fix_settings([f"${number}={wanted}"])
    arm.move_j(base_deg=3)


def test_settings_only_in_fluidncs_file_are_reported_and_not_sent():
    arm = found(config(device={"hard_limits": True}), factory=True, firmware="fluidnc")
    arm.controller.fix_settings()
    (left_over,) = arm.parts.core.differences
    assert str(left_over).startswith("$21 (hard limits, in the board's configuration file) is 0")
    assert left_over.fix == ""


def test_a_line_that_writes_no_setting_is_not_sent():
    arm = ready()
    motors = arm.twin.world.motors
    for line in ("$J=G91X9F99", "$H", "$/a=G1X9", "$N0=G0X9", "$RST=*", "$X", "$100", "G0X9"):
        with pytest.raises(Refused, match="is not a GRBL setting"):
            arm.controller.fix_settings([line])
    arm.sleep(1.0)
    assert not any(
        piece.startswith((b"$J", b"$H", b"$N", b"G0")) for piece in arm.twin.link.messages
    )
    assert arm.twin.world.motors == motors


def test_a_setting_that_lost_a_byte_on_the_wire_keeps_no_arm_from_moving():
    """A difference counts only if it is read twice; a damaged `$100=` changes $10."""
    arm = over(Rule(rb"\$100=", becoming(lambda line: line.replace(b"$100", b"$10", 1))))
    assert arm.parts.core.differences == ()
    arm.jog_j(base_deg=1.0)


# -- Outputs ---------------------------------------------------------------------------------------


def test_outputs_and_a_servo_come_back_after_a_stop():
    arm = ready(config(gripper="servo", device={"outputs": ("flood",)}))
    arm.gripper.open(76.0)
    arm.io.write(1)
    assert arm.twin.world.opening_mm == pytest.approx(76.0, abs=1.0)
    before = arm.twin.board.details()["outputs"]
    arm.move_j(base_deg=60, wait=False)
    arm.sleep(0.6)
    arm.stop()
    arm.sleep(0.5)
    assert arm.twin.board.details()["outputs"] == before
    with pytest.raises(Refused, match=r"grbl\.outputs"):
        arm.io.write(2)


@pytest.mark.parametrize(
    ("valve", "firmware", "closes"),
    [("mist", "mega5x", False), ("P0", "grblhal", True)],
)
def test_a_gripper_on_a_valve_opens_and_closes(valve, firmware, closes):
    device = {"outputs": ("flood", valve), "gripper_output": 1, "gripper_closes": closes}
    arm = ready(config(gripper="output", device=device), firmware=firmware)
    arm.gripper.open(76.0)
    assert arm.twin.world.opening_mm == pytest.approx(76.0, abs=1.0)
    arm.gripper.close(0.0)
    assert arm.twin.world.opening_mm == pytest.approx(0.0, abs=1.0)
