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

from armdrive.recorder.bench import Bench
from armdrive.recorder.entries import Entry, Kind
from armdrive.recorder.judging import GRACE_S, Judge, Parting
from armdrive.recorder.messages import talk
from armdrive.recorder.placing import (
    answer_to,
    counts_of,
    first_counts,
    first_offset,
    gap,
    offset_at,
    position,
)

if TYPE_CHECKING:
    from armdrive.recorder.reading import Recording
    from armdrive.sim.options import Value

_ANSWERS = frozenset((Kind.REPLY, Kind.REGISTERS, Kind.SILENCE))


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
        self._judge = Judge(bench, talk(recording.header.dialect))
        self._asked = ""

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
            if self._judge.parting is not None:
                break
        else:
            self._end()
        if missing.stop == len(self._entries) and missing:
            self._notes.append("part of the recording had gone, and the rest cannot be compared")
        judge = self._judge
        return Replayed(judge.compared, self._bench.late_s, judge.parting, tuple(self._notes))

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
        self._judge.resume()
        self._asked = ""
        self._notes.append(
            f"part of the recording had gone: it is compared from {answer.time_s:.3f} s on"
        )

    # -- what happens ---------------------------------------------------------------------------

    def _take(self, index: int, entry: Entry) -> None:
        judge = self._judge
        if entry.kind is Kind.SENT and isinstance(entry.what, bytes):
            self._bench.send(entry.what, entry.time_s)
        elif entry.kind is Kind.HEARD:
            judge.heard(index, entry, self._asked)
        elif entry.kind is Kind.REQUEST:
            judge.unasked(index, entry, entry.time_s - GRACE_S)
            self._asked = str(entry.what)
        elif entry.kind is Kind.ALERT:
            judge.alerted(index, entry)
        elif entry.kind is Kind.REGISTERS:
            judge.counts(index, entry)
        elif entry.kind is Kind.SILENCE:
            judge.silence(index, entry)
        if entry.kind in _ANSWERS:
            self._asked = ""

    def _end(self) -> None:
        """Look whether the twin has said more, unless the arm's answer was still to come."""
        if not self._entries or self._asked:
            return
        index = len(self._entries) - 1
        last = self._entries[index]
        self._bench.advance(last.time_s)
        self._judge.unasked(index, last, last.time_s - GRACE_S)
