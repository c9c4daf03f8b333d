"""A driver's end on simulated time, without the engine between; what is at its wire is added."""

from __future__ import annotations

from collections.abc import Callable

from armdrive.dialects.controller import Controller
from armdrive.tasks import Alert, Event, Progress, ProtocolWarning, SwitchOn
from firmware_protocol.frames import Frame


class DriverBench:
    """A controller whose requests are carried out while time passes."""

    def __init__(self, controller: Controller) -> None:
        self.controller = controller
        self.now_s = 0.0
        self.heard: list[Event] = []
        self.sent: list[tuple[float, Frame]] = []
        self.dead = False
        """Whether the host does nothing any more."""
        self.at_s: dict[float, Callable[[], object]] = {}

    def do(self, request, longest_s: float = 20.0):
        """Carry out a request, and return its reply."""
        self.begin(request)
        return self.finish(longest_s)

    def begin(self, request) -> None:
        """Hand a request over."""
        self.controller.begin(request, self.now_s)
        self._speak()

    def finish(self, longest_s: float = 20.0):
        """Let time pass until the request is answered."""
        end_s = self.now_s + longest_s
        while self.now_s < end_s:
            if (reply := self.reply()) is not None:
                return reply
            self._step(end_s)
        raise AssertionError("no reply")

    def run(self, time_s: float) -> None:
        """Let time pass."""
        end_s = self.now_s + time_s
        while self.now_s < end_s:
            self._step(end_s)

    def ready(self):
        """Switch the drives on."""
        reply = self.do(SwitchOn())
        assert str(reply) == "done", reply
        return self

    def alerts(self) -> list[Alert]:
        """Return what has alarmed so far, as far as it was fetched."""
        return [event for event in self.heard if isinstance(event, Alert)]

    def reply(self):
        """Return what the request has come to, None while nothing; note what else was heard."""
        while (event := self.controller.next_event()) is not None:
            self.heard.append(event)
            if not isinstance(event, Alert | ProtocolWarning | Progress):
                return event
        return None

    def _pass_to(self, end_s: float, times: list[float]) -> None:
        """Let time pass to the first of these times, and do what is due then."""
        if not self.dead:
            times.append(self.controller.next_s())
        self.now_s = max(self.now_s, min(end_s, *times, *self.at_s))
        for at_s in [at_s for at_s in self.at_s if at_s <= self.now_s]:
            self.at_s.pop(at_s)()

    def _step(self, end_s: float) -> None:
        raise NotImplementedError

    def _speak(self) -> None:
        raise NotImplementedError
