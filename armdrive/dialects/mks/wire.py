"""The wire to MKS drives: requests out, replies in, and what each reply shows to the observer.

A script sends one request to each of several drives at once and waits for all replies. A request
that is safe to repeat is sent again if its reply is missing, since frames can be lost.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Iterable, Mapping
from typing import TypeAlias, TypeVar

from armdrive.dialects.bus.drives import ALL_SILENT, absence, absent_words
from armdrive.dialects.bus.ledger import LateReplies, SurplusAnswers
from armdrive.dialects.bus.observer import Bounds, ObservedDrive, Observer
from armdrive.dialects.exchange import Script as ExchangeScript
from armdrive.dialects.exchange import ScriptIO
from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.words import plain
from armdrive.tasks import ProtocolWarning, Registers, Reply, RequestRejected, Timeout
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.mks import (
    BROADCAST,
    COUNTS_PER_TURN,
    COUNTS_S_PER_RPM,
    LATEST,
    MOTION_CODES,
    Ability,
    Answered,
    ArmSynchronous,
    Code,
    Done,
    EnabledRead,
    EncoderRead,
    Event,
    Failed,
    Foreign,
    Home,
    HomingRead,
    HomingState,
    Host,
    LimitStop,
    Motion,
    MotorState,
    MoveAbsoluteAxis,
    Outcome,
    Overrun,
    Read,
    ReadEncoder,
    Reading,
    ReadSetting,
    SetMode,
    Setting,
    SettingRead,
    StallRead,
    Started,
    StateRead,
    Status,
    Stop,
    StoredForStart,
    Stray,
    Superseded,
    UnreadableFrame,
    abilities_of,
    as_setting,
    slope_of,
)
from firmware_protocol.mks import Request as Message
from firmware_protocol.mks.requests import answer_code
from kinematics.spaces import Motors

T = TypeVar("T")
WireScript: TypeAlias = ExchangeScript[Event, T]
"""A script on the wire, with its result."""
Script: TypeAlias = WireScript[Reply]
Answer: TypeAlias = Reading | SettingRead
"""A drive's answer to a question."""

GIVE = COUNTS_PER_TURN // 32
"""How many counts a loaded shaft may give way while its position loop still holds it."""
TRIES = 3
"""How often a request that is safe to repeat is sent."""
LAST_TRY_S = 0.25
"""How much longer the last reply is waited for: computers may be busy."""


