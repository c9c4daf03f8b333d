"""A small host for a simulated Robko, a wire that disturbs frames by rule, and ready arms."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from functools import partial

from faults import DisturbedLink, arm_config, driven

from armdrive.arm import Arm
from armdrive.sim.device import SimDevice
from armdrive.sim.robko01 import SimRobkoBoard
from armdrive.sim.simulated_arm import link_to
from firmware_protocol.robko01 import Answer, Answered, Axes, Enable, Host, Op, Request

AA = 0xAA


@dataclass
class RobkoBench:
    """Sends one request at a time, and lets simulated time pass until the reply."""

    board: SimRobkoBoard = field(default_factory=SimRobkoBoard)
    now_s: float = 0.0

    def __post_init__(self) -> None:
        self.device = SimDevice(self.board)
        self.link = link_to(self.device)
        self.host = Host()

    def begin(self, request: Request) -> None:
        self.link.write(self.host.send(request), self.now_s)

    def finish(self, longest_s: float = 1.0) -> Answer | None:
        """Let time pass until the reply, and return it; None without one."""
        until_s = self.now_s + longest_s
        while self.now_s < until_s:
            self.now_s = min(max(self.now_s, self.link.next_s()), until_s)
            self.host.receive_data(self.link.read(self.now_s))
            while (event := self.host.next_event()) is not None:
                if isinstance(event, Answered):
                    return event.answer
        self.host.forget()
        return None

    def ask(self, request: Request) -> Answer | None:
        self.begin(request)
        return self.finish()

    def enabled(self) -> RobkoBench:
        self.ask(Enable())
        return self

    def pass_time(self, seconds: float) -> bytes:
        """Let time pass; return the bytes that arrived."""
        self.now_s += seconds
        return self.link.read(self.now_s)


def axes(*steps: int, speed: int = 100) -> Axes:
    """Return a motion of the first axes at one speed; axes that stand get no speed."""
    steps = (*steps, *(0,) * (6 - len(steps)))
    return Axes(steps, tuple(speed if each else 0 for each in steps))


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
