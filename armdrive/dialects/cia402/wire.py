"""The wire to CiA 402 drives: frames out, what comes in as events, and what is known of each drive.

    Cia402Bus          commands to bytes, and bytes to events; Sans-IO
    HeartbeatProducer  when this program's heartbeat is due: drives stop when it is missing
    Cia402Drive        what one drive told last, and where it is held
    DriveGroup         all drives of an arm: notes what they tell, and says what is wrong with one

Of its PDOs a drive receives the first, with controlword, mode and target, and transmits the first,
with statusword, mode and position; both belong to the SYNC. Nothing that is on the bus raises.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from typing import TypeAlias

from armdrive.dialects.bus.observer import ObservedDrive
from armdrive.dialects.cia402.settings import CYCLIC, Cia402Settings
from armdrive.dialects.exchange import ScriptIO
from armdrive.tasks import Alert, AlertKind, ProtocolWarning, Registers
from firmware_protocol import canopen
from firmware_protocol.canopen.sdo import Upload
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, Unpacker, pack
from kinematics.spaces import Motors

RECEIVED = canopen.Mapping.of_objects(
    canopen.STANDARD, canopen.CONTROLWORD, canopen.MODE, canopen.TARGET_POSITION
)
TRANSMITTED = canopen.Mapping.of_objects(
    canopen.STANDARD, canopen.STATUSWORD, canopen.MODE_SHOWN, canopen.POSITION
)
TARGET_MAX = (1 << 31) - 1
"""How far from its zero a drive can be sent, in increments."""


@dataclass(frozen=True, slots=True)
class NodeMessage:
    """A drive has said what it is and where, as of a SYNC. Increments."""

    node: int
    word: canopen.Statusword
    mode: int
    position: int


@dataclass(frozen=True, slots=True)
class SdoAnswered:
    """Something has come of a transfer with a node."""

    node: int
    event: canopen.SdoEvent


@dataclass(frozen=True, slots=True)
class ForeignFrame:
    """A frame that no drive of this arm sends, or that says nothing known."""

    frame: Frame
    reason: str = ""

    def __str__(self) -> str:
        return f"frame {self.frame}{': ' if self.reason else ''}{self.reason}"


Heard: TypeAlias = NodeMessage | SdoAnswered | canopen.Emergency | canopen.Heartbeat | ForeignFrame


def setups(node: int) -> tuple[canopen.PdoSetup, canopen.PdoSetup]:
    """Return the PDOs of a drive as they are to be."""
    return (
        canopen.PdoSetup(canopen.Direction.RECEIVED, 1, node, RECEIVED),
        canopen.PdoSetup(canopen.Direction.TRANSMITTED, 1, node, TRANSMITTED),
    )


class Cia402Bus:
    """The machine that speaks to the drives. It has no clock."""

    def __init__(self, nodes: Iterable[int]) -> None:
        self._clients = {node: canopen.SdoClient(node) for node in nodes}
        self._unpacker = Unpacker()
        self._events: deque[Heard] = deque()
        self._owed = bytearray()

    # -- what is said -------------------------------------------------------------------------

    def command(
        self, node: int, word: canopen.Controlword, mode: canopen.OperationMode, target: int
    ) -> bytes:
        """Tell a drive what it shall be and where, from the next SYNC on."""
        data = RECEIVED.pack((word.value, int(mode), target))
        return pack(Frame(canopen.cob_id(canopen.Service.RPDO1, node), data))

    def sync(self) -> bytes:
        """Have every drive act on what it was told, and say where it is."""
        return pack(canopen.Sync().frame)

    def order(self, order: canopen.Nmt) -> bytes:
        """Order a node to be operational, say."""
        return pack(order.frame)

    def upload(self, node: int, place: canopen.Place) -> bytes:
        """Begin to read an object."""
        return pack(self._clients[node].upload(place))

    def download(self, node: int, place: canopen.Place, data: bytes) -> bytes:
        """Begin to write an object."""
        return pack(self._clients[node].download(place, data))

    def abandon(self, node: int) -> bytes:
        """Wait no longer for what comes of a transfer; the node is told.

        What has come of it already and was not fetched is dropped: it would be taken for the
        answer to whatever is asked next.
        """
        self._events = deque(each for each in self._events if not _answers(each, node))
        frame = self._clients[node].abandon(canopen.AbortCode.TIMED_OUT)
        return b"" if frame is None else pack(frame)

    def owed(self) -> bytes:
        """Return what the transfers under way have to say next."""
        data = bytes(self._owed)
        self._owed.clear()
        return data

    # -- what is heard ------------------------------------------------------------------------

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus, in any portions."""
        for frame in self._unpacker.feed(data):
            self._hear(frame)

    def silence(self) -> None:
        """Say that nothing has come for longer than a record pauses."""
        for frame in self._unpacker.silence():
            self._hear(frame)

    def next_event(self) -> Heard | None:
        """Return what was received so far, one event at a time, then None."""
        return self._events.popleft() if self._events else None

    def _hear(self, frame: Frame) -> None:
        found = None if frame.extended or frame.remote else canopen.service_of(frame.can_id)
        if found is None:
            self._events.append(ForeignFrame(frame))
            return
        service, node = found
        try:
            self._take(frame, service, node)
        except RemoteProtocolError as error:
            self._events.append(ForeignFrame(frame, str(error)))

    def _take(self, frame: Frame, service: canopen.Service, node: int) -> None:
        client = self._clients.get(node)
        if service is canopen.Service.HEARTBEAT:
            self._events.append(canopen.Heartbeat.read(frame))
        elif client is None:
            self._events.append(ForeignFrame(frame))
        elif service is canopen.Service.TPDO1:
            word, mode, position = TRANSMITTED.unpack(frame.data)
            told = NodeMessage(node, canopen.Statusword(int(word)), int(mode), int(position))
            self._events.append(told)
        elif service is canopen.Service.EMCY:
            self._events.append(canopen.Emergency.read(frame))
        elif service is canopen.Service.SDO_RESPONSE:
            self._answer(client, frame, node)
        else:
            self._events.append(ForeignFrame(frame))

    def _answer(self, client: canopen.SdoClient, frame: Frame, node: int) -> None:
        said = client.receive_frame(frame)
        if said is not None:
            self._owed += pack(said)
        while (event := client.next_event()) is not None:
            self._events.append(SdoAnswered(node, event))


