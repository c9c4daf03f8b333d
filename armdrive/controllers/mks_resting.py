"""Taking MKS drives for standing where they are, with none that pushes towards anywhere else."""

from __future__ import annotations

from collections.abc import Generator

from armdrive.controllers.mks_stops import MksStopping
from armdrive.controllers.requests import Denied, Oddity, Silence
from firmware_protocol.mks import Event

EASED_S = 1.5
"""A drive that was sent to where its shaft is stands there long before."""

Hindrance = Generator[float, Event | None, Silence | Denied | None]


class MksResting(MksStopping):
    """Knows where drives stand, before they are moved."""

    def take_up(self) -> Hindrance:
        """Take every drive for standing where it is."""
        began_s = self.now_s
        if missing := (yield from self.look()):
            return self.absence(missing, began_s)
        for drive in self.drives:
            self._host.settle(drive.node)
            if drive.moving or drive.count(self.settings.rest_counts) != drive.target:
                drive.rest_at(drive.seen or 0, self.now_s)
        return None

    def take_up_at_rest(self) -> Hindrance:
        """Take drives for standing where they are, and have none push towards anywhere else.

        One may have been blocked as its last program, or its cable, was lost: nobody eased it then,
        and it would spring to its set-point whenever it comes free.
        """
        hindrance = yield from self.take_up()
        if hindrance is not None:
            return hindrance
        pushing = yield from self.ease(self.nodes)
        if not pushing:
            return None
        yield from self.eased(pushing, self.now_s + EASED_S)
        for node, off in pushing.items():
            if why := (yield from self.mode_words(node)):  # it does not hear, and pushes on
                return Denied(why, moved=False)
            self.tell(Oddity(self.pressing_words(self.drive(node), off)))
        return (yield from self.take_up())
