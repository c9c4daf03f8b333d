"""Exchanges with CiA 402 drives: SYNC cycles, position reads, state transitions, objects.

In a cycle each drive receives a state and a target. At the SYNC it acts on them and reports its
own. The effect of a command shows at the SYNC after the one on which the drive acted.

Deadlines of drives are in listened time (`dialects.exchange.ListenedTime`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import zip_longest
from types import MappingProxyType
from typing import TypeAlias, TypeVar

from armdrive.dialects.bus.drives import ALL_SILENT, absence
from armdrive.dialects.bus.questions import LAST_TRY_S, MUTE_POLLS
from armdrive.dialects.cia402.drives import (
    FAULTS,
    Cia402Drive,
    DriveGroup,
    HeartbeatProducer,
    value_of,
)
from armdrive.dialects.cia402.objects import object_words, value_words
from armdrive.dialects.cia402.settings import Cia402Settings, DriveLimits
from armdrive.dialects.exchange import TRIES, Obstructed, ScriptIO
from armdrive.tasks import Progress, RequestRejected, Timeout, never
from firmware_protocol import canopen
from firmware_protocol.canopen import (
    Command,
    Controlword,
    DriveState,
    HostEvent,
    OperationMode,
)
from firmware_protocol.fields import in_words
from firmware_protocol.frames import pack

# A drive that reports nothing in this many cycles is mute; a busy computer is late by fewer. In
# motion it is usually found earlier: by the question about its state after an outage.
MUTE_CYCLES = 20
# A drive at rest may miss this many of its own heartbeats before it is asked for a reply, up to
# `MUTE_POLLS` times.
BEATS_LOST = 3.5

ENABLE = Controlword.of(Command.ENABLE_OPERATION)
DISABLE = Controlword.of(Command.DISABLE_VOLTAGE)
STOP = Controlword.of(Command.QUICK_STOP)
# The stop of a drive that exchanges no PDOs.
STOP_WRITE = canopen.Write(canopen.CONTROLWORD, canopen.DataType.U16, STOP.value)
# The commands on the way to "operation enabled"; in any other state it is commanded itself.
TOWARDS_ENABLED: Mapping[DriveState | None, Controlword] = MappingProxyType(
    {
        DriveState.DISABLED: Controlword.of(Command.SHUT_DOWN),
        DriveState.READY: Controlword.of(Command.SWITCH_ON),
    }
)

# How long a drive may take to change its state or mode, or to accept a set-point. Simulated drives
# take two cycles; real ones were not measured.
RESPONSE_S = 1.0

T = TypeVar("T")
Script: TypeAlias = Generator[float, HostEvent | None, T]


class Cia402Exchange(ScriptIO[HostEvent]):
    """Sends commands to drives and waits for their reports. A cycle lasts `cycle_s`."""

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
        self.cycle_s = limits.cycle_s
        self.bus = canopen.Host(settings.ids)
        self.group = DriveGroup(self, settings, names)
        self.drives = self.group.drives
        """All drives, in motor order."""
        self.states, self.transfers = DriveStates(self), ObjectTransfers(self)
        self.beats = HeartbeatProducer(settings.master_id, settings.heartbeat_period_ms / 1000.0)
        self.began_s = -math.inf
        """When the present request began."""
        self.underruns = 0
        """How often a cycle was late, or a path ended although more was to come."""
        self._looked_s = -math.inf
        """When a silent drive at rest was asked last."""

    # -- cycles -------------------------------------------------------------------------------

    def wait(self, until_s: float, over: Callable[[], bool] = never) -> Script[None]:
        """Wait until a moment or a condition, regardless of stops."""
        while self.now_s < until_s and not over():
            yield until_s

    def command(
        self,
        drive: Cia402Drive,
        word: Controlword,
        mode: OperationMode,
        target: int | None = None,
    ) -> None:
        """Send a drive a controlword, a mode and a target, by default its last position."""
        target = drive.shaft.count if target is None else target
        self.write(self.bus.command(drive.node, word, mode, target))

    def send_point(self, drive: Cia402Drive) -> None:
        """Send a drive its set-point and the next word of its handshake."""
        word = drive.handshake.controlword
        self.command(drive, word, OperationMode.PROFILE_POSITION, drive.set_point)

    def send_nmt(self, command: canopen.NmtCommand, drives: Collection[Cia402Drive]) -> None:
        """Send drives a network management order."""
        for drive in drives:
            self.write(pack(canopen.Nmt(command, drive.node).frame))

    def sync(self) -> None:
        """Make all drives act on their commands and report their positions."""
        self.write(self.bus.sync())
        for drive in self.drives:
            drive.ask(self.now_s)

    def cycle(self) -> Script[None]:
        """Make the drives act on their commands, and wait for the end of the cycle."""
        self.sync()
        yield from self.wait(self.now_s + self.cycle_s)

    def progress(self) -> None:
        """Report the positions of the drives."""
        self.notify(Progress(self.group.registers()))

    def mute(self, drives: Collection[Cia402Drive]) -> tuple[Cia402Drive, ...]:
        """Return the drives that have reported nothing for too long."""
        return tuple(drive for drive in drives if drive.missed > MUTE_CYCLES)

    # -- positions ----------------------------------------------------------------------------

    def require_positions(self) -> Script[None]:
        """Read every position. Raises `Obstructed` if a drive does not report its own."""
        if missing := (yield from self.look()):
            raise Obstructed(self.absence(missing))

    def look(self) -> Script[tuple[Cia402Drive, ...]]:
        """Read every position; return the drives that do not report theirs."""
        for tried in range(1, TRIES + 1):
            asked_s = self.now_s
            self.sync()
            until_s = self.answered_s(last=tried == TRIES)
            yield from self.wait(until_s, partial(self.group.have_reported, asked_s))
            if self.group.have_reported(asked_s):
                return ()
        return tuple(drive for drive in self.drives if drive.shaft.read_s < asked_s)

    def answered_s(self, *, last: bool) -> float:
        """Return the deadline of the answer to a question that is sent now."""
        return self.now_s + self.settings.answer_s + (LAST_TRY_S if last else 0.0)

    # -- missing drives -----------------------------------------------------------------------

    def watch_heartbeats(self) -> None:
        """Watch the heartbeats of drives at rest.

        Since frames can be lost, a silent drive is asked by SYNC, as often as this program sends
        its heartbeat, before it counts as lost. If all are silent, the cause is the bus or this
        computer, which the next read of the positions finds out.
        """
        since_s = self.listened.s - BEATS_LOST * self.settings.drive_heartbeat_ms / 1000.0
        quiet = [drive for drive in self.drives if drive.heard_s < since_s]
        if not quiet or len(quiet) == len(self.drives):
            return
        for drive in quiet:
            if drive.missed > MUTE_POLLS:
                self.group.lose(drive)
        if self.now_s >= self._looked_s + self.beats.period_s:
            self._looked_s = self.now_s
            self.sync()

    def absence(self, drives: Collection[Cia402Drive]) -> Timeout | RequestRejected:
        """Return the reply that names missing drives; the next request makes contact again.

        A missing drive may have restarted unnoticed, and then has to be set up again. It may have
        dropped its motor, which is reported unless all are silent.
        """
        self.group.contacted = False
        if len(drives) < len(self.drives):
            for drive in drives:
                self.group.lose(drive)
        silence = self.silence(self.began_s)
        return absence(tuple(drives), self.drives, "node number", silence)


# Transitions between the states of drives: on, off, out of a fault, back from a quick stop.
#
# None of them moves a motor: a drive gets its own position as the target before its current.


@dataclass(slots=True, eq=False)
class DriveStates:
    """Brings drives from one state to another."""

    io: Cia402Exchange

    def _repeat(
        self,
        left: Callable[[], tuple[Cia402Drive, ...]],
        command: Callable[[Cia402Drive, int], None],
    ) -> Script[tuple[Cia402Drive, ...]]:
        """Repeat a command each cycle until no drive is left; return those that take too long."""
        listened = self.io.listened
        given_up_s, cycle = listened.s + RESPONSE_S, 0
        while (drives := left()) and listened.s < given_up_s:
            for drive in drives:
                command(drive, cycle)
            yield from self.io.cycle()
            cycle += 1
        return drives

    def bring(
        self, drives: Collection[Cia402Drive], goal: DriveState
    ) -> Script[tuple[Cia402Drive, ...]]:
        """Bring drives to a state; return those that do not reach it."""
        mode = self.io.group.resting_mode
        return self._repeat(
            lambda: tuple(each for each in drives if not self._is_there(each, goal)),
            lambda drive, _: self.io.command(drive, self._next_word(drive, goal), mode),
        )

    def _is_there(self, drive: Cia402Drive, goal: DriveState) -> bool:
        rests = not goal.holds or drive.mode == self.io.group.resting_mode
        return drive.state is goal and rests

    def _next_word(self, drive: Cia402Drive, goal: DriveState) -> Controlword:
        """Return the next command towards a state; a drive that holds gets its mode first."""
        if not goal.holds:
            return DISABLE
        if drive.state is DriveState.QUICK_STOP and drive.mode != self.io.group.resting_mode:
            return STOP
        return TOWARDS_ENABLED.get(drive.state, ENABLE)

    def reset_faults(self, drives: Collection[Cia402Drive]) -> Script[tuple[Cia402Drive, ...]]:
        """Reset faults with a rising edge; return the drives that stay in fault."""
        words, mode = (DISABLE, Controlword.of(Command.FAULT_RESET)), self.io.group.resting_mode
        return self._repeat(
            lambda: tuple(each for each in drives if each.state in FAULTS),
            lambda drive, cycle: self.io.command(drive, words[cycle % 2], mode),
        )

    def take_mode(self, drives: Collection[Cia402Drive], mode: OperationMode) -> Script[None]:
        """Switch enabled drives to a mode; each holds where it is."""
        left = yield from self._repeat(
            lambda: tuple(each for each in drives if each.mode != mode),
            lambda drive, _: self.io.command(drive, ENABLE, mode, drive.shaft.goal),
        )
        for drive in left:
            name = in_words(mode)
            raise Obstructed(
                f"{drive} does not take mode {int(mode)} ({name}), it reports {drive.mode}: "
                "another program may command it"
            )

    def leave_quick_stop(self, drives: Collection[Cia402Drive]) -> Script[None]:
        """Bring drives back that stand in a quick stop; they hold where they are."""
        stopped = [drive for drive in drives if drive.state is DriveState.QUICK_STOP]
        left = yield from self.bring(stopped, DriveState.ENABLED)
        yield from self.hold_here(stopped)
        for drive in stopped:
            drive.rest()
        for drive in left:
            if drive.state is DriveState.QUICK_STOP:
                raise Obstructed(
                    f"{drive} holds in its quick stop and no command brings it back: support the "
                    "arm, call `disable()`, then call `enable()`"
                )

    def hold_here(self, drives: Collection[Cia402Drive]) -> Script[None]:
        """Give enabled drives in profile position mode a set-point where they stand.

        Their own is where their brake ramp ended. A blocked shaft would jump there when it comes
        free. In cyclic mode the target has gone out with every command.
        """
        if self.io.group.is_cyclic:
            return
        # only a rising edge of bit 4 counts, so each handshake begins anew and runs to its end
        for drive in drives:
            drive.offer(drive.shaft.count)
        yield from self._repeat(
            lambda: tuple(each for each in drives if not each.handshake.taken),
            lambda drive, _: self.io.send_point(drive),
        )

    def offer(self, goals: Mapping[Cia402Drive, int]) -> Script[None]:
        """Begin to hand drives their set-points, and wait until each is ready for its own."""
        for drive, goal in goals.items():
            drive.offer(goal)
        asking = canopen.SetPointPhase.ASKING
        left = yield from self._repeat(
            lambda: tuple(each for each in goals if each.handshake.phase is not asking),
            lambda _drive, _cycle: None,
        )
        for drive in left:
            raise Obstructed(f"{drive} does not accept a set-point: call `reset()`")

    def mode_of(self, drive: Cia402Drive) -> OperationMode:
        """Return the drive's present mode, so that a stop changes nothing else."""
        mode = canopen.mode_of(drive.mode)
        return self.io.group.resting_mode if mode is None else mode


