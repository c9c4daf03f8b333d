"""Jogging: increments and held jogs, for programs, which wait, and for the desk, which does not."""

from __future__ import annotations

from armdrive.arm.connected import Handle, finished
from armdrive.connect.parts import PATIENCE_S, Parts
from armdrive.errors import BadRequest, Refused, WrongState
from armdrive.motion.jog.session import Jogged, check_jog, jog_session
from armdrive.moves import ContinuousJog, IncrementalJog, Jog, JogMove, speed_fraction
from armdrive.runtime.states import Event, after
from armdrive.status import State
from armdrive.tasks import Task
from kinematics.errors import finite

LONGEST_HOLD_S = 1.0  # a held jog that is not renewed within this time ends
LONGEST_WAIT_S = 1.0  # an increment that starts later than this would surprise the operator


class Jogging:
    """The jogs of one arm. One jog session at a time carries out all requests."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._core = parts.core
        self._session: Task[Jogged] | None = None

    async def jog(self, jog: Jog, speed: float, duration_s: float | None) -> Jogged:
        """Jog by an increment or for a time, and wait for the end."""
        if duration_s is None:
            return await finished(self.start(JogMove(jog, speed)))
        return await self.jog_for(jog, speed, duration_s)

    def start(self, move: JogMove) -> Handle[Jogged]:
        """Start an increment. Raises `WrongState` while another one waits."""
        with self._parts.pace.lock:
            if self._core.nudges:
                self._require(move.jog)
                raise WrongState("another increment is already waiting: wait for its end")
            task = self._begin(IncrementalJog(move.jog, move.speed))
        return Handle(self._parts.runner, task, PATIENCE_S * 10)

    async def jog_for(self, jog: Jog, speed: float, duration_s: float) -> Jogged:
        """Jog for a time, and wait for the end."""
        fraction = speed_fraction(speed)
        with self._parts.pace.lock:
            self._require(jog)
            if not finite("duration_s", duration_s) > 0.0:
                raise BadRequest(f"duration_s must be above 0, not {duration_s!r}")
            until_s = self._parts.pace.now_s() + duration_s
            task = self._begin(ContinuousJog(jog, fraction, until_s))
        return await self._parts.runner.finish(task, duration_s + PATIENCE_S * 10)

    def hold(self, jog: Jog, speed: float, for_s: float) -> None:
        """Jog for a time, unless another call extends the jog; returns at once."""
        pace = self._parts.pace
        with pace.lock:
            until_s = pace.now_s() + min(for_s, LONGEST_HOLD_S)
            self._go_on(ContinuousJog(jog, speed_fraction(speed), until_s))
        pace.wake()

    def nudge(self, jog: Jog, speed: float) -> None:
        """Jog by one increment, unless another one is already waiting; returns at once."""
        pace = self._parts.pace
        with pace.lock:
            nudge = IncrementalJog(jog, speed_fraction(speed), pace.now_s() + LONGEST_WAIT_S)
            if not self._core.nudges:
                self._go_on(nudge)
        pace.wake()

    def release(self) -> None:
        """End a held jog."""
        self._parts.core.hold = None
        self._parts.pace.wake()

    def _require(self, jog: Jog, *, joins: bool = False) -> None:
        """Raise if no jog may start now; with `joins`, a jog may extend the running session."""
        core = self._core
        check_jog(core, jog)
        alive = joins and self._session is not None and not self._session.done
        if not alive and core.state is not State.HOMING:
            after(core.state, Event.MOVE)

    def _begin(self, asked: ContinuousJog | IncrementalJog, *, joins: bool = False) -> Task[Jogged]:
        """Hand a jog to a session. Raises if the jog may not start."""
        core = self._core
        self._require(asked.jog, joins=joins)
        task = self._join_session()
        if isinstance(asked, IncrementalJog):
            core.nudges.append(asked)
        else:
            core.hold = asked
            core.holds += 1
        return task

    def _go_on(self, asked: ContinuousJog | IncrementalJog) -> None:
        """Hand a jog to a session, and report a refusal in the status's notice."""
        try:
            self._begin(asked, joins=True)
        except Refused as refusal:
            self._core.diagnostics.notify(str(refusal), refusal)

    def _join_session(self) -> Task[Jogged]:
        """Return the running jog session, or start one."""
        if self._session is None or self._session.done:
            body = jog_session(self._parts.wire, self._parts.speeds)
            self._session = self._parts.runner.submit(body, alone=True)
        return self._session
