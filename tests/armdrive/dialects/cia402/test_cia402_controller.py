"""A CiA 402 controller on simulated drives: switching on, orders, faults, settings."""

import re

import pytest
from amounts import amount, every_row, in_pairs
from can_fault_bench import Bus, check_recovery, check_reported_and_stopped
from cia402_rig import Rig, moving, steps

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.dialects.cia402.drives import Cia402Drive, Trouble, value_of
from armdrive.dialects.controller import MOTORS_OFF
from armdrive.errors import DeviceFault
from armdrive.registry import simulate
from armdrive.status import State
from armdrive.tasks import (
    AlertKind,
    ClearFault,
    Done,
    DropCurrent,
    Halted,
    HomeDevice,
    MeasureUnits,
    MoveAlong,
    MoveBy,
    ReadPosition,
    Registers,
    RequestRejected,
    SwitchOn,
)
from firmware_protocol import canopen
from firmware_protocol.canopen import Nmt, NmtCommand
from firmware_protocol.frames import pack

FAR = steps(60_000, -30_000)
QUICK_STOP = 0x0002
"""The controlword."""
PDO = canopen.Service.RPDO1
MOVE = MoveBy(steps(8000, -4000), 20_000.0)


# -- contact --------------------------------------------------------------------------------------


def test_the_first_request_sets_every_drive_up_and_moves_nothing():
    rig = Rig()
    before = rig.positions
    reply = rig.do(ReadPosition())
    assert isinstance(reply, Registers)
    assert reply.positions == before == rig.positions
    assert rig.states() == {canopen.DriveState.DISABLED}
    for node in rig.device.board.nodes:
        assert node.nmt.state is canopen.NodeState.OPERATIONAL
        assert node.objects.number_of(canopen.HEARTBEAT_REACTION, -1) == 3
        assert node.objects.number_of(canopen.QUICK_STOP_OPTION, -1) == 6


def test_a_drive_without_the_quick_stop_that_holds_refuses_contact_in_words():
    reply = Rig(missing="605A").do(ReadPosition())
    assert isinstance(reply, RequestRejected)
    assert not reply.moved
    quick_stop = "object 605A:00 Quick stop option code (6, quick ramp and stay)"
    assert quick_stop in reply.reason


@pytest.mark.parametrize(
    "constant",
    ["60C2:02=-3", "1400:02=255", "1400:02=254+605E:00=2+60C2:02=-3"],  # EuServo, TMCM-1276, -1230
)
def test_objects_that_are_constant_with_a_suitable_value_refuse_nothing(constant):
    rig = Rig(constant=constant).ready()
    before = rig.positions
    assert rig.along(MOVE, MOVE) == Done()
    assert rig.do(MoveBy(steps(-2000, 1000), 20_000.0)) == Done()
    assert rig.positions - before == steps(14_000, -7000)
    assert not rig.alerts()


@pytest.mark.parametrize("constant", ["1400:02=0", "1800:02=255", "60C2:02=-2", "605A:00=2"])
def test_a_constant_with_another_value_refuses_contact_in_words(constant):
    reply = Rig(constant=constant).do(ReadPosition())
    assert isinstance(reply, RequestRejected)
    assert f"refused object {constant.split('=')[0]}" in reply.reason
    assert "can only be read" in reply.reason or "cannot be accessed so" in reply.reason


def test_a_drive_that_does_not_keep_how_it_stops_refuses_contact(monkeypatch):
    rig = Rig()
    store = rig.node(2).objects.store
    put, forgotten = store.put, canopen.HEARTBEAT_REACTION
    monkeypatch.setattr(
        store, "put", lambda entry, value: entry.place == forgotten or put(entry, value)
    )
    assert "drive 2 (shoulder) does not keep 3 in object 6007:00" in rig.do(ReadPosition()).reason


