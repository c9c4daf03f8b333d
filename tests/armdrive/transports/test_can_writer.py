"""The writer of a CAN bus: no hang, no stale frame, and the adapter's refusals in words."""

import contextlib
import errno

import can
import pytest
from can_bench import LONG_S, FailingBus, until_lost
from waiting import returns, soon, until

from armdrive.transports import can_link
from armdrive.transports.can_health import BusState, of_error_frame, of_status
from armdrive.transports.can_link import MOST_AWAKE_S, PATIENCE_S, CanLink
from firmware_protocol.frames import Frame, pack

pytestmark = pytest.mark.usefixtures("short_patience")


class TestWriter:
    def test_a_stuck_adapter_holds_up_nobody_and_is_a_loss(self, failing):
        bus, link = failing
        bus.stuck.clear()
        returns(lambda: link.write(pack(Frame(1)) + pack(Frame(2)), 0.0))
        assert "took no frame" in until_lost(link)
        bus.stuck.set()
        link.close()
        assert [each.arbitration_id for each in bus.sent] == [1]

    def test_frames_written_before_closing_are_sent_first(self, patient, failing):
        bus, link = failing
        bus.stuck.clear()
        link.write(pack(Frame(1)) + pack(Frame(2)), 0.0)
        assert link.waiting == 2
        soon(bus.stuck.set)
        link.close()
        assert [each.arbitration_id for each in bus.sent] == [1, 2]
        assert link.waiting == 0

    def test_a_stuck_adapter_does_not_hold_up_closing(self, failing):
        bus, link = failing
        bus.stuck.clear()
        link.write(pack(Frame(1)) + pack(Frame(2)), 0.0)
        returns(link.close)
        bus.stuck.set()
        assert bus._is_shutdown

    def test_a_transmit_buffer_that_stays_full_is_a_loss(self, failing):
        bus, link = failing
        bus.full = True
        link.write(pack(Frame(1)), 0.0)
        assert "stays full" in until_lost(link)
        assert bus.sent == []

    def test_a_buffer_that_is_full_for_a_moment_is_not(self, patient, failing):
        bus, link = failing
        bus.sending.extend([can.CanOperationError("x", errno.ENOBUFS), can.CanTimeoutError("y")])
        link.write(pack(Frame(1)) + pack(Frame(2)), 0.0)
        until(lambda: len(bus.sent) == 2)
        assert [each.arbitration_id for each in bus.sent] == [1, 2]
        assert link.read(0.0) == b""

    @pytest.mark.parametrize(
        ("error", "words"),
        [(("device unplugged",), "device unplugged"), (("x", errno.ENETDOWN), "interface is down")],
    )
    def test_an_adapter_that_refuses_is_a_loss_in_its_words(self, failing, error, words):
        bus, link = failing
        bus.sending.append(can.CanOperationError(*error))
        link.write(pack(Frame(1)) + pack(Frame(2)), 0.0)
        assert words in until_lost(link)
        link.close()
        assert bus.sent == []

    def test_more_frames_than_any_bus_carries_are_a_loss(self, failing):
        bus, link = failing
        bus.stuck.clear()
        link.write(pack(Frame(1)) * (2 * can_link.MOST_FRAMES), 0.0)
        assert "frames wait to be sent" in until_lost(link)

    def test_nothing_is_sent_periodically_by_anybody_else(self, failing, monkeypatch):
        def periodic(*args, **kwargs):
            pytest.fail("a driver was asked to go on by itself")

        monkeypatch.setattr(can.BusABC, "send_periodic", periodic)
        bus, link = failing
        link.write(pack(Frame(1)), 0.0)
        until(lambda: bus.sent)
        link.close()


class Suspended:
    """A writer on a failing bus, on a clock that the test sets; `end` closes both."""

    def __init__(self, bus: FailingBus | None = None) -> None:
        self.now_s = 0.0
        self.bus = bus or FailingBus()
        self.watch = can_link.Watch(lambda: self.now_s, lambda: None)
        self.writer = can_link.CanWriter(self.bus, self.watch, lambda: self.now_s)

    def stick(self) -> None:
        """Have the adapter hang in the middle of frame 1."""
        self.bus.stuck.clear()
        self.writer.put([Frame(1)])
        until(lambda: self.writer._began_s is not None)

    def end(self) -> list[int]:
        """End the writer; return the ids that were sent."""
        self.bus.stuck.set()
        self.writer.drain(LONG_S)
        self.watch.ended.set()
        self.writer.join(LONG_S)
        self.bus.shutdown()
        return [each.arbitration_id for each in self.bus.sent]


