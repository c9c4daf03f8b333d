"""Replay: feed a recording to a simulated device and find the first difference from the real arm.

The simulated device receives the recorded bytes at their recorded times. Its replies are compared
with the arm's replies, message by message, and its position counts with the arm's wherever those
were read at rest. Only the content counts, not the speed: if the simulated device is slower than
the arm was, everything after that is fed to it later, so that no message reaches a busy device that
reached an idle one in the recording.
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

from armdrive.config.arm import ArmConfig
from armdrive.config.sections import is_model_file
from armdrive.dialects.words import Message, Weight
from armdrive.errors import ArmError, BadRequest, RecordingError
from armdrive.errors.printable import reason_of
from armdrive.registry import simulated_kind
from armdrive.registry.arm_files import parse_arm
from armdrive.sim.device import SimDevice, Value, state_json, state_line
from armdrive.sim.simulated_arm import DIALECT
from armdrive.sim.wire import DeviceLine
from armdrive.status import BELIEVED_WORDS
from armdrive.tasks import AlertKind
from armdrive.text.reading import parse_toml
from armdrive.trace.entries import EntryKind, TraceEntry, counts_text
from armdrive.trace.files import Recording
from armdrive.trace.log import Divergence, describer
from kinematics.errors import KinematicsError

# The messages that are compared. A restart is noticed by its alert, so its banner is left out.
_COMPARED = frozenset((Weight.ANSWER, Weight.MOMENT))

# The simulated device, on simulated time.

ANSWER_S = 2.0  # a simulated device at rest has answered by then, or never will
MOTION_S = 300.0  # longest motion to wait for
TAKEN_S = 0.1  # a device has taken a message by then: the time kept between those around a gap
_STALLED = 1000  # wake-ups without progress after which the device is left alone


class ReplayBench:
    """The simulated device of a replay.

    `late_s` is its delay against the recording; `passing` is its latest progress report. `device`
    changes when the simulated device is placed somewhere else. The times of all calls are those of
    the recording.
    """

    def __init__(self, config: ArmConfig, settings: Mapping[str, Value] | None = None) -> None:
        self.late_s = 0.0
        self.now_s = 0.0
        self._config = config
        self._settings = settings
        self._answers: deque[tuple[float, Message]] = deque()
        self.passing: Message | None = None
        self._passed_s = -math.inf
        self._skipped_s = 0.0
        self.describer = describer(config.connection.dialect)
        self._splitter = self.describer.splitter()
        self._make(None)

    @property
    def passing_s(self) -> float:
        """Time of the latest progress report."""
        return self._passed_s + self._skipped_s - self.late_s

    def place(self, registers: Sequence[int], position: Sequence[int] | None) -> None:
        """Set the controller's registers and, if it is known, the position of the motors.

        Raises `RecordingError` for counts that such a controller cannot have.
        """
        saved = self.device.to_json()
        saved["registers"] = list(registers)
        world = saved["world"]
        if position is not None and isinstance(world, dict):
            world["motors"] = list(position)
        self._make({DIALECT: self._config.connection.dialect, **saved})
        self._answers.clear()
        self._line.advance(self.now_s)

    def skip_to(self, time_s: float) -> None:
        """Leave out the time of missing entries, in which a device would miss heartbeats."""
        self._skipped_s += max(self._own_s(time_s) - self.now_s - TAKEN_S, 0.0)

    def _own_s(self, time_s: float) -> float:
        """Return a time of the recording on the device's own clock."""
        return time_s - self._skipped_s + self.late_s

    def send(self, data: bytes, time_s: float) -> None:
        """Send bytes to the device."""
        self.advance(time_s)
        self._line.send(data, self.now_s)

    def advance(self, time_s: float) -> None:
        """Run the device up to a time."""
        self._run(self._own_s(time_s))

    def answer(self, time_s: float) -> Message | None:
        """Return the next answer, which may come after a time; None without one.

        The delay is added to every later time.
        """
        self.advance(time_s)
        due_s = self.now_s
        while not self._answers and self._may_come(due_s):
            self._run(min(max(self._line.next_s(), self.now_s), due_s + MOTION_S))
        if not self._answers:
            return None
        self.late_s += self.now_s - due_s
        return self._answers.popleft()[1]

    def stand(self, time_s: float) -> bool:
        """Run the device until its motors rest, at least up to a time; return whether they do."""
        self.advance(time_s)
        due_s = self.now_s
        while self.device.moving and self.now_s < due_s + MOTION_S:
            self._run(max(min(self._line.next_s(), due_s + MOTION_S), self.now_s))
        self.late_s += self.now_s - due_s
        return not self.device.moving

    def extra_answer(self, before_s: float = math.inf) -> Message | None:
        """Return an answer from before a time that the recorded arm has not given, if any."""
        if self._answers and self._answers[0][0] <= self._own_s(before_s):
            return self._answers[0][1]
        return None

    def _may_come(self, due_s: float) -> bool:
        """Return whether a message due at a time may still come."""
        timeout_s = MOTION_S if self.device.moving else ANSWER_S
        return max(self._line.next_s(), self.now_s) < due_s + timeout_s

    def _run(self, time_s: float) -> None:
        """Run the device up to a time on its own clock, and take each message when it is sent."""
        idle = 0
        # a broken device may ask to be called at the same moment for ever
        while (due_s := self._line.next_s()) < time_s and idle < _STALLED:
            idle = 0 if due_s > self.now_s else idle + 1
            self._take(max(due_s, self.now_s))
        self._take(max(time_s, self.now_s))

    def _take(self, now_s: float) -> None:
        self.now_s = now_s
        for message in self._splitter.feed(self._line.receive(now_s)):
            if message.weight in _COMPARED:
                self._answers.append((now_s, message))
            elif message.weight is Weight.PASSING:
                self.passing, self._passed_s = message, now_s

    def _make(self, saved: object) -> None:
        try:
            kind = simulated_kind(self._config.connection.dialect)
            twin = kind.simulate(self._config, saved, settings=self._settings)
        except BadRequest:  # a setting that the caller has chosen
            raise
        except (ArmError, KinematicsError, ArithmeticError, LookupError) as error:
            raise RecordingError(f"the recorded arm cannot be simulated: {error}") from None
        self.device: SimDevice = twin.device
        self._line = self._wire()

    def _wire(self) -> DeviceLine:
        network = "://" in self._config.connection.port
        if network and self.device.board.baud is not None:  # which keeps no pace
            return DeviceLine(self.device, None)
        return self.device.line()


