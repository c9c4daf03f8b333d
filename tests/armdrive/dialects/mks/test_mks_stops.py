"""Stops of MKS drives: heard by all, within the bound, and no shaft springs afterwards."""

from __future__ import annotations

import pytest
from amounts import each_value
from driver_bench import ANSWERS
from mks_bench import (
    AHEAD_S,
    FAR_FROM_ZERO,
    MksBench,
    along,
    begun,
    check_halted,
    requests,
    segments,
    straight,
)
from test_mks_arm import ready

from armdrive.dialects.mks.stops import STOP_POLL_S
from armdrive.errors import ArmError
from armdrive.status import State, Trust
from armdrive.tasks import (
    AlertKind,
    ClearFault,
    DropCurrent,
    Halted,
    MoveBy,
    ProtocolWarning,
    RequestRejected,
    SwitchOn,
)
from firmware_protocol.mks import (
    Code,
    EmergencyStop,
    Mode,
    MoveAbsoluteAxis,
    ReadAngleError,
    Stop,
    decode_request,
)
from kinematics import Motors

# -- the stop reaches every drive ------------------------------------------------------------------

WAY = (0, 0, 0, 3000, -3000, 0)
"""Counts in 0.1 s, of the two motors of a wrist."""
SOON_S = 0.005


def stops_of(bench, number, since_s=0.0):
    """Return when one drive was told to stop since a time, and each stop."""
    found = requests(bench, Stop, EmergencyStop, node=number, since_s=since_s)
    return [(at_s, stop) for at_s, _, stop in found]


@each_value("lost_s, hard, of_host", [0.01, 0.055, 0.105, 0.3], [False, True], [True, True, False])
def test_a_stop_is_repeated_until_the_drive_stands(lost_s, hard, of_host):
    bench = begun(straight(12, WAY), 0.8)
    until_s = bench.now_s + lost_s
    bench.loses = lambda frame, host: (
        frame.can_id == 4 and bench.now_s < until_s and host is of_host
    )
    check_halted(bench, hard=hard)
    heard_s = until_s if of_host else 0.0
    first_s, _ = stops_of(bench, 4, heard_s)[0]
    assert first_s <= max(heard_s, stops_of(bench, 4)[0][0]) + STOP_POLL_S + SOON_S


def test_an_emergency_stop_in_a_stop_is_sent_at_once():
    bench = begun(straight(12, WAY), 0.8)
    bench.controller.stop(hard=False)
    bench.run(0.005)
    asked_s = bench.now_s
    check_halted(bench, hard=True)
    at_s, stop = stops_of(bench, 4, asked_s)[0]
    assert stop == EmergencyStop()
    assert at_s == pytest.approx(asked_s, abs=0.002)


def test_an_emergency_stop_gives_drives_above_1000_rpm_a_ramp():
    bench = begun(straight(12, (30_000, -3000, 0, 0, 0, 0)), 0.8)
    asked_s = bench.now_s
    check_halted(bench, hard=True)
    assert isinstance(stops_of(bench, 1, asked_s)[0][1], Stop)
    assert stops_of(bench, 2, asked_s)[0][1] == EmergencyStop()


def test_drives_that_know_no_emergency_stop_are_stopped_without_a_ramp():
    bench = MksBench((1, 0, 3), {"firmware": "1.0.3"}, FAR_FROM_ZERO).ready()
    bench.begin(MoveBy(Motors((30_000, -9000, 0, 0, 0, 0)), 30_000.0))
    bench.run(0.3)
    asked_s = bench.now_s
    check_halted(bench, hard=True)
    assert stops_of(bench, 1, asked_s)[0][1] == Stop(0)


@pytest.mark.parametrize("later_s", [0.002, 0.005, 0.012])
def test_a_drive_that_gets_its_last_order_after_the_stop_is_stopped_again(later_s):
    """Mission mks 690000069: the stop had overtaken the order, and the drive had said it brakes."""
    bench = begun(straight(12, WAY), 0.8)
    orders = [frame for _, frame in bench.sent if frame.can_id == 4 and frame.data[0] == 0xF5]
    stopped_s = bench.now_s
    bench.at_s[stopped_s + later_s] = lambda: bench.node(4).receive(orders[-1])
    check_halted(bench)
    assert any(
        stopped_s + later_s <= at_s <= stopped_s + later_s + STOP_POLL_S + SOON_S
        for at_s, _ in stops_of(bench, 4)
    )


