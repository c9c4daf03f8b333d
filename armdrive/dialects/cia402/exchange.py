"""What is said to CiA 402 drives and waited for: turns by SYNC, looks, states, objects.

In a turn each drive is told what to be and where; at the SYNC it acts on that, and tells what it
is. It shows what became of an order at the SYNC behind the one that it acted on.

Deadlines of drives are in listened time: a program that is called later than it asked for has told
the drives nothing meanwhile, and what they have told is unread. So it waits, reads all that came,
and only then finds something missing.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TypeAlias, TypeVar

from armdrive.dialects.bus.motors import absent_words
from armdrive.dialects.cia402.wire import FAULTS, Cia402Bus, Cia402Drive, DriveGroup, Heard
from armdrive.dialects.exchange import ScriptIO
from armdrive.tasks import Alert, AlertKind, Progress, Reply, RequestRejected, Timeout, never
from firmware_protocol import canopen
from firmware_protocol.canopen import Command, Controlword, DriveState, OperationMode, way

TRIES = 3
"""How often something that may be said twice is said: of ten frames a bad bus loses one."""
LAST_ANSWER_S = 0.25
"""How much longer the last answer is waited for: a frame may lie so long in the computer or in the
adapter (see `transports/can_threads.py`)."""
MUTE_TURNS = 20
"""A drive that tells nothing in so many turns is mute; a late computer is late by fewer."""
BEATS_LOST = 3.5
"""So many of its heartbeats a drive at rest may miss before it is asked whether it is there."""
LOOKS_LOST = 4
"""So often it is asked: on a bus that loses one frame in ten, one such drive in 750 is there."""

ENABLE = Controlword.of(Command.ENABLE_OPERATION)
DISABLE = Controlword.of(Command.DISABLE_VOLTAGE)
STOP = Controlword.of(Command.QUICK_STOP)

RESPONSE_S = 1.0
"""So long a drive may take to another state or mode, or to be ready for a set-point: simulated
drives take two turns, and what real ones take was not measured."""

T = TypeVar("T")
Script: TypeAlias = Generator[float, Heard | None, T]


class Hindered(Exception):
    """A request cannot be carried out, or not to its end: what it is answered with.

    Words alone say that nothing of it was carried out.
    """

    def __init__(self, reply: Reply | str) -> None:
        super().__init__(str(reply))
        self.reply = RequestRejected(reply, moved=False) if isinstance(reply, str) else reply


class ListenedTime:
    """How long this program has listened: all the time but that by which it was called late."""

    def __init__(self) -> None:
        self.s = 0.0
        self._now_s = self._due_s = math.inf

    def pass_to(self, now_s: float) -> None:
        """Take note of the time at which it is called."""
        self.s += max(min(now_s, self._due_s) - self._now_s, 0.0)
        self._now_s = now_s

    def expect(self, due_s: float) -> None:
        """Take note of when it wants to be called."""
        self._due_s = due_s


@dataclass(slots=True, eq=False)
class Cia402Exchange:
    """Tells drives what to be, and waits for what they tell. A turn lasts `cycle_s`."""

    io: ScriptIO[Heard]
    bus: Cia402Bus
    group: DriveGroup
    answer_s: float
    cycle_s: float
    listened: ListenedTime = field(default_factory=ListenedTime)
    began_s: float = -math.inf
    """When the present request was taken up."""
    looked_s: float = -math.inf
    """When a drive at rest that is not heard was asked last."""
    # -- turns --------------------------------------------------------------------------------

    def wait(self, until_s: float, over: Callable[[], bool] = never) -> Script[None]:
        """Let time pass, stop or no stop, until a moment or until something is so."""
        while self.io.now_s < until_s and not over():
            yield until_s

    def command(
        self,
        drive: Cia402Drive,
        word: Controlword,
        mode: OperationMode,
        target: int | None = None,
    ) -> None:
        """Tell a drive what to be, and where: as a rule where it was seen."""
        target = drive.seen if target is None else target
        self.io.say(self.bus.command(drive.node, word, mode, target))

    def order(self, command: canopen.NmtCommand, drives: Collection[Cia402Drive]) -> None:
        """Order drives to take part in PDOs, or not."""
        for drive in drives:
            self.io.say(self.bus.order(canopen.Nmt(command, drive.node)))

    def sync(self) -> None:
        """Have all drives do what they were told, and tell where they are."""
        self.io.say(self.bus.sync())
        for drive in self.group.drives:
            drive.ask(self.io.now_s)

    def turn(self) -> Script[None]:
        """Have the drives do what they were told; wait for the end of the turn."""
        self.sync()
        yield from self.wait(self.io.now_s + self.cycle_s)

    def progress(self) -> None:
        """Tell where the drives are."""
        self.io.tell(Progress(self.group.registers()))

    def mute(self, drives: Collection[Cia402Drive]) -> tuple[Cia402Drive, ...]:
        """Return those of some drives that have told nothing for too long."""
        return tuple(drive for drive in drives if drive.missed > MUTE_TURNS)

    # -- looks --------------------------------------------------------------------------------

    def look(self) -> Script[None]:
        """Have every drive tell where it is; raises `Hindered` where one does not."""
        if missing := (yield from self.poll()):
            raise Hindered(self.absence(missing))

    def poll(self) -> Script[tuple[Cia402Drive, ...]]:
        """Have every drive tell where it is; return those that do not."""
        for tried in range(1, TRIES + 1):
            asked_s = self.io.now_s
            self.sync()
            until_s = self.answered_s(last=tried == TRIES)
            yield from self.wait(until_s, partial(self.group.have_told, asked_s))
            if self.group.have_told(asked_s):
                return ()
        return tuple(drive for drive in self.group.drives if drive.shaft.read_s < asked_s)

    def answered_s(self, *, last: bool) -> float:
        """Return until when to wait for the answer to what is asked now."""
        return self.io.now_s + self.answer_s + (LAST_ANSWER_S if last else 0.0)

    # -- who is missing -----------------------------------------------------------------------

    def mind(self, silent_s: float, period_s: float) -> None:
        """Miss drives that stand, by their heartbeats, while nothing is asked.

        A drive that was silent for so long is asked by SYNC once in a period before it counts as
        lost: frames can be. Where all are silent, it is the bus or this computer, which the next
        look at the positions finds out.
        """
        since_s = self.listened.s - silent_s
        quiet = [drive for drive in self.group.drives if drive.heard_s < since_s]
        if not quiet or len(quiet) == len(self.group.drives):
            return
        for drive in quiet:
            if drive.missed > LOOKS_LOST and not drive.reported:
                words = f"{drive} is not heard any more: it has lost its power, or its cable"
                self.group.alarm(drive, Alert(AlertKind.SWITCHED_OFF, words))
        if self.io.now_s >= self.looked_s + period_s:
            self.looked_s = self.io.now_s
            self.sync()

    def silence(self) -> Timeout:
        """Return the reply that says that nothing answered."""
        return self.io.silence(self.began_s)

    def absence(
        self, drives: Collection[Cia402Drive], *, moved: bool = False
    ) -> Timeout | RequestRejected:
        """Say that drives do not answer; silence where it is all of them.

        Contact is made anew then: a drive may begin anew while nobody hears it, and wait for that.
        Where something was on its way, they fell silent in the middle of it.
        """
        self.group.contacted = False
        if len(drives) == len(self.group.drives):
            return self.silence()
        words = f"{absent_words(tuple(drives), 'node number')} (`armdrive doctor --can`)"
        return RequestRejected(words, moved=moved, silent=moved)


# The ways between the states of drives: on, off, out of a fault, back from a quick stop.
#
# None of them moves a motor: a drive that gets its current is told before that it is where it
# should be.


@dataclass(slots=True, eq=False)
class DriveStates:
    """Brings drives from one state to another."""

    exchange: Cia402Exchange
    group: DriveGroup

    def bring(
        self, drives: Collection[Cia402Drive], goal: DriveState
    ) -> Script[tuple[Cia402Drive, ...]]:
        """Bring drives to a state; return those that do not come there."""
        given_up_s = self.exchange.listened.s + RESPONSE_S
        while left := tuple(drive for drive in drives if not self._is_there(drive, goal)):
            if self.exchange.listened.s >= given_up_s:
                return left
            for drive in left:
                word = self._next_word(drive, goal)
                self.exchange.command(drive, word, self.group.resting_mode)
            yield from self.exchange.turn()
        return ()

    def _is_there(self, drive: Cia402Drive, goal: DriveState) -> bool:
        rests = not goal.holds or drive.mode == self.group.resting_mode
        return drive.state is goal and rests

    def _next_word(self, drive: Cia402Drive, goal: DriveState) -> Controlword:
        """Return the next command on a drive's way; one that holds is given its mode first."""
        state = drive.state
        rests = drive.mode == self.group.resting_mode
        if state is DriveState.QUICK_STOP and goal.holds and not rests:
            return STOP
        found = None if state is None else way(state, goal, resume=True)
        cause = found[0].cause if found else None  # it is there, or will be, or nobody knows
        if isinstance(cause, Command):
            return Controlword.of(cause)
        return ENABLE if goal.holds else DISABLE

    def reset_faults(self, drives: Collection[Cia402Drive]) -> Script[tuple[Cia402Drive, ...]]:
        """Reset faults, by an edge that rises; return the drives that stay in theirs."""
        given_up_s = self.exchange.listened.s + RESPONSE_S
        words = itertools.cycle((DISABLE, Controlword.of(Command.FAULT_RESET)))
        while left := tuple(drive for drive in drives if drive.state in FAULTS):
            if self.exchange.listened.s >= given_up_s:
                return left
            word = next(words)
            for drive in left:
                self.exchange.command(drive, word, self.group.resting_mode)
            yield from self.exchange.turn()
        return ()

    def take_mode(self, drives: Collection[Cia402Drive], mode: OperationMode) -> Script[None]:
        """Have drives that are enabled be in a mode; each holds where it is."""
        given_up_s = self.exchange.listened.s + RESPONSE_S
        while left := [drive for drive in drives if drive.mode != mode]:
            if self.exchange.listened.s >= given_up_s:
                name = mode.name.lower().replace("_", " ")
                raise Hindered(
                    f"{left[0]} does not take mode {int(mode)} ({name}), it shows {left[0].mode}: "
                    "something else may command it"
                )
            for drive in left:
                self.exchange.command(drive, ENABLE, mode, drive.shaft.goal)
            yield from self.exchange.turn()

    def take_back(self, drives: Collection[Cia402Drive]) -> Script[None]:
        """Take drives back that stand in a quick stop; they hold where they are."""
        stopped = [drive for drive in drives if drive.state is DriveState.QUICK_STOP]
        left = yield from self.bring(stopped, DriveState.ENABLED)
        for drive in stopped:
            drive.rest()
        for drive in left:
            if drive.state is DriveState.QUICK_STOP:
                raise Hindered(
                    f"{drive} holds in its quick stop and does not come back from there by a "
                    "command: support the arm, call `disable()`, then call `enable()`"
                )

    def mode_of(self, drive: Cia402Drive) -> OperationMode:
        """Return the mode that a drive is in, so that a stop changes nothing else."""
        modes = (mode for mode in OperationMode if mode == drive.mode)
        return next(modes, self.group.resting_mode)


