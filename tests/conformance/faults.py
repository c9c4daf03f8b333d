"""The faults that every arm has to survive, and the error that each arm reports after each.

Some faults may make a device do what the driver did not command (`misdirects`). No driver can
prevent that, but it has to notice it, or stop trusting the position.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.status import Trust

from .behaviour import MOVING, STANDING, Moment, Rule, board_reset, limit_switches, on_bus
from .bench import Bench


def _never(_: Bench) -> bool:
    return False


WITH_CHECK_BYTES = ("robko01", "mks")
"""The dialects whose messages end in a checksum."""


def _unchecked(bench: Bench) -> bool:
    """Return whether the device obeys changed numbers: messages and line have no checks."""
    checked_bus = bench.row.can and bench.bus_is_checked
    return bench.row.name not in WITH_CHECK_BYTES and not checked_bus


def _always(_: Bench) -> bool:
    return True


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault: the requests to the console, and the possible effects.

    `evident` is False if no device can notice the fault: a stepper that slips. `idle` is True if
    the fault can strike a standing arm as well.
    """

    name: str
    words: tuple[str, ...]
    misdirects: Callable[[Bench], bool] = _never
    evident: bool = True
    idle: bool = True
    needs: tuple[Rule, ...] = ()


HOST, DEVICE = "from=host", "from=device"
HALF_A_LINE = 8
"""How many bytes in a row are lost: more than the rest of a short reply."""

FAULTS: tuple[Fault, ...] = (
    Fault("a message to the device is lost", (f"drop next {HOST}",)),
    Fault("a message from the device is lost", (f"drop next {DEVICE}",)),
    Fault("a byte to the device is lost", (f"drop #6 {HOST}",), misdirects=_unchecked),
    Fault("a byte from the device is lost", (f"drop #2 {DEVICE}",)),
    Fault("a byte to the device is changed", (f"corrupt next {HOST}",), misdirects=_unchecked),
    Fault("a byte from the device is changed", (f"corrupt next {DEVICE}",)),
    Fault("a message to the device arrives twice", (f"duplicate next {HOST}",), misdirects=_always),
    Fault("a message from the device arrives twice", (f"duplicate next {DEVICE}",)),
    Fault("a message to the device is late", (f"delay 0.4 next {HOST}",)),
    Fault("a message from the device is late", (f"delay 0.4 next {DEVICE}",)),
    Fault("a message to the device is very late", (f"delay 2.5 next {HOST}",), misdirects=_always),
    Fault("a message from the device is very late", (f"delay 2.5 next {DEVICE}",)),
    Fault(
        "half a line to the device is lost",
        (f"drop #4 {HOST}",) * HALF_A_LINE,
        misdirects=_unchecked,
    ),
    Fault("half a line from the device is lost", (f"drop #2 {DEVICE}",) * HALF_A_LINE),
    Fault("a noisy line to the device", (f"corrupt 0.03 {HOST} for=1",), misdirects=_unchecked),
    Fault("a noisy line from the device", (f"corrupt 0.03 {DEVICE} for=1",)),
    Fault("a line that loses bytes both ways", ("drop 0.03 for=1",), misdirects=_unchecked),
    Fault("garbage from the device", ("garbage 40",)),
    Fault("the device goes mute", ("mute",)),
    Fault("the device is mute for a second", ("mute for=1",)),
    Fault("the cable is pulled", ("unplug",)),
    Fault("the power fails and comes back", ("brown-out",)),
    Fault("the board resets", ("reset",), needs=(board_reset,)),
    Fault("a motor loses steps", ("lose-steps 1 12",), evident=False, idle=False),
    Fault("a motor stalls", ("stall 1",), evident=False, idle=False),
    Fault("a limit switch sticks closed", ("switch 1 closed",), needs=(limit_switches,)),
    Fault("a limit switch sticks open", ("switch 1 open",), needs=(limit_switches,)),
    # orders for one drive move the other
    Fault("two drives share an id", ("drive-id 2 3",), misdirects=_always, needs=(on_bus,)),
    *(
        Fault(name, tuple(words), needs=(on_bus,))
        for name, *words in (
            ("frames are lost on the bus", "drop 0.1 for=1"),
            ("frames arrive twice on the bus", "duplicate 0.3 for=1"),
            ("frames overtake each other on the bus", "overtake 0.3 for=1"),
            ("the adapter leaves the bus", "bus-off"),
            ("no node acknowledges on the bus", "alone"),
            ("a drive goes mute", "drive-mute 2"),
            ("a drive loses its supply", "drive-dead 2"),
            ("a drive restarts", "drive-reset 2"),
            ("a drive is switched to another mode", "drive-mode 2 2"),
            ("a drive does not report done", "no-done 2"),
        )
    ),
)


# -- The errors ------------------------------------------------------------------------------------
# The rows hold in simulated time, for an arm that is well under way or at rest. A fault without a
# row, or at another moment, may end in any way that the law of faults allows (`rows_faults`).

STRIKES_S = 0.3
"""How long after the request of a motion a fault strikes an arm that is well under way."""
LOST, FAULT, SILENT, RESTARTED, OFF = "E407", "E501", "E502", "E718", "E714"
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
    """The code of an error, a pattern for its words, and the trust in the position."""

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
    (POWER, MOVING, ("grbl",), ExpectedError(SILENT, "while the arm was moving")),
    (POWER, MOVING, ("grblHAL", "FluidNC"),
     ExpectedError(RESTARTED, f"while the arm was moving|{FROM_ZERO}")),
    (BOARD, MOVING, ("grbl",), ExpectedError(RESTARTED, f"while the arm was moving|{FROM_ZERO}")),
    (BOARD, MOVING, ("grblHAL",), ExpectedError(FAULT, "")),
    (RESTARTS, STANDING, ("grbl",), ExpectedError(RESTARTED, FROM_ZERO)),
    (RESTARTS, MOVING, ("mks",), ExpectedError(FAULT, RESET)),
    (RESTARTS, STANDING, ("mks",), ExpectedError(RESTARTED, f"{RESET}.*{FROM_ZERO}")),
    (POWER, MOVING, ("cia402",), ExpectedError(RESTARTED, f"{RESET}|{CHECK_BUS}")),
    (BOARD, MOVING, ("cia402",), ExpectedError(FAULT, RESET)),
    (RESTARTS, STANDING, ("cia402",), ExpectedError(RESTARTED, RESET)),
    (STALLED, MOVING, ("mks",), ExpectedError(FAULT, r"drive 1 \(base\)")),
    (STALLED, MOVING, ("cia402",), ExpectedError(FAULT, r"drive 1 \(base\).*it is blocked")),
    (STALLED, MOVING, (PROFILE,), ExpectedError(FAULT, r"drive 1 \(base\).*it is blocked")),
    (BUS_OFF, MOVING, DRIVES, ExpectedError(LOST, "bus-off.*resistor.*bit rate")),
    (BUS_OFF, STANDING, DRIVES,
     ExpectedError(LOST, "bus-off.*resistor.*bit rate", Trust.REFERENCED)),
    ((*GONE, *TWO_IDS), MOVING, DRIVES, ExpectedError(FAULT, CHECK_DRIVE)),
    (GONE, STANDING, ("mks",), ExpectedError(FAULT, CHECK_DRIVE)),
    (GONE, STANDING, ("cia402",), ExpectedError(OFF, r"drive 2 \(shoulder\) no longer answers")),
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
