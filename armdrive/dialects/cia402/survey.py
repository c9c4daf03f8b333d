"""Survey a CANopen bus: read objects by SDO.

Nothing is written and no node gets an order (NMT). Failed transfers are abandoned without an abort
frame: that begins with 80, which an MKS drive could take for the order to calibrate. The frames
sent here begin with 40, 60 or 70, which neither move nor set such a drive.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median
from types import MappingProxyType
from typing import Any

from armdrive.dialects import DeviceTools
from armdrive.dialects.bus.drives import ANSWER_S, LAST_REPLY_S
from armdrive.dialects.bus.tools import (
    Answers,
    BusTools,
    SeenNodes,
    Survey,
)
from armdrive.dialects.cia402.contact import WATCH_OBJECTS
from armdrive.dialects.cia402.drives import FAULTS, Cia402Drive
from armdrive.dialects.cia402.objects import (
    DRIVES,
    device_words,
    mode_words,
    modes_words,
    object_words,
    register_words,
    state_words,
)
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.dialects.cia402.transfers import ObjectTransfers, ReadObjects, Script, wait
from armdrive.dialects.cia402.words import OF_MASTER, TALK, CanopenFrameDescriber
from armdrive.dialects.exchange import ScriptIO, ScriptLoop
from armdrive.dialog import Finding, note, ok, problem
from armdrive.errors.printable import command_line
from armdrive.tasks import MeasuredUnits
from armdrive.transports.can_health import BusHealth
from firmware_protocol.canopen.drives import (
    OperationMode,
    Statusword,
    supported_modes,
)
from firmware_protocol.canopen.host import Host, HostEvent, SdoAnswered
from firmware_protocol.canopen.objects import (
    DEVICE_NAME,
    DEVICE_TYPE,
    ERROR_CODE,
    ERROR_REGISTER,
    MODE_SHOWN,
    POSITION,
    PRODUCT,
    REVISION,
    SERIAL_NUMBER,
    SPEED_UNIT,
    STATUSWORD,
    SUPPORTED_MODES,
    VENDOR,
    Place,
)
from firmware_protocol.canopen.sdo import abort_words
from firmware_protocol.canopen.services import (
    HEARTBEAT_MISSING,
    NODE_MAX,
    Heartbeat,
    NodeState,
    Service,
    error_words,
    service_of,
)
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.events import UnreadableFrame
from firmware_protocol.frames import Frame

# How many nodes are asked at once for what they are: other programs on the bus go on.
TOGETHER = 8
# How often a node is asked for that: one lost frame must not hide a drive.
ROUNDS = 2

# The objects that are read of each node.
QUESTIONS = (
    DEVICE_TYPE, DEVICE_NAME, VENDOR, PRODUCT, REVISION, SERIAL_NUMBER,
    SUPPORTED_MODES, STATUSWORD, MODE_SHOWN, POSITION, ERROR_REGISTER, ERROR_CODE,
    *WATCH_OBJECTS, SPEED_UNIT,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class CanopenNode:
    """A node's objects, and the reasons why it refused others.

    `state` is from its heartbeat. A node that `answers` nothing has only sent heartbeats.
    """

    number: int
    state: NodeState | None = None
    answers: bool = True
    values: Mapping[Place, int] = field(default_factory=dict)
    name: str = ""
    """The maker's name for it; empty if it reports none."""
    refused: Mapping[Place, str] = field(default_factory=dict)
    doubled: bool = False
    missed: int = 0

    @property
    def profile(self) -> int | None:
        """The number of its device profile, 402 for a drive; None if it reports none."""
        word = self.values.get(DEVICE_TYPE)
        return None if word is None else word & 0xFFFF


def is_command(frame: Frame, master: int | None = None) -> bool:
    """Return whether a master sent a frame: an order, SYNC, target, question or heartbeat."""
    known = None if frame.extended or frame.remote else service_of(frame.can_id)
    if known is None:
        return False
    service, node = known
    return service in OF_MASTER or (service is Service.HEARTBEAT and node == master)