@pytest.mark.parametrize("missing", ["6007", "1016"])
def test_drives_that_would_not_stop_without_this_program_move_in_bursts(missing):
    rig = Rig(missing=missing)
    for node in rig.device.board.nodes:  # another program had them watch its heartbeat
        node.objects.keep(canopen.CONSUMER_HEARTBEAT, 127 << 16 | 200)
    before, cyclic = rig.positions, rig.controller.stopping(0.3)
    rig.ready()
    assert f"has no object {missing[:4]}" in str(rig.heard)
    assert not rig.controller.abilities.queued_segments
    assert rig.controller.stopping(2.0).silent_s > 2.0 > cyclic.silent_s
    for node in rig.device.board.nodes:
        assert not node.objects.number_of(canopen.CONSUMER_HEARTBEAT, 0)
    rig.begin(MOVE)
    rig.run(0.2)
    rig.suspend(5.0)  # the burst goes on to its end, and the drives hold there
    assert rig.positions - before == steps(8000, -4000)
    assert rig.states() == {canopen.DriveState.ENABLED}
    assert rig.finish() == Done()
    assert rig.do(ReadPosition()).positions == rig.positions


def test_another_master_on_the_bus_refuses_contact():
    rig = Rig()
    beat = pack(canopen.Heartbeat(rig.config.device.master_id, canopen.NodeState.OPERATIONAL).frame)
    rig.at_s = {0.0005: lambda: rig.controller.receive(beat, rig.now_s)}
    reply = rig.do(ReadPosition())
    assert isinstance(reply, RequestRejected)
    assert "another program" in reply.reason


@pytest.mark.parametrize("when_s", [0.001 * ms for ms in range(0, 40, amount(16, 2))])
@pytest.mark.parametrize("for_s", [1.5, 30.0])
def test_a_program_that_is_suspended_while_it_looks_for_the_drives_finds_them(when_s, for_s):
    rig = Rig()
    rig.begin(ReadPosition())
    rig.run(when_s)
    rig.now_s += for_s
    assert isinstance(rig.finish(), Registers)


# -- current --------------------------------------------------------------------------------------


def test_switching_on_holds_every_drive_where_it_is_and_is_verified():
    rig = Rig()
    before = rig.positions
    rig.ready()
    assert rig.states() == {canopen.DriveState.ENABLED}
    assert rig.positions == before
    for node in rig.device.board.nodes:
        assert node.objects.number_of(canopen.CONSUMER_HEARTBEAT, 0) == 127 << 16 | 200


def test_while_the_motors_are_off_nothing_moves_or_switches_them_on():
    rig = Rig()
    rig.do(ReadPosition())
    for request in (MOVE, MoveAlong(iter([MOVE]), 0.3), HomeDevice(), MeasureUnits(0, 500)):
        assert rig.do(request) == RequestRejected(MOTORS_OFF, moved=False)
    assert rig.states() == {canopen.DriveState.DISABLED}


STAYS_OPERATIONAL = "1029:01=1"


@pytest.mark.parametrize("delay_s", [0.001, 0.003, 0.006, 0.009][-amount(2, 4) :])
def test_a_shaft_turned_by_hand_while_the_watch_is_set_up_is_not_turned_back(delay_s):
    rig = Rig(constant=STAYS_OPERATIONAL).ready()
    rig.suspend(0.5)
    rig.begin(SwitchOn())
    rig.run(delay_s)
    rig.device.jog(steps(25))
    stood, reply = rig.positions, None
    while reply is None:
        reply = rig.reply()
        rig.run(0.002)
        assert rig.positions == stood
    assert reply == Done()


def test_of_drives_that_stay_on_only_the_silent_ones_do_not_answer():
    rig = Rig().ready()
    rig.node(1).port.mute = True
    rig.loses = lambda frame, host: host and frame.can_id == canopen.cob_id(PDO, 2)
    reply = rig.do(DropCurrent())
    assert "drive 1 (base) does not answer" in reply.reason
    assert "drive 2" not in reply.reason


def test_every_motor_is_switched_off_though_a_drive_does_not_confirm_the_end_of_its_watch():
    rig = Rig().ready()
    unanswered = canopen.cob_id(canopen.Service.SDO_RESPONSE, 1)
    rig.loses = lambda frame, host: not host and frame.can_id == unanswered
    assert "drive 1 (base) does not answer" in rig.do(DropCurrent()).reason
    assert rig.states() == {canopen.DriveState.DISABLED}