# Reading and writing objects: one object of every drive at once, then the next one.
#
# A request without an answer is sent again: frames can be lost, and repeating them does no harm. A
# late answer to an earlier try is as good as one to the last.

# What drives say of objects that they lack, or that are constants.
ABSENT = (
    canopen.AbortCode.NO_OBJECT,
    canopen.AbortCode.NO_SUB_INDEX,
    canopen.AbortCode.READ_ONLY,
    canopen.AbortCode.ACCESS,
)
# An object to read, or to write.
Job: TypeAlias = canopen.Place | canopen.Write
# The objects of each drive, by its node number.
Jobs: TypeAlias = Mapping[int, Sequence[Job]]


@dataclass(slots=True)
class SdoResult:
    """The result of the transfers with one drive.

    `values` were read; `refused` are refused objects, with the reason in words, and `lacking` those
    of them that it does not have or that are constants. A drive is `mute` if it did not answer.
    `over` is whether the rest of its transfers is skipped.
    """

    drive: Cia402Drive
    values: dict[canopen.Place, int] = field(default_factory=dict)
    refused: dict[canopen.Place, str] = field(default_factory=dict)
    lacking: set[canopen.Place] = field(default_factory=set)
    mute: bool = False
    over: bool = False

    def take(self, job: Job, answer: canopen.SdoEvent | None) -> None:
        """Record the answer to a job, None if none came."""
        match answer:
            case None:
                self.mute = self.over = True
            case canopen.Uploaded(place):
                self.values[place] = value_of(answer)
            case canopen.Aborted(place, code):
                what = object_words(place)
                if isinstance(job, canopen.Write):
                    what = f"{what} ({value_words(place, job.value)})"
                words = f"{what}: {canopen.abort_words(code)}"
                self.refused[place] = f"{self.drive} refused object {words}"
                if code in ABSENT:
                    self.lacking.add(place)


