"""What SDO client and server say to each other; the bytes of it are in `sdo_frames`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from firmware_protocol.canopen.sdo_codes import abort_words
from firmware_protocol.errors import BadField, whole

SEGMENT_MAX = 7
EXPEDITED_MAX = 4
"""How many bytes an initiating frame carries itself."""

_EXPEDITED, _SIZED = 0x02, 0x01


@dataclass(frozen=True, slots=True)
class Place:
    """An object of a dictionary: index and sub-index."""

    index: int
    sub: int = 0

    def __post_init__(self) -> None:
        whole("index", self.index, 0, 0xFFFF)
        whole("sub", self.sub, 0, 0xFF)

    def __str__(self) -> str:
        """Write it as manuals do: `6040:00`."""
        return f"{self.index:04X}:{self.sub:02X}"

    @property
    def packed(self) -> bytes:
        """The three bytes of it."""
        return self.index.to_bytes(2, "little") + bytes((self.sub,))


@dataclass(frozen=True, slots=True)
class Content:
    """What initiates a transfer of data: up to four bytes, or how many bytes will follow.

    `size` is None where it is not told; bytes without a size are always four.
    """

    data: bytes | None
    size: int | None

    def __post_init__(self) -> None:
        if self.size is not None:
            whole("size", self.size, 0 if self.data is None else 1, 0xFFFF_FFFF)
        expected = EXPEDITED_MAX if self.size is None else self.size
        if self.data is not None and not len(self.data) == expected <= EXPEDITED_MAX:
            raise BadField("data", self.data, "1 to 4 bytes of that size, or 4 without a size")

    @property
    def flags(self) -> int:
        """The low bits of the command."""
        spare = 0 if self.data is None else EXPEDITED_MAX - len(self.data)
        return spare << 2 | _EXPEDITED * (self.data is not None) | _SIZED * (self.size is not None)

    @property
    def packed(self) -> bytes:
        """The last four bytes."""
        if self.data is None:
            return (self.size or 0).to_bytes(4, "little")
        return self.data.ljust(EXPEDITED_MAX, b"\0")

    @classmethod
    def read(cls, command: int, packed: bytes) -> Content:
        """Read it out of a command and the last four bytes."""
        if not command & _SIZED:
            return cls(packed if command & _EXPEDITED else None, None)
        if not command & _EXPEDITED:
            return cls(None, int.from_bytes(packed, "little"))
        size = EXPEDITED_MAX - (command >> 2 & 3)
        return cls(packed[:size], size)


@dataclass(frozen=True, slots=True)
class StartUpload:
    """A client asks for an object."""

    place: Place


@dataclass(frozen=True, slots=True)
class StartDownload:
    """A client begins to write an object."""

    place: Place
    content: Content


@dataclass(frozen=True, slots=True)
class Upload:
    """A server begins to tell an object."""

    place: Place
    content: Content


@dataclass(frozen=True, slots=True)
class DownloadStarted:
    """A server has taken a `StartDownload`."""

    place: Place


@dataclass(frozen=True, slots=True)
class NextSegment:
    """A client asks for the next segment of an upload."""

    toggle: bool


@dataclass(frozen=True, slots=True)
class Segment:
    """A piece of data, of either side."""

    toggle: bool
    data: bytes
    last: bool

    def __post_init__(self) -> None:
        if not isinstance(self.data, bytes) or len(self.data) > SEGMENT_MAX:
            raise BadField("data", self.data, f"at most {SEGMENT_MAX} bytes")


@dataclass(frozen=True, slots=True)
class SegmentTaken:
    """A server has taken a segment."""

    toggle: bool


@dataclass(frozen=True, slots=True)
class Abort:
    """Either side gives a transfer up."""

    place: Place
    code: int

    def __post_init__(self) -> None:
        whole("code", self.code, 0, 0xFFFF_FFFF)

    @property
    def words(self) -> str:
        """Why."""
        return abort_words(self.code)


Request: TypeAlias = StartUpload | StartDownload | NextSegment | Segment | Abort
Response: TypeAlias = Upload | DownloadStarted | Segment | SegmentTaken | Abort