@pytest.mark.parametrize("ends", ["switched off", "in order", "in mid-motion"])
def test_only_an_end_in_mid_motion_leaves_the_drives_to_their_watch(ends):
    rig = Rig().ready() if ends != "in mid-motion" else moving(steps(60_000), 0.3)
    if ends == "switched off":
        assert rig.do(DropCurrent()) == Done()
    else:
        last_frames = rig.controller.shutdown_frames()
        assert bool(last_frames) is (ends == "in order")
        rig.link.write(last_frames, rig.now_s)
        rig.dead = True
    rig.run(1.0)
    stopped = any(node.states.watch_stops for node in rig.device.board.nodes)
    assert stopped is (ends == "in mid-motion")
    assert rig.states() == {{
        "switched off": canopen.DriveState.DISABLED,
        "in order": canopen.DriveState.ENABLED,
        "in mid-motion": canopen.DriveState.QUICK_STOP,
    }[ends]}  # fmt: skip
    assert not rig.frames(canopen.Service.HEARTBEAT, rig.now_s - 0.9)


def takes_over(rig, after_s=0.0):
    """Return another program on the same drives."""
    again = Rig()
    again.twin, again.device, again.link = rig.twin, rig.device, rig.link
    again.now_s = rig.now_s + after_s
    return again


def test_a_second_program_takes_drives_over_that_hold_and_none_sags_or_moves():
    rig = Rig().ready()
    rig.along(MOVE)
    there = rig.positions
    again, nmt_lost = takes_over(rig, 0.05), iter([True])
    again.loses = lambda frame, host: host and not frame.can_id and next(nmt_lost, False)
    assert isinstance(again.do(ReadPosition()), Registers)
    assert all(node.motor.holding for node in rig.device.board.nodes)
    assert again.do(ClearFault()) == Done()
    assert again.do(MOVE) == RequestRejected(MOTORS_OFF, moved=False)  # no heartbeat is watched
    again.ready()
    again.run(0.5)
    assert rig.states() == {canopen.DriveState.ENABLED}
    assert rig.positions == there


def test_drives_that_an_earlier_program_left_running_are_waited_for_and_then_stopped():
    rig = moving(steps(100_000), settings={"strategy": "profile"})
    for node in rig.device.board.nodes:  # it had them mind no heartbeat
        node.objects.keep(canopen.CONSUMER_HEARTBEAT, 0)
        node.watch()
    again = takes_over(rig)
    there = rig.positions[0]
    assert isinstance(again.do(ReadPosition()), Registers)
    assert there + 15_000 < rig.positions[0] < 60_000
    again.check_stands(1.0)


# -- the heartbeat --------------------------------------------------------------------------------


def test_a_program_that_falls_silent_has_the_drives_hold_and_nothing_moves_when_it_wakes():
    rig = Rig().ready()
    rig.dead = True
    rig.run(1.0)
    assert rig.states() == {canopen.DriveState.QUICK_STOP}
    there, rig.dead = rig.positions, False
    rig.run(1.0)
    assert rig.states() == {canopen.DriveState.QUICK_STOP}
    assert rig.positions == there
    assert all(node.motor.holding for node in rig.device.board.nodes)
    refused = rig.along(MOVE)  # it may belong to the motion that the drives ended
    assert (
        "has stopped by itself, and holds: a heartbeat or life guard is missing" in refused.reason
    )
    assert rig.positions == there
    assert rig.do(ClearFault()) == Done()
    assert rig.along(MOVE) == Done()
    assert rig.positions == there + MOVE.steps


