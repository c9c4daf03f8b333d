"""A port with a simulated arm behind it, for the doctor, which may try any baud rate."""

import math
import re
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

from serial.tools import list_ports as pyserial
from uart import Receiver

from armdrive.connect.port import recogniser
from armdrive.connect.target import simulated_config
from armdrive.registry import simulate
from armdrive.setup import dialog_runner
from armdrive.setup import prober as carrying
from armdrive.setup.dialog_runner import DialogClock
from armdrive.setup.prober import QUICK_BAUD, Examination, examine
from armdrive.sim.device import SimDevice
from armdrive.sim.wire import DeviceLine
from armdrive.transports import opening
from armdrive.transports.can_health import BusHealth
from armdrive.transports.link import Link
from firmware_protocol.robko01 import Axes, Enable, Host, MoveAbsolute

WHO = recogniser()
PROBES = WHO.probes
SPOKEN = sorted({probe.dialect for probe in PROBES})
"""The dialects that the doctor can probe for."""


def made(dialect: str, **settings: object) -> SimDevice:
    """Return a simulated arm whose motors hold it."""
    device = simulate(simulated_config(dialect), **settings).device
    device.world.energised = True
    return device


@dataclass
class SimPort(Link):
    """A link at any baud rate; at a wrong rate, both ends receive what a UART would."""

    description = "a simulated port"

    device: SimDevice
    receiver: Receiver = field(default_factory=lambda: Receiver(9600))
    baud: int = 0
    now: float = 0.0
    closed: bool = False

    def __post_init__(self) -> None:
        self.line = DeviceLine(self.device, self.device.board.baud)
        self.baud = self.baud or QUICK_BAUD

    def tune(self, baud: int) -> None:
        self.baud = baud

    def write(self, data: bytes, now_s: float) -> None:
        self.line.send(self._heard(data, self.baud, self.device.board.baud), now_s)

    def read(self, now_s: float) -> bytes:
        return self._heard(self.line.receive(now_s), self.device.board.baud, self.baud)

    def next_s(self) -> float:
        return self.line.next_s()

    def run(self, until_s: float) -> float:
        return min(self.next_s(), until_s)

    def wait(self, timeout_s: float) -> None:
        raise AssertionError("simulated time needs no sleep")

    def wake(self) -> None:
        pass

    def close(self) -> None:
        self.closed = True

    # the clock

    def now_s(self) -> float:
        return self.now

    def sleep(self, link: object, until_s: float) -> None:
        due_s = self.line.next_s()
        self.now = until_s if math.isinf(due_s) else min(until_s, max(due_s, self.now + 1e-5))

    def pass_time(self, time_s: float) -> bytes:
        self.now += time_s
        return self.read(self.now)

    def examine(self, baud: int | None = None) -> Examination:
        return examine(self, self, baud)

    def _heard(self, data: bytes, said_baud: int | None, heard_baud: int | None) -> bytes:
        if not data or said_baud == heard_baud or None in (said_baud, heard_baud):
            return data
        error, validates, by_level = (
            self.receiver.error,
            self.receiver.validates,
            self.receiver.by_level,
        )
        return Receiver(heard_baud, error, validates, by_level).hear(data, said_baud)


AFTER_S = 40.0
"""Longer than any motion below lasts."""


def robko(*requests) -> bytes:
    return b"".join(Host().send(each) for each in requests)


