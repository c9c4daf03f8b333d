"""The answers of an interview so far, and the arm that they describe."""

from __future__ import annotations

import functools
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from importlib import resources
from pathlib import Path
from types import MappingProxyType
from typing import Any

from armdrive.config.link_model import parse_model, read_model
from armdrive.dialects import Dialect
from armdrive.dialog import WrongAnswer, plain_number
from armdrive.errors import ArmError, ArmFileError
from armdrive.registry import DIALECTS
from armdrive.setup.templates import COUPLED, NOTHING, OUTPUT, OWN_MOTOR, SERVO, TEMPLATES, Template
from armdrive.text.reading import read_text
from kinematics.chains.chain import Chain
from kinematics.presets import PRESETS, ArmPreset
from kinematics.text import counted

# From a motor to its joint: full steps, microsteps, and a gear or belt.

# No arm has a gear with a higher ratio.
HIGHEST_GEAR = 100_000.0


@dataclass(frozen=True, slots=True)
class Ratio:
    """Turns of the motor for one turn of its joint; `written` as the user typed them."""

    turns: float
    written: str

    def __str__(self) -> str:
        return self.written


def ratio(line: str) -> Ratio:
    """Read "20:1", teeth "60/16" (joint over motor), "60/16 * 3", or a plain number.

    Raises `WrongAnswer`.
    """
    turns = 1.0
    for part in line.replace("x", "*").replace(":", "/").split("*"):
        over, divided, under = part.partition("/")
        try:
            top, bottom = plain_number(over), plain_number(under) if divided else 1.0
        except WrongAnswer:
            top = bottom = 0.0
        if top <= 0.0 or bottom <= 0.0:
            raise WrongAnswer(f"write a ratio like 20:1 or 60/16, not {line!r}")
        turns *= top / bottom
    if not 1.0 / HIGHEST_GEAR <= turns <= HIGHEST_GEAR:
        raise WrongAnswer(f"no arm has a ratio of {turns:g}: write it like 20:1")
    return Ratio(turns, " ".join(line.split()))


CABLE_MOTORS = ("base", "shoulder", "elbow", "right wrist", "left wrist")
GRIPPER_MOTOR = "gripper"
HALF_STEP = 2
# The keys that show that drives count by an encoder, and the usual counts for a turn.
ENCODERS: Mapping[str, int] = MappingProxyType(
    {"in_position_counts": 16384, "position_window": 10_000}
)


@dataclass(frozen=True, slots=True)
class LinkFile:
    """A model file of a template or of the user: its text, and the chain that it describes."""

    path: str
    text: str
    chain: Chain

    def length_mm(self, path: Sequence[str | int]) -> float:
        """Return the length at the path of a key."""
        found: Any = _parsed(self.text)
        for step in path:
            found = found[step]
        return float(found)


@functools.lru_cache(maxsize=8)
def _parsed(text: str) -> Mapping[str, Any]:
    """Return a model file's content; every question looks up all of its lengths."""
    return tomllib.loads(text)


def read_links(path: str) -> LinkFile:
    """Read the model file at a path that was typed. Raises `WrongAnswer`."""
    place = Path(path).expanduser()
    try:
        text = read_text(place, "the model file", ArmFileError)
        return LinkFile(path, text, read_model(place).chain)
    except (ArmError, RuntimeError) as error:
        raise WrongAnswer(str(error)) from None


