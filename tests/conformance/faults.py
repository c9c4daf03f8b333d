"""What may follow each of the happenings, and the errors that arms report after them.

Some happenings may make a device do what the driver did not command (`misdirects`). No driver can
prevent that, but it has to notice it, or stop trusting the position.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.sim.bus import DrivesBoard
from armdrive.sim.device import HasSwitches, Resettable
from armdrive.status import Trust
from tests.scenarios.happenings import Effect, Happening

from .behaviour import Rule, board_reset, limit_switches, on_bus
from .bench import Bench

WITH_CHECK_BYTES = ("robko01", "mks")
"""The dialects whose messages end in a checksum."""
RULES: Mapping[type, tuple[Rule, ...]] = MappingProxyType(
    {
        object: (),
        Resettable: (board_reset,),
        HasSwitches: (limit_switches,),
        DrivesBoard: (on_bus,),
    }
)
"""The rules that tell which arms something can happen to, by what it needs."""


def misdirects(fault: Happening, bench: Bench) -> bool:
    """Return whether the device may obey an order that was not given, or not so."""
    if fault.effect is not Effect.UNCHECKED:
        return fault.effect is Effect.MISDIRECTS
    checked_bus = bench.row.can and bench.bus_is_checked
    return bench.row.name not in WITH_CHECK_BYTES and not checked_bus


# -- The errors ------------------------------------------------------------------------------------
# The rows hold in simulated time, for an arm that is well under way or at rest. A fault without a
# row, or at another moment, may end in any way that the law of faults allows (`rows_faults`).

STRIKES_S = 0.3
"""How long after the request of a motion a fault strikes an arm that is well under way."""
MOVING, STANDING = STRIKES_S, None
"""The moments at which an error is expected."""
Moment = float | None
LOST, FAULT, SILENT, RESTARTED = "E407", "E501", "E502", "E718"
BURSTS, DRIVES = ("teachmover", "robko01", "armdroid"), ("mks", "cia402")
PROFILE = "CiA 402 drives in profile position"
CHECK_ARM = "no answer to .*Check that the arm is switched on"
CHECK_BUS = "no answer to .*power.*120 ohm.*bit rate"
CHECK_DRIVE = r"drive 2 \(shoulder\) does not answer, while others.*power.*plug"
FROM_ZERO = "counts from zero again"
ABORTED = "aborted: it does not answer as it should"
RESET = "reset,? or lost its power"


@dataclass(frozen=True, slots=True)
class ExpectedError:
    """Patterns for the code of an error and for its words, and the trust in the position."""

    code: str
    words: str
    trust: Trust = Trust.SUSPECT


MUTE, PULLED, STALLED = ("the device goes mute",), ("the cable is pulled",), ("a motor stalls",)
POWER, BOARD = ("the power fails and comes back",), ("the board resets",)
RESTARTS = (*POWER, *BOARD)
BUS_OFF, ALONE = ("the adapter leaves the bus",), ("no node acknowledges on the bus",)
GONE = ("a drive goes mute", "a drive loses its supply")
DRIVE_RESTARTS, OTHER_MODE = ("a drive restarts",), ("a drive is switched to another mode",)
TWO_IDS = ("two drives share an id",)

_Row = tuple[tuple[str, ...], Moment, tuple[str, ...], ExpectedError]
ROWS: tuple[_Row, ...] = (
    # faults, when they strike, dialects, what is reported
    (MUTE, MOVING, BURSTS, ExpectedError(SILENT, CHECK_ARM)),
    (MUTE, MOVING, ("grbl",), ExpectedError(SILENT, "arm was moving; a feed hold was sent")),
    (MUTE, STANDING, ("grbl",), ExpectedError(SILENT, CHECK_ARM)),
    ((*MUTE, *ALONE), MOVING, DRIVES, ExpectedError(SILENT, CHECK_BUS)),
    ((*MUTE, *ALONE), STANDING, DRIVES, ExpectedError(SILENT, CHECK_BUS)),
    (PULLED, MOVING, (*BURSTS, "grbl", *DRIVES), ExpectedError(LOST, "unplugged.*plug it in")),
    (PULLED, STANDING, (*BURSTS, "grbl", *DRIVES),
     ExpectedError(LOST, "unplugged.*plug it in", Trust.REFERENCED)),
    (POWER, MOVING, ("teachmover",), ExpectedError(SILENT, CHECK_ARM)),
    (RESTARTS, MOVING, ("robko01",), ExpectedError(FAULT, f"it was reset|{RESET}")),
    (RESTARTS, STANDING, ("robko01",), ExpectedError(RESTARTED, f"{RESET}: its positions are")),
    (RESTARTS, MOVING, ("armdroid",), ExpectedError(FAULT, ABORTED)),
    (RESTARTS, STANDING, ("armdroid",), ExpectedError(RESTARTED, "its greeting: it was reset")),
    (RESTARTS, MOVING, ("grbl",),
     ExpectedError(f"{SILENT}|{RESTARTED}", f"while the arm was moving|{FROM_ZERO}")),
    (BOARD, MOVING, ("grblHAL",), ExpectedError(FAULT, "")),
    (RESTARTS, STANDING, ("grbl",), ExpectedError(RESTARTED, FROM_ZERO)),
    (RESTARTS, MOVING, ("mks",), ExpectedError(FAULT, RESET)),
    (RESTARTS, STANDING, ("mks",), ExpectedError(RESTARTED, f"{RESET}.*{FROM_ZERO}")),
    (POWER, MOVING, ("cia402",),
     ExpectedError(f"{SILENT}|{RESTARTED}", f"{RESET}|{CHECK_BUS}")),
    (BOARD, MOVING, ("cia402",), ExpectedError(FAULT, RESET)),
    (RESTARTS, STANDING, ("cia402",), ExpectedError(RESTARTED, RESET)),
    (STALLED, MOVING, ("mks",), ExpectedError(FAULT, r"drive 1 \(base\)")),
    (STALLED, MOVING, ("cia402",), ExpectedError(FAULT, r"drive 1 \(base\).*it is blocked")),
    (STALLED, MOVING, (PROFILE,), ExpectedError(FAULT, r"drive 1 \(base\).*it is blocked")),
    (BUS_OFF, MOVING, DRIVES, ExpectedError(LOST, "bus-off.*resistor.*bit rate")),
    (BUS_OFF, STANDING, DRIVES,
     ExpectedError(LOST, "bus-off.*resistor.*bit rate", Trust.REFERENCED)),
    ((*GONE, *TWO_IDS), MOVING, DRIVES, ExpectedError(FAULT, CHECK_DRIVE)),
    (GONE, STANDING, DRIVES, ExpectedError(FAULT, CHECK_DRIVE)),
    (DRIVE_RESTARTS, MOVING, DRIVES, ExpectedError(FAULT, rf"drive 2 \(shoulder\) .*{RESET}")),
    (DRIVE_RESTARTS, STANDING, DRIVES,
     ExpectedError(RESTARTED, rf"drive 2 \(shoulder\) was {RESET}")),
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
"""The error by dialect or variant, name of the fault, and what the arm does when it strikes."""


def expected_error(names: tuple[str, ...], fault: str, moment: Moment) -> ExpectedError | None:
    """Return the error of the first of an arm's names that has a row; None without one."""
    found = (EXPECTED_ERRORS.get((name, fault, moment)) for name in names)
    return next((error for error in found if error is not None), None)
