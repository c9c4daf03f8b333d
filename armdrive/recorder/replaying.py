"""Feeding a recording to a simulated twin, and finding the first place where the two part.

The twin hears the recorded bytes at their times; what it answers is compared with what the arm
answered, message by message, and its counts with the arm's whenever those were read at rest. Where
it is slower than the arm was, the rest is given to it later, so that no byte meets a busy device
that met an idle one. What either does faster or slower is no difference; what they say is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from armdrive.controllers.requests import AlertKind
from armdrive.recorder.bench import Bench
from armdrive.recorder.entries import Entry, Kind
from armdrive.recorder.messages import Message, Weight, talk
from armdrive.recorder.placing import (
    Counts,
    answer_to,
    counts_of,
    first_counts,
    first_offset,
    gap,
    offset_at,
    position,
)
from armdrive.sim.saved import Json

if TYPE_CHECKING:
    from armdrive.recorder.reading import Recording
    from armdrive.sim.options import Value

GRACE_S = 1.0
"""An answer of the twin that the arm has not given by then, with nothing asked, is a difference."""
_ANSWERS = frozenset((Kind.REPLY, Kind.REGISTERS, Kind.SILENCE))


@dataclass(frozen=True, slots=True)
class Parting:
    """The first difference: at which entry, what each said, and how the twin stands then."""

    index: int
    time_s: float
    why: str
    arm: str
    twin: str
    twin_state: str
    twin_view: Mapping[str, Json]

    def __str__(self) -> str:
        return (
            f"they part at {self.time_s:.3f} s: {self.why}. The arm: {self.arm}. The twin: "
            f"{self.twin}. The twin stands like this: {self.twin_state}"
        )


@dataclass(frozen=True, slots=True)
class Replayed:
    """What a replay found. `compared` counts the messages and counts that were held together."""

    compared: int
    late_s: float
    parting: Parting | None
    notes: tuple[str, ...]


def replay(recording: Recording, settings: Mapping[str, Value] | None = None) -> Replayed:
    """Replay a recording against the twin of its arm. Raises `RecordingError`."""
    config = recording.config()
    notes = []
    if config.calibration != recording.header.calibration:
        notes.append(
            "this armdrive understands the recorded arm file otherwise than the one that wrote it "
            f"({recording.header.version}): angles and positions of the twin may differ"
        )
    if recording.cut_off:
        notes.append("the recording's last line was cut off")
    return _Replay(recording, Bench(config, settings), notes).run()


class _Replay:
    """One replay under way."""

    def __init__(self, recording: Recording, bench: Bench, notes: list[str]) -> None:
        self._entries = recording.entries
        self._bench = bench
        self._notes = notes
        self._talk = talk(recording.header.dialect)
        self._splitter = self._talk.splitter()
        self._asked = ""
        self._told = False
        self._passing: Message | None = None
        self._compared = 0
        self._parting: Parting | None = None

    def run(self) -> Replayed:
        """Go through all entries up to the first difference."""
        missing = gap(self._entries)
        self._begin()
        for index, entry in enumerate(self._entries):
            if index in missing:
                self._pass_over(entry)
                continue
            if missing and index == missing.stop:
                self._resume(index)
            self._take(index, entry)
            if self._parting is not None:
                break
        else:
            self._end()
        if missing.stop == len(self._entries) and missing:
            self._notes.append("part of the recording had gone, and the rest cannot be compared")
        return Replayed(self._compared, self._bench.late_s, self._parting, tuple(self._notes))

    # -- where the twin stands ------------------------------------------------------------------

    def _begin(self) -> None:
        """Have the twin stand as the arm stood at first, as far as the recording tells."""
        counts, offset = first_counts(self._entries), first_offset(self._entries)
        if counts is None:
            self._notes.append("the arm never told where it stands: the twin stands anywhere")
            return
        self._bench.place(counts, position(counts, offset))
        if offset is None:
            self._notes.append("the arm's position was never known: the twin stands anywhere")

    def _pass_over(self, entry: Entry) -> None:
        """Have the twin hear settings that last; what it says to them is not compared."""
        if entry.kind is Kind.SENT and isinstance(entry.what, bytes):
            self._bench.send(entry.what, entry.time_s)

    def _resume(self, index: int) -> None:
        answer = answer_to(self._entries, index)
        if answer is None:
            return
        counts = counts_of(answer)
        self._bench.advance(self._entries[index].time_s)
        self._bench.place(counts, position(counts, offset_at(self._entries, index)))
        self._splitter = self._talk.splitter()
        self._asked = ""
        self._notes.append(
            f"part of the recording had gone: it is compared from {answer.time_s:.3f} s on"
        )

    # -- what happens ---------------------------------------------------------------------------

    def _take(self, index: int, entry: Entry) -> None:
        if isinstance(entry.what, bytes):
            if entry.kind is Kind.SENT:
                self._bench.send(entry.what, entry.time_s)
            else:
                for message in self._splitter.feed(entry.what):
                    self._compare(index, entry, message)
        elif entry.kind is Kind.REQUEST:
            self._check_unasked(index, entry, entry.time_s - GRACE_S)
            self._asked = entry.what
        elif entry.kind is Kind.ALERT:
            self._alerted(index, entry.what)
        elif entry.kind in _ANSWERS:
            self._answered(index, entry)
            self._asked = ""

    def _answered(self, index: int, entry: Entry) -> None:
        if entry.kind is Kind.SILENCE:
            self._bench.advance(entry.time_s)
            self._check_unasked(index, entry, entry.time_s)
        elif entry.kind is Kind.REGISTERS:
            self._compare_counts(index, entry)

    def _compare(self, index: int, entry: Entry, message: Message) -> None:
        if message.weight is Weight.PASSING:
            self._passing = message
        beginning = message.weight is Weight.BANNER and not self._told
        if beginning or message.weight in (Weight.PASSING, Weight.SELF) or self._parting:
            return
        said = self._talk.said(message.data)
        banner = message.weight is Weight.BANNER
        answer = (self._bench.banner if banner else self._bench.answer)(entry.time_s)
        if answer is None:
            self._part(index, "the arm said what the twin does not say", said, "nothing")
        elif not self._agrees(message, answer):
            self._part(index, "they answered otherwise", said, self._talk.said(answer.data))
        else:
            self._compared += 1

    def _agrees(self, message: Message, answer: Message) -> bool:
        if message.data == answer.data or message.weight is Weight.BANNER:
            return True
        of_moment = message.weight is answer.weight is Weight.MOMENT
        turning = self._asked.startswith("Move") or self._bench.moving
        return of_moment and turning and message.kind == answer.kind

    def _compare_counts(self, index: int, entry: Entry) -> None:
        if self._parting is not None:
            return
        if not self._told:
            self._told = True
            self._bench.forget_banners()
        counts = counts_of(entry)
        stands = self._bench.stand(entry.time_s)
        twin = self._bench.registers
        if stands and counts == twin:
            self._compared += 1
            return
        why = "the motors were counted otherwise" if stands else "the twin still moves"
        self._part(index, why, _words(counts), _words(twin))

    def _alerted(self, index: int, words: str) -> None:
        """Compare the last reports of a motion, where the arm's were of something else."""
        ours, its = (
            "nothing" if each is None else self._talk.said(each.data)
            for each in (self._passing, self._bench.passing)
        )
        if self._parting is not None:
            return
        if words.startswith(AlertKind.RESTARTED.value):
            self._part(index, "the arm began anew, the twin did not", words, its)
        elif words.startswith(AlertKind.ASTRAY.value) and ours != its:
            self._part(index, "the arm was seen off the way that was sent", ours, its)

    def _check_unasked(self, index: int, entry: Entry, before_s: float) -> None:
        message = self._bench.unasked(before_s)
        if message is not None and self._parting is None:
            silent = str(entry.what) if entry.kind is Kind.SILENCE else "nothing"
            self._part(
                index,
                "the twin said what the arm did not say",
                silent,
                self._talk.shown(message.data),
            )

    def _end(self) -> None:
        """Look whether the twin has said more, unless the arm's answer was still to come."""
        if not self._entries or self._asked:
            return
        index = len(self._entries) - 1
        last = self._entries[index]
        self._bench.advance(last.time_s)
        self._check_unasked(index, last, last.time_s - GRACE_S)

    def _part(self, index: int, why: str, arm: str, twin: str) -> None:
        bench = self._bench
        time_s = self._entries[index].time_s
        self._parting = Parting(index, time_s, why, arm, twin, bench.words, bench.view)


def _words(counts: Counts) -> str:
    return " ".join(map(str, counts))
