"""How soon a Robko 01 is told of a stop that comes while its driver waits for an answer."""

from __future__ import annotations

from robko_bench import ready_robko

from firmware_protocol.robko01 import Op

ANSWERED_S = 0.01
"""A look and its answer take 4 ms on the wire."""


def test_a_stop_during_a_look_goes_out_as_soon_as_the_look_is_answered():
    arm = ready_robko()
    link, asked_s, said_s = arm.twin.link, [], []

    def watch(op):
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
