"""An MKS drive that rejects orders stops the whole arm soon, since motors can be coupled."""

from __future__ import annotations

from itertools import pairwise

import pytest
from mks_bench import BURSTS, MksBench, along, begun, requests, straight

from armdrive.dialects.bus.ledger import START_WINDOW_S, Rejections
from armdrive.tasks import Done, MoveBy, RequestRejected
from firmware_protocol.mks import Code, Mode, MoveAbsoluteAxis, ReadStall, Stop
from kinematics import Motors

TOGETHER = (2000, 0, 0, 2000, 2000, 0)
"""Both wrist motors go alike: the hand pitches, and does not roll."""
STARTED = 1
PERIOD_S = 0.04
SPEED = 20_000.0
WHY = (Code.STALL, Code.ENABLED, Code.MODE)
"""The readings and the setting that tell why a drive takes no orders."""


def apart(bench: MksBench) -> int:
    """Return how far the wrist's motors, which should go alike, are apart."""
    return abs(bench.positions[3] - bench.positions[4])


@pytest.mark.parametrize("after_s", [0.2, 0.23, 0.31])
def test_a_wrist_motor_that_rejects_orders_stops_the_other_one_at_once(after_s):
    bench = MksBench().ready()
    bench.at_s[bench.now_s + after_s] = lambda: bench.node(5).set_mode(Mode.PULSE_FOC)
    reply = bench.do(along(straight(10, way=TOGETHER)))
    assert isinstance(reply, RequestRejected)
    assert "drive 5 (left wrist) is in mode 2" in reply.reason
    noticed_s = 2.0 * PERIOD_S + 2.0 * START_WINDOW_S + 0.01
    assert apart(bench) <= SPEED * (noticed_s + bench.controller.ramp_s / 2.0)


def test_a_silent_wrist_motor_stops_the_other_one_once_it_is_mute():
    bench = begun(straight(10, way=TOGETHER), 0.3)
    bench.node(5).sim.port.mute = True
    farthest = 0
    while bench.reply() is None:
        bench.run(0.01)
        farthest = max(farthest, apart(bench))
    assert farthest <= SPEED * PERIOD_S


def test_a_stop_does_not_wait_for_the_answers_of_a_drive_that_rejects_orders():
    """Its answers are lost for a while, and the arm is stopped meanwhile."""
    bench = MksBench().ready()
    bench.loses = lambda frame, host: not host and frame.can_id == 5 and frame.data[0] in WHY
    bench.begin(along(straight(10, way=TOGETHER)))
    bench.run(0.2)
    bench.node(5).set_mode(Mode.PULSE_FOC)
    bench.run(2.0 * PERIOD_S + 2.0 * START_WINDOW_S + 0.01)
    assert requests(bench, ReadStall)
    bench.controller.stop(hard=False)
    bench.run(0.001)
    stopped = {node for _, node, _ in requests(bench, Stop)}
    assert {1, 4} <= stopped


def test_an_unchanged_order_is_repeated():
    bench = MksBench().ready()
    at_60_rpm = Motors(4 * count for count in (8192, 0, 0, 8192, 8192, 0))
    bench.do(along([MoveBy(at_60_rpm, 16_384.0)]))
    at_s = [at_s for at_s, *_ in requests(bench, MoveAbsoluteAxis, node=5)]
    assert max(b - a for a, b in pairwise(at_s)) <= 2.0 * PERIOD_S + 1e-3
    assert at_s[-1] - at_s[0] > 1.5


def test_a_burst_ends_soon_if_a_drive_rejects_its_order():
    bench = MksBench(settings=BURSTS, firmware=(1, 0, 6)).ready()
    ways = Motors(8 * way for way in TOGETHER)
    bench.at_s[bench.now_s + 0.2] = lambda: bench.node(5).set_mode(Mode.PULSE_FOC)
    reply = bench.do(MoveBy(ways, SPEED))
    assert isinstance(reply, RequestRejected)
    assert "drive 5 (left wrist) is in mode 2" in reply.reason
    assert apart(bench) <= SPEED * 0.12


@pytest.mark.parametrize("lost", [0, 1, 2])
def test_a_started_report_may_be_lost(lost):
    bench = MksBench().ready()
    count = [0]

    def loses(frame, host):
        data = frame.data
        began = not host and data[0] == Code.ABSOLUTE_AXIS and data[1] == STARTED
        count[0] += began
        return began and count[0] % 3 == lost

    bench.loses = loses
    assert isinstance(bench.do(along(straight())), Done)
    assert count[0] > 30
    assert not bench.alerts()


@pytest.mark.parametrize("first", ["refused", "taken"])
def test_reports_that_come_together_are_of_one_order(first):
    denials = Rejections()
    then = {"refused": "taken", "taken": "refused"}[first]
    getattr(denials, first)(1.0)
    getattr(denials, then)(1.0 + START_WINDOW_S / 2.0)
    assert denials.due_s > 1e9


def test_after_two_rejections_the_drive_is_examined():
    denials = Rejections()
    denials.taken(0.5)
    denials.refused(1.0)
    assert denials.due_s == pytest.approx(1.0 + START_WINDOW_S)
    assert not denials.confirm()
    denials.refused(1.02)
    assert denials.confirm()


@pytest.mark.parametrize("count", [0, 5, 6])
def test_a_rejected_order_is_repeated_once_before_the_drive_is_asked_why(count):
    """Drive 5 stands during the first segments; some of its first orders come with a poll."""
    bench = MksBench().ready()
    first, then = Motors((2000, 0, 0, 2000, 0, 0)), Motors(TOGETHER)
    bench.node(5).set_mode(Mode.PULSE_FOC)
    began_s = bench.now_s
    bench.begin(along([MoveBy(way, SPEED) for way in (*[first] * count, *[then] * 20)]))
    bench.run(1.0)
    sent = [frame.data for at_s, frame in bench.sent if frame.can_id == 5 and at_s >= began_s]
    asked = next(index for index, data in enumerate(sent) if data[0] == Code.STALL)
    order = next(data for data in sent if data[0] == Code.ABSOLUTE_AXIS)
    assert sent[:asked].count(order) == 2
