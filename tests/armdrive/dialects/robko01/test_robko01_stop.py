"""How soon a Robko 01 is told of a stop that comes while its driver waits for an answer."""

from __future__ import annotations

from faults import Rule
from robko_bench import of, op_of, ready_robko

from armdrive import Jog
from armdrive.status import Trust
from firmware_protocol.robko01 import Op

ANSWERED_S = 0.01
"""A look and its answer take 4 ms on the wire."""
FAR_STEPS = 200
"""More than a burst makes."""


def test_a_stop_during_a_look_goes_out_as_soon_as_the_look_is_answered():
    arm = ready_robko()
    link, asked_s, said_s = arm.twin.link, [], []

    def watch(written):
        op = op_of(written)
        if op is Op.POSITION and arm.twin.device.moving and not asked_s:
            arm.request_stop()
            asked_s.append(arm.engine.now_s)
        elif op is Op.STOP:
            said_s.append(arm.engine.now_s)

    arm.move_j(base_deg=40, wait=False)
    link.on_write = watch
    arm.sleep(2.0)
    assert asked_s
    assert said_s[0] - asked_s[0] <= ANSWERED_S


def test_a_motor_that_a_stop_left_far_beyond_its_target_is_not_believed():
    """The firmware's arithmetic takes it three steps beyond at most; what goes further is moved."""
    arm = ready_robko()
    link, stopped, moved = arm.twin.link, [], []

    def watch(written):
        op = op_of(written)
        if op is Op.STOP:
            stopped.append(op)
        elif op is Op.POSITION and stopped and not moved and not arm.twin.device.moving:
            moved.append(op)
            arm.twin.device.jog((FAR_STEPS, 0, 0, 0, 0, 0))

    arm.move_j(base_deg=40, wait=False)
    link.on_write = watch
    arm.sleep(0.5)
    arm.request_stop()
    arm.sleep(2.0)
    assert moved
    assert arm.status.trust is Trust.SUSPECT
    assert arm.twin.world.motors == arm.status.acknowledged


def test_a_lost_jog_is_not_sent_again_once_it_is_released():
    arm = ready_robko()
    link, sent, before = arm.twin.link, [], arm.twin.world.motors

    def lose(frame):
        sent.append(frame)
        arm.release()
        return []

    link.to.append(Rule(of(Op.MOVE_ABSOLUTE), lose, skip=1, times=9))  # the first one is at speed 0
    arm.hold(Jog.joint(base=1.0), speed=1.0, for_s=1.0)
    arm.sleep(2.0)
    assert len(sent) == 1
    assert arm.twin.world.motors == before
