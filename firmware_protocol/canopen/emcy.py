"""EMCY: a device reports an error, or the end of all errors, without being asked."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntFlag

from firmware_protocol.canopen.cob import Service, checked_node, cob_id, opened, sized
from firmware_protocol.errors import BadField, whole
from firmware_protocol.frames import Frame

# The meanings of the CiA 301 and CiA 402 error codes, in EMCY frames and in object 603F.
#
# The first digits are the class of the error, the others specify it. A code without a row of its
# own is described by the row of its class.

ERROR_WORDS: dict[int, str] = {
    0x0000: "no error any more",
    0x1000: "an error of no particular kind",
    0x2000: "current",
    0x2100: "current at the input",
    0x2200: "current inside the device",
    0x2220: "continuous over-current inside the device",
    0x2300: "current at the output",
    0x2310: "continuous over-current at the output",
    0x2320: "short circuit or earth leakage at the output",
    0x2330: "earth leakage at the output",
    0x2340: "short circuit at the output",
    0x3000: "voltage",
    0x3100: "mains voltage",
    0x3110: "mains voltage too high",
    0x3120: "mains voltage too low",
    0x3130: "a phase of the mains is missing",
    0x3200: "voltage inside the device",
    0x3210: "DC link voltage too high",
    0x3220: "DC link voltage too low",
    0x3300: "output voltage",
    0x4000: "temperature",
    0x4100: "ambient temperature",
    0x4110: "ambient temperature too high",
    0x4120: "ambient temperature too low",
    0x4200: "temperature of the device",
    0x4210: "device too hot",
    0x4220: "device too cold",
    0x4300: "temperature of the drive",
    0x4310: "drive too hot",
    0x4320: "drive too cold",
    0x5000: "hardware of the device",
    0x5100: "supply of the device's electronics",
    0x5112: "24 V supply",
    0x5400: "power section",
    0x5500: "memory of the device",
    0x5510: "RAM",
    0x5520: "ROM or EPROM",
    0x5530: "EEPROM",
    0x6000: "software of the device",
    0x6010: "software reset by a watchdog",
    0x6100: "internal software",
    0x6200: "user software",
    0x6300: "data set",
    0x6310: "parameters were lost",
    0x6320: "a parameter is wrong",
    0x7000: "additional modules",
    0x7100: "power: brake chopper or motor",
    0x7110: "brake chopper",
    0x7120: "motor",
    0x7121: "motor blocked",
    0x7122: "motor or its commutation",
    0x7300: "sensor",
    0x7305: "incremental sensor 1",
    0x7306: "incremental sensor 2",
    0x7310: "speed",
    0x7320: "position",
    0x7500: "communication of a module",
    0x8000: "monitoring",
    0x8100: "communication",
    0x8110: "frames were lost: CAN overrun",
    0x8120: "CAN is error-passive",
    0x8130: "a heartbeat or life guard is missing",
    0x8140: "recovered from bus-off",
    0x8150: "another node sends with its id",
    0x8200: "protocol",
    0x8210: "a PDO was too short to be used",
    0x8220: "a PDO was too long",
    0x8240: "SYNC has another length than was set",
    0x8250: "an expected PDO did not come",
    0x8300: "torque control",
    0x8311: "excess torque",
    0x8331: "torque",
    0x8400: "speed control",
    0x8500: "position control",
    0x8600: "positioning control",
    0x8611: "following error",
    0x8612: "a reference limit was reached",
    0x8700: "synchronisation control",
    0x8800: "winding control",
    0x8900: "process data monitoring",
    0x8A00: "control",
    0x9000: "an external error",
    0xF000: "additional functions",
    0xF001: "deceleration",
    0xFF00: "particular to the device: see its manual",
}
"""Sources: CiA 301, table of emergency error codes; CiA 402-2 (IEC 61800-7-201), error codes."""

_FIRST_ERROR = 0x100  # 00xx means no error
_CLASSES = (0xFFFF, 0xFFF0, 0xFF00, 0xF000)


class ErrorRegister(IntFlag):
    """The bits of object 1001, also sent in every EMCY."""

    GENERIC = 0x01
    CURRENT = 0x02
    VOLTAGE = 0x04
    TEMPERATURE = 0x08
    COMMUNICATION = 0x10
    DEVICE_PROFILE = 0x20
    MANUFACTURER = 0x80


def error_words(code: int) -> str:
    """Return the most specific description of an error code in the table."""
    if code < _FIRST_ERROR:
        return ERROR_WORDS[0]
    known = (code & mask for mask in _CLASSES if code & mask in ERROR_WORDS and code & mask)
    key = next(known, None)
    return "an error code that CiA 301 and 402 do not have" if key is None else ERROR_WORDS[key]


MAKERS_BYTES = 5
"""Manufacturer-specific bytes in an EMCY."""


@dataclass(frozen=True, slots=True)
class Emergency:
    """A node's error report: code, error register (object 1001), manufacturer-specific bytes."""

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
        """Whether the report means that no error remains."""
        return self.code < 0x100

    @property
    def words(self) -> str:
        """The description of the code."""
        return error_words(self.code)

    @property
    def kinds(self) -> ErrorRegister:
        """The named bits of the error register."""
        named = ErrorRegister(0)
        for bit in ErrorRegister:
            named |= bit & self.register
        return named

    @property
    def frame(self) -> Frame:
        """The CAN frame."""
        data = self.code.to_bytes(2, "little") + bytes((self.register,)) + self.detail
        return Frame(cob_id(Service.EMCY, self.node), data)

    @classmethod
    def read(cls, frame: Frame) -> Emergency:
        """Decode a frame. Raises `RemoteProtocolError`."""
        _, node = opened(frame, Service.EMCY)
        data = sized(frame, 8, 8)
        return cls(node, int.from_bytes(data[:2], "little"), data[2], data[3:])
