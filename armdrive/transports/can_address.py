"""The address of a CAN adapter, `can:INTERFACE:CHANNEL?OPTION=VALUE&...`, read into its parts.

Its names are python-can's own, and so are its defaults: `can:` alone means whatever python-can's
configuration file or the variables CAN_INTERFACE, CAN_CHANNEL and CAN_BITRATE say.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from urllib.parse import parse_qsl

from armdrive.errors import BadRequest
from armdrive.transports.address import PREFIX, is_can

IDS = "ids"
"""The one option that is not python-can's: the ids that are listened to, `ids=1,2,0x10`."""
MOST_ID = 0x1FFF_FFFF
_ON_SERIAL = frozenset({"slcan", "serial", "robotell", "seeedstudio"})
"""The interfaces whose channel is a serial port."""
_KEEP_QUIET = frozenset({"slcan"})
_LISTEN_ONLY = ("listen_only", "true")
"""python-can's own option for an adapter that does not even acknowledge."""


@dataclass(frozen=True, slots=True)
class CanAddress:
    """A CAN adapter as python-can knows it; what is empty is left to its configuration."""

    interface: str = ""
    channel: str = ""
    options: tuple[tuple[str, str], ...] = ()
    ids: frozenset[int] = frozenset()

    @classmethod
    def parse(cls, port: str) -> CanAddress:
        """Read a port's name. Raises `BadRequest`."""
        if not is_can(port):
            raise BadRequest(f"{port!r} is no CAN address: write can:INTERFACE:CHANNEL")
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
        """Return an option's text; empty where it is not given."""
        return dict(self.options).get(name, "")

    @property
    def device(self) -> str:
        """The serial port of the adapter; empty where it has none."""
        if self.interface not in _ON_SERIAL:
            return ""
        return self.channel.rpartition("@")[0] or self.channel

    @property
    def on_serial(self) -> bool:
        """Whether the adapter is a serial port."""
        return self.interface in _ON_SERIAL

    def listening(self) -> CanAddress:
        """Return the same with an adapter that only listens, where it can be kept from speaking."""
        if self.interface not in _KEEP_QUIET or self.option(_LISTEN_ONLY[0]):
            return self
        return replace(self, options=(*self.options, _LISTEN_ONLY))

    def at(self, device: str) -> CanAddress:
        """Return the same with its adapter at another serial port."""
        _, at, speed = self.channel.rpartition("@") if "@" in self.channel else ("", "", "")
        return replace(self, channel=f"{device}{at}{speed}")

    def __str__(self) -> str:
        """Write it as it is read."""
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
