"""What MKS drives say, asked or not: what of it is noted of each drive, and what is odd."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from armdrive.abilities import Abilities
from armdrive.dialects.bus.motors import ALL_SILENT
from armdrive.dialects.exchange import Scripted
from armdrive.dialects.mks.drive import MksDrive
from armdrive.dialects.mks.observer import LateReplies
from armdrive.dialects.mks.settings import MksSettings
from armdrive.tasks import ProtocolWarning
from firmware_protocol.mks import (
    MOTION_CODES,
    Answered,
    Code,
    Done,
    EncoderRead,
    Event,
    Failed,
    Foreign,
    Garbled,
    Host,
    LimitStop,
    Motion,
    MoveAbsoluteAxis,
    Outcome,
    Overrun,
    Started,
    Status,
    Stop,
    StoredForStart,
    Stray,
)
from firmware_protocol.mks import Request as Message
from firmware_protocol.mks.expecting import answer_code

REFUSED = 2
"""So many targets in a row that failed are refused; one may be that which a newer one replaced."""


class MksReceiving(Scripted[Event]):
    """Knows where the drives were seen, and when each was heard."""

    look_at = ALL_SILENT

    def __init__(self, abilities: Abilities, settings: MksSettings, names: Iterable[str]) -> None:
        self._host = Host(settings.ids)
        super().__init__(abilities, self._host)
        self.settings = settings
        named = zip(settings.ids, names, strict=True)
        self.drives = tuple(MksDrive(node, name, settings.acceleration) for node, name in named)
        self._by_node: Mapping[int, MksDrive] = {drive.node: drive for drive in self.drives}
        self.said_s = 0.0
        self._owed = LateReplies()
        self.extra: dict[int, int] = {}
        """How many readings of its encoder a drive has told beyond those it was asked for."""

    def give_up(self) -> None:
        """Wait for no answer any more."""
        for drive in self.drives:
            for request in self._host.unanswered(drive.node):
                self._give_up(drive.node, request)
            self._host.forget(drive.node)
        self._host.silence()

    def _give_up(self, node: int, request: Message) -> None:
        """Wait no longer for one answer: what comes of it is late."""
        self._host.forget(node, request)
        if not isinstance(request, Motion):
            self._owed.give_up(node, answer_code(request), self.now_s)

    def drive(self, node: int) -> MksDrive:
        """Return a drive by its id."""
        return self._by_node[node]

    @property
    def nodes(self) -> tuple[int, ...]:
        """The ids of all drives, in the order of the motors."""
        return self.settings.ids

    def heed(self, heard: Event) -> None:
        """Note what an answer shows, whoever asked for it."""
        node = getattr(heard, "node", None)
        drive = None if node is None else self._by_node.get(node)
        if drive is None:
            return
        drive.heard_s = self.now_s
        if not isinstance(heard, Done | Failed | LimitStop):
            drive.answered_s, drive.unanswered = self.now_s, 0
        drive.gap.heard(self.now_s, counts=_counts(heard, obedient=drive.gap.obedient))
        drive.gap.obedient = drive.gap.obedient or isinstance(heard, Started)
        drive.denials.heard(heard, self.now_s)
        if isinstance(heard, Answered | Stray) and isinstance(heard.answer, EncoderRead):
            self._count(drive.node, 1)
            drive.questions.answered()
        if isinstance(heard, Answered) and isinstance(heard.answer, EncoderRead):
            drive.see(heard.answer.counts, self.now_s)

    def _count(self, node: int, change: int) -> None:
        self.extra[node] = self.extra.get(node, 0) + change

    def unasked(self, heard: Event) -> None:
        """Weigh what no script waits for."""
        self.heed(heard)
        self.weigh_unasked(heard)

    def weigh_unasked(self, heard: Event) -> None:
        """Tell what is odd of what was heeded, and no script waits for."""
        match heard:
            case Stray(node, answer) if self._owed.takes(node, answer.code, self.now_s):
                pass
            case Failed(node, MoveAbsoluteAxis()) if self.drive(node).denials.refused < REFUSED:
                pass
            case Stray(node, answer) if not isinstance(answer, Status):
                self.tell(ProtocolWarning(f"drive {node} answered twice, or late: {answer}"))
            case Stray(_, Status(code)) if code not in MOTION_CODES and code is not Code.HOME:
                self.tell(ProtocolWarning(str(heard)))
            case Garbled() | Foreign() | Overrun() | Failed() | LimitStop():
                self.tell(ProtocolWarning(str(heard)))
            case _:
                pass  # ends of motions, late answers: the position is the better witness


def _counts(heard: Event, *, obedient: bool) -> bool:
    """Tell whether this is the one answer to a question or an order."""
    match heard:
        case Answered(_, _, EncoderRead()) | Stray(_, EncoderRead()):
            return True
        case Started(_, MoveAbsoluteAxis() | Stop()) | StoredForStart(_, MoveAbsoluteAxis()):
            return obedient
        case Stray(_, Status(Code.ABSOLUTE_AXIS, Outcome.STARTED)):
            return obedient
    return False
