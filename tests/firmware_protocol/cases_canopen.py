"""The master's end of a bus with CiA 402 drives for the long fuzz run; a drive takes frames."""

from chunks import events
from fuzzing import FuzzCase
from hypothesis import strategies as st

from firmware_protocol import canopen
from firmware_protocol.frames import Frame, pack

NODES = range(1, 7)
NODE, SIZE = st.sampled_from(NODES), canopen.REPORT_PDO.size
REPORTS = st.builds(
    lambda node, data: Frame(canopen.cob_id(canopen.Service.TPDO1, node), data),
    NODE,
    st.binary(min_size=SIZE, max_size=SIZE),
)
MESSAGES = st.one_of(
    st.builds(canopen.Heartbeat, NODE, st.sampled_from(canopen.NodeState)),
    st.builds(canopen.Emergency, NODE, st.integers(0, 0xFFFF), st.integers(0, 255)),
)
RECORDS = (REPORTS | MESSAGES.map(lambda message: message.frame)).map(pack)


def _asking() -> canopen.Host:
    host = canopen.Host(NODES)
    for node in NODES:
        host.upload(node, canopen.Place(0x1000))
    return host


def _host_saw_one(host: canopen.Host) -> bool:
    good = canopen.DriveReport | canopen.Heartbeat | canopen.Emergency
    return any(isinstance(event, good) for event in events(host))


HOST = FuzzCase("canopen host", _asking, RECORDS, _host_saw_one)