def _answers(event: Heard, node: int) -> bool:
    return isinstance(event, SdoAnswered) and event.node == node


class HeartbeatProducer:
    """When this program's heartbeat is due. Seconds.

    Drives mind it, and stop when it is missing. It is sent by the loop that also steers, so that a
    program that was suspended, or hangs, falls silent; missed beats are not made up for.
    """

    def __init__(self, node: int, period_s: float) -> None:
        self.period_s = period_s
        self.due_s = math.inf
        self.said_s = math.inf
        """When it was sent last; infinity before the first."""
        self._data = pack(canopen.Heartbeat(node, canopen.NodeState.OPERATIONAL).frame)

    @property
    def on(self) -> bool:
        """Whether it is sent."""
        return math.isfinite(self.due_s)

    def begin(self, now_s: float) -> None:
        """Send it from now on."""
        if not self.on:
            self.due_s = now_s

    def end(self) -> None:
        """Send it no more."""
        self.due_s = self.said_s = math.inf

    def say(self, now_s: float) -> bytes:
        """Return a heartbeat if it is due."""
        if now_s < self.due_s - 1e-9:
            return b""
        self.due_s = max(self.due_s, now_s - self.period_s / 2.0) + self.period_s
        self.said_s = now_s
        return self._data


FAULTS = (canopen.DriveState.FAULT, canopen.DriveState.FAULT_REACTION)


