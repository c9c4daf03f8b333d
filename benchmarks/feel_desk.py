"""The desk at work on an arm: whole, or on simulated time without its screen.

Both are tui's own hand on the keys. On simulated time only its timer is another one, since nobody
runs an event loop there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from random import Random
from typing import Any

from armdrive.arm import Arm
from armdrive.motion import jog as jogging
from armdrive.motion.dead_man import Action, Increment
from armdrive.tasks import TaskBody
from kinematics import Joints
from tui.desk import Desk
from tui.jog.jogging import DeskJogging
from tui.jog.screen import JogScreen
from tui.keys.table import JogPair, jog_pairs
from tui.settings import JogSettings

MIDDLE = {
    "base_deg": 0.0,
    "shoulder_deg": 40.0,
    "elbow_deg": -80.0,
    "wrist_pitch_deg": -40.0,
    "wrist_roll_deg": 0.0,
}
"""From here each joint can turn for 2 s either way; degrees."""
FAR_DEG, FAR_MM = 12.0, 40.0
"""So far from the middle a jog leads back to it."""
SWEEPING = 3
"""The first joints, and x, y, z, sweep the tip; the others turn the hand."""


class Increments:
    """Knows whether an arm of this process is making an increment, which no status tells."""

    def __init__(self) -> None:
        self.under_way = False
        self._inner = jogging._increment
        jogging._increment = self._seen  # type: ignore[assignment]

    def _seen(self, *words: Any) -> TaskBody[None]:
        self.under_way = True
        try:
            yield from self._inner(*words)
        finally:
            self.under_way = False


increments = Increments()


class Deadline:
    """Stands for the desk's timer where time is simulated: somebody looks at `due_s`."""

    def __init__(self, now_s: Callable[[], float]) -> None:
        self._now_s = now_s
        self.due_s = math.inf

    def after(self, delay_s: float) -> None:
        """Ring once after this delay; infinite means never."""
        self.due_s = self._now_s() + max(delay_s, 0.001)


def note_taps(hand: DeskJogging, noted: Callable[[], None]) -> None:
    """Have somebody told whenever the hand moves the arm by an increment."""
    inner = hand.carry_out

    def carry_out(action: Action) -> None:
        if isinstance(action, Increment):
            noted()
        inner(action)

    hand.carry_out = carry_out  # type: ignore[method-assign]


class TappingDesk(Desk):
    """A desk that remembers when it last moved the arm by an increment."""

    tapped_s = -math.inf

    @property
    def jog(self) -> JogScreen:
        """The screen with the jog keys."""
        assert isinstance(self.current, JogScreen)
        return self.current

    def watch_taps(self) -> None:
        """Begin to remember; once the desk is shown."""
        note_taps(self.jog.hand, self._tapped)

    def _tapped(self) -> None:
        self.tapped_s = self.clock()


class SimulatedDesk:
    """The desk's hand on the arm's own clock, without a screen: who lets time pass calls `tick`."""

    tapped_s = -math.inf

    def __init__(self, arm: Arm) -> None:
        self._arm = arm
        pairs = jog_pairs(arm.model.arm.joint_names)
        self.settings = JogSettings(pairs=pairs, frames=arm.frames)
        self.deadline = Deadline(arm.parts.pace.now_s)
        self.hand = DeskJogging(
            arm, clock=arm.parts.pace.now_s, say=lambda _: None, settings=self.settings
        )
        self.hand.alarm = self.deadline  # type: ignore[assignment]
        note_taps(self.hand, self._tapped)

    def _tapped(self) -> None:
        self.tapped_s = self._arm.parts.pace.now_s()

    def action_mode(self) -> None:
        """Switch between joint and Cartesian mode."""
        self.hand.release()
        self.settings.switch_mode()

    def action_faster(self) -> None:
        """Jog faster."""
        self.hand.release()
        self.settings.change_speed(1)


def set_up(desk: SimulatedDesk) -> None:
    """Set the full speed, which is the worst."""
    for _ in range(5):
        desk.action_faster()


def choose(desk: SimulatedDesk, arm: Arm, home: Joints, luck: Random) -> str:
    """Choose mode and key by chance, of the axes that sweep the tip; return the key.

    An arm that has gone far from its middle is led back.
    """
    if luck.random() < 0.5:
        desk.action_mode()
    pair = luck.choice(desk.settings.rows[:SWEEPING])
    off = _off(desk, arm, home, pair)
    sign = -math.copysign(1.0, off) if abs(off) > 1.0 else luck.choice((-1.0, 1.0))
    return pair.plus if sign > 0.0 else pair.minus


def _off(desk: SimulatedDesk, arm: Arm, home: Joints, pair: JogPair) -> float:
    """Return how far an axis is from its middle; beyond 1 it is far."""
    axis = pair.axis(cartesian=desk.settings.cartesian)
    if desk.settings.cartesian:
        here, there = arm.pose, arm.model.arm.fk(home)
        off_mm: float = getattr(here, f"{axis}_mm") - getattr(there, f"{axis}_mm")
        return off_mm / FAR_MM
    return (arm.joints.deg[axis] - home.deg[axis]) / FAR_DEG
