"""What a Tutor board and its host say, in words, and how one is recognised."""

from __future__ import annotations

from types import MappingProxyType

from armdrive.dialects import DeviceTools
from armdrive.dialects.recognition import Certainty, Identity, Probe, Recognition, Risk, decoded
from armdrive.dialects.words import AnswerLines, Describer, Sentences, answer, moved, standing
from firmware_protocol.tutor import (
    Failed,
    Move,
    Ok,
    Positions,
    Where,
    decode_answer,
    decode_command,
    encode,
)

MOTORS = ("base", "shoulder", "elbow", "right wrist", "left wrist", "gripper")

SENTENCES: Sentences = MappingProxyType(
    {
        Move: lambda message: f"move at {message.rate_hz} steps/s: {moved(MOTORS, message.steps)}",
        Where: lambda _: "read the positions",
        Ok: lambda _: "done",
        Failed: lambda _: "not understood",
        Positions: lambda message: f"at {standing(MOTORS, message.steps)}",
    }
)

TALK = Describer(
    lambda: AnswerLines(b"\r\n", answer), decode_answer, decode_command, sentences=SENTENCES
)


def _sign(heard: bytes) -> Identity | None:
    messages = decoded(heard, b"\r\n", decode_answer)
    found = any(isinstance(message, Positions) for message in messages)
    return Identity("tutor", "Tutor board") if found else None


RECOGNITION = Recognition(
    _sign,
    Certainty.WORDED,
    (Probe("P", encode(Where()), 0.3, times=2, risk=Risk.LINE_END),),
)

TOOLS = DeviceTools(TALK, RECOGNITION)