MOVE = MoveAbsolute(Axes((100, 0, 0, 0, 0, 0), (50, 50, 50, 50, 50, 50)))
PREPARED: defaultdict[str, dict[str, tuple[bytes, float]]] = defaultdict(
    lambda: {"fresh": (b"", AFTER_S)},
    {
        "teachmover": {
            "fresh": (b"", 0.0),
            "half a command": (b"@STEP 240,100,100,0,0,0,0", 1.0),
            "in motion": (b"@STEP 0,200,-100,0,0,0,0\r", 0.5),
        },
        "armdroid": {
            "fresh": (b"", 3.0),
            "with numbers to repeat": (b"10,20,30,40,50,60D", 5.0),
            "half a command": (b"10,20,30,40,50,60D10,2", 5.0),
            "in a long motion": (b"50,0,0,0,0,0D20s0,0,0,0,0,300D", 2.0),
        },
        "robko01": {
            "fresh": (b"", 0.0),
            "half a frame": (robko(Enable()) + robko(MOVE)[:9], 1.0),
            "all but the last byte of a frame": (robko(Enable()) + robko(MOVE)[:-1], 1.0),
            "the least of the longest frame": (b"\xaa\x01\x1b", 1.0),
            "in motion": (robko(Enable()) + robko(MOVE), 0.5),
        },
        "grbl": {
            "fresh": (b"", 3.0),
            "half a line": (b"G1G91X10F300", 3.0),
            "half a line with an open comment": (b"G1G91X10F300(a", 3.0),
            "in motion": (b"G1G91X30F600\n", 0.5),
        },
    },
)
"""The bytes that another program sent at the device's baud rate, and how long ago, in s."""

LINE_ENDS_ACT = [("grbl", "half a line with an open comment")]
"""Here any line end starts a motion: the doctor sends none to a board that replies to `?`."""


def prepared(dialect: str, state: str, *, any_rate: bool = False) -> SimPort:
    """Return a port with an arm behind it; with `any_rate`, over native USB, which has no rate."""
    device = made(dialect)
    if any_rate:
        device.board.baud = None
    port = SimPort(device)
    port.pass_time(3.0)  # a board ignores input while it boots
    data, ago_s = PREPARED[dialect][state]
    port.tune(port.device.board.baud or 0)
    port.write(data, port.now)
    port.pass_time(ago_s)
    return port


def unexamined(dialect: str, state: str, until_s: float):
    """Return a device that was not examined, at the same moment."""
    port = prepared(dialect, state)
    port.pass_time(until_s - port.now)
    return port.device


def check_unmoved(port: SimPort, dialect: str, state: str) -> None:
    port.pass_time(AFTER_S)
    other = unexamined(dialect, state, port.now)
    assert port.device.world.motors == other.world.motors
    assert port.device.world.energised == other.world.energised
    assert not port.device.moving


BANNER = b"\r\nGrbl 1.1h ['$' for help]\r\n"
"""The greeting of a GRBL board after it boots."""

NUMBER = "A50285BI"
"""An adapter's USB serial number."""


def plug(monkeypatch, adapters: dict[Path, str | None]) -> None:
    """Simulate USB adapters with these device files and serial numbers."""
    for device in adapters:
        device.touch()
    usb = {"vid": 0x0403, "pid": 0x6001, "manufacturer": "FTDI"}
    found = [
        SimpleNamespace(
            device=str(device), description="FT232R USB UART", serial_number=number, **usb
        )
        for device, number in adapters.items()
    ]
    monkeypatch.setattr(pyserial, "comports", lambda: found)


def lead(monkeypatch, port: object, device) -> list[int]:
    """Put a device behind a port, in simulated time; return the list of rates of its openings."""
    opened: list[int] = []
    sim = SimPort(device)

    def open_it(name: str, baud: int) -> SimPort:
        assert name == str(port)
        opened.append(baud)
        return sim

    monkeypatch.setattr(carrying, "_opened", open_it)
    monkeypatch.setattr(dialog_runner, "RealClock", lambda: sim)
    return opened


def lead_to_bus(monkeypatch, config) -> None:
    """Put an arm's simulated drives behind every adapter, in simulated time."""
    link, clock = simulate(config).link, DialogClock()
    link.health = BusHealth()
    monkeypatch.setattr(link, "close", lambda: None)  # the doctor opens it several times
    monkeypatch.setattr(opening, "open_can_link", lambda port: link)
    monkeypatch.setattr(dialog_runner, "RealClock", lambda: clock)


