"""What a host hears from MKS drives, and which request each reply is about.

A reply names a drive and a code and nothing else. Of readings, settings and actions one of a code
is open at a time. Motions of a code may follow each other unanswered:

    STARTED     is said of the oldest that is unanswered
    STORED      too; what is stored is under way from the synchronous start on
    DONE,       end the one that is under way; where none is, the oldest that is unanswered,
    LIMIT_STOP  whose STARTED was lost then
    FAILED      is said of the one that was superseded, where there is one; else of the oldest
                that is unanswered, else of the one under way

What gives way to a new target (F5 alone) or to a stop is superseded. By a public transcription of
the manual the drive says FAILED of it, beside the STARTED of the new one, in an order that is not
documented: so a FAILED while a new one is unanswered is taken for the old one. Where that is
wrong, the new one stays unanswered. Duplicated, lost and reordered replies never raise, and may
be taken for another motion's: the position is the better witness.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import chain
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.frames import Frame
from firmware_protocol.mks.answers import Answer, Reading, SettingRead, Status
from firmware_protocol.mks.requests import (
    EmergencyStop,
    Motion,
    Read,
    ReadSetting,
    ReportByItself,
    Request,
    Restart,
    Stop,
    answer_code,
)
from firmware_protocol.mks.values import Code, Outcome
from firmware_protocol.waiting import Overrun

# -- what is heard, one event at a time ----------------------------------------------------------


@dataclass(frozen=True, slots=True)
class _OfRequest:
    node: int
    request: Request


@dataclass(frozen=True, slots=True)
class _OfMotion:
    node: int
    request: Motion


@dataclass(frozen=True, slots=True)
class Answered:
    """A read and its answer."""

    node: int
    request: Read | ReadSetting
    answer: Reading | SettingRead


@dataclass(frozen=True, slots=True)
class Started(_OfMotion):
    """A motion, a homing or a calibration has begun."""


@dataclass(frozen=True, slots=True)
class Done(_OfRequest):
    """A setting or an action was taken, or a motion has ended where it should."""


@dataclass(frozen=True, slots=True)
class Failed(_OfRequest):
    """Refused, or ended short of its end."""


@dataclass(frozen=True, slots=True)
class LimitStop(_OfMotion):
    """A limit switch has ended a motion."""


@dataclass(frozen=True, slots=True)
class StoredForStart(_OfMotion):
    """A motion waits for the synchronous start."""


@dataclass(frozen=True, slots=True)
class Superseded(_OfMotion):
    """A motion was given up by the drive for a newer one, which goes on."""


@dataclass(frozen=True, slots=True)
class Reported:
    """A reading that the drive tells by itself, as it was asked to."""

    node: int
    reading: Reading


@dataclass(frozen=True, slots=True)
class Stray:
    """A readable answer that nobody awaits: a late one, or that of a second drive of this id."""

    node: int
    answer: Answer


@dataclass(frozen=True, slots=True)
class Garbled:
    """A frame with a drive's id that is no answer of this dialect, and why."""

    frame: Frame
    reason: str


@dataclass(frozen=True, slots=True)
class Foreign:
    """A frame of somebody else on the bus."""

    frame: Frame


Event: TypeAlias = (
    Answered
    | Started
    | Done
    | Failed
    | LimitStop
    | StoredForStart
    | Superseded
    | Reported
    | Stray
    | Garbled
    | Foreign
    | Overrun
)

# -- the motions of one code ---------------------------------------------------------------------

Heard: TypeAlias = Started | Done | LimitStop | StoredForStart | Superseded | Failed

UNANSWERED_MAX = 8
"""How many motions of a code wait for their first reply; of more, the oldest is forgotten."""


