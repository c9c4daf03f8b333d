"""The jogs of an arm: increments and timed jogs that a call waits for, and held jogs.

Programs wait for the end of a jog (`arm.jog_j`, `arm.jog_l`); the desk does not (`arm.jogging`).
Either way the jog is handed to the one session of the arm: a task of the engine (motion/jog) that
serves increments and the held jog until neither is left. A jog joins the session that is running,
or begins one.

A held jog is a lease: it ends by itself unless `hold` is called again in time. `Jogging` keeps the
press of the key that the lease belongs to. After a stop the key may still be down, and its terminal
still repeats it: such a `hold` belongs to the same press, and moves nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from armdrive.arm.arguments import RULES
from armdrive.arm.connected import BEFORE, PATIENCE, ArmPart, Handle, finished
from armdrive.connect.parts import Parts
from armdrive.connect.runner import PATIENCE_S
from armdrive.errors import BadRequest, LinkLost, Refused, Stopped, WrongState
from armdrive.errors.arguments import checked_calls, known_attributes
from armdrive.motion.jog import (
    Jogged,
    check_duration,
    increment_s,
    jog_session,
    require_allowed,
)
from armdrive.moves import ContinuousJog, IncrementalJog, Jog, JogMove, speed_fraction
from armdrive.runtime.states import Event
from armdrive.status import State
from armdrive.tasks import Task
from armdrive.trace.recorder import traced
from kinematics.errors import finite

LET_GO = "the jog was stopped: let go, then jog again"

QUEUE_PATIENCE_S = 10 * PATIENCE_S  # a jog may have to wait for the end of an earlier one
LONGEST_LEASE_S = 1.0  # a held jog that is not renewed within this time ends
LATEST_START_S = 1.0  # an increment that starts later than this would surprise the operator


class JogSessions:
    """The jogs of one arm. One jog session at a time carries out all requests."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._core = parts.core
        self._session: Task[Jogged] | None = None

    async def jog(self, jog: Jog, speed: float, duration_s: float | None) -> Jogged:
        """Jog by an increment or for a time, and wait for the end."""
        if duration_s is None:
            return await finished(self.start(JogMove(jog, speed)))
        fraction = speed_fraction(speed)
        with self._parts.pace.lock:
            self._parts.runner.require_no_stop(None, BEFORE)
            if not finite("duration_s", duration_s) > 0.0:
                raise BadRequest(f"duration_s must be above 0, not {duration_s!r}")
            until_s, bounded = self._parts.pace.now_s() + duration_s, self._core.position_known
            hold = ContinuousJog(jog, fraction, until_s, bounded)
            self._require(hold)
            check_duration(self._core, self._parts.speeds, hold, duration_s)
            task = self._begin(hold)
        return await self._parts.runner.finish(task, duration_s + QUEUE_PATIENCE_S)

    def start(self, move: JogMove, stops: int | None = None) -> Handle[Jogged]:
        """Start an increment. Raises `WrongState` while another one waits."""
        with self._parts.pace.lock:
            self._parts.runner.require_no_stop(stops, BEFORE)
            nudge = IncrementalJog(move.jog, move.speed, bounded=self._core.position_known)
            # Only one may wait: more would move the arm after the operator's last press.
            if self._core.nudges:
                self._require(nudge)  # what is wrong with the jog itself matters more
                raise WrongState("another increment is already waiting: wait for its end")
            task = self._begin(nudge)
            lasts_s = increment_s(self._core, self._parts.speeds, move.jog, move.speed)
        return Handle(self._parts.runner, task, lasts_s * PATIENCE + QUEUE_PATIENCE_S)

    def go_on(self, asked: ContinuousJog | IncrementalJog) -> None:
        """Hand a jog to a session, and report a refusal in the status's notice."""
        try:
            self._begin(asked, joins=True)
        except (Refused, LinkLost) as refusal:
            self._core.notify(str(refusal), refusal)

    def _require(self, asked: ContinuousJog | IncrementalJog, *, joins: bool = False) -> None:
        """Raise if a jog may not start now; with `joins`, it may extend the running session."""
        core, runner = self._core, self._parts.runner
        runner.require_link()
        require_allowed(core, asked)
        # a running session has passed the state machine already, and MOVING would refuse it now
        alive = joins and self._session is not None and not self._session.done
        if not alive and core.state is not State.HOMING:
            runner.require(Event.MOVE, "jogging")

    def _begin(self, asked: ContinuousJog | IncrementalJog, *, joins: bool = False) -> Task[Jogged]:
        """Hand a jog to a session. Raises if the jog may not start."""
        core = self._core
        self._require(asked, joins=joins)
        task = self._join_session()
        if isinstance(asked, IncrementalJog):
            core.nudges.append(replace(asked, holds=core.holds))
        else:
            core.hold = asked
            core.holds += 1
        return task

    def _join_session(self) -> Task[Jogged]:
        """Return the running jog session, or start one."""
        if self._session is None or self._session.done:
            body = jog_session(self._parts.context, self._parts.speeds)
            self._session = self._parts.runner.submit(body, alone=True)
        return self._session


