"""Handing work to the engine and waiting for its end, and stopping whatever is at work."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, TypeVar

from armdrive.calls.knowing import Knowing
from armdrive.controllers.requests import never
from armdrive.errors import NoAnswer, Stopped
from armdrive.flows import referencing
from armdrive.pace import RealPace
from armdrive.remarks import EMERGENCY_STOP
from armdrive.states import Event, after
from kinematics.errors import finite

if TYPE_CHECKING:
    from armdrive.flow import Flow, Task
    from armdrive.flows.exchange import Wire

T = TypeVar("T")

PATIENCE_S = 60.0
"""Whatever should take no time at all is given up after this long."""


class Waiting(Knowing):
    """The calls that stop, and what every other call waits with."""

    wire: Wire
    stops = 0
    """How often a stop was asked for: what was decided on before the latest is not begun."""

    # -- stopping -----------------------------------------------------------------------------

    def request_stop(self, *, hard: bool = False) -> None:
        """Ask for a stop and return at once: the one call that a signal handler may make."""
        self.stops += 1
        self.core.hold = None
        self.engine.stop_hard = self.engine.stop_hard or hard
        self.engine.stop_asked = True
        self.pace.wake()

    def stop(self) -> None:
        """Stop, and wait until the arm stands. Legal in every state, from any thread.

        What a device cannot abort runs to its end; `status.stop_time_s` bounds it.
        """
        if not self.stand_still():
            raise NoAnswer("the arm did not confirm that it stands; look at it")

    def estop(self) -> None:
        """Stop and latch error-stop; does not wait. Only `reset` leaves it, and moves nothing.

        A device that can stop dead does so, whatever that does to its position.
        """
        self.request_stop(hard=True)  # before the lock: the engine may be holding it
        with self.pace.lock:
            self.core.fault("emergency stop: look at the arm, then call `reset()`", EMERGENCY_STOP)
            self.request_stop(hard=True)

    def reset(self) -> None:
        """Leave error-stop: wait until the line is quiet and read the registers. Moves nothing.

        In standby, or while the motors are off, it unlocks a device that was locked before.
        """
        after(self.core.state, Event.RESET)
        self.stop()
        self.perform(referencing.reset(self.wire))

    def stand_still(self) -> bool:
        """Stop, and tell whether the arm was seen to stand."""
        self.request_stop()
        # a stop that the engine has not seen yet would be taken for one of the next motion
        return self.pace.wait(lambda: self.engine.at_rest, PATIENCE_S)

    # -- waiting ------------------------------------------------------------------------------

    def submit(self, flow: Flow[T], *, alone: bool = False, within_s: float = math.inf) -> Task[T]:
        """Hand a flow to the engine. Raises `WrongState` while another is waiting there.

        With `alone` also while one is at work: what moves the arm never waits for its turn. The
        engine ends a flow that takes longer than `within_s`, with `NoAnswer`.
        """
        with self.pace.lock:
            task = self.engine.start(flow, alone=alone, within_s=within_s)
        self.pace.wake()
        return task

    def finish(self, task: Task[T], timeout_s: float) -> T:
        """Wait for a task; whatever interrupts the wait stops the arm."""
        try:
            ended = self._waited(task, timeout_s)
        except BaseException:
            self.stand_still()
            raise
        if not ended:
            self.stand_still()
            raise NoAnswer(f"the motion had not ended after {timeout_s:.0f} s and was stopped")
        return task.result()

    def _waited(self, task: Task[Any], timeout_s: float) -> bool:
        """Wait for a task, and for as much longer as it is paused or slowed down."""
        tempo = self.core.tempo
        simulated, delay_s = not isinstance(self.pace, RealPace), tempo.delay_s
        waited_s = -tempo.waited_s

        def ended() -> bool:
            if simulated and not task.done:
                tempo.breathe(waited_s + tempo.waited_s)
            return task.done

        while not self.pace.wait(ended, timeout_s):
            timeout_s, delay_s = tempo.delay_s - delay_s, tempo.delay_s
            if timeout_s <= 0.0:
                return False
        return True

    def perform(self, flow: Flow[T], within_s: float | None = None) -> T:
        """Hand a flow that moves nothing to the engine and wait for its end.

        It ends within `call_limit_s`, or `within_s` where that is given. A motion that is under
        way is waited for before that, for a minute at most.
        """
        limit_s = self.engine.call_limit_s if within_s is None else within_s
        return self.finish(self.submit(flow, within_s=limit_s), limit_s + PATIENCE_S)

    def sleep(self, time_s: float) -> None:
        """Let time pass on the arm's own clock.

        Raises `Stopped` where this program or its computer was suspended meanwhile: who waited
        for something to pass is not to move an arm when nobody expects it any more.
        """
        absences = self._absences()
        self.pace.wait(never, max(finite("time_s", time_s), 0.0))
        self._require_present(absences)

    def _absences(self) -> int:
        with self.pace.lock:
            return self.engine.absences

    def _require_present(self, absences: int) -> None:
        """Raise `Stopped` where this program has stood still since that count was taken."""
        if self._absences() != absences:
            raise Stopped(
                "the wait was ended: this program or its computer had been suspended, and nothing "
                "goes on by itself after that"
            )