class Course:
    """The motions of one code that a drive was sent, and how far they came."""

    def __init__(self, node: int, code: Code) -> None:
        self._node = node
        self._retargets = code is Code.ABSOLUTE_AXIS
        self._unanswered: deque[Motion] = deque(maxlen=UNANSWERED_MAX)
        self._under_way: Motion | None = None
        self._superseded: Motion | None = None
        self._stored: Motion | None = None
        self._begun_unsaid = False

    @property
    def unanswered(self) -> tuple[Motion, ...]:
        """What was sent and not answered, the oldest first."""
        return tuple(self._unanswered)

    @property
    def under_way(self) -> Motion | None:
        """What the drive said it does."""
        return self._under_way

    @property
    def stored(self) -> Motion | None:
        """What waits for the synchronous start."""
        return self._stored

    def send(self, motion: Motion) -> None:
        """Take note of what is sent."""
        self._unanswered.append(motion)

    def go(self) -> None:
        """Take note of the synchronous start, which no drive answers."""
        if self._stored is not None:
            self._begin(self._stored)
            self._stored, self._begun_unsaid = None, True

    def forget(self, motion: Motion) -> None:
        """Wait no longer for the first reply to a motion."""
        if motion in self._unanswered:
            self._unanswered.remove(motion)

    def settle(self) -> None:
        """Take it as known that nothing is under way."""
        self._under_way = self._superseded = None

    def hear(self, outcome: Outcome) -> Heard | None:
        """Return what a reply says, or None where nobody awaits it."""
        match outcome:
            case Outcome.STARTED:
                return self._started()
            case Outcome.STORED:
                return self._to_store()
            case Outcome.FAILED:
                return self._failed()
            case Outcome.DONE:
                ended = self._ended()
                return None if ended is None else Done(self._node, ended)
            case Outcome.LIMIT_STOP:
                ended = self._ended()
                return None if ended is None else LimitStop(self._node, ended)

    def _begin(self, motion: Motion) -> None:
        if self._gives_way_to(motion):
            self._superseded = self._under_way
        self._under_way, self._begun_unsaid = motion, False

    def _gives_way_to(self, motion: Motion) -> bool:
        return self._under_way is not None and (self._retargets or isinstance(motion, Stop))

    def _started(self) -> Started | None:
        if self._unanswered:
            self._begin(self._unanswered.popleft())
        elif not self._begun_unsaid:
            return None
        self._begun_unsaid = False
        return None if self._under_way is None else Started(self._node, self._under_way)

    def _to_store(self) -> StoredForStart | None:
        if not self._unanswered:
            return None
        self._stored = self._unanswered.popleft()
        return StoredForStart(self._node, self._stored)

    def _ended(self) -> Motion | None:
        motion = self._under_way
        if motion is None and self._unanswered:
            motion = self._unanswered.popleft()
        self.settle()
        return motion

    def _failed(self) -> Superseded | Failed | None:
        if self._superseded is None and self._unanswered:
            if not self._gives_way_to(self._unanswered[0]):
                return Failed(self._node, self._unanswered.popleft())
            self._superseded, self._under_way = self._under_way, None
        if self._superseded is not None:
            motion, self._superseded = self._superseded, None
            return Superseded(self._node, motion)
        ended = self._ended()
        return None if ended is None else Failed(self._node, ended)


# -- all that one drive was asked ----------------------------------------------------------------


class Expecting:
    """The requests to one drive whose answers have not come, and the reports it was asked for.

    Of motions several may be unanswered, of everything else one of each code.
    """

    def __init__(self, node: int) -> None:
        self._node = node
        self._asked: dict[Code, Request] = {}
        self._courses: dict[Code, Course] = {}
        self._reports: set[Code] = set()

    @property
    def unanswered(self) -> tuple[Request, ...]:
        """Every request without a first answer; not in the order of sending."""
        motions = (course.unanswered for course in self._courses.values())
        return (*self._asked.values(), *chain.from_iterable(motions))

    @property
    def under_way(self) -> tuple[Motion, ...]:
        """Every motion that the drive said has begun, and not that it ended."""
        return _without_none(course.under_way for course in self._courses.values())

    @property
    def stored(self) -> tuple[Motion, ...]:
        """Every motion that waits for the synchronous start."""
        return _without_none(course.stored for course in self._courses.values())

    def send(self, request: Request) -> None:
        """Take note of a request; raises `LocalProtocolError` while one like it is unanswered."""
        if isinstance(request, Motion):
            if request.code not in self._courses:
                self._courses[request.code] = Course(self._node, request.code)
            self._courses[request.code].send(request)
            return
        code = answer_code(request)
        earlier = self._asked.get(code)
        if earlier is not None and not isinstance(request, EmergencyStop):
            raise LocalProtocolError(
                f"{type(earlier).__name__} to drive {self._node} is unanswered: wait for its "
                f"answer, or forget it, before sending {type(request).__name__}"
            )
        if isinstance(request, Restart):
            self.clear()
        if isinstance(request, ReportByItself):
            (self._reports.add if request.period_ms else self._reports.discard)(request.reading)
        self._asked[code] = request

    def go(self) -> None:
        """Take note of the synchronous start."""
        for course in self._courses.values():
            course.go()

    def settle(self) -> None:
        """Take it as known that the motor stands."""
        for course in self._courses.values():
            course.settle()

    def forget(self, request: Request) -> None:
        """Await no answer to a request any more."""
        if isinstance(request, Motion):
            if request.code in self._courses:
                self._courses[request.code].forget(request)
        elif self._asked.get(answer_code(request)) == request:
            del self._asked[answer_code(request)]

    def clear(self) -> None:
        """Await nothing any more."""
        for expected in (self._asked, self._courses, self._reports):
            expected.clear()

    def awaited(self, code: int) -> Request | None:
        """Return the request, other than a motion, that an answer of a code belongs to."""
        return next((request for key, request in self._asked.items() if key == code), None)

    def hear(self, answer: Answer) -> Event:
        """Return what an answer means."""
        if isinstance(answer, Status):
            return self._status(answer) or Stray(self._node, answer)
        request = self._asked.get(answer.code)
        if isinstance(request, Read | ReadSetting):
            del self._asked[answer.code]
            return Answered(self._node, request, answer)
        if answer.code in self._reports and not isinstance(answer, SettingRead):
            return Reported(self._node, answer)
        return Stray(self._node, answer)

    def _status(self, status: Status) -> Event | None:
        if (course := self._courses.get(status.code)) is not None:
            return course.hear(status.outcome)
        request = self._asked.get(status.code)
        if request is None or status.reading != getattr(request, "reading", None):
            return None
        del self._asked[status.code]
        kind = Done if status.outcome is Outcome.DONE else Failed
        return kind(self._node, request)


def _without_none(motions: Iterable[Motion | None]) -> tuple[Motion, ...]:
    return tuple(motion for motion in motions if motion is not None)
