"""From the answers to an arm file's text, and to that of its model file where it has one.

Only what differs from the preset is written for an arm of the Mini-mover's build; an arm of a
link table has everything written out. Comments say where a number comes from.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from armdrive.interview.draft import Draft
from armdrive.interview.link_tables import model_text, typed_text
from armdrive.interview.rows_arm import LENGTHS
from armdrive.interview.toml_text import Entry, Section, document
from armdrive.interview.writing_motors import array_of_motors, gripper_entry, steps_section

MODELS = "models"
"""The folder of model files, beside the arm files."""

POSTURE_KEYS = ("x_mm", "y_mm", "z_mm", "pitch_deg", "roll_deg", "yaw_deg")


@dataclass(frozen=True, slots=True)
class Files:
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


def files_of(draft: Draft) -> Files:
    """Return the texts of the files."""
    path = f"{MODELS}/{draft.name}.toml"
    return Files(document(_sections(draft, path), _heading(draft)), _links(draft), path)


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


def _sections(draft: Draft, model_path: str) -> Iterator[Section]:
    yield _top(draft, model_path)
    yield _connection(draft)
    yield _device(draft)
    yield from _arm(draft)
    yield from _use(draft)


def _top(draft: Draft, model_path: str) -> Section:
    preset = draft.template.preset
    entries = [
        Entry("model", preset or model_path, "" if preset else "the link table, beside this file"),
        Entry("title", draft.get("title", draft.name)),
    ]
    if draft.preset is not None and draft.measured and draft.stepped:
        entries += gripper_entry(draft)
    return Section("", tuple(entries))


def _connection(draft: Draft) -> Section:
    port = draft.get("connection.port", "")
    entries = [
        Entry("dialect", draft.dialect.name),
        Entry("port", port, "" if port else "none yet: the arm is only simulated"),
    ]
    if (baud := draft.get("connection.baud")) is not None:
        entries.append(Entry("baud", baud))
    if draft.get("connection.keep_dtr"):
        entries += [
            Entry("raise_dtr", True, "the board resets when DTR rises ..."),
            Entry("keep_dtr_on_close", True, "... so it stays up between programs"),
        ]
    return Section("connection", tuple(entries))


def _device(draft: Draft) -> Section:
    """Return the dialect's own section: what was asked of it, and whether it homes."""
    known = draft.device_fields
    asked = [(key, draft.get(f"device.{key}")) for key in known]
    entries = [Entry(key, value) for key, value in asked if value is not None]
    if draft.get("homing.own") and "homing" in known:
        entries.append(Entry("homing", True, "the board's own setting is checked against this"))
    return Section(draft.dialect.name, tuple(entries))


def _arm(draft: Draft) -> Iterator[Section]:
    if draft.preset is None:
        yield from array_of_motors(draft)
    else:
        lengths = [Entry(k, draft.get(f"lengths.{k}")) for k in LENGTHS]
        yield Section("lengths", tuple(entry for entry in lengths if entry.value is not None))
        yield steps_section(draft)
        yield from _signs(draft)
    every = draft.preset is None
    yield Section("limits_deg", tuple(_per_joint(draft, "limits", every)))
    yield Section("speeds_deg_s", tuple(_per_joint(draft, "speeds", every)))


def _per_joint(draft: Draft, what: str, every: bool) -> Iterator[Entry]:
    known = {"limits": draft.limits_deg, "speeds": draft.speed_deg_s}[what]
    for joint in draft.joints:
        answered = draft.get(f"{what}.{joint}")
        if answered is not None:
            yield Entry(joint, answered)
        elif every:
            yield Entry(joint, known(joint))


def _signs(draft: Draft) -> Iterator[Section]:
    for section, key in (("motor_signs", "reversed.motors"), ("joint_signs", "reversed.joints")):
        comment = "-1 counts the other way than the preset"
        yield Section(section, tuple(Entry(name, -1) for name in draft.get(key, ())), comment)


def _use(draft: Draft) -> Iterator[Section]:
    if not draft.stepped:
        yield Section("gripper", (Entry("kind", draft.gripper),))
    if draft.preset is None and "fingers.range" in draft.answers:
        entries = (
            Entry("range_mm", draft.answers["fingers.range"]),
            Entry("speed_mm_s", draft.answers["fingers.speed"]),
        )
        yield Section("fingers", entries)
    if draft.get("homing.own"):
        yield from _homing(draft)
    for key in ("reference", "park"):
        yield _posture(key, draft.get(key, ()))
    yield _guards(draft)


def _homing(draft: Draft) -> Iterator[Section]:
    entries = []
    if draft.stepped:
        entries.append(Entry("opening_mm", draft.get("homing.opening", 0.0)))
    if draft.get("homing.groups"):
        order = "motors by number, in the order in which they home"
        entries.append(Entry("groups", draft.answers["homing.groups"], order))
    yield Section("homing", tuple(entries))
    joints = tuple(Entry(joint, draft.answers[f"homing.joints.{joint}"]) for joint in draft.joints)
    yield Section("homing.joints_deg", joints, "where every joint stands after homing")


def _posture(name: str, numbers: Sequence[float]) -> Section:
    return Section(name, tuple(map(Entry, POSTURE_KEYS, numbers)))


def _guards(draft: Draft) -> Section:
    tolerance_mm = draft.get("guards.tolerance_mm")
    usual = draft.preset.guards.tolerance_mm if draft.preset else None
    if tolerance_mm is None or tolerance_mm == usual:
        return Section("guards", ())
    comment = "how far below the table rounding may put a point"
    return Section("guards", (Entry("tolerance_mm", tolerance_mm, comment),))
