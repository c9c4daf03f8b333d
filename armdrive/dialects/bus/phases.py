"""Lead the drives of one arm through a motion: its phases and signals, for every dialect.

A motion is in one phase at a time. The phase's stage sends the frames that are due and reports a
signal when something has changed. The table gives the next phase and the action on the way there.
A signal that the table does not list for a phase changes nothing.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

from armdrive.dialects.bus.drives import midway
from armdrive.dialects.controller import OVERTRAVEL, HomingTime, in_turn
from armdrive.dialects.exchange import ListenedTime, Obstructed, Script, ScriptIO
from armdrive.tasks import Done, Reply, RequestRejected, Timeout, never

H = TypeVar("H")


class Phase(Enum):
    """What all drives of the arm are doing."""

    MOVING = "moving"
    """The drives receive one target after the other."""
    OUTAGE = "bus outage"
    """No drive replies, or drives may have missed this program's heartbeat and stopped: none gets a
    further target, and each ends at its last one. Then the position or state of every drive is
    read. If the arm is paused meanwhile, this lasts until it resumes (MKS)."""
    ARRIVING = "arriving"
    """The drives have their final targets and complete the rest."""
    STOPPING = "stopping"
    """The stop is repeated until every drive is seen to brake."""
    HOMING = "homing"
    """The drives search for their switches by themselves."""
    ENDED = "ended"


class Signal(Enum):
    """What has changed in a phase."""

    STOP = "a stop was requested, or a jog was released"
    OUTAGE = "no drive has replied for a while, one replies again, or a heartbeat may be missing"
    TROUBLE = "a drive does not follow its orders, or does not reply"
    REJECTED = "a drive reports that it rejects an order"
    ALL_SENT = "the final targets have been sent"
    LOCATED = "every drive stands at its last target, or its state can be read"
    SHORT = "a drive stands short of its target: its order may have been lost"
    OUT_OF_RANGE = "a target cannot be expressed"
    ARRIVED = "all drives stand at their targets"
    STOPPED = "all drives stand"
    NOT_STOPPED = "some drives do not come to rest, or do not reply"


class Act(Enum):
    """The action between one phase and the next."""

    NOTHING = "nothing"
    STOP = "send the stop"
    EXPLAIN = "send the stop, and ask a drive that replies what is wrong"
    REPEAT = "send the order again"
    RESUME = "continue from where the drives are, leaving nothing out"
    HOLD = "have each drive hold where it stands, and find out what is still unknown"


# The next phase and the action for each signal, phase by phase.
TABLE: Mapping[tuple[Phase, Signal], tuple[Phase, Act]] = MappingProxyType(
    {
        (Phase.MOVING, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.MOVING, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.MOVING, Signal.REJECTED): (Phase.MOVING, Act.REPEAT),
        (Phase.MOVING, Signal.OUT_OF_RANGE): (Phase.STOPPING, Act.STOP),
        (Phase.MOVING, Signal.OUTAGE): (Phase.OUTAGE, Act.NOTHING),
        (Phase.MOVING, Signal.ALL_SENT): (Phase.ARRIVING, Act.NOTHING),
        (Phase.OUTAGE, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.OUTAGE, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.OUTAGE, Signal.LOCATED): (Phase.MOVING, Act.RESUME),
        (Phase.OUTAGE, Signal.REJECTED): (Phase.OUTAGE, Act.REPEAT),
        (Phase.OUTAGE, Signal.SHORT): (Phase.OUTAGE, Act.REPEAT),
        (Phase.OUTAGE, Signal.ALL_SENT): (Phase.ARRIVING, Act.NOTHING),
        (Phase.ARRIVING, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.ARRIVING, Signal.TROUBLE): (Phase.STOPPING, Act.EXPLAIN),
        (Phase.ARRIVING, Signal.REJECTED): (Phase.ARRIVING, Act.REPEAT),
        (Phase.ARRIVING, Signal.SHORT): (Phase.ARRIVING, Act.REPEAT),
        (Phase.ARRIVING, Signal.OUTAGE): (Phase.OUTAGE, Act.NOTHING),
        (Phase.ARRIVING, Signal.ARRIVED): (Phase.ENDED, Act.NOTHING),
        (Phase.STOPPING, Signal.STOPPED): (Phase.ENDED, Act.HOLD),
        (Phase.STOPPING, Signal.NOT_STOPPED): (Phase.ENDED, Act.HOLD),
        (Phase.HOMING, Signal.STOP): (Phase.STOPPING, Act.STOP),
        (Phase.HOMING, Signal.TROUBLE): (Phase.STOPPING, Act.STOP),
        (Phase.HOMING, Signal.ARRIVED): (Phase.ENDED, Act.NOTHING),
    }
)


class Stage(Protocol):
    """What a dialect does in one phase. It need not watch for stops: `run_phases` does."""

    def step(self, now_s: float) -> float:
        """Send the frames that are due; return when to call again if no reply comes first."""

    def signal(self, now_s: float) -> Signal | None:
        """Return what has changed; None while the phase goes on."""


Stages: TypeAlias = Mapping[Phase, Callable[[], Stage]]
# What each action does; an action that takes time is a script.
Acts: TypeAlias = Mapping[Act, Callable[[], Generator[float, Any, None] | None]]


def run_phases(
    io: ScriptIO[H],
    phase: Phase,
    stages: Stages,
    acts: Acts,
    released: Callable[[], bool] = never,
) -> Generator[float, H | None, None]:
    """Lead the drives from a phase through all that follow, until the motion has ended.

    A stop goes first, in every phase: before the stage is asked what else has changed. `released`
    tells whether the motion is a jog that was released, which is a stop too.
    """
    stage = stages[phase]()
    while phase is not Phase.ENDED:
        row = TABLE.get((phase, Signal.STOP)) if io.stop_asked or released() else None
        if row is None and (signal := stage.signal(io.now_s)) is not None:
            row = TABLE.get((phase, signal))
        if row is None:
            event = yield stage.step(io.now_s)
            while event is not None:  # read everything that has arrived before judging
                io.on_unsolicited(event)
                event = yield io.now_s
            continue
        following, act = row
        script = None if act is Act.NOTHING else acts[act]()
        if script is not None:
            yield from script
        if following not in (phase, Phase.ENDED):
            stage = stages[following]()
        phase = following


D = TypeVar("D")


# What every dialect goes through: the end of an earlier motion, braking, homing. A dialect supplies
# the frames and says what it has seen of each drive. Deadlines are in listened time, so a late
# computer blames no drive.


class Braking(ABC, Generic[D]):
    """The stopping stage: the stop is repeated until every drive is seen to stand."""

    def __init__(self, drives: Iterable[D], listened: ListenedTime, patience_s: float) -> None:
        self._listened = listened
        self.left = list(drives)
        """The drives that have not been seen to stand."""
        self.standing: list[D] = []
        self._mute: list[D] = []
        self._given_up_s = listened.s + patience_s

    @abstractmethod
    def step(self, now_s: float) -> float:
        """Repeat the stop and ask the drives that do not stand; return when to call again."""

    @abstractmethod
    def stands(self, drive: D) -> bool:
        """Return whether a drive has been seen to stand."""

    @abstractmethod
    def is_mute(self, drive: D) -> bool:
        """Return whether a drive has left too many questions unanswered."""

    @abstractmethod
    def absence(self, mute: Sequence[D]) -> Timeout | RequestRejected:
        """Return the reply that names missing drives."""

    def settle(self, drive: D, now_s: float) -> None:  # noqa: ARG002
        """Record that a drive stands."""
        self.left.remove(drive)
        self.standing.append(drive)

    def signal(self, now_s: float) -> Signal | None:
        """Return whether all drives stand, or that this will not be known."""
        for drive in tuple(self.left):
            if self.stands(drive):
                self.settle(drive, now_s)
        if not self.left:
            return Signal.STOPPED
        self._mute = [drive for drive in self.left if self.is_mute(drive)]
        over = self._listened.s >= self._given_up_s
        return Signal.NOT_STOPPED if over or len(self._mute) == len(self.left) else None

    def unstopped(self) -> Timeout | RequestRejected | None:
        """Return why some drives are not known to stand; None if all are."""
        if not self.left:
            return None
        if len(self._mute) == len(self.left):
            return midway(self.absence(self._mute))
        return RequestRejected(f"{self.left[0]} did not come to rest after a stop")


# How long drives may turn that an earlier program left moving or homing, and again after their
# stop.
EARLIER_MOTION_S = 1.0


def end_earlier_motion(
    io: ScriptIO[H],
    turning: Callable[[], Script[Any, list[D]]],
    stop: Callable[[list[D]], Script[Any, None]],
    homes: Callable[[D], bool] = lambda _drive: False,
) -> Script[Any, None]:
    """Wait for the end of a motion that an earlier program left running, then stop it.

    A stop request ends the wait. A drive that `homes` is stopped at once: on a silent bus its
    watchdog would stop it in the announced time, and these questions feed the watchdog. `turning`
    returns the drives that turn, and takes the time between two looks. Raises `Obstructed` if a
    drive still turns after its stop.
    """
    began_s, stopped_s = io.listened.s, math.inf
    while drives := (yield from turning()):
        if io.listened.s > stopped_s + EARLIER_MOTION_S:
            raise Obstructed(
                f"{drives[0]} turns, and did not come to rest after a stop: support the arm and "
                "switch the motors' supply off"
            )
        waited = io.stop_asked or io.listened.s > began_s + EARLIER_MOTION_S
        if (waited or any(map(homes, drives))) and math.isinf(stopped_s):
            yield from stop(drives)
            stopped_s = io.listened.s


class HomingStatus(Enum):
    """What a drive reports of its search."""

    SEARCHING = "searching"
    FOUND = "found"
    FAILED = "failed"


class Counting(Protocol):
    """A drive with a position."""

    @property
    def count(self) -> int:
        """Its count."""


Observed = TypeVar("Observed", bound=Counting)


class HomingSearch(Generic[Observed]):
    """The drives of one group that search for their switches, and what went wrong.

    `times` are how long each drive may search.
    """

    def __init__(
        self,
        ranges: Mapping[Observed, float],
        tolerance: float,
        listened: ListenedTime,
        times: Mapping[Observed, HomingTime],
    ) -> None:
        self.left = list(ranges)
        """The drives that are still searching."""
        self.wrong = ""
        """What went wrong, in words."""
        self._starts = {drive: drive.count for drive in ranges}
        self._most = {drive: OVERTRAVEL * each + tolerance for drive, each in ranges.items()}
        self._listened, self._began_s, self._times = listened, listened.s, times

    def note(self, drive: Observed, status: HomingStatus) -> None:
        """Record what a drive reports. A search that has left the motor's range has failed."""
        travel = abs(drive.count - self._starts[drive])
        if status is HomingStatus.FOUND:
            self.left.remove(drive)
        elif status is HomingStatus.FAILED:
            self.wrong = self.wrong or f"{drive} did not find its switch or stop"
        elif travel > self._most[drive]:
            self.wrong = self.wrong or f"{drive} found no switch within its joints' limits"

    def signal(self) -> Signal | None:
        """Return whether all have found their switches, or one never will."""
        for drive in self.left:
            time, searched_s = self._times[drive], self._listened.s - self._began_s
            if searched_s > time.waited_s:
                words = f"{drive} found no switch in time, after {searched_s:.0f} s{time.remedy}"
                self.wrong = self.wrong or words
        if self.wrong:
            return Signal.TROUBLE
        return None if self.left else Signal.ARRIVED


