"""The wire of simulated drives: bits and adapters."""

import itertools
import random

import pytest
from amounts import every_row
from can_bench import EchoDrive
from hypothesis import given
from hypothesis import strategies as st

from armdrive.errors import LinkLost
from armdrive.sim.bus.line import BusLine, BusSide, FrameBus
from armdrive.sim.serving.servers import Adapter
from armdrive.sim.wire import (
    MemoryLink,
    Next,
    Nth,
    Rule,
    Share,
    changed,
    late,
    lost,
    overtaken,
    repeated,
)
from armdrive.transports.can_health import frame_bits
from firmware_protocol.frames import (
    LONGEST_LINE,
    Frame,
    SlcanLines,
    Unpacker,
    frame_of,
    line_of,
    pack,
)

BITRATE = 500_000


@st.composite
def frames(draw) -> Frame:
    extended, remote = draw(st.booleans()), draw(st.booleans())
    can_id = draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF))
    data = b"" if remote else draw(st.binary(max_size=8))
    return Frame(can_id, data, extended, remote)


def test_a_frame_has_the_length_that_the_literature_says():
    data = bytes(8)
    assert (frame_bits(Frame(1, data)), frame_bits(Frame(1, data, extended=True))) == (135, 160)
    assert frame_bits(Frame(1)) == 55


class TestWire:
    def test_a_frame_arrives_when_its_last_bit_has_passed(self):
        bus, frame = FrameBus(BITRATE), Frame(5, b"abc")
        bus.push(frame, BusSide.HOST, 1.0)
        end_s = 1.0 + frame_bits(frame) / BITRATE
        assert bus.next_s() == pytest.approx(end_s)
        assert bus.pull(end_s - 1e-6) == []
        (arrival,) = bus.pull(end_s + 1e-9)
        assert (arrival.frame, arrival.sender) == (frame, BusSide.HOST)
        assert arrival.time_s == pytest.approx(end_s)
        assert bus.next_s() == float("inf")

    def test_of_those_that_wait_the_lowest_id_goes_first(self):
        bus = FrameBus(BITRATE)
        for can_id in (7, 6, 1, 3):
            bus.push(Frame(can_id), BusSide.DEVICE, 0.0)
        assert [each.frame.can_id for each in bus.pull(1.0)] == [7, 1, 3, 6]

    def test_an_adapter_sends_in_its_own_order_and_yields_to_drives(self):
        bus = FrameBus(BITRATE)
        for can_id in (9, 2, 8):
            bus.push(Frame(can_id), BusSide.HOST, 0.0)
        bus.push(Frame(4), BusSide.DEVICE, 0.0)
        assert [each.frame.can_id for each in bus.pull(1.0)] == [9, 2, 4, 8]

    def test_short_ids_win_over_long_ones_that_begin_alike(self):
        bus = FrameBus(BITRATE)
        bus.push(Frame(0x7FF), BusSide.DEVICE, 0.0)
        bus.push(Frame(5 << 18, extended=True), BusSide.DEVICE, 0.0)
        bus.push(Frame(5, remote=True), BusSide.DEVICE, 0.0)
        bus.push(Frame(5), BusSide.DEVICE, 0.0)
        order = [(each.frame.extended, each.frame.remote) for each in bus.pull(1.0)[1:]]
        assert order[-1] == (True, False)

    @given(st.lists(st.tuples(frames(), st.sampled_from(BusSide), st.floats(0, 0.01)), max_size=12))
    def test_nothing_is_lost_and_no_two_frames_overlap(self, sent):
        bus, arrived = FrameBus(BITRATE), []
        for frame, side, time_s in sorted(sent, key=lambda each: each[2]):
            arrived += bus.pull(time_s)
            bus.push(frame, side, time_s)
        arrived += bus.pull(1.0)
        assert sorted(map(str, (each.frame for each in arrived))) == sorted(
            str(frame) for frame, _, _ in sent
        )
        for before, after in itertools.pairwise(arrived):
            took_s = frame_bits(after.frame) / BITRATE
            assert after.time_s - before.time_s >= took_s - 1e-12
        if sent:
            all_s = sum(frame_bits(frame) for frame, _, _ in sent) / BITRATE
            assert arrived[-1].time_s <= max(time_s for _, _, time_s in sent) + all_s + 1e-12

    def test_a_frame_that_is_cut_off_leaves_the_bus_to_those_that_wait(self):
        bus = FrameBus(BITRATE)
        bus.push(Frame(1, bytes(8)), BusSide.HOST, 0.0)
        bus.push(Frame(2), BusSide.HOST, 0.0)
        bus.push(Frame(3), BusSide.DEVICE, 0.0)
        bus.clear(BusSide.HOST, 1e-4)
        (passed,) = bus.pull(1.0)
        assert (passed.frame, bus.waiting_of(BusSide.HOST)) == (Frame(3), 0)
        assert passed.time_s == pytest.approx(1e-4 + frame_bits(Frame(3)) / BITRATE)