# The position counts, offsets and gaps in the entries of a recording.

Counts = tuple[int, ...]

_COUNTS = re.compile(r"(-?[0-9]{1,9}(?: -?[0-9]{1,9})*)(?:;|$)")


def counts_of(entry: TraceEntry) -> Counts:
    """Return the motor counts at the start of an entry. Raises `RecordingError`."""
    found = _COUNTS.match(str(entry.what))
    if found is None:
        raise RecordingError(f"{entry.what!r:.60} does not begin with the motors' counts")
    return tuple(int(word) for word in found[1].split(" "))


def offset_at(entries: Sequence[TraceEntry], index: int) -> Counts | None:
    """Return the reference offset at an entry; if it was not known yet, at the next motion.

    A position is believed before its offset is taken up, or at once with it.
    """
    offset, known = None, False
    for at, entry in enumerate(entries):
        begins = entry.kind is EntryKind.REQUEST and str(entry.what).startswith("Move")
        if known and (at == index or (at > index and begins)):
            break
        if entry.kind is EntryKind.OFFSET:
            offset = counts_of(entry)
        elif entry.kind is EntryKind.TRUST:
            known = known or str(entry.what).startswith(BELIEVED_WORDS)
    return offset if known else None


def position(counts: Counts, offset: Counts | None) -> Counts | None:
    """Return the position of the motors, or None if it is not known."""
    if offset is None or len(offset) != len(counts):
        return None
    return tuple(a + b for a, b in zip(counts, offset, strict=True))


def next_counts(entries: Sequence[TraceEntry], index: int) -> int:
    """Return the index of the first counts that the controller reported from an entry on."""
    found = (at for at in range(index, len(entries)) if entries[at].kind is EntryKind.REGISTERS)
    return next(found, len(entries))


def gap(entries: Sequence[TraceEntry]) -> range:
    """Return the entries that cannot be compared: from the first gap to the next counts.

    Those counts tell where to place the simulated device. The range is empty without a gap.
    """
    gaps = [index for index, entry in enumerate(entries) if entry.kind is EntryKind.DROPPED]
    if not gaps:
        return range(len(entries), len(entries))
    return range(gaps[0], next_counts(entries, gaps[-1]) + 1)


# The replay itself: the messages of the arm and of the simulated device are compared.

GRACE_S = 1.0  # an unrequested answer of the simulated device this long before the arm's differs
_REPLIES = frozenset((EntryKind.REPLY, EntryKind.REGISTERS, EntryKind.TIMEOUT))


