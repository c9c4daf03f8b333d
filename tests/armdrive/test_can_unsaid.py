"""What was to be said on a CAN bus before this program was suspended is not said after it."""

from __future__ import annotations

from can_bench import LONG_S, FailingBus
from served import until

from armdrive.transports.can_watch import Watch
from armdrive.transports.can_writer import PATIENCE_S, Writer
from firmware_protocol.frames import Frame


def test_a_frame_that_waited_while_the_program_was_suspended_is_forgotten():
    now_s = [0.0]
    bus, watch = FailingBus(), Watch(lambda: now_s[0], lambda: None)
    writer = Writer(bus, watch, lambda: now_s[0])
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
