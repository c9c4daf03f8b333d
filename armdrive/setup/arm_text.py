"""From the answers to an arm file's text, and to that of its model file where it has one.

Only what differs from the preset is written for an arm of the Mini-mover's build; an arm of a
link table has everything written out. Comments say where a number comes from.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.config.preset import LENGTHS
from armdrive.setup.directions import SeenMotion, Signs, conclude
from armdrive.setup.draft import GRIPPER_MOTOR, HALF_STEP, Draft
from armdrive.setup.plan import MM, CommissioningPlan, Notes
from armdrive.setup.templates import COUPLED, model_text, typed_text
from armdrive.text.toml import FORMAT, FORMAT_KEY
from armdrive.text.toml_document import FORMAT_ENTRY, TomlEntry, TomlSection, document

# The motors of an arm file: steps per turn as a sum, and which joints a motor sees which way.


def steps_section(draft: Draft) -> TomlSection:
    """Return [steps_per_turn] of a Mini-mover's build, empty where it is the preset's."""
    if not draft.measured or (draft.published_motors and not draft.template.half_steps):
        return TomlSection("steps_per_turn", ())
    return TomlSection("steps_per_turn", tuple(_turning(draft, motor) for motor in draft.motors))


def gripper_entry(draft: Draft) -> list[TomlEntry]:
    """Return `steps_per_mm` of the gripper's motor, nothing where it is the preset's."""
    if draft.published_motors:
        if not draft.template.half_steps:
            return []
        published = draft.published_steps(GRIPPER_MOTOR)
        return [TomlEntry("steps_per_mm", _short(published), _microstepped(draft))]
    return [TomlEntry("steps_per_mm", _short(draft.gripper_steps_per_mm), _pulled(draft))]


def array_of_motors(draft: Draft) -> Iterator[TomlSection]:
    """Give [[motors]] of an arm of a link table, each with the joint that it sees."""
    reversed_motors = draft.get("reversed.motors", ())
    reversed_joints = draft.get("reversed.joints", ())
    for motor in draft.motors:
        turned = (motor in reversed_motors) != (motor in reversed_joints)
        sign = draft.direction(motor) * (-1 if turned else 1)
        entries = (
            TomlEntry("name", motor),
            _named(_turning(draft, motor), "steps_per_turn"),
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
        TomlEntry("steps_per_mm", _short(draft.gripper_steps_per_mm), _pulled(draft)),
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
    gearing = draft.gearing(motor)
    return TomlEntry(motor, _short(gearing.steps_per_turn), str(gearing))


def _named(entry: TomlEntry, key: str) -> TomlEntry:
    return TomlEntry(key, entry.value, entry.comment)


def _microstepped(draft: Draft) -> str:
    return f"the published half-steps at {draft.get('microsteps', HALF_STEP)} microsteps"


def _pulled(draft: Draft) -> str:
    answers = draft.answers
    return (
        f"{answers['full_steps']} full steps x {answers.get('microsteps', 1)} microsteps "
        f"/ {answers['fingers.mm_per_turn']:g} mm a turn"
    )


def _short(steps: float) -> float:
    """Return the number without digits that no arm has."""
    return float(f"{steps:.9g}")


MODELS = "models"
"""The folder of model files, beside the arm files."""

POSTURE_KEYS = ("x_mm", "y_mm", "z_mm", "pitch_deg", "roll_deg", "yaw_deg")


@dataclass(frozen=True, slots=True)
class ArmFiles:
    """What an interview comes to: texts, and the path of the model file from the arm file."""

    arm: str
    model: str | None
    model_path: str

    @property
    def shown(self) -> str:
        """Both texts, as one shows them to a person."""
        if self.model is None:
            return self.arm
        return f"{self.arm}\n# --- and {self.model_path}:\n\n{self.model}"


def files_of(draft: Draft) -> ArmFiles:
    """Return the texts of the files."""
    path = f"{MODELS}/{draft.name}.toml"
    return ArmFiles(document(_sections(draft, path), _heading(draft)), _links(draft), path)


def _heading(draft: Draft) -> str:
    lines = [
        f"{draft.name}: written by `armdrive config new` from the template {draft.template.key}."
    ]
    if draft.template.note:
        lines.append(draft.template.note)
    lines.append(f"`armdrive config show {draft.name} --toml` lists every key with its value.")
    return "\n".join(lines)


def _links(draft: Draft) -> str | None:
    if draft.preset is not None:
        return None
    title = str(draft.get("title", draft.name))
    table = draft.template.links
    if table is not None:
        lengths = {each.key: draft.answers[f"lengths.{each.key}"] for each in table.lengths}
        return model_text(table, lengths, draft.name, title)
    if "links.file" in draft.answers:
        return str(draft.answers["links.file"].text)
    rows = {joint: draft.answers[f"links.{joint}"] for joint in draft.joints}
    return typed_text(rows, draft.name, title)


def _sections(draft: Draft, model_path: str) -> Iterator[TomlSection]:
    yield _top(draft, model_path)
    yield _connection(draft)
    yield _device(draft)
    yield from _arm(draft)
    yield from _use(draft)


def _top(draft: Draft, model_path: str) -> TomlSection:
    preset = draft.template.preset
    entries = [
        FORMAT_ENTRY,
        TomlEntry(
            "model", preset or model_path, "" if preset else "the link table, beside this file"
        ),
        TomlEntry("title", draft.get("title", draft.name)),
    ]
    if draft.preset is not None and draft.measured and draft.stepped:
        entries += gripper_entry(draft)
    return TomlSection("", tuple(entries))


def _connection(draft: Draft) -> TomlSection:
    port = draft.get("connection.port", "")
    entries = [
        TomlEntry("dialect", draft.dialect.name),
        TomlEntry("port", port, "" if port else "none yet: the arm is only simulated"),
    ]
    if (baud := draft.get("connection.baud")) is not None:
        entries.append(TomlEntry("baud", baud))
    if draft.get("connection.keep_dtr"):
        entries += [
            TomlEntry("raise_dtr", True, "the board resets when DTR rises ..."),
            TomlEntry("keep_dtr_on_close", True, "... so it stays up between programs"),
        ]
    return TomlSection("connection", tuple(entries))


def _device(draft: Draft) -> TomlSection:
    """Return the dialect's own section: what was asked of it, and whether it homes."""
    known = draft.device_fields
    asked = [(key, draft.get(f"device.{key}")) for key in known]
    entries = [TomlEntry(key, value) for key, value in asked if value is not None]
    if draft.get("homing.own") and "homing" in known:
        entries.append(TomlEntry("homing", True, "the board's own setting is checked against this"))
    return TomlSection(draft.dialect.name, tuple(entries))


