"""Getting the arm back after its wire was lost, by hand."""

from __future__ import annotations

from armdrive.calls.connected import Connected
from armdrive.calls.waiting import PATIENCE_S
from armdrive.errors import NoAnswer, WrongState
from armdrive.status import State


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