@pytest.mark.parametrize("behaviour", ["", STAYS_OPERATIONAL])
def test_a_program_that_is_suspended_in_motion_stops_the_arm_and_does_not_go_on_when_it_wakes(
    behaviour,
):
    rig = moving(steps(60_000), constant=behaviour)
    there = rig.suspend(1.0)
    assert rig.states() == {canopen.DriveState.QUICK_STOP}
    assert there[0] < 20_000 * (0.5 + 0.3)
    rig.stop()  # what the engine says to a program that wakes
    assert rig.finish() == Halted()
    rig.run(0.5)
    assert rig.positions == there
    held = canopen.DriveState.ENABLED if behaviour else canopen.DriveState.QUICK_STOP
    assert rig.states() == {held}
    assert isinstance(rig.do(ReadPosition()), Registers)  # as the engine does at rest
    assert rig.along(MOVE) == Done()
    assert rig.positions == there + MOVE.steps


@in_pairs(
    "strategy, late_s, quirk, behaviour",
    ["cyclic", "profile"], [0.32, 0.9], ["hold", "extrapolate"], ["", STAYS_OPERATIONAL],
)  # fmt: skip
def test_a_program_that_is_later_than_the_heartbeat_timeout_finds_the_motion_ended(
    strategy, late_s, quirk, behaviour
):
    settings = {"strategy": strategy}
    rig = moving(FAR, settings=settings, hold_after_loss=quirk, constant=behaviour)
    there = rig.suspend(late_s)
    assert rig.states() == {canopen.DriveState.QUICK_STOP}
    reply = rig.finish()
    assert "stopped by itself, and holds: a heartbeat or life guard is missing" in reply.reason
    assert [alert.kind for alert in rig.alerts()] == [AlertKind.ALARM]
    assert rig.do(ClearFault()) == Done()
    rig.run(0.5)
    assert rig.positions == there


def test_drives_that_stopped_between_two_bursts_are_taken_back_by_no_reading_midway():
    rig = Rig({"strategy": "profile"}).ready()
    assert rig.do(MoveBy(steps(2000), 20_000.0)) == Done()
    there = rig.suspend(0.5)
    for request in (ReadPosition(midway=True), MoveBy(steps(2000), 20_000.0)):
        reply = rig.do(request)
        assert "stopped by itself, and holds: a heartbeat or life guard is missing" in reply.reason
    assert {alert.kind for alert in rig.alerts()} == {AlertKind.ALARM}
    assert rig.positions == there
    assert isinstance(rig.do(ReadPosition()), Registers)  # at rest
    assert rig.do(MoveBy(steps(2000), 20_000.0)) == Done()


def test_targets_that_lay_in_the_computer_while_drives_stopped_do_not_have_the_motion_go_on(
    monkeypatch,
):
    rig, late = moving(FAR), list[bytes]()
    with monkeypatch.context() as held_up:
        held_up.setattr(rig.link, "write", lambda data, _: late.append(data))
        rig.run(0.011)
    there = rig.suspend(0.5)
    rig.link.write(b"".join(late), rig.now_s)
    assert "stopped by itself, and holds" in rig.finish().reason
    rig.run(0.5)
    way = rig.positions - there
    assert way.largest <= 20_000 * rig.controller.stopping(0.3).asked_motion_s  # of what lay there


def test_a_report_from_before_a_suspension_does_not_hide_that_the_drives_have_stopped():
    rig = moving(FAR, constant=STAYS_OPERATIONAL)
    begun_s = rig.now_s
    while not rig.frames(canopen.Service.SYNC, begun_s):
        rig.run(0.0001)
    there = rig.suspend(0.5)  # before the reports of that SYNC were read
    assert "stopped by itself, and holds" in rig.finish().reason
    rig.run(0.5)
    assert rig.positions == there


@every_row("place, data, value", [
    (canopen.STATUSWORD, b"\x37\x02\0\0", 0x237),
    (canopen.MODE_SHOWN, b"\xff\xff\xff\xff", -1),
    (canopen.SUPPORTED_MODES, b"\xa1\0", 0xA1),
])  # fmt: skip
def test_a_number_is_read_whatever_its_length_on_the_wire(place, data, value):
    assert value_of(canopen.Uploaded(place, data)) == value