def test_how_often_one_looks_changes_nothing():
    draw = random.Random(1)
    sent = sorted((draw.random() * 0.01, draw.randrange(1, 64, 2)) for _ in range(30))
    heard = []
    for looks in (1, 40):
        line = BusLine(EchoDrive(after_s=0.0003))
        for time_s, can_id in sent:
            for look in range(looks, 0, -1):
                line.advance(time_s - look * 1e-5)
            line.send(pack(Frame(can_id, b"x")), time_s)
        heard.append((Unpacker().feed(line.receive(1.0)), line.device.heard))
    assert heard[0] == heard[1]
    assert len(heard[0][0]) == len(sent)


class Bench:
    """A link to an echoing drive, on a clock of its own."""

    def __init__(self, after_s: float = 0.0) -> None:
        self.drive = EchoDrive(after_s)
        self.link = MemoryLink(BusLine(self.drive, BITRATE), "simulated arm")
        self.now_s = 0.0

    def write(self, *frames: Frame) -> None:
        self.link.write(b"".join(map(pack, frames)), self.now_s)

    def run(self, for_s: float = 1.0) -> list[tuple[float, Frame]]:
        """Go from deadline to deadline, and return what was heard and when."""
        heard, end_s = [], self.now_s + for_s
        while (next_s := self.link.next_s()) <= end_s:
            self.now_s = max(next_s, self.now_s)
            heard += [(self.now_s, each) for each in Unpacker().feed(self.link.read(self.now_s))]
        self.now_s = end_s
        self.link.read(end_s)
        return heard


class TestLink:
    def test_an_answer_comes_after_both_frames_have_passed(self):
        bench, frame = Bench(after_s=0.002), Frame(5, b"abc")
        bench.write(frame)
        ((time_s, answer),) = bench.run()
        assert answer == Frame(6, b"abc")
        both = frame_bits(frame) + frame_bits(answer)
        assert time_s == pytest.approx(0.002 + both / BITRATE)
        assert bench.drive.heard[0][0] == pytest.approx(frame_bits(frame) / BITRATE)
        assert bench.link.description == "simulated arm on a CAN bus at 500 kbit/s"

    def test_it_runs_by_itself_until_its_host_has_something_to_read(self):
        alone, often = Bench(after_s=0.002), Bench(after_s=0.002)
        for bench in (alone, often):
            bench.write(Frame(5, b"abc"))
        ((time_s, answer),) = often.run()
        assert alone.link.run(1.0) == time_s
        assert alone.drive.heard == often.drive.heard
        assert Unpacker().feed(alone.link.read(time_s)) == [answer]
        assert alone.link.run(1.0) == 1.0

    def test_it_runs_no_longer_than_its_host_waits(self):
        bench = Bench(after_s=0.002)
        bench.write(Frame(5))
        assert bench.link.run(0.001) == 0.001
        assert len(bench.drive.heard) == 1

    def test_a_wake_ends_a_run_behind_what_happens_next(self):
        bench = Bench(after_s=0.002)
        bench.write(Frame(5))
        bench.link.wake()
        assert bench.link.run(1.0) == pytest.approx(frame_bits(Frame(5)) / BITRATE)
        assert bench.link.run(1.0) > 0.002

    def test_a_wire_that_was_pulled_does_not_run_behind_its_hosts_back(self):
        bench = Bench()
        bench.write(Frame(5))
        bench.link.unplug()
        assert bench.link.run(1.0) == pytest.approx(frame_bits(Frame(5)) / BITRATE)
        assert bench.drive.heard == []

    def test_half_a_frame_waits_for_its_other_half(self):
        bench, packed = Bench(), pack(Frame(5, b"\r\n\r\n"))
        bench.link.write(packed[:4], 0.0)
        assert bench.run(0.1) == []
        bench.link.write(packed[4:], bench.now_s)
        assert [each for _, each in bench.run()] == [Frame(6, b"\r\n\r\n")]

    def test_a_delayed_frame_comes_later(self):
        bench = Bench()
        bench.link.line.faults.device.rules.append(Rule(late(0.2), Next()))
        bench.write(Frame(1))
        ((time_s, _),) = bench.run()
        assert 0.2 < time_s < 0.21

    def test_bus_off_is_told_and_ends_with_reopening(self):
        bench = Bench()
        bench.write(Frame(1))
        bench.link.line.leave_bus()
        with pytest.raises(LinkLost, match="bus-off"):
            bench.link.read(0.0)
        with pytest.raises(LinkLost, match="a resistor of 120 ohm"):
            bench.write(Frame(1))
        bench.link.close()
        bench.link.reopen()
        assert bench.run() == []
        assert bench.drive.heard == []
        bench.write(Frame(1))
        assert len(bench.run()) == 1

    def test_drives_live_on_while_the_adapter_is_unplugged(self):
        bench = Bench(after_s=0.1)
        bench.write(Frame(1), Frame(3))
        bench.link.read(frame_bits(Frame(1)) / BITRATE + 1e-9)
        bench.link.unplug()
        for time_s in (0.05, 0.5):
            with pytest.raises(LinkLost, match="unplugged"):
                bench.link.read(time_s)
        bench.link.replug()
        bench.now_s = 0.5
        assert bench.run() == []
        assert [each.can_id for _, each in bench.drive.heard] == [1]

    def test_a_host_that_waits_knows_how_many_frames_have_not_passed(self):
        bench = Bench()
        bench.write(Frame(1), Frame(3), Frame(5))
        assert bench.link.line.backlog == 3
        bench.run()
        assert bench.link.line.backlog == 0


