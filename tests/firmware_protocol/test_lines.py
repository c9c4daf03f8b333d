"""Lines out of bytes: any chunks, bounded memory, every loss reported once."""

from itertools import pairwise

import pytest
from chunks import events
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import armdroid, grbl, teachmover
from firmware_protocol.events import Stray, Unreadable
from firmware_protocol.lines import MAX_EARLY, SHOWN_BYTES, LineSplitter


def drained(splitter: LineSplitter) -> list[bytes | Unreadable]:
    found = []
    while (line := splitter.next_line()) is not None:
        found.append(line)
    return found


def chunks_of(data: bytes, cuts: list[int]) -> list[bytes]:
    at = sorted({min(cut, len(data)) for cut in cuts} | {0, len(data)})
    return [data[a:b] for a, b in pairwise(at)]


def test_a_line_appears_when_its_terminator_does():
    splitter = LineSplitter(b"\r")
    splitter.feed(b"one")
    assert splitter.next_line() is None
    assert splitter.partial == b"one"
    splitter.feed(b"\rtw")
    assert drained(splitter) == [b"one"]
    assert splitter.partial == b"tw"


def test_any_byte_of_the_set_ends_a_line_and_empty_lines_are_skipped():
    splitter = LineSplitter(b"\r\n")
    splitter.feed(b"a\r\nb\n\n\rc\r")
    assert drained(splitter) == [b"a", b"b", b"c"]


def test_terminators_that_mean_something_in_a_pattern_are_only_themselves():
    splitter = LineSplitter(b"^]-")
    splitter.feed(b"a^b]c-d\\e^")
    assert drained(splitter) == [b"a", b"b", b"c", b"d\\e"]


def test_a_line_of_the_greatest_length_passes_and_one_byte_more_does_not():
    splitter = LineSplitter(b"\r", max_length=5)
    splitter.feed(b"12345\r123456\rok\r")
    assert drained(splitter) == [
        b"12345",
        Unreadable(b"12345", "a line of more than 5 bytes"),
        b"ok",
    ]


def test_an_endless_line_is_reported_once_and_at_once_and_takes_no_memory():
    splitter = LineSplitter(b"\r", max_length=100)
    for _ in range(1000):
        splitter.feed(b"x" * 77)
        assert splitter.buffered <= 100 + SHOWN_BYTES
    assert [type(line) for line in drained(splitter)] == [Unreadable]
    splitter.feed(b"tail\rgood\r")
    assert drained(splitter) == [b"good"]


def test_a_flood_of_lines_is_bounded_and_says_where_it_lost_some():
    splitter = LineSplitter(b"\r", max_length=10, max_lines=4)
    splitter.feed(b"".join(b"%d\r" % n for n in range(1000)))
    assert splitter.buffered <= 4 * SHOWN_BYTES
    lost = Unreadable(b"3", "4 lines were waiting: from here on they are lost")
    assert drained(splitter) == [b"0", b"1", b"2", lost]
    splitter.feed(b"after\r")
    assert drained(splitter) == [b"after"]


def test_discarding_makes_the_next_byte_begin_a_line():
    splitter = LineSplitter(b"\r", max_length=8)
    for junk in (b"waiting\rpart", b"far too long for a line"):
        splitter.feed(junk)
        splitter.discard()
        assert splitter.buffered == 0
        splitter.feed(b"new\r")
        assert drained(splitter) == [b"new"]


@given(
    st.lists(st.binary(max_size=30), max_size=12).map(b"\r".join),
    st.lists(st.integers(0, 400), max_size=12),
)
def test_the_chunks_make_no_difference(data: bytes, cuts: list[int]):
    whole, split, bytewise = (LineSplitter(b"\r\n", max_length=20, max_lines=8) for _ in range(3))
    whole.feed(data)
    for chunk in chunks_of(data, cuts):
        split.feed(chunk)
    for byte in data:
        bytewise.feed(bytes([byte]))
    assert whole.partial == split.partial == bytewise.partial
    assert drained(whole) == drained(split) == drained(bytewise)


@given(st.lists(st.binary(min_size=1, max_size=20).filter(lambda b: b"\r" not in b), max_size=20))
def test_lines_within_the_bounds_come_out_as_they_went_in(lines: list[bytes]):
    splitter = LineSplitter(b"\r", max_length=20)
    splitter.feed(b"".join(line + b"\r" for line in lines))
    assert drained(splitter) == lines


# -- the hosts that read lines --------------------------------------------------------------------

CLOSE, OFFSETS, QUERY = teachmover.Close(), armdroid.ReportOffsets(), grbl.QuerySettings()
REPORTED = armdroid.OffsetsReported((1, -2, 3, -4, 5, -6))
DONE = teachmover.Status.DONE
every_host = pytest.mark.parametrize(
    ("make", "command", "line", "answered", "stray"),
    [
        (teachmover.Host, CLOSE, b"1\r", teachmover.Completed(CLOSE, DONE), DONE),
        (
            armdroid.Host,
            OFFSETS,
            b"offsets = 1,-2,3,-4,5,-6\r\n",
            armdroid.Completed(OFFSETS, REPORTED),
            REPORTED,
        ),
        (grbl.Host, QUERY, b"ok\r\n", grbl.Acknowledged(QUERY), grbl.Ok()),
    ],
    ids=["teachmover", "armdroid", "grbl"],
)
"""Each with a command, the line that answers it, and what the host says of the line both ways."""


@every_host
def test_a_line_that_came_or_began_before_a_command_is_never_its_answer(
    make, command, line, answered, stray
):
    for cut in range(1, len(line) + 1):
        host = make()
        host.receive_data(line[:cut])
        host.send(command)
        (early,) = events(host, line[cut:])
        if early != Stray(stray):
            assert early == Unreadable(
                line.rstrip(b"\r\n"), "the line began before the command was sent"
            )
        assert cut < len(line) or early == Stray(stray)
        assert events(host, line) == [answered]


@every_host
def test_an_endless_line_is_told_once_and_spoils_no_answer(make, command, line, answered, stray):
    host, found = make(), []
    host.send(command)
    for _ in range(300):
        found += events(host, b"<" * 100)
        assert host.buffered <= 512 + SHOWN_BYTES
    assert [type(event) for event in found] == [Unreadable]
    assert events(host, line[-1:] + line) == [answered]


@every_host
def test_discarded_bytes_and_events_are_gone_and_the_command_stays(
    make, command, line, answered, stray
):
    host = make()
    host.receive_data(line * 2 + line[:1])
    host.send(command)
    host.discard()
    assert host.buffered == 0
    assert events(host, line) == [answered]


@every_host
def test_a_host_that_only_sends_keeps_a_bounded_past(make, command, line, answered, stray):
    host = make()
    for _ in range(20):
        host.receive_data(b"junk\r\n" * 100)
        host.send(command)
        (host.forget_outstanding if isinstance(host, grbl.Host) else host.give_up)()
    found = events(host)
    assert {type(event) for event in found} == {Unreadable}
    assert 0 < len(found) <= MAX_EARLY
