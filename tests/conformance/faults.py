"""The table of faults that every arm has to survive, in the words of the simulator's console.

Some faults may make a device do what the driver did not command (`misdirects`). No driver can
prevent that, but it has to notice it, or stop trusting the position.
"""

from collections.abc import Callable
from dataclasses import dataclass

from .behaviour import Rule, board_reset, limit_switches, on_bus
from .bench import Bench


def _never(_: Bench) -> bool:
    return False


def _unchecked(bench: Bench) -> bool:
    """Return whether the device obeys changed numbers: messages and line have no checks."""
    return not bench.abilities.check_bytes and not (bench.row.can and bench.bus_is_checked)


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


HOST, DEVICE = "--from host", "--from device"
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
    Fault("a noisy line to the device", (f"corrupt 0.03 {HOST} --for 1",), misdirects=_unchecked),
    Fault("a noisy line from the device", (f"corrupt 0.03 {DEVICE} --for 1",)),
    Fault("a line that loses bytes both ways", ("drop 0.03 --for 1",), misdirects=_unchecked),
    Fault("garbage from the device", ("garbage 40",)),
    Fault("the device goes mute", ("mute",)),
    Fault("the device is mute for a second", ("mute --for 1",)),
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
            ("frames are lost on the bus", "lose-frame 0.1 --for 1"),
            ("frames arrive twice on the bus", "double-frame 0.3 --for 1"),
            ("frames overtake each other on the bus", "overtake 0.3 --for 1"),
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
