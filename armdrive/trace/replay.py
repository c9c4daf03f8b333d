"""Feeding a recording to a simulated twin, and finding the first place where the two part.

The twin hears the recorded bytes at their times; what it answers is compared with what the arm
answered, message by message, and its counts with the arm's whenever those were read at rest.
Where
it is slower than the arm was, the rest is given to it later, so that no byte meets a busy device
that met an idle one. What either does faster or slower is no difference; what they say is.
"""

from __future__ import annotations

import math
import re
import tempfile
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from armdrive.config.arm import MODEL_FILE, ArmConfig
from armdrive.dialects.words import Describer, Message, Weight
from armdrive.errors import ArmError, BadRequest, RecordingError
from armdrive.registry.arm_files import parse_arm
from armdrive.registry.simulate import simulate_device
from armdrive.sim.device import SimDevice, Value, state_json, state_line
from armdrive.sim.simulated_arm import DIALECT
from armdrive.sim.wire import PacedDevice
from armdrive.sim.world.saved import Json
from armdrive.tasks import AlertKind
from armdrive.text.reading import parse_toml
from armdrive.trace.entries import EntryKind, TraceEntry
from armdrive.trace.files import Recording
from armdrive.trace.log import Parting, talk
from kinematics.errors import KinematicsError

# A simulated twin on simulated time, brought to where a recording begins, fed with its bytes.


Said = deque[tuple[float, Message]]

ANSWER_S = 2.0
"""A twin that stands has answered by then, or never will."""
MOTION_S = 300.0
"""So long its motions are waited for."""
_STALLED = 1000


class ReplayBench:
    """One twin. `late_s` is how far it has fallen behind the arm that was recorded.

    `passing` is the last of its reports that tell of a moment.
    """

    def __init__(self, config: ArmConfig, settings: Mapping[str, Value] | None = None) -> None:
        self.late_s = 0.0
        self.now_s = 0.0
        self._config = config
        self._settings = settings
        self._answers: Said = deque()
        self._banners: Said = deque()
        self.passing: Message | None = None
        self._passed_s = -math.inf
        self._splitter = talk(config.connection.dialect).splitter()
        self._make(None)

    @property
    def words(self) -> str:
        """The physical state of the twin in one line."""
        return state_line(self._device)

    @property
    def view(self) -> dict[str, Json]:
        """The physical state of the twin as plain data."""
        return state_json(self._device)

    @property
    def passing_s(self) -> float:
        """When that report came, on the recording's clock."""
        return self._passed_s - self.late_s

    @property
    def moving(self) -> bool:
        """Whether its motors turn."""
        return self._device.moving

    @property
    def registers(self) -> tuple[int, ...]:
        """What its controller would tell."""
        return tuple(self._device.registers)

    def place(self, registers: Sequence[int], position: Sequence[int] | None) -> None:
        """Have its controller count from there, and its motors stand at a position if one is known.

        Raises `RecordingError` for counts that such a controller cannot have.
        """
        saved = self._device.to_json()
        saved["registers"] = list(registers)
        world = saved["world"]
        if position is not None and isinstance(world, dict):
            world["motors"] = list(position)
        self._make({DIALECT: self._config.connection.dialect, **saved})
        self._answers.clear()
        self._banners.clear()
        self._line.advance(self.now_s)

    def send(self, data: bytes, time_s: float) -> None:
        """Give it bytes at a time of the recording."""
        self.advance(time_s)
        self._line.send(data, self.now_s)

    def advance(self, time_s: float) -> None:
        """Let it live up to a time of the recording."""
        self._live(time_s + self.late_s)

    def answer(self, time_s: float) -> Message | None:
        """Return its next answer, waiting for it beyond a time of the recording where it must.

        None where none comes. What it is late by is added to every time from then on.
        """
        return self._next(self._answers, time_s)

    def banner(self, time_s: float) -> Message | None:
        """Return its next banner in the same way."""
        return self._next(self._banners, time_s)

    def forget_banners(self) -> None:
        """Take no notice of how it began."""
        self._banners.clear()

    def stand(self, time_s: float) -> bool:
        """Let its motors come to rest, beyond a time of the recording where it must."""
        self.advance(time_s)
        due_s = self.now_s
        while self.moving and self.now_s < due_s + MOTION_S:
            self._live(max(min(self._line.next_s(), due_s + MOTION_S), self.now_s))
        self.late_s += self.now_s - due_s
        return not self.moving

    def unasked(self, before_s: float = math.inf) -> Message | None:
        """Return an answer from before a time that the recorded arm has not given."""
        if self._answers and self._answers[0][0] <= before_s + self.late_s:
            return self._answers[0][1]
        return None

    def _next(self, said: Said, time_s: float) -> Message | None:
        self.advance(time_s)
        due_s = self.now_s
        while not said and self._waits(due_s):
            self._live(min(max(self._line.next_s(), self.now_s), due_s + MOTION_S))
        if not said:
            return None
        self.late_s += self.now_s - due_s
        return said.popleft()[1]

    def _waits(self, due_s: float) -> bool:
        next_s = self._line.next_s()
        patient_s = MOTION_S if self.moving else ANSWER_S
        return max(next_s, self.now_s) < due_s + patient_s

    def _live(self, time_s: float) -> None:
        """Take what it says up to a time on its own clock, each thing at its moment."""
        idle = 0
        while (due_s := self._line.next_s()) < time_s and idle < _STALLED:
            idle = 0 if due_s > self.now_s else idle + 1
            self._take(max(due_s, self.now_s))
        self._take(max(time_s, self.now_s))

    def _take(self, now_s: float) -> None:
        self.now_s = now_s
        for message in self._splitter.feed(self._line.receive(now_s)):
            if message.weight in (Weight.ANSWER, Weight.MOMENT):
                self._answers.append((now_s, message))
            elif message.weight is Weight.BANNER:
                self._banners.append((now_s, message))
            elif message.weight is Weight.PASSING:
                self.passing, self._passed_s = message, now_s

    def _make(self, saved: object) -> None:
        try:
            self._device: SimDevice = simulate_device(self._config, saved, settings=self._settings)
        except BadRequest:  # a setting that the caller has chosen
            raise
        except (ArmError, KinematicsError, ArithmeticError, LookupError) as error:
            raise RecordingError(f"no twin can be made of the recorded arm: {error}") from None
        self._line = self._wire()

    def _wire(self) -> PacedDevice:
        network = "://" in self._config.connection.port
        if network and self._device.board.baud is not None:  # which keeps no pace
            return PacedDevice(self._device, None)
        return self._device.line()


