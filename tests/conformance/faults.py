"""The table of faults that every arm has to survive, in the words of the simulator's console.

`strays` says where a fault may make a device do what nobody commanded, and no driver can prevent
it: that is then found out, or the position is no longer trusted.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .behaviour import Rule, board_reset, limit_switches, on_bus
from .bench import Bench


def _never(_: Bench) -> bool:
    return False


def _unchecked(bench: Bench) -> bool:
    """A changed number is a number: without check bytes the device obeys it."""
    return not bench.abilities.check_bytes


def _always(_: Bench) -> bool:
    return True


@dataclass(frozen=True, slots=True)
class Fault:
    """One fault: what the console is told, and what may come of it.

    `evident` is False where no device of this kind can notice anything: a stepper that slips.
    `idle` is True of one that can befall a standing arm as well.
    """

    name: str
    words: tuple[str, ...]
    strays: Callable[[Bench], bool] = _never
    evident: bool = True
    idle: bool = True
    needs: tuple[Rule, ...] = ()


HOST, DEVICE = "--from host", "--from device"
HALF_A_LINE = 8
"""So many bytes are lost in a row: more than the end of a short answer."""

FAULTS: tuple[Fault, ...] = (
    Fault("a message to the device is lost", (f"drop next {HOST}",)),
    Fault("a message from the device is lost", (f"drop next {DEVICE}",)),
    Fault("a byte to the device is lost", (f"drop #6 {HOST}",), strays=_unchecked),
    Fault("a byte from the device is lost", (f"drop #2 {DEVICE}",)),
    Fault("a byte to the device is changed", (f"corrupt next {HOST}",), strays=_unchecked),
    Fault("a byte from the device is changed", (f"corrupt next {DEVICE}",)),
    Fault("a message to the device comes twice", (f"duplicate next {HOST}",), strays=_always),
    Fault("a message from the device comes twice", (f"duplicate next {DEVICE}",)),
    Fault("a message to the device is late", (f"delay 0.4 next {HOST}",)),
    Fault("a message from the device is late", (f"delay 0.4 next {DEVICE}",)),
    Fault("a message to the device is very late", (f"delay 2.5 next {HOST}",), strays=_always),
    Fault("a message from the device is very late", (f"delay 2.5 next {DEVICE}",)),
    Fault("half a line goes to the device", (f"drop #4 {HOST}",) * HALF_A_LINE, strays=_unchecked),
    Fault("half a line comes from the device", (f"drop #2 {DEVICE}",) * HALF_A_LINE),
    Fault("a noisy line to the device", (f"corrupt 0.03 {HOST} --for 1",), strays=_unchecked),
    Fault("a noisy line from the device", (f"corrupt 0.03 {DEVICE} --for 1",)),
    Fault("a line that loses bytes both ways", ("drop 0.03 --for 1",), strays=_unchecked),
    Fault("garbage from the device", ("garbage 40",)),
    Fault("the device falls mute", ("mute",)),
    Fault("the device is mute for a second", ("mute --for 1",)),
    Fault("the cable is pulled", ("unplug",)),
    Fault("the power fails and comes back", ("brown-out",)),
    Fault("the board resets", ("reset",), needs=(board_reset,)),
    Fault("a motor loses steps", ("lose-steps 1 12",), evident=False, idle=False),
    Fault("a motor stalls", ("stall 1",), evident=False, idle=False),
    Fault("a limit switch sticks closed", ("switch 1 closed",), needs=(limit_switches,)),
    Fault("a limit switch sticks open", ("switch 1 open",), needs=(limit_switches,)),
    # what is told to the one moves the other
    Fault("two drives have one id", ("drive-id 2 3",), strays=_always, needs=(on_bus,)),
    *(
        Fault(name, tuple(words), needs=(on_bus,))
        for name, *words in (
            ("frames are lost on the bus", "lose-frame 0.1 --for 1"),
            ("frames come twice on the bus", "double-frame 0.3 --for 1"),
            ("frames overtake each other on the bus", "overtake 0.3 --for 1"),
            ("the adapter leaves the bus", "bus-off"),
            ("nobody acknowledges on the bus", "alone"),
            ("a drive falls mute", "drive-mute 2"),
            ("a drive loses its supply", "drive-dead 2"),
            ("a drive begins anew", "drive-reset 2"),
            ("a drive is given another mode", "drive-mode 2 2"),
            ("a drive does not say done", "no-done 2"),
        )
    ),
)
