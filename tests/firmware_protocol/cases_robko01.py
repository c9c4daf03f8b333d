"""What the Robko 01 tests draw from: every request and a fitting answer."""

from fuzzing import FuzzCase
from hypothesis import strategies as st

from firmware_protocol import robko01
from firmware_protocol.robko01.messages import encode_answer

BYTE = st.integers(0, 255)
PAYLOAD = st.binary(max_size=26)
WORDS = st.tuples(*[st.integers(-32768, 32767)] * 6)
AXES = st.builds(robko01.Axes, WORDS, WORDS)
PLAIN = [
    robko01.Stop,
    robko01.Disable,
    robko01.Enable,
    robko01.Clear,
    robko01.Inputs,
    robko01.IsMoving,
    robko01.Position,
]
MOVES = (robko01.MoveRelative, robko01.MoveAbsolute, robko01.MoveSpeed)
REQUESTS = st.one_of(
    st.sampled_from([kind() for kind in PLAIN]),
    st.builds(robko01.Ping, PAYLOAD),
    *[
        st.builds(kind, AXES)
        for kind in (robko01.MoveRelative, robko01.MoveAbsolute, robko01.MoveSpeed)
    ],
    st.builds(robko01.Outputs, BYTE),
)
VALUES = {
    robko01.Op.INPUTS: st.builds(robko01.InputsRead, BYTE),
    robko01.Op.IS_MOVING: st.builds(robko01.Moving, BYTE),
    robko01.Op.POSITION: st.builds(robko01.Positions, AXES),
    robko01.Op.OUTPUTS: st.builds(robko01.OutputsSet, BYTE)
    | st.just(robko01.Acknowledged(robko01.Op.OUTPUTS)),
}
NOT_OK = st.sampled_from([robko01.Status.ERROR, robko01.Status.BUSY, robko01.Status.TIMEOUT])


def answers_to(request):
    """Draw an answer to a request, as a device may send it."""
    refused = st.builds(robko01.Acknowledged, st.just(request.op), NOT_OK)
    busy = st.builds(robko01.Busy, st.just(request.op), BYTE)
    if isinstance(request, robko01.Ping):
        done = st.just(robko01.Pong(request.payload))
    else:
        done = (
            VALUES[request.op]
            if request.op in VALUES
            else st.just(robko01.Acknowledged(request.op))
        )
    return done | refused | busy


ANSWERS = REQUESTS.flatmap(answers_to)
EXCHANGES = REQUESTS.flatmap(lambda request: st.tuples(st.just(request), answers_to(request)))


# -- The ends of the codec for the long fuzz run ---------------------------------------------------


def _host_saw_one(host: robko01.Host) -> bool:
    seen = False
    while (event := host.next_event()) is not None:
        seen |= isinstance(event, robko01.Answered | robko01.Stray)
    if host.outstanding is None:
        host.send(robko01.Position())
    return seen


HOST = FuzzCase("robko01 host", robko01.Host, ANSWERS.map(encode_answer), _host_saw_one)
