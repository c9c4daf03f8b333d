"""A CANopen bus of devices that have objects and move nothing, on simulated time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from armdrive.transports.can_health import BusHealth
from firmware_protocol.canopen import (
    STANDARD,
    Access,
    DataType,
    Dictionary,
    NodeState,
    ObjectEntry,
    ObjectStore,
    Place,
    SdoServer,
)
from firmware_protocol.frames import Frame, Unpacker, pack

ANSWER_S = 0.001
NAME = Place(0x1008)
OBJECTS = Dictionary(
    (*STANDARD, ObjectEntry(NAME, "Device name", DataType.VISIBLE_STRING, Access.CONST))
)


@dataclass
class Device:
    """One device: what its objects hold; it is `deaf` where it answers nothing."""

    number: int
    state: NodeState = NodeState.PRE_OPERATIONAL
    missing: frozenset[Place] = frozenset()
    store: ObjectStore = field(init=False)
    server: SdoServer = field(init=False)

    def __post_init__(self) -> None:
        kept = [entry for entry in OBJECTS if entry.place not in self.missing]
        self.store = ObjectStore(Dictionary(kept), self.number)
        self.server = SdoServer(self.number, self.store.read, self.store.write)

    def has(self, values: dict[Place, object]) -> Device:
        for place, value in values.items():
            self.store.set(place, value)
        return self

    def hear(self, frame: Frame) -> list[Frame]:
        if self.state is NodeState.STOPPED:
            return []
        answer = self.server.receive_frame(frame)
        return [] if answer is None else [answer]


class NodesBus:
    """A link to such devices; `said` are the frames that were put on the bus."""

    description = "a bus of CANopen devices"
    health = BusHealth()

    def __init__(self, *devices: Device, lose: Callable[[Frame], bool] = lambda _: False) -> None:
        self.devices = devices
        self.said: list[Frame] = []
        self.lose = lose
        self._coming: list[tuple[float, bytes]] = []
        self._unpacker = Unpacker()

    def write(self, data: bytes, now_s: float) -> None:
        for frame in self._unpacker.feed(data):
            self.said.append(frame)
            if self.lose(frame):
                continue
            answers = [answer for each in self.devices for answer in each.hear(frame)]
            self._coming += [(now_s + ANSWER_S, pack(answer)) for answer in answers]

    def read(self, now_s: float) -> bytes:
        come = b"".join(data for at_s, data in self._coming if at_s <= now_s)
        self._coming = [each for each in self._coming if each[0] > now_s]
        return come

    def next_s(self) -> float:
        return min((at_s for at_s, _ in self._coming), default=math.inf)

    def wait(self, timeout_s: float) -> None:
        raise NotImplementedError("time is simulated")

    def close(self) -> None:
        """Nothing is open."""
