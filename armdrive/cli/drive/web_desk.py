"""Show the desk in a browser on this computer: `armdrive jog --web`.

textual-serve makes the browser's page. Each open page has a desk in a process of its own, with its
arm; there is one at a time. That process ends when its page is closed or this process dies.

Only this user on this computer gets in. Any other page in the same browser can reach the ports of
this computer too, and browsers let any page open a WebSocket. So every request needs the right
origin and a key that only the terminal has shown. Both also keep other users of the computer out.
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
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast
from urllib.parse import parse_qs, urlsplit

from armdrive.cli.arm_files import chosen_target
from armdrive.cli.options import ARM_OPTIONS, typed_again
from armdrive.cli.presenter import say
from armdrive.errors import BadRequest

HOST = "127.0.0.1"
"""The only address that the server listens on."""

KEY_BYTES = 24
PAGE, SOCKET = "/", "/ws"

POLICY = (
    "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; "
    "script-src 'self' 'unsafe-inline' 'unsafe-eval'; connect-src 'self' ws://{host}; "
    "frame-ancestors 'none'"
)
"""The page loads only its own content, and no other page may embed it."""


@dataclass(frozen=True, slots=True)
class Visit:
    """The parts of a browser's request that decide whether it gets in."""

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
        """The host that a browser's request has to name."""
        return f"{HOST}:{self.port}"

    @property
    def address(self) -> str:
        """The address to open in the browser."""
        return f"http://{self.host}{PAGE}?key={self.key}"

    @property
    def cookie(self) -> str:
        """The cookie's name: one browser may have the desks of several ports."""
        return f"armdrive-{self.port}"

    @property
    def headers(self) -> dict[str, str]:
        """The headers of every answer."""
        policy = POLICY.format(host=self.host)
        return {"Content-Security-Policy": policy, "Referrer-Policy": "no-referrer"}

    def refusal(self, visit: Visit) -> str:
        """Return why a request is refused, or "" if it is not."""
        if visit.host != self.host:
            return f"this desk is only at http://{self.host}"
        if visit.origin not in ("", f"http://{self.host}"):
            return "another page sent this request: open the desk by its own address"
        if visit.path == SOCKET and not visit.origin:
            return "only a browser can open a desk"
        shown = visit.kept or visit.given if visit.path != PAGE else visit.given or visit.kept
        # a cookie may have bytes that decode to characters which cannot be encoded again
        if not secrets.compare_digest(shown.encode(errors="replace"), self.key.encode()):
            return "open the whole address that `armdrive jog --web` has printed, with its key"
        return ""


# Reads the head of each request before the web server sees a byte of it. A web server answers a
# malformed request with its name and version, and logs it. Here a connection reaches the server
# only if its first request carries the key. Every other request gets one plain 403, which says only
# how to open the desk.

MOST_HEAD_BYTES = 16384
"""A browser's head has one or two thousand."""

HEAD_S = 5.0
"""Timeout for a complete head, however fast its bytes arrive."""

LINGER_S = 2.0
"""Time for a refused caller to read the reason; anything it still sends is discarded."""

MOST_CALLERS = 64
"""Connections without a complete head, or refused; beyond this number the oldest is closed."""

UNREADABLE = "this is not a browser's request"

_END = b"\r\n\r\n"
_PLAIN = re.compile(rb"[\t\r\n\x20-\x7e]*")
_LONE = ("host", "origin", "cookie")
"""Headers that decide access; two readers could pick different ones of a repeated header."""


class Porch:
    """Creates the first protocol of each connection; `inside` creates the web server's."""

    def __init__(self, door: Door, inside: Callable[[], asyncio.Protocol]) -> None:
        self.door = door
        self.inside = inside
        self.callers: dict[Caller, None] = {}

    def __call__(self) -> Caller:
        """Return the protocol of one more connection."""
        return Caller(self)


