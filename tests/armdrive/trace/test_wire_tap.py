"""What passes on a held arm's wire, as other programs are told: in order, bounded, to its end."""

from __future__ import annotations

import contextlib
from types import SimpleNamespace

from armdrive.connect.control_socket import REQUESTS, WIRE
from armdrive.trace.entries import (
    MESSAGE_BYTES,
    TAP_BACK,
    TAP_MOST,
    EntryKind,
    EntryRing,
    TraceEntry,
    tap_messages,
)


def held():
    """An arm of which nothing is there but its recorder."""
    ring = EntryRing()
    ring.seal()
    return ring, SimpleNamespace(tracer=ring, closed=False)


def tapped(arm):
    """Listen to the wire of an arm whose clock stands still."""
    return tap_messages(arm.tracer.since, lambda: 7.0, lambda: arm.closed, 0.0)


def told(arm, ring, entries):
    """Begin to listen, have entries come, and return all that is told until the arm is closed."""
    stream = tapped(arm)
    assert next(stream) == {}
    for each in entries:
        ring.add(each)
    arm.closed = True
    return list(stream)


def test_bytes_are_told_in_their_order_and_nothing_else_is():
    ring, arm = held()
    ring.add(TraceEntry(1.0, EntryKind.SENT, b"before"))
    entries = [
        TraceEntry(2.0, EntryKind.SENT, b"\x01\xff"),
        TraceEntry(2.1, EntryKind.STATE, "moving"),
        TraceEntry(2.2, EntryKind.RECEIVED, b"\x02"),
    ]
    (message,) = told(arm, ring, entries)
    assert message == {
        "wire": [(2.0, "sent", "01ff"), (2.2, "heard", "02")],
        "missed": 0,
        "now_s": 7.0,
    }


def test_messages_are_bounded_and_nothing_is_lost_between_them():
    ring, arm = held()
    sizes = [1, 5000, 300, 1024, 1025, *[40] * (3 * TAP_MOST)]
    messages = told(
        arm, ring, [TraceEntry(3.0, EntryKind.RECEIVED, bytes([7]) * size) for size in sizes]
    )
    pieces = [piece for message in messages for piece in message["wire"]]
    assert sum(len(data) // 2 for _, _, data in pieces) == sum(sizes)
    assert all(
        sum(len(data) for _, _, data in message["wire"]) <= MESSAGE_BYTES for message in messages
    )


def test_who_reads_too_slowly_is_told_how_much_was_passed_over():
    ring, arm = held()
    more = 10
    messages = told(arm, ring, [TraceEntry(3.0, EntryKind.SENT, b"x")] * (TAP_BACK + more))
    assert sum(message["missed"] for message in messages) == more
    assert sum(len(message["wire"]) for message in messages) == TAP_BACK


def test_it_is_a_request_that_others_know_of():
    assert WIRE in REQUESTS
    with contextlib.closing(tapped(held()[1])) as stream:
        assert next(stream) == {}
