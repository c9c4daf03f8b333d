"""A drive that pushes a blocked shaft as it stops is relieved, and reported."""

from __future__ import annotations

import pytest
from mks_bench import FAR_FROM_ZERO, MksBench, along, begun, requests, straight
from test_mks_arm import ready

from armdrive.errors import ArmError
from armdrive.status import State, Trust
from armdrive.tasks import (
    AlertKind,
    ClearFault,
    DropCurrent,
    Halted,
    ProtocolWarning,
    RequestRejected,
    SwitchOn,
)
from firmware_protocol.mks import (
    Mode,
    MoveAbsoluteAxis,
    ReadAngleError,
    decode_request,
)


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
        *((motor, ("block", UNNOTICED_S, "estop")) for motor in (2, 3)),
        # an emergency stop behind a stop may fall into what the first one does
        *((2 + index % 2, ("block", UNNOTICED_S, "stop", again_s, "estop"))
          for index, again_s in enumerate((0.02, 0.1, 0.25, 0.4))),
    ],
)  # fmt: skip
def test_a_shaft_that_is_blocked_around_a_stop_does_not_spring_when_it_is_free(motor, acts):
    arm = blocked_around_a_stop(motor, acts)
    stood = check_does_not_spring(arm)
    if "estop" not in acts:
        assert (stood - arm.status.acknowledged).largest <= 8


def test_a_drive_that_pressed_is_named_and_the_arm_works_again_afterwards():
    arm = blocked_around_a_stop(1, ("stop", "block"))
    assert arm.status.state is State.ERROR_STOP
    assert arm.status.trust is Trust.SUSPECT
    assert "drive 1 (base)" in arm.status.trust_reason
    assert "pressed" in arm.status.trust_reason
    arm.twin.faults.end()
    arm.reset()
    world = arm.twin.world
    arm.reference.declare(world.joints, opening_mm=world.opening_mm)
    arm.move_j(base_deg=10)
    assert arm.twin.world.motors == arm.status.acknowledged


def test_no_shaft_springs_back_after_a_blocked_motion():
    arm = ready()
    arm.twin.device.at(arm.parts.pace.now_s() + 0.4, lambda: arm.twin.faults.add("stall", "2"))
    with pytest.raises(ArmError):
        arm.move_j(shoulder_deg=60)
    stood = check_does_not_spring(arm)
    assert arm.twin.world.motors == stood


def eased(bench, number, since_s):
    """Return where a drive was sent since a moment."""
    found = requests(bench, MoveAbsoluteAxis, node=number, since_s=since_s)
    return [order.counts for _, _, order in found]


def stopped(bench, after_s=0.3):
    bench.begin(along(straight(20)))
    bench.run(after_s)
    bench.controller.stop(hard=False)
    return bench.now_s


@pytest.mark.parametrize(("counts", "sent"), [(-700, True), (700, True), (5, False), (-8, False)])
def test_only_a_drive_that_rests_too_far_off_is_relieved(counts, sent):
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    asked_s = stopped(bench)
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
    bench = MksBench(starts=FAR_FROM_ZERO).ready()

    def loses(frame, host):
        return host and isinstance(decode_request(frame), ReadAngleError)

    bench.loses = loses
    stopped(bench)
    assert isinstance(bench.finish(), Halted)
    assert not bench.alerts()


def test_a_blocked_drive_that_rests_off_its_path_is_reported_once():
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.node(1).block()
    assert isinstance(bench.do(along(straight(20))), RequestRejected)
    assert len(bench.alerts()) == 1


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


@pytest.mark.parametrize("asked", [SwitchOn(), ClearFault()], ids=["enable", "reset"])
@pytest.mark.parametrize("counts", [-700, 700])
def test_enable_and_reset_relieve_a_drive_that_pushes_once(counts, asked):
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.node(2).load(counts)
    began_s = bench.now_s
    assert str(bench.do(asked)) == "done"
    (order,) = eased(bench, 2, began_s)
    assert order == 50_000 + counts
    assert not any(eased(bench, node, began_s) for node in (1, 3, 4, 5, 6))
    assert not bench.alerts()
    (odd,) = (event for event in bench.heard if isinstance(event, ProtocolWarning))
    assert "drive 2 (shoulder) pressed" in odd.text


@pytest.mark.parametrize("asked", [SwitchOn(), ClearFault()], ids=["enable", "reset"])
def test_a_drive_that_another_program_has_armed_is_relieved_too(asked):
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.node(2).load(700)
    bench.node(2).sim.motion.armed = True
    assert str(bench.do(asked)) == "done"
    assert abs(bench.node(2).set_point - (50_000 + 700)) <= 1


@pytest.mark.parametrize("asked", [SwitchOn(), ClearFault()], ids=["enable", "reset"])
def test_enable_and_reset_send_no_motion_to_a_drive_that_does_not_push(asked):
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.do(asked)
    assert not any(eased(bench, node, 0.0) for node in range(1, 7))


def test_a_reset_sends_no_motion_to_drives_without_current():
    bench = MksBench(starts=FAR_FROM_ZERO).ready()
    bench.do(DropCurrent())
    bench.node(2).load(700)
    bench.do(ClearFault())
    assert not eased(bench, 2, 0.0)


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