class MksWire(ScriptIO[Event]):
    """Sends requests to the drives and passes their replies to the observer."""

    look_at = ALL_SILENT

    def __init__(self, settings: MksSettings, names: Iterable[str]) -> None:
        super().__init__(self.unsolicited)
        self.host = Host(settings.ids)
        self.settings = settings
        bounds = Bounds(settings.rest_counts, settings.corridor_counts, GIVE, COUNTS_PER_TURN)
        named = zip(settings.ids, names, strict=True)
        self.observer = Observer([ObservedDrive(node, name, bounds) for node, name in named])
        self.able = abilities_of(settings.version or LATEST)
        """The abilities that all drives have, as far as is known."""
        self.states: dict[int, MotorState] = {}
        """The last motor state of each drive since its entry was cleared."""
        self.orders: dict[int, MoveAbsoluteAxis] = {}
        """The last order to each drive."""
        self.homing: dict[int, HomingState] = {}
        """The last homing state of each drive since its entry was cleared."""
        self.at_limit: set[int] = set()
        """The drives that a limit switch has stopped, since the set was cleared."""
        self.unfit: set[int] = set()
        """The drives that reported a stall, no current, or a mode in which the bus moves nothing,
        since the set was cleared."""
        self.surplus = SurplusAnswers()
        self.garbled = 0
        """How many replies were unreadable."""
        self._late = LateReplies()

    @property
    def drives(self) -> tuple[ObservedDrive, ...]:
        """All drives, in motor order."""
        return self.observer.drives

    @property
    def nodes(self) -> tuple[int, ...]:
        """The ids of all drives, in motor order."""
        return self.settings.ids

    @property
    def under_way(self) -> tuple[int, ...]:
        """The ids of drives with a target that were not seen to stand since."""
        return tuple(drive.node for drive in self.drives if drive.moving)

    def drive(self, node: int) -> ObservedDrive:
        """Return a drive by its id."""
        return self.observer[node]

    # -- sending ------------------------------------------------------------------------------

    def put(self, node: int, message: Message, text: str = "") -> None:
        """Send a request to a drive, and give up earlier ones whose reply would look the same.

        Motions may follow each other unanswered, so of these only an identical one is given up. A
        new target also gives up earlier targets, which will not be answered any more.
        """
        for earlier in self.host.unanswered(node):
            alike = answer_code(earlier) == answer_code(message) and not isinstance(message, Motion)
            replaced = isinstance(earlier, MoveAbsoluteAxis) and isinstance(
                message, MoveAbsoluteAxis
            )
            if earlier == message or alike or replaced:
                self._give_up(node, earlier)
        self.write(self.host.send(node, message), text)
        if self.drive(node).ledger.answers_orders or not isinstance(message, Motion):
            owes = isinstance(message, ReadEncoder | MoveAbsoluteAxis | Stop)
            self.observer.sent(node, self.now_s, owes=owes)
        if isinstance(message, Read):
            self.surplus.asked(node, message.code)
        if isinstance(message, ReadEncoder):
            self.drive(node).ledger.asked(self.now_s)

    def send(self, node: int, order: MoveAbsoluteAxis) -> None:
        """Send a drive an order: target, speed and ramp."""
        self.put(node, order)
        self.note_order(node, order)

    def repeat(self, drive: ObservedDrive) -> None:
        """Send a moving drive its last order again, which is absolute."""
        if drive.moving:
            self.send(drive.node, self.orders[drive.node])

    def note_order(self, node: int, order: MoveAbsoluteAxis) -> None:
        """Record that a drive has received an order."""
        self.orders[node] = order
        speed, slope = order.speed_rpm * COUNTS_S_PER_RPM, slope_of(order.acc)
        self.drive(node).order(order.counts, speed, slope, self.now_s)
        self.said = f"F5 to {' '.join(str(drive.goal) for drive in self.drives)}"

    def broadcast(self, message: Message, text: str = "") -> None:
        """Send a request to all drives, which none of them answers."""
        self.write(self.host.send(BROADCAST, message), text)

    def give_up(self) -> None:
        """Give up all open requests."""
        for node in self.nodes:
            for request in self.host.unanswered(node):
                self._give_up(node, request)
            self.host.forget(node)
        self.host.silence()

    def _give_up(self, node: int, request: Message) -> None:
        """Give up one request: its reply will count as late."""
        self.host.forget(node, request)
        if not isinstance(request, Motion):
            self._late.give_up(node, answer_code(request), self.now_s)

    # -- asking -------------------------------------------------------------------------------

    def ask(
        self,
        messages: Mapping[int, Message],
        *,
        tries: int = TRIES,
        text: str = "",
        patient: bool = True,
    ) -> WireScript[dict[int, Event]]:
        """Send each drive its request; return the replies that came.

        A drive that does not reply is asked again at once. With `patient` the last of several tries
        waits longer.
        """
        found: dict[int, Event] = {}
        for left in range(tries, 0, -1):
            missing = {node: each for node, each in messages.items() if node not in found}
            if not missing:
                break
            for node, message in missing.items():
                self.put(node, message, text)
            patient_s = LAST_TRY_S if patient and left == 1 < tries else 0.0
            yield from self._collect(missing, found, patient_s)
            for node, message in missing.items():
                if node not in found and message in self.host.unanswered(node):
                    self._give_up(node, message)
        return found

    def _collect(
        self, wanted: Mapping[int, Message], found: dict[int, Event], patient_s: float
    ) -> Generator[float, Event | None, None]:
        until_s = self.now_s + self.settings.answer_s + patient_s
        left = set(wanted)
        while left:  # a late computer reads everything that arrived in time before it gives up
            event = yield until_s
            if event is None:
                if self.now_s >= until_s:
                    return
                continue
            node = getattr(event, "node", None)
            answers = isinstance(event, Answered | Done | Failed | Started | StoredForStart)
            if answers and node in left and event.request == wanted[node]:  # type: ignore[union-attr]
                self.note(event)
                found[node] = event
                left.discard(node)
            else:
                self.unsolicited(event)

    def read(
        self,
        message: Read | ReadSetting,
        nodes: Collection[int] | None = None,
        *,
        tries: int = TRIES,
        patient: bool = True,
    ) -> WireScript[dict[int, Answer]]:
        """Ask some drives, or all, the same question; return the answers that came."""
        asked = dict.fromkeys(self.nodes if nodes is None else nodes, message)
        found = yield from self.ask(asked, tries=tries, patient=patient)
        return {node: each.answer for node, each in found.items() if isinstance(each, Answered)}

    def reading(
        self, node: int, message: Read | ReadSetting, *, tries: int = TRIES
    ) -> WireScript[Answer | None]:
        """Ask one drive a question; None if it does not answer."""
        return (yield from self.read(message, (node,), tries=tries)).get(node)

    def setting(self, node: int, code: Code) -> WireScript[Setting | None]:
        """Read one setting of a drive; None if it does not report it."""
        return setting_of((yield from self.reading(node, ReadSetting(code))))

    def look(self, nodes: Collection[int] | None = None) -> WireScript[tuple[int, ...]]:
        """Read the positions of drives; return the ids of those that do not answer."""
        asked = self.nodes if nodes is None else tuple(nodes)
        found = yield from self.read(ReadEncoder(), asked)
        return tuple(node for node in asked if node not in found)

    # -- receiving ----------------------------------------------------------------------------

    def note(self, event: Event) -> None:
        """Record what a message shows, expected or not."""
        node = getattr(event, "node", None)
        if node not in self.observer:
            return
        if isinstance(event, Answered | Stray) and isinstance(event.answer, Reading):
            self.surplus.answered(event.node, event.answer.code)
        drive = self.drive(node)  # type: ignore[arg-type]
        drive.frame_s = self.now_s
        ledger, asked = drive.ledger, not isinstance(event, Done | Failed | LimitStop)
        settles = _settles(event, answers_orders=ledger.answers_orders)
        self.observer.replied(drive.node, self.now_s, settles=settles, asked=asked)
        ledger.answers_orders = ledger.answers_orders or isinstance(event, Started)
        if isinstance(event, LimitStop):
            self.at_limit.add(drive.node)
        match event:
            case Started() | Stray(_, Status(Code.ABSOLUTE_AXIS, Outcome.STARTED)):
                drive.rejections.taken(self.now_s)
            case Failed(_, MoveAbsoluteAxis()) | Superseded():
                drive.rejections.refused(self.now_s)
            case Answered(_, _, EncoderRead(counts)):
                drive.read(counts, self.now_s)
            case Stray(_, EncoderRead()):
                drive.ledger.located(self.now_s)
            case Answered(_, _, StateRead(state)):
                self.states[drive.node] = state
            case Answered(_, _, StallRead(on=True) | EnabledRead(on=False)):
                self.unfit.add(drive.node)
            case Answered(_, _, SettingRead(Code.MODE) as mode) if not obeys_bus(setting_of(mode)):
                self.unfit.add(drive.node)
            case Answered(_, _, HomingRead(by_command=homing)) if homing is not None:
                self.homing[drive.node] = homing
            case Done(_, Home()):
                self.homing[drive.node] = HomingState.DONE
                self.states[drive.node] = MotorState.STOPPED
            case StoredForStart(_, MoveAbsoluteAxis() as order) if drive.moving:
                self.put(drive.node, ArmSynchronous(on=False))
                self.put(drive.node, order)

    def unsolicited(self, event: Event) -> None:
        """Record a message that no script waits for, and warn if it is odd."""
        self.note(event)
        self.garbled += isinstance(event, UnreadableFrame)
        match event:
            case Stray(node, answer) if self._late.takes(node, answer.code, self.now_s):
                pass
            case Failed(_, MoveAbsoluteAxis()):
                pass  # for this order or the one it replaced: see `ledger.Rejections`
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

    def absence(
        self, missing: Collection[int], since_s: float, *, moved: bool = False
    ) -> Timeout | RequestRejected:
        """Return the reply that names missing drives."""
        drives = [self.drive(node) for node in missing]
        return absence(drives, self.drives, "id", self.silence(since_s), moved=moved)

    def absent_words(self, missing: Collection[int]) -> str:
        """Return which drives do not answer and what to check."""
        return absent_words([self.drive(node) for node in missing], "id")

    def can(self, ability: Ability) -> bool:
        """Return whether all drives have an ability."""
        return ability in self.able


def setting_of(answer: Answer | None) -> Setting | None:
    """Return the setting in an answer; None if the drive reported none, or an unknown one."""
    try:
        return as_setting(answer) if isinstance(answer, SettingRead) else None
    except RemoteProtocolError:
        return None


def obeys_bus(setting: Setting | None) -> bool:
    """Return whether the bus can move a drive in this mode; True if the mode is not known."""
    return not isinstance(setting, SetMode) or setting.mode.on_bus


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
