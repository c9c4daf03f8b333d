"""The limit switch on the IN_1 of a simulated MKS drive: pressed from a physical place on."""

from __future__ import annotations

from armdrive.sim.device import SwitchState
from armdrive.sim.mks_drive import ClosedLoopDrive


class LimitSwitch:
    """A switch on the shaft of one motor, at a count and beyond in a direction."""

    def __init__(self, drive: ClosedLoopDrive, motor: int, at: int, way: int) -> None:
        self.at = at
        self.way = way
        self.state = SwitchState.FREE
        self.held = False
        """Whether somebody presses it."""
        self._drive = drive
        self._motor = motor

    @property
    def pressed(self) -> bool:
        """Whether the drive sees it pressed."""
        if self.state is not SwitchState.FREE:
            return self.state is SwitchState.CLOSED
        return self.held or (self._drive.shafts[self._motor] - self.at) * self.way >= 0
