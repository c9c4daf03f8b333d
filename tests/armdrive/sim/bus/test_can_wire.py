"""The wire of simulated drives: the bus, the link to it, and the serial adapter."""

import itertools
import random

import pytest
from amounts import every_row
from can_bench import EchoDrive
from hypothesis import given
from hypothesis import strategies as st

from armdrive.errors import LinkLost
from armdrive.sim.bus.line import BusLine
from armdrive.sim.serving.servers import Adapter
from armdrive.sim.wire import Amount, MemoryLink, Rule, changed, lost, repeated
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


class Chatter:
    """A drive that sends frames of its own."""

    def __init__(self, *ready: tuple[float, Frame]) -> None:
        self.ready, self.heard = sorted(ready, key=lambda each: each[0]), []

    def receive(self, message, now_s):
        self.heard += [(now_s, frame) for frame in message]

    def transmit(self, now_s):
        sent = tuple(frame for time_s, frame in self.ready if time_s <= now_s)
        self.ready = [each for each in self.ready if each[0] > now_s]
        return sent

    def next_s(self):
        return self.ready[0][0] if self.ready else float("inf")


class Bench:
    """A link to drives, on a clock of its own."""

    def __init__(self, drive=None) -> None:
        self.drive = drive or EchoDrive()
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

    def ids(self) -> list[int]:
        """Run; return the ids of all frames that passed, those of the host as well."""
        passed = [*self.run(), *self.drive.heard]
        return [frame.can_id for _, frame in sorted(passed, key=lambda each: each[0])]


class TestBus:
    def test_the_lowest_id_goes_first_and_the_adapter_keeps_its_order(self):
        long_id = Frame(7 << 18, extended=True)
        bench = Bench(Chatter(*((0.0, each) for each in (Frame(9), Frame(6), long_id, Frame(1)))))
        bench.write(Frame(8), Frame(2), Frame(3))
        assert bench.ids() == [9, 1, 6, long_id.can_id, 8, 2, 3]  # 9 was on the bus already

    @given(st.lists(st.tuples(frames(), st.booleans(), st.floats(0, 0.01)), max_size=12))
    def test_nothing_is_lost_and_no_two_frames_overlap(self, sent):
        bench = Bench(Chatter(*((time_s, frame) for frame, own, time_s in sent if own)))
        arrived = []
        for frame, own, time_s in sorted(sent, key=lambda each: each[2]):
            if not own:
                arrived += bench.run(time_s - bench.now_s)
                bench.write(frame)
        arrived += [*bench.run(), *bench.drive.heard]
        arrived.sort(key=lambda each: each[0])
        assert sorted(str(each) for _, each in arrived) == sorted(str(each) for each, *_ in sent)
        for (before_s, _), (after_s, frame) in itertools.pairwise(arrived):
            assert after_s - before_s >= frame_bits(frame) / BITRATE - 1e-12
        if sent:
            all_s = sum(frame_bits(frame) for frame, *_ in sent) / BITRATE
            assert arrived[-1][0] <= max(time_s for *_, time_s in sent) + all_s + 1e-12

    def test_a_frame_that_is_cut_off_leaves_the_bus_to_those_that_wait(self):
        bench = Bench(Chatter((5e-5, Frame(9))))
        bench.write(Frame(1, bytes(8)), Frame(2))
        bench.link.read(1e-4)
        bench.link.line.leave_bus()
        assert bench.link.line.backlog == 0
        assert bench.link.next_s() == pytest.approx(1e-4 + frame_bits(Frame(9)) / BITRATE)
        bench.link.line.advance(1.0)
        assert bench.drive.heard == []


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


class TestLink:
    def test_an_answer_comes_after_both_frames_have_passed(self):
        bench, frame = Bench(EchoDrive(after_s=0.002)), Frame(5, b"abc")
        bench.write(frame)
        ((time_s, answer),) = bench.run()
        assert answer == Frame(6, b"abc")
        both = frame_bits(frame) + frame_bits(answer)
        assert time_s == pytest.approx(0.002 + both / BITRATE)
        assert bench.drive.heard[0][0] == pytest.approx(frame_bits(frame) / BITRATE)
        assert bench.link.description == "simulated arm on a CAN bus at 500 kbit/s"

    def test_it_runs_by_itself_until_its_host_has_something_to_do(self):
        alone, often = Bench(EchoDrive(after_s=0.002)), Bench(EchoDrive(after_s=0.002))
        for bench in (alone, often):
            bench.write(Frame(5, b"abc"))
        ((time_s, answer),) = often.run()
        assert alone.link.run(0.001) == 0.001  # no longer than its host waits
        assert alone.link.run(1.0) == time_s
        assert alone.drive.heard == often.drive.heard
        assert Unpacker().feed(alone.link.read(time_s)) == [answer]
        assert alone.link.run(1.0) == 1.0
        alone.link.write(pack(Frame(5)), 1.0)
        alone.link.wake()
        assert alone.link.run(2.0) == pytest.approx(1.0 + frame_bits(Frame(5)) / BITRATE)
        assert alone.link.run(2.0) > 1.002

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
        bench = Bench(EchoDrive(after_s=0.1))
        bench.write(Frame(1), Frame(3))
        assert bench.link.line.backlog == 2
        bench.link.read(frame_bits(Frame(1)) / BITRATE + 1e-9)
        bench.link.unplug()
        for time_s in (0.05, 0.5):
            with pytest.raises(LinkLost, match="unplugged"):
                bench.link.read(time_s)
        bench.link.replug()
        bench.now_s = 0.5
        assert bench.run() == []
        assert [each.can_id for _, each in bench.drive.heard] == [1]


