"""One planned motion asked for at a screen: seen first, confirmed twice, begun, stopped with all.

Two presses of a key confirm. A key that is held repeats, so that the second press counts only
once no third one has followed it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from armdrive.motion.resolve import BASE

if TYPE_CHECKING:
    from armdrive.arm.handle import Handle
    from armdrive.motion.execute import Moved
    from armdrive.motion.preview import Preview
    from armdrive.storage.points import Point
    from kinematics import Joints, Pose
    from tui.arm_port import DeskArm

QUIET_S = 0.3
"""So long nothing may follow the second press: a key that is held repeats sooner."""

ASKED_FOR_S = 10.0
"""A first press that is older has been forgotten."""


@dataclass(frozen=True, slots=True)
class Ask:
    """A goal that is complete: angles of some joints, a pose or a point, and how to go there."""

    joints_deg: tuple[tuple[str, float], ...] = ()
    pose: Pose | None = None
    point: Point | None = None
    line: bool = False
    frame: str = BASE
    speed: float = 0.5


def foreseen(arm: DeskArm, ask: Ask) -> Preview:
    """Return what a goal's motion would be."""
    place = ask.pose or ask.point
    if place is None:
        named: dict[str, Any] = dict(ask.joints_deg)
        return arm.preview(speed=ask.speed, **named)
    return arm.preview(place, line=ask.line, frame=ask.frame, speed=ask.speed)


def begun(arm: DeskArm, ask: Ask) -> Handle[Moved]:
    """Begin a goal's motion."""
    place = ask.pose or ask.point
    if place is None:
        named: dict[str, Any] = dict(ask.joints_deg)
        return arm.move_j(speed=ask.speed, wait=False, **named)
    move = arm.move_l if ask.line else arm.move_to
    return move(place, speed=ask.speed, frame=ask.frame, wait=False)


@dataclass(slots=True)
class Twice:
    """Two presses of one key, with a pause behind them; a held key is none."""

    clock: Callable[[], float]
    _presses: list[float] = field(default_factory=list)

    @property
    def waiting(self) -> bool:
        """Whether a first press waits for its second one."""
        return len(self._presses) == 1

    @property
    def pressed(self) -> bool:
        """Whether there is a press that may still count."""
        return bool(self._presses)

    def press(self) -> None:
        """Take a press."""
        now_s = self.clock()
        if self._presses and now_s - self._presses[-1] > ASKED_FOR_S:
            self._presses = []
        self._presses.append(now_s)

    def due(self) -> bool:
        """Tell, once, whether two presses were meant; more of them were a held key."""
        if self.waiting and self.clock() - self._presses[-1] > ASKED_FOR_S:
            self.forget()
        if len(self._presses) < 2 or self.clock() - self._presses[-1] < QUIET_S:
            return False
        meant = len(self._presses) == 2
        self.forget()
        return meant

    def forget(self) -> None:
        """Take everything back."""
        self._presses = []


def carried_out(arm: DeskArm, begin: Callable[[], Handle[Moved]], stops: int) -> Moved:
    """Begin a motion and wait for its end; a stop that was asked for since `stops` ends it too."""
    handle = begin()
    if arm.stops != stops:  # it came while this was on its way to the arm
        handle.cancel()
    return handle.wait()


@dataclass(slots=True)
class Progress:
    """How far along a previewed way the arm has been seen; it only ever goes on."""

    preview: Preview
    index: int = 0

    def seen(self, joints: Joints | None) -> float:
        """Take a look at the arm; return the share of the way behind it, 0 to 1."""
        ahead = self.preview.postures
        if joints is not None and self.index < len(ahead):
            near = min(
                range(self.index, len(ahead)),
                key=lambda index: math.dist(ahead[index].angles_rad, joints.angles_rad),
            )
            self.index = near
        return self.index / max(len(ahead) - 1, 1)