# Where a twin has to stand for a recording: the counts, offsets and gaps in its entries.

Counts = tuple[int, ...]

_POSITIONED = ("referenced", "restored")
_COUNTS = re.compile(r"(-?[0-9]{1,9}(?: -?[0-9]{1,9})*)(?:;|$)")
_NO_COUNTS = (EntryKind.REQUEST, EntryKind.SILENCE, EntryKind.REPLY, EntryKind.LOST)


def counts_of(entry: TraceEntry) -> Counts:
    """Return the motors' counts that an entry begins with. Raises `RecordingError`."""
    found = _COUNTS.match(str(entry.what))
    if found is None:
        raise RecordingError(f"{entry.what!r:.60} stands where the counts of motors belong")
    return tuple(int(word) for word in found[1].split(" "))


def first_counts(entries: Sequence[TraceEntry]) -> Counts | None:
    """Return what the controller told first."""
    return next((counts_of(entry) for entry in entries if entry.kind is EntryKind.REGISTERS), None)


def first_offset(entries: Sequence[TraceEntry]) -> Counts | None:
    """Return what made counts a position when the position was first known."""
    offset = None
    for entry in entries:
        if entry.kind is EntryKind.OFFSET:
            offset = counts_of(entry)
        elif entry.kind is EntryKind.TRUST and str(entry.what).startswith(_POSITIONED):
            return offset
    return None


def offset_at(entries: Sequence[TraceEntry], index: int) -> Counts | None:
    """Return the offset at an entry, None where the position was not known by then."""
    known = first_offset(entries[:index])
    found = (entry for entry in reversed(entries[:index]) if entry.kind is EntryKind.OFFSET)
    latest = next(found, None)
    return None if known is None or latest is None else counts_of(latest)


def position(counts: Counts, offset: Counts | None) -> Counts | None:
    """Return where the motors are, None where that is not known."""
    if offset is None or len(offset) != len(counts):
        return None
    return tuple(a + b for a, b in zip(counts, offset, strict=True))


def gap(entries: Sequence[TraceEntry]) -> range:
    """Return which entries are not to be compared: from the first gap to where counts are read.

    There the twin can be put to where the arm stood. Empty where nothing is missing.
    """
    gaps = [index for index, entry in enumerate(entries) if entry.kind is EntryKind.GAP]
    if not gaps:
        return range(len(entries), len(entries))
    for index in range(gaps[-1], len(entries)):
        if answer_to(entries, index) is not None:
            return range(gaps[0], index)
    return range(gaps[0], len(entries))


