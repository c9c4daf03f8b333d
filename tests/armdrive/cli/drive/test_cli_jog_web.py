"""The desk in a browser: who gets access, and that closing the page stops the arm."""

import asyncio
import contextlib
import json
import os
import re
import shlex
import signal
import subprocess
import sys
import threading
from argparse import Namespace
from socket import create_server
from types import SimpleNamespace

import pytest
from cli_calls import write_arm_file
from served import Served
from waiting import LONG_S, ends, tried, until, until_seen

from armdrive.cli.drive import jog
from armdrive.cli.drive.jog import HOST, Door, Visit, guard, runner_of
from armdrive.connect.target import find
from armdrive.storage import files as places
from armdrive.storage.lock_client import ask_holder

KEY = "the-key"
DOOR = Door(8765, KEY)
GOOD = {"host": "127.0.0.1:8765", "origin": "http://127.0.0.1:8765"}
REPEAT_S = 0.04

LET_IN = [
    Visit("/", GOOD["host"], given=KEY),
    Visit("/", GOOD["host"], kept=KEY),
    Visit("/ws", kept=KEY, **GOOD),
    Visit("/static/js/textual.js", GOOD["host"], kept=KEY),
]
REFUSED = {
    "another name of this computer": Visit("/", "localhost:8765", given=KEY),
    "a name that somebody has made lead here": Visit("/", "evil.example:8765", given=KEY),
    "another port": Visit("/", "127.0.0.1:8766", given=KEY),
    "another page's socket": Visit("/ws", GOOD["host"], "http://evil.example", kept=KEY),
    "a page of another port": Visit("/ws", GOOD["host"], "http://127.0.0.1:80", kept=KEY),
    "a page in a sandbox": Visit("/ws", GOOD["host"], "null", kept=KEY),
    "no browser": Visit("/ws", GOOD["host"], kept=KEY),
    "no key": Visit("/", GOOD["host"]),
    "a wrong key": Visit("/", GOOD["host"], given="the-kez"),
    "a socket without a cookie": Visit("/ws", **GOOD),
    "a socket with a wrong cookie": Visit("/ws", kept="é", **GOOD),
    "a cookie that is no UTF-8": Visit("/", GOOD["host"], kept="\udcff\udcfe"),
    "a file of the page without a key": Visit("/static/js/textual.js", GOOD["host"]),
    "the list of the files": Visit("/static/", GOOD["host"]),
}


@pytest.mark.parametrize("visit", LET_IN)
def test_the_own_page_is_let_in(visit):
    assert DOOR.refusal(visit) == ""


@pytest.mark.parametrize("who", REFUSED)
def test_anybody_else_is_not(who):
    assert DOOR.refusal(REFUSED[who])


def test_every_desk_has_its_own_unguessable_key():
    keys = {Door(1).key for _ in range(100)}
    assert len(keys) == 100
    assert min(map(len, keys)) >= 32


def options(**more):
    return Namespace(**dict.fromkeys(jog.PASSED_ON) | more)


def test_the_desk_behind_the_page_is_given_what_was_asked_for_and_no_shell_reads_it():
    line = jog.command(options(arm="a; rm x", ascii=True, reconnect=True, baud=9600))
    words = shlex.split(line)
    assert words[0] == "exec"
    assert words[2:] == [
        "-m", "armdrive", "jog", "--served", "--reconnect", "--ascii", "--arm", "a; rm x",
        "--baud", "9600",
    ]  # fmt: skip


def test_every_option_of_the_desk_is_handed_on(call):
    said = call("jog", "--help", code=0).out
    own = {"help", "web", "web-port", "show-keys", "json"}
    named = set(re.findall(r"--([a-z-]+)", said.partition("options:")[2])) - own
    assert named - {"setup", "arm", "sim"} <= {*jog.PASSED_ON}
    assert {*jog.PASSED_ON} - {"fresh", "setup", "ascii"} <= named


