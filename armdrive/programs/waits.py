"""Waits of a program or a sequence: a pause lengthens them, a stop or a suspension ends them."""

from __future__ import annotations

import time

from armdrive.arm import Arm
from armdrive.errors import Stopped
from armdrive.runtime.overrides import given_up

SLICE_S = 0.05
"""The longest sleep of a wait, on the arm's clock: between two sleeps a stop ends it."""

BREATH_S = 0.02
"""The time between two looks of a paused program whether it may go on, in real time."""


class Waits:
    """The waits of one run on one arm.

    `since`, then `stops`, is the arm's count of `stops` when the run was decided on: a later stop
    ends the run.
    """

    def __init__(self, arm: Arm, *, since: int | None = None) -> None:
        self._arm = arm
        self._runner, self._pace = arm.parts.runner, arm.parts.pace
        self.stops = arm.stops if since is None else since
        self._runner.know_of(self.stops)
        self._absences = self._runner.absences()

    @property
    def stopped(self) -> bool:
        """Whether a stop was requested since the run began."""
        return self._arm.stops != self.stops

    def require_no_stop(self) -> None:
        """Raise `Stopped` after a stop or a suspension since the run began."""
        if self.stopped:
            raise Stopped("the program was stopped")
        self._runner.require_present(self._absences)

    def attended(self) -> None:
        """Note that a person has just seen the arm. Raises `Stopped`."""
        self._absences = self._runner.absences()
        self.require_no_stop()

    def delay(self, time_s: float) -> None:
        """Wait this long on the arm's clock, not counting pauses. Raises `Stopped`."""
        now_s = self._pace.now_s
        end_s = now_s() + time_s
        while (left_s := end_s - now_s()) > 0.0:
            self._arm.sleep(min(left_s, SLICE_S))
            end_s += self.paused_s()

    def paused_s(self) -> float:
        """Wait while the arm is paused; return how long, which extends a wait."""
        began_s = self._pace.now_s()
        self.while_paused()
        return self._pace.now_s() - began_s

    def while_paused(self) -> None:
        """Wait, in real time, for as long as the arm is paused.

        Raises `Stopped`, and `WrongState` after the time that a motion would wait.
        """
        self.require_no_stop()
        if self._arm.status.paused:
            waited_s, longest_s = 0.0, self._arm.parts.core.speed_override.longest_real_s
            while self._arm.status.paused:
                if waited_s >= longest_s:
                    raise given_up(waited_s)
                time.sleep(BREATH_S)
                waited_s += BREATH_S
            self._absences = self._runner.absences()  # a person ended the pause
        self.require_no_stop()  # a stop ends a pause, too