def test_a_drive_that_was_not_enabled_at_a_single_report_has_stopped_by_itself():
    drive = Cia402Drive(1, "base", 0, 8)
    drive.watch()
    for state in (canopen.DriveState.QUICK_STOP, canopen.DriveState.ENABLED):
        drive.note_word(canopen.Statusword.of(state))
    assert drive.trouble(on=True, moving=True) is Trouble.STOPPED
    assert drive.trouble(on=True, moving=False) is None


def test_a_stop_goes_before_the_states_that_are_asked_for_after_an_outage():
    rig = moving(FAR)
    rig.loses = lambda *_: True  # or late: no drive hears the program
    begun_s = rig.now_s
    while not rig.frames(canopen.Service.SDO_REQUEST, begun_s):
        rig.run(0.001)
    rig.stop()
    asked_s = rig.now_s
    rig.run(2.0 * rig.controller.limits.cycle_s)
    assert all(rig.words(node)[-1] == QUICK_STOP for node in range(1, 7))
    rig.loses = lambda *_: False
    assert rig.finish() == Halted()
    assert rig.now_s - asked_s < 0.5


@pytest.mark.parametrize("quirk", ["hold", "extrapolate"])
@pytest.mark.parametrize("strategy", ["cyclic", "profile"])
def test_targets_without_a_sync_that_drives_got_before_they_stopped_move_nothing(
    monkeypatch, strategy, quirk
):
    """Suspended between the two: the next SYNC would have drives act on what waits for it."""
    rig = moving(FAR, settings={"strategy": strategy}, hold_after_loss=quirk)
    write, sync = rig.link.write, pack(canopen.Sync().frame)
    with monkeypatch.context() as cut_short:
        said: list[bytes] = []
        cut_short.setattr(
            rig.link,
            "write",
            lambda data, now_s: (said.append(data), write(data.replace(sync, b""), now_s)),
        )
        while not any(sync in data for data in said):
            rig.run(0.001)
    there = rig.suspend(0.5)
    assert rig.states() == {canopen.DriveState.QUICK_STOP}
    assert "stopped by itself, and holds" in rig.finish().reason
    rig.run(0.5)
    assert rig.positions == there


def test_a_stop_drops_targets_that_were_not_sent_yet():
    """Suspended as it hears: what is thought out with that was not said, and is not on waking."""
    rig = moving(FAR, constant=STAYS_OPERATIONAL)
    due_s = rig.controller.next_s()
    rig.controller.receive(pack(canopen.Heartbeat(1, canopen.NodeState.OPERATIONAL).frame), due_s)
    assert rig.controller.next_s() == due_s  # there is something to be said
    there = rig.suspend(1.2)
    rig.stop()
    assert rig.finish() == Halted()
    rig.run(0.5)
    assert rig.positions == there


def test_heartbeats_that_just_suffice_hold_nothing_up():
    rig = Rig({"heartbeat_timeout_ms": 100, "heartbeat_period_ms": 50}).ready()
    rig.begin(MoveAlong(iter([MoveBy(steps(20_000), 20_000.0)]), 10.0))
    began_s = rig.now_s
    assert rig.finish() == Done()
    assert rig.now_s - began_s < 1.2
    assert not rig.controller.underruns


def test_a_drive_that_restarted_unnoticed_is_set_up_again_once_it_is_missing():
    rig = Rig().ready()
    rig.device.board.node(2).port.mute = True
    rig.device.board.switch_drive(2, on=False)
    rig.run(0.6)
    rig.device.board.switch_drive(2, on=True)
    rig.run(2.0)
    rig.device.board.node(2).port.mute = False
    rig.do(ClearFault())
    assert [alert.kind for alert in rig.alerts()] == [AlertKind.SWITCHED_OFF]
    rig.do(ClearFault())
    assert rig.do(SwitchOn()) == Done()
    assert rig.states() == {canopen.DriveState.ENABLED}
    assert isinstance(rig.do(ReadPosition()), Registers)


