"""A port with a simulated arm behind it, for the doctor: any baud rate may be tried on it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace

from serial.tools import list_ports as pyserial
from uart import Receiver

from armdrive.connecting import simulated_config
from armdrive.doctor import carrying
from armdrive.doctor.carrying import carry_out
from armdrive.doctor.probes import PROBES
from armdrive.doctor.probing import Examination, examine
from armdrive.sim.device import SimDevice
from armdrive.sim.pacing import PacedDevice
from armdrive.sim.twin import make_device
from armdrive.sim.twins import TWINS

SPOKEN = sorted({probe.dialect for probe in PROBES} & set(TWINS))
"""The dialects of the table of probes that have a simulated arm."""


def made(dialect: str, **settings: object) -> SimDevice:
    """Return a simulated arm, its motors holding it."""
    device = make_device(simulated_config(dialect), settings=settings)
    device.world.energised = True
    return device


@dataclass
class SimPort:
    """A link at any baud rate; at another than the device's, both ends hear what a UART hears."""

    device: SimDevice
    receiver: Receiver = field(default_factory=lambda: Receiver(9600))
    baud: int = 0
    now: float = 0.0
    closed: bool = False

    def __post_init__(self) -> None:
        self.line = PacedDevice(self.device, self.device.baud)
        self.description = "a simulated port"
        self.baud = self.baud or self.device.baud or 0

    def tune(self, baud: int) -> None:
        self.baud = baud

    def write(self, data: bytes, now_s: float) -> None:
        self.line.send(self._heard(data, self.baud, self.device.baud), now_s)

    def read(self, now_s: float) -> bytes:
        return self._heard(self.line.receive(now_s), self.device.baud, self.baud)

    def next_s(self) -> float:
        return self.line.next_s()

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
        return carry_out(examine(baud), self, self)

    def _heard(self, data: bytes, said_baud: int | None, heard_baud: int | None) -> bytes:
        if not data or said_baud == heard_baud or None in (said_baud, heard_baud):
            return data
        error, validates, by_level = (
            self.receiver.error,
            self.receiver.validates,
            self.receiver.by_level,
        )
        return Receiver(heard_baud, error, validates, by_level).hear(data, said_baud)


BANNER = b"\r\nGrbl 1.1h ['$' for help]\r\n"
"""What a GRBL board says when it has started."""

NUMBER = "A50285BI"
"""An adapter's USB serial number."""


def plug(monkeypatch, adapters: dict[Path, str | None]) -> None:
    """Pretend that these USB adapters are plugged in; files stand in for their devices."""
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
    """Have a port lead to a device on simulated time; each opening is noted, with its rate."""
    opened: list[int] = []
    sim = SimPort(device)

    def open_it(name: str, baud: int) -> SimPort:
        assert name == str(port)
        opened.append(baud)
        return sim

    monkeypatch.setattr(carrying, "_opened", open_it)
    monkeypatch.setattr(carrying, "RealClock", lambda: sim)
    return opened


class Deaf:
    """A device that says what it was told to, whoever asks: no arm at all."""

    byte_gap_s = 0.0

    def __init__(self, *says: tuple[float, bytes], baud: int = 9600, answers: bytes = b"") -> None:
        self.baud = baud
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


class Echo(Deaf):
    """A wire whose transmit and receive are joined."""

    def receive(self, data: bytes, now_s: float) -> None:
        self._says.append((now_s, data))
