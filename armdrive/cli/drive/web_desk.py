"""Show the desk in a browser on this computer: `armdrive jog --web`.

The browser's page is textual-serve's. Each page that is opened has a desk in a process of its own,
with its arm; there is one at a time. When the page is closed that process is told to end, and when
this one dies it notices by itself.

Only this computer and this user get in. A page of anybody's that is open in the same browser can
reach this computer's own ports too, and a WebSocket asks no leave of its server. So the origin
counts, and a key that only the terminal has shown; both also where another user of the same
computer tries.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import re
import secrets
import shlex
import socket
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, cast
from urllib.parse import parse_qs, urlsplit

from armdrive.cli.arm_files import chosen_target
from armdrive.cli.presenter import say
from armdrive.errors import BadRequest

HOST = "127.0.0.1"
"""The only address that is listened on."""

KEY_BYTES = 24
PAGE, SOCKET = "/", "/ws"

POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "script-src 'self' 'unsafe-inline' 'unsafe-eval'; connect-src 'self' ws://{host}; "
    "frame-ancestors 'none'"
)
"""What the page may load, nothing of anybody else's; and no other page may show it inside."""


@dataclass(frozen=True, slots=True)
class Visit:
    """What a browser says when it asks for something."""

    path: str
    host: str
    origin: str = ""
    given: str = ""
    """The key in the address."""
    kept: str = ""
    """The key in the cookie."""


@dataclass(frozen=True, slots=True)
class Door:
    """One desk's address and key."""

    port: int
    key: str = field(default_factory=lambda: secrets.token_urlsafe(KEY_BYTES))

    @property
    def host(self) -> str:
        """What a browser has to call this computer."""
        return f"{HOST}:{self.port}"

    @property
    def address(self) -> str:
        """What is opened in the browser."""
        return f"http://{self.host}{PAGE}?key={self.key}"

    @property
    def cookie(self) -> str:
        """The cookie's name: one browser may have the desks of several ports."""
        return f"armdrive-{self.port}"

    @property
    def headers(self) -> dict[str, str]:
        """What every answer says beside its content."""
        policy = POLICY.format(host=self.host)
        return {"Content-Security-Policy": policy, "Referrer-Policy": "no-referrer"}

    def refusal(self, visit: Visit) -> str:
        """Return why a browser is not let in; nothing where it is."""
        if visit.host != self.host:
            return f"this desk is at http://{self.host}, and is called nothing else"
        if visit.origin not in ("", f"http://{self.host}"):
            return "another page asked for this: a desk is opened by its own address alone"
        if visit.path == SOCKET and not visit.origin:
            return "a desk is opened by a browser"
        shown = visit.kept or visit.given if visit.path != PAGE else visit.given or visit.kept
        # a cookie may have any bytes, of which some decode to what no encoding has
        if not secrets.compare_digest(shown.encode(errors="replace"), self.key.encode()):
            return "open the whole address that `armdrive jog --web` has printed, with its key"
        return ""


# Reads the head of each request before the web server sees a byte of it. A web server answers what
# it cannot parse with its name and version, and logs it. Here a connection reaches the server only
# when its first request carries the key. Everything else gets one plain 403, which says only how to
# open the desk.

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


# Serving the desk.

SHUTDOWN_S = 2.0
"""So long a page may take to be told that the server ends."""

HIGHEST_PORT = 65535
"""Ports are numbers of sixteen bits."""

ENDING_S = 3.0
"""So long a page waits for the desk of one that was closed, as when it is loaded again."""

BUSY = "there is a desk in another tab, or one is just ending: close it, then load this page again"

SWITCHES = ("ascii", "setup", "fresh")
VALUES = ("keys", "model", "arm", "sim", "port", "dialect", "baud", "gamepad")
"""Options that the desk behind a page is given on."""


