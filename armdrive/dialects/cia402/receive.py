"""What CiA 402 drives say, asked or not: what of it is noted of each, what is odd, what alarms."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Mapping

from armdrive.abilities import Abilities
from armdrive.dialects.bus.motors import ALL_SILENT
from armdrive.dialects.cia402.drive import Cia402Drive
from armdrive.dialects.cia402.master import (
    Cia402Bus,
    ForeignFrame,
    Heard,
    HeartbeatProducer,
    NodeMessage,
    SdoAnswered,
)
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.dialects.exchange import Scripted
from armdrive.tasks import Alert, AlertKind, ProtocolWarning, Registers, never
from firmware_protocol.canopen import (
    Aborted,
    Downloaded,
    DriveState,
    Emergency,
    GarbledResponse,
    Heartbeat,
    NodeState,
    Place,
    SdoEvent,
    StrayResponse,
    Uploaded,
)
from firmware_protocol.canopen.sdo_messages import Upload
from kinematics.spaces import Motors

SERIAL_NUMBER = Place(0x1018, 4)
FAULTS = (DriveState.FAULT, DriveState.FAULT_REACTION)
Waiting = Generator[float, Heard | None, None]


class Cia402Receiving(Scripted[Heard]):
    """Knows what each drive said last; its scripts look at that instead of at messages."""

    look_at = ALL_SILENT
    contacted = False
    configured = False
    """Whether the drives have been set up before; one that forgot that has begun anew."""
    on = False
    """Whether every drive was switched on, and nothing speaks against its being so still."""

    def __init__(
        self, abilities: Abilities, settings: Cia402Settings, names: Iterable[str]
    ) -> None:
        self.bus = Cia402Bus(settings.ids)
        super().__init__(abilities, self.bus)
        self.settings = settings
        self.beats = HeartbeatProducer(settings.master_id, settings.beat_ms / 1000.0)
        tremble = settings.rest_window // 4 + 1
        self.drives = tuple(
            Cia402Drive(node, name, tremble) for node, name in zip(settings.ids, names, strict=True)
        )
        self._by_node: Mapping[int, Cia402Drive] = {drive.node: drive for drive in self.drives}
        self.answers: dict[int, SdoEvent] = {}
        """What has come of the transfer with each node, until it is fetched."""
        self.shared: set[int] = set()
        """The node numbers by which two drives have answered: two serial numbers."""
        self._serials: dict[int, bytes] = {}
        self.rival_s = -math.inf
        """When somebody else was heard to beat with this program's number."""

    # -- what scripts call --------------------------------------------------------------------

    def wait(self, until_s: float, over: Callable[[], bool] = never) -> Waiting:
        """Let time pass, stop or no stop, until a moment or until something is so."""
        while self.now_s < until_s and not over():
            yield until_s

    def registers(self) -> Registers:
        """Return where the drives were seen last; one within reach of its place is there.

        Drives that hold, but not for this program, are not told as held: it has to enable them.
        """
        counts = Motors(drive.count(self.settings.rest_window) for drive in self.drives)
        told = {None if drive.state is None else drive.holds for drive in self.drives}
        held = told.pop() if len(told) == 1 else None
        return Registers(counts, held=None if held and not self.on else held)

    # -- what the engine calls ----------------------------------------------------------------

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the bus."""
        self.now_s = now_s
        self.bus.receive_data(data)
        while (heard := self.bus.next_event()) is not None:
            self.heed(heard)
            if self.busy:
                self._step(heard)
            else:
                self.unasked(heard)
        self.say(self.bus.owed())

    def advance(self, now_s: float) -> bytes:
        """Do what is due by now; the heartbeat is, whatever else."""
        said = super().advance(now_s)
        return self.beats.say(now_s) + said

    def next_s(self) -> float:
        """Tell when the script wants to go on, or the heartbeat is due."""
        return min(super().next_s(), self.beats.due_s)

    def give_up(self) -> None:
        """Wait for no answer any more."""
        for drive in self.drives:
            self.bus.abandon(drive.node)
        self.answers.clear()
        self.bus.silence()

    # -- what is heard ------------------------------------------------------------------------

    def heed(self, heard: Heard) -> None:
        """Note what a message shows, whoever waits for it."""
        drive = self._by_node.get(getattr(heard, "node", 0))
        if drive is not None:
            drive.heard_s = self.now_s
        match heard:
            case NodeMessage() if drive is not None:
                drive.tell(heard, self.now_s)
            case SdoAnswered(node, Uploaded() | Downloaded() | Aborted() as event):
                self.answers[node] = event
                if isinstance(event, Uploaded) and event.place == SERIAL_NUMBER:
                    self._serials[node] = event.data
            case SdoAnswered(node, StrayResponse(Upload(place, content))) if place == SERIAL_NUMBER:
                if self._serials.get(node, content.data) != content.data:  # not what comes twice
                    self.shared.add(node)
            case SdoAnswered(node, GarbledResponse(frame, reason)):
                self.tell(
                    ProtocolWarning(f"node {node} answered {frame}, which is no answer: {reason}")
                )
            case Heartbeat(node) if node == self.settings.master_id:
                self.rival_s = self.now_s
            case Heartbeat(_, state) if drive is not None:
                self._beat(drive, state)
            case Emergency() if drive is not None:
                self._emergency(drive, heard)
            case ForeignFrame():
                self.tell(ProtocolWarning(str(heard)))

    def _beat(self, drive: Cia402Drive, state: NodeState) -> None:
        drive.network = state
        if state is NodeState.BOOTING and self.configured:
            drive.booted, drive.word = True, None
            self.contacted = False

    def _emergency(self, drive: Cia402Drive, told: Emergency) -> None:
        if not told.over:  # what was wrong explains what became of it also when it is over
            drive.error = f"{told.words} (error {told.code:04X})"
        self.tell(ProtocolWarning(f"{drive} reports: {told.words} (error {told.code:04X})"))
        if self.contacted and not self.busy:  # what has become of it?
            self.sync()

    def sync(self) -> None:
        """Have all drives do what they were told, and tell where they are."""
        self.say(self.bus.sync())
        for drive in self.drives:
            drive.missed += 1

    def unasked(self, heard: Heard) -> None:
        """Weigh what comes while no script is at work."""
        drive = self._by_node.get(getattr(heard, "node", 0))
        if drive is not None:
            self.report(drive)

    # -- what alarms --------------------------------------------------------------------------

    def report(self, drive: Cia402Drive) -> None:
        """Tell once what is wrong with a drive, if anything is."""
        alert = self.trouble(drive)
        if alert is not None and not drive.reported:
            drive.reported = True
            self.tell(alert)
            if alert.kind is not AlertKind.ALARM:
                self.on = False

    def trouble(self, drive: Cia402Drive, *, moving: bool = False) -> Alert | None:
        """Return what is wrong with a drive; one that holds in a quick stop is fine at rest."""
        if drive.booted:
            return Alert(AlertKind.RESTARTED, away_words(drive))
        if self.contacted and (words := away_words(drive)):
            return Alert(AlertKind.ALARM, words)
        if not self.on or drive.word is None or drive.state is DriveState.ENABLED:
            return None
        if drive.state in FAULTS:
            return Alert(AlertKind.SWITCHED_OFF, self.fault_words(drive))
        if drive.state is not DriveState.QUICK_STOP:
            return Alert(AlertKind.SWITCHED_OFF, f"{drive} has switched its motor off")
        if not moving:
            return None
        why = f": {drive.error}" if drive.error else ""
        return Alert(AlertKind.ALARM, f"{drive} has stopped by itself, and holds{why}")

    def fault_words(self, drive: Cia402Drive) -> str:
        """Say that a drive is in fault, and lets its motor go."""
        why = f": {drive.error}" if drive.error else ""
        return f"{drive} is in fault and has switched its motor off{why}"


def away_words(drive: Cia402Drive) -> str:
    """Say why a drive takes no part any more, as far as it has said so itself."""
    if drive.booted:
        return f"{drive} was reset, or lost its power for a moment"
    if drive.network is None or drive.network is NodeState.OPERATIONAL:
        return ""
    state = drive.network.name.lower().replace("_", "-")
    return f"{drive} was ordered to be {state} by somebody else"
