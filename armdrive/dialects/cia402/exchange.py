"""What scripts work with: the drives, their cycles by SYNC, the heartbeat."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable

from armdrive.dialects.bus.drives import ALL_SILENT, LAST_TRY_S, absence, shared_words
from armdrive.dialects.bus.homing import HomingTimes
from armdrive.dialects.cia402.drives import Cia402Drive, Trouble
from armdrive.dialects.cia402.settings import CYCLIC, Cia402Settings, DriveLimits
from armdrive.dialects.cia402.transfers import Jobs, ObjectTransfers, ReadObjects, Script
from armdrive.dialects.controller import HomingTime
from armdrive.dialects.exchange import TRIES, Obstructed, ScriptIO
from armdrive.tasks import (
    Alert,
    AlertKind,
    Progress,
    ProtocolWarning,
    Registers,
    RequestRejected,
    Timeout,
)
from firmware_protocol import canopen
from firmware_protocol.canopen import Controlword, HostEvent, OperationMode
from firmware_protocol.frames import pack
from kinematics.spaces import Motors

# The path stands still while a drive has missed this many SYNCs: it may not get its targets either.
LOST_CYCLES = 4
# After a late cycle the next one takes at least this share of a period, so that the drives can
# interpolate. The delay is caught up in four cycles.
MIN_CYCLE_SHARE = 0.75


class HeartbeatProducer:
    """Sends this program's heartbeat when it is due. Seconds.

    Drives watch it, and stop without it. The loop that steers them also sends it, so that a
    suspended or hanging program falls silent. Missed heartbeats are not sent later.
    """

    def __init__(self, node: int, period_s: float) -> None:
        self._frame = pack(canopen.Heartbeat(node, canopen.NodeState.OPERATIONAL).frame)
        self._period_s = period_s
        self.sent_s = self.due_s = math.inf

    def begin(self, now_s: float) -> None:
        """Send it from now on."""
        if math.isinf(self.due_s):
            self.sent_s = self.due_s = now_s

    def end(self) -> None:
        """Stop sending it."""
        self.sent_s = self.due_s = math.inf

    def beat(self, now_s: float) -> bytes:
        """Return a heartbeat if one is due."""
        if now_s < self.due_s:
            return b""
        self.sent_s, self.due_s = now_s, now_s + self._period_s
        return self._frame


class Cia402Exchange(ScriptIO[HostEvent]):
    """The drives of an arm and the wire to them.

    Every event is recorded here when it arrives; scripts read the drives' state instead of events.
    """

    look_at = ALL_SILENT

    def __init__(
        self,
        settings: Cia402Settings,
        limits: DriveLimits,
        names: Iterable[str],
        on_unsolicited: Callable[[HostEvent], None],
    ) -> None:
        super().__init__(on_unsolicited)
        self.settings, self.limits = settings, limits
        self.drives = tuple(
            Cia402Drive(node, name, motor, settings.position_window)
            for motor, (node, name) in enumerate(zip(settings.ids, names, strict=True))
        )
        assumed = HomingTime(settings.homing_s, "cia402.homing_s")
        self.homing = HomingTimes(self.drives, limits.ranges, assumed)
        self.by_node = {drive.node: drive for drive in self.drives}
        self.host = canopen.Host(settings.ids)
        self.transfers = ObjectTransfers(self, self.host, settings.answer_s)
        self.beats = HeartbeatProducer(settings.master_id, settings.heartbeat_period_ms / 1000.0)
        self.contacted = self.configured = False
        """Whether the drives are set up; whether they ever were."""
        self.on = False
        """Whether this program has switched the motors on."""
        self.watches = True
        """Whether all drives stop by themselves without this program's heartbeat."""
        self.is_cyclic = settings.strategy == CYCLIC
        """Whether the drives get cyclic targets."""
        self.rival_s = -math.inf
        """When another program sent a heartbeat with this program's number."""
        self.underruns = 0
        self.outages = 0
        """How often drives may have stopped by themselves in a motion."""
        self.began_s = 0.0
        """When the present request began."""
        self.synced_s = -math.inf
        """When the last SYNC was sent."""
        self._ends_s = self._checked_s = -math.inf

    @property
    def resting_mode(self) -> OperationMode:
        """The mode in which drives hold."""
        if self.is_cyclic:
            return OperationMode.CYCLIC_POSITION
        return OperationMode.PROFILE_POSITION

    # -- events -------------------------------------------------------------------------------

    def note(self, event: HostEvent) -> None:
        """Record what an event shows."""
        match event:
            case canopen.UnreadableFrame(frame, reason):
                self.warn(f"frame {frame}: {reason}")
            case canopen.Heartbeat(self.settings.master_id):
                self.rival_s = self.now_s
            case _ if (drive := self.by_node.get(event.node)) is not None:
                self._note_drive(drive, event)

    def _note_drive(self, drive: Cia402Drive, event: HostEvent) -> None:
        match event:
            case canopen.DriveReport():
                drive.note_report(event, self.synced_s, self.now_s)
            case canopen.SdoAnswered(_, canopen.UnreadableFrame(frame, reason)):
                self.warn(f"{drive} sent an invalid answer, {frame}: {reason}")
            case canopen.SdoAnswered(_, answer):
                self.transfers.note(drive, answer)
            case canopen.Emergency():
                self.warn(f"{drive} reports: {drive.note_error(event)}")
            case canopen.Heartbeat(_, state):
                drive.network = state
                if state is canopen.NodeState.BOOTING and self.configured:
                    drive.word, drive.booted, self.contacted = None, True, False
                elif drive.dropped_out:
                    self.contacted = False  # the next request starts it again

    def warn(self, words: str) -> None:
        """Report something that ends no motion."""
        self.notify(ProtocolWarning(words))

    def alarm(self, alert: Alert, drive: Cia402Drive) -> None:
        """Send an alert about a drive."""
        drive.alerted = True
        if not drive.operates:
            self.contacted = False  # the next request starts it again
        if alert.kind in (AlertKind.RESTARTED, AlertKind.SWITCHED_OFF):
            self.on = False
        self.notify(alert)

    def report_troubles(self) -> None:
        """Report what is wrong with each drive at rest, once."""
        contacted = self.contacted
        for drive in self.drives:
            trouble = drive.trouble(on=self.on, moving=False)
            known = self.configured and (contacted or trouble is not Trouble.ORDERED)
            if trouble is not None and known and not drive.alerted:
                self.alarm(trouble.alert(drive), drive)

    def registers(self) -> Registers:
        """Return the positions. Drives that another program has enabled are not told as held."""
        states = {None if drive.state is None else drive.holds for drive in self.drives}
        held = states.pop() if len(states) == 1 else None
        counts = Motors(drive.register for drive in self.drives)
        return Registers(counts, held=None if held and not self.on else held)

    # -- cycles -------------------------------------------------------------------------------

    def command(
        self, drive: Cia402Drive, word: Controlword, mode: OperationMode, target: int
    ) -> None:
        """Send a drive a command, which it obeys from the next SYNC on."""
        self.out += self.host.command(drive.node, word, mode, target)

    def send_nmt(self, command: canopen.NmtCommand, drives: Iterable[Cia402Drive]) -> None:
        """Send drives a network management order."""
        for drive in drives:
            self.out += pack(canopen.Nmt(command, drive.node).frame)

    def sync(self) -> None:
        """Make all drives act on their commands and report."""
        self.synced_s = self.now_s
        self.out += self.host.sync()
        for drive in self.drives:
            drive.missed += 1

    def cycle(self) -> Script[None]:
        """Make all drives act on their commands; wait for the end of the cycle, or for a stop."""
        cycle_s = self.limits.cycle_s
        self._ends_s = max(self._ends_s + cycle_s, self.now_s + MIN_CYCLE_SHARE * cycle_s)
        asked = self.stop_asked
        self.sync()
        while self.now_s < self._ends_s and self.stop_asked == asked:
            yield self._ends_s

    @property
    def is_late(self) -> bool:
        """Whether the next cycle begins more than a period late."""
        return self.now_s > self._ends_s + self.limits.cycle_s

    def progress(self) -> None:
        """Report the positions."""
        self.notify(Progress(self.registers()))

    # -- objects ------------------------------------------------------------------------------

    def obtain(self, jobs: Jobs, *, lenient: bool = False) -> Script[list[ReadObjects]]:
        """Transfer objects (`ObjectTransfers`). Raises `Obstructed` if a drive does not answer."""
        results = yield from self.transfers.transfer(jobs, lenient=lenient)
        mute = [result.drive for result in results if result.mute]
        if mute:
            raise Obstructed(self.absence(mute))
        return results

    def put(self, jobs: Jobs) -> Script[None]:
        """Like `obtain`. Raises `Obstructed` also if a drive refuses a job."""
        for result in (yield from self.obtain(jobs)):
            for words in result.refused.values():
                raise Obstructed(words)

    def explain(self, drive: Cia402Drive) -> Script[None]:
        """Ask a drive for its error, unless it has reported one."""
        if drive.error:
            return
        (result,) = yield from self.transfers.transfer({drive: (canopen.ERROR_CODE,)}, tries=1)
        if code := result.values.get(canopen.ERROR_CODE):
            drive.error = f"{canopen.error_words(code)} (error {code:04X})"

    # -- silence ------------------------------------------------------------------------------

    def look(self) -> Script[None]:
        """Read every position. Raises `Obstructed` if a drive does not report its own."""
        since_s, began_s = self.now_s, self.listened.s
        while left := [drive for drive in self.drives if drive.reported_s <= since_s]:
            if self.listened.s - began_s > TRIES * self.settings.answer_s + LAST_TRY_S:
                raise Obstructed(self.absence(left))
            yield from self.cycle()

    @property
    def may_have_stopped(self) -> bool:
        """Whether drives may have missed this program's heartbeat, and stopped by themselves.

        Such a drive would take its next target as an order to go on, and jump to where the others
        are by then.
        """
        heard_s = max(min(drive.reported_s for drive in self.drives), self._checked_s)
        silent_s = self.now_s - self.beats.sent_s
        return (
            silent_s > self.settings.heartbeat_wait_s
            or self.now_s - heard_s > self.settings.report_age_s
        )

    def check_states(self) -> Script[Timeout | RequestRejected | None]:
        """Find out whether the drives still obey, before any SYNC on which they may act.

        Their objects tell that; a command may wait in each drive for the next SYNC. Returns which
        drives do not answer, or have sent no report since the last check.
        """
        before_s = self._checked_s
        self.outages += 1
        self.underruns += 1
        both = (canopen.STATUSWORD, canopen.POSITION)
        results = yield from self.transfers.transfer(
            dict.fromkeys(self.drives, both), tries=2 * TRIES, over=lambda: self.stop_asked
        )
        mute = [
            result.drive
            for result in results
            if result.mute or result.drive.reported_s < before_s < self.synced_s
        ]
        self._checked_s = self.now_s
        return self.absence(mute) if mute else None

    def absence(self, missing: Collection[Cia402Drive]) -> Timeout | RequestRejected:
        """Return the reply that names missing drives; the next request makes contact again.

        A missing drive may have lost its power, or dropped its motor, which is reported. One that
        has left the bus's operation answers no SYNC, but it holds.
        """
        self.contacted = False
        reply = absence(tuple(missing), self.drives, "node number", self.silence(self.began_s))
        for drive in missing:
            drive.word = None
            if isinstance(reply, RequestRejected) and self.on and drive.operates:
                self.alarm(Alert(AlertKind.SWITCHED_OFF, reply.reason), drive)
        return reply

    @property
    def shared_words(self) -> str:
        """Which node numbers two drives share; empty if none."""
        remedy = "give each one of its own, by its switches or its maker's program"
        return shared_words(self.transfers.shared, "node number", remedy)
