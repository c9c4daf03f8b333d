"""A Robko's wire that disturbs frames by rule, and ready arms on it."""

from __future__ import annotations

import re
from functools import partial

from faults import DisturbedLink, arm_config, driven

from armdrive.arm import Arm
from firmware_protocol.robko01 import Op

AA = 0xAA


def of(op: Op) -> bytes:
    """Return the pattern of frames of an operation, for the disturbed wire."""
    return rb"[^\xaa]*\xaa.." + re.escape(bytes([op]))


def op_of(data: bytes) -> Op:
    return Op(data[data.index(AA) + 3])


class FrameLink(DisturbedLink):
    """A disturbed wire that carries a Robko's frames."""

    def received(self, data: bytes) -> tuple[list[bytes], bytes]:
        frames = []
        while len(data) >= 5 and len(data) >= (size := data[2] + 5):
            frames.append(data[:size])
            data = data[size:]
        return frames, data

    def count(self, *ops: Op) -> int:
        return sum(op_of(frame) in ops for frame in self.messages)


robko_config = partial(arm_config, "robko01")
"""Makes the configuration of an arm on a Robko 01 board."""


def ready_robko(config=None, **options) -> Arm:
    """Return a referenced arm above the table, with its motors on."""
    return driven(config or robko_config(), link=FrameLink, **options)
