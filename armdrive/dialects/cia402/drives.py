"""The state of CiA 402 drives as their events show it, and this program's heartbeat.

    HeartbeatProducer  sends this program's heartbeat, without which the drives stop
    Cia402Drive        the last report of one drive, and its shaft
    SdoInbox           the results of transfers, and which node numbers two drives share
    DriveGroup         all drives of an arm: records their events, and finds what is wrong

Commands and frames are encoded and decoded by `canopen.Host`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable
from dataclasses import dataclass, field

from armdrive.dialects.bus.drives import off_target_words, shared_words
from armdrive.dialects.bus.observer import ObservedDrive
from armdrive.dialects.cia402.settings import CYCLIC, Cia402Settings
from armdrive.dialects.exchange import ScriptIO
from armdrive.tasks import Alert, AlertKind, ProtocolWarning, Registers
from firmware_protocol import canopen
from firmware_protocol.canopen.sdo import Upload
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import pack
from kinematics.spaces import Motors
from kinematics.text import counted

# The greatest target that can be commanded, in increments.
TARGET_MAX = (1 << 31) - 1


class HeartbeatProducer:
    """Sends this program's heartbeat when it is due. Seconds.

    Drives watch it, and stop if it is missing. The loop that steers them also sends it, so that a
    suspended or hanging program falls silent. Missed heartbeats are not sent later.
    """

    def __init__(self, node: int, period_s: float) -> None:
        self.period_s = period_s
        self.due_s = math.inf
        self.sent_s = math.inf
        """When the last one was sent; infinity before the first."""
        self._data = pack(canopen.Heartbeat(node, canopen.NodeState.OPERATIONAL).frame)

    @property
    def on(self) -> bool:
        """Whether it is being sent."""
        return math.isfinite(self.due_s)

    def begin(self, now_s: float) -> None:
        """Send it from now on."""
        if not self.on:
            self.due_s = now_s

    def end(self) -> None:
        """Stop sending it."""
        self.due_s = self.sent_s = math.inf

    def beat(self, now_s: float) -> bytes:
        """Return a heartbeat if one is due."""
        if now_s < self.due_s - 1e-9:
            return b""
        self.due_s = max(self.due_s, now_s - self.period_s / 2.0) + self.period_s
        self.sent_s = now_s
        return self._data


# A drive this close to its target, in increments, has received that target: the reading counts for
# that many.
EXACT_REACH, EXACT = 1, 4
FAULTS = (canopen.DriveState.FAULT, canopen.DriveState.FAULT_REACTION)


@dataclass(slots=True, eq=False)
class Cia402Drive:
    """One drive: its last report, and its shaft as the observer judges it. Seconds."""

    motor: int
    """The index of its motor."""
    shaft: ObservedDrive
    word: canopen.Statusword | None = None
    state: canopen.DriveState | None = None
    """Its last state; None if that is unknown."""
    last_fall: canopen.DriveState | None = None
    """Its last state other than enabled, since a motion began."""
    mode: int = 0
    """The mode that it reports."""
    heard_s: float = -math.inf
    """When its last frame came, in listened time."""
    missed: int = 0
    """How many SYNCs were sent since its last report."""
    near: int = 0
    """How many readings in a row found it near its last target; one that is exact counts more."""
    off_s: float = math.inf
    """Since when its readings find it off its target; infinity while they find it near."""
    set_point: int = 0
    """The target of its last set-point, in profile position mode."""
    handshake: canopen.SetPointHost = field(default_factory=canopen.SetPointHost)
    """How far that set-point has been handed over."""
    speed_unit_hz: float = 0.0
    """Its unit of speed, in increments/s; 0 if neither it nor the arm file states it."""
    ramp_unit_hz_s: float = 0.0
    """Its unit of ramps, in increments/s²; 0 like the unit of speed."""
    reported_unit_hz: float = 0.0
    """The unit of speed that it reports (60A9)."""
    turn: float = 0.0
    """The increments of a turn of its motor; 0 if that is unknown."""
    network: canopen.NodeState | None = None
    """The state in its last heartbeat; None before the first one."""
    missed_heartbeat: bool = False
    """Whether it has missed a heartbeat, and may have left the bus's operation because of that."""
    booted: bool = False
    """Whether it has restarted since it was set up."""
    error: str = ""
    """The error that it reported last."""
    reported: bool = False
    """Whether an alert has reported what is wrong with it."""

    def __str__(self) -> str:
        return str(self.shaft)

    @property
    def node(self) -> int:
        """Its number."""
        return self.shaft.node

    def speed(self, rate_hz: float) -> int:
        """Return a speed in its own unit: at least 1."""
        return max(round(rate_hz / self.speed_unit_hz), 1)

    def ramp(self, slope_hz_s: float) -> int:
        """Return a ramp in its own unit: at least 1."""
        return max(round(slope_hz_s / self.ramp_unit_hz_s), 1)

    @property
    def has_just_reported(self) -> bool:
        """Whether it reported at the last SYNC, or the one before: the last may be on its way."""
        return self.missed <= 1

    @property
    def holds(self) -> bool:
        """Whether its motor has current, as far as is known."""
        return self.state is not None and self.state.holds

    def ask(self, now_s: float) -> None:
        """Record a SYNC, at which it reports."""
        self.missed += 1
        self.shaft.questions.asked(now_s)

    def show(self, word: canopen.Statusword | None) -> None:
        """Record its statusword; None if its state has become unknown."""
        self.word, self.state = word, None if word is None else word.state
        if self.state is not canopen.DriveState.ENABLED:
            self.last_fall = self.state
        if word is not None:
            self.handshake.receive(word)

    def note(self, report: canopen.DriveReport, now_s: float) -> None:
        """Record its report."""
        self.network = canopen.NodeState.OPERATIONAL  # no other state sends PDOs
        self.missed_heartbeat = False
        self.mode = report.mode
        self.show(report.word)
        self.locate(report.position, now_s)

    def note_object(self, object_: canopen.Uploaded, now_s: float) -> None:
        """Record an object that was read, if it shows the drive's state or position."""
        value = value_of(object_)
        if object_.place == canopen.STATUSWORD:
            self.show(canopen.Statusword(value & 0xFFFF))
        elif object_.place == canopen.POSITION:
            self.locate(value, now_s)

    def locate(self, count: int, now_s: float) -> None:
        """Record its position."""
        self.missed = 0
        self.shaft.read(count, now_s)
        if not self.shaft.is_near:
            self.near, self.off_s = 0, min(self.off_s, now_s)
            return
        exact = abs(count - self.shaft.goal) <= EXACT_REACH
        self.near, self.off_s = self.near + (EXACT if exact else 1), math.inf

    def order(self, goal: int, speed_hz: float, slope_hz_s: float, now_s: float) -> None:
        """Record an order."""
        if goal != self.shaft.goal:
            self.near = 0  # what it was near before says nothing of whether it got this target
        self.shaft.order(goal, speed_hz, slope_hz_s, now_s)

    def offer(self, set_point: int) -> None:
        """Begin to hand it a set-point, in profile position mode."""
        self.set_point, self.handshake = set_point, canopen.SetPointHost()
        if self.word is not None:  # saves a cycle if it is ready for a set-point already
            self.handshake.receive(self.word)

    def note_error(self, event: canopen.Emergency) -> str:
        """Record the error that it reports, or that it is over; return the report in words."""
        words = f"{event.words} (error {event.code:04X})"
        if not event.over:  # keep the cause even after the error is over
            self.error = words
        self.missed_heartbeat |= event.code == canopen.HEARTBEAT_MISSING
        return words

    def stands(self, since_s: float, for_s: float) -> bool:
        """Return whether it was seen not to turn for a time span after a moment."""
        return self.shaft.read_s - max(self.shaft.still_s, since_s) >= for_s - 1e-9

    def rest(self) -> None:
        """Record that it is held where it is."""
        self.shaft.rest_at(self.shaft.count, self.shaft.read_s)

    def watch(self) -> None:
        """Begin a motion: judge the drive by its reports from now on."""
        self.shaft.watch()
        self.near, self.off_s = 0, math.inf
        self.last_fall, self.error = None, ""

    def recover(self) -> None:
        """Forget what was wrong with it."""
        self.booted = self.reported = False
        self.error = ""

    # -- faults -------------------------------------------------------------------------------

    @property
    def obeys(self) -> bool:
        """Whether it has been enabled since the motion began, as far as it reported anything."""
        enabled = self.state is canopen.DriveState.ENABLED and self.last_fall is None
        return enabled and not self.booted and self.network is canopen.NodeState.OPERATIONAL

    @property
    def operates(self) -> bool:
        """Whether it exchanges PDOs, as far as its heartbeats show that."""
        return self.network in (None, canopen.NodeState.OPERATIONAL)

    @property
    def away_words(self) -> str:
        """Why it has left the bus's operation, as far as it reported that; else empty."""
        if self.booted:
            return f"{self} was reset, or lost its power for a moment"
        if self.operates or self.network is None or self.missed_heartbeat:
            return ""
        state = self.network.name.lower().replace("_", "-")
        return f"another program has ordered {self} to be {state}"

    @property
    def fault_words(self) -> str:
        """That it is in fault, and why."""
        return f"{self} is in fault and has switched its motor off{self.why}"

    @property
    def locked_words(self) -> str:
        """That it is in fault, why, and what ends that."""
        return f"{self.fault_words}; `reset()` clears that"

    @property
    def why(self) -> str:
        """The error that it reported, to be appended; empty if it reported none."""
        return f": {self.error}" if self.error else ""


