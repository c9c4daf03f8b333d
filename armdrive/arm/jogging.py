"""Jogging: increments and holds, for programs (which wait) and for the desk (which never does)."""

from __future__ import annotations

from armdrive.arm.connected import Handle, StatusView, finished
from armdrive.connect.parts import PATIENCE_S, Parts
from armdrive.errors import BadRequest, Refused, WrongState
from armdrive.motion.jog.session import Jogged, check_jog, jog_session
from armdrive.moves import ContinuousJog, IncrementalJog, Jog, JogMove, speed_fraction
from armdrive.runtime.states import Event, after
from armdrive.status import State
from armdrive.tasks import Task
from kinematics.errors import finite

LONGEST_HOLD_S = 1.0
"""A held jog is renewed at least this often, or it ends."""

LONGEST_WAIT_S = 1.0
"""An increment that could not begin within this time is one that nobody expects any more."""


class Jogging:
    """The jogs of one arm: one session at a time takes up what is asked of it."""

    def __init__(self, parts: Parts, view: StatusView) -> None:
        self._parts = parts
        self._view = view
        self._session: Task[Jogged] | None = None

    async def jog(self, jog: Jog, speed: float, duration_s: float | None) -> Jogged:
        """Jog by an increment, or for a time, and wait for the end."""
        if duration_s is None:
            return await finished(self.start(JogMove(jog, speed)))
        return await self.jog_for(jog, speed, duration_s)

    def start(self, move: JogMove) -> Handle[Jogged]:
        """Begin an increment. Raises `WrongState` while another one waits."""
        core, pace = self._parts.core, self._parts.pace
        with pace.lock:
            self._require(move.jog)
            if core.nudges:
                raise WrongState("an increment is waiting already: wait for its end")
            task = self._join_session()
            core.nudges.append(IncrementalJog(move.jog, move.speed))
        return Handle(self._parts.runner, task, PATIENCE_S * 10)

    async def jog_for(self, jog: Jog, speed: float, duration_s: float) -> Jogged:
        """Jog for a time, and wait for the end."""
        core, pace = self._parts.core, self._parts.pace
        fraction = speed_fraction(speed)
        with pace.lock:
            self._require(jog)
            if not finite("duration_s", duration_s) > 0.0:
                raise BadRequest(f"duration_s must be above 0, not {duration_s!r}")
            hold = ContinuousJog(jog, fraction, pace.now_s() + duration_s)
            task = self._join_session()
            core.hold = hold
            core.holds += 1
        return await self._parts.runner.finish(task, duration_s + PATIENCE_S * 10)

    def _require(self, jog: Jog) -> None:
        check_jog(self._parts.core, jog)
        if self._parts.core.state is not State.HOMING:
            after(self._parts.core.state, Event.MOVE)

    def hold(self, jog: Jog, speed: float, for_s: float) -> None:
        """Jog for a time and no longer unless called again; never waits."""
        core, pace = self._parts.core, self._parts.pace
        with pace.lock:
            until_s = pace.now_s() + min(for_s, LONGEST_HOLD_S)
            hold = ContinuousJog(jog, speed_fraction(speed), until_s)
            if self._may_jog(jog):
                core.hold = hold
                core.holds += 1
        pace.wake()

    def nudge(self, jog: Jog, speed: float) -> None:
        """Jog by one increment, unless one is waiting already; never waits."""
        core, pace = self._parts.core, self._parts.pace
        with pace.lock:
            nudge = IncrementalJog(jog, speed_fraction(speed), pace.now_s() + LONGEST_WAIT_S)
            if not core.nudges and self._may_jog(jog):
                core.nudges.append(nudge)
        pace.wake()

    def release(self) -> None:
        """End a held jog."""
        self._parts.core.hold = None
        self._parts.pace.wake()

    def _may_jog(self, jog: Jog) -> bool:
        """Have a session ready to take up a jog; where that is refused, say so in the notice."""
        core = self._parts.core
        alive = self._session is not None and not self._session.done
        try:
            check_jog(core, jog)
            if not alive and core.state is not State.HOMING:
                after(core.state, Event.MOVE)
            self._join_session()
        except Refused as refusal:
            core.diagnostics.notify(str(refusal), refusal)
            return False
        return True

    def _join_session(self) -> Task[Jogged]:
        """Return the jogging under way, which takes up what was just asked, or begin one."""
        if self._session is None or self._session.done:
            body = jog_session(self._parts.wire, self._view.speeds)
            self._session = self._parts.runner.submit(body, alone=True)
        return self._session
