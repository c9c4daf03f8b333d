"""How bytes reach a machine of any dialect, cut anywhere, and what it says of them."""

from itertools import pairwise

from hypothesis import strategies as st


@st.composite
def chunked(draw: st.DrawFn, data: bytes) -> list[bytes]:
    """Cut bytes into portions: all at once, one by one, or anywhere."""
    how = draw(st.sampled_from(["whole", "bytes", "anywhere"]))
    if how == "whole":
        return [data]
    if how == "bytes":
        return [bytes([byte]) for byte in data]
    cuts = draw(st.lists(st.integers(0, len(data)), max_size=6))
    return [data[a:b] for a, b in pairwise(sorted({0, len(data), *cuts}))]


def events(machine, data: bytes = b"") -> list:
    """Give a machine bytes; return every event that waits."""
    if data:
        machine.receive_data(data)
    return list(iter(machine.next_event, None))


def carried(draw, data: bytes, machine) -> list:
    """Carry bytes to a machine in portions; return its events, fetched after each of them."""
    return [event for chunk in draw(chunked(data)) for event in events(machine, chunk)]
