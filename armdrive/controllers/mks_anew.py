"""What of an MKS drive's count speaks for its having begun anew, and the words for that."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from firmware_protocol.mks import COUNTS_PER_TURN

if TYPE_CHECKING:
    from armdrive.controllers.mks_drive import Drive


def counts_anew(drive: Drive, reach: int, now_s: float) -> bool:
    """Tell whether a drive's count speaks for its having begun anew, at zero.

    It leapt to where it can have run from zero; or zero is not on its way; or it stands, and counts
    from zero within the turn that it is in; or it was gone for a moment, and has counted no more
    since than it may have run from zero.
    """
    seen = drive.seen or 0
    if drive.leap.leapt and abs(seen) <= reach + _ran_since(drive, drive.leap.since_s, now_s):
        return True
    if abs(seen) <= reach and not drive.passes(0, reach):
        return True
    if not drive.moving and _counts_within_its_turn(drive.target, seen, reach):
        return True
    gone_s = drive.gap.gone_s
    return drive.moving and gone_s < now_s and abs(seen) <= reach + _ran_since(drive, gone_s, now_s)


def _ran_since(drive: Drive, since_s: float, now_s: float) -> float:
    """Return how far a drive may have run since then, as fast as any of its orders let it."""
    return (now_s - since_s) * max(drive.fastest, drive.speeds.fastest_since(since_s))


def _counts_within_its_turn(target: int, seen: int, reach: int) -> bool:
    """Tell whether whole turns are missing of where one stands: its encoder knows the angle."""
    turns = round((target - seen) / COUNTS_PER_TURN)
    near = abs(target - seen - turns * COUNTS_PER_TURN) <= reach
    return bool(turns) and near and -reach <= seen < COUNTS_PER_TURN + reach


def anew_words(drive: Drive) -> str:
    """Say that a drive began anew, and how surely that is known."""
    if math.isinf(drive.gap.gone_s):
        return f"{drive} was reset or lost its power: it counts from zero again"
    return (
        f"{drive} was gone for a moment in motion, and counts {drive.seen}: it was reset or lost "
        "its power, most likely, and counts from zero again. Look at its supply and its plug"
    )
