"""The model file: a serial arm as a link table in TOML, in mm and degrees.

Any number of joints, in either convention. Unknown keys are refused with the nearest known one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from armdrive.errors import ArmFileError
from armdrive.sections import number, read_section, refuse_unknown, require_table
from armdrive.textfile import read_toml
from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention
from kinematics.chains.tables import chain_of_rows
from kinematics.errors import KinematicsError
from kinematics.frames.orientations import RPY
from kinematics.frames.transforms import Transform, transform

ENDING = ".toml"

MOST_LINKS = 100
"""No arm has so many; what is worked out of a chain takes time with their number squared."""

_TOP_KEYS = ("name", "title", "source", "verified", "convention", "base", "tool", "links")


@dataclass(frozen=True, slots=True)
class Model:
    """A model as its file describes it: name, title, where its numbers come from, links.

    `verified` is False where the file says that nobody has measured them on an arm yet.
    """

    name: str
    title: str
    source: str
    chain: Chain
    verified: bool = True


@dataclass(frozen=True, slots=True)
class Placement:
    """A frame in another: position in mm, turned by Rot(z, phi) Rot(y, theta) Rot(x, psi)."""

    x_mm: float = 0.0
    y_mm: float = 0.0
    z_mm: float = 0.0
    phi_deg: float = 0.0
    theta_deg: float = 0.0
    psi_deg: float = 0.0

    def frame(self) -> Transform:
        """Return it as a transform, exact at whole quarter turns."""
        angles = map(math.radians, (self.phi_deg, self.theta_deg, self.psi_deg))
        turned = RPY(*angles).rotation()
        clean = tuple(tuple(_clean(entry) for entry in row) for row in turned)
        return transform(clean, (self.x_mm, self.y_mm, self.z_mm))  # type: ignore[arg-type]


def is_model_file(word: str) -> bool:
    """Whether a word names a model file rather than a built-in model."""
    return word.lower().endswith(ENDING)


def read_model(path: str | Path) -> Model:
    """Read a model file. Raises `ArmFileError`, which names the file and the key."""
    place = Path(path)
    document = read_toml(place, "the model file", ArmFileError)
    try:
        return parse_model(document, name=place.stem)
    except (ArmFileError, KinematicsError) as error:
        raise ArmFileError(f"{place}: {error}") from None


def parse_model(document: Mapping[str, Any], *, name: str = "model") -> Model:
    """Return the model of a parsed file; `name` is used where it gives none.

    Raises `ArmFileError` for a wrong key or value of the file, `KinematicsError` for links that
    make no chain.
    """
    refuse_unknown(document, list(_TOP_KEYS), "")
    called = _text(document, "name", name)
    rows = document.get("links", [])
    if not isinstance(rows, list) or not rows:
        raise ArmFileError("a model needs at least one link, each written under [[links]]")
    if len(rows) > MOST_LINKS:
        raise ArmFileError(f"a model has at most {MOST_LINKS} links, not {len(rows)}")
    chain = chain_of_rows(
        [require_table(row, "links") for row in rows],
        convention=_convention(_text(document, "convention", Convention.STANDARD.value)),
        base=read_section(Placement, document.get("base", {}), "base").frame(),
        tool=read_section(Placement, document.get("tool", {}), "tool").frame(),
        name=called,
    )
    verified = document.get("verified", True)
    if not isinstance(verified, bool):
        raise ArmFileError(f"verified must be true or false, not {verified!r}")
    title, source = _text(document, "title", called), _text(document, "source", "")
    return Model(called, title, source, chain, verified)


def _text(document: Mapping[str, Any], key: str, default: str) -> str:
    value = document.get(key, default)
    if not isinstance(value, str):
        raise ArmFileError(f"{key} must be text, not {value!r}")
    return value


def _convention(word: str) -> Convention:
    for one in Convention:
        if one.value == word:
            return one
    known = " or ".join(repr(one.value) for one in Convention)
    raise ArmFileError(f"convention must be {known}, not {word!r}")


def _clean(entry: float) -> float:
    """Return the entry of a rotation without the rounding of quarter turns."""
    whole = float(round(number(entry, "rotation")))
    return whole if abs(entry - whole) < 1e-15 else entry
