"""The recorder's memory: bounded by bytes and by time, and it never forgets how it began."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from armdrive.trace.entries import ENTRY_BYTES, EntryKind, EntryRing, TraceEntry

kinds = st.sampled_from(
    [EntryKind.SENT, EntryKind.RECEIVED, EntryKind.REQUEST, EntryKind.REPLY, EntryKind.OFFSET]
)
words = st.sampled_from(["MoveBy(1)", "SwitchOn()", "SetOutputs(bits=3)", "1 2 3", "done"])


@st.composite
def runs(draw):
    time_s, run = 0.0, []
    for _ in range(draw(st.integers(0, 60))):
        time_s += draw(st.floats(0.0, 20.0))
        kind, text = draw(kinds), draw(words)
        run.append(TraceEntry(time_s, kind, text.encode() if kind is EntryKind.SENT else text))
    return run


def filled(entries, sealed_after, **bounds):
    ring = EntryRing(**bounds)
    for index, entry in enumerate(entries):
        if index == sealed_after:
            ring.seal()
        ring.add(entry)
    return ring


@given(runs(), st.integers(0, 10))
def test_what_fits_is_kept_whole_and_in_order(run, sealed_after):
    ring = filled(run, sealed_after, longest_s=1e9)
    assert list(ring.entries()) == run
    assert ring.dropped == 0


@given(runs(), st.integers(0, 10), st.integers(200, 3000), st.floats(1.0, 100.0))
def test_it_never_grows_beyond_its_bounds(run, sealed_after, most_bytes, longest_s):
    opening = 1500
    ring = filled(
        run,
        sealed_after,
        most_bytes=most_bytes,
        longest_s=longest_s,
        most_opening_bytes=opening,
    )
    kept = ring.entries()
    assert ring.bytes <= most_bytes
    size = sum(ENTRY_BYTES + len(each.what) for each in kept if each.kind is not EntryKind.GAP)
    assert size <= most_bytes + opening + ENTRY_BYTES + 20  # the entry that closes the beginning
    assert [each.time_s for each in kept] == sorted(each.time_s for each in kept)


@given(runs(), st.integers(1, 10), st.integers(200, 2000))
def test_the_beginning_the_end_and_settings_that_last_are_there(run, sealed_after, most_bytes):
    ring = filled(run, sealed_after, most_bytes=most_bytes, longest_s=1e9)
    kept = ring.entries()
    beginning = run[:sealed_after]
    assert list(kept[: len(beginning)]) == beginning
    assert not run or kept[-1] == run[-1] or kept[-1].kind is EntryKind.GAP
    for entry in run:
        lasting = entry.kind is EntryKind.REQUEST and entry.what.startswith(
            ("SwitchOn", "SetOutputs")
        )
        assert entry in kept or not (lasting or entry.kind is EntryKind.OFFSET)


def test_a_gap_stands_where_something_went():
    run = [TraceEntry(float(t), EntryKind.REPLY, "done") for t in range(100)]
    kept = filled(run, 1, longest_s=10.0).entries()
    assert [each.kind for each in kept[:3]] == [EntryKind.REPLY, EntryKind.GAP, EntryKind.GAP]
    assert kept[3].time_s == 89.0


def test_a_connection_that_never_comes_about_is_bounded_too():
    ring = filled([TraceEntry(float(t), EntryKind.RECEIVED, b"x" * 100) for t in range(5000)], -1)
    assert sum(len(each.what) for each in ring.entries()) < 5_000_000
    assert ring.bytes <= 4_000_000
