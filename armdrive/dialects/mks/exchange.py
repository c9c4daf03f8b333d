"""Requests to MKS drives out, replies in, and what each reply shows to the observer.

A script sends one request to each of several drives at once and waits for all replies. A request
that is safe to repeat is sent again if its reply is missing, since frames can be lost.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Generator, Iterable, Mapping, Sequence
from typing import TypeAlias, TypeVar

from armdrive.dialects.bus.drives import ALL_SILENT, SURPLUS_LIMIT, absence
from armdrive.dialects.bus.questions import LAST_TRY_S
from armdrive.dialects.exchange import TRIES, Obstructed, ScriptIO
from armdrive.dialects.exchange import Script as ExchangeScript
from armdrive.dialects.mks.drive import MksDrive, setting_of
from armdrive.dialects.mks.observer import Observer
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
    EncoderRead,
    Event,
    Host,
    Motion,
    MoveAbsoluteAxis,
    Outcome,
    Read,
    ReadEncoder,
    Reading,
    ReadSetting,
    Setting,
    Status,
    Stop,
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

    def answered(self, node: int, code: int) -> None:
        """Record a reply, expected or not."""
        self._surplus[node, code] += 1

    def exceeds(self, node: int, code: int) -> bool:
        """Return whether there were more replies than questions."""
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
    """Sends requests to the drives and passes their replies to the observer."""

    look_at = ALL_SILENT

    def __init__(self, settings: MksSettings, names: Iterable[str]) -> None:
        super().__init__(self.unsolicited)
        self.host = Host(settings.ids)
        self.settings = settings
        named = zip(settings.ids, names, strict=True)
        self.observer = Observer([MksDrive(node, name, settings) for node, name in named])
        self.able = abilities_of(settings.version or LATEST)
        """The abilities that all drives have, as far as is known."""
        self.surplus = SurplusAnswers()
        self.garbled = 0
        """How many replies were unreadable."""

    @property
    def drives(self) -> tuple[MksDrive, ...]:
        """All drives, in motor order."""
        return self.observer.drives

    @property
    def under_way(self) -> tuple[MksDrive, ...]:
        """The drives with a target that were not seen to stand since."""
        return tuple(drive for drive in self.drives if drive.moving)

    def witness(self, others: Collection[MksDrive]) -> tuple[MksDrive, ...]:
        """Return a drive to ask along with others, or none; its reply shows that the bus works.

        Without it, drives that fall silent together look like a bus that does.
        """
        return tuple(drive for drive in self.drives if drive not in others)[:1]

    def drive(self, node: int) -> MksDrive:
        """Return a drive by its id."""
        return self.observer[node]

    # -- sending ------------------------------------------------------------------------------

    def put(self, drive: MksDrive, message: Message, text: str = "") -> None:
        """Send a request to a drive; an earlier one with the same code is no longer awaited."""
        self.write(self.host.send(drive.node, message), text)
        if drive.ledger.answers_orders or not isinstance(message, Motion):
            owes = isinstance(message, ReadEncoder | MoveAbsoluteAxis | Stop)
            self.observer.sent(drive, self.now_s, owes=owes)
        if isinstance(message, Read):
            self.surplus.asked(drive.node, message.code)
        if isinstance(message, ReadEncoder):
            drive.ledger.asked(self.now_s)

    def send(self, drive: MksDrive, order: MoveAbsoluteAxis) -> None:
        """Send a drive an order: target, speed and ramp."""
        self.put(drive, order)
        drive.follow(order, self.now_s)
        self.last_command = f"F5 to {' '.join(str(each.goal) for each in self.drives)}"

    def repeat(self, drive: MksDrive) -> None:
        """Send a moving drive its last order again, which is absolute."""
        if drive.moving and drive.last_order is not None:
            self.send(drive, drive.last_order)

    def give_up(self) -> None:
        """Give up all open requests."""
        for drive in self.drives:
            self.host.forget(drive.node)
        self.host.silence()

    # -- asking -------------------------------------------------------------------------------

    def ask(
        self,
        messages: Mapping[MksDrive, Message],
        *,
        tries: int = TRIES,
        text: str = "",
        patient: bool = True,
    ) -> MksScript[dict[MksDrive, Answer]]:
        """Send each drive its request; return the replies that came.

        A drive that does not reply is asked again at once. With `patient` the last of several tries
        waits longer.
        """
        found: dict[MksDrive, Answer] = {}
        for left in range(tries, 0, -1):
            missing = {drive: each for drive, each in messages.items() if drive not in found}
            if not missing:
                break
            for drive, message in missing.items():
                self.put(drive, message, text)
            patient_s = LAST_TRY_S if patient and left == 1 < tries else 0.0
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
            drive = self.observer.find(event.node) if isinstance(event, Answered) else None
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
        patient: bool = True,
    ) -> MksScript[dict[MksDrive, Answer]]:
        """Ask some drives, or all, the same question; return the answers that came."""
        asked = dict.fromkeys(self.drives if drives is None else drives, message)
        return (yield from self.ask(asked, tries=tries, patient=patient))

    def reading(
        self, drive: MksDrive, message: Read | ReadSetting, *, tries: int = TRIES
    ) -> MksScript[Answer | None]:
        """Ask one drive a question; None if it does not answer."""
        return (yield from self.read(message, (drive,), tries=tries)).get(drive)

    def setting(self, drive: MksDrive, code: Code) -> MksScript[Setting | None]:
        """Read one setting of a drive; None if it does not report it."""
        return setting_of((yield from self.reading(drive, ReadSetting(code))))

    def look(
        self, drives: Collection[MksDrive] | None = None, *, tries: int = TRIES
    ) -> MksScript[tuple[MksDrive, ...]]:
        """Read the positions of some drives, or all; return those that do not answer."""
        asked = self.drives if drives is None else tuple(drives)
        found = yield from self.read(ReadEncoder(), asked, tries=tries)
        return tuple(drive for drive in asked if drive not in found)

    def require_positions(self) -> MksScript[None]:
        """Read every position. Raises `Obstructed` if a drive does not answer."""
        began_s = self.now_s
        if missing := (yield from self.look()):
            raise Obstructed(self.absence(missing, began_s))

    # -- receiving ----------------------------------------------------------------------------

    def note(self, event: Answered) -> None:
        """Record what a message shows, expected or not."""
        drive = self.observer.find(event.node)
        if drive is None:
            return
        if isinstance(event.answer, Reading):
            self.surplus.answered(event.node, event.answer.code)
        self._note_reply(drive, event.answer)
        drive.note(event, self.now_s)
        if event.answer == Status(Code.ABSOLUTE_AXIS, Outcome.STORED) and drive.moving:
            self.put(drive, ArmSynchronous(on=False))  # another program has armed it
            if drive.last_order is not None:
                self.put(drive, drive.last_order)

    def unsolicited(self, event: Event) -> None:
        """Record a message that no script waits for, and warn if it is odd."""
        if not isinstance(event, Answered):
            self.garbled += isinstance(event, UnreadableFrame)
            self.notify(ProtocolWarning(plain(event)))
            return
        self.note(event)
        node, answer = event.node, event.answer
        if isinstance(answer, Reading) and self.surplus.exceeds(node, answer.code):
            self.notify(ProtocolWarning(f"drive {node} answered twice, or late: {plain(answer)}"))
        if isinstance(answer, Status) and self._is_odd(node, answer):
            self.notify(ProtocolWarning(f"drive {node}: {plain(answer)}"))

    def _is_odd(self, node: int, status: Status) -> bool:
        """Return whether a report that no script waits for may tell a person something."""
        if status.outcome is Outcome.LIMIT_STOP:
            return not self.drive(node).moving
        # F5 also fails if a newer order replaces it: see `MksDrive.rejected_s`
        return status.outcome is Outcome.FAILED and status.code is not Code.ABSOLUTE_AXIS

    def _note_reply(self, drive: MksDrive, answer: Answer) -> None:
        """Record that a reply came, and whether it is one of those that the drive owes."""
        status, ledger = isinstance(answer, Status), drive.ledger
        begun = isinstance(answer, Status) and answer.outcome in (Outcome.STARTED, Outcome.STORED)
        settles = isinstance(answer, EncoderRead) or (
            begun and answer.code is Code.ABSOLUTE_AXIS and ledger.answers_orders
        )
        drive.frame_s = self.now_s
        self.observer.replied(drive, self.now_s, settles=settles, asked=begun or not status)
        ledger.answers_orders = ledger.answers_orders or begun

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


def is_done(answer: Answer | None) -> bool:
    """Return whether a drive has answered that it did what it was asked to."""
    return isinstance(answer, Status) and answer.outcome is Outcome.DONE
