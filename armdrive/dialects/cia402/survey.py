"""Asks a CANopen bus politely who is on it: one node at a time, objects read by SDO and no more.

Nothing is written, nobody is ordered to become anything (NMT), and no transfer is given up aloud:
the frame that says so begins with 80, which an MKS drive could take for the order to calibrate.
What is sent begins with 40, 60 or 70, by which such a drive moves and sets nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TypeAlias, TypeVar

from armdrive.dialects.cia402.objects import NAME, entry_of
from armdrive.dialects.cia402.words import OF_MASTER
from firmware_protocol.canopen.cob import NODE_MAX, Service, cob_id, is_for, service_of
from firmware_protocol.canopen.datatypes import Value
from firmware_protocol.canopen.nmt import Heartbeat, NodeState
from firmware_protocol.canopen.sdo_client import Aborted, GarbledResponse, SdoClient, Uploaded
from firmware_protocol.canopen.sdo_messages import Place
from firmware_protocol.canopen.standard import (
    DEVICE_TYPE,
    ERROR_CODE,
    ERROR_REGISTER,
    MODE_SHOWN,
    POSITION,
    STATUSWORD,
    SUPPORTED_MODES,
)
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame

T = TypeVar("T")

ASK_S = 0.02
"""A node is there if it answers so soon; drives take some ms."""
ANSWER_S = 0.12
"""So long an answer of one that is there is waited for: a computer may be busy."""
LATE_S = 0.2
"""An answer that has not come by then never will."""
LINGER_S = 0.03
"""A second node of the same number answers within this time after the first."""
PAUSE_S = 0.005
ROUNDS, TRIES = 2, 3
LONGEST = 256
"""Bytes of an object that are read at most, a name being the longest."""

VENDOR, PRODUCT, REVISION, SERIAL = (Place(0x1018, sub) for sub in (1, 2, 3, 4))
QUESTIONS = (
    DEVICE_TYPE, NAME, VENDOR, PRODUCT, REVISION, SERIAL,
    SUPPORTED_MODES, STATUSWORD, MODE_SHOWN, POSITION, ERROR_REGISTER, ERROR_CODE,
)  # fmt: skip
"""What a node is asked that is there."""
_TELLTALES = (SERIAL, POSITION, STATUSWORD)
"""Objects that are hardly ever alike in two drives."""


@dataclass(frozen=True, slots=True)
class Put:
    """Send a frame, or none, and hear what comes: for a time, or a while after what is enough."""

    frame: Frame | None
    wait_s: float
    enough: Callable[[Frame], bool] = lambda _frame: False
    linger_s: float = 0.0


Talk: TypeAlias = Generator[Put, tuple[Frame, ...], T]


@dataclass(frozen=True, slots=True)
class Node:
    """What a node has told: objects that it has, and of others why it did not tell them.

    `state` is its own word, where it says heartbeats. One that `answers` nothing was only heard.
    """

    number: int
    state: NodeState | None = None
    answers: bool = True
    objects: Mapping[Place, Value] = field(default_factory=dict)
    refused: Mapping[Place, str] = field(default_factory=dict)
    doubled: bool = False
    missed: int = 0

    def number_of(self, place: Place) -> int | None:
        """Return a whole number that an object holds; None where it does not tell one."""
        value = self.objects.get(place)
        return value if isinstance(value, int) and not isinstance(value, bool) else None

    @property
    def name(self) -> str:
        """What its maker calls it; empty where it does not tell."""
        value = self.objects.get(NAME)
        return value if isinstance(value, str) else ""

    @property
    def profile(self) -> int | None:
        """The number of its device profile, 402 of a drive; None where it does not tell."""
        word = self.number_of(DEVICE_TYPE)
        return None if word is None else word & 0xFFFF


@dataclass(frozen=True, slots=True)
class CanopenSurvey:
    """Who was asked, who is there, and how many answers could not be read."""

    asked: tuple[int, ...] = ()
    nodes: tuple[Node, ...] = ()
    garbled: int = 0

    @property
    def there(self) -> tuple[int, ...]:
        """The nodes that answer."""
        return tuple(each.number for each in self.nodes if each.answers)


@dataclass(slots=True)
class _Counts:
    missed: int = 0
    garbled: int = 0


def is_command(frame: Frame, master: int | None = None) -> bool:
    """Tell whether a frame is a master's: an order, SYNC, process data, a question, its beat."""
    known = None if frame.extended or frame.remote else service_of(frame.can_id)
    if known is None:
        return False
    service, node = known
    return service in OF_MASTER or (service is Service.HEARTBEAT and node == master)