class ScriptedDevice(Link):
    """A device that is no arm: it sends its bytes at their times, and `answers` to everything."""

    def __init__(self, *says: tuple[float, bytes], baud: int = 9600, answers: bytes = b"") -> None:
        self.board = SimpleNamespace(baud=baud)
        self.heard = b""
        self._says = list(says)
        self._answers = answers
        self._now_s = 0.0

    def receive(self, data: bytes, now_s: float) -> None:
        self.heard += data
        if self._answers:
            self._says.append((now_s, self._answers))

    def transmit(self, now_s: float) -> bytes:
        said = b"".join(data for at_s, data in self._says if at_s <= now_s)
        self._says = [(at_s, data) for at_s, data in self._says if at_s > now_s]
        return said

    def next_s(self) -> float:
        return min((at_s for at_s, _ in self._says), default=math.inf)


class EchoDevice(ScriptedDevice):
    """A wire that sends everything back: transmit and receive are joined."""

    def receive(self, data: bytes, now_s: float) -> None:
        self._says.append((now_s, data))


class RewritingDevice(Link):
    """A device with some replies changed, such as a board of another build."""

    def __init__(self, device: SimDevice, *changes: tuple[bytes, bytes]) -> None:
        self._device = device
        self._changes = changes

    def __getattr__(self, name: str) -> object:
        return getattr(self._device, name)

    def transmit(self, now_s: float) -> bytes:
        said = self._device.transmit(now_s)
        for pattern, other in self._changes:
            said = re.sub(pattern, other, said)
        return said


THREE = rb"((?:-?[0-9.]+,){2}-?[0-9.]+)[0-9.,-]*"
THREE_AXES = (
    (rb"MPos:" + THREE, rb"MPos:\1"),
    (rb"WCO:" + THREE, rb"WCO:\1"),
    (rb"\[AXS[^\n]*\n", b""),
)
"""The changes that make the replies of a board with six axes those of one with three."""


class EchoingBoard(Link):
    """A board on a line that sends everything back before the board replies."""

    def __init__(self, device: SimDevice) -> None:
        self._device = device
        self._back = b""

    def __getattr__(self, name: str) -> object:
        return getattr(self._device, name)

    def receive(self, data: bytes, now_s: float) -> None:
        self._back += data
        self._device.receive(data, now_s)

    def transmit(self, now_s: float) -> bytes:
        back, self._back = self._back, b""
        return back + self._device.transmit(now_s)

    def next_s(self) -> float:
        return 0.0 if self._back else self._device.next_s()


class TableDevice(ScriptedDevice):
    """Firmware that replies to lines and to single characters from a table."""

    def __init__(self, answers: dict[bytes, bytes], default: bytes, greeting: bytes) -> None:
        super().__init__((0.1, greeting), baud=115_200)
        self._table = answers
        self._default = default
        self._line = b""

    def receive(self, data: bytes, now_s: float) -> None:
        self.heard += data
        for byte in data:
            one = bytes([byte])
            if one in self._table:
                self._says.append((now_s, self._table[one]))
                continue
            self._line += one
            if one == b"\n":
                line, self._line = self._line.strip(), b""
                self._says.append((now_s, self._table.get(line, self._default)))


class TwinBus:
    """The wire of simulated drives behind an adapter, at their bit rate or at another one."""

    def __init__(self, link, *, right=True):
        self.link, self.right, self.refused = link, right, 0

    @property
    def health(self):
        return BusHealth(refused=self.refused)

    def write(self, data, now_s):
        if self.right:
            self.link.write(data, now_s)
        else:
            self.refused += bool(data)

    def read(self, now_s):
        return self.link.read(now_s) if self.right else b""

    def next_s(self):
        return self.link.next_s() if self.right else math.inf

    def close(self):
        """Leave the drives' wire open."""
