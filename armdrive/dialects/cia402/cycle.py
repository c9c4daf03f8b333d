"""One turn with CiA 402 drives: each is told what to be and where, SYNC, each tells what it is.

A drive shows what became of an order at the SYNC behind the one that it acted on.
"""

from __future__ import annotations

from collections.abc import Collection, Generator, Iterable
from typing import TypeAlias

from armdrive.abilities import Abilities
from armdrive.dialects.cia402.drive import Cia402Drive
from armdrive.dialects.cia402.master import Heard
from armdrive.dialects.cia402.sdo_queue import TRIES, Cia402Objects
from armdrive.dialects.cia402.settings import Cia402Settings
from armdrive.tasks import Progress, Reply
from firmware_protocol.canopen import Command, Controlword, OperationMode

MUTE_TURNS = 20
"""A drive that tells nothing in so many turns is mute, where another one tells something."""
ALL_MUTE_TURNS = 20
"""So many are given to drives that all are silent: then it is the computer that is late, mostly."""
ENABLE = Controlword.of(Command.ENABLE_OPERATION)
STOP = Controlword.of(Command.QUICK_STOP)

Script: TypeAlias = Generator[float, Heard | None, Reply]
Turning: TypeAlias = Generator[float, Heard | None, None]


class Cia402Cycle(Cia402Objects):
    """Turns, and looks."""

    def __init__(
        self,
        abilities: Abilities,
        settings: Cia402Settings,
        names: Iterable[str],
        cycle_s: float,
    ) -> None:
        super().__init__(abilities, settings, names)
        self.cycle_s = cycle_s
        """How long a turn lasts: the period of SYNC."""

    def command(
        self, drive: Cia402Drive, word: Controlword, mode: OperationMode, target: int | None = None
    ) -> None:
        """Tell a drive what to be, and where: as a rule where it was seen."""
        target = drive.seen if target is None else target
        self.say(self.bus.command(drive.node, word, mode, target))

    def turn(self) -> Turning:
        """Have the drives do what they were told; wait for the end of the turn."""
        self.sync()
        yield from self.wait(self.now_s + self.cycle_s)

    def timed(self, turn: Turning) -> Generator[float, Heard | None, float]:
        """Make a turn; return how much longer it took than it should, and 0 for one cut short.

        This program was late by that. A deadline of a drive is put off by it: the drive was told
        nothing meanwhile, and what it has told since is unread.
        """
        began_s = self.now_s
        yield from turn
        return max(self.now_s - began_s - self.cycle_s, 0.0)

    def look(self) -> Generator[float, Heard | None, tuple[Cia402Drive, ...]]:
        """Have every drive tell where it is; return those that do not."""
        missing: tuple[Cia402Drive, ...] = self.drives
        for left in range(TRIES, 0, -1):
            asked_s = self.now_s
            self.sync()
            until_s = asked_s + self.settings.answer_s * (2.0 if left == 1 else 1.0)
            yield from self.wait(until_s, lambda since_s=asked_s: not self._untold(since_s))  # type: ignore[misc]
            missing = self._untold(asked_s)
            if not missing:
                break
        return missing

    def _untold(self, since_s: float) -> tuple[Cia402Drive, ...]:
        return tuple(drive for drive in self.drives if drive.told_s < since_s)

    def mute(self, drives: Collection[Cia402Drive]) -> tuple[Cia402Drive, ...]:
        """Return those of some drives that have told nothing for too long."""
        others = min(drive.missed for drive in self.drives)
        most = MUTE_TURNS if others <= 1 else ALL_MUTE_TURNS
        return tuple(drive for drive in drives if drive.missed > most)

    def progress(self) -> None:
        """Tell where the drives are."""
        self.tell(Progress(self.registers()))
