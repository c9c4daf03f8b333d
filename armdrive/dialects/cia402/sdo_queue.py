"""Reading and writing objects of several drives at once, one after the other in each.

What does not come within the time is asked for again: frames can be lost, and to read or to write
an object twice does no harm. A late answer to the try before is then as good as that to the next.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from armdrive.dialects.cia402.drive import Cia402Drive
from armdrive.dialects.cia402.master import Heard
from armdrive.dialects.cia402.receive import Cia402Receiving
from armdrive.tasks import Alert, AlertKind, RequestRejected, Timeout
from firmware_protocol.canopen import (
    DEVICE_TYPE,
    STANDARD,
    Aborted,
    DataType,
    Nmt,
    NmtCommand,
    Place,
    Uploaded,
    Write,
    abort_words,
)

# Whether CiA 402 drives that stand are there still: by their heartbeats, while nothing is asked.
#
# In motion each tells what it is with every SYNC. A drive whose heartbeat is missing is asked by
# SYNC a few times before it counts as lost: frames can be. Where all are silent, it is the bus or
# this computer, which the next look at the positions finds out.

BEATS_LOST = 3.5
"""So many of its heartbeats a drive may miss."""
LOOKS_LOST = 4
LATE_S = 0.1
"""Who was not called for so long has not read what was said meanwhile."""


class HeartbeatMonitor(Cia402Receiving):
    """Minds the heartbeats of the drives at rest."""

    _minded_s = -math.inf
    _looked_s = -math.inf

    def advance(self, now_s: float) -> bytes:
        """Do what is due by now; look whether every drive is heard."""
        self.now_s = now_s
        late = now_s - self._minded_s > self.beats.period_s + LATE_S
        self._minded_s = now_s
        if self.on and self.contacted and not self.busy:
            if late:
                for drive in self.drives:
                    drive.heard_s = max(drive.heard_s, now_s)
            self._mind()
        return super().advance(now_s)

    def _mind(self) -> None:
        patience_s = BEATS_LOST * self.settings.drive_beat_ms / 1000.0
        quiet = [each for each in self.drives if each.heard_s < self.now_s - patience_s]
        if not quiet or len(quiet) == len(self.drives):
            return
        for drive in quiet:
            if drive.missed > LOOKS_LOST and not drive.reported:
                drive.reported, self.on = True, False
                words = f"{drive} is not heard any more: it has lost its power, or its cable"
                self.tell(Alert(AlertKind.SWITCHED_OFF, words))
        if self.now_s >= self._looked_s + self.beats.period_s:
            self._looked_s = self.now_s
            self.sync()


TRIES = 3
"""How often something that may be said twice is said."""
PATIENT_S = 0.25
"""How much longer than any other the last answer to that is waited for."""


_MAPPINGS = (*range(0x1600, 0x1800), *range(0x1A00, 0x1C00))


@dataclass(frozen=True, slots=True)
class ObjectRead:
    """An object to be read."""

    place: Place


Job: TypeAlias = ObjectRead | Write


@dataclass(slots=True)
class SdoQueue:
    """What is to be done with one drive, and what came of it.

    `values` are those that were read; `refused` what it refused, with its code. It is `mute` where
    it did not answer; the rest was not asked of it then.
    """

    drive: Cia402Drive
    jobs: Sequence[Job]
    values: dict[Place, int] = field(default_factory=dict)
    refused: dict[Place, int] = field(default_factory=dict)
    mute: bool = False
    lenient: bool = False
    """Whether what is behind a write that was refused is asked all the same."""
    done: int = 0
    tries: int = 0
    until_s: float = 0.0

    @property
    def over(self) -> bool:
        """Whether nothing is left to be asked."""
        return self.mute or self.done >= len(self.jobs)


Lanes: TypeAlias = Generator[float, Heard | None, Mapping[int, SdoQueue]]


class Cia402Objects(HeartbeatMonitor):
    """Transfers objects."""

    def transfer(
        self, jobs: Mapping[int, Sequence[Job]], *, tries: int = TRIES, lenient: bool = False
    ) -> Lanes:
        """Do for each drive what is asked, by its node number; all drives at the same time."""
        lanes = {
            node: SdoQueue(self._by_node[node], each, lenient=lenient)
            for node, each in jobs.items()
        }
        for node in lanes:
            self.say(self.bus.abandon(node))
            self.answers.pop(node, None)
        for lane in lanes.values():
            self._ask(lane, tries)
        while open_lanes := [lane for lane in lanes.values() if not lane.over]:
            until_s = min(lane.until_s for lane in open_lanes)
            nodes = {lane.drive.node for lane in open_lanes}
            yield from self.wait(until_s, lambda nodes=nodes: not nodes.isdisjoint(self.answers))  # type: ignore[misc]
            for lane in open_lanes:
                self._go_on(lane, tries)
        return lanes

    def everywhere(self, *jobs: Job, lenient: bool = False) -> Lanes:
        """Do the same for every drive."""
        return self.transfer({drive.node: jobs for drive in self.drives}, lenient=lenient)

    def _ask(self, lane: SdoQueue, tries: int) -> None:
        if lane.over:
            return
        node, job = lane.drive.node, lane.jobs[lane.done]
        if isinstance(job, ObjectRead):
            self.say(self.bus.upload(node, job.place))
        else:
            self.say(self.bus.download(node, job.place, job.data))
        lane.tries += 1
        patient_s = PATIENT_S if lane.tries == tries > 1 else 0.0
        lane.until_s = self.now_s + self.settings.answer_s + patient_s

    def _go_on(self, lane: SdoQueue, tries: int) -> None:
        """Take an answer, or say it again where none came in time."""
        node, answer = lane.drive.node, self.answers.pop(lane.drive.node, None)
        if answer is None:
            if self.now_s < lane.until_s:
                return
            self.say(self.bus.abandon(node))
            if lane.tries >= tries:
                lane.mute = True
                return
        else:
            self._take(lane, answer)
        self._ask(lane, tries)

    def _take(self, lane: SdoQueue, answer: object) -> None:
        job = lane.jobs[lane.done]
        match answer:
            case Uploaded(place, data, exact):
                lane.values[place] = value_of(place, data, exact=exact)
            case Aborted(place, code):
                lane.refused[place] = code
        lane.done, lane.tries = lane.done + 1, 0
        if job.place in lane.refused and isinstance(job, Write) and not lane.lenient:
            lane.done = len(lane.jobs)  # what comes behind a write builds upon it

    def awoken(self, lanes: Mapping[int, SdoQueue]) -> Generator[float, Heard | None, bool]:
        """Have nodes that did not answer be pre-operational; tell whether one answers now.

        One that somebody has stopped does not, and says no more than its heartbeat.
        """
        mute = [node for node, lane in lanes.items() if lane.mute]
        for node in mute:
            self.say(self.bus.order(Nmt(NmtCommand.PRE_OPERATIONAL, node)))
        asked = dict.fromkeys(mute, (ObjectRead(DEVICE_TYPE),))
        return not all(each.mute for each in (yield from self.transfer(asked, tries=1)).values())

    # -- words --------------------------------------------------------------------------------

    def missing(
        self, lanes: Mapping[int, SdoQueue], since_s: float
    ) -> Timeout | RequestRejected | None:
        """Say which drives did not answer; None where all did."""
        mute = [lane.drive for lane in lanes.values() if lane.mute]
        return self.absence(mute, since_s) if mute else None

    def absence(self, drives: Sequence[Cia402Drive], since_s: float) -> Timeout | RequestRejected:
        """Say that drives do not answer; silence where it is all of them.

        Contact is made anew then: a drive may begin anew while nobody hears it, and wait for that.
        """
        self.contacted = False
        if len(drives) == len(self.drives):
            return self.silence(since_s)
        return RequestRejected(self.absent_words(drives), moved=False)

    def absent_words(self, drives: Sequence[Cia402Drive]) -> str:
        """Say which drives do not answer, and what to look at."""
        named = ", ".join(map(str, drives))
        verb = "does" if len(drives) == 1 else "do"
        return (
            f"{named} {verb} not answer, while others on the bus do: check that it has power, "
            "that its CAN plug sits, and that its node number and bit rate are those of the arm "
            "file (`armdrive doctor --can`)"
        )

    def shared_words(self) -> str:
        """Say which node numbers two drives have; empty where none."""
        if not self.shared:
            return ""
        named = ", ".join(map(str, sorted(self.shared)))
        return (
            f"more than one drive answers to the node number {named}: give each one of its own, by "
            "its switches or its maker's program"
        )


def refusal_words(lane: SdoQueue, place: Place, remedy: str = "") -> str:
    """Say that a drive refused an object, which, and why."""
    entry = STANDARD.find(place)
    name = f" ({entry.name.lower()})" if entry is not None else _mapped_words(lane, place)
    why = abort_words(lane.refused[place])
    return f"{lane.drive} refused object {place}{name}: {why}{remedy}"


def _mapped_words(lane: SdoQueue, place: Place) -> str:
    """Say what an entry of a PDO's mapping should carry; empty where the object is none."""
    for job in lane.jobs:
        if isinstance(job, Write) and job.place == place and place.index in _MAPPINGS and place.sub:
            mapped = STANDARD.find(Place(job.value >> 16, job.value >> 8 & 0xFF))
            if mapped is not None:
                return f" (PDO with {mapped.place}, {mapped.name.lower()})"
    return ""


def value_of(place: Place, data: bytes, *, exact: bool = True) -> int:
    """Return a whole number that was read, by the type that its object has."""
    entry = STANDARD.find(place)
    kind = entry.type if entry is not None else DataType.U32
    size = kind.size or len(data)
    if kind.limits is None or (exact and len(data) != size):
        return int.from_bytes(data, "little")
    return int.from_bytes(data[:size], "little", signed=kind.signed)