def test_a_drive_that_restarted_unheard_is_reported_when_it_is_taken_back():
    rig = Rig().ready()
    rig.suspend(1.0)  # all drives miss the heartbeat
    rig.run(0.2)
    rig.node(3).port.mute = True
    rig.device.board.switch_drive(2, on=False)
    rig.device.board.switch_drive(2, on=True)
    rig.run(1.0)
    rig.node(3).port.mute = False
    assert isinstance(rig.do(ReadPosition()), Registers)
    assert [alert.kind for alert in rig.alerts()] == [AlertKind.RESTARTED]
    assert rig.do(MOVE) == RequestRejected(MOTORS_OFF, moved=False)


@pytest.mark.parametrize("before_s", [0.0, 0.02])
def test_one_drive_that_missed_a_heartbeat_at_rest_is_taken_back_without_an_alert(before_s):
    rig = Rig().ready()
    rig.node(2).silent_s = rig.now_s  # the others have heard the heartbeat
    rig.run(before_s)
    assert isinstance(rig.do(ReadPosition()), Registers)
    rig.run(0.5)
    assert isinstance(rig.do(ReadPosition()), Registers)
    assert not rig.alerts()


def test_a_drive_that_another_master_takes_out_of_operation_in_a_burst_is_stopped_by_sdo():
    rig = moving(steps(0, 0, 100_000), settings={"strategy": "profile"})
    there = rig.positions[2]
    ordered(rig, NmtCommand.PRE_OPERATIONAL)()
    reply = rig.finish()
    assert re.search(ORDERED[1], reply.reason)
    assert "come to rest" not in reply.reason
    assert rig.positions[2] - there < 20_000
    rig.check_stands(0.5)


def test_a_motion_switches_no_drive_on_that_has_switched_itself_off_unheard():
    rig = Rig().ready()
    rig.run(0.5)
    rig.node(1).states.machine.state = canopen.DriveState.DISABLED  # by its enable input
    reply = rig.do(MOVE)
    assert "drive 1 (base) has switched its motor off" in reply.reason
    assert not reply.moved
    assert rig.node(1).states.state is canopen.DriveState.DISABLED
    assert [alert.kind for alert in rig.alerts()] == [AlertKind.SWITCHED_OFF]


def test_a_drive_that_another_master_stops_at_rest_moves_nothing_until_it_is_reset():
    rig = Rig().ready()
    before = rig.positions
    ordered(rig, NmtCommand.PRE_OPERATIONAL)()
    rig.run(0.12)
    reply = rig.do(MOVE)
    assert re.search(ORDERED[1], reply.reason)
    assert not reply.moved
    assert rig.positions == before
    assert {alert.kind for alert in rig.alerts()} == {AlertKind.ALARM}
    assert rig.do(ClearFault()) == Done()
    assert rig.do(MOVE) == Done()


# -- what goes wrong ------------------------------------------------------------------------------


def test_a_fault_at_rest_is_reported_in_words_and_cleared_by_reset():
    rig = Rig().ready()
    rig.device.board.put_in_fault(1, 0x4310)
    rig.run(0.5)
    (alert,) = rig.alerts()
    assert alert.kind is AlertKind.SWITCHED_OFF
    assert "drive 2 (shoulder) is in fault" in alert.text
    assert "drive too hot" in alert.text
    refused = rig.do(ClearFault())
    assert isinstance(refused, RequestRejected)
    assert "does not leave it" in refused.reason
    rig.device.board.fix(1, 0x4310)
    assert rig.do(ClearFault()) == Done()
    assert rig.node(2).states.state is canopen.DriveState.DISABLED
    rig.ready()
    assert rig.states() == {canopen.DriveState.ENABLED}


@pytest.mark.parametrize("connected_before", [True, False])
def test_a_drive_in_fault_while_the_motors_are_off_is_reported_once_with_its_cause(
    connected_before,
):
    rig = Rig()
    if connected_before:
        rig.do(ReadPosition())
    rig.device.board.put_in_fault(1, 0x4310)
    rig.run(0.1)
    for _ in range(2):
        assert isinstance(rig.do(ReadPosition()), Registers)
    (alert,) = rig.alerts()
    assert alert.kind is AlertKind.LOCKED
    assert re.search(r"drive 2 \(shoulder\) is in fault.*too hot.*`reset\(\)`", alert.text)
    rig.device.board.fix(1, 0x4310)
    assert rig.do(ClearFault()) == Done()
    rig.ready()
    assert len(rig.alerts()) == 1