def answer_to(entries: Sequence[TraceEntry], index: int) -> TraceEntry | None:
    """Return the counts that answer an entry, if it asks for them and gets them."""
    entry = entries[index]
    if entry.kind is not EntryKind.REQUEST or not str(entry.what).startswith("ReadPosition"):
        return None
    for later in range(index + 1, len(entries)):
        if entries[later].kind is EntryKind.REGISTERS:
            return entries[later]
        if entries[later].kind in _NO_COUNTS:
            return None
    return None


# Holding what an arm said beside what its twin says: the first difference is the parting.

GRACE_S = 1.0
"""An answer of the twin that the arm has not given by then, with nothing asked, is a difference."""
_APART = frozenset((Weight.PASSING, Weight.SELF))


class Judge:
    """Compares entry after entry, up to the first difference; `compared` counts what agreed."""

    def __init__(self, bench: ReplayBench, talk: Describer) -> None:
        self.compared = 0
        self.parting: Parting | None = None
        self._bench = bench
        self._talk = talk
        self._splitter = talk.splitter()
        self._told = False
        self._heard_s = 0.0
        self._passing: Message | None = None

    def resume(self) -> None:
        """Begin to listen behind a gap: a message that had begun before it is none."""
        self._splitter = self._talk.splitter()

    def heard(self, index: int, entry: TraceEntry, asked: str) -> None:
        """Compare the messages that the bytes of an entry complete."""
        data = entry.what if isinstance(entry.what, bytes) else b""
        for message in self._splitter.feed(data):
            self._heard_s = entry.time_s
            if message.weight is Weight.PASSING:
                self._passing = message
            beginning = message.weight is Weight.BANNER and not self._told
            if message.weight not in _APART and not beginning and self.parting is None:
                self._compare(index, entry, message, asked)

    def _compare(self, index: int, entry: TraceEntry, message: Message, asked: str) -> None:
        said = self._talk.said(message.data)
        banner = message.weight is Weight.BANNER
        answer = (self._bench.banner if banner else self._bench.answer)(entry.time_s)
        if answer is None:
            self._part(index, entry, "the arm said what the twin does not say", said, "nothing")
        elif not self._agrees(message, answer, asked):
            its = self._talk.said(answer.data)
            self._part(index, entry, "they answered otherwise", said, its)
        else:
            self.compared += 1

    def _agrees(self, message: Message, answer: Message, asked: str) -> bool:
        if message.data == answer.data or message.weight is Weight.BANNER:
            return True
        of_moment = message.weight is answer.weight is Weight.MOMENT
        turning = asked.startswith("Move") or self._bench.moving
        return of_moment and turning and message.kind == answer.kind

    def counts(self, index: int, entry: TraceEntry) -> None:
        """Compare the counts of motors that stand."""
        if not self._told:
            self._told = True
            self._bench.forget_banners()
        counts = counts_of(entry)
        stands = self._bench.stand(entry.time_s)
        twin = self._bench.registers
        if stands and counts == twin:
            self.compared += 1
            return
        why = "the motors were counted otherwise" if stands else "the twin still moves"
        self._part(index, entry, why, _words(counts), _words(twin))

    def silence(self, index: int, entry: TraceEntry) -> None:
        """Look whether the twin has spoken since the arm fell silent."""
        self._bench.advance(entry.time_s)
        self.unasked(index, entry, entry.time_s)
        said = self._bench.passing
        if said is not None and self._bench.passing_s > self._heard_s + GRACE_S / 4:
            why = f"the arm was silent from {self._heard_s:.3f} s on, and the twin was not"
            self._part(index, entry, why, str(entry.what), self._talk.said(said.data))

    def alerted(self, index: int, entry: TraceEntry) -> None:
        """Compare the last reports of a motion, where the arm's were of something else."""
        words = str(entry.what)
        ours, its = (
            "nothing" if each is None else self._talk.said(each.data)
            for each in (self._passing, self._bench.passing)
        )
        if words.startswith(AlertKind.RESTARTED.value):
            self._part(index, entry, "the arm began anew, the twin did not", words, its)
        elif words.startswith(AlertKind.ASTRAY.value) and ours != its:
            self._part(index, entry, "the arm was seen off the way that was sent", ours, its)

    def unasked(self, index: int, entry: TraceEntry, before_s: float) -> None:
        """Look whether the twin has said by then what the arm never said."""
        message = self._bench.unasked(before_s)
        if message is not None:
            silent = str(entry.what) if entry.kind is EntryKind.SILENCE else "nothing"
            its = self._talk.said(message.data)
            self._part(index, entry, "the twin said what the arm did not say", silent, its)

    def _part(self, index: int, entry: TraceEntry, why: str, arm: str, twin: str) -> None:
        if self.parting is None:
            bench = self._bench
            self.parting = Parting(index, entry.time_s, why, arm, twin, bench.words, bench.view)