def _arm(draft: Draft) -> Iterator[TomlSection]:
    if draft.preset is None:
        yield from array_of_motors(draft)
    else:
        lengths = [TomlEntry(k, draft.get(f"lengths.{k}")) for k in LENGTHS]
        yield TomlSection("lengths", tuple(entry for entry in lengths if entry.value is not None))
        yield steps_section(draft)
        yield from _signs(draft)
    every = draft.preset is None
    yield TomlSection("limits_deg", tuple(_per_joint(draft, "limits", every)))
    yield TomlSection("speeds_deg_s", tuple(_per_joint(draft, "speeds", every)))


def _per_joint(draft: Draft, what: str, every: bool) -> Iterator[TomlEntry]:
    known = {"limits": draft.limits_deg, "speeds": draft.speed_deg_s}[what]
    for joint in draft.joints:
        answered = draft.get(f"{what}.{joint}")
        if answered is not None:
            yield TomlEntry(joint, answered)
        elif every:
            yield TomlEntry(joint, known(joint))


def _signs(draft: Draft) -> Iterator[TomlSection]:
    for section, key in (("motor_signs", "reversed.motors"), ("joint_signs", "reversed.joints")):
        comment = "-1 counts the other way than the preset"
        yield TomlSection(
            section, tuple(TomlEntry(name, -1) for name in draft.get(key, ())), comment
        )


def _use(draft: Draft) -> Iterator[TomlSection]:
    if not draft.stepped:
        yield TomlSection("gripper", (TomlEntry("kind", draft.gripper),))
    if draft.preset is None and "fingers.range" in draft.answers:
        entries = (
            TomlEntry("range_mm", draft.answers["fingers.range"]),
            TomlEntry("speed_mm_s", draft.answers["fingers.speed"]),
        )
        yield TomlSection("fingers", entries)
    if draft.get("homing.own"):
        yield from _homing(draft)
    for key in ("reference", "park"):
        yield _posture(key, draft.get(key, ()))
    yield _guards(draft)


def _homing(draft: Draft) -> Iterator[TomlSection]:
    entries = []
    if draft.stepped:
        entries.append(TomlEntry("opening_mm", draft.get("homing.opening", 0.0)))
    if draft.get("homing.groups"):
        order = "motors by number, in the order in which they home"
        entries.append(TomlEntry("groups", draft.answers["homing.groups"], order))
    yield TomlSection("homing", tuple(entries))
    joints = tuple(
        TomlEntry(joint, draft.answers[f"homing.joints.{joint}"]) for joint in draft.joints
    )
    yield TomlSection("homing.joints_deg", joints, "where every joint stands after homing")


def _posture(name: str, numbers: Sequence[float]) -> TomlSection:
    return TomlSection(name, tuple(map(TomlEntry, POSTURE_KEYS, numbers)))