@functools.cache
def shipped_links(name: str) -> LinkFile:
    """Return a model file of this package."""
    text = resources.files("armdrive.setup").joinpath(name).read_text(encoding="utf-8")
    return LinkFile(name, text, parse_model(tomllib.loads(text)).chain)


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What an interview knows beforehand: the names of ports, and answers by their keys.

    `buses` are the CAN adapters, each as the port that opens it.
    """

    ports: tuple[str, ...] = ()
    given: Mapping[str, str] = field(default_factory=dict)
    buses: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Draft:
    """Answers by key, in the order of the questions."""

    answers: Mapping[str, Any]
    around: Surroundings

    def get(self, key: str, otherwise: Any = None) -> Any:
        """Return an answer, or `otherwise` if the question was not asked."""
        return self.answers.get(key, otherwise)

    @property
    def name(self) -> str:
        """The arm's name."""
        return str(self.answers["name"])

    @property
    def template(self) -> Template:
        """The template that was chosen."""
        return TEMPLATES[self.answers["template"]]

    @property
    def usual_answers(self) -> Mapping[str, str]:
        """The template's own default answers; none before it is chosen."""
        return self.template.answers if "template" in self.answers else {}

    @property
    def dialect(self) -> Dialect:
        """The dialect of the arm's controller."""
        return DIALECTS[self.get("dialect", self.template.dialect)]

    @property
    def preset(self) -> ArmPreset | None:
        """The preset; None for an arm with a link table."""
        return PRESETS[self.template.preset] if self.template.preset else None

    @property
    def measured(self) -> bool:
        """Whether the arm's numbers are reliable: published, or measured by its owner."""
        return self.preset is None or self.preset.verified or bool(self.get("measured"))

    @property
    def device_fields(self) -> dict[str, Any]:
        """The keys of the dialect's own section, with their defaults.

        A dialect whose section names its axes drives as many motors as are named there.
        """
        return {each.name: each.default for each in fields(self.dialect.settings())}

    @property
    def encoder_counts(self) -> int | None:
        """The usual counts for a turn; None if a motor step is no count of an encoder.

        A count is one whatever the microsteps.
        """
        known = self.device_fields
        return next((counts for key, counts in ENCODERS.items() if key in known), None)

    # -- joints ------------------------------------------------------------------------------

    @property
    def links(self) -> LinkFile | None:
        """The arm's model file; None for a preset, and until it is named."""
        if self.template.model:
            return shipped_links(self.template.model)
        found: LinkFile | None = self.get("links.file")
        return found

    @property
    def joints(self) -> tuple[str, ...]:
        """The joints from the table to the hand; empty until they are known."""
        if self.preset is not None:
            return self.preset.arm.joint_names
        return () if self.links is None else self.links.chain.joint_names

    def limits_deg(self, joint: str) -> tuple[float, float] | None:
        """Return a joint's range if it is known without asking."""
        index, links = self.joints.index(joint), self.links
        if self.preset is not None:
            known = self.preset.arm.limits[index]
            return math.degrees(known.low_rad), math.degrees(known.high_rad)
        if links is None:
            return None
        low, high = links.chain.links[index].low, links.chain.links[index].high
        return (math.degrees(low), math.degrees(high)) if math.isfinite(high - low) else None

    def speed_deg_s(self, joint: str) -> float | None:
        """Return a joint's speed if it is known without asking."""
        if self.preset is None:
            return self.template.speeds_deg_s.get(joint)
        return math.degrees(self.preset.joint_speeds_rad_s[self.joints.index(joint)])

    def direction(self, motor: str) -> int:
        """Return 1 or -1: which way a motor of a link table counts according to its template."""
        return -1 if motor in self.template.counts_down else 1

    # -- motors ------------------------------------------------------------------------------

    @property
    def motors(self) -> tuple[str, ...]:
        """The motors that turn joints, in the controller's order."""
        if self.preset is None:
            return self.joints
        known = self.preset.transmission
        return CABLE_MOTORS if known is None else tuple(motor.name for motor in known.motors[:-1])

    @property
    def all_motors(self) -> tuple[str, ...]:
        """The motors with the gripper's, if it has one."""
        return (*self.motors, GRIPPER_MOTOR) if self.stepped else self.motors

    @property
    def gripper(self) -> str:
        """The kind of the gripper."""
        return str(self.get("gripper.kind", self.grippers[0] if self.grippers else NOTHING))

    @property
    def grippers(self) -> tuple[str, ...]:
        """The kinds of grippers that this controller can move in addition to the arm's joints."""
        known = self.device_fields
        spare = self.dialect.abilities.motors - len(self.motors)
        fits = {
            COUPLED: spare > 0,
            OWN_MOTOR: spare > 0,
            SERVO: "servo" in known,
            OUTPUT: "gripper_output" in known,
            # a board that names its axes leaves the rest unused; any other drives all that it has
            NOTHING: spare == 0 or "axes" in known,
        }
        return tuple(kind for kind in self.template.grippers if fits[kind])

    @property
    def stepped(self) -> bool:
        """Whether a motor of the arm's own drives the gripper."""
        return self.gripper in (COUPLED, OWN_MOTOR)

    @property
    def published_motors(self) -> bool:
        """Whether the motors are the preset's own."""
        return str(self.get("motors", "own")) == "published"

    @property
    def turn_steps(self) -> int:
        """The steps that the controller counts for one turn of a motor's shaft."""
        return int(self.answers["full_steps"] * self.get("microsteps", 1))

    @property
    def turn_words(self) -> str:
        """The same as a calculation."""
        full_steps, microsteps = self.answers["full_steps"], self.get("microsteps", 1)
        if microsteps == 1:
            return f"{full_steps} counts a turn"
        return f"{full_steps} full steps x {counted(microsteps, 'microstep')}"

    def published_steps(self, motor: str) -> float:
        """Return a motor's published steps for a turn (gripper: a mm), as the controller counts."""
        assert self.preset is not None  # noqa: S101 - asked of presets alone
        assert self.preset.transmission is not None  # noqa: S101
        motors = {each.name: each for each in self.preset.transmission.motors}
        per_unit = abs(motors[motor].steps_per_unit)
        scale = self.get("microsteps", HALF_STEP) / HALF_STEP if self.template.half_steps else 1.0
        return scale * per_unit * (1.0 if motor == GRIPPER_MOTOR else math.tau)


# Answers from a file: a TOML table, flattened to the keys of the questions.


def flattened(table: Mapping[str, Any], before: str = "") -> dict[str, str]:
    """Return every answer as text by its key: `[gear] base = "20:1"` becomes gear.base."""
    found: dict[str, str] = {}
    for key, value in table.items():
        if isinstance(value, Mapping):
            found |= flattened(value, f"{before}{key}.")
        else:
            several = value if isinstance(value, list) else [value]
            found[before + key] = ", ".join(map(str, several))
    return found
