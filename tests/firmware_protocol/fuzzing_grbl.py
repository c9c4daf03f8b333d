"""The GRBL codec's two ends for the long fuzz run."""

import random

from chunks import events
from fuzzing import FuzzCase

from firmware_protocol.grbl import (
    GRBLHAL,
    MEGA_5X,
    Alarm,
    AxesInfo,
    Banner,
    BuildInfo,
    Device,
    Empty,
    Error,
    Feedback,
    Host,
    Line,
    LineReceived,
    Ok,
    Parameter,
    QuerySettings,
    Rejected,
    SetSetting,
    Setting,
    State,
    StatusReport,
    Unreadable,
    encode_answer,
)

AXES = "XYZABC"


def _number(rng: random.Random) -> float:
    return rng.randint(-999_999, 999_999) / 1000


def _place(rng: random.Random) -> tuple[float, ...]:
    return tuple(_number(rng) for _ in AXES)


def _target(rng: random.Random) -> str:
    return "".join(f"{letter}{_number(rng)}" for letter in rng.sample(AXES, rng.randint(1, 4)))


COMMANDS = (
    lambda rng: Line(f"G90G1{_target(rng)}F{rng.randint(1, 9999)}"),
    lambda rng: Line(f"G91G0{_target(rng)}"),
    lambda rng: Line(f"$J=G91{_target(rng)}F{rng.randint(1, 9999)}"),
    lambda rng: Line(f"G4P{rng.random():.3f}"),
    lambda rng: QuerySettings(),
    lambda rng: SetSetting(rng.randint(0, 255), _number(rng)),
)
ANSWERS = (
    lambda rng: Ok(),
    lambda rng: Error(rng.randint(1, 60)),
    lambda rng: Alarm(rng.randint(1, 18)),
    lambda rng: StatusReport(rng.choice(list(State)), None, _place(rng), feed=1.0, speed=0.0),
    lambda rng: StatusReport(State.HOLD, 1, None, _place(rng), 15, 128, work_offset=_place(rng)),
    lambda rng: Banner(),
    lambda rng: Setting(rng.randint(0, 132), f"{_number(rng):.3f}"),
    lambda rng: Feedback("Reset to continue"),
    lambda rng: BuildInfo("VNMZ", 35, 254),
    lambda rng: AxesInfo(6, AXES),
    lambda rng: Parameter("G54", _place(rng)),
)


def _line(rng: random.Random) -> bytes:
    realtime = rng.choice((b"", b"", b"?", b"!", b"\x85"))
    return realtime + rng.choice(COMMANDS)(rng).text.encode() + b"\n"


def _host_saw_one(host: Host) -> bool:
    found = events(host)
    while len(host.outstanding_lines) < 3 and host.room_for(QuerySettings()):
        host.send(QuerySettings())
    return any(not isinstance(event, Unreadable) for event in found)


def _device_saw_one(device: Device) -> bool:
    lines = [event for event in events(device) if isinstance(event, LineReceived)]
    for _ in lines:
        device.send(Ok())
    return any(not isinstance(line.content, Rejected | Empty) for line in lines)


HOST = FuzzCase(
    "grbl host",
    lambda: Host(MEGA_5X),
    lambda rng: encode_answer(rng.choice(ANSWERS)(rng)),
    _host_saw_one,
)
DEVICE = FuzzCase("grbl device", lambda: Device(GRBLHAL), _line, _device_saw_one)
