"""The `?` that a GRBL board has been asked: how long it has been mute, and what they may leave.

A board answers a `?` within milliseconds, but in homing and while it starts. One that was changed
on the wire is no `?` to it but a character, and stands in front of the next line.
"""

from __future__ import annotations

import math


class Polls:
    """What is unanswered: `since_s` is when the oldest was asked, infinity where none is left.

    `stray` tells whether a character may stand in the board's line.
    """

    def __init__(self) -> None:
        self.stray = False
        self.since_s = math.inf

    def ask(self, now_s: float) -> None:
        """Take in that a report is asked for; where one was asked for before, that one is lost."""
        self.stray |= self.since_s < now_s
        self.since_s = min(self.since_s, now_s)

    def answered(self) -> None:
        """Take in a report."""
        self.since_s = math.inf

    def begin_anew(self) -> None:
        """Take in a banner: the board has forgotten what stood in its line."""
        self.since_s = math.inf
        self.stray = False