def config_of(recording: Recording) -> ArmConfig:
    """Return the arm that the header of a recording describes. Raises `RecordingError`."""
    header = recording.header
    if not header.arm_file:
        raise RecordingError(
            "the recording contains no arm file, so it cannot be replayed; `armdrive log` prints it"
        )
    try:
        table = parse_toml(header.arm_file, RecordingError)
        with tempfile.TemporaryDirectory(prefix="armdrive-") as folder:
            _put_model(table, Path(folder), header.model_file)
            return parse_arm(table, name=header.arm, folder=Path(folder))
    except (ArmError, KinematicsError, OSError) as error:
        raise RecordingError(
            f"the recording's arm file cannot be used: {reason_of(error)}"
        ) from None


def _put_model(table: dict[str, Any], folder: Path, text: str) -> None:
    """Write the recorded model file into a folder and make the arm file name that one."""
    word = table.get("model")
    if isinstance(word, str) and is_model_file(word):
        place = folder / f"model{Path(word).suffix}"
        place.write_text(text, encoding="utf-8", errors="replace")
        table["model"] = place.name


@dataclass(frozen=True, slots=True)
class Replayed:
    """The result of a replay. `compared` counts the messages and positions that agreed."""

    compared: int
    late_s: float
    divergence: Divergence | None
    notes: tuple[str, ...]


def replay(recording: Recording, settings: Mapping[str, Value] | None = None) -> Replayed:
    """Replay a recording against a simulated device of its arm. Raises `RecordingError`.

    All times of the result are seconds since the connection, as in the log.
    """
    config = config_of(recording)
    notes = []
    if config.calibration != recording.header.calibration:
        notes.append(
            f"armdrive {recording.header.version}, which wrote the recording, read the arm file "
            "differently: the simulated angles and positions may differ"
        )
    if recording.cut_off:
        notes.append("the last line of the recording is incomplete and was ignored")
    began_s = recording.header.began_s
    entries = tuple(entry._replace(time_s=entry.time_s - began_s) for entry in recording.entries)
    return _Replay(entries, ReplayBench(config, settings), notes).run()


