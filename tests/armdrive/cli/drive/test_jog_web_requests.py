"""The web desk's port under requests that no browser makes: none gets past the guard."""

from __future__ import annotations

import asyncio
import contextlib
from socket import create_server

import pytest
from waiting import ends

from armdrive.cli.drive.jog import HOST, Door, guard, runner_of

web = pytest.importorskip("aiohttp.web")

KEY = "the-key"
KEY_BYTES = KEY.encode()
LONG = b"a" * 100_000
INSIDE = b"behind the guard"


def head(port, *lines, first=b"GET / HTTP/1.1", host=b""):
    own = b"Host: " + (host or b"%s:%d" % (HOST.encode(), port))
    return b"\r\n".join((first, own, *lines)) + b"\r\n\r\n"


def cookie(port, value=KEY_BYTES):
    return b"Cookie: armdrive-%d=%s" % (port, value)


REFUSED = {
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


@pytest.mark.parametrize("what", REFUSED)
def test_a_request_without_the_key_reaches_nothing_and_is_not_reported(what, capfd, caplog):
    answer = answered(REFUSED[what])
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