@pytest.mark.parametrize("silent_s", [0.06, 0.1, 0.15])
def test_a_late_drive_in_a_stop_near_zero_is_no_restart(silent_s):
    bench = MksBench(starts=(0, 50_000, 0, 0, 0, 0)).ready()
    bench.begin(along(straight(30, (1000, 3000, 0, 0, 0, 0))))
    bench.run(0.5)
    bench.delay_frames(silent_s, ANSWERS, node=1)
    bench.run(0.02)
    check_halted(bench)


@pytest.mark.parametrize(
    ("after_s", "acceleration"),
    [(0.42, 252), (0.5, 252), (0.515, 252), (0.52, 252), (0.59, 240), (0.61, 240)],
)
def test_a_stop_near_the_end_of_a_motion_takes_no_drive_past_it(after_s, acceleration):
    way = (6000, -3000, 1500, 0, 700, 20)
    bench = begun(straight(5, way), after_s, acceleration=acceleration)
    check_halted(bench)
    gone = [here - 50_000 for here in bench.positions]
    assert all(abs(count) <= 5 * abs(each) + 1 for count, each in zip(gone, way, strict=True))


# -- if the host dies, a drive that has lost orders also stops as soon as announced ----------------

FAST, SLOW = (9000, -3000, 700, 0, 0, 0), (90, -30, 7, 0, 0, 0)
MOST_S = 2.0
LOOK_S = 0.005
PATHS = [segments(*([FAST] * 5 + [SLOW] * tail)) for tail in (0, 1, 4)]
PATHS.append(segments(*([(3000, -900, 0, 0, 0, 0)] * 3 + [(60, -20, 0, 0, 0, 0)] * 6)))


@each_value(
    "later_s, lost, moves", [0.02, 0.12, 0.25], [(0.02, 0.4), (0.2, 0.65), (0.5, 0.75)], PATHS
)
def test_a_drive_that_lost_orders_stops_as_soon_as_announced(moves, lost, later_s):
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    began_s = bench.now_s
    bench.loses = lambda frame, host: (
        host
        and frame.can_id == 1
        and frame.data[0] == Code.ABSOLUTE_AXIS
        and lost[0] <= bench.now_s - began_s < lost[1]
    )
    bench.begin(along(moves))
    bench.run(lost[1] + later_s)
    bench.dead = True
    dead_s, stood_s, before = bench.now_s, bench.now_s, bench.positions
    while bench.now_s < dead_s + MOST_S:
        bench.run(LOOK_S)
        if bench.positions != before:
            before, stood_s = bench.positions, bench.now_s
    assert stood_s - dead_s <= bench.controller.stopping(AHEAD_S).silent_s + LOOK_S


# -- a shaft that is blocked around a stop does not spring when it comes free ----------------------


def blocked_around_a_stop(motor, acts):
    """Return an arm whose shaft was blocked around its stop, and has stood for a second since.

    `acts` happen in a motion one after the other: "stop", "estop", "block", or a pause in s.
    """
    arm = ready()
    handle = arm.move_j(base_deg=60, shoulder_deg=60, elbow_deg=-50, wait=False)
    arm.sleep(0.5)
    for act in acts:
        if act == "block":
            arm.twin.faults.add("stall", str(motor))
        elif act == "stop":
            arm.request_stop()
        elif act == "estop":
            arm.estop()
        else:
            arm.sleep(act)
    arm.sleep(1.0)
    with pytest.raises(ArmError):
        handle.wait()
    return arm


def check_does_not_spring(arm):
    """Check that no shaft turns when it comes free."""
    stood = arm.twin.world.motors
    arm.twin.faults.end()
    arm.sleep(1.5)
    assert (arm.twin.world.motors - stood).largest <= arm.config.device.in_position_counts
    return stood


UNNOTICED_S = 0.05
"""Too short for a blocked shaft to be noticed."""


@pytest.mark.parametrize(
    ("motor", "acts"),
    [
        *((motor, ("stop", after_s, "block")) for motor in (1, 3) for after_s in (0.0, 0.04)),
        (3, ("block", UNNOTICED_S, "estop")),
        # an emergency stop behind a stop may fall into what the first one does
        *((2, ("block", UNNOTICED_S, "stop", again_s, "estop")) for again_s in (0.02, 0.25)),
        (2, ("block", 0.5)),
    ],
)
def test_a_shaft_that_is_blocked_around_a_stop_does_not_spring_when_it_is_free(motor, acts):
    arm = blocked_around_a_stop(motor, acts)
    stood = check_does_not_spring(arm)
    if "estop" not in acts:
        assert (stood - arm.status.acknowledged).largest <= 8


