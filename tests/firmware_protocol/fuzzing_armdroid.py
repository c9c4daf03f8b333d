"""The Armdroid codec's two ends for the long fuzz run."""

from armdroid_strategies import ANSWERS, PLAIN, events
from fuzzing import FuzzCase
from hypothesis import strategies as st

from firmware_protocol import armdroid
from firmware_protocol.armdroid.messages import encode_answer, encode_command


def _host_saw_one(host: armdroid.Host) -> bool:
    found = any(
        isinstance(event, armdroid.Completed | armdroid.Stray | armdroid.Welcome)
        for event in events(host)
    )
    if host.outstanding is None:
        host.send(armdroid.ReportOffsets())
    return found


def _device_saw_one(device: armdroid.Device) -> bool:
    return any(
        not isinstance(event, armdroid.Ignored | armdroid.Overrun) for event in events(device)
    )


LINES = (ANSWERS | st.just(armdroid.Welcome())).map(encode_answer)
MOST_HELD = 256 * 80 + 80
HOST = FuzzCase("armdroid host", armdroid.Host, LINES, _host_saw_one, MOST_HELD, most_good=2)
DEVICE = FuzzCase(
    "armdroid device",
    armdroid.Device,
    PLAIN.map(encode_command),
    _device_saw_one,
    MOST_HELD,
    most_good=2,
)
