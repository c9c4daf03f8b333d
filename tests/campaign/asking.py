"""A row of the campaign's table of faults, and how one is asked of the simulator."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from armdrive.errors import BadRequest
from armdrive.sim.device import Board
from armdrive.sim.faults.request import parse_words

from .stage import Stage

OF_THE_ARM = ("brown-out", "reset", "lose-steps", "stall", "switch", "drive-dead", "drive-reset")
HOST, DEVICE = "--from host", "--from device"


@dataclass(frozen=True, slots=True)
class Fault:
    """One row: `begin` makes it happen; `needs` is what a board must be able to do."""

    name: str
    begin: Callable[[Stage], str]
    needs: type | None = None
    of_programs: bool = False
    """Whether it befalls a program: where there is none, nothing happens."""

    def befalls(self, board: Board) -> bool:
        """Tell whether a device with this board can have it."""
        return self.needs is None or isinstance(board, self.needs)


def ask(stage: Stage, words: str, *, strays: bool = False) -> str:
    if strays:
        stage.watch.stray = True
    if not words.startswith(OF_THE_ARM):  # what a restart has to tell may be lost
        stage.watch.untold(stage.now_s)
    seed = stage.draw.randrange(1 << 30)
    stage.look()
    try:
        stage.twin.faults.ask(parse_words(f"{words} --seed {seed}".split()))
    except BadRequest as error:
        return f"{words}: {error}"
    return words


def motor(stage: Stage) -> int:
    """Draw a motor, counted from 1."""
    return stage.draw.randint(1, len(stage.world.motors))