@every_row(
    "effect, heard, answered",
    [
        (lambda: Rule(lost, Next()), [3, 5, 7], [4, 6, 8]),
        (lambda: Rule(changed(random.Random(1)), Next()), [3, 5, 7], [4, 6, 8]),
        (lambda: Rule(repeated, Nth(2)), [1, 3, 3, 5, 7], [2, 4, 4, 6, 8]),
        (lambda: overtaken(Next()), [3, 1, 5, 7], [4, 2, 6, 8]),
        # one that nothing overtakes is late for ever
        (lambda: overtaken(Share(1.0, random.Random(1))), [3, 1, 7, 5], [4, 2, 8, 6]),
    ],
)
def test_faults_concern_whole_frames_either_way(effect, heard, answered):
    bench = Bench()
    bench.link.line.faults.host.rules.append(effect())
    bench.write(*map(Frame, (1, 3, 5, 7)))
    bench.run()
    assert [each.can_id for _, each in bench.drive.heard] == heard
    bench = Bench()
    bench.link.line.faults.device.rules.append(effect())
    bench.write(*map(Frame, (1, 3, 5, 7)))
    assert sorted(each.can_id for _, each in bench.run()) == sorted(answered)
    assert len(bench.drive.heard) == 4


# -- The adapter -----------------------------------------------------------------------------------

LINES = [
    (Frame(0x7FF, bytes.fromhex("01F601403A")), b"t7FF501F601403A\r"),
    (Frame(0), b"t0000\r"),
    (Frame(1, b"", remote=True), b"r0010\r"),
    (Frame(0x1ABCDEF0, b"\xff", extended=True), b"T1ABCDEF01FF\r"),
    (Frame(5, extended=True, remote=True), b"R000000050\r"),
]


@every_row("frame, line", LINES)
def test_frames_are_written_and_read_as_lawicel_does(frame, line):
    assert line_of(frame) == line
    assert frame_of(line.rstrip()) == frame


@given(frames())
def test_written_frames_are_read(frame):
    assert frame_of(line_of(frame).rstrip()) == frame
    line = line_of(frame).rstrip()
    assert frame_of(line[:1] + line[1:].lower()) == frame
    assert frame_of(line + b"1A2B") == frame


@every_row(
    "line",
    [b"", b"t", b"t8000", b"t0019", b"t0012AB", b"t00g0", b"T200000000", b"x0010", b"t00100"],
)
def test_bytes_that_are_no_frame_give_none(line):
    assert frame_of(line) is None


@given(st.lists(st.binary(max_size=20)))
def test_garbage_never_raises_neither_in_lines_nor_in_the_adapter(pieces):
    lines, adapter = SlcanLines(), opened()
    for piece in pieces:
        for line in lines.feed(piece):
            frame_of(line)
        adapter.receive(piece)
        adapter.say()