@dataclass(slots=True, eq=False)
class Cia402Drive:
    """One drive: what it told last, and what its shaft does beside its orders. Seconds.

    While it stands its position may differ by `tremble` increments, as a closed loop's does.
    """

    shaft: ObservedDrive
    tremble: int
    word: canopen.Statusword | None = None
    state: canopen.DriveState | None = None
    """The state that it told last; None where that is not known."""
    fell: canopen.DriveState | None = None
    """The state that it told last while it was not enabled, since a motion began."""
    mode: int = 0
    """The mode that it shows."""
    heard_s: float = -math.inf
    """When anything was heard of it last, in listened time."""
    missed: int = 0
    """How many SYNCs were sent since it told something."""
    still_s: float = math.inf
    """Since when it has not turned."""
    still_at: int = 0
    network: canopen.NodeState | None = None
    """The state that its heartbeat told last; None before the first one."""
    booted: bool = False
    """Whether it has restarted since it was set up."""
    error: str = ""
    """The error that it reported last."""
    reported: bool = False
    """Whether an alert has told what is wrong with it."""

    def __str__(self) -> str:
        return str(self.shaft)

    @property
    def node(self) -> int:
        """Its number."""
        return self.shaft.node

    @property
    def seen(self) -> int:
        """Where it was read last."""
        return self.shaft.count or 0

    @property
    def holds(self) -> bool:
        """Whether its motor has current, as far as is known."""
        return self.state is not None and self.state.holds

    def ask(self, now_s: float) -> None:
        """Take note of a SYNC, at which it tells what it is."""
        self.missed += 1
        self.shaft.ledger.asked(now_s)

    def show(self, word: canopen.Statusword | None) -> None:
        """Take note of what it shows to be; None where nobody knows that any more."""
        self.word, self.state = word, None if word is None else word.state
        if self.state is not canopen.DriveState.ENABLED:
            self.fell = self.state

    def tell(self, told: NodeMessage, now_s: float) -> None:
        """Take note of what it tells of itself."""
        self.show(told.word)
        self.mode, self.missed = told.mode, 0
        self.shaft.read(told.position, now_s)
        self.network = canopen.NodeState.OPERATIONAL  # no other state sends PDOs
        if abs(told.position - self.still_at) > self.tremble or math.isinf(self.still_s):
            self.still_at, self.still_s = told.position, now_s

    def stands(self, since_s: float, for_s: float) -> bool:
        """Tell whether it was seen not to turn for so long, all of it after a moment."""
        return self.shaft.read_s - max(self.still_s, since_s) >= for_s - 1e-9

    def rest(self) -> None:
        """Take it for being held where it is."""
        self.shaft.rest_at(self.seen, self.shaft.read_s)

    def watch(self) -> None:
        """Judge it by what it tells from now on: a motion begins."""
        self.shaft.watch()
        self.fell, self.error = None, ""

    def recover(self) -> None:
        """Forget what was wrong with it."""
        self.booted = self.reported = False
        self.error = ""

    # -- what is wrong with it ----------------------------------------------------------------

    @property
    def away_words(self) -> str:
        """Why it takes no part any more, as far as it has said so itself; else empty."""
        if self.booted:
            return f"{self} was reset, or lost its power for a moment"
        if self.network is None or self.network is canopen.NodeState.OPERATIONAL:
            return ""
        state = self.network.name.lower().replace("_", "-")
        return f"{self} was ordered to be {state} by somebody else"

    @property
    def fault_words(self) -> str:
        """That it is in fault, and why."""
        return f"{self} is in fault and has switched its motor off{self._why}"

    @property
    def stopped_words(self) -> str:
        """That it has made a quick stop, and why."""
        return f"{self} has stopped by itself, and holds{self._why}"

    @property
    def _why(self) -> str:
        return f": {self.error}" if self.error else ""


def beside(drive: Cia402Drive) -> Alert:
    """Say that a drive is not where it was sent."""
    return Alert(
        AlertKind.ASTRAY,
        f"{drive} is at {drive.seen}, not at {drive.shaft.goal} increments: it is blocked, "
        "overloaded, or was turned by force",
    )


