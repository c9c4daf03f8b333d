"""Carries out a talk: requests on a link, questions to a person. Stops what it has moved."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable, Mapping
from typing import Any, Protocol, TypeVar

from armdrive.dialects.bus.tools import BusHost
from armdrive.dialog.conversation import (
    Act,
    Announce,
    AskPerson,
    Hear,
    Keep,
    NotePosture,
    Put,
    Stands,
    Talk,
)
from armdrive.errors import LinkError
from armdrive.setup.prober import Clock
from armdrive.transports.link import Link

T = TypeVar("T")

STOPS = 3
"""A stop is said so often: a frame can be lost."""
BETWEEN_S = 0.01


class DialogPerson(Protocol):
    """Who is told, is asked, and looks at the arm."""

    def tell(self, text: str) -> None:
        """Hear a line."""

    def answer(self, asked: AskPerson) -> Any:
        """Answer a question, by its reader's value."""

    def watch(self, motor: int) -> None:
        """Look how the arm stands, before a motor turns."""


class NobodyFound:
    """A survey asks no person anything."""

    def tell(self, text: str) -> None:
        """Say nothing."""

    def watch(self, motor: int) -> None:
        """See nothing."""

    def answer(self, asked: AskPerson) -> object:
        """Refuse: there is no question in a survey."""
        raise NotImplementedError(asked.question.words)


class DialogClock:
    """Time on a simulated bus: it passes when somebody waits."""

    def __init__(self) -> None:
        self._now_s = 0.0

    def now_s(self) -> float:
        """Return the time."""
        return self._now_s

    def sleep(self, link: Link, until_s: float) -> None:
        """Jump to when something may have come, or to a moment."""
        self._now_s = min(max(link.next_s(), self._now_s), until_s)


class DialogRunner:
    """One link and the protocol spoken on it, one clock, one person."""

    def __init__(
        self,
        link: Link,
        host: BusHost,
        clock: Clock,
        person: DialogPerson,
        keep: Callable[[Mapping[str, Any]], None] = lambda _notes: None,
    ) -> None:
        self._link = link
        self._clock = clock
        self._person = person
        self._keep = keep
        self._host = host
        self._moving: dict[int, Any] = {}

    def run(self, talk: Talk[T]) -> T:
        """Carry out a talk to its end; whatever ends it early stops what it has set in motion."""
        result: Any = None
        try:
            while True:
                result = self._do(talk.send(result))
        except StopIteration as end:
            found: T = end.value
            return found
        except BaseException:
            self.stop()
            raise

    def stop(self) -> None:
        """Stop every drive that may be in motion, by all words that there are for it."""
        with contextlib.suppress(LinkError):
            for _ in range(STOPS if self._moving else 0):
                for node, request in self._moving.items():
                    for data in self._host.stop(node, request):
                        self._link.write(data, self._clock.now_s())
                self._listen(BETWEEN_S)
        self._moving.clear()

    def _do(self, act: Act) -> Any:
        match act:
            case Announce(text):
                self._person.tell(text)
            case AskPerson():
                return self._person.answer(act)
            case NotePosture(motor):
                self._person.watch(motor)
            case Keep(notes):
                self._keep(notes)
            case Stands(node):
                self._moving.pop(node, None)
                self._host.settle(node)
            case Hear(seconds):
                return self._listen(seconds)
            case Put():
                return self._put(act)
        return None

    def _put(self, act: Put[Any]) -> tuple[Any, ...]:
        self._listen(0.0)  # what came before answers nothing of this
        if self._host.moves(act.request):
            self._moving[act.node] = act.request
        self._link.write(self._host.send(act.node, act.request), self._clock.now_s())
        return self._listen(act.wait_s, act.linger_s, act.request)

    def _listen(
        self, seconds: float, linger_s: float = 0.0, awaited: Any | None = None
    ) -> tuple[Any, ...]:
        """Return what is heard in so long a time, or a while after the first answer."""
        heard: list[Any] = []
        end_s = self._clock.now_s() + seconds
        while True:
            self._host.receive_data(self._link.read(self._clock.now_s()))
            while (event := self._host.next_event()) is not None:
                heard.append(event)
                if awaited is not None and self._host.answers(event, awaited):
                    end_s, awaited = min(end_s, self._clock.now_s() + linger_s), None
            if self._clock.now_s() >= end_s or not math.isfinite(end_s):
                return tuple(heard)
            self._clock.sleep(self._link, end_s)