class Caller(asyncio.Protocol):
    """One connection, until it is handed to the web server or closed."""

    def __init__(self, porch: Porch) -> None:
        self._porch = porch
        self._head = b""
        self._refused = False
        self._transport: asyncio.Transport | None = None
        self._end: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Start the timeout, and close the oldest connection if there are too many."""
        self._transport = cast(asyncio.Transport, transport)
        self._end_after(HEAD_S)
        self._porch.callers[self] = None
        if len(self._porch.callers) > MOST_CALLERS:
            next(iter(self._porch.callers)).abort()

    def data_received(self, data: bytes) -> None:
        """Collect the head; once it is complete, hand the connection on or refuse it."""
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
        """Close the connection without an answer."""
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
        """Answer with the reason; closing at once would reset a caller that is still sending."""
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
    """Return the answer to a refused request."""
    text = why.encode()
    head = (
        "HTTP/1.1 403 Forbidden\r\nContent-Type: text/plain; charset=utf-8\r\n"
        f"Content-Length: {len(text)}\r\nConnection: close\r\n\r\n"
    )
    return head.encode() + text


def visit_of(head: bytes, door: Door) -> Visit | None:
    """Parse a head; None if it is incomplete or not a browser's."""
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
    sent = {name: value.strip() for name, (_, _, value) in zip(names, fields, strict=True)}
    try:
        target = urlsplit(words[1])
        given = parse_qs(target.query).get("key", [""])
    except ValueError:
        return None
    kept = [
        value.strip()
        for name, _, value in (each.partition("=") for each in sent.get("cookie", "").split(";"))
        if name.strip() == door.cookie
    ]
    return Visit(
        path=target.path,
        host=sent.get("host", ""),
        origin=sent.get("origin", ""),
        given=given[0],
        kept=kept[-1] if kept else "",
    )


# Serving the desk.

SHUTDOWN_S = 2.0
"""Time for an open page to learn that the server is shutting down."""

HIGHEST_PORT = 65535
"""Ports are numbers of sixteen bits."""

ENDING_S = 3.0
"""Time a page waits for the desk of a closed page to end, as when a page is reloaded."""

BUSY = "a desk is open in another tab, or is just closing: close it, then reload this page"

PASSED_ON = (
    "reconnect", "ascii", "setup", "fresh", "keys", "model", "program", "gamepad", *ARM_OPTIONS,
)  # fmt: skip
"""Options that are passed on to the desk behind a page."""


def jog_web(options: argparse.Namespace) -> int:
    """Serve the desk until Ctrl-C or a signal, and return the exit code."""
    try:
        from aiohttp import web
        from textual_serve.server import Server
    except ModuleNotFoundError:
        raise BadRequest(
            "a desk in a browser needs textual-serve: pip install 'armdrive[web]'"
        ) from None
    if options.model is None:
        chosen_target(options)  # a wrong name is refused before a page is opened
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
    say("click into the page once: until then the browser keeps the keys, even the space bar")
    say("only this computer can open it; closing the page stops the arm, Ctrl-C ends the server")
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
            f"cannot listen on port {port} ({why}): give another one with --web-port"
        ) from None


def command(options: argparse.Namespace) -> str:
    """Return the command line of the desk behind a page; `exec` lets it replace the shell."""
    desk = (sys.executable, "-m", "armdrive", "jog", "--served")
    return "exec " + shlex.join((*desk, *typed_again(options, *PASSED_ON)))


async def _serve(server: Any, web: Any, door: Door, listening: socket.socket) -> None:
    """Serve until a signal raises `GracefulExit` out of the loop."""
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
    """Return the web application with its access check."""
    app = await server._make_app()  # noqa: SLF001 - its `serve` listens and logs in its own way
    app.middlewares.append(guard(web, door))
    return app


def guard(web: Any, door: Door) -> Any:
    """Return the middleware that checks access and lets one page in at a time."""
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
            return web.Response(status=400, text="this is not a WebSocket request")
        free.clear()
        try:
            return await handler(request)
        finally:
            free.set()

    return web.middleware(let_in)


async def _soon(free: asyncio.Event) -> bool:
    """Wait a moment for the desk of a closed page to end; return whether it has."""
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
    """Print no banner: the address of the desk has been printed already."""
    del app
