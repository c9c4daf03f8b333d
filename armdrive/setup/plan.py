"""The drives of an arm, the trial motion of each, and the notes kept about them."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.dialects import Dialect
from armdrive.dialects.bus.tools import BusTools, CommissioningTools
from armdrive.dialects.controller import Controller
from armdrive.dialects.exchange import ScriptLoop
from armdrive.errors import ArmFileError, BadRequest, StateFileError
from armdrive.registry import DIALECTS, language_of
from armdrive.setup.directions import ArmMotion, Trial, roll_joint, trial_of
from armdrive.sim.world.body import found_posture
from armdrive.storage import files as places
from armdrive.storage.files import replace_file
from armdrive.text.reading import is_there, read_json
from armdrive.text.toml import FORMAT, FORMAT_KEY, Problems, TomlTable, require_format
from kinematics.text import counted, shown_name

DEGREES, MM = "°", "mm"


@dataclass(frozen=True, slots=True)
class Planned:
    """One motor and its drive.

    `trial` is a small motion and what should be seen of it. `moves` names the joint, or the
    fingers, that the motor moves most, by `amount` degrees or mm if the gear is right. `gear` is
    the arm file's: turns of the motor for a turn of what its gear drives, or for a mm.
    """

    motor: int
    name: str
    node: int
    trial: Trial
    moves: str
    amount: float
    unit: str
    gear: float

    @property
    def gear_words(self) -> str:
        """What one unit of the gear is."""
        return "a mm of the fingers" if self.unit == MM else "one turn of what its gear drives"

    @property
    def unit_words(self) -> str:
        """The unit as a question names it."""
        return "mm" if self.unit == MM else "degrees"

    def shown(self, amount: float) -> str:
        """Return an amount with its unit."""
        return f"{amount:.2g}{'' if self.unit == DEGREES else ' '}{self.unit}"

    def moved(self, motion: ArmMotion) -> float:
        """Return how far this motor's joint or the fingers moved, in `unit`."""
        if self.unit == MM:
            return abs(motion.opened_mm)
        return abs(motion.turned_deg(self.moves.replace(" ", "_")))

    @property
    def title(self) -> str:
        """The motor's name with its drive's id."""
        return f"{self.name} (drive {self.node})"


@dataclass(frozen=True, slots=True)
class CommissioningPlan:
    """An arm and its drives; `controller` makes the controller of an arm."""

    config: ArmConfig
    drives: tuple[Planned, ...]
    bus: BusTools
    tools: CommissioningTools
    roll_joint: str
    controller: Callable[[ArmConfig], Controller]

    @property
    def name(self) -> str:
        """The arm's name."""
        return self.config.name

    def scripts(self) -> ScriptLoop[Any]:
        """Return a loop of scripts that reaches these drives, and a new one."""
        ids = {self.tools.new_id, *(each.node for each in self.drives)}
        return self.bus.scripts(sorted(ids))

    @property
    def order(self) -> tuple[Planned, ...]:
        """The drives in the order of commissioning: the one with the id of a new drive comes last.

        So each new drive can be plugged in while those with their own ids stay on the bus.
        """
        return tuple(sorted(self.drives, key=lambda each: each.node == self.tools.new_id))


def commissionable() -> tuple[Dialect, ...]:
    """Return the dialects whose drives can be commissioned."""
    return tuple(row for row in DIALECTS.values() if row.bus and row.bus.commissioning)


