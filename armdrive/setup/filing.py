"""Writes arm files: a new one after reading it back, a present one as a difference to confirm."""

from __future__ import annotations

import difflib
import tempfile
import tomllib
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from armdrive.config.arm import ArmConfig, read_arm_table
from armdrive.config.write import MEANINGS
from armdrive.errors import ArmFileError
from armdrive.errors.printable import command_line
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import arm_problems, load_arm
from armdrive.setup.commissioning import CommissioningPlan
from armdrive.setup.directions import Signs, changes, written_steps
from armdrive.setup.draft import GRIPPER_MOTOR, HALF_STEP, Draft, Ratio
from armdrive.setup.questions import ROWS
from armdrive.setup.templates import GRIPPER_KEYS
from armdrive.storage.files import kept_aside, replace_file
from armdrive.text.reading import read_text
from armdrive.text.toml import FORMAT_ENTRY, TomlEntry, TomlSection, document, rule_of
from armdrive.text.toml_amend import Change, amended
from kinematics.text import counted
from kinematics.transmission import Transmission

# The text of an arm file, and of its model file if it has one, from the answers of an interview.
#
# Each answer goes to the place that its question names (questions.py). What follows from several
# answers is added here: the model, and the motors with their steps and directions. For an arm of
# the Mini-mover's build only what differs from the preset is written, for a link table everything.
# Comments say where a number comes from.

# The folder of model files, in the folder of arm files.
MODELS = "models"


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
    lines.append(f"`{command_line('config', 'show', draft.name)}` lists every key with its value.")
    return "\n".join(lines)


def _model_text(draft: Draft) -> str | None:
    """Return the text of the arm's model file; None for an arm with a preset."""
    links = draft.links
    if links is None:
        return None
    lengths = {
        path: draft.answers[f"lengths.{key}"] for key, path in draft.template.lengths.items()
    }
    if not lengths:
        return links.text
    measured = any(links.length_mm(path) != mm for path, mm in lengths.items())
    title = str(draft.get("title", draft.name))
    head = {"name": draft.name, "title": title, "verified": measured}
    changes = [Change((key,), each) for key, each in head.items()]
    changes += [Change(path, mm) for path, mm in lengths.items()]
    return amended(links.text, changes)


# The order of the sections; the controller's own follows its connection.
ORDER = (
    "", "connection", "lengths", "steps_per_turn", "limits_deg", "speeds_deg_s", "gripper",
    "fingers", "homing", "homing.joints_deg", "reference", "park",
)  # fmt: skip


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
    of_gripper = GRIPPER_KEYS.get(draft.gripper, ())
    found[dialect] += [
        TomlEntry(each.name, each.default, rule_of(each).help)
        for each in fields(draft.dialect.settings())
        if each.name in of_gripper
    ]
    if linked:
        # a model file has limits of its own, but no speeds
        asked = {entry.key for entry in found["speeds_deg_s"]}
        found["speeds_deg_s"] += [
            TomlEntry(joint, draft.speed_deg_s(joint))
            for joint in draft.joints
            if joint not in asked
        ]
    elif not _presets_own(draft):
        found["steps_per_turn"] += [_turning(draft, motor) for motor in draft.motors]
        if draft.stepped:
            found[""].append(_pulling(draft))
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


def _array_of_motors(draft: Draft) -> Iterator[TomlSection]:
    """Yield the [[motors]] of an arm with a link table, each with the joint that it moves."""
    for motor in draft.motors:
        sign = draft.direction(motor)
        why = "-1: it counts up as the joint goes down" * (sign < 0)
        entries = (
            TomlEntry("name", motor),
            replace(_turning(draft, motor), key="steps_per_turn"),
            TomlEntry("sees", {motor: sign}, why),
        )
        yield TomlSection("motors", entries, array=True)
    if draft.stepped:
        entries = (
            TomlEntry("name", GRIPPER_MOTOR),
            _pulling(draft),
            TomlEntry("sees", {"opening": 1}),
        )
        yield TomlSection("motors", entries, array=True)


