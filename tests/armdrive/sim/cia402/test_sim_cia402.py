"""Simulated CiA 402 drives: they move as the profile says, and talk as CiA 301 says."""

import json

import pytest
from amounts import every_row
from bus_sim import IDS
from cia402_sim import (
    CSP,
    ENABLE,
    HOMING,
    MASTER,
    ORDER,
    PERIOD_S,
    PP,
    QUICK_STOP,
    TURN,
    Bench,
    arm_config,
    setups,
)

from armdrive.config.sections import HomingSettings
from armdrive.errors import BadRequest
from armdrive.registry import simulate
from armdrive.sim.cia402.objects import dictionary
from armdrive.sim.mechanics.motors import SwitchState
from firmware_protocol import canopen
from firmware_protocol.canopen import (
    AbortCode,
    DriveState,
    NodeState,
    Place,
    QuickStopOption,
    StatusBit,
)
from firmware_protocol.frames import Frame
from kinematics import Motors

GO = ENABLE | canopen.ControlBit.NEW_SET_POINT | canopen.ControlBit.AT_ONCE
RATE, UP, DOWN = 10_000, 20_000, 40_000
LATE_S, BOOT_S = 0.02, 0.5
METHOD, OFFSET, PERIOD = Place(0x6098), Place(0x607C), Place(0x60C2, 1)
HOMED = StatusBit.REACHED | StatusBit.ACKNOWLEDGED
HOLDS = QuickStopOption.QUICK_RAMP_AND_STAY


def in_profile(bench: Bench) -> Bench:
    """Enable the first drive in profile position mode."""
    bench.enable(1, mode=PP)
    for place, value in (
        (canopen.PROFILE_SPEED, RATE),
        (canopen.PROFILE_ACCELERATION, UP),
        (canopen.PROFILE_DECELERATION, DOWN),
        (canopen.QUICK_STOP_OPTION, HOLDS),
    ):
        bench.write(1, place, value)
    return bench


def in_cycles(bench: Bench) -> Bench:
    """Enable the first drive in cyclic position mode."""
    bench.set_up(1)
    bench.enable(1)
    return bench


def hand_over(bench, target):
    bench.write(1, canopen.TARGET_POSITION, target)
    bench.write(1, canopen.CONTROLWORD, GO)
    bench.write(1, canopen.CONTROLWORD, ENABLE)


def drive_along(bench, targets, *, beating=False):
    for target in targets:
        if beating:
            bench.beat()
        bench.order(1, ENABLE, CSP, target)
        bench.sync()


def emergencies(frames, node=1):
    return [canopen.Emergency.read(frame).code for frame in frames if frame.can_id == 0x80 + node]


def beats(frames, node=1):
    return [canopen.Heartbeat.read(frame).state for frame in frames if frame.can_id == 0x700 + node]


# -- the state machine ----------------------------------------------------------------------------


def test_enabling_holds_every_shaft_where_it_is_and_disabling_lets_the_arm_sag():
    bench = Bench()
    assert bench.state(1).state is DriveState.DISABLED
    assert not bench.world.energised
    before = bench.world.motors
    bench.enable(*IDS, mode=PP)
    assert bench.state(6).state is DriveState.ENABLED
    assert bench.world.energised
    assert bench.world.motors == before
    bench.write(2, canopen.CONTROLWORD, 0)
    assert bench.state(2).state is DriveState.DISABLED
    assert bench.world.motors[1] != before[1]
    assert bench.count(2) == bench.world.motors[1] - before[1]


@every_row("option, ends", [(QuickStopOption.QUICK_RAMP, DriveState.DISABLED),
                            (QuickStopOption.DISABLE, DriveState.DISABLED),
                            (HOLDS, DriveState.QUICK_STOP)])  # fmt: skip
def test_a_quick_stop_ends_as_its_option_says(option, ends):
    bench = in_profile(Bench())
    bench.write(1, canopen.QUICK_STOP_OPTION, option)
    hand_over(bench, 10 * TURN)
    bench.run(1.0)
    bench.write(1, canopen.CONTROLWORD, QUICK_STOP)
    bench.run(0.1)
    assert bench.state(1).state is ends
    assert bench.board.nodes[0].motor.holding is ends.holds
    there = bench.count(1)
    bench.run(1.0)
    assert bench.count(1) == there


