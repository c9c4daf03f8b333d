"""How far the position can be believed: one table of what is seen, and what it does to trust.

The arms have no encoders, so trust is all there is. Evidence against a position lowers it and
never raises it; only a reference, or an operator who confirms the drawn posture, raises it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from armdrive.errors import NotReferenced
from armdrive.status import Trust


class Evidence(Enum):
    """What was seen, in the words that the status shows."""

    NO_RECORD = "nothing is recorded of this arm's position"
    HOMED = "referenced in the reference posture"
    HOMED_BY_SWITCHES = "referenced by the controller's own homing"
    DECLARED = "the posture was declared by the caller"
    CONFIRMED = "the operator confirmed the recorded posture"
    RECORD_MATCHES = "recorded by an earlier program, and the registers still agree"
    RECORD_DIFFERS = "the registers differ from the recorded ones: it was moved, or lost its power"
    LINK_BACK = "the wire was lost and is back, and the registers still agree"
    ENDED_IN_MOTION = "the last program ended in mid-motion"
    RECORD_UNUSABLE = "the recorded position cannot be used"
    ANSWER_LOST = "a motion was sent and its answer never came"
    SILENT = "the controller did not answer, and may have lost its power"
    READ_BACK_DIFFERS = "the registers are not where the motion should have left them"
    MOTION_REFUSED = "the controller refused a motion that it should have understood"
    BROKEN_OFF = "a motion was broken off before its end"
    HOMING_FAILED = "the controller's homing did not end"
    OFF_ITS_MARK = "verified at its mark, and found off its position"
    STOPPED_DEAD = "the motors were stopped dead in motion, and may have lost steps"
    ALARM = "the controller went into alarm while it moved"
    OFF_THE_PATH = "the controller reported a position off the path that was sent"
    SWITCHED_OFF = "the controller switched the motors off, and the arm can sag"
    CURRENT_DROPPED = "the motor current was switched off, and the arm can sag"
    LOST_IN_MOTION = "the wire was lost while the arm moved"
    MOVED_BY_OTHERS = "the registers changed with no motion from here: by hand, or by a pendant"
    RESTARTED = "the controller announced that it was restarted"
    CONTROLLER_RESTARTED = "the registers fell to zero: the controller was reset or lost its power"


RESULTS: Mapping[Evidence, Trust] = MappingProxyType(
    {
        Evidence.NO_RECORD: Trust.UNKNOWN,
        Evidence.HOMED: Trust.REFERENCED,
        Evidence.HOMED_BY_SWITCHES: Trust.REFERENCED,
        Evidence.DECLARED: Trust.REFERENCED,
        Evidence.CONFIRMED: Trust.REFERENCED,
        Evidence.RECORD_MATCHES: Trust.RESTORED,
        Evidence.RECORD_DIFFERS: Trust.SUSPECT,
        Evidence.LINK_BACK: Trust.RESTORED,
        Evidence.ENDED_IN_MOTION: Trust.SUSPECT,
        Evidence.RECORD_UNUSABLE: Trust.UNKNOWN,
        Evidence.ANSWER_LOST: Trust.SUSPECT,
        Evidence.SILENT: Trust.SUSPECT,
        Evidence.READ_BACK_DIFFERS: Trust.SUSPECT,
        Evidence.MOTION_REFUSED: Trust.SUSPECT,
        Evidence.BROKEN_OFF: Trust.SUSPECT,
        Evidence.HOMING_FAILED: Trust.SUSPECT,
        Evidence.OFF_ITS_MARK: Trust.SUSPECT,
        Evidence.STOPPED_DEAD: Trust.SUSPECT,
        Evidence.ALARM: Trust.SUSPECT,
        Evidence.OFF_THE_PATH: Trust.SUSPECT,
        Evidence.SWITCHED_OFF: Trust.SUSPECT,
        Evidence.CURRENT_DROPPED: Trust.SUSPECT,
        Evidence.LOST_IN_MOTION: Trust.SUSPECT,
        Evidence.MOVED_BY_OTHERS: Trust.SUSPECT,
        Evidence.RESTARTED: Trust.SUSPECT,
        Evidence.CONTROLLER_RESTARTED: Trust.SUSPECT,
    }
)


@dataclass(frozen=True, slots=True)
class Belief:
    """A trust with its reason and the time it was formed, on the arm's clock."""

    trust: Trust
    reason: str
    since_s: float = 0.0

    def after(self, evidence: Evidence, now_s: float, detail: str = "") -> Belief:
        """Weigh new evidence. An unknown position stays unknown whatever else goes wrong."""
        result = RESULTS[evidence]
        if result is Trust.SUSPECT and self.trust in (Trust.UNKNOWN, Trust.SUSPECT):
            return self  # the first reason is the one that has to be mended
        if evidence is Evidence.LINK_BACK and self.trust is not Trust.REFERENCED:
            return self  # it only takes away
        reason = f"{evidence.value} ({detail})" if detail else evidence.value
        return Belief(result, reason, now_s)


FIRST_BELIEF = Belief(Trust.UNKNOWN, Evidence.NO_RECORD.value)

_REMEDY = MappingProxyType(
    {
        Trust.UNKNOWN: "bring the arm to its reference posture and call `home()`",
        Trust.SUSPECT: "look at the arm, then call `home()`",
        Trust.RESTORED: "compare the arm with the drawn posture, then call "
        "`confirm_restored()`, or connect with `allow_restored=True`",
    }
)


def require_reference(belief: Belief, *, allow_restored: bool) -> None:
    """Raise `NotReferenced`, with the way to regain trust, unless planned motion may go on."""
    if belief.trust is Trust.REFERENCED:
        return
    if belief.trust is Trust.RESTORED and allow_restored:
        return
    raise NotReferenced(
        f"planned motion needs a position that can be trusted, and this one is "
        f"{belief.trust.value}: {belief.reason}. To mend it, {_REMEDY[belief.trust]}"
    )
