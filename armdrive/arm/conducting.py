"""Pausing, resuming and slowing an arm: for whoever watches it while a program moves it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from armdrive.arm.connected import PATIENCE_S, Connected
from armdrive.errors import NoAnswer, WrongState
from armdrive.status import State


class Conducting(Connected):
    """The calls that change when and how fast the arm goes, not where. None of them waits."""

    program: Callable[[], dict[str, Any]] | None = None
    """Tells other programs what program the arm is at work on, as plain data; None of none."""

    def pause(self) -> None:
        """Have the arm stand behind its next burst or segment, until `resume` or a stop.

        The motion under way goes on with the same plan when it is resumed, unless the arm was
        moved meanwhile; motions that are asked for later wait as well. After 8 h they are given up
        with `WrongState`, and the arm stays paused; on simulated time, a call gives up after 600 s
        where only its own program could resume. Jogs are given up at once, and refused. The
        controller's own homing and a servo's way are not paused, only stopped.
        """
        self.core.tempo.pause()
        self.pace.wake()

    def resume(self) -> None:
        """Let a paused arm go on. Nothing goes on that an error, a stop or a lost wire ended."""
        self.core.tempo.end_pause()
        self.pace.wake()

    @property
    def paused(self) -> bool:
        """Whether somebody wants the arm to wait: `status.paused`, cheap to ask for."""
        return self.core.tempo.paused

    @property
    def speed_override(self) -> float:
        """The share of the speed asked for that the arm goes with, from 0.01 to 1.

        A change holds for what is sent next: bursts, segments and jogs. Raises `BadRequest`.
        """
        return self.core.tempo.override

    @speed_override.setter
    def speed_override(self, share: float) -> None:
        self.core.tempo.set_override(share)


# Getting the arm back after its wire was lost, by hand.


class Reconnecting(Connected):
    """The call that looks for a lost wire."""

    @property
    def reconnects(self) -> bool:
        """Whether a lost wire is looked for without anybody asking, until it is back."""
        return self.mender is not None and self.mender.automatic

    def reconnect(self) -> None:
        """Look for the lost wire once, by its USB serial number where it had one. Moves nothing.

        Ends in error-stop (`reset` leaves it), or disabled where the arm was disabled before.
        What was under way or waiting when the wire was lost is not taken up again. Raises
        `PortUnavailable` while the wire is not there, `LinkLost` or `DeviceFault` where the arm
        does not answer over it, and `WrongState` while nothing is lost.
        """
        mender = self.mender
        with self.pace.lock:
            if self.engine.broken is None:
                raise WrongState("the wire is there: nothing has to be reconnected")
            if mender is None or self.closed:
                raise WrongState("this connection was closed for good: connect anew")
            before = mender.ask(self.pace.now_s())
        self.pace.wake()
        if not self.pace.wait(lambda: mender.tries > before, PATIENCE_S):
            raise NoAnswer("nobody knows whether the wire is back: look for it again")
        if self.core.state is State.DISCONNECTED and mender.trouble is not None:
            raise mender.trouble