@dataclass(frozen=True, slots=True)
class Press:
    """One press of a key, from its tap to its release; its jogs come until `until_s`.

    A stop after the first `stops` ends it, and so does the loss of the position if it is `bounded`:
    limits and guards would end its jogs when it began.
    """

    stops: int
    bounded: bool
    until_s: float = -math.inf


@known_attributes
@traced("jogging")
@checked_calls(RULES)
class Jogging(ArmPart):
    """Jogs for keys, buttons and sticks that a person holds or taps. No call waits for the end."""

    def __init__(self, parts: Parts, sessions: JogSessions) -> None:
        super().__init__(parts)
        self._sessions = sessions
        self._press: Press | None = None
        """The latest press of a key, until its `release`, even if a stop has ended its jog."""

    def hold(self, jog: Jog, *, speed: float, for_s: float) -> None:
        """Jog for `for_s` seconds (at most 1) unless another `hold` extends it; return at once.

        A `hold` within a second of a `nudge` is taken for the same press of a key. After a stop, no
        `hold` of that press moves the arm before `release` or the end of the latest `for_s`; nor
        once the position is no longer known, since no limit would end the jog.
        If the jog is refused, the status's `notice` says why until the next motion begins.
        """
        pace, runner = self._parts.pace, self._parts.runner
        with pace.lock:
            now_s, press = pace.now_s(), self._press
            if press is None or now_s >= press.until_s:
                press = self._pressed()
            press = replace(press, until_s=now_s + min(for_s, LONGEST_LEASE_S))
            asked = ContinuousJog(jog, speed_fraction(speed), press.until_s, press.bounded)
            self._press = press
            if runner.stops == press.stops:
                self._sessions.go_on(asked)
            else:
                self._core.notify(LET_GO, Stopped())
        pace.wake()

    def nudge(self, jog: Jog, *, speed: float) -> None:
        """Jog by one increment and return at once.

        At most one increment waits for the current one, and is dropped after a second.
        """
        pace = self._parts.pace
        with pace.lock:
            press = self._press = replace(self._pressed(), until_s=pace.now_s() + LATEST_START_S)
            nudge = IncrementalJog(jog, speed_fraction(speed), press.until_s, press.bounded)
            if not self._core.nudges:
                self._sessions.go_on(nudge)
        pace.wake()

    def _pressed(self) -> Press:
        """Return a press that begins now: it was decided on after every stop so far."""
        runner = self._parts.runner
        runner.know_of(runner.stops)
        return Press(runner.stops, self._core.position_known)

    def release(self) -> None:
        """End a held jog: the current burst is the last, and queued segments are dropped."""
        self._core.hold = self._press = None
        self._parts.pace.wake()
