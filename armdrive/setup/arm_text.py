"""From the answers to an arm file's text, and to that of its model file where it has one.

Only what differs from the preset is written for an arm of the Mini-mover's build; an arm of a
link table has everything written out. Comments say where a number comes from.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from armdrive.config.preset import LENGTHS
from armdrive.setup.draft import GRIPPER_MOTOR, HALF_STEP, Draft
from armdrive.setup.templates import COUPLED, model_text, typed_text
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