def test_a_missing_package_or_a_busy_port_is_reported(call, monkeypatch):
    monkeypatch.setitem(sys.modules, "textual_serve.server", None)
    assert "pip install 'armdrive[web]'" in call.refused("jog", "--web", code=2)
    with jog.socket.create_server((HOST, 0)) as taken:
        monkeypatch.setitem(sys.modules, "aiohttp", SimpleNamespace(web=None))
        monkeypatch.setitem(sys.modules, "textual_serve.server", SimpleNamespace(Server=None))
        port = taken.getsockname()[1]
        assert "--web-port" in call.refused("jog", "--web", "--web-port", str(port), code=2)
    assert "--web-port" in call.refused("jog", "--web", "--web-port", "99999", code=2)


# -- the desk behind a page -------------------------------------------------------------------


def packet(kind, data):
    return kind + len(data).to_bytes(4, "big") + data


ARMED = b"armed: let go"
"""What the desk says when the keys are armed, and no part of what it says of disarmed keys."""


class Browsed:
    """A desk behind a page, as the program that serves the page runs it, and its arm's twin."""

    def __init__(self):
        self.served = Served("teachmover", tcp=f"{HOST}:0")
        self.watch = self.served.watch
        text = f'model = "teachmover"\n[connection]\nport = "{self.served.port}"\n'
        write_arm_file("bench", text + 'dialect = "teachmover"\n')
        places.states().mkdir(parents=True, exist_ok=True)
        (places.states() / "desk.json").write_text('{"instructed": true, "screen": "jog"}')
        words = shlex.split(jog.command(options(arm="bench")))[1:]
        driver = "textual.drivers.web_driver:WebDriver"
        self.process = subprocess.Popen(
            words,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "TEXTUAL_DRIVER": driver, "COLUMNS": "100", "ROWS": "30"},
        )
        self.painted = b""
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self._lifted = threading.Event()
        self._finger = None

    def _read(self):
        while data := os.read(self.process.stdout.fileno(), 65536):
            self.painted += data

    def send(self, kind, data):
        self.process.stdin.write(packet(kind, data))
        self.process.stdin.flush()

    def press(self, keys):
        self.send(b"D", keys)

    def meta(self, what):
        self.send(b"M", json.dumps({"type": what}).encode())

    def hold(self, key):
        """Hold a key from now on, whatever happens to the desk."""
        self._lifted.clear()

        def repeat():
            while not self._lifted.wait(REPEAT_S):
                try:
                    self.press(key)
                except (OSError, ValueError):
                    return

        self._finger = threading.Thread(target=repeat, daemon=True)
        self._finger.start()

    def lift(self):
        self._lifted.set()
        if self._finger is not None:
            self._finger.join()

    def _hold_on(self):
        """Hold the key anew; arm again first where the desk was too busy for a held key."""
        self.lift()
        if self._armed:
            self.hold(b"q")
        else:
            self.press(b"\r")

    @property
    def _armed(self):
        """Whether the keys were armed when the screen was painted last."""
        return self.painted.rfind(ARMED) > self.painted.rfind(b"DISARMED")

    def jog(self):
        """Have the arm move by a held key; return what its status announces then."""
        until(lambda: b"DISARMED" in self.painted and not self._armed)
        tried(lambda: self.press(b"\r"), lambda: self._armed, "the keys were not armed")
        start = self.watch.motors
        tried(self._hold_on, lambda: self.watch.motors != start, "the key jogged nothing")
        said = ask_holder("bench", "status")
        return max(said["stop_time_s"], said["silent_time_s"])

    def __enter__(self):
        return self

    def __exit__(self, *error):
        self._lifted.set()
        self.process.kill()
        self.process.wait()
        with contextlib.suppress(BrokenPipeError):  # what was typed last reached nobody
            self.process.stdin.close()
        self._reader.join()
        self.process.stdout.close()
        self.served.end()


ENDS = {
    "the server has died": (lambda desk: (desk.lift(), desk.process.stdin.close()), 0),
    "the server is told to end": (lambda desk: desk.process.send_signal(signal.SIGTERM), 143),
}


@pytest.mark.skipif(sys.platform == "win32", reason="its pipes cannot be waited for there")
@pytest.mark.parametrize("end", ENDS)
def test_a_desk_that_is_ended_leaves_an_arm_that_stands_within_the_announced_time(end):
    do, code = ENDS[end]
    with Browsed() as desk:
        bound_s = desk.jog()
        do(desk)
        assert desk.process.wait(LONG_S) == code
        desk.watch.stands_within(bound_s)