def plan_of(config: ArmConfig) -> CommissioningPlan:
    """Return the plan for an arm. Raises `BadRequest` for one without drives on a CAN bus."""
    transmission, device = config.model.transmission, config.device
    spoken = config.connection.dialect
    bus = DIALECTS[spoken].bus
    tools = None if bus is None else bus.commissioning
    if transmission is None or bus is None or tools is None:
        known = commissionable()
        titles = " or ".join(language_of(each.name).title for each in known)
        lines = " or ".join(f'dialect = "{each.name}"' for each in known)
        raise BadRequest(
            f"{config.name} has no {titles}: `armdrive can setup` is for arm files that say "
            f"{lines} under [connection]"
        )
    if len(device.ids) < len(transmission.motors):
        raise BadRequest(
            f"{spoken}.ids names {counted(len(device.ids), 'drive')}, and the arm has "
            f"{counted(len(transmission.motors), 'motor')}: give each its own"
        )
    arm = config.model.arm
    posture = found_posture(arm)
    drives = []
    for motor, node in enumerate(device.ids[: len(transmission.motors)]):
        column = [row[motor] for row in transmission.inverse]
        turning = column[: len(transmission.joint_names)]
        # behind cables a motor moves several joints: the person watches the one that moves most
        most = max(range(len(turning)), key=lambda at: abs(turning[at]))
        if turning[most]:
            moves, unit = shown_name(transmission.joint_names[most]), DEGREES
            per_step = math.degrees(turning[most])
        else:
            moves, unit, per_step = "fingers", MM, column[-1]
        trial, spec = trial_of(arm, transmission, posture, motor), transmission.motors[motor]
        amount = abs(trial.steps * per_step)
        gear = abs(spec.steps_per_unit) * (1.0 if unit == MM else math.tau) / tools.counts_per_turn
        drives.append(Planned(motor, spec.name, node, trial, moves, amount, unit, gear))
    return CommissioningPlan(
        config, tuple(drives), bus, tools, roll_joint(arm, posture), DIALECTS[spoken].controller
    )


# The notes about an arm's drives, kept between runs.
#
# The drives keep their ids and settings themselves; the notes hold directions, gears and trials.

NOTES_ENDING = "can-setup.json"


@dataclass(slots=True)
class Notes:
    """The notes about one motor: `way` and `roll` are the words for the motion that was seen.

    `watchdog` is whether it stopped the motor; None if that was not tried.
    """

    firmware: str = ""
    current_ma: int = 0
    calibrated: bool = False
    watchdog: bool | None = None
    way: str = ""
    roll: str = ""
    gear: float = 0.0
    done: bool = False


def notes_file(arm: str) -> Path:
    """Return the file of an arm's notes."""
    return places.states() / f"{places.file_name(arm)}.{NOTES_ENDING}"


def read_notes(arm: str, calibration: str) -> dict[str, Notes]:
    """Return the notes of an arm by its motors' names, empty if there are none.

    The motions seen count only as long as the arm file gives steps the same meaning. Raises
    `StateFileError`.
    """
    path = notes_file(arm)
    try:
        if not is_there(path):
            return {}
        known: Any = read_json(path, "the file", StateFileError, own=True)
        require_format(known, StateFileError)
        problems = Problems()
        motors = TomlTable(known, "", problems).table("motors")
        found = {name: motors.table(name).section(Notes) or Notes() for name in motors.entries}
        problems.require_none()
        same = known["calibration"] == calibration
    except (StateFileError, ArmFileError, TypeError, KeyError, AttributeError) as error:
        raise StateFileError(
            f"{path} cannot be read ({error}): delete it; ids and settings are in the drives, and "
            "only directions and gears have to be found once more"
        ) from None
    return found if same else {name: without_motions(each) for name, each in found.items()}


def without_motions(notes: Notes) -> Notes:
    """Return notes without the motions seen: the arm file contains them, or has changed."""
    return replace(notes, way="", roll="", gear=0.0)


def write_notes(arm: str, calibration: str, notes: Mapping[str, Notes]) -> None:
    """Keep the notes of an arm, whose file has that calibration."""
    path = notes_file(arm)
    motors = {name: asdict(each) for name, each in notes.items()}
    table = {FORMAT_KEY: FORMAT, "calibration": calibration, "motors": motors}
    replace_file(path, json.dumps(table, indent=1))
