"""What one MKS drive is expected to say: for each answer that comes, the request it belongs to."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain

from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.mks.actions import EmergencyStop, Motion, Restart
from firmware_protocol.mks.course import Course
from firmware_protocol.mks.events import Answered, Done, Event, Failed, Reported, Stray
from firmware_protocol.mks.identity import SettingRead
from firmware_protocol.mks.outcomes import Status
from firmware_protocol.mks.reads import Read, ReadSetting, ReportByItself
from firmware_protocol.mks.values import Code, Outcome
from firmware_protocol.mks.wire import Answer, Request


def answer_code(request: Request) -> Code:
    """Return the code that the answer to a request has."""
    return request.setting if isinstance(request, ReadSetting) else request.code


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