def _guards(draft: Draft) -> TomlSection:
    tolerance_mm = draft.get("guards.tolerance_mm")
    usual = draft.preset.guards.tolerance_mm if draft.preset else None
    if tolerance_mm is None or tolerance_mm == usual:
        return TomlSection("guards", ())
    comment = "how far below the table rounding may put a point"
    return TomlSection("guards", (TomlEntry("tolerance_mm", tolerance_mm, comment),))


# From what was found to the arm's file: a new one, or the present one with what differs.
#
# A file that is there is written anew from its own table, so that its comments go; the command
# keeps the old text beside it.

DIGITS = 9


def signs_of(plan: CommissioningPlan, notes: Mapping[str, Notes]) -> Signs:
    """Return which directions are reversed, of the motors that were tried."""
    tried = [(each, notes[each.name]) for each in plan.drives if _was_tried(notes, each.name)]
    seen = [SeenMotion(drive.trial, noted.way, noted.roll) for drive, noted in tried]
    return conclude(seen, plan.roll_joint)


def _was_tried(notes: Mapping[str, Notes], name: str) -> bool:
    return name in notes and bool(notes[name].way)


def merged(
    config: ArmConfig, plan: CommissioningPlan, notes: Mapping[str, Notes], port: str
) -> dict[str, Any]:
    """Return the table of the arm's file with everything that was found."""
    table: dict[str, Any] = copy.deepcopy(dict(config.source.table if config.source else {}))
    wire = table.setdefault("connection", {})
    wire["dialect"] = config.connection.dialect
    if port:
        wire["port"] = port
    _put_device(table.setdefault(config.connection.dialect, {}), plan, notes)
    signs = signs_of(plan, notes)
    gears = {each.name: notes[each.name].gear for each in plan.drives if each.name in notes}
    per_unit = {name: plan.tools.counts_per_turn * gear for name, gear in gears.items() if gear}
    if "motors" in table:
        _put_motors(table["motors"], per_unit, signs)
    else:
        _put_preset(table, plan, per_unit, signs)
    return table


def _put_device(
    section: dict[str, Any], plan: CommissioningPlan, notes: Mapping[str, Notes]
) -> None:
    currents = {each.current_ma for each in notes.values() if each.current_ma}
    alike = len(currents) == 1 and len(notes) == len(plan.drives)
    ids = [each.node for each in plan.drives]
    section.update(plan.tools.section(plan.config.device, ids, currents.pop() if alike else 0))


def _put_preset(
    table: dict[str, Any], plan: CommissioningPlan, per_unit: Mapping[str, float], signs: Signs
) -> None:
    pulling = {each.name for each in plan.drives if each.unit == MM}
    for name, steps in per_unit.items():
        if name in pulling:
            table["steps_per_mm"] = _rounded(steps)
        else:
            table.setdefault("steps_per_turn", {})[name] = _rounded(steps)
    for section, names in (("motor_signs", signs.motors), ("joint_signs", signs.joints)):
        for name in names:
            known = table.setdefault(section, {})
            known[name] = -known.get(name, 1)


def _put_motors(motors: list[dict[str, Any]], per_unit: Mapping[str, float], signs: Signs) -> None:
    for motor in motors:
        name = str(motor.get("name"))
        if name in per_unit:
            key = "steps_per_mm" if "steps_per_mm" in motor else "steps_per_turn"
            motor[key] = _rounded(per_unit[name])
        sees = motor.get("sees", {})
        turned = {joint: -1 for joint in signs.joints if joint in sees}
        own = -1 if name in signs.motors else 1
        motor["sees"] = {joint: one * own * turned.get(joint, 1) for joint, one in sees.items()}


def text_of(table: Mapping[str, Any], name: str, unclear: tuple[str, ...] = ()) -> str:
    """Return the text of an arm file."""
    heading = f"{name}: its drives were commissioned by `armdrive can setup {name}`."
    if unclear:
        heading += f"\nDirections and gears are not tried yet: {', '.join(unclear)}."
    return document(_table_sections({FORMAT_KEY: FORMAT, **table}), heading)


def _table_sections(
    table: Mapping[str, Any], name: str = "", array: bool = False
) -> Iterator[TomlSection]:
    inner = {key: each for key, each in table.items() if _is_section(each)}
    if array:  # an array's entries keep their tables inline
        inner = {}
    yield TomlSection(
        name,
        tuple(TomlEntry(key, each) for key, each in table.items() if key not in inner),
        array=array,
    )
    for key, each in inner.items():
        path = f"{name}.{key}" if name else key
        if isinstance(each, Mapping):
            yield from _table_sections(each, path)
        else:
            for one in each:
                yield from _table_sections(one, path, array=True)


def _is_section(value: Any) -> bool:
    tables = isinstance(value, list) and value and all(isinstance(one, Mapping) for one in value)
    return isinstance(value, Mapping) or bool(tables)


def _rounded(steps: float) -> float:
    """Return the number without digits that no arm has."""
    return float(f"{steps:.{DIGITS}g}")
