"""A link over python-can: what passes, what breaks it, and that nothing ever hangs."""

from __future__ import annotations

import errno
import threading

import can
import pytest
from can_bench import frames_of, message, until_lost
from waiting import FOREVER_S, returns, soon, until

from armdrive.errors import LinkLost
from armdrive.transports import can_threads
from armdrive.transports.can_health import BusState
from armdrive.transports.opening import open_link
from firmware_protocol.frames import Frame, pack

BUS_OFF = message(0x040, bytes(8), is_error_frame=True)
NO_ACK = message(0x020, bytes(8), is_error_frame=True)


pytestmark = pytest.mark.usefixtures("short_patience", "never_stale")


@pytest.fixture
def pair(request):
    """Two links on one virtual bus of the test's own."""
    links = [open_link(f"can:virtual:{request.node.name}", 0) for _ in range(2)]
    yield links
    for link in links:
        link.close()


class TestFrames:
    def test_frames_pass_both_ways_in_their_order(self, pair):
        one, other = pair
        sent = [Frame(5, b"hello"), Frame(0x1ABCDEF0, b"\r\n", extended=True)]
        sent.append(Frame(7, remote=True))
        one.write(b"".join(map(pack, sent)), 0.0)
        assert frames_of(other, 3) == sent
        other.write(pack(Frame(6)), 0.0)
        assert frames_of(one) == [Frame(6)]
        assert (one.health.heard, other.health.heard) == (1, 3)

    def test_half_a_frame_is_sent_with_its_other_half(self, pair):
        one, other = pair
        packed = pack(Frame(5, b"abc"))
        one.write(packed[:3], 0.0)
        one.write(packed[3:], 0.0)
        assert frames_of(other) == [Frame(5, b"abc")]

    def test_only_ids_that_are_asked_for_are_heard(self, request):
        where = f"can:virtual:{request.node.name}"
        one, other = open_link(where, 0), open_link(f"{where}?ids=2,0x10", 0)
        one.write(b"".join(pack(Frame(each)) for each in (1, 2, 3, 16, 17)), 0.0)
        assert [each.can_id for each in frames_of(other, 2)] == [2, 16]
        one.close()
        other.close()

    def test_frames_of_another_kind_and_ones_own_are_passed_over(self, failing):
        bus, link = failing
        bus.coming.append(message(1, bytes(12), is_fd=True, dlc=12))
        bus.coming.append(message(2, is_rx=False))
        bus.coming.append(message(3))
        assert frames_of(link) == [Frame(3)]

    def test_of_a_flood_the_oldest_frames_are_dropped_and_counted(self, failing, monkeypatch):
        monkeypatch.setattr(can_threads, "MOST_UNREAD_FRAMES", 4)
        bus, link = failing
        bus.coming.extend(message(each) for each in range(10))
        until(lambda: link.health.heard == 10)
        assert [each.can_id for each in frames_of(link, 4)] == [6, 7, 8, 9]
        assert link.health.overrun == 6

    def test_waking_ends_a_wait(self, failing):
        _, link = failing
        soon(link.wake)
        returns(lambda: link.wait(FOREVER_S))

    def test_a_closed_link_says_so_and_its_threads_are_gone(self, request):
        link = open_link(f"can:virtual:{request.node.name}", 0)
        link.close()
        link.close()
        for use in (lambda: link.write(b"", 0.0), lambda: link.read(0.0)):
            with pytest.raises(LinkLost, match="closed"):
                use()
        assert not [each for each in threading.enumerate() if each.name.startswith("armdrive-can")]

    def test_an_engine_may_close_a_link_that_was_lost(self, failing):
        bus, link = failing
        bus.coming.append(BUS_OFF)
        until_lost(link)
        link.close()
        assert bus._is_shutdown


class TestReader:
    def test_errors_of_the_bus_are_survived(self, patient, failing):
        bus, link = failing
        bus.coming.extend([can.CanOperationError("error warning limit"), ValueError("odd")])
        bus.coming.append(message(1))
        assert frames_of(link) == [Frame(1)]
        assert link.health.read_errors == 2

    def test_errors_that_never_end_are_a_loss(self, failing):
        bus, link = failing
        bus.always = can.CanOperationError("error warning limit exceeded")
        assert "error warning limit exceeded" in until_lost(link)

    @pytest.mark.parametrize("number", [errno.ENODEV, errno.ENETDOWN, errno.EIO])
    def test_an_adapter_that_has_gone_is_a_loss_at_once(self, failing, number):
        bus, link = failing
        bus.coming.append(can.CanOperationError("failed to receive", number))
        assert "gone" in until_lost(link)
        assert link.health.read_errors == 1

    def test_what_came_before_the_loss_is_handed_out_first(self, failing):
        bus, link = failing
        bus.coming.extend([message(1), BUS_OFF])
        until(lambda: link.health.error_frames)
        assert link.read(0.0) == pack(Frame(1))
        assert "has left the bus" in until_lost(link)


class TestState:
    def test_bus_off_is_a_loss_at_once(self, failing):
        bus, link = failing
        bus.coming.append(BUS_OFF)
        lost = until_lost(link)
        assert "bus-off" in lost
        assert "120 ohm" in lost
        assert link.health.state is BusState.OFF
        with pytest.raises(LinkLost, match="bus-off"):
            link.write(pack(Frame(1)), 0.0)

    def test_a_driver_that_knows_of_bus_off_is_believed(self, failing):
        bus, link = failing
        bus.broken = can.BusState.ERROR
        assert "its driver reports so" in until_lost(link)

    def test_error_passive_that_lasts_is_a_loss(self, failing):
        bus, link = failing
        bus.coming.append(NO_ACK)
        assert "no node acknowledged" in until_lost(link)
        assert link.health.state is BusState.PASSIVE

    def test_error_passive_is_forgiven_once_a_frame_is_heard(self, patient, failing, monkeypatch):
        bus, link = failing
        bus.coming.extend([NO_ACK, message(1)])
        assert frames_of(link) == [Frame(1)]
        monkeypatch.setattr(can_threads, "WATCH_PATIENCE_S", 0.0)
        link.wait(0.2)
        assert link.read(0.0) == b""
        assert link.health.state is BusState.PASSIVE
        assert link.health.error_frames == 1
        assert "acknowledged" in link.health.last_trouble
