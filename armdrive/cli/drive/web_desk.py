"""Show the desk in a browser on this computer: `armdrive jog --web`.

The browser's page is textual-serve's. Each page that is opened has a desk in a process of its own,
with its arm; there is one at a time. When the page is closed that process is told to end, and when
this one dies it notices by itself.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import shlex
import socket
import sys
from collections.abc import Iterator
from typing import Any

from armdrive.cli.arm_files import chosen_target
from armdrive.cli.drive.web_access import HOST, PAGE, SOCKET, Door, Porch, Visit
from armdrive.cli.presenter import say
from armdrive.errors import BadRequest

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
