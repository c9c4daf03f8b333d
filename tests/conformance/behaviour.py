"""A row of the table of behaviours, and the rules that tell which arms a row applies to.

A rule returns why a row is not applicable to an arm, or an empty text. It looks at the abilities of
the dialect, the arm's model or the class of the simulated device, never at a name.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from armdrive.abilities import Switching
from armdrive.sim.device import HasSwitches, Resettable
from tests.scenarios.happenings import Happening

from .bench import Bench

Rule = Callable[[Bench], str]


EVERYWHERE = ("memory", "pty", "tcp", "port")
"""The transports of a row that names none."""
IN_SIMULATION = ("memory", "pty", "tcp")
"""The transports of a row that needs a simulated device."""
ALSO_UDP = (*EVERYWHERE, "udp")
"""The transports of a row in which datagrams, without pace or order, may make a difference."""


@dataclass(frozen=True, slots=True)
class Behaviour:
    """One behaviour of an arm, as a function that raises `Broken` if the arm behaves otherwise.

    `watched` rows are safe on a real arm if a person stands next to it with a hand on its power
    switch. The everyday tests run `smoke` rows over a pty as well. `fault` is what a row of the law
    of faults injects.
    """

    name: str
    family: str
    run: Callable[[Bench], None]
    needs: tuple[Rule, ...] = ()
    watched: bool = False
    smoke: bool = False
    transports: tuple[str, ...] = EVERYWHERE
    fault: Happening | None = None

    def runs_over(self, transport: str) -> bool:
        """Return whether this row runs over a transport."""
        return transport in self.transports

    def why_not_applicable(self, bench: Bench) -> str:
        """Return why this row is not applicable to the arm on a bench; empty if it is."""
        if not self.runs_over(bench.transport):
            return f"only over {' and '.join(self.transports)}"
        if bench.simulated or self.watched:
            return next((why for rule in self.needs if (why := rule(bench))), "")
        return "not on a real arm"


def row(name: str, family: str, **more: Any) -> Callable[[Callable[[Bench], None]], Behaviour]:
    """Make a row of the function below."""
    return lambda run: Behaviour(name, family, run, **more)


def rows_of(module: Mapping[str, object]) -> tuple[Behaviour, ...]:
    """Return the rows of a module, family by family."""
    here = str(module["__name__"])
    rows = [
        each
        for each in module.values()
        if isinstance(each, Behaviour) and each.run.__module__ == here
    ]
    families = list(dict.fromkeys(each.family for each in rows))
    return tuple(sorted(rows, key=lambda each: families.index(each.family)))


def cartesian(bench: Bench) -> str:
    """Require dimensions that are verified: Cartesian motion of other real arms is refused."""
    known = bench.config.model.verified or bench.trusts_geometry
    return "" if known else "the arm's dimensions are a template"


def finger_motor(bench: Bench) -> str:
    """Require fingers with a stepped motor."""
    return "" if bench.transmission.has_gripper else "no motor for the fingers"


def grip_switch(bench: Bench) -> str:
    """Require a grip switch."""
    return "" if bench.abilities.grip_switch else "no grip switch"


def switches_current(bench: Bench) -> str:
    """Require motors whose current the host can switch off."""
    if not bench.sees_current:
        return "the bench does not see the motors' current"
    able = bench.abilities.current is not Switching.NONE
    return "" if able else "its motors are always on"


def board_reset(bench: Bench) -> str:
    """Require a board that can be reset without losing its power."""
    return "" if _is(bench, Resettable) else "its board cannot be reset on its own"


def on_bus(bench: Bench) -> str:
    """Require drives on a CAN bus."""
    return "" if bench.row.can else "it is not on a CAN bus"


def bytes_on_wire(bench: Bench) -> str:
    """Require a wire on which a message has several bytes."""
    return "on a CAN bus a frame is lost as a whole" if bench.row.can else ""


def own_homing(bench: Bench) -> str:
    """Require a controller that homes by switches."""
    return "" if bench.abilities.own_homing else "its controller does not home by switches"


def servo(bench: Bench) -> str:
    """Require a controller that can drive a servo."""
    able = hasattr(bench.config.device, "servo")
    return _unseen(bench) if able else "no servo on its controller"


def no_servo(bench: Bench) -> str:
    """Require a controller that cannot drive a servo."""
    return "its controller can move a servo" if hasattr(bench.config.device, "servo") else ""


def valve(bench: Bench) -> str:
    """Require a controller with an output for a gripper's valve."""
    able = hasattr(bench.config.device, "gripper_output")
    return _unseen(bench) if able else "no output for a gripper"


def _unseen(bench: Bench) -> str:
    return "" if bench.sees_outputs else "the bench does not see what an output moves"


def limit_switches(bench: Bench) -> str:
    """Require limit switches, which can stick."""
    return "" if _is(bench, HasSwitches) else "no limit switches"


def _is(bench: Bench, ability: type) -> bool:
    board = bench.board
    return board is not None and issubclass(board, ability)
