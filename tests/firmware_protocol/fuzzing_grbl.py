"""The GRBL codec's two ends for the long fuzz run."""

import random

from chunks import events
from fuzzing import FuzzCase

from firmware_protocol import grbl

AXES = "XYZABC"


def _number(rng: random.Random) -> float:
    return rng.randint(-999_999, 999_999) / 1000


def _place(rng: random.Random) -> tuple[float, ...]:
    return tuple(_number(rng) for _ in AXES)


def _target(rng: random.Random) -> str:
    return "".join(f"{letter}{_number(rng)}" for letter in rng.sample(AXES, rng.randint(1, 4)))


COMMANDS = (
    lambda rng: grbl.Line(f"G90G1{_target(rng)}F{rng.randint(1, 9999)}"),
    lambda rng: grbl.Line(f"G91G0{_target(rng)}"),
    lambda rng: grbl.Line(f"$J=G91{_target(rng)}F{rng.randint(1, 9999)}"),
    lambda rng: grbl.Line(f"G4P{rng.random():.3f}"),
    lambda rng: grbl.QuerySettings(),
    lambda rng: grbl.SetSetting(rng.randint(0, 255), _number(rng)),
)
ANSWERS = (
    lambda rng: grbl.Ok(),
    lambda rng: grbl.Error(rng.randint(1, 60)),
    lambda rng: grbl.Alarm(rng.randint(1, 18)),
    lambda rng: grbl.StatusReport(
        rng.choice(list(grbl.State)), None, _place(rng), feed=1.0, speed=0.0
    ),
    lambda rng: grbl.StatusReport(
        grbl.State.HOLD, 1, None, _place(rng), 15, 128, work_offset=_place(rng)
    ),
    lambda rng: grbl.Banner(),
    lambda rng: grbl.Setting(rng.randint(0, 132), f"{_number(rng):.3f}"),
    lambda rng: grbl.Feedback("Reset to continue"),
    lambda rng: grbl.BuildInfo("VNMZ", 35, 254),
    lambda rng: grbl.AxesInfo(6, AXES),
    lambda rng: grbl.Parameter("G54", _place(rng)),
)


def _line(rng: random.Random) -> bytes:
    realtime = rng.choice((b"", b"", b"?", b"!", b"\x85"))
    return realtime + rng.choice(COMMANDS)(rng).text.encode() + b"\n"


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
    lambda rng: grbl.encode_answer(rng.choice(ANSWERS)(rng)),
    _host_saw_one,
)
DEVICE = FuzzCase("grbl device", lambda: grbl.Device(grbl.GRBLHAL), _line, _device_saw_one)