@pytest.mark.skipif(sys.platform == "win32", reason="its pipes cannot be waited for there")
def test_losing_the_keyboard_focus_disarms_the_keys_and_closing_the_page_ends_the_desk():
    with Browsed() as desk:
        desk.jog()
        desk.meta("blur")
        until(lambda: b"lost the keyboard focus" in desk.painted)
        desk.lift()
        bound_s = desk.jog()
        desk.meta("quit")
        assert desk.process.wait(LONG_S) == 0
        desk.watch.stands_within(bound_s)


# -- the page ---------------------------------------------------------------------------------


@pytest.mark.skipif(sys.platform == "win32", reason="its pipes cannot be waited for there")
def test_a_browser_opens_jogs_and_closes_a_desk(tmp_path):
    aiohttp = pytest.importorskip("aiohttp")
    pytest.importorskip("textual_serve")
    places.states().mkdir(parents=True, exist_ok=True)
    (places.states() / "desk.json").write_text('{"instructed": true}')
    with jog.socket.create_server((HOST, 0)) as free:
        port = free.getsockname()[1]
    words = [sys.executable, "-m", "armdrive", "jog", "--sim", "teachmover", "--web"]
    server = subprocess.Popen(
        [*words, "--web-port", str(port)], stdout=subprocess.PIPE, text=True, bufsize=1
    )
    try:
        said = server.stdout.readline()
        address = said.partition(" at ")[2].strip()
        assert address.startswith(f"http://{HOST}:{port}/?key=")
        until(lambda: _answers(port))
        asyncio.run(_browse(aiohttp, address, port))
    finally:
        server.send_signal(signal.SIGINT)
        server.stdout.read()
        assert server.wait(LONG_S) == 0
        server.stdout.close()


async def _browse(aiohttp, address, port):
    own = {"Origin": f"http://{HOST}:{port}"}
    socket = f"http://{HOST}:{port}/ws?width=100&height=30"
    jar = aiohttp.CookieJar(unsafe=True)
    async with aiohttp.ClientSession(cookie_jar=jar) as browser:
        async with browser.get(address.partition("?")[0]) as answer:
            assert answer.status == 403
        async with browser.get(address, headers={"Host": f"localhost:{port}"}) as answer:
            assert answer.status == 403
        async with browser.get(address) as answer:
            assert answer.status == 200
            assert "default-src 'self'" in answer.headers["Content-Security-Policy"]
            assert f"ws://{HOST}:{port}/ws" in await answer.text()
        with pytest.raises(aiohttp.WSServerHandshakeError):
            await browser.ws_connect(socket, headers={"Origin": "http://evil.example"})
        async with browser.ws_connect(socket, headers=own) as page:
            await _painted(page, b"DISARMED")
            with pytest.raises(aiohttp.WSServerHandshakeError, match="409"):
                await browser.ws_connect(socket, headers=own)
            await page.send_json(["stdin", "\r"])
            await _painted(page, ARMED)
            held = find("sim:teachmover").config.name
            assert ask_holder(held, "status")["state"] == "standby"
        async with await _let_in(aiohttp, browser, socket, own) as page:
            await _painted(page, b"DISARMED")


async def _let_in(aiohttp, browser, socket, own):
    """Open the page again once the desk of the previous page has ended."""
    pages = []

    async def knock():
        try:
            pages.append(await browser.ws_connect(socket, headers=own))
        except aiohttp.WSServerHandshakeError as error:
            if error.status != 409:
                raise

    await until_seen(lambda: pages, knock)
    return pages[0]


def _answers(port):
    try:
        jog.socket.create_connection((HOST, port)).close()
    except ConnectionRefusedError:
        return False
    return True


async def _painted(page, words):
    seen = b""
    while words not in seen:
        message = await page.receive()
        assert isinstance(message.data, bytes), message
        seen += message.data


# The web desk's port under requests that no browser makes: none gets past the guard.


web = pytest.importorskip("aiohttp.web")

KEY_BYTES = KEY.encode()
LONG = b"a" * 100_000
INSIDE = b"behind the guard"