def off_target_alert(drive: Cia402Drive) -> Alert:
    """Return that a drive is not at its target."""
    words = off_target_words(drive, drive.shaft.count, drive.shaft.goal, "increments")
    return Alert(AlertKind.OFF_PATH, words)


def value_of(object_: canopen.Uploaded) -> int:
    """Decode a whole number by the type of its object, or by its length if that does not fit."""
    entry = canopen.STANDARD.find(object_.place)
    kind = entry.type if entry is not None else canopen.DataType.U32
    try:
        return int(kind.unpack(object_.data, exact=object_.exact))
    except RemoteProtocolError:
        return int.from_bytes(object_.data, "little")


class SdoInbox:
    """The result of the transfer with each node, until it is fetched.

    Two drives share a node number if it answers with two serial numbers.
    """

    def __init__(self) -> None:
        self.answers: dict[int, canopen.SdoEvent] = {}
        self.shared: set[int] = set()
        """The node numbers that two drives answer to."""
        self._serials: dict[int, bytes] = {}

    def take(self, node: int, event: canopen.SdoEvent) -> None:
        """Take what a node has sent."""
        match event:
            case canopen.Uploaded() | canopen.Downloaded() | canopen.Aborted():
                self.answers[node] = event
                if isinstance(event, canopen.Uploaded) and event.place == canopen.SERIAL_NUMBER:
                    self._serials[node] = event.data
            case canopen.StrayResponse(Upload(canopen.SERIAL_NUMBER, content)):
                # a repeated frame is equal
                if self._serials.get(node, content.data) != content.data:
                    self.shared.add(node)

    @property
    def shared_words(self) -> str:
        """Which node numbers two drives share; empty if none."""
        remedy = "give each one of its own, by its switches or its maker's program"
        return shared_words(self.shared, "node number", remedy)


