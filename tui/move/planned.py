"""One planned motion asked for at a screen: seen first, confirmed twice, and stopped with all."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from armdrive import Preview
from armdrive.errors import ArmError
from armdrive.moves import Motion
from armdrive.render.scene import Moment
from armdrive.status import State, Status
from kinematics.errors import KinematicsError
from kinematics.spaces import Joints
from tui.keys.presses import DoublePress
from tui.move import text as move_text
from tui.screens import ScreenHost


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


Goal = Callable[[Status], Motion | None]
"""Returns what is asked for now; None where nothing is."""

Seen = tuple[Motion | None, Any, State, str]
"""What a preview was made of: it holds as long as none of it has changed."""


class PlannedMove:
    """Moves the arm to the goal of a screen: as it was shown, and confirmed by two presses."""

    def __init__(self, desk: ScreenHost, goal: Goal) -> None:
        self.preview: Preview | None = None
        """What the goal would lead to, as soon as that is worked out."""
        self._desk = desk
        self._goal = goal
        self._presses = DoublePress(desk.clock)
        self._seen: Seen | None = None
        self._working = False
        self._progress: MoveProgress | None = None

    @property
    def working(self) -> bool:
        """Whether a preview is being worked out."""
        return self._working

    @property
    def under_way(self) -> bool:
        """Whether the arm is on its way."""
        return self._progress is not None

    @property
    def half_confirmed(self) -> bool:
        """Whether a first press waits for its second one."""
        return self._presses.waiting

    def forget_press(self) -> None:
        """Take a first press back."""
        self._presses.forget()

    def follow(self, status: Status) -> Preview | None:
        """Work out what has changed, and move if that was confirmed.

        Return the preview, if it is that of the present goal and place.
        """
        self._foresee(status)
        if self._presses.due():
            self._go()
        return self.preview if self._fresh(status) else None

    def moment(self, status: Status, fresh: Preview | None) -> Moment:
        """Return the arm as it stands, with the ghost of where it goes or would go."""
        shown = self.preview if self.under_way else fresh
        return Moment(
            status.joints,
            status.gripper_mm,
            goal=shown.end if shown else None,
            goal_opening_mm=status.gripper_mm,
            planned=shown.path if shown else (),
        )

    def text(self, status: Status, fresh: Preview | None) -> str:
        """Say how the motion is begun, confirmed or stopped."""
        keys = self._desk.keys
        if self._progress is not None:
            return move_text.progress_text(self._progress.seen(status.joints), keys)
        if self.half_confirmed:
            return move_text.again_text(keys)
        return move_text.ready_text(fresh, keys)

    # -- the preview --------------------------------------------------------------------------

    def _asked(self, status: Status) -> Seen:
        return self._goal(status), status.acknowledged, status.state, status.trust.value

    def _fresh(self, status: Status) -> bool:
        return self._seen == self._asked(status) and not self._working

    def _foresee(self, status: Status) -> None:
        """Have a preview worked out where something has changed, one at a time, not in motion."""
        asked = self._asked(status)
        if self._working or self.under_way or asked == self._seen:
            return
        if status.state in (State.MOVING, State.HOMING, State.STOPPING):
            return
        self.forget_press()
        if asked[0] is None:
            self._seen, self.preview = asked, None
            return
        self._working = True
        self._desk.in_thread(partial(self._work_out, asked, asked[0]))

    def _work_out(self, asked: Seen, ask: Motion) -> None:
        message = ""
        preview: Preview | None = None
        try:
            preview = self._desk.arm.preview(ask)
        except (ArmError, KinematicsError) as error:
            message = str(error)
        finally:
            self._desk.call_from_thread(self._keep, asked, preview, message)

    def _keep(self, asked: Seen, preview: Preview | None, message: str) -> None:
        self._working, self._seen, self.preview = False, asked, preview
        if message:
            self._desk.message = message
        self._desk.show()

    # -- going --------------------------------------------------------------------------------

    def press(self) -> None:
        """Take one press of the two that move the arm."""
        desk = self._desk
        if desk.link.says_lost():
            return
        if self.under_way:
            desk.say("the arm is on its way: space stops it")
        elif self.preview is None or not self._fresh(desk.link.status):
            self._presses.refuse()
            desk.say("there is nothing to confirm yet: choose a goal, and look at what it would be")
        elif self.preview.refusal is not None:
            self._presses.refuse()
            desk.say(str(self.preview.refusal))
        else:
            self._presses.press()
            desk.show()

    def _go(self) -> None:
        """Move as it is shown, unless what is shown is no longer so."""
        preview, desk = self.preview, self._desk
        ask = self._seen[0] if self._seen is not None else None
        if preview is None or ask is None or not self._fresh(desk.link.status):
            desk.message = "something has changed meanwhile: look at it, and confirm again"
            return
        self._progress = MoveProgress(preview)
        stops = desk.arm.stops
        desk.message = ""
        desk.call(partial(self._carry_out, ask, stops), move_text.arrived)

    def _carry_out(self, ask: Motion, stops: int) -> None:
        try:
            self._desk.arm.start(ask, stops=stops).wait()
        finally:
            self._progress = None
