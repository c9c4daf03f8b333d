"""Reads the head of each request to the desk's port, before the web server sees a byte of it.

A web server answers what it cannot parse by itself, with its name and version, and logs it. Here a
connection is handed to it only when its first request carries the key. Everything else, however it
is malformed, gets one plain 403 that says no more than how the desk is opened.
"""

from __future__ import annotations

import asyncio
import re
from collections.abc import Callable
from typing import cast
from urllib.parse import parse_qs, urlsplit

from armdrive.cli.jog_door import Door, Visit

MOST_HEAD_BYTES = 16384
"""A browser's head takes one or two thousand."""

HEAD_S = 5.0
"""Within this time a head has to be whole, however many bytes of it come."""

LINGER_S = 2.0
"""A refused caller may take this long to read why; what it still sends is thrown away."""

MOST_CALLERS = 64
"""Connections without a whole head, or refused; the oldest goes when there are more."""

UNREADABLE = "this is no request that a browser makes"

_END = b"\r\n\r\n"
_PLAIN = re.compile(rb"[\t\r\n\x20-\x7e]*")
_LONE = ("host", "origin", "cookie")
"""Headers that decide who is let in: with two of a name, two readers could take different ones."""


class Porch:
    """Makes the first protocol of each connection; `inside` makes the web server's."""

    def __init__(self, door: Door, inside: Callable[[], asyncio.Protocol]) -> None:
        self.door = door
        self.inside = inside
        self.callers: dict[Caller, None] = {}

    def __call__(self) -> Caller:
        """Return the protocol of one more connection."""
        return Caller(self)


class Caller(asyncio.Protocol):
    """One connection, until it is handed on or has ended."""

    def __init__(self, porch: Porch) -> None:
        self._porch = porch
        self._head = b""
        self._refused = False
        self._transport: asyncio.Transport | None = None
        self._end: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Give the caller its time, and let the oldest go where there are too many."""
        self._transport = cast(asyncio.Transport, transport)
        self._end_after(HEAD_S)
        self._porch.callers[self] = None
        if len(self._porch.callers) > MOST_CALLERS:
            next(iter(self._porch.callers)).abort()

    def data_received(self, data: bytes) -> None:
        """Take more of the head; hand the connection on, or refuse it, once that is whole."""
        if self._refused or self._transport is None:
            return
        self._head += data
        if _END not in self._head and len(self._head) <= MOST_HEAD_BYTES:
            return
        visit = visit_of(self._head, self._porch.door)
        if why := UNREADABLE if visit is None else self._porch.door.refusal(visit):
            self._refuse(self._transport, why)
        else:
            self._hand_on(self._transport)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002
        """Forget the connection."""
        self._leave()

    def abort(self) -> None:
        """End the connection without a word."""
        self._leave()
        if self._transport is not None:
            self._transport.abort()

    def _hand_on(self, transport: asyncio.Transport) -> None:
        self._leave()
        inside = self._porch.inside()
        transport.set_protocol(inside)
        inside.connection_made(transport)
        inside.data_received(self._head)

    def _refuse(self, transport: asyncio.Transport, why: str) -> None:
        """Say why. A close at once would be a reset for a caller that still sends."""
        self._refused, self._head = True, b""
        transport.write(refusal(why))
        if transport.can_write_eof():
            transport.write_eof()
        self._end_after(LINGER_S)

    def _end_after(self, time_s: float) -> None:
        if self._end is not None:
            self._end.cancel()
        self._end = asyncio.get_running_loop().call_later(time_s, self.abort)

    def _leave(self) -> None:
        if self._end is not None:
            self._end.cancel()
        self._porch.callers.pop(self, None)


def refusal(why: str) -> bytes:
    """Return the answer to everything that is not let in."""
    text = why.encode()
    head = (
        "HTTP/1.1 403 Forbidden\r\nContent-Type: text/plain; charset=utf-8\r\n"
        f"Content-Length: {len(text)}\r\nConnection: close\r\n\r\n"
    )
    return head.encode() + text


def visit_of(head: bytes, door: Door) -> Visit | None:
    """Return what a head says of its caller; None where it is not whole, or no browser's."""
    head, end, _ = head.partition(_END)
    if not end or len(head) > MOST_HEAD_BYTES or not _PLAIN.fullmatch(head):
        return None
    first, *lines = head.decode("ascii").split("\r\n")
    words = first.split(" ")
    fields = [line.partition(":") for line in lines]
    names = [name.lower() for name, _, _ in fields]
    if len(words) != 3 or not words[1].startswith("/"):
        return None
    if any(names.count(name) > 1 for name in _LONE):
        return None
    said = {name: value.strip() for name, (_, _, value) in zip(names, fields, strict=True)}
    try:
        target = urlsplit(words[1])
        given = parse_qs(target.query).get("key", [""])
    except ValueError:
        return None
    kept = [
        value.strip()
        for name, _, value in (each.partition("=") for each in said.get("cookie", "").split(";"))
        if name.strip() == door.cookie
    ]
    return Visit(
        path=target.path,
        host=said.get("host", ""),
        origin=said.get("origin", ""),
        given=given[0],
        kept=kept[-1] if kept else "",
    )
