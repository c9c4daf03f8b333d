"""Drive an arm from the keyboard, or jog a model with no arm: `armdrive jog --model NAME`."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import logging
import secrets
import shlex
import socket
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import tui
from armdrive.cli.arm_files import chosen_target, default_arm
from armdrive.cli.chosen_arm import connect_chosen, switch_on_settled
from armdrive.cli.learn.models import find_subject
from armdrive.cli.look.status import watch_on_screen
from armdrive.cli.options import ARM_OPTIONS, names_arm, typed_again
from armdrive.cli.presenter import Outcome, Result, require_screen, say
from armdrive.cli.program.arguments import PROGRAM
from armdrive.cli.terminal_operator import confirm_simulated
from armdrive.connect.target import DEFAULT_TARGET
from armdrive.errors import ArmInUse, BadRequest
from armdrive.errors.printable import reason_of
from armdrive.registry.arm_files import arm_paths
from armdrive.status import State, coded
from armdrive.storage import files as places
from armdrive.text.reading import read_text
from kinematics.textbook.systems import MODEL_NAMES, system
from tui.gamepad import check_gamepads
from tui.keys.keyboard import Keyboard, as_rows, as_text
from tui.keys.remap import load_keys
from tui.model_desk import run_model


def jog(options: argparse.Namespace) -> Outcome:
    """Open the desk."""
    keys = load_keys(options.keys)  # a wrong file is refused before anything is opened
    if options.program is not None:
        _check_program(options.program)
    if options.show_keys:
        return Result({"keys": as_rows(keys)}, as_text(keys))
    if options.web:
        return jog_web(options)
    if options.model is not None:
        return jog_model(options, keys)
    if not options.served:
        require_screen("jogging", "`armdrive shell` and `armdrive move` need none")
    if options.gamepad is not None:
        check_gamepads()
    first = "setup" if options.setup else "program" if options.program is not None else ""
    end = _desk(options, keys, first, _hint(options, keys))
    while end.opens is not None:  # the set-up screen wrote an arm file
        options = _on_file(options, end.opens)
        hint = f"this is {options.arm}: nothing moved; reference it, then check its motors"
        end = _desk(options, keys, "setup", hint)
    return end.code


def _check_program(path: Path) -> None:
    """Refuse what is no program file, or cannot be read. Its mistakes are shown on the screen."""
    if path.suffix.lower() != PROGRAM:
        raise BadRequest(f"{path} is no program file ({PROGRAM}); `armdrive run` runs scripts")
    read_text(path, "the program", BadRequest)


def _desk(options: argparse.Namespace, keys: Keyboard, first: str, hint: str) -> tui.DeskEnd:
    """Connect the arm, and show its desk until the user leaves it."""
    # in real time, also for the simulated twin of an arm on a port
    try:
        arm = connect_chosen(options, pace="real", reconnect=options.reconnect)
    except ArmInUse as error:
        return tui.DeskEnd(_watch_instead(error, options))
    with contextlib.closing(arm):
        confirm_simulated(arm)
        switch_on_settled(arm)
        end = tui.run_desk(
            arm,
            ascii_only=options.ascii,
            keys=keys,
            first=first,
            hint=hint,
            reopens=not options.served,
            gamepad=options.gamepad,
            program=None if options.program is None else options.program.absolute(),
        )
        last = arm.status
    if last.error and last.state is State.DISCONNECTED and not end.code:
        say(f"the connection was lost when you left: {coded(last.error, last.error_code)}")
    return end


def _on_file(options: argparse.Namespace, path: Path) -> argparse.Namespace:
    """Return the same options with the arm of a file."""
    named = path.stem if path.parent == places.arm_files() else str(path)
    return argparse.Namespace(
        **vars(options)
        | {"arm": named, "sim": None, "port": None, "dialect": None, "baud": None, "fresh": False}
    )


def _hint(options: argparse.Namespace, keys: Keyboard) -> str:
    """Return a hint to set an arm up, if none was named and there is no arm file."""
    if names_arm(options) or default_arm() != DEFAULT_TARGET or arm_paths():
        return ""
    key = keys.label("screen-setup")
    return f"you have no arm file yet, so this arm is simulated: {key} sets up a real one"


def _watch_instead(error: ArmInUse, options: argparse.Namespace) -> int:
    """Watch an arm that another program drives: that moves nothing, and needs no question."""
    if options.served:
        raise error
    end = watch_on_screen(chosen_target(options).config, ascii_only=options.ascii)
    say(f"the arm was watched, not driven: {error}")
    return end


# A model with no arm.


def jog_model(options: argparse.Namespace, keys: Keyboard) -> Outcome:
    """Open the desk of a model, or list the models if none is named."""
    if names_arm(options):
        raise BadRequest("--model has no arm: leave out --arm, --sim and --port, or --model")
    if options.gamepad is not None:
        raise BadRequest("a model is jogged in steps, with keys: leave out --gamepad, or --model")
    if options.setup or options.program is not None:
        raise BadRequest("a model has no set-up and runs no programs: leave them out, or --model")
    if not options.model:
        return _models()
    subject = find_subject(options.model)
    if not options.served:
        require_screen("jogging", "`armdrive explain` prints the same for one posture")
    return run_model(subject, ascii_only=options.ascii, keys=keys)


def _models() -> Result:
    titles = {name: system(name).title for name in MODEL_NAMES}
    width = max(map(len, titles)) + 2
    return Result(
        {"models": [{"name": name, "title": title} for name, title in titles.items()]},
        [
            *(f"{name:<{width}}{title}" for name, title in titles.items()),
            "or an arm of your own, by its link table, arm file or URDF: armdrive jog --model FILE",
        ],
    )


# The desk in a browser on this computer: `armdrive jog --web`.
#
# textual-serve makes the browser's page. Each open page has a desk in a process of its own, with
# its arm; there is one at a time. That process ends when its page is closed or this process dies.
#
# Only this user on this computer gets in. Any other page in the same browser can reach the ports of
# this computer too, and browsers let any page open a WebSocket. So every request needs the right
# origin and a key that only the terminal has shown. Both also keep other users of the computer out.

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
        # at the page, the address of this desk counts more than a cookie from an earlier one
        shown = visit.kept or visit.given if visit.path != PAGE else visit.given or visit.kept
        # a cookie may have bytes that decode to characters which cannot be encoded again
        if not secrets.compare_digest(shown.encode(errors="replace"), self.key.encode()):
            return "open the whole address that `armdrive jog --web` has printed, with its key"
        return ""


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
        why = reason_of(error)
        raise BadRequest(
            f"cannot listen on port {port} ({why}): give another one with --web-port"
        ) from None


def command(options: argparse.Namespace) -> str:
    """Return the command line of the desk behind a page; `exec` lets it replace the shell."""
    desk = (sys.executable, "-m", "armdrive", "jog", "--served")
    return "exec " + shlex.join((*desk, *typed_again(options, *PASSED_ON)))


async def _serve(server: Any, web: Any, door: Door, listening: socket.socket) -> None:
    """Serve until a signal raises `GracefulExit` out of the loop."""
    app = await server._make_app()  # noqa: SLF001 - its `serve` listens and logs in its own way
    app.middlewares.append(guard(web, door))
    runner = runner_of(web, app)
    await runner.setup()
    try:
        await web.SockSite(runner, listening).start()
        await asyncio.Event().wait()
    finally:
        await runner.cleanup()


def runner_of(web: Any, app: Any) -> Any:
    """Return what runs an application; it reports no request, as anybody may send broken ones."""
    silent = logging.Logger("armdrive.web", logging.CRITICAL + 1)
    return web.AppRunner(
        app, handle_signals=True, access_log=None, logger=silent, shutdown_timeout=SHUTDOWN_S
    )


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
