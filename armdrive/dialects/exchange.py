"""Scripts: generators that say something to a device and wait for its answer.

A script yields the time until which it waits, and is resumed with what the codec heard, or with
None when the time is over or a stop was asked for. What it returns answers the request.

A controller answers requests by scripts (`controller.ScriptRunner`) and holds what they work with
(`ScriptIO`), which it hands to its collaborators. What is no request of an arm, such as a survey of
a bus, runs in a bare `ScriptLoop`.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Generator, Iterable, Sequence
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

from armdrive.errors import ArmError, WrongState
from armdrive.tasks import SWITCHED_ON, Event, RequestRejected, Timeout

H = TypeVar("H")
"""What the dialect's codec hears."""
H_co = TypeVar("H_co", covariant=True)
T = TypeVar("T")
Script: TypeAlias = Generator[float, H | None, T]

MOST_TURNS = 10_000
"""A script that goes round more often without time passing is broken, and is ended."""

BITS_A_BYTE = 10
"""A start bit, eight data bits and a stop bit."""


class Codec(Protocol[H_co]):
    """The receiving side of a dialect's host machine."""

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the device."""

    def next_event(self) -> H_co | None:
        """Return the next thing heard."""


class Received(Generic[H]):
    """A codec that makes of bytes what `feed` makes of them, and answers nothing."""

    def __init__(self, feed: Callable[[bytes], Iterable[H]]) -> None:
        self._feed = feed
        self._come: deque[H] = deque()

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the device."""
        self._come.extend(self._feed(data))

    def next_event(self) -> H | None:
        """Return the next thing heard."""
        return self._come.popleft() if self._come else None


class ScriptIO(Generic[H]):
    """What a script works with: the wire, the engine's ear, the time, and whether to stop.

    `on_unasked` weighs what no script was waiting for: see `controller.ScriptRunner.unasked`.
    """

    look_at = SWITCHED_ON
    """What a person does about a device that does not answer."""

    def __init__(self, on_unasked: Callable[[H], None]) -> None:
        self.on_unasked = on_unasked
        self.said = ""
        """The text of the message sent last, for people."""
        self.now_s = 0.0
        self.stop_asked = False
        self.stop_hard = False
        self.overdue = False
        """Whether what `hear` returned last came when it was waited for no longer: this program
        stood still meanwhile, and a time measured so says nothing about the device."""
        self.out = bytearray()
        """What is to be written when the controller is called next."""
        self.events: deque[Event] = deque()
        """What the engine has not fetched yet."""

    def say(self, data: bytes, text: str = "") -> None:
        """Put bytes on the wire; with a text for people where they are more than a poll."""
        self.out += data
        self.said = text or self.said

    def tell(self, event: Event) -> None:
        """Give an event to the engine."""
        self.events.append(event)

    def hear(
        self, until_s: float, wanted: Callable[[H], bool], *, until_stop: bool = False
    ) -> Script[H, H | None]:
        """Wait for a message of a kind; None when the time is over, or at a stop if told so.

        What has come is read to its end before the time is found to be over: this program may be
        late, and the answer stand behind something else.
        """
        while not (until_stop and self.stop_asked):
            heard = yield until_s
            if heard is None:
                if self.now_s >= until_s:
                    return None
                continue
            if wanted(heard):
                self.overdue = self.now_s > until_s
                return heard
            self.on_unasked(heard)
        return None

    def collect(
        self,
        seconds: float,
        enough: Callable[[Sequence[H]], bool] = lambda _heard: False,
        linger_s: float = 0.0,
    ) -> Script[H, tuple[H, ...]]:
        """Return what is heard in so long a time, or until it is enough and a while longer."""
        heard: list[H] = []
        until_s, awaited = self.now_s + seconds, True
        while True:
            more = yield until_s
            if more is not None:
                heard.append(more)
                if awaited and enough(heard):
                    until_s, awaited = self.now_s + linger_s, False
            elif self.now_s >= until_s:
                return tuple(heard)

    def pause(self, until_s: float) -> Script[H, None]:
        """Let time pass until a moment, or until a stop is asked for."""
        asked = self.stop_asked
        while self.now_s < until_s and self.stop_asked == asked:
            heard = yield until_s
            if heard is not None:
                self.on_unasked(heard)

    def silence(self, since_s: float) -> Timeout:
        """Return the reply that says that nothing answered."""
        return Timeout(self.said, self.now_s - since_s, self.look_at)


class ScriptLoop(Generic[H]):
    """Runs one script at a time over a codec, whatever it is for.

    A controller has its requests run so, and so do a survey and whoever sets a device up. `unasked`
    weighs what no script was waiting for.
    """

    def __init__(
        self, codec: Codec[H], io: ScriptIO[H], unasked: Callable[[H], None] | None = None
    ) -> None:
        self.io = io
        self._codec = codec
        self._unasked = unasked or io.on_unasked
        self._script: Script[H, Any] | None = None
        self._until_s = math.inf

    @property
    def busy(self) -> bool:
        """Tell whether a script is at work."""
        return self._script is not None

    def begin(self, script: Callable[[], Script[H, Any]], now_s: float) -> None:
        """Make a script and begin it; raises `ValueError` where the dialect cannot express it."""
        if self._script is not None:
            raise WrongState("a request is unanswered: wait for its answer, or forget it")
        self.io.now_s = now_s
        self.io.stop_asked = self.io.stop_hard = False
        self._script = script()
        try:
            self._run(None)
        except (ValueError, ArmError):
            self._script = None
            self.io.out.clear()
            raise

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the device."""
        self.io.now_s = now_s
        self._codec.receive_data(data)
        while (heard := self._codec.next_event()) is not None:
            if self._script is None:
                self._unasked(heard)
            else:
                self.step(heard)

    def advance(self, now_s: float) -> bytes:
        """Do what is due by now, and return the bytes to be written."""
        self.io.now_s = now_s
        turns = 0
        while self._script is not None and self._until_s <= now_s:
            self.step(None)
            turns += 1
            if turns > MOST_TURNS:
                self._script = None
                self.io.tell(
                    RequestRejected(f"the script of `{self.io.said}` waits for what is over")
                )
        data = bytes(self.io.out)
        self.io.out.clear()
        return data

    def next_s(self) -> float:
        """Tell when the script wants to go on even if nothing is heard."""
        if self.io.out:
            return self.io.now_s
        return self._until_s if self._script is not None else math.inf

    def next_event(self) -> Any:
        """Return the next thing told: of a script that has ended, what it returned."""
        return self.io.events.popleft() if self.io.events else None

    def stop(self, *, hard: bool) -> None:
        """Have the script know of a stop, at once."""
        if self._script is None or (self.io.stop_asked and self.io.stop_hard >= hard):
            return
        self.io.stop_asked, self.io.stop_hard = True, hard
        self._until_s = -math.inf

    def forget(self) -> None:
        """Give up the script, and what it has said and nobody has fetched.

        What a script says as it is closed is left to be said.
        """
        self.io.out.clear()
        if self._script is not None:
            self._script.close()
            self._script = None

    def step(self, heard: H | None) -> None:
        """Resume the script with what was heard, or with nothing."""
        try:
            self._run(heard)
        except ValueError as error:  # in mid-script: a message that the dialect cannot express
            self._script = None
            self.io.tell(RequestRejected(str(error)))

    def _run(self, heard: H | None) -> None:
        script = self._script
        if script is None:
            return
        try:
            self._until_s = script.send(heard)
        except StopIteration as end:
            self._script, self._until_s = None, math.inf
            self.io.tell(end.value)
