"""What drives do together: the end of an earlier motion, and their own homing, group by group."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

from armdrive.dialects.controller import OVERTRAVEL, HomingTime, in_turn
from armdrive.dialects.exchange import ListenedTime, Obstructed, Script, ScriptIO
from armdrive.tasks import Done, Reply

H = TypeVar("H")
D = TypeVar("D")

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

    `times` tell how far and for how long each drive may search.
    """

    def __init__(
        self,
        drives: Sequence[Observed],
        tolerance: float,
        listened: ListenedTime,
        times: HomingTimes[Observed],
    ) -> None:
        self.left = list(drives)
        """The drives that are still searching."""
        self.wrong = ""
        """What went wrong, in words."""
        self._starts = {drive: drive.count for drive in drives}
        self._tolerance, self._times = tolerance, times
        self._listened, self._began_s = listened, listened.s

    def note(self, drive: Observed, status: HomingStatus) -> None:
        """Record what a drive reports. A search that has left the motor's range has failed."""
        travel = abs(drive.count - self._starts[drive])
        if status is HomingStatus.FOUND:
            self.left.remove(drive)
        elif status is HomingStatus.FAILED:
            self.wrong = self.wrong or f"{drive} did not find its switch or stop"
        elif travel > OVERTRAVEL * self._times.ranges[drive] + self._tolerance:
            self.wrong = self.wrong or f"{drive} found no switch within its joints' limits"

    @property
    def over(self) -> bool:
        """Whether all have found their switches, or one never will."""
        for drive in self.left:
            time, searched_s = self._times.time(drive), self._listened.s - self._began_s
            if searched_s > time.waited_s:
                words = f"{drive} found no switch in time, after {searched_s:.0f} s{time.remedy}"
                self.wrong = self.wrong or words
        return bool(self.wrong) or not self.left


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


class HomingTimes(Generic[D]):
    """How fast drives home, and how long at most, as far as they report it.

    `ranges` are how far each drive's motor turns between its joints' limits, and `assumed` is the
    time of a drive that reports nothing.
    """

    def __init__(self, drives: Sequence[D], ranges: Sequence[float], assumed: HomingTime) -> None:
        self._drives, self._unknown = drives, (math.inf, assumed)
        self.ranges = dict(zip(drives, ranges, strict=False))
        self._found: dict[D, tuple[float, HomingTime]] = {}

    def note(self, drive: D, rate_hz: float, lasts_s: float) -> None:
        """Record a drive's greatest speed, and how long its search lasts at most."""
        self._found[drive] = rate_hz, HomingTime(lasts_s)

    def forget(self, drive: D) -> None:
        """Record that a drive does not report how it homes."""
        self._found.pop(drive, None)

    def time(self, drive: D) -> HomingTime:
        """Return how long a drive homes at most."""
        return self._found.get(drive, self._unknown)[1]

    def estimate(self, groups: Groups) -> HomingEstimate:
        """Return how some groups home."""
        together = homing_groups(groups, self._drives)
        times = [max(map(self.time, group)) for group in together]
        drives = (drive for group in together for drive in group)
        rates_hz = (self._found.get(drive, self._unknown)[0] for drive in drives)
        return HomingEstimate(max(rates_hz), max(times), in_turn(times))


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
