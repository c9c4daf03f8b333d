"""Conclude which of an arm's MKS drives reply, and which do not: outages, and mute drives.

    Observer  the drives of an arm together
    Verdict   what ends a motion: a finding of one drive

What a reading shows is a matter of its drive alone (`bus.observer`). But a drive that does not
reply is only mute if another one does; else the bus is silent, for a moment (an outage) or longer.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from armdrive.dialects.bus.intervals import MAX_DELAY_S, DriveFinding
from armdrive.dialects.bus.questions import MUTE_POLLS
from armdrive.dialects.mks.drive import MksDrive

# No reply for this long although questions are open means a bus outage: a reply takes no longer
# than `answer_s` (0.05 by default), and the adapter adds little. On a slow link it takes longer:
# see `Ledger.longest_wait_s`. But after `MAX_DELAY_S` nothing is sent on a bus that does not reply.
OUTAGE_S = 0.06
# If all drives are silent, they get this many polls: then the computer is usually late.
SILENT_POLLS = 10
# If a drive has sent this many late readings in a row, and no drive a prompt one last, all replies
# of this bus are late. An outage makes those to at most `SILENT_POLLS` polls late, no later ones.
LATE_READINGS = 15


@dataclass(frozen=True, slots=True)
class Verdict:
    """A conclusion about a drive: its count, and its place by its orders."""

    drive: MksDrive
    finding: DriveFinding
    count: int
    place: float

    @classmethod
    def on_reading(cls, drive: MksDrive) -> Verdict:
        """Return what its last reading shows."""
        return cls(drive, drive.finding, drive.count, drive.place)


class Observer:
    """The drives of one arm, and the conclusions about all of them."""

    def __init__(self, drives: Sequence[MksDrive]) -> None:
        self.drives = tuple(drives)
        self.returned = False
        """Whether a drive has replied again after an outage, until the motion takes that up."""
        self.replied_s = -math.inf
        """When any drive replied last."""
        self._by_node = {drive.node: drive for drive in self.drives}

    def __getitem__(self, node: int) -> MksDrive:
        return self._by_node[node]

    def find(self, node: int | None) -> MksDrive | None:
        """Return the drive with an id; None if there is none."""
        return None if node is None else self._by_node.get(node)

    def watch(self) -> None:
        """Begin a motion: judge all drives from now on."""
        self.returned = False
        for drive in self.drives:
            drive.watch()

    def sent(self, drive: MksDrive, now_s: float, *, owes: bool) -> None:
        """Record a frame to a drive that needs a reply."""
        others = (each.ledger.replied_s for each in self.drives if each is not drive)
        drive.ledger.sent(now_s, max(others, default=0.0), owes=owes)

    def replied(self, drive: MksDrive, now_s: float, *, settles: bool, asked: bool = True) -> None:
        """Record a frame from a drive, as in `Ledger.replied`.

        After an outage each drive may have lost its power: a failing supply looks like a bus
        outage, but orders sent meanwhile are never answered.
        """
        if asked and self.in_outage(now_s):
            outage_s, self.returned = self.silent_s(now_s), True
            for ledger in (each.ledger for each in self.drives):
                ledger.timeout_s = max(ledger.timeout_s, outage_s + OUTAGE_S)
                ledger.suspect(now_s + ledger.timeout_s)
                ledger.unanswered_polls = 0  # no drive replied, so none is to blame
        if asked:
            self.replied_s = now_s
        drive.ledger.replied(now_s, settles=settles, asked=asked)

    @property
    def suspects(self) -> bool:
        """Whether a drive that may have been away may still send the replies it owes."""
        return any(drive.absence.suspected for drive in self.drives)

    def silent_s(self, now_s: float) -> float:
        """Return how long questions have been open without any reply; 0 if one came."""
        replied_s = self.replied_s
        opened = (drive.ledger.open_s for drive in self.drives)
        since_s = min((at_s for at_s in opened if at_s >= replied_s), default=math.inf)
        return max(now_s - since_s, 0.0)

    def in_outage(self, now_s: float) -> bool:
        """Return whether all drives have been silent for longer than they ever need to reply."""
        silent_s = self.silent_s(now_s)
        if silent_s <= OUTAGE_S:
            return False
        slowest_s = max(drive.ledger.longest_wait_s for drive in self.drives)
        return silent_s > min(slowest_s, MAX_DELAY_S)

    @property
    def doubtful(self) -> tuple[MksDrive, ...]:
        """Return the drives whose last reading is in doubt."""
        return tuple(each for each in self.drives if each.finding is DriveFinding.DOUBTED)

    @property
    def to_reread(self) -> tuple[MksDrive, ...]:
        """Those that are to be asked again: none has been asked since that reading."""
        return tuple(each for each in self.doubtful if each.ledger.asked_s <= each.read_s)

    @property
    def due_s(self) -> float:
        """When the next retry or rejection is due."""
        replied_s = self.replied_s
        asked_s = min(each.ledger.retry_s(replied_s) for each in self.drives)
        return min(asked_s, self.rejected_s)

    @property
    def rejected_s(self) -> float:
        """When a rejection is due; infinity if there is none."""
        return min(each.rejected_s for each in self.drives)

    def to_retry(self, now_s: float) -> tuple[MksDrive, ...]:
        """Return the drives to ask again: they are silent while others reply."""
        replied_s = self.replied_s
        return tuple(each for each in self.drives if now_s >= each.ledger.retry_s(replied_s))

    # -- verdicts -----------------------------------------------------------------------------

    def judge(self) -> Verdict | None:
        """Return the verdict that ends the motion, or None."""
        for drive in self.drives:
            if drive.finding.ends:
                return Verdict.on_reading(drive)
        return self.silence()

    def silence(self) -> Verdict | None:
        """Return the verdict on drives that leave polls unanswered, or reply late; or None."""
        drive = max(self.drives, key=lambda each: each.ledger.unanswered_polls)
        others = self.replied_s > drive.ledger.open_s
        late = [each.late_readings for each in self.drives]
        if min(late) and max(late) >= LATE_READINGS:
            finding = DriveFinding.LATE
        elif drive.ledger.unanswered_polls <= (MUTE_POLLS if others else SILENT_POLLS):
            return None
        else:
            finding = DriveFinding.MUTE if others else DriveFinding.SILENT
        return Verdict(drive, finding, drive.count, drive.course.place)