def seen_nodes(frames: Iterable[Frame]) -> dict[int, NodeState]:
    """Return the nodes that sent a heartbeat, and its state."""
    found: dict[int, NodeState] = {}
    for frame in frames:
        try:
            heartbeat = Heartbeat.read(frame)
        except RemoteProtocolError:
            continue
        found[heartbeat.node] = heartbeat.state
    return found


class SurveyIO(ScriptIO[HostEvent]):
    """The objects of all nodes of a bus, and the wire to them. It is the codec of its script too.

    Whatever comes together is recorded before the script continues, which a last event wakes.
    """

    def __init__(self) -> None:
        super().__init__(lambda _event: None)
        self.host = Host(range(1, NODE_MAX + 1))
        self.transfers = ObjectTransfers(self, self.host, ANSWER_S, aborts=False)
        self.nodes = {node: Cia402Drive(node, "", 0, 0) for node in range(1, NODE_MAX + 1)}
        self.garbled = 0
        self._latest: HostEvent | None = None

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus."""
        self.host.receive_data(data)
        while (event := self.host.next_event()) is not None:
            self._latest = event
            if isinstance(event, SdoAnswered):
                self.garbled += isinstance(event.event, UnreadableFrame)
                self.transfers.note(self.nodes[event.node], event.event)
        self.out += self.host.owed()

    def next_event(self) -> HostEvent | None:
        """Return the latest event once."""
        event, self._latest = self._latest, None
        return event


def survey_scripts() -> ScriptLoop[HostEvent]:
    """Return a loop for a survey on the wire."""
    io = SurveyIO()
    return ScriptLoop(io, io)


def ask_nodes(
    io: SurveyIO, ids: Sequence[int], beating: Mapping[int, NodeState] = MappingProxyType({})
) -> Script[Survey[CanopenNode]]:
    """Ask each number for its device type; then read the objects of those found.

    `beating` are nodes that have sent heartbeats; they are asked too.
    """
    asked = sorted({each for each in ids if each <= NODE_MAX} | set(beating))
    answering: set[int] = set()
    for first in range(0, len(asked), TOGETHER):
        kinds = {io.nodes[node]: (DEVICE_TYPE,) for node in asked[first : first + TOGETHER]}
        found = yield from io.transfers.transfer(kinds, tries=ROUNDS)
        answering |= {result.drive.node for result in found if not result.mute}
    results = {}
    for node in sorted(answering):
        jobs = {io.nodes[node]: QUESTIONS}
        (results[node],) = yield from io.transfers.transfer(jobs, lenient=True)
    yield from wait(io, LAST_REPLY_S)
    nodes = [
        _node(io, node, beating.get(node), results.get(node))
        for node in asked
        if node in answering or node in beating
    ]
    return Survey(tuple(asked), tuple(nodes), io.garbled)


def _node(
    io: SurveyIO, number: int, state: NodeState | None, found: ReadObjects | None
) -> CanopenNode:
    if found is None:
        return CanopenNode(number, state, answers=False)
    drive = io.nodes[number]
    return CanopenNode(
        number,
        state,
        True,
        found.values,
        found.texts.get(DEVICE_NAME, ""),
        {place: abort_words(code) for place, code in found.codes.items()},
        number in io.transfers.shared,
        max(drive.repeats - drive.strays, 0),  # a late answer is not missed
    )


# The result of a survey, as findings: the nodes that answer, their states, their faults.


def of_answers(found: Survey[CanopenNode], health: BusHealth, arm: str = "NAME") -> list[Finding]:
    """Report the nodes that answered, and each one's data."""
    words = ", ".join(map(str, there(found)))
    findings = found.answering("nodes", words and f"{words} (CANopen)", health)
    for each in found.nodes:
        findings += of_node(each, arm)
    return findings


def there(found: Survey[CanopenNode]) -> tuple[int, ...]:
    """Return the nodes that answer."""
    return tuple(each.number for each in found.nodes if each.answers)


