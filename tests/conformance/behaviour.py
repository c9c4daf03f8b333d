"""A row of the table of behaviours, and the rules that say which arm cannot have it.

A rule asks the abilities of the dialect, the arm's model or the class of the simulated device;
none asks for a name. It returns why the row is not applicable, or nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from armdrive.abilities import Switching
from armdrive.sim.device import HasSwitches, Resettable

from .bench import Bench

Rule = Callable[[Bench], str]

EVERYWHERE = ("memory", "pty", "tcp", "port")
"""The transports of a row that names none; others are only for the rows that name them."""
IN_SIMULATION = ("memory", "pty", "tcp")
"""The transports of a row that needs a simulated device."""


@dataclass(frozen=True, slots=True)
class Behaviour:
    """What an arm shall do, as a function that raises `Broken` where it does not.

    `watched` rows are safe on a real arm beside which a person stands with a hand on its switch.
    `smoke` rows are run over a pty every day.
    """

    name: str
    family: str
    run: Callable[[Bench], None]
    needs: tuple[Rule, ...] = ()
    watched: bool = False
    smoke: bool = False
    transports: tuple[str, ...] = EVERYWHERE

    def meant_for(self, transport: str) -> bool:
        """Tell whether this row is one for a transport at all."""
        return transport in self.transports

    def lacking(self, bench: Bench) -> str:
        """Return why this row is not applicable to the arm on a bench; empty where it is."""
        if not self.meant_for(bench.transport):
            return f"only over {' and '.join(self.transports)}"
        if bench.simulated or self.watched:
            return next((why for rule in self.needs if (why := rule(bench))), "")
        return "not on a real arm"


def cartesian(bench: Bench) -> str:
    """Cartesian goals are refused where nobody has verified the numbers of a real arm."""
    known = bench.config.model.verified or bench.knows_geometry
    return "" if known else "the arm's numbers are a template"


def finger_motor(bench: Bench) -> str:
    """Fingers that are moved step by step."""
    transmission = bench.config.model.transmission
    able = transmission is not None and transmission.has_gripper
    return "" if able else "no motor for the fingers"


def grip_switch(bench: Bench) -> str:
    """Fingers that feel."""
    return "" if bench.abilities.grip_switch else "no grip switch"


def switches_current(bench: Bench) -> str:
    """Motors that the host can let go."""
    if not bench.sees_current:
        return "the bench does not see the motors' current"
    able = bench.abilities.current is not Switching.NONE
    return "" if able else "its motors are always on"


def starts_disabled(bench: Bench) -> str:
    """Motors that are off until somebody switches them on."""
    able = bench.abilities.current is Switching.BOTH
    return "" if able else "its motors cannot be switched on by themselves"


def board_reset(bench: Bench) -> str:
    """A board that begins anew without losing its power."""
    return "" if _is(bench, Resettable) else "its board has no reset of its own"


def on_bus(bench: Bench) -> str:
    """Drives of their own on a CAN bus."""
    return "" if bench.row.can else "it is not on a CAN bus"


def own_homing(bench: Bench) -> str:
    """A controller that homes by switches."""
    return "" if bench.abilities.own_homing else "its controller does not home by switches"


def servo(bench: Bench) -> str:
    """A controller that can be told where a servo goes."""
    able = hasattr(bench.config.device, "servo")
    return _unseen(bench) if able else "no servo on its controller"


def no_servo(bench: Bench) -> str:
    """A controller whose motors are all that moves the arm."""
    return "its controller can move one" if hasattr(bench.config.device, "servo") else ""


def valve(bench: Bench) -> str:
    """A controller with an output that can be wired to a gripper."""
    able = hasattr(bench.config.device, "gripper_output")
    return _unseen(bench) if able else "no output for a gripper"


def _unseen(bench: Bench) -> str:
    return "" if bench.sees_outputs else "the bench does not see what an output moves"


def limit_switches(bench: Bench) -> str:
    """Limit switches that can stick."""
    return "" if _is(bench, HasSwitches) else "no limit switches"


def _is(bench: Bench, ability: type) -> bool:
    board = bench.board
    return board is not None and issubclass(board, ability)
