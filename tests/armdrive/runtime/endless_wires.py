"""Wires that never let a call come to its end by themselves, on simulated time, for any dialect."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

from armdrive.arm import Arm
from armdrive.connect.parts import assemble
from armdrive.connect.target import simulated_config
from armdrive.registry import DIALECTS, simulate
from armdrive.runtime.clock import SimulatedPace
from armdrive.runtime.engine import Engine
from armdrive.sim.simulated_arm import SimulatedArm
from armdrive.transports.link import Link
from firmware_protocol.frames import Frame, Unpacker, pack

EVERY_S = 0.01
"""A flood comes in pieces of so long, as an operating system hands it over."""
DRIP_S = 0.12
"""A byte each: shorter than the silence that a reset waits for."""
JUST_BEFORE_S = 0.001

HEARTBEATS = b"".join(pack(Frame(0x700 + node, b"\x7f")) for node in (1, 2, 3, 4, 5, 6, 99))
IRRELEVANT = {
    "teachmover": b"0\r",
    "robko01": b"\r\n",
    "armdroid": b"Welcome, Armdroid!\r\n",
    "grbl": b"<Idle|MPos:0.000,0.000,0.000,0.000,0.000,0.000|FS:0,0>\r\n",
    "mks": HEARTBEATS,
    "cia402": HEARTBEATS,
}
"""What a device of the dialect may say, or others on its bus, and what answers nothing."""


def noise(dialect: str, size: int) -> bytes:
    """Return bytes of noise; on a bus, frames of ids that no drive here has."""
    draw = random.Random(size)
    if not DIALECTS[dialect].can:
        return draw.randbytes(size)
    return b"".join(pack(Frame(draw.randrange(0x10, 0x7F), draw.randbytes(8))) for _ in range(5))


class Wire(Link):
    """A link to a simulated arm that behaves until `spoil` puts another wire in its place."""

    description = "the wire"

    def __init__(self, twin: SimulatedArm) -> None:
        self.engine: Engine | None = None
        self.twin = twin
        self.now: Link = twin.link

    def spoil(self, kind: str | None) -> None:
        """Make it a wire of a kind from now on; None makes it a good one again."""
        self.now = self.twin.link if kind is None else KINDS[kind](self)

    def write(self, data: bytes, now_s: float) -> None:
        self.now.write(data, now_s)

    def read(self, now_s: float) -> bytes:
        return self.now.read(now_s)

    def next_s(self) -> float:
        return self.now.next_s()

    def wait(self, timeout_s: float) -> None:
        self.now.wait(timeout_s)

    def wake(self) -> None:
        self.now.wake()

    def close(self) -> None:
        self.now.close()


class Talker(Link):
    """A wire on which pieces come at regular times, whatever is sent."""

    description = "a talker"

    def __init__(self, piece: Callable[[int], bytes], every_s: float) -> None:
        self._piece, self._every_s = piece, every_s
        self._count, self._due_s = 0, -math.inf

    def write(self, data: bytes, now_s: float) -> None:
        """Lose it."""

    def read(self, now_s: float) -> bytes:
        if now_s < self._due_s:
            return b""
        self._due_s = now_s + self._every_s
        self._count += 1
        return self._piece(self._count)

    def next_s(self) -> float:
        return self._due_s


class Dilatory(Link):
    """A wire to the true device, each of whose answers comes just before it would be late."""

    description = "a slow device"

    def __init__(self, wire: Wire) -> None:
        self._wire, self._link = wire, wire.twin.link
        self._held, self._due_s = b"", math.inf

    def write(self, data: bytes, now_s: float) -> None:
        self._link.write(data, now_s)

    def read(self, now_s: float) -> bytes:
        if said := self._link.read(now_s):
            self._held += said
            assert self._wire.engine is not None
            late_s = self._wire.engine.controller.next_s()
            self._due_s = now_s if math.isinf(late_s) else max(now_s, late_s - JUST_BEFORE_S)
        if now_s < self._due_s:
            return b""
        held, self._held, self._due_s = self._held, b"", math.inf
        return held

    def next_s(self) -> float:
        return min(self._link.next_s(), self._due_s)

    def close(self) -> None:
        self._link.close()


def _flood(wire: Wire) -> Talker:
    dialect = wire.twin.dialect
    size = max(int(DIALECTS[dialect].baud / 10 * EVERY_S), 1)
    return Talker(lambda count: noise(dialect, size + count % 3), EVERY_S)


def _irrelevant(wire: Wire) -> Talker:
    return Talker(lambda _: IRRELEVANT[wire.twin.dialect], EVERY_S)


def _drip(wire: Wire) -> Talker:
    heard = noise(wire.twin.dialect, 997)
    if DIALECTS[wire.twin.dialect].can:
        frames = [pack(each) for each in Unpacker().feed(heard)]
        return Talker(lambda count: frames[count % len(frames)], DRIP_S)
    return Talker(lambda count: heard[count % 997 : count % 997 + 1], DRIP_S)


KINDS: dict[str, Callable[[Wire], Link]] = {
    "silent": lambda _: Talker(lambda _: b"", 1e9),
    "flooding with noise": _flood,
    "flooding with what answers nothing": _irrelevant,
    "dripping": _drip,
    "answering at the last moment": Dilatory,
}


class Pace(SimulatedPace):
    """Simulated time that shows the wire who is driven."""

    def __init__(self, wire: Wire) -> None:
        super().__init__()
        self.wire = wire

    def start(self, engine: Engine) -> None:
        self.wire.engine = engine
        super().start(engine)


def wire_to(dialect: str) -> tuple[Wire, Pace]:
    """Return a wire to a simulated arm of a dialect, and the time in which it is."""
    wire = Wire(simulate(simulated_config(dialect)))
    return wire, Pace(wire)


def connected(dialect: str, wire: Wire, pace: Pace) -> Arm:
    """Connect over a wire, as it is."""
    arm = Arm(
        assemble(simulated_config(dialect), wire, pace, simulated=True, operator=wire.twin.operator)
    )
    arm.twin = wire.twin
    return arm
