"""What can happen to an arm: to its wire, its board, or one of its drives.

Each row is a request to the simulator's console, with the numbers that the conformance suite uses,
and the same request with numbers that the campaign draws. `Effect` says what no driver can know or
prevent. What happens to programs and their disks is in `tests/campaign/programs.py`.
"""

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from types import MappingProxyType

from armdrive.sim.bus import DrivesBoard
from armdrive.sim.device import HasSwitches, Resettable


class Effect(Enum):
    """What a driver cannot know, or not prevent, after something has happened."""

    NONE = "the driver can notice it in time"
    DISTURBS = "drives on a bus may miss orders, or get them late, until it is over"
    UNCHECKED = "a device whose messages have no check bytes may obey a changed order"
    MISDIRECTS = "the device may obey an order that was not given"
    RESTARTS = "motors lose their current, and count from zero"
    SLIPS = "a stepper leaves its place, and gives no evidence of it"
    STICKS = "a limit switch is wrong, and so is what it references"
    CUTS_OFF = "the device hears nothing from its program any more"


@dataclass(frozen=True, slots=True)
class Happening:
    """One thing that can happen: `words` as the conformance suite chooses them.

    `drawn` are the words of the campaign, with names of `NUMBERS` in braces; by default the same.
    """

    name: str
    words: tuple[str, ...]
    drawn: str
    effect: Effect
    needs: type

    @property
    def idle(self) -> bool:
        """Whether it can strike a standing arm: a motor that stands cannot slip."""
        return self.effect is not Effect.SLIPS

    @property
    def of_bytes(self) -> bool:
        """Whether it strikes single bytes: on a bus these are frames, as messages are."""
        return self.name.startswith(("a byte ", "half a line "))

    def draw(self, draw: random.Random, motors: int) -> "Drawn":
        """Draw the numbers of this happening, for an arm with some motors."""
        numbers: dict[str, object] = {name: pick(draw) for name, pick in NUMBERS.items()}
        numbers["motor"] = motor = draw.randint(1, motors)
        words = self.drawn.format(**numbers)
        lasts_s = numbers["s"] if "{s}" in self.drawn else numbers["late"]
        lasting = any(name in self.drawn for name in ("{s}", "{late}"))
        struck = (motor - 1,) if "{motor}" in self.drawn else tuple(range(motors))
        return Drawn(words, float(str(lasts_s)) if lasting else 0.0, struck)


@dataclass(frozen=True, slots=True)
class Drawn:
    """A happening with its numbers: its words, its duration, and the motors that it strikes."""

    words: str
    lasts_s: float
    motors: tuple[int, ...]


NUMBERS: Mapping[str, Callable[[random.Random], object]] = MappingProxyType(
    {
        "s": lambda draw: draw.choice((0.1, 0.3, 0.6, 1.0, 2.0, 5.0)),
        "late": lambda draw: draw.choice((0.05, 0.2, 0.4)),
        "count": lambda draw: draw.choice((draw.randint(1, 8), draw.randint(1, 30))),
        "share": lambda draw: draw.choice((0.005, 0.03, 0.1)),
        "bytes": lambda draw: draw.choice((1, 8, 40, 300)),
        "steps": lambda draw: draw.choice((1, 5, 40)),
        "node": lambda draw: draw.randint(1, 7),
    }
)
"""How the campaign draws a number of each name. Times are in seconds."""
HOST, DEVICE = "from=host", "from=device"
HALF_A_LINE = 8
"""How many bytes in a row are lost: more than the rest of a short reply."""


def row(
    name: str,
    words: str,
    drawn: str = "",
    effect: Effect = Effect.NONE,
    *,
    needs: type = object,
    times: int = 1,
) -> Happening:
    """Return a row of the table; the words are requested several times in a row."""
    return Happening(name, (words,) * times, drawn or words, effect, needs)


def on_bus(name: str, words: str, drawn: str, effect: Effect = Effect.NONE) -> Happening:
    """Return a row for drives on a CAN bus."""
    return row(name, words, drawn, effect, needs=DrivesBoard)


