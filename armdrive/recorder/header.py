"""The first line of a recording: whose it is, and the whole arm file, so that none is needed."""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from armdrive.errors import ArmError, ArmFileError
from armdrive.textfile import read_text

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig, Source

FORMAT = 1
MARK = "armdrive_recording"
"""The key that makes a file a recording; its value is the format's number."""


@dataclass(frozen=True, slots=True)
class Header:
    """What is said of a recording as a whole.

    `began` is the wall clock's time of the connection (UTC, ISO 8601), `began_s` the arm's own
    time then. `arm_file` is TOML with every default in it, and empty where none could be written;
    `model_file` is the text of the model file that it names, if it names one.
    """

    version: str
    why: str
    arm: str
    title: str
    dialect: str
    link: str
    calibration: str
    began: str
    began_s: float
    arm_file: str
    model_file: str


def header_of(config: ArmConfig, *, link: str, why: str, began: tuple[float, float]) -> Header:
    """Return the header of an arm's recording; `began` is the wall's time and the arm's."""
    from importlib.metadata import version  # most arms are closed with nothing written

    wall_s, began_s = began
    moment = dt.datetime.fromtimestamp(wall_s, dt.UTC)
    arm_file, model_file = texts_of(config)
    return Header(
        version=version("armdrive"),
        why=why,
        arm=config.name,
        title=config.title,
        dialect=config.connection.dialect,
        link=link,
        calibration=config.calibration,
        began=moment.isoformat(timespec="milliseconds"),
        began_s=began_s,
        arm_file=arm_file,
        model_file=model_file,
    )


def texts_of(config: ArmConfig) -> tuple[str, str]:
    """Return an arm as TOML, and its model file; empty texts where they cannot be had.

    A recording is written when something has gone wrong: it is worth having without them too.
    """
    from armdrive.armfile import MODEL_FILE
    from armdrive.interview.complete import complete
    from kinematics import PRESETS, KinematicsError

    source = config.source
    if source is None:
        return "", ""
    table: dict[str, Any] = dict(source.table)
    word = str(table.get("model", ""))
    try:
        text = complete(config, table)
        given = word not in PRESETS and word.lower().endswith(MODEL_FILE)
        model = _model_text(source, word) if given else ""
    except (ArmError, KinematicsError, ArithmeticError, LookupError, OSError, ValueError):
        return "", ""
    return text, model


def _model_text(source: Source, word: str) -> str:
    return read_text(source.folder / word, "the model file", ArmFileError)
