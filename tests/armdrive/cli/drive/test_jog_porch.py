"""The desk's port under requests that no browser makes: a plain 403, and nothing of the server."""

from __future__ import annotations

import asyncio
import contextlib
import re

import pytest
from waiting import ends

from armdrive.cli.drive import web_desk
from armdrive.cli.drive.web_desk import (
    HOST,
    MOST_CALLERS,
    MOST_HEAD_BYTES,
    UNREADABLE,
    Door,
    Porch,
    visit_of,
)

KEY = "the-key"
KEY_BYTES = KEY.encode()
LONG_S = 3600.0
LONG = b"a" * 100_000


class Inside(asyncio.Protocol):
    """In the place of the web server: says what it was handed."""

    def connection_made(self, transport):
        self.transport = transport

    def data_received(self, data):
        self.transport.write(b"INSIDE " + data)
        self.transport.close()


def talked(talk):
    """Have a porch, and `talk` with it; `talk(port)` is a coroutine."""

    async def main():
        loop = asyncio.get_running_loop()
        porch = Porch(Door(0, KEY), Inside)
        async with await loop.create_server(porch, HOST, 0) as server:
            port = server.sockets[0].getsockname()[1]
            porch.door = Door(port, KEY)
            return await ends(talk(port))

    return asyncio.run(main())


async def answer_to(port, data, *, half=True):
    """Return all that comes back, also where the other end would hear no more of it."""
    reader, writer = await asyncio.open_connection(HOST, port)
    try:
        with contextlib.suppress(ConnectionError):
            writer.write(data)
            await writer.drain()
            if half:
                writer.write_eof()
        return await reader.read()
    finally:
        writer.close()
        with contextlib.suppress(ConnectionError):
            await writer.wait_closed()


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
    "a cookie whose name is no UTF-8": lambda port: head(port, b"Cookie: \xff=1; a=b"),
    "a cookie in quotes": lambda port: head(port, cookie(port, b'"\\377\\376"')),
    "two cookies": lambda port: head(port, cookie(port, b"other"), cookie(port)),
    "a key that is no UTF-8": lambda port: head(port, first=b"GET /?key=\xff HTTP/1.1"),
    "a key of escapes": lambda port: head(port, first=b"GET /?key=%ff%00%ed%a0%80 HTTP/1.1"),
    "a path that is no UTF-8": lambda port: head(port, cookie(port), first=b"GET /\xff HTTP/1.1"),
    "a host that is no UTF-8": lambda port: head(port, cookie(port), host=b"\xff"),
    "an origin that is no UTF-8": lambda port: head(port, cookie(port), b"Origin: \xff"),
    "a header that is no UTF-8": lambda port: head(port, cookie(port), b"\xff\xfe: x"),
    "a method that is no UTF-8": lambda port: head(port, cookie(port), first=b"\xff / HTTP/1.1"),
    "a null": lambda port: head(port, cookie(port), b"X: \x00"),
    "an escape sequence": lambda port: head(port, cookie(port), b"X: \x1b[2J"),
    "the list of files": lambda port: head(port, first=b"GET /static/ HTTP/1.1"),
    "a file": lambda port: head(port, first=b"GET /static/js/textual.js HTTP/1.1"),
    "a download": lambda port: head(port, first=b"GET /download/1 HTTP/1.1"),
    "another path": lambda port: head(port, first=b"GET /other HTTP/1.1"),
    "a way up": lambda port: head(port, first=b"GET /static/../../etc/passwd HTTP/1.1"),
    "another method": lambda port: head(port, first=b"POST / HTTP/1.1"),
    "a method of nobody": lambda port: head(port, first=b"FOO / HTTP/1.1"),
    "OPTIONS": lambda port: head(port, first=b"OPTIONS * HTTP/1.1"),
    "CONNECT": lambda port: head(port, cookie(port), first=b"CONNECT a:1 HTTP/1.1"),
    "HTTP/0.9": lambda port: b"GET /\r\n\r\n",
    "HTTP/2": lambda port: b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
    "TLS": lambda port: b"\x16\x03\x01\x00\xa5\x01\x00\x00\xa1\x03\x03\r\n\r\n",
    "a whole address": lambda port: head(port, cookie(port), first=b"GET http://evil/ HTTP/1.1"),
    "a broken address": lambda port: head(port, cookie(port), first=b"GET //[ HTTP/1.1"),
    "no host": lambda port: b"GET / HTTP/1.1\r\n" + cookie(port) + b"\r\n\r\n",
    "two hosts": lambda port: head(port, cookie(port), b"Host: evil"),
    "another host": lambda port: head(port, cookie(port), host=b"evil.example"),
    "another origin": lambda port: head(port, cookie(port), b"Origin: http://evil.example"),
    "two origins": lambda port: head(
        port, cookie(port), b"Origin: http://evil", b"Origin: http://127.0.0.1:%d" % port
    ),
    "a folded host": lambda port: head(port, b" evil", cookie(port), b"Host : evil", b"hOST:x"),
    "a socket": lambda port: head(port, b"Upgrade: websocket", first=b"GET /ws HTTP/1.1"),
    "an expectation": lambda port: head(port, b"Expect: 100-continue"),
    "a bad length": lambda port: head(port, b"Content-Length: -5"),
    "bad chunks": lambda port: head(port, b"Transfer-Encoding: chunked") + b"zz\r\n",
    "a long header": lambda port: head(port, cookie(port), b"X: " + LONG),
    "many headers": lambda port: head(port, cookie(port), *[b"X: a"] * 20_000),
    "a long path": lambda port: head(port, cookie(port), first=b"GET /" + LONG + b" HTTP/1.1"),
    "no end": lambda port: LONG,
    "only ends": lambda port: b"\r\n" * 50,
}


