"""EMCY: a device says by itself that something is wrong, or is right again."""

from __future__ import annotations

from dataclasses import dataclass

from firmware_protocol.canopen.cob import Service, checked_node, cob_id, opened, sized
from firmware_protocol.canopen.emcy_codes import ErrorRegister, error_words
from firmware_protocol.errors import BadField, whole
from firmware_protocol.frames import Frame

MAKERS_BYTES = 5
"""How many bytes of an EMCY the maker of the device has for itself."""


@dataclass(frozen=True, slots=True)
class Emergency:
    """What a node reports: error code, the error register (object 1001), the maker's bytes."""

    node: int
    code: int
    register: int = 0
    detail: bytes = bytes(MAKERS_BYTES)

    def __post_init__(self) -> None:
        checked_node(self.node)
        whole("code", self.code, 0, 0xFFFF)
        whole("register", self.register, 0, 0xFF)
        if not isinstance(self.detail, bytes) or len(self.detail) != MAKERS_BYTES:
            raise BadField("detail", self.detail, f"{MAKERS_BYTES} bytes")

    @property
    def over(self) -> bool:
        """Whether it says that no error is left."""
        return self.code < 0x100

    @property
    def words(self) -> str:
        """What the code means."""
        return error_words(self.code)

    @property
    def kinds(self) -> ErrorRegister:
        """The named bits of the register."""
        named = ErrorRegister(0)
        for bit in ErrorRegister:
            named |= bit & self.register
        return named

    @property
    def frame(self) -> Frame:
        """The frame that says so."""
        data = self.code.to_bytes(2, "little") + bytes((self.register,)) + self.detail
        return Frame(cob_id(Service.EMCY, self.node), data)

    @classmethod
    def read(cls, frame: Frame) -> Emergency:
        """Read a frame; raises `RemoteProtocolError`."""
        _, node = opened(frame, Service.EMCY)
        data = sized(frame, 8, 8)
        return cls(node, int.from_bytes(data[:2], "little"), data[2], data[3:])
