"""The table of templates: what an interview begins from, each with the defaults that it offers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.dialects import DIALECTS
from armdrive.interview.link_tables import LinkTable
from armdrive.interview.printed_six import PRINTED_SIX

COUPLED, OWN_MOTOR, SERVO, OUTPUT, NOTHING = "coupled", "stepper", "servo", "output", "none"

GRIPPERS: Mapping[str, str] = MappingProxyType(
    {
        COUPLED: "a stepper whose cable passes over another joint and follows its motor",
        OWN_MOTOR: "a stepper of its own",
        SERVO: "a servo on the controller",
        OUTPUT: "a digital output: a valve, a magnet",
        NOTHING: "no gripper",
    }
)
"""Kinds of grippers, as the interview calls them."""


@dataclass(frozen=True, slots=True)
class Template:
    """One row. Its arm is a preset, a link table, or (with neither) the reader's own links.

    `grippers` are the kinds to choose from, the usual one first. `half_steps` tells that the
    preset counts half-steps while the controller may count microsteps. `homes` tells that such
    arms usually have switches.
    """

    key: str
    title: str
    dialect: str
    preset: str | None = None
    links: LinkTable | None = None
    grippers: tuple[str, ...] = (COUPLED,)
    half_steps: bool = False
    homes: bool = False
    note: str = ""


_ANY_GRIPPER = tuple(GRIPPERS)
_CABLE_OR_OTHER = (COUPLED, SERVO, OUTPUT, NOTHING)

TEMPLATES: Mapping[str, Template] = MappingProxyType(
    {
        each.key: each
        for each in (
            Template(
                "teachmover", "a Microbot TeachMover with its own controller", "teachmover",
                preset="teachmover",
            ),
            Template(
                "robko01", "a Robko 01 with its open controller", "robko01", preset="robko01"
            ),
            Template(
                "armdroid1", "an Armdroid 1 on its Arduino board", "armdroid", preset="armdroid1",
                note="Lengths and steps of this arm are not published: measure yours.",
            ),
            Template(
                "minimover5-grbl",
                "a Mini-mover 5 without its controller, its six motors on a GRBL board", "grbl",
                preset="minimover5", half_steps=True, grippers=_CABLE_OR_OTHER,
                note="All six motors count motor steps, so the cables' couplings are armdrive's.",
            ),
            Template(
                "minimover5-mks",
                "a Mini-mover 5 whose six motors are MKS drives on a CAN bus", "mks",
                preset="minimover5-mks",
                note="New drives all have the id 1 and move nothing: `armdrive can setup` gives "
                "each its id, finds which way it turns, and writes the same file.",
            ),
            Template(
                "minimover5-cia402",
                "a Mini-mover 5 whose six motors are CiA 402 drives (CANopen)", "cia402",
                preset="minimover5-cia402",
                note="Node numbers and the bit rate are set by the drives' own program or "
                "switches; `armdrive doctor --can` shows who is there. A step is an increment of "
                "the drive: steps_per_turn is increments for a turn of the joint.",
            ),
            Template(
                "printed-six", "a printed six-axis arm on a six-axis GRBL board", "grbl",
                links=PRINTED_SIX, grippers=(SERVO, OUTPUT, NOTHING), homes=True,
                note="A starting template: lengths, gears, limits and homing are not your arm's "
                "until you have measured and entered them.",
            ),
            Template(
                "own", "any other arm of five or six turning joints, by its link table",
                "teachmover", grippers=_ANY_GRIPPER,
            ),
        )
    }
)  # fmt: skip
"""Every template by its key."""


def available() -> dict[str, Template]:
    """Return the templates whose dialect this armdrive speaks."""
    return {key: each for key, each in TEMPLATES.items() if each.dialect in DIALECTS}
