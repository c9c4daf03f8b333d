"""Watches what passes the adapter of a driver that steers drives on a bus: rounds of targets."""

from __future__ import annotations

import abc
import contextlib
import itertools
import time
from collections.abc import Iterator, Mapping
from types import MappingProxyType

from tapping import tapped

from armdrive.arm import Arm
from armdrive.transports.can_health import frame_bits
from firmware_protocol.canopen import COMMAND_PDO, REPORT_PDO, Service, service_of
from firmware_protocol.frames import Frame, Unpacker
from firmware_protocol.mks import Code


class Rounds(abc.ABC):
    """Knows when each round of targets began, in s, and how far drives were behind it."""

    def __init__(self) -> None:
        self.behind: list[int] = []
        """By how much a drive was not where it was told to be, in counts, as far as is told."""

    @abc.abstractmethod
    def sent(self, frame: Frame, time_s: float) -> None:
        """Take a frame that had gone out by then."""

    @abc.abstractmethod
    def heard(self, frame: Frame) -> None:
        """Take a frame that has come in."""

    @abc.abstractmethod
    def periods_s(self) -> list[float]:
        """Return the times from one round to the next."""

    @staticmethod
    @abc.abstractmethod
    def longest_s(arm: Arm) -> float:
        """Return the period beyond which drives brake by themselves."""


class MksRounds(Rounds):
    """Orders for one drive after the other; a round goes up through the ids."""

    def __init__(self) -> None:
        super().__init__()
        self._orders: list[tuple[float, int]] = []

    def sent(self, frame: Frame, time_s: float) -> None:
        """Note an order for a motion."""
        if frame.data[:1] == bytes((Code.ABSOLUTE_AXIS,)):
            self._orders.append((time_s, frame.can_id))

    def heard(self, frame: Frame) -> None:
        """Take no note of what drives answer."""

    def periods_s(self) -> list[float]:
        """Return the times between first frames of rounds."""
        starts = [self._orders[0][0]] if self._orders else []
        for before, after in itertools.pairwise(self._orders):
            if after[1] <= before[1]:
                starts.append(after[0])
        return [b - a for a, b in itertools.pairwise(starts)]

    @staticmethod
    def longest_s(arm: Arm) -> float:
        """Return how far ahead targets are sent."""
        return arm.config.motion.planned_burst_s


class SyncRounds(Rounds):
    """Targets, which SYNC makes valid: a round begins with it. One that is not told again stays.

    A drive tells at each SYNC where it is: that is compared with what it was to reach by then.
    """

    def __init__(self) -> None:
        super().__init__()
        self._given: dict[int, int] = {}
        self._due: dict[int, int] = {}
        self._last: dict[int, int] = {}
        """Targets that wait for SYNC; that drives are on their way to; that they were to reach."""
        self._steered = False
        self._last_s: float | None = None
        self._periods_s: list[float] = []

    def sent(self, frame: Frame, time_s: float) -> None:
        """Note a target, or that all of them are due."""
        service, node = service_of(frame.can_id) or (None, 0)
        if service is Service.RPDO1:
            self._given[node] = int(COMMAND_PDO.unpack(frame.data)[2])
            self._steered = True
        elif service is Service.SYNC:
            if self._steered and self._last_s is not None:
                self._periods_s.append(time_s - self._last_s)
            # what is asked where it is, and told nothing, is not steered
            self._last_s = time_s if self._steered else None
            self._last, self._due = self._due, dict(self._given)
            self._steered = False

    def heard(self, frame: Frame) -> None:
        """Note how far a drive is from where it was to be."""
        service, node = service_of(frame.can_id) or (None, 0)
        if service is Service.TPDO1 and node in self._last:
            position = int(REPORT_PDO.unpack(frame.data)[2])
            self.behind.append(abs(position - self._last.pop(node)))

    def periods_s(self) -> list[float]:
        """Return the times between the SYNCs that had targets before them."""
        return self._periods_s

    @staticmethod
    def longest_s(arm: Arm) -> float:
        """Return after how long drives miss the heartbeat of a program that does nothing."""
        return float(arm.config.device.heartbeat_timeout_ms) / 1e3


ROUNDS: Mapping[str, type[Rounds]] = MappingProxyType({"mks": MksRounds, "cia402": SyncRounds})


class Wire:
    """What passed a driver's adapter: frames, and the rounds of targets among them.

    It is noted as it comes and read afterwards, so that reading does not slow down what is watched.
    """

    def __init__(self, rounds: Rounds) -> None:
        self.bits = self.frames = 0
        self._rounds = rounds
        self._noted: list[tuple[float, bytes, bool]] = []
        self._unpackers = {True: Unpacker(), False: Unpacker()}

    def sent(self, data: bytes, time_s: float) -> None:
        """Take records of frames that had gone out by then."""
        self._noted.append((time_s, data, True))

    def heard(self, data: bytes, time_s: float) -> None:
        """Take records of frames that have come in by then."""
        if data:
            self._noted.append((time_s, data, False))

    def rounds(self) -> Rounds:
        """Read what has been noted, and return what is known by it."""
        noted, self._noted = self._noted, []
        for time_s, data, out in noted:
            for frame in self._unpackers[out].feed(data):
                self.bits += frame_bits(frame)
                self.frames += 1
                if out:
                    self._rounds.sent(frame, time_s)
                else:
                    self._rounds.heard(frame)
        return self._rounds


@contextlib.contextmanager
def watched(arm: Arm) -> Iterator[Wire]:
    """Note all that passes the adapter of an arm."""
    wire, link = Wire(ROUNDS[arm.config.connection.dialect]()), arm.parts.engine.link
    read = link.read

    def noted_read(now_s: float) -> bytes:
        data = read(now_s)
        wire.heard(data, time.monotonic())
        return data

    link.read = noted_read  # type: ignore[method-assign]
    with tapped(arm, lambda data: wire.sent(data, time.monotonic())):
        yield wire
    link.read = read  # type: ignore[method-assign]
