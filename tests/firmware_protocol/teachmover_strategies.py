"""What the TeachMover tests draw from: every command and reply, and every way to cut a stream."""

import string
from itertools import pairwise

from hypothesis import strategies as st

from firmware_protocol.teachmover import (
    Arm,
    Close,
    Delay,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Registers,
    Reset,
    Run,
    Set,
    Status,
    Step,
)

BYTE = st.integers(0, 255)
SPEED = st.integers(0, 245)
SIX_STEPS = st.tuples(*[st.integers(-32768, 32767)] * 6)
ROWS = st.builds(ProgramRow, st.integers(0, 65535), BYTE, SIX_STEPS, BYTE)
SIGNS = st.sampled_from(sorted(set(string.punctuation) - set(",-")))
MAYBE_SPEED = st.none() | SPEED
COMMANDS = st.one_of(
    st.builds(Step, SPEED, SIX_STEPS, st.none() | BYTE),
    st.sampled_from([Read(), Reset(), Run(), QDump()]),
    st.builds(Close, MAYBE_SPEED),
    st.builds(Set, MAYBE_SPEED),
    st.builds(QWrite, ROWS),
    st.builds(Arm, SIGNS),
    st.builds(Delay, st.integers(0, 65535)),
)
REGISTERS = st.builds(Registers, SIX_STEPS, BYTE, BYTE)
STATUSES = st.sampled_from(Status)
REPLIES = st.one_of(STATUSES, REGISTERS, ROWS)


@st.composite
def chunked(draw: st.DrawFn, data: bytes) -> list[bytes]:
    """Cut bytes into portions: all at once, one by one, or anywhere."""
    how = draw(st.sampled_from(["whole", "bytes", "anywhere"]))
    if how == "whole":
        return [data]
    if how == "bytes":
        return [bytes([byte]) for byte in data]
    cuts = draw(st.lists(st.integers(0, len(data)), max_size=6))
    at = sorted({0, len(data), *cuts})
    return [data[a:b] for a, b in pairwise(at)]
