"""Addresses that may be given instead of a serial port's name.

`SCHEME://HOST:PORT` is a controller on a network. `can:` begins the address of a CAN adapter, which
can_address.py parses.
"""

from __future__ import annotations

from urllib.parse import urlsplit

from armdrive.errors import BadRequest

TCP_SCHEMES = frozenset({"socket", "rfc2217"})
PREFIX = "can:"


def is_can(port: str) -> bool:
    """Return whether a port's name is the address of a CAN adapter."""
    return port[: len(PREFIX)].lower() == PREFIX


def scheme(port: str) -> str:
    """Return the part before `://`, in lower case; empty for a plain name or a CAN bus."""
    if is_can(port):
        return ""
    before, found, _ = port.partition("://")
    return before.lower() if found else ""


def host_and_port(url: str) -> tuple[str, int]:
    """Read the host and the port number of a network URL. Raises `BadRequest`."""
    parts = urlsplit(url)
    try:
        number = parts.port
    except ValueError:
        number = None
    if not parts.hostname or not number:
        raise BadRequest(
            f"{url} is not a complete address: write host and port number, for example "
            f"{parts.scheme or 'socket'}://192.168.4.1:2217"
        )
    return parts.hostname, number
