"""Requests to MKS drives out, replies in.

A script sends one request to each of several drives at once and waits for all replies. A request
that is safe to repeat is sent again if its reply is missing, since frames can be lost.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Generator, Iterable, Mapping, Sequence
from typing import TypeAlias, TypeVar

from armdrive.dialects.bus.drives import ALL_SILENT, LAST_TRY_S, SURPLUS_LIMIT, absence
from armdrive.dialects.bus.homing import HomingTimes
from armdrive.dialects.controller import HomingTime
from armdrive.dialects.exchange import TRIES, Obstructed, ScriptIO
from armdrive.dialects.exchange import Script as ExchangeScript
from armdrive.dialects.mks.drive import MksDrive, setting_of
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.words import plain
from armdrive.tasks import ProtocolWarning, Registers, Reply, RequestRejected, Timeout
from firmware_protocol.mks import (
    LATEST,
    Ability,
    Answer,
    Answered,
    ArmSynchronous,
    Code,
    Event,
    Host,
    MoveAbsoluteAxis,
    Outcome,
    Read,
    ReadEncoder,
    Reading,
    ReadSetting,
    Setting,
    SilenceWatchdog,
    Status,
    UnreadableFrame,
    abilities_of,
)
from firmware_protocol.mks import Request as Message
from kinematics.spaces import Motors

T = TypeVar("T")
# A script that asks MKS drives, with its result.
MksScript: TypeAlias = ExchangeScript[Event, T]
Script: TypeAlias = MksScript[Reply]

# Replies that a drive may still owe: more than that many were lost, and will not come.
MOST_OWED = 16
# How often drives are polled at least whose count could be that of a restarted one.
NEAR_ZERO_S = 0.1


class SurplusAnswers:
    """Counts by which number each drive's replies exceed the questions, by drive and code.

    A reply names its sender and the kind of its question, not the question. The questions are
    counted for as long as replies come, so late ones are no surplus: those are of a second drive
    with the same id. Every drive is shipped with id 1.
    """

    def __init__(self) -> None:
        self._surplus: Counter[tuple[int, int]] = Counter()

    def asked(self, node: int, code: int) -> None:
        """Record a question that has one reply."""
        self._surplus[node, code] = max(self._surplus[node, code] - 1, -MOST_OWED)

    def answered(self, node: int, code: int) -> bool:
        """Record a reply; return whether there were more replies than questions."""
        self._surplus[node, code] += 1
        return self._surplus[node, code] > 0

    def clear(self) -> None:
        """Start counting from zero."""
        self._surplus.clear()

    @property
    def shared(self) -> tuple[int, ...]:
        """The ids that more than one drive has replied to."""
        over = {node for (node, _), more in self._surplus.items() if more >= SURPLUS_LIMIT}
        return tuple(sorted(over))

    def owed_by(self, node: int, code: int) -> int:
        """Return how many questions to a drive were not answered."""
        return max(-self._surplus[node, code], 0)

    @property
    def owed(self) -> bool:
        """Whether a question is still open."""
        return any(more < 0 for more in self._surplus.values())


class MksExchange(ScriptIO[Event]):
    """Sends requests to the drives and records what their replies tell."""

    look_at = ALL_SILENT

    def __init__(
        self,
        settings: MksSettings,
        names: Iterable[str],
        ramp_s: float = 0.0,
        ranges: Sequence[float] = (),
    ) -> None:
        super().__init__(self.unsolicited)
        self.host = Host(settings.ids)
        self.settings, self.ramp_s = settings, ramp_s
        """The arm file's section, and how long the fastest drive brakes."""
        named = zip(settings.ids, names, strict=True)
        self.drives = tuple(MksDrive(node, name, settings) for node, name in named)
        """All drives, in motor order."""
        assumed = HomingTime(settings.homing_s, "mks.homing_s")
        self.homing = HomingTimes(self.drives, ranges, assumed)
        self._by_id = {drive.node: drive for drive in self.drives}
        self.able = abilities_of(settings.version or LATEST)
        """The abilities that all drives have, as far as is known."""
        self.connected = False
        """Whether all drives were found standing."""
        self.on = False
        """Whether all drives were switched on."""
        self.watchdog = SilenceWatchdog(round(settings.watchdog_s * 1000.0))
        self.watched = False
        """Whether every drive is known to stop on a silent bus."""
        self.firmware = ""
        """The oldest firmware of all drives; empty before the first contact."""
        self.underruns = 0
        """How often drives stood still although more of their motion was to come."""
        self.surplus = SurplusAnswers()
        self.garbled = 0
        """How many replies were unreadable."""

    def find(self, node: int | None) -> MksDrive | None:
        """Return a drive by its id, or None."""
        return None if node is None else self._by_id.get(node)

    def drive(self, node: int) -> MksDrive:
        """Return a drive by its id."""
        return self._by_id[node]

    # -- sending ------------------------------------------------------------------------------

    def put(self, drive: MksDrive, message: Message, text: str = "") -> None:
        """Send a request to a drive; an earlier one with the same code is no longer awaited."""
        self.write(self.host.send(drive.node, message), text)
        if isinstance(message, Read):
            self.surplus.asked(drive.node, message.code)
        if isinstance(message, ReadEncoder):
            drive.questions.ask(self.now_s, self.listened.s)

    def send(self, drive: MksDrive, order: MoveAbsoluteAxis) -> None:
        """Send a drive an order: target, speed and ramp."""
        self.put(drive, order)
        drive.follow(order, self.now_s)
        self.last_command = f"F5 to {' '.join(str(each.target) for each in self.drives)}"

    def poll(self, drives: Iterable[MksDrive], period_s: float) -> float:
        """Ask for the positions that are due; return when the next one is."""
        due_s = []
        for drive in drives:
            each_s = period_s if drive.is_far else min(period_s, NEAR_ZERO_S)
            if drive.questions.next_s(each_s) <= self.now_s:
                self.put(drive, ReadEncoder())
            due_s.append(drive.questions.next_s(each_s))
        return min(due_s)

    def give_up(self) -> None:
        """Give up all open requests."""
        for drive in self.drives:
            self.host.forget(drive.node)
            drive.questions.clear()
        self.host.silence()

    # -- asking -------------------------------------------------------------------------------

    def hear(self, until_s: float) -> Generator[float, Event | None, None]:
        """Wait for a moment, a stop or a reply; take every reply that has arrived.

        A late program reads all that arrived before it judges any drive.
        """
        event = yield until_s
        while event is not None:
            self.unsolicited(event)
            event = yield self.now_s

    def ask(
        self,
        messages: Mapping[MksDrive, Message],
        *,
        tries: int = TRIES,
        text: str = "",
    ) -> MksScript[dict[MksDrive, Answer]]:
        """Send each drive its request; return the replies that came.

        A drive that does not reply is asked again at once. The last of several tries waits longer.
        """
        found: dict[MksDrive, Answer] = {}
        for left in range(tries, 0, -1):
            missing = {drive: each for drive, each in messages.items() if drive not in found}
            if not missing:
                break
            for drive, message in missing.items():
                self.put(drive, message, text)
            patient_s = LAST_TRY_S if left == 1 < tries else 0.0
            yield from self._collect(missing, found, patient_s)
        return found

    def _collect(
        self,
        wanted: Mapping[MksDrive, Message],
        found: dict[MksDrive, Answer],
        patient_s: float,
    ) -> Generator[float, Event | None, None]:
        until_s = self.now_s + self.settings.answer_s + patient_s
        left = set(wanted)
        while left:  # a late computer reads everything that arrived in time before it gives up
            event = yield until_s
            if event is None:
                if self.now_s >= until_s:
                    return
                continue
            drive = self.find(event.node) if isinstance(event, Answered) else None
            if isinstance(event, Answered) and drive in left and event.request == wanted[drive]:
                self.note(event)
                found[drive] = event.answer
                left.discard(drive)
            else:
                self.unsolicited(event)

    def read(
        self,
        message: Read | ReadSetting,
        drives: Collection[MksDrive] | None = None,
        *,
        tries: int = TRIES,
    ) -> MksScript[dict[MksDrive, Answer]]:
        """Ask some drives, or all, the same question; return the answers that came."""
        asked = dict.fromkeys(self.drives if drives is None else drives, message)
        return (yield from self.ask(asked, tries=tries))

    def reading(
        self, drive: MksDrive, message: Read | ReadSetting, *, tries: int = TRIES
    ) -> MksScript[Answer | None]:
        """Ask one drive a question; None if it does not answer."""
        return (yield from self.read(message, (drive,), tries=tries)).get(drive)

    def setting(self, drive: MksDrive, code: Code) -> MksScript[Setting | None]:
        """Read one setting of a drive; None if it does not report it."""
        return setting_of((yield from self.reading(drive, ReadSetting(code))))

    def look(self, drives: Collection[MksDrive] | None = None) -> MksScript[tuple[MksDrive, ...]]:
        """Read the positions of some drives, or all; return those that do not answer."""
        asked = self.drives if drives is None else tuple(drives)
        found = yield from self.read(ReadEncoder(), asked)
        return tuple(drive for drive in asked if drive not in found)

    def require_positions(self) -> MksScript[None]:
        """Read every position. Raises `Obstructed` if a drive does not answer."""
        began_s = self.now_s
        if missing := (yield from self.look()):
            raise Obstructed(self.absence(missing, began_s))

    # -- receiving ----------------------------------------------------------------------------

    def note(self, event: Answered) -> bool:
        """Record what a message tells; return whether it is a reply too many."""
        drive, answer = self.find(event.node), event.answer
        if drive is None:
            return False
        drive.note(answer, self.now_s, self.listened.s)
        if answer == Status(Code.ABSOLUTE_AXIS, Outcome.STORED):
            # another program has armed it for a common start
            self.put(drive, ArmSynchronous(on=False))
            if drive.order is not None:
                self.put(drive, drive.order)
        return isinstance(answer, Reading) and self.surplus.answered(event.node, answer.code)

    def unsolicited(self, event: Event) -> None:
        """Record a message that no script waits for, and warn if it is odd."""
        if not isinstance(event, Answered):
            self.garbled += isinstance(event, UnreadableFrame)
            self.notify(ProtocolWarning(plain(event)))
            return
        node, answer = event.node, event.answer
        if self.note(event):
            self.notify(ProtocolWarning(f"drive {node} answered twice, or late: {plain(answer)}"))
        # F5 is also reported as failed if a newer order replaces it
        failed = isinstance(answer, Status) and answer.outcome is Outcome.FAILED
        if failed and answer.code is not Code.ABSOLUTE_AXIS:
            self.notify(ProtocolWarning(f"drive {node}: {plain(answer)}"))

    # -- replies ------------------------------------------------------------------------------

    def registers(self) -> Registers:
        """Return the last positions of the drives' encoders."""
        return Registers(Motors(drive.register for drive in self.drives))

    def absence(self, missing: Sequence[MksDrive], since_s: float) -> Timeout | RequestRejected:
        """Return the reply that names missing drives."""
        return absence(missing, self.drives, "id", self.silence(since_s))

    def can(self, ability: Ability) -> bool:
        """Return whether all drives have an ability."""
        return ability in self.able

    @property
    def watchable(self) -> bool:
        """Whether the arm file wants a watchdog that the firmware has."""
        return bool(self.watchdog.timeout_ms) and self.can(Ability.SILENCE_WATCHDOG)


def is_done(answer: Answer | None) -> bool:
    """Return whether a drive has answered that it did what it was asked to."""
    return isinstance(answer, Status) and answer.outcome is Outcome.DONE
