"""What has been found out of an arm's drives so far, kept between programs.

The drives keep their ids and settings themselves; directions, gears and what was tried stand here.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

from armdrive import places
from armdrive.durable import replace_file
from armdrive.errors import StateFileError
from armdrive.textfile import is_there, read_json

ENDING = "can-setup.json"


@dataclass(slots=True)
class Notes:
    """Of one motor. `way` and `roll` are the words for what was seen; gears are turns of the motor.

    `watchdog` is whether it was seen to stop the motor; None where that was not tried.
    """

    firmware: str = ""
    current_ma: int = 0
    calibrated: bool = False
    watchdog: bool | None = None
    way: str = ""
    roll: str = ""
    gear: float = 0.0
    done: bool = False


def path_of(arm: str) -> Path:
    """Return the file of an arm's notes."""
    return places.states() / f"{places.file_name(arm)}.{ENDING}"


def read(arm: str, calibration: str) -> dict[str, Notes]:
    """Return the notes of an arm by its motors' names, empty where there are none.

    What was seen of motions counts only where the arm file gives steps the same meaning still.
    Raises `StateFileError`.
    """
    path = path_of(arm)
    try:
        if not is_there(path):
            return {}
        known: Any = read_json(path, "the file", StateFileError, own=True)
        found = {name: _one(given) for name, given in known["motors"].items()}
        same = known["calibration"] == calibration
    except (StateFileError, ValueError, TypeError, KeyError, AttributeError) as error:
        raise StateFileError(
            f"{path} cannot be read ({error}): delete it; ids and settings are in the drives, and "
            "only directions and gears have to be found once more"
        ) from None
    return found if same else {name: absorbed(each) for name, each in found.items()}


def absorbed(notes: Notes) -> Notes:
    """Return notes without what was seen of motions: the arm file has that, or means another."""
    return replace(notes, way="", roll="", gear=0.0)


def write(arm: str, calibration: str, notes: Mapping[str, Notes]) -> None:
    """Keep the notes of an arm, whose file has that calibration."""
    path = path_of(arm)
    motors = {name: asdict(each) for name, each in notes.items()}
    replace_file(path, json.dumps({"calibration": calibration, "motors": motors}, indent=1))


def _one(given: Mapping[str, Any]) -> Notes:
    kinds = {each.name: type(each.default) for each in fields(Notes)}
    for name, value in given.items():
        kind = kinds[name]
        if not isinstance(value, bool | None if kind is type(None) else kind):
            raise TypeError(f"{name} cannot be {value!r}")
    return Notes(**given)