def test_drives_found_in_fault_are_a_notice_until_the_arm_is_reset():
    config = simulated_config("cia402")
    twin = simulate(config)
    twin.device.board.put_in_fault(1, 0x2310)
    twin.device.board.fix(1, 0x2310)
    arm = Arm(connect_simulated(config, twin=twin))
    assert (arm.status.state, arm.status.notice_code) == (State.DISABLED, "E506")
    assert "drive 2 (shoulder) is in fault" in arm.status.notice
    with pytest.raises(DeviceFault, match="is in fault"):
        arm.enable()
    arm.reset()
    assert not arm.status.notice
    arm.enable()
    assert (arm.status.state, arm.status.notice) == (State.STANDBY, "")


@every_row("mute, words", [(False, "did not come to rest after a stop"), (True, "does not answer")])
def test_a_drive_that_turns_on_after_the_stop_is_named_beside_the_one_in_trouble(mute, words):
    rig = moving(steps(100_000, 30_000), settings={"strategy": "profile"})
    rig.loses = lambda frame, host: host and frame.can_id in (0x201, 0x601)  # no stop reaches it
    rig.node(1).port.mute = mute
    rig.device.board.put_in_fault(1, 0x2310)
    reply = rig.finish()
    assert "drive 2 (shoulder) is in fault" in reply.reason
    assert f"drive 1 (base) {words}" in reply.reason
    assert reply.silent is mute
    assert rig.node(3).states.state is canopen.DriveState.ENABLED  # the others hold


# -- the current, as it is told -------------------------------------------------------------------


def test_drives_that_hold_are_reported_as_held_unless_they_have_to_be_enabled_first():
    rig = Rig()
    assert rig.do(ReadPosition()).held is False
    assert rig.ready().do(ReadPosition()).held is True
    rig.controller._exchange.on = False  # as behind a wire that was lost
    assert rig.do(ReadPosition()).held is None


# -- Faults that only CiA 402 drives have, and orders of another master ----------------------------
# `tests/conformance/faults.py` lists the faults that drives of every kind can have. Each row ends
# in the same program, where the arm moves again.

FAULT = "E501"
ELBOW = r"drive 3 \(elbow\)"
TOO_HOT = ("drive-fault 3 4310", f"{ELBOW} is in fault.*too hot")
LEFT_BEHIND = ("drive-fault 3 8611", f"{ELBOW} is in fault.*following")
ORDERED = (NmtCommand.PRE_OPERATIONAL, f"program has ordered {ELBOW} to be pre-operational")
STOPPED = (NmtCommand.STOP, f"program has ordered {ELBOW} to be stopped")


def ordered(bus, command):
    """Return what has another master order the elbow's drive to be something."""
    frame = Nmt(command, 3).frame
    return lambda: bus.twin.device.receive((frame,), bus.twin.device.now_s)


@pytest.mark.parametrize(
    ("fault", "words", "strategy"),
    [(*TOO_HOT, "cyclic"), (*ORDERED, "profile"), (*STOPPED, "cyclic"), (*LEFT_BEHIND, "cyclic"),
     (*TOO_HOT, "profile"), (*ORDERED, "cyclic")][: amount(3, 6)],
)  # fmt: skip
def test_it_is_reported_and_mended_in_the_same_program(fault, words, strategy):
    bus = Bus("cia402", settings={"strategy": strategy})
    arm = bus.ready()
    begin = ordered(bus, fault) if isinstance(fault, NmtCommand) else fault
    check_reported_and_stopped(arm, words, FAULT, begin, after_s=0.3, watched_s=1.2)
    check_recovery(arm, bus.motors)
