"""The state machine of an arm, and how evidence and alerts change the trust in its position.

The states are PLCopen's. Trust is independent of them.

disconnected --opened--> standby (or disabled, where the device can switch its motor current)
standby --move--> moving --done--> standby;  standby --home--> homing --done--> standby
moving, homing --stop--> stopping --done--> standby
any but disconnected --fault--> error-stop --reset--> standby (or disabled, where the device's
motors went off meanwhile);  any --lost--> disconnected

`stop` is legal everywhere. Error-stop latches: only `reset` leaves it. It is legal in
standby and disabled too, where it unlocks the device. It never moves anything.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType

from armdrive.errors import NotReferenced, WrongState
from armdrive.status import WAYS_OUT, WAYS_TO_TRUST, Evidence, State, Trust
from armdrive.tasks import AlertKind


class Event(Enum):
    """The events of the state machine, in the words of the sentence that refuses them."""

    OPENED_HELD = "the port was opened"
    OPENED_SWITCHED = "the port was opened and the motors are off"
    LOST = "the connection was lost or closed"
    ENABLE = "switching the motors on"
    DISABLE = "switching the motors off"
    HOME = "referencing"
    MOVE = "a motion"
    DONE = "the motion has ended"
    STOP = "a stop"
    FAULT = "a fault"
    RESET = "a reset"
    RESET_SWITCHED = "a reset, and the motors are off"


def _table() -> Mapping[tuple[State, Event], State]:
    s, e = State, Event
    rows: dict[tuple[State, Event], State] = {
        (s.DISCONNECTED, e.OPENED_HELD): s.STANDBY,
        (s.DISCONNECTED, e.OPENED_SWITCHED): s.DISABLED,
        (s.DISABLED, e.ENABLE): s.STANDBY,
        (s.STANDBY, e.ENABLE): s.STANDBY,
        (s.STANDBY, e.DISABLE): s.DISABLED,
        (s.DISABLED, e.DISABLE): s.DISABLED,
        (s.STANDBY, e.MOVE): s.MOVING,
        (s.STANDBY, e.HOME): s.HOMING,
        (s.MOVING, e.DONE): s.STANDBY,
        (s.HOMING, e.DONE): s.STANDBY,
        (s.STOPPING, e.DONE): s.STANDBY,
        (s.MOVING, e.STOP): s.STOPPING,
        (s.HOMING, e.STOP): s.STOPPING,
        (s.ERROR_STOP, e.RESET): s.STANDBY,
        (s.ERROR_STOP, e.RESET_SWITCHED): s.DISABLED,
        # a device may be locked since before this program started, which latches no error
        (s.STANDBY, e.RESET): s.STANDBY,
        (s.STANDBY, e.RESET_SWITCHED): s.DISABLED,
        (s.DISABLED, e.RESET): s.DISABLED,
        (s.DISABLED, e.RESET_SWITCHED): s.DISABLED,
    }
    for state in s:
        rows.setdefault((state, e.STOP), state)
        rows[state, e.LOST] = s.DISCONNECTED
        if state is not s.DISCONNECTED:
            rows[state, e.FAULT] = s.ERROR_STOP
    return MappingProxyType(rows)


# (state, event) to the next state. Any other combination is refused.
TRANSITIONS = _table()


def after(state: State, event: Event, action: str = "") -> State:
    """Return the next state; raises `WrongState` if the table has no such row.

    `action` names the call in the error, if it differs from the event.
    """
    try:
        return TRANSITIONS[state, event]
    except KeyError:
        call = action or event.value
        raise WrongState(
            f"{call} is not possible while the arm is {state.where}: {WAYS_OUT[state]}"
        ) from None


# Trust in the position. `status.Evidence` says what each observation makes of it.
#
# Most of the arms have no encoders, so a wrong position cannot be measured. Evidence against a
# position lowers trust; only a reference, or an operator who confirms the drawn posture, raises it.

# Evidence that the motors may be without current, until the device says whether they are.
UNPOWERED = frozenset(
    {
        Evidence.SWITCHED_OFF,
        Evidence.CURRENT_DROPPED,
        Evidence.RESTARTED,
        Evidence.CONTROLLER_RESTARTED,
    }
)

# An alert, a device's unsolicited message, is evidence too.

# The evidence of each alert about the position; None if the device still guarantees it.
ALERTED: Mapping[AlertKind, Evidence | None] = MappingProxyType(
    {
        AlertKind.RESTARTED: Evidence.RESTARTED,
        AlertKind.ALARM: None,
        AlertKind.ALARM_LOST: Evidence.ALARM,
        AlertKind.SWITCHED_OFF: Evidence.SWITCHED_OFF,
        AlertKind.OFF_PATH: Evidence.OFF_THE_PATH,
        AlertKind.LOCKED: None,
    }
)


# Joins the first reason for a suspect position to the latest one.
THEN = "; then "


@dataclass(frozen=True, slots=True)
class Belief:
    """A trust, its reason, and the time of the evidence on the arm's clock."""

    trust: Trust
    reason: str
    since_s: float = 0.0

    def after(self, evidence: Evidence, now_s: float, detail: str = "") -> Belief:
        """Return the belief after new evidence. An unknown position cannot become suspect."""
        result = evidence.trust
        if result is Trust.SUSPECT and self.trust is Trust.UNKNOWN:
            return self
        if evidence is Evidence.LINK_BACK and self.trust is not Trust.REFERENCED:
            return self  # a returning link can only lower trust
        reason = f"{evidence.value} ({detail})" if detail else evidence.value
        if result is self.trust is Trust.SUSPECT:  # of several reasons, the first and the latest
            first = self.reason.split(THEN)[0]
            told = evidence.value in self.reason
            return self if told else replace(self, reason=f"{first}{THEN}{reason}")
        return Belief(result, reason, now_s)

    def allows_planning(self, *, allow_restored: bool) -> bool:
        """Return whether planned motion is allowed, and coordinates and soft limits mean anything.

        A restored position counts once its operator or caller has accepted it.
        """
        return self.trust is Trust.REFERENCED or (self.trust is Trust.RESTORED and allow_restored)


FIRST_BELIEF = Belief(Trust.UNKNOWN, Evidence.NO_RECORD.value)


PLANNED_MOTION = "planned motion needs"


def require_reference(belief: Belief, *, allow_restored: bool, what: str = PLANNED_MOTION) -> None:
    """Raise `NotReferenced`, with the remedy, unless planned motion is allowed.

    `what` begins the message: what needs a trusted position.
    """
    if not belief.allows_planning(allow_restored=allow_restored):
        raise NotReferenced(
            f"{what} a trusted position, and this one is {belief.trust.value}: "
            f"{belief.reason}. To fix this, {WAYS_TO_TRUST[belief.trust]}"
        )
