"""What the tests of the host of MKS drives say and hear."""

from firmware_protocol.frames import pack
from firmware_protocol.mks import (
    Code,
    EncoderRead,
    Host,
    MoveAbsoluteAxis,
    MoveRelativeAxis,
    Outcome,
    Status,
    Stop,
    encode,
)

NODES = range(1, 7)
ONE, TWO, THREE = (MoveAbsoluteAxis(0x4000 * turns, 600, 2) for turns in (1, 2, 3))
BY = MoveRelativeAxis(100, 60, 2)
HALT = Stop(Code.ABSOLUTE_AXIS, 4)
HERE = EncoderRead(123)


def said(node, *answers) -> bytes:
    return b"".join(pack(encode(node, answer)) for answer in answers)


def outcome(what: Outcome, code=Code.ABSOLUTE_AXIS) -> Status:
    return Status(code, what)


STARTED, DONE, FAILED = map(outcome, (Outcome.STARTED, Outcome.DONE, Outcome.FAILED))
LIMIT, STORED = map(outcome, (Outcome.LIMIT_STOP, Outcome.STORED))


def asked(*requests, node=1) -> Host:
    host = Host(NODES)
    for request in requests:
        host.send(node, request)
    return host
