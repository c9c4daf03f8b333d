"""What keeps pushing after it has stopped: a drive whose shaft something holds aside is eased.

A closed loop pushes towards its set-point for as long as it is held off it, and springs there when
it is let free, whenever that may be. So a drive that came to rest elsewhere is sent to where its
shaft is. It tells how far that is off (39).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Generator

from armdrive.controllers.mks_drive import Drive
from armdrive.controllers.mks_ramps import COUNTS_S_PER_RPM
from armdrive.controllers.mks_talk import MksTalk
from firmware_protocol.mks import (
    ANGLE_ERROR_PER_TURN,
    COUNTS_PER_TURN,
    TARGET_MAX,
    AngleErrorRead,
    Answered,
    Event,
    MoveAbsoluteAxis,
    ReadAngleError,
)

EASE_S = 0.1
"""A set-point takes so long to come back to its shaft, ramps apart."""
EASE_MAX_RPM = 300
"""A shaft that comes free meanwhile goes no faster."""
ASKED = 2
"""How often a drive is asked how far off it is: firmware that cannot tell costs two answers."""


class MksEasing(MksTalk):
    """Sends drives to a count, and those that push to where they are."""

    def send(self, node: int, target: int, rpm: int, acc: int) -> None:
        """Send a drive to a count, at a speed and by a ramp."""
        self.put_motion(node, MoveAbsoluteAxis(target, rpm, acc))
        self.drive(node).send_to(target, rpm, acc, self.now_s)

    @property
    def targets(self) -> str:
        """Where all drives were sent last, for whoever reads what was said."""
        return " ".join(str(drive.target) for drive in self.drives)

    def put_motion(self, node: int, message: MoveAbsoluteAxis) -> None:
        """Say a motion; what the host still waits for of older ones is not waited for."""
        for earlier in self._host.unanswered(node):
            if isinstance(earlier, MoveAbsoluteAxis):
                self._host.forget(node, earlier)
        self.put(node, message)

    def ease(self, nodes: Collection[int]) -> Generator[float, Event | None, dict[int, int]]:
        """Send drives that stand, and push, to where they are; return how far off each was.

        Once only: one that hangs off its set-point wherever that is would be followed away.
        """
        messages = dict.fromkeys(nodes, ReadAngleError())
        found = yield from self.ask(messages, tries=ASKED, patient=False)
        errors = {node: _counts_off(heard) for node, heard in found.items()}
        pushing = {node: off for node, off in errors.items() if self._pushes(node, off)}
        for node, off in pushing.items():
            rpm = math.ceil(abs(off) / EASE_S / COUNTS_S_PER_RPM)
            here = self.drive(node).seen or 0
            self.send(node, here, min(rpm, EASE_MAX_RPM), self.settings.acceleration)
        return pushing

    def _pushes(self, node: int, off: int) -> bool:
        reachable = abs(self.drive(node).seen or 0) <= TARGET_MAX
        return reachable and abs(off) > self.settings.rest_counts

    def pressing_words(self, drive: Drive, off: int) -> str:
        """Say that a drive pressed against something."""
        return (
            f"{drive} pressed against something as it stopped, {abs(off)} counts from where it "
            "would stand: it is blocked, overloaded, or was turned by force. It was told to stay "
            "where it is, and pushes no more"
        )


def _counts_off(heard: Event) -> int:
    """Return how far a shaft is from its set-point, in counts; 0 where that was not told."""
    if not isinstance(heard, Answered) or not isinstance(heard.answer, AngleErrorRead):
        return 0
    return round(heard.answer.error * COUNTS_PER_TURN / ANGLE_ERROR_PER_TURN)