# The motors that home together, group after group; without groups, each by itself.
Groups: TypeAlias = tuple[tuple[int, ...], ...]


def homing_groups(groups: Groups, drives: Sequence[D]) -> list[tuple[D, ...]]:
    """Return the drives that home together, group after group."""
    motors = groups or tuple((motor,) for motor in range(len(drives)))
    return [tuple(drives[motor] for motor in group) for group in motors]


@dataclass(frozen=True, slots=True)
class HomingEstimate:
    """How the drives of some groups home.

    `rate_hz` is the speed of the fastest, infinite if one does not report its own. `longest` is the
    most time that a group takes, and `lasts` what all take, one after the other.
    """

    rate_hz: float
    longest: HomingTime
    lasts: HomingTime


def homing_estimate(
    groups: Groups,
    drives: Sequence[D],
    rate_hz: Callable[[D], float],
    time: Callable[[D], HomingTime],
) -> HomingEstimate:
    """Return how groups home, from the speed and the time of each drive."""
    together = homing_groups(groups, drives)
    times = [max(map(time, group)) for group in together]
    fastest_hz = max(rate_hz(drive) for group in together for drive in group)
    return HomingEstimate(fastest_hz, max(times), in_turn(times))


def home_in_groups(
    groups: Groups,
    drives: Sequence[D],
    home_group: Callable[[tuple[D, ...]], Script[Any, Reply]],
) -> Script[Any, Reply]:
    """Home group after group."""
    for group in homing_groups(groups, drives):
        reply = yield from home_group(group)
        if not isinstance(reply, Done):
            return reply
    return Done()