class _Replay:
    """A replay in progress: it compares entries up to the first difference."""

    def __init__(
        self, entries: tuple[TraceEntry, ...], bench: ReplayBench, notes: list[str]
    ) -> None:
        self._entries = entries
        self._bench = bench
        self._notes = notes
        self._index = 0  # of the entry at work
        self._request = ""  # the request that has no reply yet
        self._compared = 0
        self._divergence: Divergence | None = None
        self._describer = bench.describer
        self._splitter = bench.describer.splitter()
        self._received_s = 0.0
        self._passing: Message | None = None

    def run(self) -> Replayed:
        """Process all entries up to the first difference."""
        missing = gap(self._entries)
        comparable = missing.stop <= len(self._entries)  # counts follow the gap, if there is one
        self._place(0)
        for index in range(len(self._entries)):
            self._index = index
            if index in missing:
                self._pass_over()
                if index == missing[-1]:
                    self._compare_again()
                continue
            self._take()
            if self._divergence is not None:
                break
        else:
            if comparable:
                self._end()
        if not comparable:
            self._notes.append("entries are missing, and the rest cannot be compared")
        return Replayed(self._compared, self._bench.late_s, self._divergence, tuple(self._notes))

    # -- where the simulated device stands ------------------------------------------------------

    def _place(self, index: int) -> None:
        """Place the simulated device where the arm stood, as far as the recording shows."""
        at, offset = next_counts(self._entries, index), offset_at(self._entries, index)
        if at == len(self._entries):
            self._notes.append(
                "the arm never reported its position: the simulated device starts anywhere"
            )
            return
        counts = counts_of(self._entries[at])
        self._bench.place(counts, position(counts, offset))
        if offset is None:
            self._notes.append(
                "the arm's position was never known: the simulated device starts anywhere"
            )

    def _pass_over(self) -> None:
        """Send the device what it was sent, such as a lasting setting, and compare no answer."""
        entry = self._entry
        if entry.kind is EntryKind.DROPPED:
            self._bench.skip_to(entry.time_s)
        elif entry.kind is EntryKind.SENT and isinstance(entry.what, bytes):
            self._bench.skip_to(entry.time_s)
            self._bench.send(entry.what, entry.time_s)

    def _compare_again(self) -> None:
        """Begin to compare again, at the first counts after missing entries."""
        time_s = self._entry.time_s
        self._bench.skip_to(time_s)
        self._bench.stand(time_s)
        self._place(self._index)
        self._splitter = self._describer.splitter()  # a message from before the gap is incomplete
        self._request = ""
        self._notes.append(f"entries are missing: the comparison starts again at {time_s:.3f} s")

    # -- entries --------------------------------------------------------------------------------

    def _take(self) -> None:
        entry = self._entry
        if entry.kind is EntryKind.SENT and isinstance(entry.what, bytes):
            self._bench.send(entry.what, entry.time_s)
        elif entry.kind is EntryKind.RECEIVED:
            self._received()
        elif entry.kind is EntryKind.REQUEST:
            self._extra_answer(entry.time_s - GRACE_S)
            self._request = str(entry.what)
        elif entry.kind is EntryKind.ALERT:
            self._alerted()
        elif entry.kind is EntryKind.REGISTERS:
            self._counts()
        elif entry.kind is EntryKind.TIMEOUT:
            self._timed_out()
        if entry.kind in _REPLIES:
            self._request = ""

    def _end(self) -> None:
        """Check for extra answers, unless the arm's last answer is missing from the recording."""
        if not self._entries or self._request:
            return
        last_s = self._entries[-1].time_s
        self._bench.advance(last_s)
        self._extra_answer(last_s - GRACE_S)

    # -- comparing -----------------------------------------------------------------------------

    def _received(self) -> None:
        """Compare the messages that the bytes of an entry complete."""
        entry = self._entry
        data = entry.what if isinstance(entry.what, bytes) else b""
        for message in self._splitter.feed(data):
            self._received_s = entry.time_s
            if message.weight is Weight.PASSING:
                self._passing = message
            if message.weight in _COMPARED and self._divergence is None:
                self._compare(message)

    def _compare(self, message: Message) -> None:
        arm = self._describer.said(message.data)
        answer = self._bench.answer(self._entry.time_s)
        if answer is None:
            why = "the arm sent a message that the simulated device did not send"
            self._differ(why, arm, "nothing")
        elif not self._agrees(message, answer):
            self._differ("the answers differ", arm, self._describer.said(answer.data))
        else:
            self._compared += 1

    def _agrees(self, message: Message, answer: Message) -> bool:
        if message.data == answer.data:
            return True
        momentary = message.weight is answer.weight is Weight.MOMENT
        moving = self._request.startswith("Move") or self._bench.device.moving
        return momentary and moving and message.kind == answer.kind

    def _counts(self) -> None:
        """Compare the counts of motors at rest."""
        counts = counts_of(self._entry)
        at_rest = self._bench.stand(self._entry.time_s)
        twin = tuple(self._bench.device.registers)
        if at_rest and counts == twin:
            self._compared += 1
            return
        why = "the motor counts differ" if at_rest else "the simulated device still moves"
        self._differ(why, counts_text(counts), counts_text(twin))

    def _timed_out(self) -> None:
        """Check that the simulated device has been as silent as the arm was."""
        entry = self._entry
        self._bench.advance(entry.time_s)
        self._extra_answer(entry.time_s)
        report = self._bench.passing
        if report is not None and self._bench.passing_s > self._received_s + GRACE_S / 4:
            why = (
                f"the arm was silent from {self._received_s:.3f} s on; the simulated device was not"
            )
            self._differ(why, str(entry.what), self._describer.said(report.data))

    def _alerted(self) -> None:
        """Compare the latest progress reports, if the arm's raised an alert."""
        text = str(self._entry.what)
        arm, twin = (
            "nothing" if each is None else self._describer.said(each.data)
            for each in (self._passing, self._bench.passing)
        )
        if text.startswith(AlertKind.RESTARTED.value):
            why = "the arm restarted; the simulated device did not"
            self._differ(why, text, twin)
        elif text.startswith(AlertKind.OFF_PATH.value) and arm != twin:
            self._differ("the arm was off the commanded path", arm, twin)

    def _extra_answer(self, before_s: float) -> None:
        """Check that the simulated device has sent no answer that the arm never sent."""
        message = self._bench.extra_answer(before_s)
        if message is not None:
            timeout = self._entry.kind is EntryKind.TIMEOUT
            arm = str(self._entry.what) if timeout else "nothing"
            why = "the simulated device sent a message that the arm did not send"
            self._differ(why, arm, self._describer.said(message.data))

    def _differ(self, why: str, arm: str, twin: str) -> None:
        if self._divergence is None:
            device, time_s = self._bench.device, self._entry.time_s
            self._divergence = Divergence(
                self._index, time_s, why, arm, twin, state_line(device), state_json(device)
            )

    @property
    def _entry(self) -> TraceEntry:
        return self._entries[self._index]


def replayed_view(recording: Recording, replayed: Replayed) -> dict[str, Any]:
    """Return the result of a replay as plain data."""
    header, parting = recording.header, replayed.divergence
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