@given(st.lists(frames(), max_size=5), st.integers(1, 9))
def test_lines_are_the_same_in_any_chunks(sent, size):
    text = b"".join(map(line_of, sent))
    lines = SlcanLines()
    chunks = [text[at : at + size] for at in range(0, len(text), size)]
    heard = [frame_of(line) for chunk in chunks for line in lines.feed(chunk)]
    assert heard == sent


def test_noise_without_an_end_is_forgotten_and_the_next_line_is_read():
    lines = SlcanLines()
    for _ in range(10):
        assert lines.feed(b"?" * LONGEST_LINE) == []
    assert lines.feed(b"\rt0010\r") == [b"t0010"]


def opened(**settings) -> Adapter:
    adapter = Adapter(**settings)
    adapter.receive(b"S6\rO\r")
    assert adapter.say() == b"\r\r"
    return adapter


def listening() -> Adapter:
    adapter = Adapter()
    adapter.receive(b"S6\rL\r")
    assert adapter.say() == b"\r\r"
    return adapter


def troubled(adapter: Adapter, fault: str) -> Adapter:
    setattr(adapter.faults, fault, True)
    return adapter


def restarted() -> Adapter:
    adapter = opened()
    adapter.restart()
    return adapter


MAKERS = {
    "open": opened,
    "closed": Adapter,
    "listening": listening,
    "at another bit rate than the bus": lambda: opened(bus_bitrate=250_000),
    "bus-off": lambda: troubled(opened(), "bus_off"),
    "alone on its bus": lambda: troubled(opened(), "alone"),
    "mute": lambda: troubled(Adapter(), "mute"),
    "dead": lambda: troubled(opened(), "dead"),
    "back with power": restarted,
}
SAID = [
    ("open", b"V", b"V1013\r"),
    ("open", b"N", b"NA123\r"),
    ("open", b"F", b"F00\r"),
    ("open", b"", b"\r"),
    ("open", b"t1232AABB", b"z\r", Frame(0x123, b"\xaa\xbb")),
    ("open", b"T000001230", b"Z\r", Frame(0x123, extended=True)),
    ("open", b"r1230", b"z\r", Frame(0x123, remote=True)),
    ("open", b"t1239", b"\a"),
    ("open", b"Z0", b"\r"),
    ("open", b"Z1", b"\a"),
    ("open", b"O", b"\a"),
    ("open", b"S6", b"\a"),
    ("open", b"C", b"\r"),
    ("open", b"Q", b"\a"),
    ("open", b"d1230", b"\a"),
    ("closed", b"V", b"V1013\r"),
    ("closed", b"C", b"\a"),
    ("closed", b"O", b"\a"),
    ("closed", b"S9", b"\a"),
    ("closed", b"S8", b"\r"),
    ("closed", b"t1230", b"\a"),
    ("closed", b"F", b"\a"),
    ("listening", b"t0010", b"\a"),
    ("at another bit rate than the bus", b"t0010", b"\a"),
    ("bus-off", b"t0010\rF", b"\aFA0\r"),
    ("bus-off", b"C\rO\rt0010", b"\r\rz\r", Frame(1)),  # opened anew, it is back on the bus
    ("alone on its bus", b"t0010\rF", b"\aF20\r"),
    ("mute", b"S6\rO\rt0010\rF\rV", b"V1013\r", Frame(1)),
    ("dead", b"V\rt0010", b""),
    ("back with power", b"O", b"\a"),  # it has forgotten its bit rate
]


@every_row("which, lines, answer, sent", [(*row, None)[:4] for row in SAID])
def test_an_adapter_answers_and_sends(which, lines, answer, sent):
    adapter = MAKERS[which]()
    assert adapter.receive(lines + b"\r") == ([] if sent is None else [sent])
    assert adapter.say() == answer


@every_row("which", MAKERS)
def test_only_an_adapter_that_is_on_the_bus_shows_its_frames(which):
    adapter = MAKERS[which]()
    adapter.show(Frame(6, b"\x33"))
    on_bus = which in ("open", "listening", "alone on its bus")
    assert adapter.say() == (b"t006133\r" if on_bus else b"")
    adapter.receive(b"C\r")
    adapter.say()
    adapter.show(Frame(6))
    assert adapter.say() == b""
