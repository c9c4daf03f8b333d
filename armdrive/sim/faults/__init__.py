"""What a fault is: its request in words, what it can affect, and its row in the `table`."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

from armdrive.errors import BadRequest
from armdrive.sim.device import Board, SimDevice
from armdrive.sim.wire import DeviceLine
from armdrive.text.numbers import number, whole

# --- A requested fault, from a command line, the console or a program ----------------------------
# On a command line: `NAME[:ARGUMENT,..][@SECONDS]`; at the console, the same words with spaces.
# Named arguments are written `from=host` or `--from host`.

SIDES = ("host", "device", "both")
_NAMED = ("from", "seed", "for")


@dataclass(frozen=True, slots=True)
class FaultRequest:
    """A requested fault: `side` is the sender affected; times are in seconds from now.

    `for_s` is its duration, None for until it is ended. Raises `BadRequest`.
    """

    name: str
    words: tuple[str, ...] = ()
    side: str = "both"
    seed: int = 0
    after_s: float = 0.0
    for_s: float | None = None
    text: str = field(default="", compare=False)

    def __post_init__(self) -> None:
        if self.side not in SIDES:
            raise BadRequest(f"bytes come from {', '.join(SIDES)}, not from {self.side!r}")
        for seconds in (self.after_s, self.for_s or 0.0):
            if not (math.isfinite(seconds) and seconds >= 0.0):
                raise BadRequest(f"a time must be 0 or more seconds, not {seconds}")
        if not self.text:
            object.__setattr__(self, "text", " ".join((self.name, *self.words)))


def parse_option(text: str) -> FaultRequest:
    """Parse the value of `--fault`."""
    head, at, seconds = text.rpartition("@")
    if not at:
        head = text
    name, _, arguments = head.partition(":")
    words = [word for word in arguments.split(",") if word]
    return parse_words([name, *words, *([f"@{seconds}"] if at else [])])


def parse_words(words: Sequence[str]) -> FaultRequest:
    """Parse the words of a console command."""
    after_s, named, plain = 0.0, {}, []
    rest = list(words)
    while rest:
        word = rest.pop(0)
        name, equals, value = word.removeprefix("--").partition("=")
        if word.startswith("@"):
            after_s = number(word[1:])
        elif name in _NAMED and (equals or word.startswith("--")):
            if not equals and not rest:
                raise BadRequest(f"{word} needs a value")
            named[name] = value if equals else rest.pop(0)
        elif word.startswith("--"):
            raise BadRequest(f"there is no {word}; there are --{', --'.join(_NAMED)} and @SECONDS")
        else:
            plain.append(word)
    if not plain:
        raise BadRequest("name a fault")
    return FaultRequest(
        plain[0].lower(),
        tuple(plain[1:]),
        side=named.get("from", "both"),
        seed=whole(named.get("seed", "0")),
        after_s=after_s,
        for_s=number(named["for"]) if "for" in named else None,
        text=" ".join(words),
    )


class Cable:
    """The cable between a device and the program that opens its wire; it can be pulled at any time.

    `withdraw` disconnects the program that has opened the wire. `offer` reconnects it, possibly
    under another name, and may raise `PortUnavailable`.
    """

    def __init__(
        self,
        line: DeviceLine,
        withdraw: Callable[[], None],
        offer: Callable[[str | None], None],
    ) -> None:
        self._line = line
        self._withdraw = withdraw
        self._offer = offer

    def unplug(self) -> None:
        """Pull the cable; bytes under way are lost."""
        self._withdraw()
        self._line.unplug()

    def replug(self, name: str | None = None) -> None:
        """Plug the cable in again, possibly under another name."""
        self._offer(name)
        self._line.plug()


@dataclass(frozen=True, slots=True)
class FaultBench:
    """Everything that a fault can affect."""

    device: SimDevice
    line: DeviceLine
    cable: Cable


Fault: TypeAlias = Generator[Callable[[], bool] | None, None, None]
"""A fault: it checks its words and yields, begins when it is resumed, and yields again if it lasts.

Resuming it once more ends it. The second yield may give a function that tells whether the fault
still has an effect; None means until it is ended.
"""


@dataclass(frozen=True, slots=True)
class FaultKind:
    """One row; `needs` is the ability required of the board, `lasts_s` the usual duration.

    A fault that `replaces` ends an earlier one of its kind on the same motor, so that its own end
    restores the state before both.
    """

    name: str
    arguments: str
    summary: str
    run: Callable[[FaultBench, FaultRequest], Fault]
    needs: type | None = None
    lasts_s: float | None = None
    replaces: bool = False

    @property
    def usage(self) -> str:
        """How the fault is written."""
        return f"{self.name} {self.arguments}".strip()

    def befalls(self, board: type[Board]) -> bool:
        """Return whether a device with this kind of board can have the fault."""
        return self.needs is None or issubclass(board, self.needs)


def check_count(usage: str, words: Sequence[str]) -> None:
    """Raise `BadRequest` if a command or fault has too many or too few words.

    The usage text decides: words in brackets are optional, and "..." stands for any number.
    """
    arguments = usage.split()[1:]
    optional = [at for at, word in enumerate(arguments) if word.startswith("[")]
    least = min([*optional, len(arguments)])
    if usage.endswith("..."):
        least = 1
    if not least <= len(words) <= len(arguments):
        raise BadRequest(f"write it like this: {usage}")
