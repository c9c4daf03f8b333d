"""Writes the text of an arm file, and of its model file if it has one, from the answers.

Each answer goes to the place that its question names (setup/questions.py). This module adds what
follows from several answers: the model, and the motors with their steps and directions. For an arm
of the Mini-mover's build it writes only what differs from the preset, for a link table everything.
Comments say where a number comes from.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from armdrive.config.write import MEANINGS
from armdrive.setup.draft import GRIPPER_MOTOR, HALF_STEP, Draft, Ratio
from armdrive.setup.questions import ROWS
from armdrive.setup.templates import COUPLED
from armdrive.text.toml import FORMAT_ENTRY, TomlEntry, TomlSection, document
from armdrive.text.toml_amend import Change, amended
from kinematics.text import counted

MODELS = "models"
"""The folder of model files, in the folder of arm files."""


@dataclass(frozen=True, slots=True)
class ArmFiles:
    """The texts that an interview makes, and the path of the model file from the arm file."""

    arm: str
    model: str | None
    model_path: str

    @property
    def shown(self) -> str:
        """Both texts in one."""
        if self.model is None:
            return self.arm
        return f"{self.arm}\n# --- and {self.model_path}:\n\n{self.model}"


def files_of(draft: Draft) -> ArmFiles:
    """Return the texts of the files."""
    given = draft.answers.get("links.file")
    ending = ".toml" if given is None else Path(given.path).suffix.lower()
    path = f"{MODELS}/{draft.name}{ending}"
    return ArmFiles(document(_sections(draft, path), _heading(draft)), _model_text(draft), path)


def _heading(draft: Draft) -> str:
    lines = [
        f"{draft.name}: written by `armdrive config new` from the template {draft.template.key}."
    ]
    if draft.template.note:
        lines.append(draft.template.note)
    lines.append(f"`armdrive config show {draft.name} --toml` lists every key with its value.")
    return "\n".join(lines)


def _model_text(draft: Draft) -> str | None:
    """Return the text of the arm's model file; None for an arm with a preset."""
    if draft.preset is not None:
        return None
    title, links = str(draft.get("title", draft.name)), draft.links
    if links is None:
        rows = {joint: draft.answers[f"links.{joint}"] for joint in draft.joints}
        return typed_text(rows, draft.name, title)
    lengths = {
        path: draft.answers[f"lengths.{key}"] for key, path in draft.template.lengths.items()
    }
    if not lengths:
        return links.text
    measured = any(links.length_mm(path) != mm for path, mm in lengths.items())
    head = {"name": draft.name, "title": title, "verified": measured}
    changes = [Change((key,), each) for key, each in head.items()]
    changes += [Change(path, mm) for path, mm in lengths.items()]
    return amended(links.text, changes)


def typed_text(rows: Mapping[str, tuple[float, ...]], name: str, title: str) -> str:
    """Return the model file of rows that were typed: theta, d, a, alpha of each joint."""
    keys = ("offset_deg", "d_mm", "a_mm", "alpha_deg")
    top = TomlSection("", (FORMAT_ENTRY, TomlEntry("name", name), TomlEntry("title", title)))
    links = [
        TomlSection("links", (TomlEntry("joint", joint), *map(TomlEntry, keys, row)), array=True)
        for joint, row in rows.items()
    ]
    return document((top, *links), "A link table; docs/reference/arm-file.md explains the keys.")


ORDER = (
    "", "connection", "lengths", "steps_per_turn", "motor_signs", "joint_signs", "limits_deg",
    "speeds_deg_s", "gripper", "fingers", "homing", "homing.joints_deg", "reference", "park",
    "guards",
)  # fmt: skip
"""The order of the sections; the controller's own follows its connection."""


