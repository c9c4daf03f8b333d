"""The templates from which an interview begins, each with its defaults."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

COUPLED, OWN_MOTOR, SERVO, OUTPUT, NOTHING = "coupled", "stepper", "servo", "output", "none"

# The kinds of grippers in the interview.
GRIPPERS: Mapping[str, str] = MappingProxyType(
    {
        COUPLED: "a stepper whose cable passes over another joint and follows its motor",
        OWN_MOTOR: "a stepper of its own",
        SERVO: "a servo on the controller",
        OUTPUT: "a digital output: a valve, a magnet",
        NOTHING: "no gripper",
    }
)
# The keys of a controller's section that are found by trying: written with their defaults.
GRIPPER_KEYS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        SERVO: ("servo", "servo_closed", "servo_open"),
        OUTPUT: ("gripper_output", "gripper_closes"),
    }
)
_CABLE_OR_OTHER = (COUPLED, SERVO, OUTPUT, NOTHING)


@dataclass(frozen=True, slots=True)
class Template:
    """One row. Its arm is a preset, a model file, or (with neither) the user's own links.

    `model` is the name of a model file in this package; `lengths` are the ones in it that the
    interview asks for, each with the path of its key in that file. `speeds_deg_s` and
    `counts_down` (the motors that count up as their joint goes down) are of its joints.
    `answers` are default answers, by the keys of the questions. `grippers` are the kinds to choose
    from, the usual one first. With `half_steps` the preset counts half-steps, while the controller
    may count microsteps.
    """

    key: str
    title: str
    dialect: str
    preset: str | None = None
    model: str = ""
    lengths: Mapping[str, tuple[str | int, ...]] = field(default_factory=dict)
    speeds_deg_s: Mapping[str, float] = field(default_factory=dict)
    counts_down: tuple[str, ...] = ()
    answers: Mapping[str, str] = field(default_factory=dict)
    grippers: tuple[str, ...] = (COUPLED,)
    half_steps: bool = False
    note: str = ""


_ROWS = (
    Template(
        "teachmover", "a Microbot TeachMover with its own controller", "teachmover",
        preset="teachmover",
    ),
    Template("robko01", "a Robko 01 with its open controller", "robko01", preset="robko01"),
    Template(
        "armdroid1", "an Armdroid 1 on its Arduino board", "armdroid", preset="armdroid1",
        note="Lengths and steps of this arm are not published: measure yours.",
    ),
    Template(
        "minimover5-grbl", "a Mini-mover 5 without its controller, its six motors on a GRBL board",
        "grbl", preset="minimover5", half_steps=True, grippers=_CABLE_OR_OTHER,
        note="All six motors count motor steps, so the cables' couplings are armdrive's.",
    ),
    Template(
        "minimover5-mks", "a Mini-mover 5 whose six motors are MKS drives on a CAN bus", "mks",
        preset="minimover5-mks",
        note="New drives all have the id 1 and move nothing: `armdrive can setup` gives each its "
        "id, finds which way it turns, and writes the same file.",
    ),
    Template(
        "minimover5-cia402", "a Mini-mover 5 whose six motors are CiA 402 drives (CANopen)",
        "cia402", preset="minimover5-cia402",
        note="Node numbers and the bit rate are set by the drives' own program or switches; "
        "`armdrive doctor --can` lists the nodes on the bus. A step is an increment of the drive: "
        "steps_per_turn is increments for a turn of the joint.",
    ),
    # The lengths are those that public programs give for the AR3 and AR4 (modified link table:
    # 169.77, 64.2, 305, 222.63, 36.25 mm). Every printed arm has its own, and the interview asks
    # for each. Homing is assumed to end at each motor's upper end, as GRBL does by default.
    Template(
        "printed-six", "a printed six-axis arm on a six-axis GRBL board", "grbl",
        model="printed-six.toml",
        lengths={
            "shoulder_height": ("links", 0, "d_mm"),
            "shoulder_offset": ("links", 1, "a_mm"),
            "upper_arm": ("links", 2, "a_mm"),
            "forearm": ("links", 3, "d_mm"),
            "flange": ("links", 5, "d_mm"),
            "tool": ("tool", "z_mm"),
        },
        speeds_deg_s={
            "base": 20.0, "shoulder": 15.0, "elbow": 15.0,
            "forearm_roll": 30.0, "wrist_pitch": 30.0, "wrist_roll": 40.0,
        },
        counts_down=("shoulder", "elbow"),
        answers={
            "gear.base": "10:1", "gear.shoulder": "50:1", "gear.elbow": "50:1",
            "gear.forearm_roll": "16:1", "gear.wrist_pitch": "10:1", "gear.wrist_roll": "20:1",
            "homing.own": "yes",
        },
        grippers=(SERVO, OUTPUT, NOTHING),
        note="A starting template: measure the lengths, gears, limits, speeds and homing of your "
        "arm, and enter them.",
    ),
    Template(
        "own", "any other arm of five or six turning joints, by its link table", "teachmover",
        grippers=(OWN_MOTOR, SERVO, OUTPUT, NOTHING),
    ),
)  # fmt: skip

# Every template by its key.
TEMPLATES: Mapping[str, Template] = MappingProxyType({each.key: each for each in _ROWS})