E = Effect
HAPPENINGS: tuple[Happening, ...] = (
    row("a message to the device is lost", f"drop next {HOST}"),
    row("a message from the device is lost", f"drop next {DEVICE}"),
    row("a byte to the device is lost", f"drop #6 {HOST}", f"drop #{{count}} {HOST}", E.UNCHECKED),
    row("a byte from the device is lost", f"drop #2 {DEVICE}", f"drop #{{count}} {DEVICE}"),
    row("a byte to the device is changed", f"corrupt next {HOST}", f"corrupt #{{count}} {HOST}",
        E.UNCHECKED),
    row("a byte from the device is changed", f"corrupt next {DEVICE}",
        f"corrupt #{{count}} {DEVICE}"),
    row("a message to the device arrives twice", f"duplicate next {HOST}", "", E.MISDIRECTS),
    row("a message from the device arrives twice", f"duplicate next {DEVICE}"),
    row("a message to the device is late", f"delay 0.4 next {HOST}", f"delay {{late}} next {HOST}",
        E.DISTURBS),
    row("a message from the device is late", f"delay 0.4 next {DEVICE}",
        f"delay {{late}} next {DEVICE}"),
    row("a message to the device is very late", f"delay 2.5 next {HOST}", "", E.MISDIRECTS),
    row("a message from the device is very late", f"delay 2.5 next {DEVICE}"),
    row("half a line to the device is lost", f"drop #4 {HOST}", "", E.UNCHECKED,
        times=HALF_A_LINE),
    row("half a line from the device is lost", f"drop #2 {DEVICE}", times=HALF_A_LINE),
    row("a noisy line to the device", f"corrupt 0.03 {HOST} for=1",
        f"corrupt {{share}} {HOST} for={{s}}", E.UNCHECKED),
    row("a noisy line from the device", f"corrupt 0.03 {DEVICE} for=1",
        f"corrupt {{share}} {DEVICE} for={{s}}"),
    row("a line that loses bytes both ways", "drop 0.03 for=1", "drop {share} for={s}",
        E.UNCHECKED),
    row("garbage from the device", "garbage 40", "garbage {bytes}"),
    row("the device goes mute", "mute", "mute for={s}"),
    row("the device is mute for a second", "mute for=1"),
    row("the cable is pulled", "unplug", "unplug for={s}", E.CUTS_OFF),
    row("the power fails and comes back", "brown-out", "brown-out for={s}", E.RESTARTS),
    row("the board resets", "reset", "", E.RESTARTS, needs=Resettable),
    row("a motor loses steps", "lose-steps 1 12", "lose-steps {motor} {steps}", E.SLIPS),
    row("a motor stalls", "stall 1", "stall {motor} for={s}", E.SLIPS),
    row("a limit switch sticks closed", "switch 1 closed", "switch {motor} closed for={s}",
        E.STICKS, needs=HasSwitches),
    row("a limit switch sticks open", "switch 1 open", "switch {motor} open for={s}",
        E.STICKS, needs=HasSwitches),
    # orders for one drive move the other
    on_bus("two drives share an id", "drive-id 2 3", "drive-id {motor} {node} for={s}",
           E.MISDIRECTS),
    on_bus("frames are lost on the bus", "drop 0.1 for=1", "drop {share} for={s}", E.DISTURBS),
    on_bus("frames arrive twice on the bus", "duplicate 0.3 for=1", "duplicate 0.2 for={s}"),
    on_bus("frames overtake each other on the bus", "overtake 0.3 for=1", "overtake 0.2 for={s}",
           E.DISTURBS),
    on_bus("the adapter leaves the bus", "bus-off", "bus-off for={s}", E.CUTS_OFF),
    on_bus("no node acknowledges on the bus", "alone", "alone for={s}", E.DISTURBS),
    on_bus("a drive goes mute", "drive-mute 2", "drive-mute {motor} for={s}"),
    on_bus("a drive loses its supply", "drive-dead 2", "drive-dead {motor} for={s}", E.RESTARTS),
    on_bus("a drive restarts", "drive-reset 2", "drive-reset {motor}", E.RESTARTS),
    on_bus("a drive is switched to another mode", "drive-mode 2 2", "drive-mode {motor} 2 for={s}",
           E.DISTURBS),
    on_bus("a drive does not report done", "no-done 2", "no-done {motor} for={s}"),
)  # fmt: skip