class TestSuspension:
    """What was to be sent before this program was suspended is not sent after it."""

    @pytest.fixture(autouse=True)
    def usual_patience(self, short_patience, monkeypatch):
        monkeypatch.setattr(can_link, "PATIENCE_S", PATIENCE_S)

    def test_frames_that_waited_in_the_queue_are_forgotten(self):
        bench = Suspended()
        bench.stick()
        bench.writer.put([Frame(2), Frame(3)])
        bench.now_s = PATIENCE_S + 0.1
        bench.bus.stuck.set()
        bench.writer.drain(LONG_S)
        bench.writer.put([Frame(4)])
        assert bench.end() == [1, 4]
        assert bench.watch.health.forgotten == 2

    def test_a_frame_in_hand_is_forgotten(self, monkeypatch):
        bench, message = Suspended(), can_link.message_of

        def suspended(frame):
            bench.now_s += 0.5 if frame.can_id == 1 else 0.0
            return message(frame)

        monkeypatch.setattr(can_link, "message_of", suspended)
        bench.writer.put([Frame(1)])
        bench.writer.drain(LONG_S)
        bench.writer.put([Frame(2)])
        assert bench.end() == [2]
        assert bench.watch.health.forgotten == 1

    def test_a_frame_whose_time_ran_out_is_forgotten_and_the_bus_is_not_lost(self, monkeypatch):
        bench, send = Suspended(), FailingBus.send

        def suspended(bus, msg, timeout=None):
            if bench.now_s == 0.0:
                bench.now_s = 20.0
                raise can.CanTimeoutError("the adapter takes nothing more")
            send(bus, msg, timeout)

        monkeypatch.setattr(FailingBus, "send", suspended)
        bench.writer.put([Frame(1)])
        until(lambda: bench.watch.health.forgotten == 1)
        bench.writer.put([Frame(2)])
        assert bench.end() == [2]
        assert bench.watch.lost == ""

    def test_a_suspension_in_mid_frame_is_no_lost_bus(self):
        bench = Suspended()
        bench.stick()
        bench.writer.look()
        bench.now_s = 20.0
        bench.writer.look()
        assert bench.watch.lost == ""
        assert bench.end() == [1]

    def test_an_adapter_that_is_stuck_while_the_program_is_awake_is_lost(self):
        bench = Suspended()
        bench.stick()
        bench.writer.look()
        for _ in range(100):
            bench.now_s += MOST_AWAKE_S / 2.0
            bench.writer.look()
            if bench.watch.lost:
                break
        assert bench.now_s <= PATIENCE_S + MOST_AWAKE_S
        assert "took no frame" in bench.watch.lost
        bench.end()


class TellingBus(FailingBus):
    """A bus whose adapter tells of frames that it did not send, as slcan does."""

    def __init__(self, status: int | None) -> None:
        self.refused = 0
        self.refusing = False
        self.asked = 0
        self._status = status
        self._answer: int | None = None
        super().__init__()

    def send(self, msg, timeout=None):
        self.refused += 1
        self.refusing = True

    def ask(self) -> None:
        self.asked += 1
        self._answer = self._status

    def take_status(self) -> int | None:
        answer, self._answer = self._answer, None
        return answer


REFUSALS = [(None, "refuses frames"), (0x20, "error-passive"), (0xA0, "has left the bus")]


@pytest.mark.parametrize(("status", "words"), REFUSALS)
def test_an_adapter_that_tells_is_asked_why_it_sends_nothing(status, words, monkeypatch):
    monkeypatch.setattr(can_link, "STATE_S", 0.01)
    bus = TellingBus(status)
    with contextlib.closing(CanLink(bus, "can:telling")) as link:
        link.write(pack(Frame(1)), 0.0)
        lost = until_lost(link)
        assert words in lost or (status == 0x20 and "refuses frames" in lost)
        assert link.health.refused == 1
    assert bus.asked == 1 or status == 0x20


ERROR_FRAMES = [
    (0x040, b"", BusState.OFF, "bus-off"),
    (0x020, b"", BusState.PASSIVE, "acknowledged"),
    (0x004, b"\0\x20", BusState.PASSIVE, "error-passive"),
    (0x004, b"\0\x08", BusState.WARNING, "warning limit"),
    (0x004, b"\0\x40", BusState.ACTIVE, "again"),
    (0x100, b"", BusState.ACTIVE, "again"),
    (0x004, b"\0\x01", None, "overflowed"),
    (0x088, bytes(8), None, "protocol error, the bus has an error"),
    (0x200, b"", None, "without a reason"),
]


@pytest.mark.parametrize(("can_id", "data", "state", "words"), ERROR_FRAMES)
def test_error_frames_are_put_into_words(can_id, data, state, words):
    found, said = of_error_frame(can_id, data)
    assert found is state
    assert words in said


STATUSES = [(0x00, BusState.ACTIVE), (0x04, BusState.WARNING), (0x20, BusState.PASSIVE)]


@pytest.mark.parametrize(
    ("status", "state"), [*STATUSES, (0x80, BusState.PASSIVE), (0xA4, BusState.OFF)]
)
def test_the_status_of_an_adapter_is_a_state(status, state):
    assert of_status(status)[0] is state
