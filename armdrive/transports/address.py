"""Addresses that may be given instead of a serial port's name.

`SCHEME://HOST:PORT` is a controller on a network. `can:INTERFACE:CHANNEL?OPTION=VALUE&...` is a CAN
adapter, with the names and defaults of python-can: `can:` alone means the adapter in python-can's
configuration file, or in the variables CAN_INTERFACE, CAN_CHANNEL and CAN_BITRATE.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from urllib.parse import parse_qsl, urlsplit

from armdrive.errors import BadRequest

TCP_SCHEMES = frozenset({"socket", "rfc2217"})
PREFIX = "can:"
# Bits a second of a CAN bus, unless its address or an arm file says otherwise.
BITRATE = 500_000


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


# The only option that is not python-can's: the ids of the frames to receive, `ids=1,2,0x10`.
IDS = "ids"
MOST_ID = 0x1FFF_FFFF  # 29 bits: the largest id of an extended frame
# The interfaces whose channel is a serial port.
ON_SERIAL = frozenset({"slcan", "serial", "robotell", "seeedstudio"})
_CAN_LISTEN_ONLY = frozenset({"slcan"})
# python-can's option for an adapter that never sends, not even an acknowledgement.
_LISTEN_ONLY = ("listen_only", "true")


@dataclass(frozen=True, slots=True)
class CanAddress:
    """A CAN adapter in python-can's terms; empty fields are left to python-can's configuration."""

    interface: str = ""
    channel: str = ""
    options: tuple[tuple[str, str], ...] = ()
    ids: frozenset[int] = frozenset()

    @classmethod
    def parse(cls, port: str) -> CanAddress:
        """Parse an address. Raises `BadRequest`."""
        if not is_can(port):
            raise BadRequest(f"{port!r} is not a CAN address: write can:INTERFACE:CHANNEL")
        where, _, query = port[len(PREFIX) :].partition("?")
        interface, _, channel = where.partition(":")
        try:
            options = dict(parse_qsl(query, keep_blank_values=True, strict_parsing=bool(query)))
        except ValueError:
            raise BadRequest(
                f"{port}: write options as ?bitrate=500000&NAME=VALUE after the channel"
            ) from None
        ids = _ids(options.pop(IDS, ""), port)
        return cls(interface.strip(), channel.strip(), tuple(options.items()), ids)

    def option(self, name: str) -> str:
        """Return the value of an option; empty if it is not given."""
        return dict(self.options).get(name, "")

    @property
    def device(self) -> str:
        """The serial port of the adapter; empty if it has none."""
        if self.interface not in ON_SERIAL:
            return ""
        return self.channel.rpartition("@")[0] or self.channel

    def listening(self) -> CanAddress:
        """Return the address with the adapter in listen-only mode, if its interface has one."""
        if self.interface not in _CAN_LISTEN_ONLY or self.option(_LISTEN_ONLY[0]):
            return self
        return replace(self, options=(*self.options, _LISTEN_ONLY))

    def at(self, device: str) -> CanAddress:
        """Return the address with the adapter at another serial port."""
        _, at, speed = self.channel.rpartition("@") if "@" in self.channel else ("", "", "")
        return replace(self, channel=f"{device}{at}{speed}")

    def __str__(self) -> str:
        """Return the address as `parse` accepts it."""
        words = [f"{name}={value}" for name, value in self.options]
        if self.ids:
            words.append(f"{IDS}={','.join(map(str, sorted(self.ids)))}")
        where = f"{self.interface}:{self.channel}" if self.channel else self.interface
        return PREFIX + where + ("?" + "&".join(words) if words else "")


def _ids(text: str, port: str) -> frozenset[int]:
    try:
        found = frozenset(int(word, 0) for word in text.split(",") if word.strip())
    except ValueError:
        found = frozenset({-1})
    if any(not 0 <= each <= MOST_ID for each in found):
        raise BadRequest(f"{port}: ids are numbers, as in ids=1,2,0x10, not {text!r}")
    return found
