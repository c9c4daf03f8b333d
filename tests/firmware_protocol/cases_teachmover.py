"""What the TeachMover tests draw from: every command and reply, and every way to cut a stream."""

from fuzzing import FuzzCase
from hypothesis import strategies as st

from firmware_protocol import teachmover
from firmware_protocol.teachmover.messages import encode_reply

BYTE = st.integers(0, 255)
SPEED = st.integers(0, 245)
SIX_STEPS = st.tuples(*[st.integers(-32768, 32767)] * 6)
ROWS = st.builds(teachmover.ProgramRow, st.integers(0, 65535), BYTE, SIX_STEPS, BYTE)
MAYBE_SPEED = st.none() | SPEED
COMMANDS = st.one_of(
    st.builds(teachmover.Step, SPEED, SIX_STEPS, st.none() | BYTE),
    st.sampled_from([teachmover.Read(), teachmover.Reset(), teachmover.Run(), teachmover.QDump()]),
    st.builds(teachmover.Close, MAYBE_SPEED),
    st.builds(teachmover.Set, MAYBE_SPEED),
    st.builds(teachmover.QWrite, ROWS),
)
REGISTERS = st.builds(teachmover.Registers, SIX_STEPS, BYTE, BYTE)
STATUSES = st.sampled_from(teachmover.Status)
REPLIES = st.one_of(STATUSES, REGISTERS, ROWS)


# -- The ends of the codec for the long fuzz run ---------------------------------------------------


def _host_saw_one(host: teachmover.Host) -> bool:
    """Ask for nothing, so that every readable line is an event of its own."""
    seen = False
    while (event := host.next_event()) is not None:
        seen |= isinstance(event, teachmover.Completed | teachmover.Stray)
    return seen


HOST = FuzzCase("teachmover host", teachmover.Host, REPLIES.map(encode_reply), _host_saw_one)
