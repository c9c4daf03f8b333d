"""What the Robko 01 tests draw from: every request and a fitting answer."""

from hypothesis import strategies as st

from firmware_protocol.robko01 import (
    Acknowledged,
    Axes,
    Busy,
    Clear,
    Disable,
    Enable,
    GetRobotId,
    Inputs,
    InputsRead,
    IsMoving,
    LoadPosition,
    MoveAbsolute,
    MoveRelative,
    MoveSpeed,
    Moving,
    Op,
    Outputs,
    OutputsSet,
    Ping,
    Pong,
    Position,
    Positions,
    RobotId,
    SavePosition,
    SetRobotId,
    Status,
    Stop,
)

BYTE = st.integers(0, 255)
PAYLOAD = st.binary(max_size=26)
WORDS = st.tuples(*[st.integers(-32768, 32767)] * 6)
AXES = st.builds(Axes, WORDS, WORDS)
PLAIN = [Stop, Disable, Enable, Clear, Inputs, IsMoving, Position, SavePosition, LoadPosition]
REQUESTS = st.one_of(
    st.sampled_from([kind() for kind in PLAIN]),
    st.builds(Ping, PAYLOAD),
    *[st.builds(kind, AXES) for kind in (MoveRelative, MoveAbsolute, MoveSpeed)],
    st.builds(Outputs, BYTE),
    *[st.builds(kind, PAYLOAD) for kind in (SetRobotId, GetRobotId)],
)
VALUES = {
    Op.INPUTS: st.builds(InputsRead, BYTE),
    Op.IS_MOVING: st.builds(Moving, BYTE),
    Op.POSITION: st.builds(Positions, AXES),
    Op.OUTPUTS: st.builds(OutputsSet, BYTE) | st.just(Acknowledged(Op.OUTPUTS)),
    Op.SET_ROBOT_ID: st.builds(RobotId, st.just(Op.SET_ROBOT_ID), PAYLOAD),
    Op.GET_ROBOT_ID: st.builds(RobotId, st.just(Op.GET_ROBOT_ID), PAYLOAD),
}
NOT_OK = st.sampled_from([Status.ERROR, Status.BUSY, Status.TIMEOUT])


def answers_to(request):
    """Draw an answer to a request, as a device may send it."""
    refused = st.builds(Acknowledged, st.just(request.op), NOT_OK)
    busy = st.builds(Busy, st.just(request.op), BYTE)
    if isinstance(request, Ping):
        done = st.just(Pong(request.payload))
    else:
        done = VALUES[request.op] if request.op in VALUES else st.just(Acknowledged(request.op))
    return done | refused | busy


ANSWERS = REQUESTS.flatmap(answers_to)
EXCHANGES = REQUESTS.flatmap(lambda request: st.tuples(st.just(request), answers_to(request)))
