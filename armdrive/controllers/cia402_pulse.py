"""Whether CiA 402 drives that stand are there still: by their heartbeats, while nothing is asked.

In motion each tells what it is with every SYNC. A drive whose heartbeat is missing is asked by SYNC
a few times before it counts as lost: frames can be. Where all are silent, it is the bus or this
computer, which the next look at the positions finds out.
"""

from __future__ import annotations

import math

from armdrive.controllers.cia402_hearing import Cia402Hearing
from armdrive.controllers.requests import Alert, AlertKind

BEATS_LOST = 3.5
"""So many of its heartbeats a drive may miss."""
LOOKS_LOST = 4
LATE_S = 0.1
"""Who was not called for so long has not read what was said meanwhile."""


class Cia402Pulse(Cia402Hearing):
    """Minds the heartbeats of the drives at rest."""

    _minded_s = -math.inf
    _looked_s = -math.inf

    def advance(self, now_s: float) -> bytes:
        """Do what is due by now; look whether every drive is heard."""
        self.now_s = now_s
        late = now_s - self._minded_s > self.beats.period_s + LATE_S
        self._minded_s = now_s
        if self.on and self.contacted and not self.busy:
            if late:
                for drive in self.drives:
                    drive.heard_s = max(drive.heard_s, now_s)
            self._mind()
        return super().advance(now_s)

    def _mind(self) -> None:
        patience_s = BEATS_LOST * self.settings.drive_beat_ms / 1000.0
        quiet = [each for each in self.drives if each.heard_s < self.now_s - patience_s]
        if not quiet or len(quiet) == len(self.drives):
            return
        for drive in quiet:
            if drive.missed > LOOKS_LOST and not drive.reported:
                drive.reported, self.on = True, False
                words = f"{drive} is not heard any more: it has lost its power, or its cable"
                self.tell(Alert(AlertKind.SWITCHED_OFF, words))
        if self.now_s >= self._looked_s + self.beats.period_s:
            self._looked_s = self.now_s
            self.sync()