def head(port, *lines, first=b"GET / HTTP/1.1", host=b""):
    own = b"Host: " + (host or b"%s:%d" % (HOST.encode(), port))
    return b"\r\n".join((first, own, *lines)) + b"\r\n\r\n"


def cookie(port, value=KEY_BYTES):
    return b"Cookie: armdrive-%d=%s" % (port, value)


HOSTILE_REQUESTS = {
    "no key": head,
    "a wrong key": lambda port: head(port, first=b"GET /?key=other HTTP/1.1"),
    "a cookie that is no UTF-8": lambda port: head(port, cookie(port, b"\xff\xfe")),
    "a cookie of half a character": lambda port: head(port, cookie(port, b"\xed\xa0\x80")),
    "a key of escapes": lambda port: head(port, first=b"GET /?key=%ff%00%ed%a0%80 HTTP/1.1"),
    "a null": lambda port: head(port, cookie(port), b"X: \x00"),
    "a file": lambda port: head(port, first=b"GET /static/js/textual.js HTTP/1.1"),
    "another path": lambda port: head(port, first=b"GET /other HTTP/1.1"),
    "another method": lambda port: head(port, first=b"POST / HTTP/1.1"),
    "OPTIONS": lambda port: head(port, first=b"OPTIONS * HTTP/1.1"),
    "HTTP/2": lambda port: b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    "TLS": lambda port: b"\x16\x03\x01\x00\xa5\x01\x00\x00\xa1\x03\x03\r\n\r\n",
    "two hosts": lambda port: head(port, cookie(port), b"Host: evil"),
    "another host": lambda port: head(port, cookie(port), host=b"evil.example"),
    "another origin": lambda port: head(port, cookie(port), b"Origin: http://evil.example"),
    "two origins": lambda port: head(
        port, cookie(port), b"Origin: http://evil", b"Origin: http://127.0.0.1:%d" % port
    ),
    "a socket": lambda port: head(port, b"Upgrade: websocket", first=b"GET /ws HTTP/1.1"),
    "a bad length": lambda port: head(port, b"Content-Length: -5"),
    "a long header": lambda port: head(port, cookie(port), b"X: " + LONG),
    "a long path": lambda port: head(port, cookie(port), first=b"GET /" + LONG + b" HTTP/1.1"),
    "no end": lambda port: LONG,
}


async def answer_to(port, data):
    """Return all that comes back."""
    reader, writer = await asyncio.open_connection(HOST, port)
    try:
        with contextlib.suppress(ConnectionError):
            writer.write(data)
            await writer.drain()
            first = await reader.read(1)  # an end before the answer would be a browser that left
            writer.write_eof()
            return first + await reader.read()
        return b""
    finally:
        writer.close()
        with contextlib.suppress(ConnectionError):
            await writer.wait_closed()


def answered(ask):
    """Return the answer to `ask(port)` of a guarded server that lets see whether it was reached."""

    async def inside(_):
        return web.Response(body=INSIDE)

    async def main():
        with create_server((HOST, 0)) as listening:
            door = Door(listening.getsockname()[1], KEY)
            app = web.Application(middlewares=[guard(web, door)])
            app.router.add_route("*", "/{path:.*}", inside)
            runner = runner_of(web, app)
            await runner.setup()
            await web.SockSite(runner, listening).start()
            try:
                return await ends(answer_to(door.port, ask(door.port)))
            finally:
                await runner.cleanup()

    return asyncio.run(main())


@pytest.mark.parametrize("what", HOSTILE_REQUESTS)
def test_a_request_without_the_key_reaches_nothing_and_is_not_reported(what, capfd, caplog):
    answer = answered(HOSTILE_REQUESTS[what])
    assert INSIDE not in answer
    assert KEY_BYTES not in answer.partition(b"\r\n\r\n")[0]
    assert answer[9:10] in (b"4", b"")
    assert capfd.readouterr() == ("", "")
    assert not caplog.records


@pytest.mark.parametrize(
    "ask",
    [
        lambda port: head(port, cookie(port)),
        lambda port: head(port, first=b"GET /?key=the-key HTTP/1.1"),
    ],
)
def test_the_key_is_let_in_by_cookie_and_by_address(ask):
    assert INSIDE in answered(ask)
