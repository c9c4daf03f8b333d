"""What keeps an MKS drive from taking its orders while others go on: it is found, and named.

Motors can be coupled: where one of a wrist's two stands, the other turns a joint that nobody meant
to turn, beyond its limit perhaps. So a denial is not waited out, till the drive is far behind.
"""

from __future__ import annotations

import math
from collections.abc import Generator

from armdrive.controllers.mks_contact import MksContact
from armdrive.controllers.mks_drive import Drive
from armdrive.controllers.mks_ramps import COUNTS_S_PER_RPM
from armdrive.controllers.requests import Alert, AlertKind
from firmware_protocol.mks import SPEED_MAX_RPM, Event


class MksRefusing(MksContact):
    """Says an order that was denied again, and looks into a drive that denies that too."""

    ahead_s = math.inf
    """How far ahead drives are sent; in a burst, as far as their speeds take them."""

    @property
    def denial_s(self) -> float:
        """When a drive is to be spoken to next, because it denies what it was told."""
        return min(drive.denials.due_s for drive in self.drives)

    def say_again(self) -> Generator[float, Event | None, tuple[int, Alert] | None]:
        """Give drives that deny it their order again; return who takes none and why, if it does.

        An order may be said twice: it is absolute.
        """
        for drive in self.drives:
            if self.now_s < drive.denials.due_s:
                continue
            if not drive.denials.confirm():
                self.repeat(drive)
            elif (alert := (yield from self.hindered(drive.node))) is not None:
                return drive.node, alert
        return None

    def repeat(self, drive: Drive) -> None:
        """Say a drive's last order again, if it is sent anywhere."""
        if drive.moving:
            rpm = max(1, round(drive.told / COUNTS_S_PER_RPM), self.least_rpm(drive, drive.target))
            self.send(drive.node, drive.target, rpm, drive.acc)

    def least_rpm(self, drive: Drive, target: int) -> int:
        """Return the speed by which a drive that was seen behind is at a target when announced."""
        if abs(drive.behind) <= self.settings.rest_counts:
            return 0
        return min(drive.rpm_within(target, self.ahead_s), SPEED_MAX_RPM)

    def hindered(self, node: int) -> Generator[float, Event | None, Alert | None]:
        """Find what keeps a drive from moving: a stall, no current, or a mode; None for nothing."""
        if (yield from self.stalled((node,))) or (yield from self.off((node,))):
            return (yield from self.found_at(node))
        words = yield from self.mode_words(node)
        return Alert(AlertKind.ASTRAY, words) if words else None
