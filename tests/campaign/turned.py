"""A shaft that a hand turns just before its drive is told where to hold is turned back.

A CiA 402 drive is told to hold where it was read last, at the SYNC before. Nothing tells the driver
of a hand that turns the shaft after this reading, and the drive turns the shaft back. The next
reading may be of the hand's place, and the shaft returns there. So what is excused ends where the
hand began and where it ended, and lasts for as many periods as such an order can take.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from armdrive.dialects.cia402.settings import Cia402Settings
from kinematics import Motors

from .physical import NOISE_S
from .stage import Stage

STALE_PERIODS = 4.0
"""The reading is up to a period old when the order goes out, and the drive takes a period to get
there. The reading at that SYNC is of the hand's place, and the next order may bring it back there,
which takes two periods more."""


@dataclass(frozen=True, slots=True)
class TurnedByHand:
    """Where motors stood before and after a hand turned some of them; until when that counts."""

    before: Motors
    after: Motors
    until_s: float

    def excuses(self, motors: Collection[int], there: Motors, time_s: float) -> bool:
        """Tell whether only those motors turn, and only between these two places."""
        return time_s <= self.until_s and all(
            a != b and min(a, b) <= there[motor] <= max(a, b)
            for motor, (a, b) in enumerate(zip(self.before, self.after, strict=True))
            if motor in motors
        )


def turned_by_hand(stage: Stage, before: Motors) -> TurnedByHand | None:
    """Return the excuse of motors that stood there before; None where no drive is told its place.

    Steppers stand wherever they are turned to.
    """
    settings = stage.config.device
    if not isinstance(settings, Cia402Settings):
        return None
    until_s = stage.now_s + STALE_PERIODS * settings.period_ms / 1000.0 + NOISE_S
    return TurnedByHand(before, stage.world.motors, until_s)
