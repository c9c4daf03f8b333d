"""The log in words: read as it comes, never more than what is new, and sieved."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from recorder_bench import recorded_arm

from armdrive import ArmError
from armdrive.errors.table import found
from armdrive.trace.entries import ENTRY_BYTES, EntryKind, EntryRing, TraceEntry
from armdrive.trace.log import LogBook, LogFilter, LogLine, LogReader, Topic


@pytest.fixture
def arm():
    with recorded_arm() as arm:
        yield arm


def line(number, kind=EntryKind.REPLY, words="done", **more):
    return LogLine(number, float(number), kind, **({"shown": "", "words": words} | more))


def reader(ring, **how):
    return LogReader(ring.since, "teachmover", 0.0, **how)


# -- lines -------------------------------------------------------------------------------------


def test_every_kind_of_entry_has_a_topic():
    assert {kind.topic for kind in EntryKind} == set(Topic)


def test_a_motion_is_read_in_words_with_its_intent_and_its_bytes(arm):
    log = arm.log()
    while log.read():
        pass
    arm.move_motors(37, 0, 0, 0, 0, 0)
    lines = log.read()
    (asked,) = [each for each in lines if each.topic is Topic.INTENTS]
    assert asked.words == "move_motors 37, 0, 0, 0, 0, 0"
    sent = next(each for each in lines if each.shown.startswith("@STEP"))
    assert "base +" in sent.words
    assert "->" in str(sent)
    assert "<-" in "\n".join(map(str, lines))
    assert [each.number for each in lines] == sorted(each.number for each in lines)
    assert log.read() == ()


def test_counts_are_told_once(arm):
    told = next(each for each in arm.log().read() if each.kind is EntryKind.REGISTERS)
    assert told.text == "registers: 0 0 0 0 0 0, inputs 0"


def test_times_are_counted_from_the_connection():
    ring = EntryRing()
    ring.add(TraceEntry(1000.5, EntryKind.SENT, b"@READ\r"))
    (read,) = LogReader(ring.since, "teachmover", 1000.0).read()
    assert read.time_s == 0.5
    assert str(read).split() == ["0.500", "s", "->", "@READ\\r", "read", "the", "registers"]


def test_errors_carry_the_code_of_the_catalogue(arm):
    arm.confirm_reference()
    arm.twin.faults.add("mute")
    with pytest.raises(ArmError):
        arm.move_motors(0, 0, 0, 0, 5, 0)
    lines = arm.log().read()
    codes = {each.kind: each.code for each in lines if each.code}
    assert codes[EntryKind.RAISED] == "E502"
    assert codes[EntryKind.ERROR] == arm.status.error_code
    assert codes[EntryKind.TRUST] in ("E706", "E707")


def test_frames_of_a_bus_are_written_as_frames():
    with recorded_arm("mks") as arm:
        lines = arm.log().read()
    sent = next(each for each in lines if each.kind is EntryKind.SENT)
    assert sent.shown.startswith("001#")
    assert sent.words == "1 2 3 4 5 6: read encoder"


# -- reading as it comes -------------------------------------------------------------------------


@given(
    st.lists(st.integers(0, 9), max_size=40),
    st.integers(1, 7),
    st.integers(0, 30),
    st.integers(2, 60),
)
def test_whatever_comes_is_read_once_in_order_or_counted_as_gone(runs, most, sealed, kept):
    """`runs` are so many entries between two looks; what is missing is always said."""
    entry = TraceEntry(0.0, EntryKind.REPLY, "done")
    ring = EntryRing(most_bytes=kept * (ENTRY_BYTES + len(entry.what)))
    log = reader(ring, back=1000)
    read, added = [], 0
    for run in [*runs, *[0] * 60]:
        for _ in range(run):
            if added == sealed:
                ring.seal()
            ring.add(entry)
            added += 1
        read += log.read(most)
    told = [each.number for each in read if each.kind is not EntryKind.GAP]
    gone = sum(int(each.words.split()[0]) for each in read if each.kind is EntryKind.GAP)
    assert told == sorted(set(told))
    assert len(told) + gone == added == ring.added


def test_a_reader_looks_no_further_back_than_it_was_told():
    ring = EntryRing()
    for number in range(100):
        ring.add(TraceEntry(float(number), EntryKind.REPLY, str(number)))
    gap, *lines = reader(ring, back=10).read()
    assert gap.words.startswith("90 older entries")
    assert [each.words for each in lines] == [str(number) for number in range(90, 100)]


def test_a_reader_may_begin_with_what_is_yet_to_come():
    ring = EntryRing()
    ring.add(TraceEntry(0.0, EntryKind.REPLY, "old"))
    log = reader(ring, back=0)
    ring.add(TraceEntry(1.0, EntryKind.REPLY, "new"))
    assert [each.words for each in log.read()] == ["new"]


def test_a_message_that_began_before_a_gap_is_no_message():
    ring = EntryRing(most_bytes=2 * (ENTRY_BYTES + 2))
    ring.seal()
    log = reader(ring)
    ring.add(TraceEntry(0.0, EntryKind.RECEIVED, b"1,"))
    log.read()
    for _ in range(5):
        ring.add(TraceEntry(0.0, EntryKind.RECEIVED, b"x"))
    ring.add(TraceEntry(0.0, EntryKind.RECEIVED, b"\r1\r"))
    assert log.read()[-1].words.endswith("done")


def test_two_readers_do_not_disturb_each_other(arm):
    one, other = arm.log(), arm.log()
    assert one.read() == other.read() != ()


# -- sieving -----------------------------------------------------------------------------------


def test_topics_and_texts_are_sieved():
    book = LogBook()
    sent = line(0, EntryKind.SENT, "base +37", shown="@STEP")
    failed = line(1, EntryKind.RAISED, "NoAnswer: no answer", code="E502")
    assert book.take([sent, failed]) == 2
    for sieve, passed in (
        (LogFilter(frozenset({Topic.BYTES})), [sent]),
        (LogFilter(text="ANSWER"), [failed]),
        (LogFilter(text="e502"), [failed]),
        (LogFilter(text="step,37"), [sent]),
        (LogFilter(text="step,38"), []),
        (LogFilter().toggled(Topic.BYTES), [failed]),
        (LogFilter().toggled(Topic.BYTES).toggled(Topic.BYTES), [sent, failed]),
    ):
        book.choose(sieve)
        assert list(book.lines) == passed
    assert book.total == 2


def test_a_book_is_bounded_and_forgets_what_is_too_old_for_it():
    book = LogBook(kept=3)
    book.choose(LogFilter(frozenset({Topic.ERRORS})))
    assert book.take([line(0, EntryKind.ERROR), *map(line, range(1, 5))]) == 1
    assert book.total == 3
    assert not book.lines
    book.clear()
    assert book.total == 0


@given(st.lists(st.sampled_from(list(EntryKind)), max_size=30), st.integers(1, 8))
def test_what_passes_is_the_same_whether_it_is_chosen_before_or_after(kinds, kept):
    lines = [line(number, kind) for number, kind in enumerate(kinds)]
    wanted = LogFilter(frozenset({Topic.ERRORS, Topic.BYTES}))
    before, after = LogBook(kept), LogBook(kept)
    before.choose(wanted)
    for each in lines:
        before.take([each])
    after.take(lines)
    after.choose(wanted)
    assert list(before.lines) == list(after.lines)


def test_the_catalogue_can_be_searched():
    assert "E502" in [row.code for row in found("does not answer")]
    assert [row.code for row in found("e502,timeout")] == ["E502"]
    assert found("no such words anywhere") == ()


# -- the command ---------------------------------------------------------------------------------


@pytest.fixture
def recording(arm, tmp_path):
    arm.move_motors(0, 0, 0, 0, 5, 0)
    return str(arm.save_recording(tmp_path / "some.jsonl"))


def test_a_recording_is_printed_in_the_same_words_as_the_arm_is_read(call, arm, recording):
    printed = call("log", recording, code=0).out.splitlines()[1:]
    live = [str(each) for each in arm.log().read()]
    assert printed == live
    views = call("log", recording, "--json", code=0).json_lines
    assert [each["words"] for each in views] == [each.words for each in arm.log().read()]


def test_a_recording_is_sieved(call, recording):
    out = call("log", recording, "--only", "intents,errors", code=0).out
    assert "call: move_motors" in out
    assert "->" not in out
    found_lines = call("log", recording, "--find", "step,speed", code=0).out.splitlines()[1:]
    assert found_lines
    assert all("step at speed" in each for each in found_lines)
    assert "did you mean" in call.refused("log", recording, "--only", "byte", code=2)


def test_the_newest_recording_is_read_where_none_is_named(call, arm):
    assert "there is no recording" in call.refused("log", code=2)
    file = arm.save_recording()
    assert call("log", code=0).out.startswith(f"{file}: ")


def test_errors_are_found_by_words(call):
    out = call("errors", "--find", "does not answer,timeout", code=0).out
    assert out.startswith("E502: ")
    assert "cause" in out
    assert "no error has these words" in call("errors", "--find", "zzz", code=0).out
