"""Writes arm files: a new one after reading it back, a present one as a difference to confirm."""

from __future__ import annotations

import difflib
import tempfile
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from armdrive.config.arm import ArmConfig, read_arm_table
from armdrive.errors import ArmFileError
from armdrive.registry.arm_files import arm_problems, load_arm
from armdrive.setup.arm_text import ArmFiles
from armdrive.setup.directions import Signs, changes, conclude, known_steps
from armdrive.setup.plan import CommissioningPlan, Notes
from armdrive.storage.files import replace_file
from armdrive.text.reading import read_text
from armdrive.text.toml import FORMAT_ENTRY, TomlEntry, TomlSection, document
from armdrive.text.toml_amend import Change, amended
from kinematics.transmission import Transmission


def checked(files: ArmFiles, name: str) -> ArmConfig:
    """Return the arm that the texts describe, read back from a temporary folder."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"{name}.toml"
        write(files, path)
        return load_arm(path)


def write(files: ArmFiles, path: Path) -> None:
    """Write the model file, then the arm file that names it."""
    if files.model is not None:
        replace_file(path.parent / files.model_path, files.model.rstrip("\n"))
    replace_file(path, files.arm.rstrip("\n"))


@dataclass(frozen=True, slots=True)
class FileProposal:
    """An arm file before and after a change; `remarks` are faults that no file can mend."""

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

    def write(self, aside: str = "") -> None:
        """Write the file; with `aside`, keep the old text in a file of that name.

        Raises `ArmFileError` if the file has changed since it was read.
        """
        if _text_before(self.path) != self.before:
            raise ArmFileError(
                f"{self.path} has changed in the meantime and was not written: repeat the check"
            )
        if aside and self.before:
            replace_file(self.path.with_name(aside), self.before.rstrip("\n"))
        replace_file(self.path, self.after.rstrip("\n"))


def after_writing(path: Path, config: ArmConfig) -> Iterator[str]:
    """Yield that a file was written, and the commands to type next, from the safest on."""
    name = config.name
    yield f"written: {path}"
    yield "next, from the safest on:"
    lines = [
        (f"armdrive config check {name}", "problems and remarks; opens nothing"),
        (f"ARMDRIVE_FORCE_SIM=1 armdrive home --arm {name}", "its simulated twin"),
    ]
    if config.connection.port:
        lines += [
            (f"armdrive doctor --arm {name}", "asks who is at its port; moves nothing"),
            (f"armdrive status --arm {name}", "connects; moves nothing"),
            (f"armdrive config signs {name}", "turns each motor a little, to see its direction"),
            (f"armdrive jog --arm {name}", "slowly, by hand; space stops"),
        ]
    lines.append((f"armdrive config set-default {name}", "use it if no arm is named"))
    width = max(len(command) for command, _ in lines)
    for command, words in lines:
        yield f"  {command:<{width}}  {words}"


def propose(path: Path, transmission: Transmission | None, signs: Signs) -> FileProposal:
    """Return how an arm file should be changed. Writes nothing; raises `ArmFileError`."""
    before = _text(path)
    table = tomllib.loads(before)
    known = set(arm_problems(table, path.stem, path.parent))
    order = dict(signs.order) if "motors" in table and signs.swapped else {}
    before_steps = known_steps(table, transmission)
    steps = {name: before_steps[name] / share for name, share in signs.farther.items()}
    text = amended(before, changes(table, transmission, signs, steps), order)
    new = [
        each
        for each in arm_problems(tomllib.loads(text), path.stem, path.parent)
        if each not in known
    ]
    if new:
        raise ArmFileError(f"with these changes the arm file could not be used: {new[0]}")
    return FileProposal(path, before, text, tuple(_remarks(signs, order)))


# The arm file of drives that were commissioned.


def signs_of(plan: CommissioningPlan, notes: Mapping[str, Notes]) -> Signs:
    """Return the reversed directions of the motors that were tried."""
    tried = [(each, notes[each.name]) for each in plan.drives if each.name in notes]
    seen = [drive.trial.seen(noted.way, noted.roll) for drive, noted in tried if noted.way]
    return conclude(seen, plan.roll_joint)


def new_text(config: ArmConfig, left_out: tuple[str, ...] = ()) -> str:
    """Return the file of a preset's arm without anything about its drives."""
    heading = f"{config.name}: its drives were commissioned by `armdrive can setup {config.name}`."
    if left_out:
        heading += f"\nDirections and gears not tried yet: {', '.join(left_out)}."
    table = config.source.table if config.source else {}
    return document((TomlSection("", (FORMAT_ENTRY, TomlEntry("model", table["model"]))),), heading)


def commissioned(
    text: str, config: ArmConfig, plan: CommissioningPlan, notes: Mapping[str, Notes], port: str
) -> str:
    """Return the text of an arm file with all that commissioning found out."""
    table, spoken = tomllib.loads(text), config.connection.dialect
    wire = {"dialect": spoken, "port": port} if port else {"dialect": spoken}
    currents = {each.current_ma for each in notes.values() if each.current_ma}
    alike = len(currents) == 1 and len(notes) == len(plan.drives)
    ids = [each.node for each in plan.drives]
    device = plan.tools.section(config.device, ids, currents.pop() if alike else 0)
    gears = {each.name: notes[each.name].gear for each in plan.drives if each.name in notes}
    steps = {name: plan.tools.counts_per_turn * gear for name, gear in gears.items() if gear}
    directions = changes(table, config.model.transmission, signs_of(plan, notes), steps)
    found = [
        *(Change(("connection", key), each) for key, each in wire.items()),
        *(Change((spoken, key), each) for key, each in device.items()),
        *directions,
    ]
    return amended(text, found)


def propose_drives(
    path: Path,
    config: ArmConfig,
    plan: CommissioningPlan,
    notes: Mapping[str, Notes],
    port: str,
    left_out: tuple[str, ...] = (),
) -> FileProposal:
    """Return the arm file, or a new one, with all that commissioning found out."""
    before = _text_before(path)
    begun = before or new_text(config, left_out)
    return FileProposal(path, before, commissioned(begun, config, plan, notes, port))


def file_of(config: ArmConfig) -> Path | None:
    """Return the file that an arm was read from; None if there is none or it has changed."""
    if config.source is None:
        return None
    path = config.source.folder / f"{config.name}.toml"
    try:
        return path if read_arm_table(path) == config.source.table else None
    except ArmFileError:
        return None


def _remarks(signs: Signs, order: dict[str, str]) -> list[str]:
    remarks = []
    if signs.order and not order:
        pairs = ", ".join(f"{seen} moved for {meant}" for meant, seen in signs.order.items())
        remarks.append(f"{pairs}: swap their plugs at the controller, then check again")
    if order:
        remarks.append("motors have changed places: check their directions again")
    if signs.unclear:
        names = ", ".join(signs.unclear)
        remarks.append(f"unclear: {names}. Check plugs and drivers, then check again")
    return remarks


def _text_before(path: Path) -> str:
    """Return the text of an arm file; an empty text for one that is yet to be made."""
    return _text(path) if path.is_file() else ""


def _text(path: Path) -> str:
    return read_text(path, "the arm file", ArmFileError)
