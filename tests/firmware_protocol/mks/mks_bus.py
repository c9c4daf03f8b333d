"""What the tests of the host of MKS drives say and hear."""

from firmware_protocol import mks
from firmware_protocol.frames import pack

NODES = range(1, 7)
ONE, TWO, THREE = (mks.MoveAbsoluteAxis(0x4000 * turns, 600, 2) for turns in (1, 2, 3))
BY = mks.MoveRelativeAxis(100, 60, 2)
HALT = mks.Stop(mks.Code.ABSOLUTE_AXIS, 4)
HERE = mks.EncoderRead(123)


def said(node, *answers) -> bytes:
    return b"".join(pack(mks.encode(node, answer)) for answer in answers)


def outcome(what: mks.Outcome, code=mks.Code.ABSOLUTE_AXIS) -> mks.Status:
    return mks.Status(code, what)


STARTED, DONE, FAILED = map(outcome, (mks.Outcome.STARTED, mks.Outcome.DONE, mks.Outcome.FAILED))
LIMIT, STORED = map(outcome, (mks.Outcome.LIMIT_STOP, mks.Outcome.STORED))


def asked(*requests, node=1) -> mks.Host:
    host = mks.Host(NODES)
    for request in requests:
        host.send(node, request)
    return host