def _turning(draft: Draft, motor: str) -> TomlEntry:
    if draft.published_motors:
        return TomlEntry(motor, written_steps(draft.published_steps(motor)), _microstepped(draft))
    gear: Ratio = draft.answers[f"gear.{motor}"]
    steps = draft.turn_steps * gear.turns
    return TomlEntry(
        motor, written_steps(steps), f"{draft.turn_words} x {gear.written} = {steps:.6g}"
    )


def _microstepped(draft: Draft) -> str:
    return f"the published half-steps at {counted(draft.get('microsteps', HALF_STEP), 'microstep')}"


def _pulling(draft: Draft) -> TomlEntry:
    if draft.published_motors:
        published = draft.published_steps(GRIPPER_MOTOR)
        return TomlEntry("steps_per_mm", written_steps(published), _microstepped(draft))
    turn_mm = draft.answers["fingers.mm_per_turn"]
    words = f"{draft.turn_words} / {turn_mm:g} mm a turn"
    return TomlEntry("steps_per_mm", written_steps(draft.turn_steps / turn_mm), words)


# Reading the texts back, and writing them.


def checked(files: ArmFiles, name: str) -> ArmConfig:
    """Return the arm that the texts describe, read back from a temporary folder."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.toml"
        write(files, path)
        return load_arm(path)


def write(files: ArmFiles, path: Path) -> None:
    """Write the model file, then the arm file that names it."""
    # the model file first: an arm file that names a missing one cannot be read
    if files.model is not None:
        replace_file(path.parent / files.model_path, files.model.rstrip("\n"))
    replace_file(path, files.arm.rstrip("\n"))


@dataclass(frozen=True, slots=True)
class FileProposal:
    """An arm file before and after a change; `remarks` are faults that no file can fix."""

    path: Path
    before: str
    after: str
    remarks: tuple[str, ...] = ()

    @property
    def differs(self) -> bool:
        """Whether there is anything to write."""
        return self.before != self.after

    @property
    def difference(self) -> tuple[str, ...]:
        """The lines that go and come, with a line of context."""
        lines = (self.before.splitlines(), self.after.splitlines())
        return tuple(difflib.unified_diff(*lines, "as it is", "as proposed", lineterm="", n=1))

    def write(self, *, keep_old: bool = False) -> None:
        """Write the file; with `keep_old`, keep the old text in a file beside it.

        Raises `ArmFileError` if the file has changed since it was read.
        """
        if _text_before(self.path) != self.before:
            raise ArmFileError(
                f"{self.path} has changed in the meantime and was not written: repeat the check"
            )
        if keep_old and self.before:
            replace_file(kept_aside(self.path), self.before.rstrip("\n"))
        replace_file(self.path, self.after.rstrip("\n"))


def after_writing(path: Path, config: ArmConfig) -> Iterator[str]:
    """Yield that a file was written, and the commands to type next, from the safest on."""
    name = config.name
    yield f"written: {path}"
    yield "next, beginning with the safest:"
    twin = f"ARMDRIVE_FORCE_SIM=1 {command_line('home', '--arm', name)}"
    check = command_line("config", "check", name)
    lines = [(check, "problems and notes; opens nothing"), (twin, "its simulated twin")]
    if config.connection.names_port:
        on_port = {
            "doctor --arm": "checks what is connected to its port; moves nothing",
            "status --arm": "connects; moves nothing",
        }
        bus = DIALECTS[config.connection.dialect].bus
        if bus is not None and bus.units is not None:
            on_port["can setup"] = "measures units that drives do not report, by slow turns"
        on_port["config signs"] = "turns each motor a little, to see its direction"
        homes = config.homing is not None  # by switches, after a question
        on_port["home --arm"] = "seeks its switches" if homes else "you jog it to its reference"
        on_port["jog --arm"] = "slowly, by hand; space stops"
        lines += [(command_line(*words.split(), name), does) for words, does in on_port.items()]
    lines.append((command_line("config", "set-default", name), "used where no arm is named"))
    width = max(len(command) for command, _ in lines)
    for command, words in lines:
        yield f"  {command:<{width}}  {words}"


def _proposal(
    path: Path, changes: Iterable[Change], *, new: str = "", remarks: Iterable[str] = ()
) -> FileProposal:
    """Return an arm file with these changes; `new` is its text if there is no such file yet.

    Raises `ArmFileError` if the file could not be used any more.
    """
    before = _text_before(path)
    proposal = FileProposal(path, before, amended(before or new, changes), tuple(remarks))
    # the file may have problems already, which the change neither made nor has to fix
    known, now = (
        arm_problems(tomllib.loads(text), path.stem, path.parent)
        for text in (proposal.before, proposal.after)
    )
    worse = [each for each in now if each not in known]
    if worse:
        raise ArmFileError(f"with these changes the arm file could not be used: {worse[0]}")
    return proposal


def propose(path: Path, transmission: Transmission | None, signs: Signs) -> FileProposal:
    """Return how an arm file should be changed. Writes nothing; raises `ArmFileError`."""
    table = tomllib.loads(_text(path))
    return _proposal(path, changes(table, transmission, signs), remarks=_remarks(signs))


def propose_keys(path: Path, table: str, keys: Mapping[str, Any], why: str) -> FileProposal:
    """Return the arm file with these keys of one of its tables, which get a comment."""
    return _proposal(path, [Change((table, key), value, why) for key, value in keys.items()])


def new_text(config: ArmConfig) -> str:
    """Return the file of a preset's arm without anything about its drives."""
    setup = command_line("can", "setup", config.name)
    heading = f"{config.name}: its drives were commissioned by `{setup}`."
    table = config.source.table if config.source else {}
    return document((TomlSection("", (FORMAT_ENTRY, TomlEntry("model", table["model"]))),), heading)