def of_node(node: CanopenNode, arm: str = "NAME") -> list[Finding]:
    """Report one node's data, and what is wrong with it."""
    name = f"node {node.number}"
    if not node.answers:
        return [_mute(name, node)]
    found = [ok(f"{name}: {', '.join(_self_words(node))}")]
    if node.doubled:
        found.append(
            problem(
                f"{name}: two devices have this number",
                "plug in one at a time, and give each a number of its own by its maker's program "
                "or its switches",
            )
        )
    if node.profile != DRIVES:
        words = f"{name}: not a CiA 402 drive ({_type_words(node)}), so not a motor of an arm"
        return [*found, note(words, "")]
    found.append(ok(f"{name}: {', '.join(_drive_words(node))}"))
    more = (_fault(name, node, arm), _modes(name, node), _unit(name, node, arm))
    return found + [each for each in more if each]


def of_arm(ids: Sequence[int], found: Survey[CanopenNode]) -> list[Finding]:
    """Report which nodes of an arm file are no drives."""
    return [
        problem(
            f"node {each.number} of the arm file is not a CiA 402 drive ({_type_words(each)})",
            "cia402.ids in the arm file must list the drives' numbers, in the order of the motors",
        )
        for each in found.nodes
        if each.answers and each.number in ids and each.profile != DRIVES
    ]


def view(node: CanopenNode) -> dict[str, object]:
    """Return a node as plain data."""
    word = node.values.get(STATUSWORD)
    state = None if word is None else Statusword(word).state
    return {
        "id": node.number,
        "protocol": "canopen",
        "answers": node.answers,
        "profile": node.profile,
        "device": _type_words(node) if node.answers else "",
        "name": node.name,
        "identity": [node.values.get(each) for each in (VENDOR, PRODUCT, REVISION, SERIAL_NUMBER)],
        "nmt": None if node.state is None else node.state.name.lower(),
        "state": None if state is None else state.name.lower(),
        "mode": node.values.get(MODE_SHOWN),
        "counts": node.values.get(POSITION),
        "error": node.values.get(ERROR_CODE),
        "doubled": node.doubled,
        "refused": {str(place): why for place, why in node.refused.items()},
    }


def _mute(name: str, node: CanopenNode) -> Finding:
    if node.state is NodeState.STOPPED:
        return problem(
            f"{name}: stopped (NMT), so it does not answer",
            "connecting to its arm starts it again",
        )
    return problem(
        f"{name}: sends heartbeats, but does not answer (SDO)",
        "check that no other program is asking it, and that no other node has its number",
    )


def _self_words(node: CanopenNode) -> list[str]:
    words = [_type_words(node)]
    if node.name:
        words.append(f"called {node.name}")
    identity = [("vendor", VENDOR), ("product", PRODUCT), ("revision", REVISION)]
    for word, place in identity:
        if (number := node.values.get(place)) is not None:
            words.append(f"{word} {number:08X}")
    if serial := node.values.get(SERIAL_NUMBER):
        words.append(f"serial number {serial}")
    if node.state is not None:
        words.append(node.state.name.lower().replace("_", "-"))
    return words


def _type_words(node: CanopenNode) -> str:
    word = node.values.get(DEVICE_TYPE)
    return "it does not report its type" if word is None else device_words(word)


def _drive_words(node: CanopenNode) -> list[str]:
    rows: tuple[tuple[Place, Callable[[int], str]], ...] = (
        (STATUSWORD, state_words),
        (MODE_SHOWN, lambda value: f"mode {mode_words(value)}"),
        (POSITION, lambda value: f"at {value}"),
        (SUPPORTED_MODES, lambda value: f"can do {modes_words(value)}"),
    )
    parts = []
    for place, words in rows:
        value = node.values.get(place)
        parts.append(f"{object_words(place)} is not reported" if value is None else words(value))
    return parts


