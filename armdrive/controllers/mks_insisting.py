"""How MKS drives are told to stop, again and again, until each has been heard to brake.

A bus may lose a stop, and with it the question whether it was heard. Waiting for that answer would
let the drive run on: whoever has not said that it brakes is told, and asked, every `INSIST_S`.
"""

from __future__ import annotations

from collections.abc import Collection, Generator
from typing import TypeVar

from armdrive.controllers.mks_easing import MksEasing
from armdrive.controllers.mks_ramps import shared_acc
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    HARD_STOP_MAX_RPM,
    Ability,
    Answered,
    Code,
    EmergencyStop,
    Event,
    MotorState,
    ReadState,
    StateRead,
    Stop,
)

T = TypeVar("T")
INSIST_S = 0.02
"""A drive that is not known to brake is told so often: some frames a turn, on any bus."""
RUNNING = (MotorState.ACCELERATING, MotorState.FULL_SPEED)
"""Whoever says this behind a stop has not heard it."""


class MksInsisting(MksEasing):
    """Says stops, and insists on them."""

    able: frozenset[Ability] = frozenset()

    def insisting(
        self, inquiry: Generator[float, Event | None, T], deaf: set[int], *, hard: bool
    ) -> Generator[float, Event | None, T]:
        """Carry out an inquiry; meanwhile say the stop to those who have not said that they brake.

        Who says so is taken out of `deaf`.
        """
        again_s, heard = self.now_s + INSIST_S, None
        while True:
            try:
                until_s = inquiry.send(heard)
            except StopIteration as ended:
                return ended.value  # type: ignore[no-any-return]
            heard = yield min(until_s, again_s) if deaf else until_s
            if _brakes(heard):
                deaf.discard(heard.node)  # type: ignore[union-attr]
            elif deaf and self.now_s >= again_s:
                again_s = self.now_s + INSIST_S
                self._insist(sorted(deaf), hard or self.stop_hard)

    def _insist(self, nodes: Collection[int], hard: bool) -> None:
        self._say_stop(nodes, hard)
        witness = tuple(node for node in self.nodes if node not in nodes)[:1]
        for node in (*nodes, *witness):  # who is gone is told from a bus that loses frames
            self.put(node, ReadState())

    def _say_stop(self, nodes: Collection[int], hard: bool) -> None:
        for drive in self.drives:
            drive.advance(self.now_s)
        fastest = max((abs(drive.speed) for drive in self.drives), default=0.0)
        for node in nodes:
            speed = abs(self.drive(node).speed)
            rpm = speed / COUNTS_PER_TURN * 60.0
            if hard and rpm <= HARD_STOP_MAX_RPM and Ability.EMERGENCY_STOP in self.able:
                self.put(node, EmergencyStop(), "EMERGENCY STOP")
            else:
                share = speed / fastest if speed else 1.0
                ramp = shared_acc(self.settings.acceleration, share)
                dead = hard and rpm <= HARD_STOP_MAX_RPM
                self.put(node, Stop(Code.ABSOLUTE_AXIS, 0 if dead else ramp), "STOP")


def runs(heard: Event | None) -> bool:
    """Tell whether a drive says that it does not brake: the stop before the question was lost."""
    state = heard.answer if isinstance(heard, Answered) else None
    return isinstance(state, StateRead) and state.state in RUNNING


def _brakes(heard: Event | None) -> bool:
    state = heard.answer if isinstance(heard, Answered) else None
    return isinstance(state, StateRead) and state.state not in RUNNING
