"""A host's events from MKS drives, and the matching of replies to requests.

A reply contains only a drive and a code. Of each reading, setting and action, only one request per
code is open at a time. Several motions with one code may be unanswered:

    STARTED     belongs to the oldest unanswered motion
    STORED      the same; armdrive starts no stored motion
    DONE,       end the motion under way, or else the oldest unanswered one, whose STARTED
    LIMIT_STOP  was then lost
    FAILED      belongs to a superseded motion if there is one, else to the oldest unanswered
                motion, else to the motion under way

A motion is superseded by a new target (F5 only) or by a stop. According to a public transcription
of the manual, the drive then reports FAILED for the old motion and STARTED for the new one, in an
undocumented order. So a FAILED while the new motion is unanswered is assigned to the old one; if
that is wrong, the new motion stays unanswered. Duplicate, lost and reordered replies never raise,
but may be assigned to the wrong motion: the position is more reliable.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from itertools import chain
from typing import TypeAlias

from firmware_protocol.errors import LocalProtocolError, RemoteProtocolError, whole
from firmware_protocol.events import EventQueue, Overrun, UnreadableFrame
from firmware_protocol.fields import message
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks.answers import (
    Answer,
    Reading,
    SettingRead,
    Status,
    decode_answer,
    encode,
)
from firmware_protocol.mks.requests import (
    EmergencyStop,
    Motion,
    Read,
    ReadSetting,
    Request,
    SetId,
    Stop,
    answer_code,
)
from firmware_protocol.mks.values import NODE_MAX, Code, Outcome

# -- events --------------------------------------------------------------------------------------


@message()
class _OfRequest:
    node: int
    request: Request


@message()
class _OfMotion:
    node: int
    request: Motion


@message()
class Answered:
    """A read request and its answer."""

    node: int
    request: Read | ReadSetting
    answer: Reading | SettingRead


@message()
class Started(_OfMotion):
    """A motion, homing or calibration has started."""


@message()
class Done(_OfRequest):
    """A setting or action was accepted, or a motion has reached its target."""


@message()
class Failed(_OfRequest):
    """The request was refused, or the motion ended early."""


@message()
class LimitStop(_OfMotion):
    """A limit switch has ended a motion."""


@message()
class StoredForStart(_OfMotion):
    """A motion is stored for the synchronous start."""


@message()
class Superseded(_OfMotion):
    """The drive has abandoned a motion in favour of a newer one, which continues."""


@message()
class Stray:
    """A readable but unexpected answer: late, or from a second drive with this id."""

    node: int
    answer: Answer


@message()
class Foreign:
    """A frame from another device on the bus."""

    frame: Frame


Event: TypeAlias = (
    Answered
    | Started
    | Done
    | Failed
    | LimitStop
    | StoredForStart
    | Superseded
    | Stray
    | UnreadableFrame
    | Foreign
    | Overrun
)

# -- the motions of one code ---------------------------------------------------------------------

UNANSWERED_MAX = 8
"""Most motions per code that wait for their first reply; beyond that, the oldest is dropped."""


class MotionReplies:
    """Tracks the motions with one code that were sent to a drive."""

    def __init__(self, node: int, code: Code) -> None:
        self._node = node
        self._retargets = code is Code.ABSOLUTE_AXIS
        self._unanswered: deque[Motion] = deque(maxlen=UNANSWERED_MAX)
        self._under_way: Motion | None = None
        self._superseded: Motion | None = None

    @property
    def unanswered(self) -> tuple[Motion, ...]:
        """The unanswered motions, oldest first."""
        return tuple(self._unanswered)

    def send(self, motion: Motion) -> None:
        """Record a motion that is being sent."""
        self._unanswered.append(motion)

    def forget(self, motion: Motion) -> None:
        """Stop waiting for the first reply to a motion."""
        if motion in self._unanswered:
            self._unanswered.remove(motion)

    def settle(self) -> None:
        """Record that no motion is under way."""
        self._under_way = self._superseded = None

    def receive(
        self, outcome: Outcome
    ) -> Started | Done | LimitStop | StoredForStart | Superseded | Failed | None:
        """Return the event for a reply, or None if the reply is unexpected."""
        match outcome:
            case Outcome.STARTED:
                return self._started()
            case Outcome.STORED:
                waits = self._unanswered
                return StoredForStart(self._node, waits.popleft()) if waits else None
            case Outcome.FAILED:
                return self._failed()
            case Outcome.DONE:
                ended = self._ended()
                return None if ended is None else Done(self._node, ended)
            case Outcome.LIMIT_STOP:
                ended = self._ended()
                return None if ended is None else LimitStop(self._node, ended)

    def _begin(self, motion: Motion) -> None:
        if self._gives_way_to(motion):  # the drive will say FAILED for the old one
            self._superseded = self._under_way
        self._under_way = motion

    def _gives_way_to(self, motion: Motion) -> bool:
        return self._under_way is not None and (self._retargets or isinstance(motion, Stop))

    def _started(self) -> Started | None:
        if not self._unanswered:
            return None
        motion = self._unanswered.popleft()
        self._begin(motion)
        return Started(self._node, motion)

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


# -- all requests to one drive -------------------------------------------------------------------


class OpenRequests:
    """A drive's unanswered requests.

    Several motions may be unanswered, but only one other request per code.
    """

    def __init__(self, node: int) -> None:
        self._node = node
        self._asked: dict[Code, Request] = {}
        self._motions: dict[Code, MotionReplies] = {}

    @property
    def unanswered(self) -> tuple[Request, ...]:
        """All requests without a first answer, in no particular order."""
        motions = chain.from_iterable(each.unanswered for each in self._motions.values())
        return (*self._asked.values(), *motions)

    def send(self, request: Request) -> None:
        """Record a request. Raises `LocalProtocolError` while a similar one is unanswered."""
        if isinstance(request, Motion):
            if request.code not in self._motions:
                self._motions[request.code] = MotionReplies(self._node, request.code)
            self._motions[request.code].send(request)
            return
        code = answer_code(request)
        earlier = self._asked.get(code)
        if earlier is not None and not isinstance(request, EmergencyStop):
            raise LocalProtocolError(
                f"{type(earlier).__name__} to drive {self._node} is unanswered: wait for its "
                f"answer, or forget it, before sending {type(request).__name__}"
            )
        self._asked[code] = request

    def settle(self) -> None:
        """Record that the motor is at rest."""
        for each in self._motions.values():
            each.settle()

    def forget(self, request: Request) -> None:
        """Stop waiting for the answer to a request."""
        if isinstance(request, Motion):
            if request.code in self._motions:
                self._motions[request.code].forget(request)
        elif self._asked.get(answer_code(request)) == request:
            del self._asked[answer_code(request)]

    def clear(self) -> None:
        """Stop waiting for all answers."""
        self._asked.clear()
        self._motions.clear()

    def awaited(self, code: int) -> Request | None:
        """Return the request (not a motion) that an answer with this code belongs to."""
        return next((request for key, request in self._asked.items() if key == code), None)

    def receive(self, answer: Answer) -> Event:
        """Return the event for an answer."""
        if isinstance(answer, Status):
            return self._status(answer) or Stray(self._node, answer)
        request = self._asked.get(answer.code)
        if isinstance(request, Read | ReadSetting):
            del self._asked[answer.code]
            return Answered(self._node, request, answer)
        return Stray(self._node, answer)

    def _status(self, status: Status) -> Event | None:
        if (motions := self._motions.get(status.code)) is not None:
            return motions.receive(status.outcome)
        request = self._asked.pop(status.code, None)
        if request is None:
            return None
        kind = Done if status.outcome is Outcome.DONE else Failed
        return kind(self._node, request)


EVENTS_MAX = 256
"""Most queued events; the newest are kept."""


class Host:
    """The host's protocol machine, for several drives. Raises `LocalProtocolError` if misused.

    Input and output are frame records (`firmware_protocol.frames`). No frame on the bus raises.
    An answer is matched on arrival to the request with the same drive and code, so that an earlier
    answer never matches a later request. A late answer after `forget` may be taken for the answer
    to the next request with this code, because nothing in it shows the difference. It speaks to one
    drive at a time: broadcasts and groups have no answers, so nothing shows which drives obeyed.

    There is no clock: the caller calls `forget` after a timeout. A drive need not report the end of
    a motion, so the caller calls `settle` once the position shows that the drive is at rest.
    """

    def __init__(self, nodes: Iterable[int]) -> None:
        self._drives: dict[int, OpenRequests] = {}
        self._unpacker = Unpacker()
        self._events: EventQueue[Event] = EventQueue(EVENTS_MAX)
        for node in nodes:
            self.add(node)

    @property
    def nodes(self) -> frozenset[int]:
        """The ids of the drives."""
        return frozenset(self._drives)

    def add(self, node: int) -> None:
        """Add a drive."""
        whole("node", node, 1, NODE_MAX)
        self._drives.setdefault(node, OpenRequests(node))

    def unanswered(self, node: int) -> tuple[Request, ...]:
        """Return a drive's requests without a first answer, in no particular order."""
        return self._drive(node).unanswered

    def send(self, node: int, request: Request) -> bytes:
        """Return the bytes of a request to a drive.

        Motions, stops and `EmergencyStop` are never refused. Raises `LocalProtocolError` for an
        unknown id, and while an earlier request is unanswered whose answer has the same code.
        """
        self._drive(node).send(request)
        if isinstance(request, SetId):
            self.add(request.node)
        return pack(encode(node, request))

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the bus, in any portions."""
        for frame in self._unpacker.feed(data):
            self._events.put(self._hear(frame))

    def silence(self) -> None:
        """Say that nothing has come for longer than a record pauses."""
        for frame in self._unpacker.silence():
            self._events.put(self._hear(frame))

    def next_event(self) -> Event | None:
        """Return what was received so far, one event at a time, then None."""
        return self._events.next()

    def forget(self, node: int, request: Request | None = None) -> None:
        """Stop waiting for the first answer to one request to a drive, or to all of them."""
        drive = self._drive(node)
        if request is None:
            drive.clear()
        else:
            drive.forget(request)

    def settle(self, node: int) -> None:
        """Report that a drive is known to be at rest, so that its motions have ended.

        Otherwise the next motion would seem to supersede a motion whose end was never reported.
        """
        self._drive(node).settle()

    def _drive(self, node: int) -> OpenRequests:
        if node not in self._drives:
            raise LocalProtocolError(f"no drive of this host has the id {node}")
        return self._drives[node]

    def _hear(self, frame: Frame) -> Event:
        drive = self._drives.get(frame.can_id)
        if drive is None or frame.extended or frame.remote:
            return Foreign(frame)
        awaited = drive.awaited(frame.data[0]) if frame.data else None
        try:
            answer = decode_answer(frame, setting=isinstance(awaited, ReadSetting))
        except RemoteProtocolError as error:
            return UnreadableFrame(frame, str(error))
        event = drive.receive(answer)
        if isinstance(event, Stray) and answer.code is Code.NODE:
            return self._by_new_id(frame.can_id, event)
        return event

    def _by_new_id(self, node: int, event: Stray) -> Event:
        """Match an answer from the new id of a drive after `SetId`."""
        for drive in self._drives.values():
            if drive.awaited(Code.NODE) == SetId(node):
                return drive.receive(event.answer)
        return event