@pytest.mark.parametrize("what", REFUSED)
def test_a_request_without_the_key_is_refused_without_details(what):
    answer = talked(lambda port: answer_to(port, REFUSED[what](port), half=False))
    first, *lines = answer.partition(b"\r\n\r\n")[0].split(b"\r\n")
    assert first == b"HTTP/1.1 403 Forbidden"
    said = {line.partition(b":")[0] for line in lines}
    assert said == {b"Content-Type", b"Content-Length", b"Connection"}
    words = answer.partition(b"\r\n\r\n")[2].decode()
    assert words == UNREADABLE or re.search("desk is|open (the|a) desk|whole address", words)
    assert KEY not in answer.decode()


@pytest.mark.parametrize(
    "lines", [(), (b"Origin: http://127.0.0.1:%d",), (b"Accept: */*", b"Cookie2: x")]
)
def test_the_key_is_let_in_by_cookie_and_by_address(lines):
    async def talk(port):
        own = [line % port if b"%" in line else line for line in lines]
        by_cookie = head(port, b"Cookie: a=b; " + cookie(port)[8:] + b"; c=d", *own)
        by_address = head(port, *own, first=b"GET /?key=the-key HTTP/1.1")
        for each in (by_cookie, by_address):
            assert await answer_to(port, each) == b"INSIDE " + each

    talked(talk)


def test_a_head_may_come_in_pieces_and_its_rest_is_handed_on():
    async def talk(port):
        reader, writer = await asyncio.open_connection(HOST, port)
        data = head(port, cookie(port)) + b"and more"
        for at in range(len(data) - 20):
            writer.write(data[at : at + 1])
            await writer.drain()
        writer.write(data[-20:])
        found = await reader.read()
        writer.close()
        return found, data

    found, data = talked(talk)
    assert found == b"INSIDE " + data


@pytest.mark.parametrize("data", [b"", b"GET / HT", b"GET / HTTP/1.1\r\n"])
def test_a_client_without_a_whole_request_head_is_disconnected(monkeypatch, data):
    monkeypatch.setattr(web_desk, "HEAD_S", 0.05)

    async def talk(port):
        with contextlib.suppress(ConnectionError):
            assert await answer_to(port, data, half=False) == b""

    talked(talk)


def test_a_client_that_keeps_sending_after_a_refusal_is_disconnected(monkeypatch):
    monkeypatch.setattr(web_desk, "LINGER_S", 0.05)
    monkeypatch.setattr(web_desk, "HEAD_S", LONG_S)

    async def talk(port):
        _, writer = await asyncio.open_connection(HOST, port)
        with contextlib.suppress(ConnectionError):
            while True:
                writer.write(LONG)
                await writer.drain()
        writer.close()

    talked(talk)


def test_silent_callers_make_room_for_new_ones(monkeypatch):
    monkeypatch.setattr(web_desk, "HEAD_S", LONG_S)

    async def talk(port):
        silent = [await asyncio.open_connection(HOST, port) for _ in range(3 * MOST_CALLERS)]
        each = head(port, cookie(port))
        assert await answer_to(port, each) == b"INSIDE " + each
        with contextlib.suppress(ConnectionError):
            assert await silent[0][0].read() == b""
        for _, writer in silent:
            writer.close()

    talked(talk)


def test_a_head_is_read_up_to_its_bound():
    door = Door(1, KEY)
    fits = b"GET / HTTP/1.1\r\nX: "
    assert visit_of(fits + b"a" * (MOST_HEAD_BYTES - len(fits)) + b"\r\n\r\n", door) is not None
    assert visit_of(fits + b"a" * (MOST_HEAD_BYTES - len(fits) + 1) + b"\r\n\r\n", door) is None
