"""A row of the campaign's table of faults, and the request that makes the simulator inject one."""

from collections.abc import Callable
from dataclasses import dataclass

from armdrive.errors import BadRequest
from armdrive.sim.device import Board
from armdrive.sim.faults import parse_words

from .stage import Stage

ARM_FAULTS = ("brown-out", "reset", "lose-steps", "stall", "switch", "drive-dead", "drive-reset")
"""Faults that leave the messages on the wire as they are."""
HOST, DEVICE = "--from host", "--from device"


@dataclass(frozen=True, slots=True)
class CampaignFault:
    """A fault that missions draw: `begin` injects it and returns what was injected, for the log."""

    name: str
    begin: Callable[[Stage], str]
    needs: type | None = None
    """The ability that a board needs to have this fault."""
    needs_program: bool = False
    """Whether the fault strikes a program: without one, nothing happens."""

    def applies_to(self, board: Board) -> bool:
        """Return whether a device with this board can have the fault."""
        return self.needs is None or isinstance(board, self.needs)


def inject(stage: Stage, words: str, *, misdirects: bool = False) -> str:
    """Inject a fault of the simulator's table, and return its words.

    `misdirects`: the device may now do something that the driver did not command.
    """
    if misdirects:
        stage.watch.misdirected = True
    if not words.startswith(ARM_FAULTS):  # the fault may swallow the evidence of a restart
        stage.watch.excuse_restart(stage.now_s)
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