def _fault(name: str, node: CanopenNode, arm: str) -> Finding | None:
    word, register = node.values.get(STATUSWORD), node.values.get(ERROR_REGISTER) or 0
    code = node.values.get(ERROR_CODE) or 0
    broken = word is not None and Statusword(word).state in FAULTS
    if not broken and not register:
        return None
    why = f"error {code:04X}, {error_words(code)}" if code else "an error without a code"
    kinds = f" ({register_words(register)})" if register else ""
    fix = "find out what caused it, then call `reset()`; that moves nothing"
    if broken:
        return problem(f"{name}: fault: {why}{kinds}", fix)
    if code == HEARTBEAT_MISSING:
        enable = command_line("enable", "--arm", arm)
        fix = f"the program that drove it has ended: `{enable}` continues"
    return note(f"{name}: it still reports {why}{kinds}", fix)


def _unit(name: str, node: CanopenNode, arm: str) -> Finding | None:
    if SPEED_UNIT not in node.refused:
        return None
    measure = command_line("can", "setup", arm)
    words = f"{name}: it does not report its unit of speed (60A9), which an arm needs to move"
    return note(words, f"`{measure}` measures it, unless the arm file states it")


def _modes(name: str, node: CanopenNode) -> Finding | None:
    word = node.values.get(SUPPORTED_MODES)
    if word is None:
        return note(f"{name}: it does not report which modes it has (6502)", "")
    modes = supported_modes(word)
    if OperationMode.PROFILE_POSITION not in modes:
        return problem(f"{name}: it has no profile position mode, which armdrive needs", "")
    if lacking := [place for place in WATCH_OBJECTS if place in node.refused]:
        words = f"{name}: without object {lacking[0]} it does not stop if this program dies, so its"
        return note(f"{words} arm moves in bursts, which end by themselves", "")
    if OperationMode.CYCLIC_POSITION not in modes:
        words = f"{name}: without cyclic position mode its arm moves in bursts (profile position)"
        return note(words, "")
    return None


def survey_nodes(io: SurveyIO, ids: Sequence[int], heard: SeenNodes) -> Script[Answers]:
    """Survey the numbers; return the nodes in words and as plain data."""
    found = yield from ask_nodes(io, ids, heard)
    return Answers(
        "canopen",
        found.asked,
        there(found),
        tuple(each.number for each in found.nodes if each.profile == DRIVES),
        tuple(map(view, found.nodes)),
        lambda health, arm: of_answers(found, health, arm),
        lambda ids: of_arm(ids, found),
    )


# The measured units of drives of one kind differ by at most this share (Lely's stack: 6 %).
ALIKE = 0.1


def measured_units(device: Cia402Settings, found: Sequence[MeasuredUnits]) -> dict[str, Any]:
    """Return the keys of [cia402] for measured units; none if every drive reports its own."""
    speeds = _alike([0.0 if each.reported else each.speed_hz for each in found])
    ramps = _alike([0.0 if each.reported else each.ramp_hz_s for each in found])
    if not any(speeds) and not device.speed_units and not device.ramp_units:
        return {}
    return {"speed_units": speeds, "ramp_units": ramps}


def _alike(units: list[float]) -> list[float]:
    """Return the units, or their median for all if they differ by what measuring leaves open."""
    middle = median(units)
    return (
        [middle] * len(units)
        if all(abs(each - middle) <= ALIKE * middle for each in units)
        else units
    )


# CANopen on a bus. Reading objects by SDO does nothing to MKS drives with any ids.
BUS = BusTools(
    name="canopen",
    dialect="cia402",
    most=NODE_MAX,
    scripts=lambda _ids: survey_scripts(),
    ask=survey_nodes,
    reads_command=is_command,
    heard=seen_nodes,
    harmless=True,
    leaves_free=NODE_MAX,
    next=("config", "new", "NAME", "--template", "minimover5-cia402"),
    units=measured_units,
)

TOOLS = DeviceTools(TALK, bus=BUS, describer=CanopenFrameDescriber)
