"""What was to be said on a CAN bus before this program was suspended is not said after it."""

from __future__ import annotations

import can
from can_bench import LONG_S, FailingBus
from waiting import until

from armdrive.transports.can_threads import MOST_AWAKE_S, PATIENCE_S, CanWriter, Watch
from firmware_protocol.frames import Frame


def test_a_frame_that_waited_while_the_program_was_suspended_is_forgotten():
    now_s = [0.0]
    bus, watch = FailingBus(), Watch(lambda: now_s[0], lambda: None)
    writer = CanWriter(bus, watch, lambda: now_s[0])
    bus.stuck.clear()
    writer.put([Frame(1)])
    until(lambda: writer._began_s is not None)
    writer.put([Frame(2), Frame(3)])
    now_s[0] = PATIENCE_S + 0.1
    bus.stuck.set()
    until(lambda: not writer.waiting)
    writer.put([Frame(4)])
    until(lambda: len(bus.sent) == 2)
    watch.ended.set()
    writer.join(LONG_S)
    assert [each.arbitration_id for each in bus.sent] == [1, 4]
    assert watch.health.forgotten == 2


def stuck_writer(now_s):
    bus, watch = FailingBus(), Watch(lambda: now_s[0], lambda: None)
    writer = CanWriter(bus, watch, lambda: now_s[0])
    bus.stuck.clear()
    writer.put([Frame(1)])
    until(lambda: writer._began_s is not None)
    writer.look()
    return bus, watch, writer


def test_a_program_that_was_suspended_in_mid_frame_has_lost_no_bus():
    now_s = [0.0]
    bus, watch, writer = stuck_writer(now_s)
    now_s[0] = 20.0
    writer.look()
    assert watch.lost == ""
    bus.stuck.set()
    until(lambda: len(bus.sent) == 1)
    watch.ended.set()
    writer.join(LONG_S)


def test_an_adapter_that_is_stuck_while_the_program_is_awake_is_lost():
    now_s = [0.0]
    bus, watch, writer = stuck_writer(now_s)
    looks = 0
    while not watch.lost:
        now_s[0] += MOST_AWAKE_S / 2.0
        writer.look()
        looks += 1
        assert looks < 100
    assert now_s[0] <= PATIENCE_S + MOST_AWAKE_S
    assert "took no frame" in watch.lost
    bus.stuck.set()
    writer.join(LONG_S)


class SleepyBus(FailingBus):
    """A bus on which the program is suspended in the middle of a frame."""

    def __init__(self, now_s) -> None:
        super().__init__()
        self.now_s = now_s
        self.asleep_s = 20.0

    def send(self, msg, timeout=None):
        if self.asleep_s:
            self.now_s[0] += self.asleep_s
            self.asleep_s = 0.0
            raise can.CanTimeoutError("the adapter takes nothing more")
        super().send(msg, timeout)


def test_a_frame_whose_time_ran_out_in_a_suspension_is_forgotten_and_the_bus_is_not_lost():
    now_s = [0.0]
    bus = SleepyBus(now_s)
    watch = Watch(lambda: now_s[0], lambda: None)
    writer = CanWriter(bus, watch, lambda: now_s[0])
    writer.put([Frame(1)])
    until(lambda: watch.health.forgotten == 1)
    writer.put([Frame(2)])
    until(lambda: len(bus.sent) == 1)
    assert watch.lost == ""
    watch.ended.set()
    writer.join(LONG_S)
    assert [each.arbitration_id for each in bus.sent] == [2]
