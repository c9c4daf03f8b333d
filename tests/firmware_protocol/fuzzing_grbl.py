"""The GRBL codec's two ends for the long fuzz run."""

from chunks import events
from fuzzing import FuzzCase
from grbl_strategies import ANSWERS, COMMANDS
from hypothesis import strategies as st

from firmware_protocol import grbl

REALTIME = st.sampled_from((b"", b"", b"?", b"!", b"\x85"))
LINES = st.builds(
    lambda realtime, command: realtime + command.text.encode() + b"\n", REALTIME, COMMANDS
)


def _host_saw_one(host: grbl.Host) -> bool:
    found = events(host)
    while len(host.outstanding_lines) < 3 and host.room_for(grbl.QuerySettings()):
        host.send(grbl.QuerySettings())
    return any(not isinstance(event, grbl.Unreadable) for event in found)


def _device_saw_one(device: grbl.Device) -> bool:
    lines = [event for event in events(device) if isinstance(event, grbl.LineReceived)]
    for _ in lines:
        device.send(grbl.Ok())
    return any(not isinstance(line.content, grbl.Rejected | grbl.Empty) for line in lines)


HOST = FuzzCase(
    "grbl host",
    lambda: grbl.Host(grbl.MEGA_5X),
    ANSWERS.map(grbl.encode_answer),
    _host_saw_one,
)
DEVICE = FuzzCase("grbl device", lambda: grbl.Device(grbl.GRBLHAL), LINES, _device_saw_one)
