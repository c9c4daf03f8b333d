"""Whether MKS drives that are steered are beside the way that was checked: one of them lags alone.

The model of a drive that turns too slowly is drawn to where it is, and it keeps pace, so that it is
not doubted; but the others go on by their own time, and the arm leaves its way by all that it lags.
Drives that are late together are on their way, only later, and are well.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence

from armdrive.controllers.mks_holdups import MksHoldUps
from armdrive.controllers.mks_pace import laggard
from armdrive.controllers.mks_track import KEEP_S, LOOK_S, Track, Trip
from armdrive.controllers.requests import Alert, AlertKind, Reply
from firmware_protocol.mks import Event

LOOKS = 2
"""At so many looks in a row the drives are beside their way, before one is blamed."""

SLOWEST = 10.0
"""A drive is weighed that should turn by this part of the corridor from look to look, or more."""


def is_on(
    track: Track, counts: Sequence[int], let_pass: Sequence[float], early_s: float, late_s: float
) -> bool:
    """Tell whether there is one time, from the late one back to the early one, that fits all."""
    time_s = late_s
    while time_s > early_s - LOOK_S:
        if _fits(track, counts, let_pass, max(time_s, early_s)):
            return True
        time_s -= LOOK_S
    return False


def _fits(track: Track, counts: Sequence[int], let_pass: Sequence[float], time_s: float) -> bool:
    return all(
        abs(track.at(motor, time_s) - count) <= most
        for motor, (count, most) in enumerate(zip(counts, let_pass, strict=True))
    )


class MksBeside(MksHoldUps):
    """Ends a motion in which one drive falls behind the others."""

    def beside(self, trip: Trip) -> Generator[float, Event | None, Reply | None]:
        """Weigh where all were at the last look, once all have told; return how it ends, if so."""
        if trip.weighed or any(drive.seen_s < trip.polled_s for drive in self.drives):
            return None
        trip.weighed = True
        counts = [drive.seen or 0 for drive in self.drives]
        corridor = self.settings.corridor_counts
        slow = laggard([each.pace for each in self.drives], corridor / SLOWEST)
        if slow is not None:
            place = trip.track.at(slow, trip.polled_at_s)
            if abs(place - counts[slow]) > corridor / 2.0:
                return (yield from self._lags(slow, place))
        let_pass = [corridor + drive.late_by(self.now_s) for drive in self.drives]
        late_s = min(trip.polled_at_s + self.settings.segment_s, trip.track.end_s)
        if is_on(trip.track, counts, let_pass, max(late_s - KEEP_S, 0.0), late_s):
            trip.beside = 0
            return None
        trip.beside += 1
        if trip.beside < LOOKS:
            return None
        motor = max(
            range(len(counts)),
            key=lambda motor: abs(trip.track.at(motor, late_s) - counts[motor]) / let_pass[motor],
        )
        return (yield from self._lags(motor, trip.track.at(motor, late_s)))

    def _lags(self, motor: int, place: float) -> Generator[float, Event | None, Reply]:
        drive = self.drives[motor]
        off = abs(round(place) - (drive.seen or 0))
        alert = yield from self.hindered(drive.node)
        words = (
            f"{drive} is {off} counts beside its way, which the others keep: it is overloaded, or "
            "its supply is too weak for its speed"
        )
        return (yield from self.break_off(drive.node, alert or Alert(AlertKind.ASTRAY, words)))
