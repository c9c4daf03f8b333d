"""What CANopen drives say, as messages of a recording: how each frame is weighed, and read."""

from __future__ import annotations

from armdrive.recorder import messages_can
from armdrive.recorder.weighing import Message, Weight
from armdrive.wording.canopen import TRANSMITTED, told
from firmware_protocol.canopen.cob import Service
from firmware_protocol.canopen.nmt import Heartbeat
from firmware_protocol.canopen.sdo_messages import Upload
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, pack

_OF_ITSELF = frozenset((0x1000, 0x1002, 0x1003, 0x1008, 0x1009, 0x100A, 0x1018, 0x6502))
"""Objects by which a device describes itself."""
_PASSING = frozenset((0x6041, 0x6061, 0x6064, 0x606C, 0x60F4))
"""Objects that tell of a moment; where drives rest is what has to agree."""
_PLACE = 4
"""Bytes of an SDO frame that say what is answered, and of which object."""


def weighed(frame: Frame) -> Message:
    """Return a frame as a message, by its service and its object."""
    data = pack(frame)
    try:
        said = told(frame)
    except RemoteProtocolError:
        return Message(data, Weight.ANSWER)
    message = said.message
    if isinstance(message, Heartbeat):
        return Message(data, Weight.BANNER if message.booted else Weight.PASSING)
    if said.service in TRANSMITTED:
        return Message(data, Weight.PASSING)
    if isinstance(message, Upload) and message.place.index in _OF_ITSELF:
        return Message(data, Weight.SELF)
    if isinstance(message, Upload) and message.place.index in _PASSING:
        return Message(data, Weight.PASSING)
    kind = frame.data[: 2 if said.service is Service.EMCY else _PLACE]
    return Message(data, Weight.MOMENT, frame.can_id.to_bytes(2, "big") + kind)


def words(data: bytes) -> object:
    """Return what frames of either side mean. Raises `RemoteProtocolError`."""
    return messages_can.words(data, _read)


def _read(frame: Frame) -> tuple[str, object]:
    said = told(frame)
    return said.who, said.message
