"""The TeachMover's own program over the wire: a dump, whose end is a silence.

Nothing marks the end of a dump, so it is over when no byte has come for longer than a row takes.
"""

from __future__ import annotations

from collections.abc import Callable, Generator

from armdrive.controllers.program_requests import Program
from armdrive.controllers.requests import Denied, Reply
from firmware_protocol.teachmover import MAX_ROWS, Completed, Garbled, Host, QDump, Status
from firmware_protocol.teachmover.host import Event as HostEvent

LONGEST_ROW = len("-32768," * 8)
"""Characters of a row at most, its CR for the last comma."""

ENDLESS = 2.0
"""A dump that takes so many times as long as the longest one does is not one."""


class Dump:
    """One dump being taken in: how long it is waited for, and what it came to.

    `byte_s` is a character's time on the wire, and `margin_s` what a row may be late.
    """

    def __init__(self, host: Host, byte_s: float, margin_s: float) -> None:
        self._host = host
        self.data = host.send(QDump())
        self._first_s = (len(self.data) + len("1\r")) * byte_s + margin_s
        self._pause_s = LONGEST_ROW * byte_s + margin_s
        self._longest_s = self._first_s + MAX_ROWS * LONGEST_ROW * byte_s * ENDLESS
        self._bad = ""
        self._ended: Completed | None = None

    def heard(self, event: HostEvent | None) -> None:
        """Take what the codec says: a row that cannot be read spoils the whole."""
        if isinstance(event, Completed):
            self._ended = event
        elif isinstance(event, Garbled):
            self._bad = self._bad or event.reason

    def wait(
        self, began_s: float, now_s: Callable[[], float], last_byte_s: Callable[[], float]
    ) -> Generator[float, HostEvent | None, None]:
        """Wait until the rows are over, or nothing has come that could be one."""
        while self._ended is None:
            until_s = began_s + self._first_s
            if self._host.dumping:
                until_s = min(last_byte_s() + self._pause_s, began_s + self._longest_s)
            if now_s() >= until_s:
                return
            self.heard((yield until_s))

    def reply(self) -> Reply | None:
        """Return what was asked for, or why not; None where nothing answered."""
        if self._host.dumping:
            self._host.end_dump()
            while self._ended is None:  # half a row first, where it broke off in one
                self.heard(self._host.next_event())
        if self._ended is None:
            return None
        if self._bad:
            return Denied(f"its program cannot be read: {self._bad}", moved=False)
        if self._ended.status is not Status.DONE:
            return Denied("it does not tell its program", moved=False)
        return Program(tuple(row.words for row in self._ended.rows))