def test_a_quick_stop_goes_by_its_ramp_and_is_led_out_of_without_moving():
    bench = in_profile(Bench())
    bench.write(1, canopen.QUICK_STOP_DECELERATION, RATE)
    hand_over(bench, 10 * TURN)
    bench.run(1.5)
    begins = bench.count(1)
    bench.write(1, canopen.CONTROLWORD, QUICK_STOP)
    bench.run(0.9)
    assert not bench.state(1).has(StatusBit.REACHED)
    bench.run(0.2)
    assert bench.state(1).has(StatusBit.REACHED)
    there = bench.count(1)
    assert there - begins == pytest.approx(RATE / 2, abs=RATE * LATE_S)
    bench.write(1, canopen.CONTROLWORD, ENABLE)
    bench.run(1.0)
    assert bench.state(1).state is DriveState.ENABLED
    assert bench.count(1) == there


@every_row("reaction, frees", [(0, True), (2, False)])
def test_a_drive_in_fault_brakes_first_unless_its_reaction_is_to_free_the_motor(reaction, frees):
    bench = in_profile(Bench())
    bench.write(1, canopen.FAULT_REACTION_OPTION, reaction)
    bench.write(1, canopen.QUICK_STOP_DECELERATION, RATE)
    hand_over(bench, 10 * TURN)
    bench.run(1.0)
    bench.board.put_in_fault(0, 0x4310)
    bench.run(0.5)
    assert bench.board.nodes[0].motor.holding is not frees
    bench.run(0.7)
    assert not bench.board.nodes[0].motor.holding


def test_a_fault_lasts_as_long_as_its_cause_and_is_reset_by_a_rising_edge():
    bench = in_profile(Bench())
    bench.twin.faults.add("drive-fault", "1", "4310")
    assert emergencies(bench.run()) == [0x4310]
    assert bench.read(1, canopen.ERROR_REGISTER) == 0x09
    bench.write(1, canopen.CONTROLWORD, 0x80)
    assert bench.state(1).state is DriveState.FAULT  # still too hot
    assert not bench.board.nodes[0].motor.holding
    bench.twin.faults.end()
    bench.write(1, canopen.CONTROLWORD, 0x80)
    assert bench.state(1).state is DriveState.FAULT  # no edge
    bench.write(1, canopen.CONTROLWORD, 0)
    bench.heard.clear()
    bench.write(1, canopen.CONTROLWORD, 0x80)
    assert emergencies(frame for _, frame in bench.heard) == [0]
    assert bench.state(1).state is DriveState.DISABLED
    assert bench.read(1, canopen.ERROR_CODE) == 0


def test_a_shaft_that_does_not_follow_is_a_fault_and_comes_down():
    bench = in_profile(Bench())
    bench.enable(2, mode=PP)
    bench.write(1, canopen.FOLLOWING_ERROR_WINDOW, 500)
    bench.write(1, canopen.FOLLOWING_ERROR_TIMEOUT_MS, 50)
    bench.twin.faults.add("stall", "1")
    hand_over(bench, TURN)
    assert emergencies(bench.run(1.0)) == [0x8611]
    assert bench.state(1).has(StatusBit.FOLLOWING_ERROR)
    assert [node.motor.holding for node in bench.board.nodes[:2]] == [False, True]
    bench.write(1, canopen.CONTROLWORD, 0x80)  # its cause is over
    assert bench.state(1).state is DriveState.DISABLED


def test_a_push_is_turned_back_and_seen_meanwhile():
    bench = in_profile(Bench())
    bench.twin.world.stalled.add(0)
    bench.device.push([400, 0, 0, 0, 0, 0])
    assert bench.count(1) == 400
    assert bench.read(1, canopen.FOLLOWING_ERROR) == -400
    bench.twin.world.stalled.clear()
    bench.run(0.1)
    assert bench.count(1) == 0


# -- profile position and cyclic targets ----------------------------------------------------------


