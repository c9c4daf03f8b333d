"""Requests to MKS drives out, replies in, and what each reply shows to the observer.

A script sends one request to each of several drives at once and waits for all replies. A request
that is safe to repeat is sent again if its reply is missing, since frames can be lost.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Iterable, Mapping, Sequence
from typing import TypeAlias, TypeVar

from armdrive.dialects.bus.drives import ALL_SILENT, absence
from armdrive.dialects.bus.questions import LAST_TRY_S
from armdrive.dialects.exchange import TRIES, Obstructed, ScriptIO
from armdrive.dialects.exchange import Script as ExchangeScript
from armdrive.dialects.mks.drive import Answer, MksDrive, setting_of
from armdrive.dialects.mks.observer import Observer
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.surplus import LateReplies, SurplusAnswers
from armdrive.dialects.words import plain
from armdrive.tasks import ProtocolWarning, Registers, Reply, RequestRejected, Timeout
from firmware_protocol.mks import (
    LATEST,
    MOTION_CODES,
    Ability,
    Answered,
    ArmSynchronous,
    Code,
    Done,
    EncoderRead,
    Event,
    Failed,
    Foreign,
    Host,
    LimitStop,
    Motion,
    MoveAbsoluteAxis,
    Outcome,
    Overrun,
    Read,
    ReadEncoder,
    Reading,
    ReadSetting,
    Setting,
    Started,
    Status,
    Stop,
    StoredForStart,
    Stray,
    UnreadableFrame,
    abilities_of,
)
from firmware_protocol.mks import Request as Message
from firmware_protocol.mks.requests import answer_code
from kinematics.spaces import Motors

T = TypeVar("T")
MksScript: TypeAlias = ExchangeScript[Event, T]
"""A script that asks MKS drives, with its result."""
Script: TypeAlias = MksScript[Reply]


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
        self._late = LateReplies()

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
        """Send a request to a drive, and give up earlier ones whose reply would look the same.

        Motions may follow each other unanswered, so of these only an identical one is given up. A
        new target also gives up earlier targets, which will not be answered any more.
        """
        for earlier in self.host.unanswered(drive.node):
            alike = answer_code(earlier) == answer_code(message) and not isinstance(message, Motion)
            replaced = isinstance(earlier, MoveAbsoluteAxis) and isinstance(
                message, MoveAbsoluteAxis
            )
            if earlier == message or alike or replaced:
                self._give_up(drive, earlier)
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
            for request in self.host.unanswered(drive.node):
                self._give_up(drive, request)
            self.host.forget(drive.node)
        self.host.silence()

    def _give_up(self, drive: MksDrive, request: Message) -> None:
        """Give up one request: its reply will count as late."""
        self.host.forget(drive.node, request)
        if not isinstance(request, Motion):
            self._late.give_up(drive.node, answer_code(request), self.now_s)

    # -- asking -------------------------------------------------------------------------------

    def ask(
        self,
        messages: Mapping[MksDrive, Message],
        *,
        tries: int = TRIES,
        text: str = "",
        patient: bool = True,
    ) -> MksScript[dict[MksDrive, Event]]:
        """Send each drive its request; return the replies that came.

        A drive that does not reply is asked again at once. With `patient` the last of several tries
        waits longer.
        """
        found: dict[MksDrive, Event] = {}
        for left in range(tries, 0, -1):
            missing = {drive: each for drive, each in messages.items() if drive not in found}
            if not missing:
                break
            for drive, message in missing.items():
                self.put(drive, message, text)
            patient_s = LAST_TRY_S if patient and left == 1 < tries else 0.0
            yield from self._collect(missing, found, patient_s)
            for drive, message in missing.items():
                if drive not in found and message in self.host.unanswered(drive.node):
                    self._give_up(drive, message)
        return found

    def _collect(
        self,
        wanted: Mapping[MksDrive, Message],
        found: dict[MksDrive, Event],
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
            drive = self._sender(event)
            answers = isinstance(event, Answered | Done | Failed | Started | StoredForStart)
            if answers and drive in left and event.request == wanted[drive]:  # type: ignore[union-attr]
                self.note(event)
                found[drive] = event
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
        found = yield from self.ask(asked, tries=tries, patient=patient)
        return {drive: each.answer for drive, each in found.items() if isinstance(each, Answered)}

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

    def _sender(self, event: Event) -> MksDrive | None:
        """Return the drive that a message is from; None if it is from none of this arm."""
        return self.observer.find(getattr(event, "node", None))

    def note(self, event: Event) -> None:
        """Record what a message shows, expected or not."""
        drive = self._sender(event)
        if drive is None:
            return
        self._note_reply(drive, event)
        drive.note(event, self.now_s)
        match event:
            case StoredForStart(_, MoveAbsoluteAxis() as order) if drive.moving:
                self.put(drive, ArmSynchronous(on=False))  # another program has armed it
                if drive.last_order is not None:
                    self.put(drive, order)

    def _note_reply(self, drive: MksDrive, event: Event) -> None:
        """Record that a message came, and which open question or order it can be the reply to."""
        if isinstance(event, Answered | Stray) and isinstance(event.answer, Reading):
            self.surplus.answered(event.node, event.answer.code)
        drive.frame_s = self.now_s
        ledger, asked = drive.ledger, not isinstance(event, Done | Failed | LimitStop)
        settles = _settles(event, answers_orders=ledger.answers_orders)
        self.observer.replied(drive, self.now_s, settles=settles, asked=asked)
        ledger.answers_orders = ledger.answers_orders or isinstance(event, Started)

    def unsolicited(self, event: Event) -> None:
        """Record a message that no script waits for, and warn if it is odd."""
        self.note(event)
        self.garbled += isinstance(event, UnreadableFrame)
        match event:
            case Stray(node, answer) if self._late.takes(node, answer.code, self.now_s):
                pass
            case Failed(_, MoveAbsoluteAxis()):
                pass  # for this order or the one it replaced: see `drive.Rejections`
            case Stray(node, answer) if not isinstance(answer, Status):
                self.notify(
                    ProtocolWarning(f"drive {node} answered twice, or late: {plain(answer)}")
                )
            case Stray(_, Status(code)) if code not in MOTION_CODES and code is not Code.HOME:
                self.notify(ProtocolWarning(plain(event)))
            case UnreadableFrame() | Foreign() | Overrun() | Failed():
                self.notify(ProtocolWarning(plain(event)))
            case LimitStop(node) if not self.drive(node).moving:
                self.notify(ProtocolWarning(plain(event)))
            case _:
                pass  # ends of motions and late replies: the position says more

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


def _settles(event: Event, *, answers_orders: bool) -> bool:
    """Return whether a message is the one reply to a question or an order."""
    match event:
        case Answered(_, _, EncoderRead()) | Stray(_, EncoderRead()):
            return True
        case Started(_, MoveAbsoluteAxis() | Stop()) | StoredForStart(_, MoveAbsoluteAxis()):
            return answers_orders
        case Stray(_, Status(Code.ABSOLUTE_AXIS, Outcome.STARTED)):
            return answers_orders
    return False