def propose_drives(
    path: Path, plan: CommissioningPlan, currents_ma: Mapping[str, int], port: str
) -> FileProposal:
    """Return the arm file, or a new one, with its port and its drives' ids and settings."""
    config = plan.config
    spoken = config.connection.dialect
    known = set(currents_ma.values())
    # the section has one current for all drives, so it is written only if all have the same
    alike = len(known) == 1 and len(currents_ma) == len(plan.drives)
    ids = [each.node for each in plan.drives]
    device = plan.tools.section(config.device, ids, known.pop() if alike else 0)
    connection = {"dialect": spoken, "port": port} if port else {"dialect": spoken}
    changed = [
        Change((section, key), each)
        for section, keys in (("connection", connection), (spoken, device))
        for key, each in keys.items()
    ]
    return _proposal(path, changed, new=new_text(config))


def file_of(config: ArmConfig) -> Path | None:
    """Return the file that an arm was read from; None if there is none or it has changed."""
    if config.source is None:
        return None
    path = config.source.folder / f"{config.name}.toml"
    try:
        return path if read_arm_table(path) == config.source.table else None
    except ArmFileError:
        return None


def _remarks(signs: Signs) -> Iterator[str]:
    """Yield what no change of a file mends."""
    if signs.order:
        pairs = ", ".join(f"{seen} moved for {meant}" for meant, seen in signs.order.items())
        yield (
            f"{pairs}: swap their plugs at the controller, or their places in the arm file, then "
            "check again"
        )
    if signs.unclear:
        yield f"unclear: {', '.join(signs.unclear)}. Check plugs and drivers, then check again"


def _text_before(path: Path) -> str:
    """Return the text of an arm file; an empty text for one that is yet to be made."""
    return _text(path) if path.is_file() else ""


def _text(path: Path) -> str:
    return read_text(path, "the arm file", ArmFileError)