Results: TypeAlias = Mapping[int, SdoResult]


@dataclass(slots=True, eq=False)
class ObjectTransfers:
    """Transfers objects by SDO."""

    io: Cia402Exchange

    def of_each(self, *jobs: Job) -> Jobs:
        """Return the same jobs for every drive."""
        return dict.fromkeys(self.io.group.by_node, jobs)

    def transfer(
        self,
        jobs: Jobs,
        *,
        tries: int = TRIES,
        lenient: bool = False,
        given_up: Callable[[], bool] = never,
    ) -> Script[Results]:
        """Carry out the jobs of all drives side by side, until they are done or `given_up`.

        Jobs build on the writes before them, so the rest is skipped after a refused write, unless
        `lenient`.
        """
        results = {node: SdoResult(self.io.group.by_node[node]) for node in jobs}
        for row in zip_longest(*jobs.values()):
            asked = {
                node: job
                for node, job in zip(jobs, row, strict=True)
                if job is not None and not results[node].over
            }
            answers = yield from self._ask_all(asked, tries, given_up)
            if given_up():
                break
            # a constant cannot be written, but may have the wanted value already: read it
            refused = {
                node: job
                for node, job in asked.items()
                if isinstance(job, canopen.Write) and isinstance(answers[node], canopen.Aborted)
            }
            places = {node: write.place for node, write in refused.items()}
            present = yield from self._ask_all(places, tries, given_up)
            for node, job in asked.items():
                if node in refused and _suits(refused[node], present[node]):
                    continue
                results[node].take(job, answers[node])
                results[node].over |= node in refused and not lenient
        return results

    def _ask_all(
        self, jobs: Mapping[int, Job], tries: int, given_up: Callable[[], bool]
    ) -> Script[dict[int, canopen.SdoEvent | None]]:
        """Transfer one object of each drive; return the answers, None if there is none."""
        inbox = self.io.group.inbox.answers
        left = set(jobs)

        def is_over() -> bool:
            return given_up() or left <= inbox.keys()

        for node in jobs:  # what an earlier transfer was answered is no answer to this one
            self.io.write(self.io.bus.abandon(node))
            inbox.pop(node, None)
        for tried in range(1, tries + 1):
            for node in jobs:
                if node in left:
                    self.ask(node, jobs[node])
            until_s = self.io.answered_s(last=tried > 1 and tried == tries)
            yield from self.io.wait(until_s, is_over)
            left -= inbox.keys()
            if not left or given_up():
                break
        return {node: inbox.pop(node, None) for node in jobs}

    def ask(self, node: int, job: Job) -> None:
        """Send a drive a request, which replaces an unanswered one."""
        self.io.write(self.io.bus.abandon(node))
        if isinstance(job, canopen.Write):
            self.io.write(self.io.bus.download(node, job.place, job.data))
        else:
            self.io.write(self.io.bus.upload(node, job))

    def obtain(self, jobs: Jobs, *, lenient: bool = False) -> Script[Results]:
        """Transfer as above. Raises `Obstructed` if a drive does not answer."""
        results = yield from self.transfer(jobs, lenient=lenient)
        if mute := [result.drive for result in results.values() if result.mute]:
            raise Obstructed(self.io.absence(mute))
        return results

    def carry_out(
        self,
        jobs: Jobs,
        remedy: Callable[[canopen.Place], str] = lambda _: "",
        optional: Collection[canopen.Place] = (),
    ) -> Script[None]:
        """Transfer as above. Raises `Obstructed` also if a drive refuses an object.

        Drives may lack `optional` objects, or have constants instead.
        """
        for result in (yield from self.obtain(jobs, lenient=bool(optional))).values():
            for place, words in result.refused.items():
                if place not in result.lacking or place not in optional:
                    raise Obstructed(words + remedy(place))

    def verify(self, writes: Sequence[canopen.Write], why: str) -> Script[None]:
        """Read back the objects on which safety depends."""
        results = yield from self.obtain(self.of_each(*(write.place for write in writes)))
        for write in writes:
            for result in results.values():
                if result.values.get(write.place) != write.value:
                    raise Obstructed(
                        f"{result.drive} does not keep {write.value} in object {write.place}, "
                        f"{why} when this program dies"
                    )

    def explain(self, drive: Cia402Drive) -> Script[None]:
        """Ask a drive for its error unless it has reported one."""
        if drive.error:
            return
        results = yield from self.transfer({drive.node: (canopen.ERROR_CODE,)}, tries=2)
        if code := results[drive.node].values.get(canopen.ERROR_CODE, 0):
            drive.error = f"{canopen.error_words(code)} (error {code:04X})"

    def unanswered_writes(self, write: canopen.Write) -> bytes:
        """Return frames that write an object of every drive, without waiting for answers.

        Each is sent twice, because it may be lost.
        """
        frames = b""
        for drive in self.io.drives * 2:
            self.io.bus.abandon(drive.node)
            frames += self.io.bus.download(drive.node, write.place, write.data)
        return frames

    def give_up(self) -> None:
        """Give up all transfers."""
        for drive in self.io.drives:
            self.io.bus.abandon(drive.node)
        self.io.group.inbox.answers.clear()
        self.io.bus.silence()


def _suits(write: canopen.Write, present: canopen.SdoEvent | None) -> bool:
    """Return whether an object that cannot be written has a suitable value already.

    Drives have constants where CiA 301 and 402 allow writing: 1400:02 is 255 in Trinamic's
    TMCM-1276, 60C2:02 is -3 in Yiyou's EuServo (their EDS files).
    """
    equals = (write.value, *write.equals)
    return isinstance(present, canopen.Uploaded) and value_of(present) in equals