def _sections(draft: Draft, model_path: str) -> Iterator[TomlSection]:
    linked, dialect = draft.preset is None, draft.dialect.name
    model = (
        TomlEntry("model", model_path, "the link table")
        if linked
        else TomlEntry("model", draft.template.preset)
    )
    found = defaultdict(list, {"": [FORMAT_ENTRY, model]})
    found["connection"].append(TomlEntry("dialect", dialect))
    for row in ROWS:
        for name, entries in row.entries(draft):
            found[name] += entries
    if not draft.stepped:
        found["gripper"].append(TomlEntry("kind", draft.gripper))
    if linked:
        # a model file has limits of its own, but no speeds
        found["speeds_deg_s"] = found["speeds_deg_s"] or [
            TomlEntry(joint, draft.speed_deg_s(joint)) for joint in draft.joints
        ]
    else:
        found[""] += _gripper_steps(draft)
        found["steps_per_turn"] += _steps(draft)
        for name, key in (("motor_signs", "reversed.motors"), ("joint_signs", "reversed.joints")):
            found[name] += [TomlEntry(each, -1) for each in draft.get(key, ())]
    for name in ORDER:
        yield TomlSection(name, tuple(found[name]), MEANINGS.get(name, ""))
        if name == "connection":
            yield TomlSection(dialect, tuple(found[dialect]))
            if linked:
                yield from _array_of_motors(draft)


# The motors of an arm file: steps per turn, and the joints that each motor moves.


def _presets_own(draft: Draft) -> bool:
    """Return whether the steps of an arm of the Mini-mover's build are those of its preset."""
    return not draft.measured or (draft.published_motors and not draft.template.half_steps)


def _steps(draft: Draft) -> list[TomlEntry]:
    """Return the entries of [steps_per_turn]; none if they are the preset's own."""
    return [] if _presets_own(draft) else [_turning(draft, motor) for motor in draft.motors]


def _gripper_steps(draft: Draft) -> list[TomlEntry]:
    """Return the gripper's `steps_per_mm`; nothing if it is the preset's own."""
    if _presets_own(draft) or not draft.stepped:
        return []
    if draft.published_motors:
        published = draft.published_steps(GRIPPER_MOTOR)
        return [TomlEntry("steps_per_mm", _short(published), _microstepped(draft))]
    return [_pulling(draft)]


def _array_of_motors(draft: Draft) -> Iterator[TomlSection]:
    """Yield the [[motors]] of an arm with a link table, each with the joint that it moves."""
    reversed_motors = draft.get("reversed.motors", ())
    reversed_joints = draft.get("reversed.joints", ())
    for motor in draft.motors:
        turned = (motor in reversed_motors) != (motor in reversed_joints)
        sign = draft.direction(motor) * (-1 if turned else 1)
        entries = (
            TomlEntry("name", motor),
            replace(_turning(draft, motor), key="steps_per_turn"),
            TomlEntry(
                "sees", {motor: sign}, "-1: it counts up as the joint goes down" * (sign < 0)
            ),
        )
        yield TomlSection("motors", entries, array=True)
    if draft.stepped:
        yield _gripper_motor(draft, set(reversed_motors))


def _gripper_motor(draft: Draft, reversed_motors: set[str]) -> TomlSection:
    sign = -1 if GRIPPER_MOTOR in reversed_motors else 1
    entries = [
        TomlEntry("name", GRIPPER_MOTOR),
        _pulling(draft),
        TomlEntry("sees", {"opening": sign}),
    ]
    if draft.gripper == COUPLED:
        over = draft.answers["gripper.over"]
        ratio = sign * (-1 if over in reversed_motors else 1)
        entries.append(
            TomlEntry("follows", {over: ratio}, "steps added for each step of that motor")
        )
    return TomlSection("motors", tuple(entries), array=True)


def _turning(draft: Draft, motor: str) -> TomlEntry:
    if draft.published_motors:
        return TomlEntry(motor, _short(draft.published_steps(motor)), _microstepped(draft))
    gear: Ratio = draft.answers[f"gear.{motor}"]
    steps = draft.turn_steps * gear.turns
    return TomlEntry(motor, _short(steps), f"{draft.turn_words} x {gear.written} = {steps:.6g}")


def _microstepped(draft: Draft) -> str:
    return f"the published half-steps at {counted(draft.get('microsteps', HALF_STEP), 'microstep')}"


def _pulling(draft: Draft) -> TomlEntry:
    turn_mm = draft.answers["fingers.mm_per_turn"]
    words = f"{draft.turn_words} / {turn_mm:g} mm a turn"
    return TomlEntry("steps_per_mm", _short(draft.turn_steps / turn_mm), words)


def _short(steps: float) -> float:
    """Return the number with as many digits as an arm needs."""
    return float(f"{steps:.9g}")