class DriveGroup:
    """The drives of one arm, and what is known of all of them together.

    Scripts look at this instead of at messages: every message is noted here, whoever waits for it.
    """

    def __init__(self, io: ScriptIO[Heard], settings: Cia402Settings, names: Iterable[str]) -> None:
        self._io = io
        self._settings = settings
        tremble, bounds = settings.rest_window // 4 + 1, settings.bounds
        self.drives = tuple(
            Cia402Drive(ObservedDrive(node, name, bounds), tremble)
            for node, name in zip(settings.ids, names, strict=True)
        )
        self.by_node = {drive.node: drive for drive in self.drives}
        self.contacted = False
        self.configured = False
        """Whether the drives have been set up before; one that forgot that has restarted."""
        self.on = False
        """Whether every drive was switched on, and nothing speaks against its being so still."""
        self.resting_mode = canopen.OperationMode.PROFILE_POSITION
        """The mode in which drives hold their motors when nothing moves."""
        self.choose((canopen.OperationMode.CYCLIC_POSITION,))
        self.answers: dict[int, canopen.SdoEvent] = {}
        """What has come of the transfer with each node, until it is fetched."""
        self.shared: set[int] = set()
        """The node numbers by which two drives have answered: two serial numbers."""
        self._serials: dict[int, bytes] = {}
        self.rival_s = -math.inf
        """When another program's heartbeat with this one's number was heard."""

    def choose(self, modes: Collection[canopen.OperationMode]) -> None:
        """Give targets cyclically where all drives have that mode and the arm file lets us.

        Else they are sent bursts.
        """
        wanted = canopen.OperationMode.CYCLIC_POSITION
        cyclic = self._settings.strategy == CYCLIC and wanted in modes
        self.resting_mode = wanted if cyclic else canopen.OperationMode.PROFILE_POSITION

    @property
    def is_cyclic(self) -> bool:
        """Whether they are given targets cyclically."""
        return self.resting_mode is canopen.OperationMode.CYCLIC_POSITION

    # -- what is heard ------------------------------------------------------------------------

    def heed(self, heard: Heard, listened_s: float) -> None:
        """Note what a message shows."""
        drive, now_s = self.by_node.get(getattr(heard, "node", 0)), self._io.now_s
        if drive is not None:
            drive.heard_s = listened_s
        match heard:
            case NodeMessage() if drive is not None:
                drive.tell(heard, now_s)
            case SdoAnswered(
                node, canopen.Uploaded() | canopen.Downloaded() | canopen.Aborted() as event
            ):
                self.answers[node] = event
                if isinstance(event, canopen.Uploaded) and event.place == canopen.SERIAL_NUMBER:
                    self._serials[node] = event.data
            case SdoAnswered(node, canopen.StrayResponse(Upload(place, content))) if (
                place == canopen.SERIAL_NUMBER
            ):
                if self._serials.get(node, content.data) != content.data:  # not what comes twice
                    self.shared.add(node)
            case SdoAnswered(node, canopen.GarbledResponse(frame, reason)):
                self._warn(f"node {node} answered {frame}, which is no answer: {reason}")
            case canopen.Heartbeat(node) if node == self._settings.master_id:
                self.rival_s = now_s
            case canopen.Heartbeat(_, state) if drive is not None:
                drive.network = state
                if state is canopen.NodeState.BOOTING and self.configured:
                    drive.show(None)
                    drive.booted, self.contacted = True, False
            case canopen.Emergency() if drive is not None:
                words = f"{heard.words} (error {heard.code:04X})"
                if not heard.over:  # its cause explains what follows, also when it is over
                    drive.error = words
                self._warn(f"{drive} reports: {words}")
            case ForeignFrame():
                self._warn(str(heard))

    def _warn(self, words: str) -> None:
        self._io.tell(ProtocolWarning(words))

    def have_told(self, since_s: float) -> bool:
        """Tell whether every drive has told where it is since a moment."""
        return all(drive.shaft.read_s >= since_s for drive in self.drives)

    def has_answer(self, nodes: Iterable[int]) -> bool:
        """Tell whether something has come of the transfer with one of some nodes."""
        return not self.answers.keys().isdisjoint(nodes)

    # -- what is wrong ------------------------------------------------------------------------

    def report(self, drive: Cia402Drive) -> None:
        """Tell once what is wrong with a drive, if anything is."""
        alert = self.trouble(drive)
        if alert is not None and not drive.reported:
            self.alarm(drive, alert)

    def alarm(self, drive: Cia402Drive | None, alert: Alert) -> None:
        """Tell an alert of a drive, or of none in particular."""
        if drive is not None:
            drive.reported = True
        self._io.tell(alert)
        if alert.kind in (AlertKind.RESTARTED, AlertKind.SWITCHED_OFF):
            self.on = False

    def trouble(self, drive: Cia402Drive, *, moving: bool = False) -> Alert | None:
        """Return what is wrong with a drive; one that holds in a quick stop is fine at rest.

        In motion, one that was not enabled for a single turn has stopped by itself.
        """
        if drive.booted:
            return Alert(AlertKind.RESTARTED, drive.away_words)
        if self.contacted and (words := drive.away_words):
            return Alert(AlertKind.ALARM, words)
        state = (drive.fell if moving else None) or drive.state
        if not self.on or drive.word is None or state is canopen.DriveState.ENABLED:
            return None
        if state in FAULTS:
            return Alert(AlertKind.SWITCHED_OFF, drive.fault_words)
        if state is not canopen.DriveState.QUICK_STOP:
            return Alert(AlertKind.SWITCHED_OFF, f"{drive} has switched its motor off")
        return Alert(AlertKind.ALARM, drive.stopped_words) if moving else None

    # -- how it is ----------------------------------------------------------------------------

    @property
    def astray(self) -> tuple[Cia402Drive, ...]:
        """The drives that were seen farther from their places than they may rest."""
        return tuple(each for each in self.drives if not each.shaft.is_near)

    @property
    def targets(self) -> str:
        """Where each drive is sent, for people."""
        return f"607A to {' '.join(str(drive.shaft.goal) for drive in self.drives)}"

    @property
    def shared_words(self) -> str:
        """Which node numbers two drives have; empty where none."""
        if not self.shared:
            return ""
        named = ", ".join(map(str, sorted(self.shared)))
        return (
            f"more than one drive answers to the node number {named}: give each one of its own, by "
            "its switches or its maker's program"
        )

    def registers(self) -> Registers:
        """Return where the drives were seen last; one within reach of its place is there.

        Drives that hold, but not for this program, are not told as held: it has to enable them.
        """
        counts = Motors(drive.shaft.register for drive in self.drives)
        told = {None if drive.state is None else drive.holds for drive in self.drives}
        held = told.pop() if len(told) == 1 else None
        return Registers(counts, held=None if held and not self.on else held)