# Reading and writing objects of several CiA 402 drives at once, one after the other in each.
#
# What does not come within the time is asked for again: frames can be lost, and to read or to write
# an object twice does no harm. A late answer to the try before is as good as that to the next.

Job: TypeAlias = canopen.Place | canopen.Write
"""An object to be read, or to be written."""
Jobs: TypeAlias = Mapping[int, Sequence[Job]]
"""What is to be done with each drive, by its node number."""


@dataclass(slots=True)
class SdoResult:
    """What came of the transfers with one drive.

    `values` are those that were read; `refused` are the objects that it refused, in words. It is
    `mute` where it did not answer; the rest was not asked of it then.
    """

    drive: Cia402Drive
    values: dict[canopen.Place, int] = field(default_factory=dict)
    refused: dict[canopen.Place, str] = field(default_factory=dict)
    mute: bool = False


Results: TypeAlias = Mapping[int, SdoResult]
Lane: TypeAlias = Generator[float, canopen.SdoEvent | None, None]


@dataclass(slots=True, eq=False)
class ObjectTransfers:
    """Transfers objects by SDO."""

    io: ScriptIO[Heard]
    bus: Cia402Bus
    group: DriveGroup
    exchange: Cia402Exchange

    def of_each(self, *jobs: Job) -> Jobs:
        """Return the same for every drive."""
        return dict.fromkeys(self.group.by_node, jobs)

    def transfer(self, jobs: Jobs, *, tries: int = TRIES, lenient: bool = False) -> Script[Results]:
        """Do for each drive what is asked; all drives at the same time.

        What comes behind a write builds upon it: where it is refused the rest is left out, unless
        that is `lenient`.
        """
        answers, results = self.group.answers, {}
        lanes: dict[int, Lane] = {}
        due_s: dict[int, float] = {}
        for node, each in jobs.items():
            self.io.say(self.bus.abandon(node))
            answers.pop(node, None)
            results[node] = SdoResult(self.group.by_node[node])
            lanes[node] = self._lane(results[node], each, tries, lenient=lenient)
            due_s[node] = next(lanes[node], math.inf)
        while waiting := [node for node in due_s if math.isfinite(due_s[node])]:
            until_s = min(due_s[node] for node in waiting)
            yield from self.exchange.wait(until_s, partial(self.group.has_answer, waiting))
            for node in waiting:
                answer = answers.pop(node, None)
                if answer is not None or self.io.now_s >= due_s[node]:
                    try:
                        due_s[node] = lanes[node].send(answer)
                    except StopIteration:
                        due_s[node] = math.inf
        return results

    def _lane(self, result: SdoResult, jobs: Sequence[Job], tries: int, *, lenient: bool) -> Lane:
        """Do one thing after the other with a drive; yields until when it waits for an answer."""
        node = result.drive.node
        for job in jobs:
            answer = None
            for tried in range(1, tries + 1):
                if isinstance(job, canopen.Write):
                    self.io.say(self.bus.download(node, job.place, job.data))
                else:
                    self.io.say(self.bus.upload(node, job))
                answer = yield self.exchange.answered_s(last=tried == tries > 1)
                if answer is not None:
                    break
                self.io.say(self.bus.abandon(node))
            match answer:
                case None:
                    result.mute = True
                    return
                case canopen.Uploaded(place, data, exact):
                    result.values[place] = value_of(place, data, exact=exact)
                case canopen.Aborted(place, code):
                    words = f"{_object_words(job)}: {canopen.abort_words(code)}"
                    result.refused[place] = f"{result.drive} refused object {words}"
                    if isinstance(job, canopen.Write) and not lenient:
                        return

    def obtain(self, jobs: Jobs, *, lenient: bool = False) -> Script[Results]:
        """Do the same; raises `Hindered` where a drive does not answer."""
        results = yield from self.transfer(jobs, lenient=lenient)
        if mute := [result.drive for result in results.values() if result.mute]:
            raise Hindered(self.exchange.absence(mute))
        return results

    def carry_out(
        self, jobs: Jobs, remedy: Callable[[canopen.Place], str] = lambda _: ""
    ) -> Script[None]:
        """Do the same; raises `Hindered` also where a drive refuses an object."""
        for result in (yield from self.obtain(jobs)).values():
            for place, words in result.refused.items():
                raise Hindered(words + remedy(place))

    def verify(self, writes: Sequence[canopen.Write], why: str) -> Script[None]:
        """Read back what safety stands on."""
        results = yield from self.obtain(self.of_each(*(write.place for write in writes)))
        for write in writes:
            for result in results.values():
                if result.values.get(write.place) != write.value:
                    raise Hindered(
                        f"{result.drive} does not keep {write.value} in object {write.place}, "
                        f"{why} when this program dies"
                    )

    def explain(self, drive: Cia402Drive) -> Script[None]:
        """Ask a drive what is wrong with it, where it has not said so."""
        if drive.error:
            return
        results = yield from self.transfer({drive.node: (canopen.ERROR_CODE,)}, tries=2)
        if code := results[drive.node].values.get(canopen.ERROR_CODE, 0):
            drive.error = f"{canopen.error_words(code)} (error {code:04X})"

    def parting(self, write: canopen.Write, times: int) -> bytes:
        """Return what writes an object of every drive; nobody waits for an answer."""
        said = b""
        for drive in self.group.drives * times:
            self.bus.abandon(drive.node)
            said += self.bus.download(drive.node, write.place, write.data)
        return said

    def give_up(self) -> None:
        """Wait for no answer any more."""
        for drive in self.group.drives:
            self.bus.abandon(drive.node)
        self.group.answers.clear()
        self.bus.silence()


_MAPPINGS = (*range(0x1600, 0x1800), *range(0x1A00, 0x1C00))


def _object_words(job: Job) -> str:
    """Name an object; of an entry of a PDO's mapping, say what that should carry."""
    place = job.place if isinstance(job, canopen.Write) else job
    if (entry := canopen.STANDARD.find(place)) is not None:
        return f"{place} ({entry.name.lower()})"
    if isinstance(job, canopen.Write) and place.index in _MAPPINGS and place.sub:
        mapped = canopen.STANDARD.find(canopen.Place(job.value >> 16, job.value >> 8 & 0xFF))
        if mapped is not None:
            return f"{place} (PDO with {mapped.place}, {mapped.name.lower()})"
    return str(place)


def value_of(place: canopen.Place, data: bytes, *, exact: bool = True) -> int:
    """Return a whole number that was read, by the type that its object has."""
    entry = canopen.STANDARD.find(place)
    kind = entry.type if entry is not None else canopen.DataType.U32
    size = kind.size or len(data)
    if kind.limits is None or (exact and len(data) != size):
        return int.from_bytes(data, "little")
    return int.from_bytes(data[:size], "little", signed=kind.signed)
