"""The wire to MKS drives: what is said to them, what they answer, and what that shows of each.

A script asks one thing of each of several drives at once, and waits until all have answered. What
cannot do harm twice is asked again where its answer did not come: frames can be lost.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Iterable, Mapping
from typing import TypeAlias, TypeVar

from armdrive.dialects.bus.ledger import LateReplies, SurplusAnswers
from armdrive.dialects.bus.motors import ALL_SILENT, absent_words
from armdrive.dialects.bus.observer import Bounds, ObservedDrive, Observer
from armdrive.dialects.exchange import Script as ExchangeScript
from armdrive.dialects.exchange import ScriptIO
from armdrive.dialects.mks.settings import MksSettings
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
    EncoderRead,
    Event,
    Failed,
    Foreign,
    Garbled,
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
    Setting,
    SettingRead,
    Started,
    StateRead,
    Status,
    Stop,
    StoredForStart,
    Stray,
    Superseded,
    abilities_of,
    as_setting,
    slope_of,
)
from firmware_protocol.mks import Request as Message
from firmware_protocol.mks.requests import answer_code
from kinematics.spaces import Motors

T = TypeVar("T")
Asking: TypeAlias = ExchangeScript[Event, T]
"""What is done on the wire, and ends with something."""
Script: TypeAlias = Asking[Reply]
Hindrance: TypeAlias = Asking[Timeout | RequestRejected | None]
Told: TypeAlias = Reading | SettingRead
"""What a drive answers to a question."""

GIVE = COUNTS_PER_TURN // 32
"""Counts by which a loaded shaft may give, without its loop losing it."""
TRIES = 3
"""How often something that may be said twice is said."""
PATIENT_S = 0.25
"""How much longer than any other the last answer to that is waited for: computers are busy."""


class MksWire(ScriptIO[Event]):
    """Says things to the drives, and knows by the observer where they are."""

    look_at = ALL_SILENT

    def __init__(self, settings: MksSettings, names: Iterable[str]) -> None:
        super().__init__(self.unasked)
        self.host = Host(settings.ids)
        self.settings = settings
        bounds = Bounds(settings.rest_counts, settings.corridor_counts, GIVE, COUNTS_PER_TURN)
        named = zip(settings.ids, names, strict=True)
        self.observer = Observer([ObservedDrive(node, name, bounds) for node, name in named])
        self.able = abilities_of(settings.version or LATEST)
        """What all drives can do, as far as is known."""
        self.states: dict[int, MotorState] = {}
        """What each said last that it does, since somebody cleared that."""
        self.orders: dict[int, MoveAbsoluteAxis] = {}
        """Where each was sent last."""
        self.homing: dict[int, HomingState] = {}
        """How far each said last that its homing is, since somebody cleared that."""
        self.at_limit: set[int] = set()
        """Which said that a limit switch has stopped them, since somebody cleared that."""
        self.surplus = SurplusAnswers()
        self.garbled = 0
        """How many answers could not be read."""
        self._late = LateReplies()

    @property
    def drives(self) -> tuple[ObservedDrive, ...]:
        """All drives, in the order of the motors."""
        return self.observer.drives

    @property
    def nodes(self) -> tuple[int, ...]:
        """The ids of all drives, in the order of the motors."""
        return self.settings.ids

    @property
    def under_way(self) -> tuple[int, ...]:
        """The ids of the drives that were sent somewhere and not seen to stand since."""
        return tuple(drive.node for drive in self.drives if drive.moving)

    def drive(self, node: int) -> ObservedDrive:
        """Return a drive by its id."""
        return self.observer[node]

    # -- what is said -------------------------------------------------------------------------

    def put(self, node: int, message: Message, text: str = "") -> None:
        """Say something to a drive; what it was asked before, and would answer alike, is forgotten.

        Of motions, the same one alone: they may follow each other unanswered. Where it is sent
        anywhere, what it was sent before is answered no more.
        """
        for earlier in self.host.unanswered(node):
            alike = answer_code(earlier) == answer_code(message) and not isinstance(message, Motion)
            replaced = isinstance(earlier, MoveAbsoluteAxis) and isinstance(
                message, MoveAbsoluteAxis
            )
            if earlier == message or alike or replaced:
                self._give_up(node, earlier)
        self.say(self.host.send(node, message), text)
        if self.drive(node).ledger.answers_orders or not isinstance(message, Motion):
            owes = isinstance(message, ReadEncoder | MoveAbsoluteAxis | Stop)
            self.observer.told(node, self.now_s, owes=owes)
        if isinstance(message, Read):
            self.surplus.asked(node, message.code)
        if isinstance(message, ReadEncoder):
            self.drive(node).ledger.asked(self.now_s)

    def send(self, node: int, order: MoveAbsoluteAxis) -> None:
        """Send a drive to a count, at a speed and by a ramp."""
        self.put(node, order)
        self.took(node, order)

    def repeat(self, drive: ObservedDrive) -> None:
        """Say a drive's last order again, if it is sent anywhere: it is absolute."""
        if drive.moving:
            self.send(drive.node, self.orders[drive.node])

    def took(self, node: int, order: MoveAbsoluteAxis) -> None:
        """Take note that a drive was sent somewhere."""
        self.orders[node] = order
        speed, slope = order.speed_rpm * COUNTS_S_PER_RPM, slope_of(order.acc)
        self.drive(node).order(order.counts, speed, slope, self.now_s)
        self.said = f"F5 to {' '.join(str(drive.goal) for drive in self.drives)}"

    def broadcast(self, message: Message, text: str = "") -> None:
        """Say something to all at once, which none answers."""
        self.say(self.host.send(BROADCAST, message), text)

    def give_up(self) -> None:
        """Wait for no answer any more."""
        for node in self.nodes:
            for request in self.host.unanswered(node):
                self._give_up(node, request)
            self.host.forget(node)
        self.host.silence()

    def _give_up(self, node: int, request: Message) -> None:
        """Wait no longer for one answer: what comes of it is late."""
        self.host.forget(node, request)
        if not isinstance(request, Motion):
            self._late.give_up(node, answer_code(request), self.now_s)

    # -- what is asked ------------------------------------------------------------------------

    def ask(
        self,
        messages: Mapping[int, Message],
        *,
        tries: int = TRIES,
        text: str = "",
        patient: bool = True,
    ) -> Asking[dict[int, Event]]:
        """Say one thing to each of some drives; return what they answered, as far as they did.

        A drive that does not answer is asked again, at once: waiting for it takes the time. Who is
        `patient` waits longer for the last answer of several.
        """
        found: dict[int, Event] = {}
        for left in range(tries, 0, -1):
            missing = {node: each for node, each in messages.items() if node not in found}
            if not missing:
                break
            for node, message in missing.items():
                self.put(node, message, text)
            patient_s = PATIENT_S if patient and left == 1 < tries else 0.0
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
        while left:  # what was read late has come in time, perhaps: it is heard to its end
            heard = yield until_s
            if heard is None:
                if self.now_s >= until_s:
                    return
                continue
            node = getattr(heard, "node", None)
            answers = isinstance(heard, Answered | Done | Failed | Started | StoredForStart)
            if answers and node in left and heard.request == wanted[node]:  # type: ignore[union-attr]
                self.heed(heard)
                found[node] = heard
                left.discard(node)
            else:
                self.unasked(heard)

    def read(
        self,
        message: Read | ReadSetting,
        nodes: Collection[int] | None = None,
        *,
        tries: int = TRIES,
        patient: bool = True,
    ) -> Asking[dict[int, Told]]:
        """Ask the same of some drives, or of all; return what they told, as far as they did."""
        asked = dict.fromkeys(self.nodes if nodes is None else nodes, message)
        found = yield from self.ask(asked, tries=tries, patient=patient)
        return {node: each.answer for node, each in found.items() if isinstance(each, Answered)}

    def reading(
        self, node: int, message: Read | ReadSetting, *, tries: int = TRIES
    ) -> Asking[Told | None]:
        """Ask one drive something; None where it does not answer."""
        return (yield from self.read(message, (node,), tries=tries)).get(node)

    def setting(self, node: int, code: Code) -> Asking[Setting | None]:
        """Read one setting of a drive; None where it does not tell it."""
        return meant((yield from self.reading(node, ReadSetting(code))))

    def look(
        self,
        nodes: Collection[int] | None = None,
        *,
        tries: int = TRIES,
    ) -> Asking[tuple[int, ...]]:
        """Read where drives are; return the ids of those that did not tell."""
        asked = self.nodes if nodes is None else tuple(nodes)
        found = yield from self.read(ReadEncoder(), asked, tries=tries)
        return tuple(node for node in asked if node not in found)

    # -- what is heard ------------------------------------------------------------------------

    def heed(self, heard: Event) -> None:
        """Note what an answer shows, whoever asked for it."""
        node = getattr(heard, "node", None)
        if node not in self.observer:
            return
        if isinstance(heard, Answered | Stray) and isinstance(heard.answer, Reading):
            self.surplus.answered(heard.node, heard.answer.code)
        drive = self.drive(node)  # type: ignore[arg-type]
        drive.said_s = self.now_s
        ledger, asked = drive.ledger, not isinstance(heard, Done | Failed | LimitStop)
        settles = _settles(heard, answers_orders=ledger.answers_orders)
        self.observer.heard(drive.node, self.now_s, settles=settles, asked=asked)
        ledger.answers_orders = ledger.answers_orders or isinstance(heard, Started)
        if isinstance(heard, LimitStop):
            self.at_limit.add(drive.node)
        match heard:
            case Started() | Stray(_, Status(Code.ABSOLUTE_AXIS, Outcome.STARTED)):
                drive.rejections.taken(self.now_s)
            case Failed(_, MoveAbsoluteAxis()) | Superseded():
                drive.rejections.refused(self.now_s)
            case Answered(_, _, EncoderRead(counts)):
                drive.read(counts, self.now_s)
            case Stray(_, EncoderRead()):
                drive.ledger.placed()
            case Answered(_, _, StateRead(state)):
                self.states[drive.node] = state
            case Answered(_, _, HomingRead(by_command=homing)) if homing is not None:
                self.homing[drive.node] = homing
            case Done(_, Home()):
                self.homing[drive.node] = HomingState.DONE
                self.states[drive.node] = MotorState.STOPPED
            case StoredForStart(_, MoveAbsoluteAxis() as order) if drive.moving:
                self.put(drive.node, ArmSynchronous(on=False))
                self.put(drive.node, order)

    def unasked(self, heard: Event) -> None:
        """Heed what no script waits for, and tell what is odd of it."""
        self.heed(heard)
        self.garbled += isinstance(heard, Garbled)
        match heard:
            case Stray(node, answer) if self._late.takes(node, answer.code, self.now_s):
                pass
            case Failed(_, MoveAbsoluteAxis()):
                pass  # this order or the one that it replaced: see the observer's rejections
            case Stray(node, answer) if not isinstance(answer, Status):
                self.tell(ProtocolWarning(f"drive {node} answered twice, or late: {answer}"))
            case Stray(_, Status(code)) if code not in MOTION_CODES and code is not Code.HOME:
                self.tell(ProtocolWarning(str(heard)))
            case Garbled() | Foreign() | Overrun() | Failed():
                self.tell(ProtocolWarning(str(heard)))
            case LimitStop(node) if not self.drive(node).moving:
                self.tell(ProtocolWarning(str(heard)))
            case _:
                pass  # ends of motions, late answers: the position is the better witness

    # -- words --------------------------------------------------------------------------------

    def registers(self) -> Registers:
        """Return where the drives were read last, by their encoders."""
        return Registers(Motors(drive.register for drive in self.drives))

    def absence(self, missing: Collection[int], since_s: float) -> Timeout | RequestRejected:
        """Say that drives do not answer; silence where it is all of them."""
        if set(missing) == set(self.nodes):
            return self.silence(since_s)
        return RequestRejected(self.absent_words(missing), moved=False)

    def absent_words(self, missing: Collection[int]) -> str:
        """Say which drives do not answer, and what to look at."""
        return absent_words([self.drive(node) for node in missing], "id")

    def can(self, ability: Ability) -> bool:
        """Tell whether all drives can do something."""
        return ability in self.able


def meant(told: Told | None) -> Setting | None:
    """Return a setting that was read; None where it was not told, or is none that is known."""
    try:
        return as_setting(told) if isinstance(told, SettingRead) else None
    except RemoteProtocolError:
        return None


def _settles(heard: Event, *, answers_orders: bool) -> bool:
    """Tell whether this is the one answer to a question or an order."""
    match heard:
        case Answered(_, _, EncoderRead()) | Stray(_, EncoderRead()):
            return True
        case Started(_, MoveAbsoluteAxis() | Stop()) | StoredForStart(_, MoveAbsoluteAxis()):
            return answers_orders
        case Stray(_, Status(Code.ABSOLUTE_AXIS, Outcome.STARTED)):
            return answers_orders
    return False
