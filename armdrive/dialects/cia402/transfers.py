"""Reading and writing the objects of several drives side by side, by SDO."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import zip_longest
from typing import TypeAlias, TypeVar

from armdrive.dialects.bus.drives import LAST_TRY_S
from armdrive.dialects.cia402.drives import Answer, Cia402Drive, value_of
from armdrive.dialects.cia402.objects import is_text, object_words, value_words
from armdrive.dialects.exchange import TRIES, ScriptIO
from armdrive.dialects.exchange import Script as ExchangeScript
from armdrive.tasks import never
from firmware_protocol import canopen
from firmware_protocol.canopen import HostEvent, Place, Write
from firmware_protocol.canopen.sdo import Upload

T = TypeVar("T")
Script: TypeAlias = ExchangeScript[HostEvent, T]

# A read or a write of an object by SDO.
Job: TypeAlias = Place | Write
Jobs: TypeAlias = Mapping[Cia402Drive, Sequence[Job]]

# The reasons for which a drive refuses to have a constant written, and those for which it refuses
# an object that it lacks or has as a constant.
CONSTANT = (canopen.AbortCode.READ_ONLY, canopen.AbortCode.ACCESS)
ABSENT = (canopen.AbortCode.NO_OBJECT, canopen.AbortCode.NO_SUB_INDEX, *CONSTANT)


@dataclass(slots=True)
class ReadObjects:
    """What the transfers with one drive gave.

    `values` and `texts` were read. `refused` are the objects that it refused, with the reason in
    words, and `codes` the abort codes of these. It is `mute` if an answer is missing.
    """

    drive: Cia402Drive
    values: dict[Place, int] = field(default_factory=dict)
    texts: dict[Place, str] = field(default_factory=dict)
    refused: dict[Place, str] = field(default_factory=dict)
    codes: dict[Place, int] = field(default_factory=dict)
    mute: bool = False

    def lacks(self, place: Place) -> bool:
        """Return whether it does not have an object, or has it as a constant."""
        return self.codes.get(place) in ABSENT

    def take(self, job: Job, answer: Answer | None) -> None:
        """Record the answer to a job."""
        match answer:
            case canopen.Uploaded(place, data) if is_text(place):
                self.texts[place] = data.decode("latin-1")
            case canopen.Uploaded(place):
                self.values[place] = value_of(answer)
            case canopen.Aborted(place, code):
                self.refused[place] = _refused_words(self.drive, job, code)
                self.codes[place] = code
            case None:
                self.mute = True


def _refused_words(drive: Cia402Drive, job: Job, code: int) -> str:
    what = object_words(job.place if isinstance(job, Write) else job)
    value = f" ({value_words(job.place, job.value)})" if isinstance(job, Write) else ""
    return f"{drive} refused object {what}{value}: {canopen.abort_words(code)}"


def wait(io: ScriptIO[HostEvent], seconds: float, over: Callable[[], bool] = never) -> Script[None]:
    """Wait for some listened time, or for a condition, regardless of stops."""
    ends_s = io.listened.s + seconds - 1e-9
    while io.listened.s < ends_s and not over():
        event = yield io.now_s + max(ends_s - io.listened.s, 1e-6)
        if event is not None:
            io.on_unsolicited(event)


class ObjectTransfers:
    """Transfers objects of the drives on a wire.

    Without `aborts`, drives are not told of transfers that are given up: see `survey`.
    """

    def __init__(
        self, io: ScriptIO[HostEvent], host: canopen.Host, answer_s: float, *, aborts: bool = True
    ) -> None:
        self._io, self._host, self._answer_s = io, host, answer_s
        self._aborts = aborts
        self.shared: set[int] = set()
        """The node numbers that two drives answer to: with two serial numbers."""
        self._serials: dict[int, bytes] = {}

    def note(self, drive: Cia402Drive, answer: canopen.SdoEvent) -> None:
        """Record what a transfer with a drive gave."""
        match answer:
            case canopen.StrayResponse(Upload(place, content)):
                drive.strays += 1
                # a repeated frame is equal
                serial = self._serials.get(drive.node, content.data)
                if place == canopen.SERIAL_NUMBER and content.data != serial:
                    self.shared.add(drive.node)
            case canopen.Uploaded() | canopen.Downloaded() | canopen.Aborted():
                drive.answer = answer
        match answer:
            case canopen.Uploaded(canopen.SERIAL_NUMBER, data):
                self._serials[drive.node] = data
            case canopen.Uploaded(canopen.POSITION):
                drive.note_position(value_of(answer), drive.asked_s)
            case canopen.Uploaded(canopen.STATUSWORD):
                drive.note_word(canopen.Statusword(value_of(answer)))

    def transfer(
        self,
        jobs: Jobs,
        *,
        tries: int = TRIES,
        lenient: bool = False,
        over: Callable[[], bool] = never,
    ) -> Script[list[ReadObjects]]:
        """Read and write objects of several drives side by side, until that is `over`.

        Later jobs build on the writes before them. So the rest of a drive's jobs is skipped after a
        refused write, unless `lenient`.
        """
        results = {drive: ReadObjects(drive) for drive in jobs}
        skipped: set[Cia402Drive] = set()
        for row in zip_longest(*jobs.values()):
            now = {
                drive: job
                for drive, job in zip(jobs, row, strict=True)
                if job is not None and drive not in skipped
            }
            yield from self._answers(now, tries, over)
            answers = {drive: drive.answer for drive in now}
            constants = {
                drive: job.place
                for drive, job in now.items()
                if isinstance(job, Write) and _cannot_be_written(drive.answer)
            }
            yield from self._answers(constants, tries, over)
            if over():
                break
            for drive, job in now.items():
                if isinstance(job, Write) and _suits(job, drive.answer):
                    continue
                results[drive].take(job, answers[drive])
                refused = isinstance(job, Write) and job.place in results[drive].refused
                if results[drive].mute or (refused and not lenient):
                    skipped.add(drive)
        return list(results.values())

    def _answers(
        self, jobs: Mapping[Cia402Drive, Job], tries: int, over: Callable[[], bool]
    ) -> Script[None]:
        """Wait for the answers of drives to one job each; none comes from a mute one."""
        left = dict(jobs)

        def complete() -> bool:
            return over() or all(drive.answer is not None for drive in left)

        for attempt in range(1, tries + 1):
            for drive, job in left.items():
                self.ask(drive, job)
                drive.repeats += attempt > 1
            # a busy computer or a full adapter may hold the last answer back
            last_s = LAST_TRY_S if attempt == tries else 0.0
            yield from wait(self._io, self._answer_s + last_s, complete)
            left = {drive: job for drive, job in left.items() if drive.answer is None}
            if not left or over():
                break
        self.give_up(left)

    def ask(self, drive: Cia402Drive, job: Job) -> None:
        """Begin a transfer with a drive; it replaces an unanswered one."""
        self.give_up((drive,))
        drive.answer, drive.asked_s = None, self._io.now_s
        if isinstance(job, Write):
            self._io.out += self._host.download(drive.node, job.place, job.data)
        else:
            self._io.out += self._host.upload(drive.node, job)

    def give_up(self, drives: Collection[Cia402Drive]) -> None:
        """Give up the transfers with drives."""
        for drive in drives:
            frame = self._host.abandon(drive.node)
            self._io.out += frame if self._aborts else b""


def _cannot_be_written(answer: Answer | None) -> bool:
    """Return whether a drive refused to have an object written because it is a constant."""
    return isinstance(answer, canopen.Aborted) and answer.code in CONSTANT


def _suits(write: Write, present: Answer | None) -> bool:
    """Return whether an object that cannot be written has a suitable value already.

    Drives have constants where CiA 301 and 402 allow writing: 1400:02 is 255 in Trinamic's
    TMCM-1276, 60C2:02 is -3 in Yiyou's EuServo (their EDS files).
    """
    equals = (write.value, *write.equals)
    return isinstance(present, canopen.Uploaded) and value_of(present) in equals
