"""The templates from which an interview begins, each with its defaults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.registry import DIALECTS
from armdrive.text.toml_document import FORMAT_ENTRY, TomlEntry, TomlSection, document

# Link tables of templates: joints by name, lengths that the interview asks for, and as a file.


@dataclass(frozen=True, slots=True)
class Length:
    """A length of a template in mm, and what it is measured from and to."""

    key: str
    mm: float
    words: str


@dataclass(frozen=True, slots=True)
class Joint:
    """One row, limits in degrees and speed in degrees a second; `d` and `a` name lengths.

    `sees` is 1, or -1 if the motor counts up as the joint goes down. Homing is assumed to end at
    the motor's upper end, as GRBL does by default.
    """

    name: str
    limits_deg: tuple[float, float]
    speed_deg_s: float
    ratio: str
    d: str = ""
    a: str = ""
    alpha_deg: float = 0.0
    offset_deg: float = 0.0
    sees: int = 1


@dataclass(frozen=True, slots=True)
class LinkTable:
    """A template's arm: its joints from the table to the hand, and the length of its tool."""

    convention: str
    source: str
    lengths: tuple[Length, ...]
    joints: tuple[Joint, ...]
    tool: str


def model_text(table: LinkTable, lengths_mm: Mapping[str, float], name: str, title: str) -> str:
    """Return the model file of a template with these lengths.

    It says `verified = false` if they are the template's own.
    """
    measured = any(lengths_mm[length.key] != length.mm for length in table.lengths)
    top = TomlSection(
        "",
        (
            FORMAT_ENTRY,
            TomlEntry("name", name),
            TomlEntry("title", title),
            TomlEntry("source", table.source),
            TomlEntry(
                "verified", measured, "true once you have measured your arm: allows Cartesian"
            ),
            TomlEntry("convention", table.convention),
        ),
    )
    tool = TomlSection(
        "tool", (TomlEntry("z_mm", lengths_mm[table.tool], _words(table, table.tool)),)
    )
    links = [_link(table, joint, lengths_mm) for joint in table.joints]
    return document(
        (top, tool, *links), "A link table; docs/reference/arm-file.md explains the keys."
    )


def typed_text(rows: Mapping[str, tuple[float, ...]], name: str, title: str) -> str:
    """Return the model file of rows that were typed: theta, d, a, alpha of each joint."""
    keys = ("offset_deg", "d_mm", "a_mm", "alpha_deg")
    top = TomlSection("", (FORMAT_ENTRY, TomlEntry("name", name), TomlEntry("title", title)))
    links = [
        TomlSection("links", (TomlEntry("joint", joint), *map(TomlEntry, keys, row)), array=True)
        for joint, row in rows.items()
    ]
    return document((top, *links), "A link table; docs/reference/arm-file.md explains the keys.")


def _link(table: LinkTable, joint: Joint, lengths_mm: Mapping[str, float]) -> TomlSection:
    entries = [TomlEntry("joint", joint.name)]
    for key, length in (("d_mm", joint.d), ("a_mm", joint.a)):
        if length:
            entries.append(TomlEntry(key, lengths_mm[length], _words(table, length)))
    entries += [
        TomlEntry(key, degrees)
        for key, degrees in (("alpha_deg", joint.alpha_deg), ("offset_deg", joint.offset_deg))
        if degrees
    ]
    return TomlSection("links", tuple(entries), array=True)


def _words(table: LinkTable, key: str) -> str:
    return next(length.words for length in table.lengths if length.key == key)


# The link table of a printed six-axis arm, as the common printed arms with NEMA motors have it.
#
# The numbers are those that public programs give for the AR3 and AR4 (modified link table: 169.77,
# 64.2, 305, 222.63, 36.25 mm). Every printed arm has its own, and the interview asks for each.

PRINTED_SIX = LinkTable(
    convention="craig",
    source="template: the link table that public programs give for the AR3 and AR4; not yours",
    lengths=(
        Length("shoulder_height", 169.77, "from the table up to the shoulder's axis"),
        Length("shoulder_offset", 64.2, "from the base axis forward to the shoulder's axis"),
        Length("upper_arm", 305.0, "from the shoulder's axis to the elbow's axis"),
        Length("forearm", 222.63, "from the elbow's axis to the axis of the wrist's pitch"),
        Length("flange", 36.25, "from the axis of the wrist's pitch to the flange"),
        Length("tool", 70.0, "from the flange to the tips of the fingers"),
    ),
    joints=(
        Joint("base", (-170.0, 170.0), 20.0, "10:1", d="shoulder_height"),
        Joint(
            "shoulder", (-42.0, 90.0), 15.0, "50:1", a="shoulder_offset", alpha_deg=-90.0,
            offset_deg=-90.0, sees=-1,
        ),
        Joint("elbow", (-89.0, 52.0), 15.0, "50:1", a="upper_arm", sees=-1),
        Joint("forearm_roll", (-165.0, 165.0), 30.0, "16:1", d="forearm", alpha_deg=-90.0),
        Joint("wrist_pitch", (-105.0, 105.0), 30.0, "10:1", alpha_deg=90.0),
        Joint("wrist_roll", (-155.0, 155.0), 40.0, "20:1", d="flange", alpha_deg=-90.0),
    ),
    tool="tool",
)  # fmt: skip

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
"""The kinds of grippers in the interview."""


@dataclass(frozen=True, slots=True)
class Template:
    """One row. Its arm is a preset, a link table, or (with neither) the reader's own links.

    `grippers` are the kinds to choose from, the usual one first. With `half_steps` the preset
    counts half-steps, while the controller may count microsteps. With `homes` such arms usually
    have switches.
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
                note="A starting template: measure the lengths, gears, limits and homing of your "
                "arm, and enter them.",
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
