"""The device's end of a network wire for other programs: a TCP port."""

from __future__ import annotations

import socket

from armdrive.transports.serve import CHUNK
from armdrive.transports.serve_network import NetworkServer


class TcpServer(NetworkServer):
    """A TCP port for one client at a time; a second one is turned away."""

    paced = True
    _client: socket.socket | None = None

    def filenos(self) -> tuple[int, ...]:
        """What to select on for reading."""
        return tuple(end.fileno() for end in (self._ear, self._client) if end is not None)

    def read(self) -> bytes:
        """Return all that the client has sent, and let the next one in when it has left."""
        heard = self._hear()
        self._admit()
        return heard + self._hear()

    def write(self, data: bytes) -> None:
        """Send to the client, if there is one."""
        if self._client is not None:
            try:
                self._client.send(data)
            except BlockingIOError:
                pass
            except OSError:
                self._hang_up()

    def close(self) -> None:
        """Hang up and listen no more."""
        self._hang_up()
        super().close()

    def _bound(self, host: str, port: int) -> socket.socket:
        return socket.create_server((host, port), backlog=1)

    def _hear(self) -> bytes:
        heard = b""
        while self._client is not None and len(heard) < CHUNK:
            try:
                data = self._client.recv(CHUNK)
            except BlockingIOError:
                break
            except OSError:
                data = b""
            heard += data
            if not data:
                self._hang_up()
        return heard

    def _admit(self) -> None:
        if self._ear is None:
            return
        try:
            client, _ = self._ear.accept()
        except OSError:
            return
        if self._client is not None:
            client.close()
            return
        client.setblocking(False)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._client = client

    def _hang_up(self) -> None:
        if self._client is not None:
            self._client.close()
            self._client = None
