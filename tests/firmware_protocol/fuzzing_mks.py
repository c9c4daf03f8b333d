"""The two ends of a bus of MKS drives for the long fuzz run."""

from chunks import events
from fuzzing import FuzzCase
from hypothesis import strategies as st
from mks_strategies import READINGS, REQUESTS

from firmware_protocol import mks
from firmware_protocol.frames import pack

NODES = range(1, 7)
MOTIONS = st.sampled_from(sorted(mks.MOTION_CODES))
STATUSES = st.one_of(
    st.builds(mks.Status, MOTIONS, st.sampled_from(mks.Outcome)),
    st.sampled_from(
        [
            mks.Status(mks.Code.ENABLE, mks.Outcome.FAILED),
            mks.Status(mks.Code.MODE, mks.Outcome.DONE),
            mks.Status(mks.Code.REPORT, mks.Outcome.DONE, mks.Code.ENCODER),
        ]
    ),
)


def _records(nodes, messages):
    return st.builds(lambda node, message: pack(mks.encode(node, message)), nodes, messages)


ANSWER_RECORDS = _records(st.sampled_from(NODES), READINGS | STATUSES)
REQUEST_RECORDS = _records(st.sampled_from((0, 1)), REQUESTS)


def _host_saw_one(host: mks.Host) -> bool:
    found = any(
        not isinstance(event, mks.UnreadableFrame | mks.Foreign | mks.Overrun)
        for event in events(host)
    )
    for node in NODES:
        host.send(node, mks.MoveAbsoluteAxis(1, 1, 1))
        if not any(isinstance(request, mks.ReadEncoder) for request in host.unanswered(node)):
            host.send(node, mks.ReadEncoder())
    return found


def _device_saw_one(device: mks.Device) -> bool:
    return any(isinstance(event, mks.Asked) for event in events(device))


HOST = FuzzCase("mks host", lambda: mks.Host(NODES), ANSWER_RECORDS, _host_saw_one)
DEVICE = FuzzCase("mks device", lambda: mks.Device(1), REQUEST_RECORDS, _device_saw_one)