def _words(counts: tuple[int, ...]) -> str:
    return " ".join(map(str, counts))


_ANSWERS = frozenset((EntryKind.REPLY, EntryKind.REGISTERS, EntryKind.SILENCE))


def config_of(recording: Recording) -> ArmConfig:
    """Return the arm of a recording as its own file there describes it. Raises `RecordingError`."""
    header = recording.header
    if not header.arm_file:
        raise RecordingError(
            "the recording holds no arm file, so that no simulated twin can be made of it; "
            "--show still prints it"
        )
    try:
        table = parse_toml(header.arm_file, RecordingError)
        with tempfile.TemporaryDirectory(prefix="armdrive-") as folder:
            _put_model(table, Path(folder), header.model_file)
            return parse_arm(table, name=header.arm, folder=Path(folder))
    except (ArmError, KinematicsError, OSError) as error:
        raise RecordingError(f"the recording's arm file cannot be used: {error}") from None


def _put_model(table: dict[str, Any], folder: Path, text: str) -> None:
    """Have the arm file name the model file that came with it, and no other."""
    word = table.get("model")
    if isinstance(word, str) and word.lower().endswith(MODEL_FILE):
        (folder / f"model{MODEL_FILE}").write_text(text, encoding="utf-8", errors="replace")
        table["model"] = f"model{MODEL_FILE}"


@dataclass(frozen=True, slots=True)
class Replayed:
    """What a replay found. `compared` counts the messages and counts that were held together."""

    compared: int
    late_s: float
    parting: Parting | None
    notes: tuple[str, ...]


def replay(recording: Recording, settings: Mapping[str, Value] | None = None) -> Replayed:
    """Replay a recording against the twin of its arm. Raises `RecordingError`."""
    config = config_of(recording)
    notes = []
    if config.calibration != recording.header.calibration:
        notes.append(
            "this armdrive understands the recorded arm file otherwise than the one that wrote it "
            f"({recording.header.version}): angles and positions of the twin may differ"
        )
    if recording.cut_off:
        notes.append("the recording's last line was cut off")
    return _Replay(recording, ReplayBench(config, settings), notes).run()


class _Replay:
    """One replay under way."""

    def __init__(self, recording: Recording, bench: ReplayBench, notes: list[str]) -> None:
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

    def _pass_over(self, entry: TraceEntry) -> None:
        """Have the twin hear settings that last; what it says to them is not compared."""
        if entry.kind is EntryKind.SENT and isinstance(entry.what, bytes):
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

    def _take(self, index: int, entry: TraceEntry) -> None:
        judge = self._judge
        if entry.kind is EntryKind.SENT and isinstance(entry.what, bytes):
            self._bench.send(entry.what, entry.time_s)
        elif entry.kind is EntryKind.HEARD:
            judge.heard(index, entry, self._asked)
        elif entry.kind is EntryKind.REQUEST:
            judge.unasked(index, entry, entry.time_s - GRACE_S)
            self._asked = str(entry.what)
        elif entry.kind is EntryKind.ALERT:
            judge.alerted(index, entry)
        elif entry.kind is EntryKind.REGISTERS:
            judge.counts(index, entry)
        elif entry.kind is EntryKind.SILENCE:
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


def replayed_view(recording: Recording, replayed: Replayed) -> dict[str, Any]:
    """Return what a replay found as plain data."""
    header, parting = recording.header, replayed.parting
    return {
        "arm": header.arm,
        "dialect": header.dialect,
        "link": header.link,
        "began": header.began,
        "why": header.why,
        "entries": len(recording.entries),
        "agree": parting is None,
        "compared": replayed.compared,
        "twin_late_s": round(replayed.late_s, 6),
        "notes": list(replayed.notes),
        "parting": None
        if parting is None
        else {
            "time_s": parting.time_s,
            "entry": parting.index,
            "why": parting.why,
            "arm": parting.arm,
            "twin": parting.twin,
            "twin_state": dict(parting.twin_view),
        },
    }