@every_row(
    "effect, more, heard",
    [
        (lost, {}, [3, 5, 7]),
        (changed(random.Random(1)), {}, [3, 5, 7]),
        (repeated, {"nth": 2}, [1, 3, 3, 5, 7]),
        (None, {}, [3, 5, 7, 1]),
    ],
)
def test_faults_concern_whole_frames_either_way(effect, more, heard):
    for answers in (False, True):
        bench = Bench()
        lanes = bench.link.line.faults
        late = {} if effect else {"late_s": 0.005, "overtaken": True}
        rule = Rule(Amount(random.Random(1), **more), effect, **late)
        (lanes.device if answers else lanes.host).rules.append(rule)
        bench.write(*map(Frame, (1, 3, 5, 7)))
        passed = [each.can_id - answers for _, each in bench.run()]
        found = passed if answers else [each.can_id for _, each in bench.drive.heard]
        assert sorted(found) == sorted(heard)
        assert answers or found == heard
        assert len(bench.drive.heard) == (4 if answers else len(heard))


# -- The adapter -----------------------------------------------------------------------------------

LINES = [
    (Frame(0x7FF, bytes.fromhex("01F601403A")), b"t7FF501F601403A\r"),
    (Frame(0), b"t0000\r"),
    (Frame(1, b"", remote=True), b"r0010\r"),
    (Frame(0x1ABCDEF0, b"\xff", extended=True), b"T1ABCDEF01FF\r"),
    (Frame(5, extended=True, remote=True), b"R000000050\r"),
]


@every_row("frame, line", LINES)
def test_frames_are_written_as_lawicel_does(frame, line):
    assert line_of(frame) == line


@given(st.lists(frames(), max_size=5), st.integers(1, 9))
def test_written_frames_are_read_in_any_chunks_and_letters(sent, size):
    text = b"".join(map(line_of, sent))
    lines = SlcanLines()
    chunks = [text[at : at + size] for at in range(0, len(text), size)]
    heard = [line for chunk in chunks for line in lines.feed(chunk)]
    assert [frame_of(line) for line in heard] == sent
    assert [frame_of(line[:1] + line[1:].lower()) for line in heard] == sent
    assert [frame_of(line + b"1A2B") for line in heard] == sent  # with a timestamp


@every_row(
    "line",
    [b"", b"t", b"t8000", b"t0019", b"t0012AB", b"t00g0", b"T200000000", b"x0010", b"t00100"],
)
def test_bytes_that_are_no_frame_give_none(line):
    assert frame_of(line) is None


@given(st.lists(st.binary(max_size=20)))
def test_garbage_never_raises_neither_in_lines_nor_in_the_adapter(pieces):
    lines, adapter = SlcanLines(), set_up(b"S6\rO\r")
    for piece in pieces:
        for line in lines.feed(piece):
            frame_of(line)
        adapter.receive(piece)
        adapter.say()


def test_noise_without_an_end_is_forgotten_and_the_next_line_is_read():
    lines = SlcanLines()
    for _ in range(10):
        assert lines.feed(b"?" * LONGEST_LINE) == []
    assert lines.feed(b"\rt0010\r") == [b"t0010"]


def set_up(words: bytes = b"", fault: str = "", *, restarts=False, **settings) -> Adapter:
    adapter = Adapter(**settings)
    adapter.receive(words)
    assert adapter.say() == b"\r" * words.count(b"\r")
    if fault:
        setattr(adapter.faults, fault, True)
    if restarts:
        adapter.restart()
    return adapter


OPEN, LISTENING = b"S6\rO\r", b"S6\rL\r"
MAKERS = {
    "open": lambda: set_up(OPEN),
    "closed": set_up,
    "listening": lambda: set_up(LISTENING),
    "at another bit rate than the bus": lambda: set_up(OPEN, bus_bitrate=250_000),
    "bus-off": lambda: set_up(OPEN, "bus_off"),
    "alone on its bus": lambda: set_up(OPEN, "alone"),
    "mute": lambda: set_up(b"", "mute"),
    "dead": lambda: set_up(OPEN, "dead"),
    "back with power": lambda: set_up(OPEN, restarts=True),
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
