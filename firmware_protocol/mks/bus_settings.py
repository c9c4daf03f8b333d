"""How an MKS drive is on its bus: speed, ids, replies; checked when built."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

from firmware_protocol.errors import RemoteProtocolError, whole
from firmware_protocol.mks.forms import one_of, sized
from firmware_protocol.mks.values import NODE_MAX, Bitrate, Code, ReplyMode


@dataclass(frozen=True, slots=True)
class SetBitrate:
    """Choose the bus's speed, for all drives or none. At which speed it answers is unknown."""

    code: ClassVar[Code] = Code.BITRATE
    bitrate: Bitrate

    def __post_init__(self) -> None:
        one_of("bitrate", self.bitrate, Bitrate)

    @property
    def payload(self) -> bytes:
        """One byte."""
        return bytes((self.bitrate,))

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload; ValueError where there is no such speed."""
        return cls(Bitrate(sized(payload, 1)[0]))


@dataclass(frozen=True, slots=True)
class _OfId:
    node: int

    def __post_init__(self) -> None:
        whole("node", self.node, 1, NODE_MAX)

    @property
    def payload(self) -> bytes:
        """Two bytes."""
        return self.node.to_bytes(2, "big")

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload."""
        return cls(int.from_bytes(sized(payload, 2), "big"))


@dataclass(frozen=True, slots=True)
class SetId(_OfId):
    """Give the drive another id. Whether it answers by the old or the new one is not documented."""

    code: ClassVar[Code] = Code.NODE


@dataclass(frozen=True, slots=True)
class SetGroup(_OfId):
    """Have the drive listen to a group's id too; nothing sent to it is answered. From 1.0.1 on.

    Never the id of a drive: its answers would be taken for commands.
    """

    code: ClassVar[Code] = Code.GROUP


@dataclass(frozen=True, slots=True)
class SetReplies:
    """Choose what the drive says of what it is told to do. In this form from 1.0.4 on."""

    code: ClassVar[Code] = Code.REPLIES
    mode: ReplyMode

    def __post_init__(self) -> None:
        one_of("mode", self.mode, ReplyMode)

    @property
    def payload(self) -> bytes:
        """Two bytes."""
        return self.mode.value

    @classmethod
    def read(cls, payload: bytes) -> Self:
        """Read a payload: where it replies nothing, the second byte means nothing."""
        sized(payload, 2)
        if max(payload) > 1:
            raise RemoteProtocolError(f"{payload.hex(' ')} where zeros and ones belong")
        return cls(ReplyMode(payload) if payload[0] else ReplyMode.NONE)