def test_a_trapezoid_is_driven_with_both_ramps_and_the_latest_target_counts():
    bench = in_profile(Bench())
    hand_over(bench, 2 * TURN)
    bench.run(0.25)
    assert bench.read(1, canopen.VELOCITY) == pytest.approx(UP * 0.25, abs=UP * LATE_S)
    assert not bench.state(1).has(StatusBit.REACHED)
    bench.run(0.4)
    assert bench.read(1, canopen.VELOCITY) == RATE
    # half a second up, a quarter down, and what is between at full speed
    total_s = 0.5 + 0.25 + (2 * TURN - RATE * 0.375) / RATE
    bench.run(total_s - 0.65 - 2 * LATE_S)
    assert not bench.state(1).has(StatusBit.REACHED)
    bench.run(4 * LATE_S)
    assert bench.state(1).has(StatusBit.REACHED)
    assert bench.count(1) == 2 * TURN
    hand_over(bench, TURN)
    hand_over(bench, -TURN // 10)
    bench.run(3.5)
    assert bench.count(1) == -TURN // 10


def test_targets_are_interpolated_from_sync_to_sync():
    bench = in_cycles(Bench())
    before = bench.world.motors
    bench.order(1, ENABLE, CSP, 50)
    bench.run(0.1)
    assert bench.count(1) == 0  # not before the SYNC
    drive_along(bench, range(50, 1001, 50))
    bench.order(1, ENABLE, CSP, 1100)
    told = bench.sync(PERIOD_S / 2)[1]
    assert told[0].state is DriveState.ENABLED
    assert told[1:] == (CSP, 1000)
    assert bench.count(1) == pytest.approx(1050, abs=20)
    bench.run()
    assert (bench.world.motors - before) == (1100, 0, 0, 0, 0, 0)


def test_a_drive_whose_targets_stop_may_hold_or_go_on():
    for quirk, goes_on in (("hold", False), ("extrapolate", True)):
        bench = in_cycles(Bench(hold_after_loss=quirk))
        drive_along(bench, range(50, 501, 50))
        bench.run(0.2)
        assert (bench.count(1) > 1000) is goes_on
        assert goes_on or bench.count(1) == 500


def test_an_old_target_is_gone_to_as_soon_as_the_mode_begins():
    bench = Bench()
    bench.enable(1, mode=PP)
    bench.write(1, canopen.TARGET_POSITION, 300)
    bench.run(0.1)
    assert bench.count(1) == 0
    bench.write(1, canopen.MODE, CSP)
    bench.run(0.1)
    assert bench.count(1) == 300


def test_a_drive_without_the_mode_refuses_it():
    bench = Bench(csp=False)
    assert bench.write(1, canopen.MODE, CSP) == AbortCode.VALUE
    bench.set_up(1)
    bench.enable(1, mode=PP)
    bench.order(1, ENABLE, CSP, 1000)
    bench.sync()
    assert bench.sync()[1][1:] == (PP, 0)


# -- homing ---------------------------------------------------------------------------------------

SEARCH = ENABLE | canopen.ControlBit.NEW_SET_POINT


def at_switch(ahead=TURN):
    """Return a bench whose first drive is ready to home by a switch, and where that is."""
    probe = simulate(arm_config())
    goal = probe.world.motors + Motors((ahead, 0, 0, 0, 0, 0))
    joints, opening_mm = probe.world.body.transmission.to_joints(goal)
    bench = Bench(config=arm_config(HomingSettings(joints, opening_mm)))
    bench.enable(1, mode=HOMING)
    bench.write(1, METHOD, 18 if ahead > 0 else 17)
    return bench, bench.world.motors[0] + ahead


@pytest.mark.parametrize("ahead", [TURN, -TURN])
def test_the_switch_is_sought_left_and_called_home(ahead):
    bench, goal = at_switch(ahead)
    bench.write(1, OFFSET, 1234)
    bench.write(1, canopen.CONTROLWORD, SEARCH)
    assert not bench.state(1).value & HOMED
    bench.run(3.0)
    assert bench.state(1).value & HOMED == HOMED
    assert bench.world.motors[0] == goal
    assert bench.count(1) == 1234
    bench.write(1, canopen.CONTROLWORD, ENABLE)
    bench.write(1, canopen.MODE, PP)  # and from beyond the switch
    hand_over(bench, 1234 + (500 if ahead > 0 else -500))
    bench.run(20.0)
    assert bench.device.inputs & 1
    bench.write(1, canopen.MODE, HOMING)
    bench.write(1, canopen.CONTROLWORD, SEARCH)
    bench.run(3.0)
    assert bench.world.motors[0] == goal


def other_switch(bench):
    bench.write(1, METHOD, 17)


def stuck(state):
    return lambda bench: bench.board.set_switch(0, state)


@pytest.mark.parametrize(
    "spoil", [other_switch, stuck(SwitchState.OPEN), stuck(SwitchState.CLOSED)]
)
def test_a_switch_that_is_never_found_is_sought_until_the_search_is_broken_off(spoil):
    bench, _ = at_switch()
    spoil(bench)
    bench.write(1, canopen.CONTROLWORD, SEARCH)
    bench.run(3.0)
    assert not bench.state(1).has(StatusBit.ACKNOWLEDGED)
    assert bench.device.moving
    bench.write(1, canopen.CONTROLWORD, ENABLE)
    bench.run(0.5)
    assert not bench.device.moving
    assert not bench.state(1).has(StatusBit.ACKNOWLEDGED)


def test_home_may_be_where_it_stands_and_without_a_method_homing_fails():
    bench = Bench()
    assert bench.write(1, METHOD, 24) == AbortCode.VALUE
    bench.enable(1, mode=HOMING)
    bench.write(1, canopen.CONTROLWORD, SEARCH)
    assert bench.state(1).has(StatusBit.FOLLOWING_ERROR)
    bench.write(1, canopen.CONTROLWORD, ENABLE)
    bench.write(1, METHOD, 37)
    bench.write(1, OFFSET, -77)
    bench.write(1, canopen.CONTROLWORD, SEARCH)
    assert bench.state(1).value & HOMED == HOMED
    assert bench.count(1) == -77


# -- objects, PDOs, network management -------------------------------------------------------------


def test_a_drive_says_what_it_is():
    bench = Bench()
    assert bench.read(3, canopen.DEVICE_TYPE) & 0xFFFF == 402
    assert bench.read(3, canopen.DEVICE_NAME) == "Simulated CiA 402 servo drive"  # in segments
    assert bench.read(3, canopen.SERIAL_NUMBER) == 3
    assert bench.read(3, canopen.SUPPORTED_MODES) == 0b1010_0001
    assert bench.read(3, Place(0x2345)) == AbortCode.NO_OBJECT
    assert bench.write(3, canopen.POSITION, 5) == AbortCode.READ_ONLY
    assert bench.read(9, canopen.DEVICE_TYPE) is None
    for entry in canopen.STANDARD:
        found = dictionary().find(entry.place)
        assert (found.type, found.access) == (entry.type, entry.access)


@every_row("settings, place, told", [
    ({"missing": "6061+60C2"}, PERIOD, AbortCode.NO_OBJECT),
    ({"homing": False}, canopen.SUPPORTED_MODES, 0b1000_0001),
    ({"following_window": 77}, canopen.FOLLOWING_ERROR_WINDOW, 77),
])  # fmt: skip
def test_a_drive_may_be_another_or_lack_something(settings, place, told):
    assert Bench(**settings).read(1, place) == told


@every_row("place, value", [
    (canopen.MODE, 3),
    (canopen.QUICK_STOP_OPTION, 9),
    (canopen.HEARTBEAT_REACTION, 4),
    (canopen.CONSUMER_HEARTBEAT, 0xC8_0064),
    (canopen.QUICK_STOP_DECELERATION, 0),
    (Place(0x1800, 2), 250),
])  # fmt: skip
def test_nonsense_is_refused(place, value):
    bench = Bench()
    before = bench.read(1, place)
    assert bench.write(1, place, value) == AbortCode.VALUE
    assert bench.read(1, place) == before


def test_pdos_are_set_up_while_they_are_off_and_go_once_the_node_is_started():
    bench, count = Bench(), Place(0x1600, 0)
    assert bench.write(1, count, 0) == AbortCode.DEVICE_STATE
    for write in setups(1):
        assert bench.write(1, write.place, write.value) is None
    assert bench.sync() == {}
    bench.order(1, 6, CSP, 0)
    bench.sync()
    assert bench.state(1).state is DriveState.DISABLED
    bench.send(canopen.Nmt(canopen.NmtCommand.START, 1).frame)
    assert bench.write(1, count, 1) == AbortCode.DEVICE_STATE
    heard = bench.tell(Frame(0x201, ORDER.pack((6, PP, 0))[:5]))  # too short
    assert emergencies(heard) == [0x8210]
    assert bench.sync()[1][0].state is DriveState.DISABLED


@every_row("reaction, state", [(0, DriveState.ENABLED), (2, DriveState.DISABLED)])
def test_a_master_resets_a_node_or_its_communication(reaction, state):
    bench = Bench()
    bench.write(1, canopen.HEARTBEAT_REACTION, reaction)
    in_cycles(bench)
    heard = bench.tell(canopen.Nmt(canopen.NmtCommand.RESET_COMMUNICATION, 1).frame, 0.1)
    assert beats(heard) == [NodeState.BOOTING]
    assert bench.state(1).state is state
    assert (bench.read(1, PERIOD), bench.read(1, Place(0x1800, 2))) == (10, 255)
    heard = bench.tell(canopen.Nmt(canopen.NmtCommand.RESET_NODE, 1).frame, 1.0)
    assert beats(heard) == [NodeState.BOOTING]
    assert bench.state(1).state is DriveState.DISABLED
    assert bench.sync() == {}  # pre-operational
    assert bench.read(1, PERIOD) == 1


def test_a_stopped_node_is_deaf_and_reacts():
    bench = in_profile(Bench())
    bench.write(1, canopen.HEARTBEAT_REACTION, 3)
    bench.send(canopen.Nmt(canopen.NmtCommand.STOP, 1).frame)
    assert bench.read(1, canopen.STATUSWORD) is None
    bench.send(canopen.Nmt(canopen.NmtCommand.PRE_OPERATIONAL, 1).frame)
    assert bench.state(1).state is DriveState.QUICK_STOP


def test_heartbeats_tell_the_state():
    bench = Bench()
    bench.write(1, canopen.PRODUCER_HEARTBEAT_MS, 100)
    assert beats(bench.run(1.0)) == [NodeState.PRE_OPERATIONAL] * 10
    bench.send(canopen.Nmt(canopen.NmtCommand.START, 1).frame)
    assert set(beats(bench.run(0.5))) == {NodeState.OPERATIONAL}
    bench.write(1, canopen.PRODUCER_HEARTBEAT_MS, 0)
    assert beats(bench.run(0.5)) == []


# -- the master's heartbeat -----------------------------------------------------------------------


def watching(reaction, **settings):
    """Return a bench whose first drive watches the master's heartbeat."""
    bench = Bench(**settings)
    bench.set_up(1)
    bench.write(1, canopen.QUICK_STOP_OPTION, HOLDS)
    bench.write(1, canopen.HEARTBEAT_REACTION, reaction)
    bench.watch(1, 200)
    bench.enable(1)
    return bench


@every_row("reaction, ends", [(0, DriveState.ENABLED), (1, DriveState.FAULT),
                              (2, DriveState.DISABLED), (3, DriveState.QUICK_STOP)])  # fmt: skip
def test_a_drive_that_misses_it_reacts_as_it_was_told(reaction, ends):
    bench = watching(reaction)
    assert emergencies(bench.run(2.0)) == []  # not before the first one
    drive_along(bench, range(50, 501, 50), beating=True)
    assert emergencies(bench.run(0.5)) == [0x8130]
    assert bench.state(1).state is ends
    assert bench.state(1).has(StatusBit.WARNING)
    assert bench.read(1, canopen.ERROR_CODE) == 0x8130
    assert bench.board.nodes[0].nmt.state is NodeState.PRE_OPERATIONAL
    bench.beat()
    assert emergencies(bench.run()) == ([] if ends is DriveState.FAULT else [0])


@pytest.mark.parametrize("plugged", [True, False])
def test_another_node_is_not_the_master_and_without_its_cable_a_drive_misses_it(plugged):
    bench = watching(3)
    bench.beat()
    bench.run(0.1)
    bench.board.node(0).port.plugged = plugged
    for _ in range(10):
        beat = canopen.Heartbeat(MASTER - plugged, NodeState.OPERATIONAL)
        bench.tell(beat.frame, 0.05)
    assert bench.board.nodes[0].states.state is DriveState.QUICK_STOP


# -- power, faults, saving ------------------------------------------------------------------------


def test_power_that_returns_boots_the_drives_which_count_from_zero():
    bench = Bench()
    bench.enable(*IDS, mode=PP)
    bench.twin.faults.add("drive-fault", "1", "4310")
    bench.device.power_off()
    assert bench.run(1.0) == []
    bench.device.power_on()
    assert bench.run(BOOT_S - 0.01) == []
    assert bench.read(1, canopen.STATUSWORD) is None
    heard = bench.run(0.1)
    assert beats(heard) == [NodeState.BOOTING]
    assert emergencies(heard) == [0x4310]
    assert [bench.state(node).state for node in (1, 2)] == [DriveState.FAULT, DriveState.DISABLED]


def test_a_position_may_outlast_the_power():
    bench = Bench(keeps_position=True)
    bench.enable(*IDS, mode=PP)
    bench.device.board.count_from([500] * 6)
    bench.device.power_off()
    bench.device.power_on()
    bench.run(1.0)
    assert bench.count(1) == 500
    assert bench.world.motors[1] - bench.count(2) == bench.board.nodes[1].motor.zero


@pytest.mark.parametrize("fault", ["drive-reset", "drive-dead"])
def test_a_restarted_drive_releases_its_motor(fault):
    bench = Bench()
    bench.enable(*IDS, mode=PP)
    before = bench.world.motors
    bench.twin.faults.add(fault, "2")
    bench.run(0.1)
    bench.twin.faults.end()
    heard = bench.run(1.0)
    assert (beats(heard, 2), beats(heard, 1)) == ([NodeState.BOOTING], [])
    assert bench.world.motors[1] != before[1]
    assert bench.count(2) == 0
    assert [node.motor.holding for node in bench.board.nodes].count(True) == 5


def test_a_drive_gets_another_id_or_mode_or_sends_an_emcy():
    bench = Bench()
    bench.write(2, canopen.HEARTBEAT_REACTION, 0)
    bench.set_up(1, 2)
    bench.enable(1, 2)
    bench.twin.faults.add("drive-id", "2", "9")
    assert beats(bench.run(0.1), 9) == [NodeState.BOOTING]
    assert bench.read(2, canopen.STATUSWORD) is None
    assert bench.state(9).state is DriveState.ENABLED
    bench.twin.faults.end()
    assert beats(bench.run(0.1), 2) == [NodeState.BOOTING]
    bench.twin.faults.add("drive-mode", "1", "2")
    bench.run(0.1)
    assert bench.sync()[1][1] == 2
    drive_along(bench, (50, 100))  # until the next order
    assert bench.sync()[1][1] == CSP
    bench.twin.faults.add("drive-emcy", "1", "7305")
    assert emergencies(bench.run()) == [0x7305]
    assert bench.state(1).state is DriveState.ENABLED
    node = bench.board.node(0)
    for nonsense in (
        lambda: node.set_id(128, 0.0),
        lambda: node.set_mode(5, 0.0),
        lambda: bench.twin.faults.add("drive-emcy", "1", "0000"),
    ):
        with pytest.raises(BadRequest):
            nonsense()


def test_drives_are_made_again_as_they_stood():
    bench = in_cycles(Bench())
    drive_along(bench, range(50, 501, 50))
    bench.run()
    bench.enable(2, 3, mode=PP)
    bench.write(2, canopen.QUICK_STOP_OPTION, HOLDS)
    bench.write(2, canopen.CONTROLWORD, QUICK_STOP)
    bench.board.put_in_fault(2, 0x4310)
    bench.board.node(4).set_id(9, bench.board.now_s)
    bench.run(0.1)
    bench.write(9, canopen.PRODUCER_HEARTBEAT_MS, 100)
    saved = json.loads(json.dumps(bench.twin.save()))
    again = Bench(saved=saved)
    assert again.twin.save() == saved
    assert again.world.motors == bench.world.motors
    assert len(beats(again.run(0.45), 9)) == 4
    told = again.sync()[1]
    assert told[0].state is DriveState.ENABLED
    assert told[1:] == (CSP, 500)
    assert [again.state(node).state for node in (2, 3)] == [DriveState.QUICK_STOP, DriveState.FAULT]
    assert [node.motor.holding for node in again.board.nodes[:3]] == [True, True, False]
    drive_along(again, [550, 600])
    again.run()
    assert again.count(1) == 600
    seen = again.board.details()["drives"][0]
    assert (seen["state"], seen["mode"], seen["rate"]) == ("enabled", CSP, 0.0)