def jog_web(options: argparse.Namespace) -> int:
    """Serve the desk until somebody ends it, and return the exit code."""
    try:
        from aiohttp import web
        from textual_serve.server import Server
    except ModuleNotFoundError:
        raise BadRequest(
            "a desk in a browser needs textual-serve: pip install 'armdrive[web]'"
        ) from None
    if options.model is None:
        chosen_target(options)  # what is wrong with it is said before anybody opens a page
    listening = _listen(options.web_port)
    door = Door(listening.getsockname()[1])
    server: Any = Server(  # Any, as its method `on_startup` is replaced below
        command(options),
        host=HOST,
        port=door.port,
        title="armdrive",
        public_url=f"http://{door.host}",
    )
    server.on_startup = _quietly
    say(f"the desk is at {door.address}")
    say("click into the page once: until then the browser keeps the keys, the space bar too")
    say("only this computer reaches it; closing the page stops the arm, ctrl+c ends this")
    with contextlib.suppress(web.GracefulExit, KeyboardInterrupt):
        asyncio.run(_serve(server, web, door, listening))
    return 0


def _listen(port: int) -> socket.socket:
    if port > HIGHEST_PORT:
        raise BadRequest(f"--web-port is at most {HIGHEST_PORT}, not {port}")
    try:
        return socket.create_server((HOST, port))
    except OSError as error:
        why = error.strerror or error
        raise BadRequest(
            f"port {port} cannot be listened on ({why}): name another one, --web-port"
        ) from None


def command(options: argparse.Namespace) -> str:
    """Return the command line of the desk behind a page, which replaces its shell."""
    return "exec " + shlex.join(_words(options))


def _words(options: argparse.Namespace) -> Iterator[str]:
    yield from (sys.executable, "-m", "armdrive", "jog", "--served")
    if options.reconnect:
        yield "--reconnect"
    for name in SWITCHES:
        if getattr(options, name):
            yield f"--{name}"
    for name in VALUES:
        if (value := getattr(options, name)) is not None:
            yield f"--{name}={value}"


async def _serve(server: Any, web: Any, door: Door, listening: socket.socket) -> None:
    """Serve until a signal ends it, which raises `GracefulExit` out of the loop."""
    app = await _guarded(server, web, door)
    runner = web.AppRunner(app, handle_signals=True, access_log=None, shutdown_timeout=SHUTDOWN_S)
    await runner.setup()
    try:
        loop = asyncio.get_running_loop()
        async with await loop.create_server(Porch(door, runner.server), sock=listening):
            await asyncio.Event().wait()
    finally:
        await runner.cleanup()


async def _guarded(server: Any, web: Any, door: Door) -> Any:
    """Return the application behind its door."""
    app = await server._make_app()  # noqa: SLF001 - its `serve` listens and logs in its own way
    app.middlewares.append(guard(web, door))
    return app


def guard(web: Any, door: Door) -> Any:
    """Return what lets nobody in who may not come, and one at a time."""
    free = asyncio.Event()
    free.set()

    async def let_in(request: Any, handler: Any) -> Any:
        if why := door.refusal(_visit(request, door)):
            return web.Response(status=403, text=why)
        if request.path in (PAGE, SOCKET) and not await _soon(free):
            return web.Response(status=409, text=BUSY)
        if request.path != SOCKET:
            response = await handler(request)
            response.headers.update(door.headers)
            if request.path == PAGE:
                response.set_cookie(door.cookie, door.key, httponly=True, samesite="Strict")
            return response
        if not web.WebSocketResponse().can_prepare(request):
            return web.Response(status=400, text="this is no WebSocket")
        free.clear()
        try:
            return await handler(request)
        finally:
            free.set()

    return web.middleware(let_in)


async def _soon(free: asyncio.Event) -> bool:
    """Wait a moment for the desk of a page that was closed to end; tell whether it has."""
    with contextlib.suppress(TimeoutError):
        await asyncio.wait_for(free.wait(), ENDING_S)
    return free.is_set()


def _visit(request: Any, door: Door) -> Visit:
    return Visit(
        path=request.path,
        host=request.host,
        origin=request.headers.get("Origin", ""),
        given=request.query.get("key", ""),
        kept=request.cookies.get(door.cookie, ""),
    )


async def _quietly(app: Any) -> None:
    """Say nothing of the server's own: where the desk is has been said."""
    del app
