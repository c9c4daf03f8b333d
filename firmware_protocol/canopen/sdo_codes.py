"""Why an SDO transfer was given up: the abort codes of CiA 301, in words."""

from __future__ import annotations

from enum import IntEnum


class AbortCode(IntEnum):
    """The codes that CiA 301 has; a device may send others."""

    TOGGLE = 0x0503_0000
    TIMED_OUT = 0x0504_0000
    COMMAND = 0x0504_0001
    BLOCK_SIZE = 0x0504_0002
    SEQUENCE_NUMBER = 0x0504_0003
    CRC = 0x0504_0004
    OUT_OF_MEMORY = 0x0504_0005
    ACCESS = 0x0601_0000
    WRITE_ONLY = 0x0601_0001
    READ_ONLY = 0x0601_0002
    NO_OBJECT = 0x0602_0000
    NOT_MAPPABLE = 0x0604_0041
    PDO_TOO_LONG = 0x0604_0042
    PARAMETERS = 0x0604_0043
    INTERNAL = 0x0604_0047
    HARDWARE = 0x0606_0000
    LENGTH = 0x0607_0010
    TOO_LONG = 0x0607_0012
    TOO_SHORT = 0x0607_0013
    NO_SUB_INDEX = 0x0609_0011
    VALUE = 0x0609_0030
    VALUE_TOO_HIGH = 0x0609_0031
    VALUE_TOO_LOW = 0x0609_0032
    MAXIMUM_BELOW_MINIMUM = 0x0609_0036
    NO_RESOURCE = 0x060A_0023
    GENERAL = 0x0800_0000
    NOT_STORED = 0x0800_0020
    LOCAL_CONTROL = 0x0800_0021
    DEVICE_STATE = 0x0800_0022
    NO_DICTIONARY = 0x0800_0023
    NO_DATA = 0x0800_0024


ABORT_WORDS: dict[AbortCode, str] = {
    AbortCode.TOGGLE: "the toggle bit did not alternate: a frame was lost or came twice",
    AbortCode.TIMED_OUT: "the transfer took too long",
    AbortCode.COMMAND: "this is no command here and now",
    AbortCode.BLOCK_SIZE: "the block has no valid size",
    AbortCode.SEQUENCE_NUMBER: "the block has no valid sequence number",
    AbortCode.CRC: "the block's CRC is wrong",
    AbortCode.OUT_OF_MEMORY: "there is more of it than memory",
    AbortCode.ACCESS: "the object cannot be accessed so",
    AbortCode.WRITE_ONLY: "the object can only be written",
    AbortCode.READ_ONLY: "the object can only be read",
    AbortCode.NO_OBJECT: "there is no such object",
    AbortCode.NOT_MAPPABLE: "the object cannot be mapped into this PDO",
    AbortCode.PDO_TOO_LONG: "the mapped objects are too many or too long for a PDO",
    AbortCode.PARAMETERS: "the parameters do not go together",
    AbortCode.INTERNAL: "the device does not go together with itself",
    AbortCode.HARDWARE: "a hardware error prevents it",
    AbortCode.LENGTH: "the object has another length",
    AbortCode.TOO_LONG: "the value is too long for the object",
    AbortCode.TOO_SHORT: "the value is too short for the object",
    AbortCode.NO_SUB_INDEX: "the object has no such sub-index",
    AbortCode.VALUE: "the value is not allowed",
    AbortCode.VALUE_TOO_HIGH: "the value is too high",
    AbortCode.VALUE_TOO_LOW: "the value is too low",
    AbortCode.MAXIMUM_BELOW_MINIMUM: "the maximum would be below the minimum",
    AbortCode.NO_RESOURCE: "what is needed for it is not available",
    AbortCode.GENERAL: "an error of no particular kind",
    AbortCode.NOT_STORED: "the value cannot be transferred or stored",
    AbortCode.LOCAL_CONTROL: "the device is controlled locally",
    AbortCode.DEVICE_STATE: "the device's present state does not allow it",
    AbortCode.NO_DICTIONARY: "the device has no object dictionary",
    AbortCode.NO_DATA: "there is no data",
}


def abort_words(code: int) -> str:
    """Return what an abort code says."""
    try:
        return ABORT_WORDS[AbortCode(code)]
    except ValueError:
        return f"abort code {code:08X}, which CiA 301 does not have"
