"""One planned motion asked for at a screen: seen first, confirmed twice, begun, stopped with all.

Two presses of a key confirm. A key that is held repeats, so that the second press counts only
once no third one has followed it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from armdrive import Preview
from armdrive.errors import ArmError
from armdrive.moves import Motion
from armdrive.render.scene import Moment
from armdrive.status import State, Status
from kinematics.errors import KinematicsError
from kinematics.spaces import Joints
from tui.arm_view import SpaceView
from tui.move import words as move_words
from tui.screens import DeskScreen

QUIET_S = 0.3
"""So long nothing may follow the second press: a key that is held repeats sooner."""

ASKED_FOR_S = 10.0
"""A first press that is older has been forgotten."""


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


@dataclass(slots=True)
class MoveProgress:
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


# The screens on which such a motion is asked for: move and points.

Seen = tuple[Motion | None, Any, State, str]
"""What a preview was made of: it holds as long as none of it has changed."""


class ErrandScreen(DeskScreen):
    """Nothing here moves the arm but what was seen, and confirmed by two presses."""

    def __init__(self) -> None:
        super().__init__()
        self.confirming = Twice(self.desk.clock)
        self.preview: Preview | None = None
        """What the goal would lead to, as soon as that is worked out."""
        self._seen: Seen | None = None
        self._working = False
        self._progress: MoveProgress | None = None

    def goal(self, status: Status) -> Motion | None:
        """Return what is asked for now; None where nothing is."""
        raise NotImplementedError

    def disarm(self, reason: str) -> None:  # noqa: ARG002 - as every screen
        """Take a first press back."""
        self.confirming.forget()

    def look_ahead(self, status: Status) -> Preview | None:
        """Work out what has changed, go where that was confirmed, and draw it.

        Return the preview, if it is that of the present goal and place.
        """
        self._foresee(status)
        if self.confirming.due():
            self._go()
        fresh = self.preview if self._fresh(status) else None
        shown = self.preview if self._progress is not None else fresh
        self.query_one(SpaceView).show(
            Moment(
                status.joints,
                status.gripper_mm,
                goal=shown.end if shown else None,
                goal_opening_mm=status.gripper_mm,
                planned=shown.path if shown else (),
            )
        )
        return fresh

    def going_text(self, status: Status, fresh: Preview | None) -> str:
        """Say how the motion is begun, confirmed or stopped."""
        if self._progress is not None:
            return move_words.progress_text(self._progress.seen(status.joints), self.desk.keys)
        if self.confirming.waiting:
            return move_words.again_text(self.desk.keys)
        return move_words.ready_text(fresh, self.desk.keys)

    # -- the preview --------------------------------------------------------------------------

    def _asked(self, status: Status) -> Seen:
        return self.goal(status), status.acknowledged, status.state, status.trust.value

    def _fresh(self, status: Status) -> bool:
        return self._seen == self._asked(status) and not self._working

    def _foresee(self, status: Status) -> None:
        """Have a preview worked out where something has changed, one at a time, not in motion."""
        asked = self._asked(status)
        if self._working or self._progress is not None or asked == self._seen:
            return
        if status.state in (State.MOVING, State.HOMING, State.STOPPING):
            return
        self.confirming.forget()
        if asked[0] is None:
            self._seen, self.preview = asked, None
            return
        self._working = True
        work = partial(self._work_out, asked)
        self.run_worker(work, thread=True, exit_on_error=False, group="preview")

    def _work_out(self, asked: Seen) -> None:
        ask, said = asked[0], ""
        preview: Preview | None = None
        try:
            if ask is not None:
                preview = self.desk.arm.preview(ask)
        except (ArmError, KinematicsError) as error:
            said = str(error)
        finally:
            self.app.call_from_thread(self._keep, asked, preview, said)

    def _keep(self, asked: Seen, preview: Preview | None, said: str) -> None:
        self._working, self._seen, self.preview = False, asked, preview
        if said:
            self.desk.message = said
        self.desk.show()

    # -- going --------------------------------------------------------------------------------

    def action_press_go(self) -> None:
        """Take one press of the two that move the arm."""
        desk = self.desk
        if desk.nobody_there():
            return
        if self._progress is not None:
            desk.say("the arm is on its way: space stops it")
        elif self.preview is None or not self._fresh(desk.status):
            self.confirming.forget()
            desk.say("there is nothing to confirm yet: choose a goal, and look at what it would be")
        elif self.preview.refusal is not None:
            self.confirming.forget()
            desk.say(str(self.preview.refusal))
        else:
            self.confirming.press()
            desk.show()

    def _go(self) -> None:
        """Move as it is shown, unless what is shown is no longer so."""
        preview, desk = self.preview, self.desk
        ask = self._seen[0] if self._seen is not None else None
        if preview is None or ask is None or not self._fresh(desk.status):
            desk.message = "something has changed meanwhile: look at it, and confirm again"
            return
        self._progress = MoveProgress(preview)
        stops = desk.arm.stops
        desk.message = ""
        desk.call(partial(self._carry_out, ask, stops), move_words.arrived)

    def _carry_out(self, ask: Motion, stops: int) -> None:
        try:
            self.desk.arm.start(ask, stops=stops).wait()
        finally:
            self._progress = None
