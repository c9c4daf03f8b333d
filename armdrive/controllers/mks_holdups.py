"""A bus that stands still for a moment while MKS drives are steered: they wait, and go on there.

Nobody is heard then: another program has the adapter's cable or the processor, or ours had no time.
Each drive ends where it was sent, which is announced. Nothing further is sent until somebody is
heard. Then all are asked where they are, and the motion goes on from that place of its way: what
was drawn for the time since is not made up for. A supply that failed looks the same, but what was
asked meanwhile is never answered. Who pauses the arm meanwhile has it stand where it stands.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Generator, Mapping

from armdrive.controllers.mks_arriving import MksArriving
from armdrive.controllers.mks_track import KEEP_S, Trip
from armdrive.controllers.requests import Reply
from firmware_protocol.mks import Event, ReadState

HELD_S = 0.06
"""A bus on which nobody has answered for so long, though somebody was asked, is held up."""


class MksHoldUps(MksArriving):
    """Notices that nobody is heard, and takes up a motion again."""

    @property
    def held_up(self) -> bool:
        """Whether nobody answers: a mute drive has been asked before others were heard last."""
        heard_s = self.answered_last_s
        asked = (drive.gap.since_s for drive in self.drives)
        return (
            self.now_s > min((at_s for at_s in asked if at_s >= heard_s), default=math.inf) + HELD_S
        )

    @property
    def soon_s(self) -> float:
        """When a drive is to be spoken to next for what it has said, or has not."""
        last_s = self.answered_last_s
        return min(self.denial_s, *(each.gap.urge_s(last_s) for each in self.drives))

    def urge(self) -> None:
        """Ask drives again that have not answered, while others did: whether they are there."""
        last_s = self.answered_last_s
        for drive in self.drives:
            if self.now_s >= drive.gap.urge_s(last_s):
                self.put(drive.node, ReadState())

    def catch_up(
        self, trip: Trip, quiet_s: float, owed: Mapping[int, int]
    ) -> Generator[float, Event | None, Reply | None]:
        """Find where the drives are after nobody was heard since a time, and go on from there.

        `owed` is as in `weigh_silence`. Return how the motion ends, where it cannot go on.
        """
        yield from self.weigh_silence(quiet_s, owed)
        if self.stop_asked:
            return None
        missing = yield from self.look_once(self.nodes)
        if set(missing) == set(self.nodes):
            trip.steered_s = self.now_s  # what was heard was said unasked: it is held up still
            return None
        end = (yield from self._found(trip, quiet_s, missing)) or (yield from self._stay(trip))
        if end is None and not self.stop_asked:
            self._go_on(trip)
        return end

    def _found(
        self, trip: Trip, quiet_s: float, missing: Collection[int]
    ) -> Generator[float, Event | None, Reply | None]:
        """Weigh where the drives were found; return how the motion ends, where one is astray."""
        if missing:
            missing = yield from self.look(missing)
        if self.stop_asked:
            return None
        if missing:
            return (yield from self.lose(quiet_s))
        early_s = max(trip.time_s - KEEP_S, 0.0)
        for motor, drive in enumerate(self.drives):
            low, high = trip.track.span(motor, early_s, trip.sent_s)
            count, margin = drive.seen or 0, self.settings.corridor_counts
            if self.began_anew(drive.node) or not low - margin <= count <= high + margin:
                return (yield from self.break_off(drive.node))
        return None

    def _stay(self, trip: Trip) -> Generator[float, Event | None, Reply | None]:
        """Stand at the last targets for as long as somebody has paused the arm meanwhile.

        It stands already: what was drawn and not sent is to wait as well. Return how the motion
        ends, where a drive that was there was turned.
        """
        while trip.held_back() and not (self.stop_asked or trip.let_go()):
            there = [node for node in self.nodes if self.is_near(node)]
            began_s = self.now_s
            yield from self.pause(began_s + self.settings.poll_s)
            missing = yield from self.look_once(self.nodes)
            if (end := (yield from self._found(trip, began_s, missing))) is not None:
                return end
            for node in there:
                if not self.is_near(node):
                    return (yield from self.break_off(node))
        return None

    def _go_on(self, trip: Trip) -> None:
        """Go on from where the drives were found."""
        early_s = max(trip.time_s - KEEP_S, 0.0)
        counts = [drive.seen or 0 for drive in self.drives]
        trip.resume(trip.track.nearest_s(counts, early_s, trip.sent_s), self.now_s)
        for drive, count in zip(self.drives, counts, strict=True):
            drive.anchor(count, self.now_s)
        self.underruns += 1