class DriveGroup:
    """The drives of one arm and their common state.

    Every event is recorded here, and scripts read this state instead of events.
    """

    def __init__(
        self, io: ScriptIO[canopen.HostEvent], settings: Cia402Settings, names: Iterable[str]
    ) -> None:
        self._io = io
        self._settings = settings
        bounds = settings.bounds
        self.drives = tuple(
            Cia402Drive(motor, ObservedDrive(node, name, bounds))
            for motor, (node, name) in enumerate(zip(settings.ids, names, strict=True))
        )
        self.by_node = {drive.node: drive for drive in self.drives}
        self.contacted = False
        self.configured = False
        """Whether the drives were set up before; a drive that lost its settings has restarted."""
        self.on = False
        """Whether every drive was switched on, and no report contradicts that."""
        self.watches = True
        """Whether every drive can stop by itself when this program's heartbeat is missing."""
        self.resting_mode = canopen.OperationMode.PROFILE_POSITION
        """The mode in which drives hold their motors at rest."""
        self.choose_mode((canopen.OperationMode.CYCLIC_POSITION,))
        self.inbox = SdoInbox()
        self.rival_s = -math.inf
        """When another program's heartbeat with this program's number came."""

    def choose_mode(self, modes: Collection[canopen.OperationMode]) -> None:
        """Choose cyclic targets if all drives have that mode and the arm file allows it.

        Else they get bursts, which end by themselves. So do drives that do not watch this
        program's heartbeat: when targets stop, some makers' drives go on (STOBER, ID 442454.02).
        """
        wanted = canopen.OperationMode.CYCLIC_POSITION
        cyclic = self.watches and self._settings.strategy == CYCLIC and wanted in modes
        self.resting_mode = wanted if cyclic else canopen.OperationMode.PROFILE_POSITION

    @property
    def is_cyclic(self) -> bool:
        """Whether they get cyclic targets."""
        return self.resting_mode is canopen.OperationMode.CYCLIC_POSITION

    # -- events -------------------------------------------------------------------------------

    def note(self, event: canopen.HostEvent) -> None:
        """Record what an event shows."""
        drive, now_s = self.by_node.get(getattr(event, "node", 0)), self._io.now_s
        if drive is not None:
            drive.heard_s = self._io.listened.s
        match event:
            case canopen.SdoAnswered(node, canopen.UnreadableFrame(frame, reason)):
                self._warn(f"node {node} sent an invalid answer, {frame}: {reason}")
            case canopen.SdoAnswered(node, answer):
                self.inbox.take(node, answer)
                if drive is not None and isinstance(answer, canopen.Uploaded):
                    drive.note_object(answer, now_s)
            case canopen.UnreadableFrame(frame, reason):
                self._warn(f"frame {frame}: {reason}")
            case canopen.Overrun(count):
                self._warn(f"lost {counted(count, 'frame')}, not read in time")
            case canopen.Heartbeat(node) if node == self._settings.master_id:
                self.rival_s = now_s
            case canopen.DriveReport() if drive is not None:
                drive.note(event, now_s)
            case canopen.Heartbeat(_, state) if drive is not None:
                self._note_state(drive, state)
            case canopen.Emergency() if drive is not None:
                self._warn(f"{drive} reports: {drive.note_error(event)}")

    def _note_state(self, drive: Cia402Drive, state: canopen.NodeState) -> None:
        """Record the state in a drive's heartbeat; after a restart it needs contact again."""
        drive.network = state
        if state is canopen.NodeState.BOOTING and self.configured:
            drive.show(None)
            drive.booted, self.contacted = True, False
        elif drive.missed_heartbeat and not drive.operates:
            self.contacted = False  # the next request sets it up again

    def _warn(self, words: str) -> None:
        self._io.notify(ProtocolWarning(words))

    def have_reported(self, since_s: float) -> bool:
        """Return whether every drive has reported its position since a moment."""
        return all(drive.shaft.read_s >= since_s for drive in self.drives)

    @property
    def dropped_out(self) -> tuple[Cia402Drive, ...]:
        """The drives that have left the bus's operation because they missed a heartbeat."""
        return tuple(
            drive for drive in self.drives if drive.missed_heartbeat and not drive.operates
        )

    # -- faults -------------------------------------------------------------------------------

    def report(self, drive: Cia402Drive) -> None:
        """Report what is wrong with a drive, once."""
        alert = self.trouble(drive)
        if alert is not None and not drive.reported:
            self.alarm(drive, alert)

    def alarm(self, drive: Cia402Drive | None, alert: Alert) -> None:
        """Send an alert about a drive, or about none in particular."""
        if drive is not None:
            drive.reported = True
        self._io.notify(alert)
        if alert.kind in (AlertKind.RESTARTED, AlertKind.SWITCHED_OFF):
            self.on = False

    def lose(self, drive: Cia402Drive) -> None:
        """Report, once, that a drive which held its motor does not answer, although others do.

        One that has left the bus's operation answers no SYNC, but it holds.
        """
        if self.on and drive.operates and not drive.reported:
            words = f"{drive} no longer answers: it has lost its power, or its cable"
            self.alarm(drive, Alert(AlertKind.SWITCHED_OFF, words))

    def trouble(self, drive: Cia402Drive, *, moving: bool = False) -> Alert | None:
        """Return what is wrong with a drive. At rest, a quick stop is nothing wrong.

        In motion, a drive that was not enabled for a single cycle has stopped by itself. A drive in
        fault whose motor was off in any case is only locked: nothing has happened to the arm.
        """
        if drive.booted:
            return Alert(AlertKind.RESTARTED, drive.away_words)
        if self.contacted and (words := drive.away_words):
            return Alert(AlertKind.ALARM, words)
        state = (drive.last_fall if moving else None) or drive.state
        if state in FAULTS:
            if self.on:
                return Alert(AlertKind.SWITCHED_OFF, drive.fault_words)
            return Alert(AlertKind.LOCKED, drive.locked_words)
        if not self.on or drive.word is None or state is canopen.DriveState.ENABLED:
            return None
        if state is not canopen.DriveState.QUICK_STOP:
            return Alert(AlertKind.SWITCHED_OFF, f"{drive} has switched its motor off")
        words = f"{drive} has stopped by itself, and holds{drive.why}"
        return Alert(AlertKind.ALARM, words) if moving else None

    # -- state --------------------------------------------------------------------------------

    @property
    def off_target(self) -> tuple[Cia402Drive, ...]:
        """The drives that are farther from their targets than they may rest."""
        return tuple(each for each in self.drives if not each.shaft.is_near)

    @property
    def targets(self) -> str:
        """The targets of all drives, as text."""
        return f"607A to {' '.join(str(drive.shaft.goal) for drive in self.drives)}"

    def registers(self) -> Registers:
        """Return the last positions; a drive near its target is taken to be there.

        Drives that hold, but were not enabled by this program, are not reported as held.
        """
        counts = Motors(drive.shaft.register for drive in self.drives)
        states = {None if drive.state is None else drive.holds for drive in self.drives}
        held = states.pop() if len(states) == 1 else None
        return Registers(counts, held=None if held and not self.on else held)
