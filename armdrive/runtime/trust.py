"""How far the position can be believed: one table of what is seen, and what it does to trust.

The arms have no encoders, so trust is all there is. Evidence against a position lowers it and
never raises it; only a reference, or an operator who confirms the drawn posture, raises it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.errors import NotReferenced
from armdrive.status import Evidence, Trust

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