def heard_nodes(frames: Iterable[Frame]) -> dict[int, NodeState]:
    """Return who has said a heartbeat, and what it is."""
    found: dict[int, NodeState] = {}
    for frame in frames:
        try:
            heartbeat = Heartbeat.read(frame)
        except RemoteProtocolError:
            continue
        found[heartbeat.node] = heartbeat.state
    return found


def ask_nodes(
    ids: Sequence[int], heard: Mapping[int, NodeState] = MappingProxyType({})
) -> Talk[CanopenSurvey]:
    """Ask each number once or twice what it is, then those that are there for what they tell.

    `heard` are nodes whose heartbeats have passed; they are asked too.
    """
    counts = _Counts()
    asked = tuple(sorted({each for each in ids if each <= NODE_MAX} | set(heard)))
    there: set[int] = set()
    for _ in range(ROUNDS):
        for node in [each for each in asked if each not in there]:
            if (yield from _upload(node, DEVICE_TYPE, ASK_S, counts)) is not None:
                there.add(node)
            yield Put(None, PAUSE_S)
    nodes = []
    for node in asked:
        if node in there:
            nodes.append((yield from _known(node, heard.get(node), counts)))
        elif node in heard:
            nodes.append(Node(node, heard[node], answers=False))
    return CanopenSurvey(asked, tuple(nodes), counts.garbled)


def _known(node: int, state: NodeState | None, counts: _Counts) -> Talk[Node]:
    objects: dict[Place, Value] = {}
    refused: dict[Place, str] = {}
    before = counts.missed
    for place in QUESTIONS:
        told = yield from _asked(node, place, counts)
        if isinstance(told, Aborted):
            refused[place] = told.words
        elif told is not None and (value := _value(told)) is not None:
            objects[place] = value
        yield Put(None, PAUSE_S)
    doubled = yield from _doubled(node)
    return Node(node, state, True, objects, refused, doubled, counts.missed - before)


def _asked(node: int, place: Place, counts: _Counts) -> Talk[Uploaded | Aborted | None]:
    """Ask for an object, again where no answer comes; None where none ever does."""
    for _ in range(TRIES):
        told = yield from _upload(node, place, ANSWER_S, counts)
        if told is not None:
            return told
        counts.missed += 1
    return None


def _upload(
    node: int, place: Place, wait_s: float, counts: _Counts
) -> Talk[Uploaded | Aborted | None]:
    """Read an object once; None where that does not come to an end."""
    client = SdoClient(node, size_max=LONGEST)
    frame: Frame | None = client.upload(place)
    response_id = cob_id(Service.SDO_RESPONSE, node)
    while frame is not None:
        heard = yield Put(frame, wait_s, lambda each: is_for(each, response_id))
        frame = None
        for each in heard:
            frame = client.receive_frame(each) or frame
        while (event := client.next_event()) is not None:
            if isinstance(event, Uploaded | Aborted):
                return event  # what is to be said then is not: see the first lines of this file
            counts.garbled += isinstance(event, GarbledResponse)
    return None


def _doubled(node: int) -> Talk[bool]:
    """Tell whether two nodes were heard to answer to a number.

    Once is not enough: a frame that was sent twice looks like that too.
    """
    response_id = cob_id(Service.SDO_RESPONSE, node)
    for place in _TELLTALES:
        twice = 0
        for _ in range(TRIES):

            def answers(frame: Frame, place: Place = place) -> bool:
                return is_for(frame, response_id) and frame.data[1:4] == place.packed

            question = SdoClient(node).upload(place)
            heard = yield Put(question, ANSWER_S, answers, LINGER_S)
            count = sum(map(answers, heard))
            twice += count > 1
            if not count:
                yield Put(None, LATE_S)
            elif not twice:
                break  # one answer: the next object may tell them apart
        if twice > 1:
            return True
    return False


def _value(told: Uploaded) -> Value | None:
    entry = entry_of(told.place)
    if entry is None:
        return None
    try:
        return entry.type.unpack(told.data, exact=False)
    except RemoteProtocolError:  # of another type than the standard says
        return None
