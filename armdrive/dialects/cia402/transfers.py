"""Reading and writing objects of several CiA 402 drives at once, one after the other in each.

What does not come within the time is asked for again: frames can be lost, and to read or to write
an object twice does no harm. A late answer to the try before is as good as that to the next.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TypeAlias

from armdrive.dialects.cia402.exchange import TRIES, Cia402Exchange, Hindered, Script
from armdrive.dialects.cia402.wire import Cia402Bus, Cia402Drive, DriveGroup, Heard
from armdrive.dialects.exchange import ScriptIO
from firmware_protocol import canopen

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
