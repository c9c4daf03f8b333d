"""The one state machine of an arm: PLCopen's states and a table of what leads from one to another.

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
from enum import Enum
from types import MappingProxyType

from armdrive.errors import WrongState
from armdrive.status import State


class Event(Enum):
    """What can happen to an arm."""

    OPENED_HELD = "the port was opened"
    OPENED_SWITCHED = "the port was opened and the motors are off"
    LOST = "the wire was lost or closed"
    ENABLE = "enable"
    DISABLE = "disable"
    HOME = "home"
    MOVE = "move"
    DONE = "the motion has ended"
    STOP = "stop"
    FAULT = "a fault"
    RESET = "reset"
    RESET_SWITCHED = "reset, and the motors are off"


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
        # a device can be locked from before this program, which shows when something is to move
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


TRANSITIONS = _table()
"""(state, event) to the next state; what is not in the table is refused."""

_WAY_OUT = MappingProxyType(
    {
        State.DISCONNECTED: "connect first",
        State.DISABLED: "switch its motors on first: call `enable()`",
        State.HOMING: "wait for the referencing to end, or stop it",
        State.MOVING: "wait for the motion to end, or stop it",
        State.STOPPING: "wait until the arm stands",
        State.ERROR_STOP: "look at the arm, then call `reset()`",
        State.STANDBY: "nothing has to be done first",
    }
)


def after(state: State, event: Event) -> State:
    """Return the state that follows; raises `WrongState` where the table has no such row."""
    try:
        return TRANSITIONS[state, event]
    except KeyError:
        raise WrongState(
            f"{event.value} is not possible while the arm is in {state.value}: {_WAY_OUT[state]}"
        ) from None
