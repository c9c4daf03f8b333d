"""Scripts: generators that send something to a device and wait for its answer.

A script yields the time until which it waits. It is resumed with a message from the codec, or with
None when that time has come or a stop is requested. Its return value answers the request, or the
reply of an `Obstructed` that it raises.

A controller answers requests with scripts (`controller.ScriptRunner`). The scripts share a
`ScriptIO`: the wire, the time and the stop flag. Work that is no request of an arm, such as a
survey of a bus, runs in a bare `ScriptLoop`.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Generator, Iterable, Sequence
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

from armdrive.errors import ArmError, WrongState
from armdrive.tasks import SWITCHED_ON, Event, Reply, RequestRejected, Timeout

# The messages of the dialect's codec.
H = TypeVar("H")
H_co = TypeVar("H_co", covariant=True)
T = TypeVar("T")
Script: TypeAlias = Generator[float, H | None, T]

# How often a message that is safe to repeat is sent: a bad line loses one in ten.
TRIES = 3

# A script that is resumed more often than this at one moment is broken, and is ended.
MOST_TURNS = 10_000


class Obstructed(Exception):
    """Ends a script early: its request cannot be carried out, or not completely.

    Carries the reply to the request. Plain words mean that nothing of it was carried out.
    """

    def __init__(self, reply: Reply | str) -> None:
        super().__init__(str(reply))
        self.reply = RequestRejected(reply, moved=False) if isinstance(reply, str) else reply


class Codec(Protocol[H_co]):
    """The receiving side of a dialect's codec."""

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the device."""

    def next_event(self) -> H_co | None:
        """Return the next message, or None."""


class ListenedTime:
    """The time during which this program has listened: all except the time it was called late.

    Deadlines of devices are in this time. A program that is called late has sent nothing meanwhile
    and has not read the replies; so it reads them first, and only then misses any.
    """

    def __init__(self) -> None:
        self.s = 0.0
        self._now_s = self._due_s = math.inf

    def pass_to(self, now_s: float) -> None:
        """Record that the program is called at a time."""
        if now_s == self._now_s:  # as nearly always: it reads and writes at one moment
            return
        # time after the due call was spent elsewhere, and does not count
        self.s += max(min(now_s, self._due_s) - self._now_s, 0.0)
        self._now_s = now_s

    def expect(self, due_s: float) -> None:
        """Record when the program wants to be called next."""
        self._due_s = due_s


class Received(Generic[H]):
    """A codec that turns bytes into messages with `feed`, and never replies."""

    def __init__(self, feed: Callable[[bytes], Iterable[H]]) -> None:
        self._feed = feed
        self._come: deque[H] = deque()

    def receive_data(self, data: bytes) -> None:
        """Take bytes from the device."""
        self._come.extend(self._feed(data))

    def next_event(self) -> H | None:
        """Return the next message, or None."""
        return self._come.popleft() if self._come else None


class ScriptIO(Generic[H]):
    """What a script works with: the wire, the events for the engine, the time, the stop flag.

    `on_unsolicited` takes the messages that no script waits for.
    """

    look_at = SWITCHED_ON
    """What to check if the device does not answer."""

    def __init__(self, on_unsolicited: Callable[[H], None]) -> None:
        self.on_unsolicited = on_unsolicited
        self.last_command = ""
        """The last command sent, as text for people."""
        self.now_s = 0.0
        self.stop_asked = False
        self.stop_hard = False
        self.overdue = False
        """Whether the message that `wait_for` returned last arrived after its deadline. Then this
        program was suspended, and the measured time says nothing about the device."""
        self.heard_s = -math.inf
        """When bytes arrived last."""
        self.listened = ListenedTime()
        self.out = bytearray()
        """Bytes to write when the controller is called next."""
        self.events: deque[Event] = deque()
        """Events that the engine has not fetched yet."""

    def write(self, data: bytes, text: str = "") -> None:
        """Put bytes on the wire, with a text for people unless they are a mere poll."""
        self.out += data
        self.last_command = text or self.last_command

    def notify(self, event: Event) -> None:
        """Pass an event to the engine."""
        self.events.append(event)

    def wait_for(
        self, until_s: float, wanted: Callable[[H], bool], *, until_stop: bool = False
    ) -> Script[H, H | None]:
        """Wait for a wanted message; None at the deadline, or at a stop with `until_stop`.

        Everything that has arrived is read before the deadline counts: this program may be late,
        and the answer may follow other messages.
        """
        while not (until_stop and self.stop_asked):
            message = yield until_s
            if message is None:
                if self.now_s >= until_s:
                    return None
                continue
            if wanted(message):
                self.overdue = self.now_s > until_s
                return message
            self.on_unsolicited(message)
        return None

    def collect(
        self,
        seconds: float,
        enough: Callable[[Sequence[H]], bool] = lambda _messages: False,
        linger_s: float = 0.0,
    ) -> Script[H, tuple[H, ...]]:
        """Return the messages of a time span, or until they are `enough`, plus `linger_s`."""
        messages: list[H] = []
        until_s, awaited = self.now_s + seconds, True
        while True:
            more = yield until_s
            if more is not None:
                messages.append(more)
                if awaited and enough(messages):
                    until_s, awaited = self.now_s + linger_s, False
            elif self.now_s >= until_s:
                return tuple(messages)

    def pause(self, until_s: float) -> Script[H, None]:
        """Wait until a moment, or until a stop is requested."""
        asked = self.stop_asked  # a script that is already stopping may pause as well
        while self.now_s < until_s and self.stop_asked == asked:
            message = yield until_s
            if message is not None:
                self.on_unsolicited(message)

    def silence(self, since_s: float, note: str = "") -> Timeout:
        """Return the reply to a request that the device did not answer."""
        return Timeout(self.last_command, self.now_s - since_s, self.look_at, note)


class ScriptLoop(Generic[H]):
    """Runs one script at a time over a codec.

    Controllers, surveys and commissioning use it.
    """

    def __init__(self, codec: Codec[H], io: ScriptIO[H]) -> None:
        self.io = io
        self._codec = codec
        self._script: Script[H, Any] | None = None
        self._until_s = math.inf

    @property
    def busy(self) -> bool:
        """Whether a script is running."""
        return self._script is not None

    def begin(self, script: Callable[[], Script[H, Any]], now_s: float) -> None:
        """Start a script. Raises `ValueError` if the dialect cannot express the request."""
        if self._script is not None:
            raise WrongState("a request is unanswered: wait for its answer, or forget it")
        self.io.now_s = now_s
        self.io.stop_asked = self.io.stop_hard = False
        self._script = script()
        try:
            self._run(None)
        except (ValueError, ArmError):
            # refused: the caller gets the error, the device gets nothing
            self._script = None
            self.io.out.clear()
            raise

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes from the device."""
        self.io.listened.pass_to(now_s)
        self.io.now_s = now_s
        if data:
            self.io.heard_s = now_s
        self._codec.receive_data(data)
        while (message := self._codec.next_event()) is not None:
            if self._script is None:
                self.io.on_unsolicited(message)
            else:
                self.step(message)

    def advance(self, now_s: float) -> bytes:
        """Resume the script if it is due, and return the bytes to write."""
        self.io.listened.pass_to(now_s)
        self.io.now_s = now_s
        turns = 0
        while self._script is not None and self._until_s <= now_s:
            self.step(None)
            turns += 1
            if turns > MOST_TURNS:
                self._script = None
                self.io.notify(
                    RequestRejected(
                        f"the script of `{self.io.last_command}` waits for a time that has passed"
                    )
                )
        data = bytes(self.io.out)
        self.io.out.clear()
        self.io.listened.expect(self.next_s())
        return data

    def next_s(self) -> float:
        """Return when to resume the script if no message comes first."""
        if self.io.out:
            return self.io.now_s
        return self._until_s if self._script is not None else math.inf

    def next_event(self) -> Any:
        """Return the next event; a script that has ended leaves its return value."""
        return self.io.events.popleft() if self.io.events else None

    def stop(self, *, hard: bool) -> None:
        """Resume the script with its stop flag set, at once."""
        if self._script is None or (self.io.stop_asked and self.io.stop_hard >= hard):
            return
        self.io.stop_asked, self.io.stop_hard = True, hard
        self._until_s = -math.inf  # whatever it waits for, it is due now

    def abandon(self) -> None:
        """End the script and drop its unsent bytes; bytes that it sends while it closes remain."""
        self.io.out.clear()
        if self._script is not None:
            self._script.close()
            self._script = None

    def step(self, message: H | None) -> None:
        """Resume the script with a message, or with None."""
        try:
            self._run(message)
        except ValueError as error:  # in mid-script: a message that the dialect cannot express
            self._script = None
            self.io.notify(RequestRejected(str(error)))

    def _run(self, message: H | None) -> None:
        script = self._script
        if script is None:
            return
        try:
            self._until_s = script.send(message)
        except StopIteration as end:
            self._end(end.value)
        except Obstructed as obstructed:
            self._end(obstructed.reply)

    def _end(self, result: Any) -> None:
        self._script, self._until_s = None, math.inf
        self.io.notify(result)