def test_a_drive_that_pressed_is_named_and_the_arm_works_again_afterwards():
    arm = blocked_around_a_stop(1, ("stop", "block"))
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.trust is Trust.SUSPECT
    assert "drive 1 (base) pressed" in arm.status.trust_reason
    arm.twin.faults.end()
    arm.reset()
    world = arm.twin.world
    arm.reference.declare(world.joints, opening_mm=world.opening_mm)
    arm.move_j(base_deg=10)
    assert arm.twin.world.motors == arm.status.acknowledged


def test_a_shaft_that_was_blocked_when_the_cable_was_pulled_is_relieved_by_enable():
    arm = ready()
    handle = arm.move_j(base_deg=60, speed=0.05, wait=False)  # its protection bears that
    arm.sleep(1.0)
    arm.twin.faults.add("stall", "1")
    arm.twin.faults.add("unplug")
    arm.sleep(1.5)
    with pytest.raises(ArmError):
        handle.wait()
    arm.twin.faults.end("unplug")
    arm.reconnect()
    arm.reset()
    arm.enable()
    check_does_not_spring(arm)
    assert arm.status.trust is Trust.SUSPECT


def eased(bench, number, since_s=0.0):
    """Return where a drive was sent since a moment."""
    found = requests(bench, MoveAbsoluteAxis, node=number, since_s=since_s)
    return [order.counts for _, _, order in found]


@pytest.mark.parametrize(("counts", "sent"), [(-700, True), (700, True), (5, False), (-8, False)])
def test_only_a_drive_that_rests_too_far_off_is_relieved(counts, sent):
    bench = begun(straight(20), 0.3)
    bench.controller.stop(hard=False)
    asked_s = bench.now_s
    bench.node(1).load(counts)
    assert isinstance(bench.finish(), Halted)
    orders = eased(bench, 1, asked_s)
    assert len(orders) == sent  # once only, though the load stays
    assert [alert.kind for alert in bench.alerts()] == [AlertKind.OFF_PATH] * sent
    assert all(abs(order - bench.node(1).set_point) <= 1 for order in orders)
    assert not any(eased(bench, node, asked_s) for node in (2, 3, 4, 5, 6))


def test_a_drive_that_pushes_and_rejects_its_relief_is_reported():
    bench = begun(straight(20), 0.3)
    bench.node(1).block()
    bench.run(0.02)
    bench.node(1).set_mode(Mode.PULSE_FOC)
    bench.controller.stop(hard=False)
    bench.finish()
    (text,) = (alert.text for alert in bench.alerts() if "drive 1 (base) press" in alert.text)
    assert "rejects the order to stay where it is" in text
    assert "springs when it comes free" in text


def test_a_drive_without_angle_error_is_stopped_too():
    bench = begun(straight(20), 0.3)
    bench.loses = lambda frame, host: host and isinstance(decode_request(frame), ReadAngleError)
    check_halted(bench)


@each_value("counts, asked, is_armed", [-700, 700], [SwitchOn(), ClearFault()], [False, True])
def test_enable_and_reset_relieve_a_drive_that_pushes_and_no_other(counts, asked, is_armed):
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    assert not any(eased(bench, node) for node in range(1, 7))
    bench.node(2).load(counts)
    bench.node(2).sim.motion.armed = is_armed  # by another program
    assert str(bench.do(asked)) == "done"
    assert set(eased(bench, 2)) == {50_000 + counts}
    assert abs(bench.node(2).set_point - (50_000 + counts)) <= 1
    assert not any(eased(bench, node) for node in (1, 3, 4, 5, 6))
    assert not bench.alerts()
    (odd,) = (event for event in bench.heard if isinstance(event, ProtocolWarning))
    assert "drive 2 (shoulder) pressed" in odd.text


def test_a_reset_sends_no_motion_to_drives_without_current():
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.do(DropCurrent())
    bench.node(2).load(700)
    bench.do(ClearFault())
    assert not eased(bench, 2)


def test_a_reset_fails_if_a_drive_that_pushes_cannot_be_relieved():
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.node(2).load(700)
    bench.node(2).set_mode(Mode.PULSE_FOC)
    reply = bench.do(ClearFault())
    assert isinstance(reply, RequestRejected)
    assert "drive 2 (shoulder) is in mode 2" in reply.reason
    assert not reply.moved
    bench.node(2).set_mode(Mode.BUS_FOC)
    assert str(bench.do(ClearFault())) == "done"
