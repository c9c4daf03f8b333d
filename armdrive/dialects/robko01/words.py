"""Descriptions of Robko 01 messages in words, and recognition of a Robko 01."""

from __future__ import annotations

from types import MappingProxyType

from armdrive.dialects import DeviceTools
from armdrive.dialects.recognition import Certainty, Identity, Probe, Recognition, Risk
from armdrive.dialects.words import Describer, Message, Sentences, Weight, moved, plain, standing
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.events import Unreadable
from firmware_protocol.robko01 import Host, Ping, Stray
from firmware_protocol.robko01.frames import FrameSplitter, SuperFrame
from firmware_protocol.robko01.messages import (
    AXIS_NAMES,
    Acknowledged,
    Axes,
    Busy,
    Disable,
    Enable,
    MoveAbsolute,
    MoveRelative,
    MoveSpeed,
    Position,
    Positions,
    decode_answer,
    decode_request,
)


def _fastest(axes: Axes) -> int:
    return max((abs(each) for each in axes.speeds_steps_s), default=0)


def _positions(message: Positions) -> str:
    axes = message.axes
    turning = moved(AXIS_NAMES, axes.speeds_steps_s)
    still = not any(axes.speeds_steps_s)
    told = "all stand" if still else f"turning (steps/s): {turning}"
    return f"at {standing(AXIS_NAMES, axes.positions_steps)}; {told}"


def _relative(message: MoveRelative) -> str:
    return f"move: {moved(AXIS_NAMES, message.axes.positions_steps)}"


def _absolute(message: MoveAbsolute) -> str:
    axes = message.axes
    return f"move, up to {_fastest(axes)} steps/s, to {standing(AXIS_NAMES, axes.positions_steps)}"


SENTENCES: Sentences = MappingProxyType(
    {
        Positions: _positions,
        MoveRelative: _relative,
        MoveAbsolute: _absolute,
        MoveSpeed: lambda message: (
            f"turn without end (steps/s): {moved(AXIS_NAMES, message.axes.speeds_steps_s)}"
        ),
        Position: lambda _: "read the positions",
        Enable: lambda _: "switch the motors on",
        Disable: lambda _: "switch the motors off",
        Acknowledged: lambda message: f"{plain(message.op)}: {plain(message.status)}",
        Busy: lambda message: f"{plain(message.op)}: busy, motors {message.moving:06b} turn",
    }
)


class RobkoFrames:
    """Splits a byte stream into frames of the SUPER protocol and noise."""

    def __init__(self) -> None:
        self._frames = FrameSplitter()

    def feed(self, data: bytes) -> list[Message]:
        """Take bytes; return the messages that are complete."""
        self._frames.feed(data)
        found = []
        while (frame := self._frames.next_frame()) is not None:
            found.append(_weighed(frame))
        return found


def _weighed(frame: SuperFrame | Unreadable) -> Message:
    if isinstance(frame, Unreadable):
        return Message(frame.data, Weight.ANSWER)
    return Message(frame.raw, Weight.MOMENT, bytes((frame.op,)))


def _frame(data: bytes) -> SuperFrame:
    """Return the last frame in the data; the bytes before it flush the board's reader."""
    splitter = FrameSplitter()
    splitter.feed(data)
    splitter.silence()
    found = None
    while (frame := splitter.next_frame()) is not None:
        found = frame if isinstance(frame, SuperFrame) else found
    if found is None:
        raise RemoteProtocolError("no frame")
    return found


def _heard(data: bytes) -> object:
    return decode_answer(_frame(data))


def _sent(data: bytes) -> object:
    return decode_request(_frame(data))


def _hexadecimal(data: bytes) -> str:
    return data.hex(" ")


TALK = Describer(RobkoFrames, _heard, _sent, _hexadecimal, SENTENCES)


# A Robko 01 is recognised by any frame of the SUPER protocol with correct check bytes.


def _sign(received: bytes) -> Identity | None:
    host = Host()
    host.receive_data(received)
    host.silence()
    while (event := host.next_event()) is not None:
        if isinstance(event, Stray):
            return Identity("robko01", "Robko 01 SUPER protocol")
    return None


RECOGNITION = Recognition(
    _sign,
    Certainty.CHECKED,
    # six pings of six bytes: a half-sent frame of another program swallows at most 29 bytes
    (Probe("ping", Host().send(Ping()), 0.15, times=6, risk=Risk.NOISE),),
    datagrams=True,
)

TOOLS = DeviceTools(TALK, RECOGNITION)
