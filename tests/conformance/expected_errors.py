"""What each arm reports after a fault: the error's code, its words, and the trust that is left.

On simulated time, with the arm well under way or at rest. A fault that has no row here, or strikes
at another moment, may end in any way that the law of faults allows.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from armdrive.status import Trust

STRIKES_S = 0.3
"""The moment after the call for a motion at which these rows hold: the arm is well under way."""
LOST, FAULT, SILENT, RESTARTED, OFF = "E407", "E501", "E502", "E718", "E714"
BURSTS, DRIVES = ("teachmover", "robko01", "armdroid"), ("mks", "cia402")
PROFILE = "CiA 402 drives in profile position"
CHECK_ARM = "no answer to .*Check that the arm is switched on"
CHECK_BUS = "no answer to .*power.*120 ohm.*bit rate"
CHECK_DRIVE = r"drive 2 \(shoulder\) does not answer, while others.*power.*plug"
FROM_ZERO = "counts from zero again"
ABORTED = "aborted: it does not answer as it should"
RESET = "reset,? or lost its power"


class Moment(Enum):
    """What the arm does when a fault strikes."""

    MOVING = "moving"
    STANDING = "standing"


@dataclass(frozen=True, slots=True)
class ExpectedError:
    """The code of an error, a pattern that its words match, and the trust in the position."""

    code: str
    words: str
    trust: Trust = Trust.SUSPECT


MOVING, STANDING = Moment.MOVING, Moment.STANDING
MUTE, PULLED, STALLED = ("the device falls mute",), ("the cable is pulled",), ("a motor stalls",)
POWER, BOARD = ("the power fails and comes back",), ("the board resets",)
RESTARTS = (*POWER, *BOARD)
BUS_OFF, ALONE = ("the adapter leaves the bus",), ("nobody acknowledges on the bus",)
GONE = ("a drive falls mute", "a drive loses its supply")
ANEW, OTHER_MODE = ("a drive begins anew",), ("a drive is given another mode",)
TWO_IDS = ("two drives have one id",)

_Row = tuple[tuple[str, ...], Moment, tuple[str, ...], ExpectedError]
ROWS: tuple[_Row, ...] = (
    # faults, when they strike, dialects, what is reported
    (MUTE, MOVING, BURSTS, ExpectedError(SILENT, CHECK_ARM)),
    (MUTE, MOVING, ("grbl",), ExpectedError(SILENT, "arm was moving; a feed hold was sent")),
    (MUTE, STANDING, ("grbl",), ExpectedError(SILENT, CHECK_ARM)),
    ((*MUTE, *ALONE), MOVING, DRIVES, ExpectedError(SILENT, CHECK_BUS)),
    ((*MUTE, *ALONE), STANDING, DRIVES, ExpectedError(SILENT, CHECK_BUS)),
    (PULLED, MOVING, (*BURSTS, "grbl", *DRIVES), ExpectedError(LOST, "unplugged: plug it in")),
    (PULLED, STANDING, (*BURSTS, "grbl", *DRIVES),
     ExpectedError(LOST, "unplugged: plug it in", Trust.REFERENCED)),
    (POWER, MOVING, ("teachmover",), ExpectedError(SILENT, CHECK_ARM)),
    (RESTARTS, MOVING, ("robko01",), ExpectedError(FAULT, "its motors off: it was reset")),
    (RESTARTS, STANDING, ("robko01",), ExpectedError(RESTARTED, f"{RESET}: its positions are")),
    (RESTARTS, MOVING, ("armdroid",), ExpectedError(FAULT, ABORTED)),
    (RESTARTS, STANDING, ("armdroid",), ExpectedError(RESTARTED, "said Welcome: it was reset")),
    (POWER, MOVING, ("grbl",), ExpectedError(SILENT, "while the arm was moving")),
    (BOARD, MOVING, ("grbl",), ExpectedError(RESTARTED, f"while the arm was moving|{FROM_ZERO}")),
    (RESTARTS, STANDING, ("grbl",), ExpectedError(RESTARTED, FROM_ZERO)),
    (RESTARTS, MOVING, ("mks",), ExpectedError(FAULT, RESET)),
    (RESTARTS, STANDING, ("mks",), ExpectedError(RESTARTED, f"{RESET}.*{FROM_ZERO}")),
    (POWER, MOVING, ("cia402",), ExpectedError(RESTARTED, f"{RESET}|{CHECK_BUS}")),
    (BOARD, MOVING, ("cia402",), ExpectedError(FAULT, RESET)),
    (BOARD, MOVING, (PROFILE,), ExpectedError(RESTARTED, f"{RESET}|{CHECK_BUS}")),
    (RESTARTS, STANDING, ("cia402",), ExpectedError(RESTARTED, RESET)),
    (STALLED, MOVING, ("mks",), ExpectedError(FAULT, r"drive 1 \(base\)")),
    (STALLED, MOVING, ("cia402",), ExpectedError(FAULT, r"drive 1 \(base\).*following error")),
    (STALLED, MOVING, (PROFILE,), ExpectedError(FAULT, r"drive 1 \(base\).*it is blocked")),
    (BUS_OFF, MOVING, DRIVES, ExpectedError(LOST, "bus-off.*resistors and the bit rate")),
    (BUS_OFF, STANDING, DRIVES,
     ExpectedError(LOST, "bus-off.*resistors and the bit rate", Trust.REFERENCED)),
    ((*GONE, *TWO_IDS), MOVING, DRIVES, ExpectedError(FAULT, CHECK_DRIVE)),
    (GONE, STANDING, ("mks",), ExpectedError(FAULT, CHECK_DRIVE)),
    (GONE, STANDING, ("cia402",), ExpectedError(OFF, r"drive 2 \(shoulder\) no longer answers")),
    (ANEW, MOVING, DRIVES, ExpectedError(FAULT, rf"drive 2 \(shoulder\) .*{RESET}")),
    (ANEW, MOVING, (PROFILE,), ExpectedError(FAULT, CHECK_DRIVE)),
    (ANEW, STANDING, DRIVES, ExpectedError(RESTARTED, rf"drive 2 \(shoulder\) was {RESET}")),
    (OTHER_MODE, MOVING, ("mks",),
     ExpectedError(FAULT, r"drive 2 \(shoulder\) is in mode 2.*set mode 5")),
    (OTHER_MODE, MOVING, ("cia402",), ExpectedError(FAULT, r"drive 2 \(shoulder\) to mode 2")),
)  # fmt: skip
EXPECTED_ERRORS: Mapping[tuple[str, str, Moment], ExpectedError] = MappingProxyType(
    {
        (dialect, fault, moment): error
        for faults, moment, dialects, error in ROWS
        for fault in faults
        for dialect in dialects
    }
)
"""By the dialect or variant, the name of the fault, and what the arm does when it strikes."""


def expected_error(names: tuple[str, ...], fault: str, moment: Moment) -> ExpectedError | None:
    """Return what an arm reports, by the first of its names that has a row."""
    found = (EXPECTED_ERRORS.get((name, fault, moment)) for name in names)
    return next((error for error in found if error is not None), None)
