"""The model that a command computes with, and its values as a person types and reads them.

A model is a built-in arm, a named system, or the reader's own file.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from armdrive.config.link_model import Model, is_model_file, read_model
from armdrive.errors import BadRequest
from kinematics.chains.chain import Chain
from kinematics.chains.links import JointKind
from kinematics.errors import suggestion
from kinematics.presets import PRESETS
from kinematics.textbook.systems import SYSTEMS


def find_model(word: str) -> Model:
    """Return a named system or a model file as a chain of links.

    Raises `BadRequest` for a name that nothing has, with the nearest one, and `ArmFileError` for
    a file that cannot be used.
    """
    if is_model_file(word):
        return read_model(word)
    if word in SYSTEMS:
        found = SYSTEMS[word]
        return Model(found.name, found.title, found.source, found.chain())
    known = list(dict.fromkeys((*PRESETS, *SYSTEMS)))
    hint = suggestion(word, known)
    raise BadRequest(
        f"no model is named {word!r}{hint} (there are {', '.join(known)}, and .toml files)"
    )


# People type and read degrees and mm; kinematics takes rad and mm.


def given_joints(chain: Chain, typed: Sequence[float]) -> tuple[float, ...]:
    """Return joint values in rad and mm. Raises `BadRequest` for the wrong number of them."""
    if len(typed) != len(chain):
        raise BadRequest(
            f"{len(chain)} joint values are required ({', '.join(chain.joint_names)}), "
            f"not {len(typed)}"
        )
    return tuple(
        math.radians(value) if kind is JointKind.REVOLUTE else value
        for value, kind in zip(typed, chain.kinds, strict=True)
    )


def given_goal(
    coordinates: Sequence[str], typed: Sequence[float], *, least: int | None = None
) -> tuple[float, ...]:
    """Return the coordinates of a goal in rad and mm.

    All are needed, or the first `least` alone. Raises `BadRequest` for another number of them.
    """
    if len(typed) not in (len(coordinates), least):
        names = [typed_name(name) for name in coordinates]
        fewer = f", or {', '.join(names[:least])} alone" if least else ""
        raise BadRequest(f"a goal is {', '.join(names)}{fewer}, not {len(typed)} numbers")
    return tuple(
        math.radians(value) if name.endswith("_rad") else value
        for name, value in zip(coordinates, typed, strict=False)
    )


def coordinates_text(coordinates: Sequence[str], values: Sequence[float]) -> str:
    """Return the coordinates of a goal as they would be typed, in a sentence."""
    pairs = map(shown, coordinates, values)
    return ", ".join(f"{name} {value:.6g}" for name, value in pairs)


def typed_name(name: str) -> str:
    """Return a coordinate's name with the unit that a person types: pitch_deg for pitch_rad."""
    return f"{name.removesuffix('_rad')}_deg" if name.endswith("_rad") else name


def shown(name: str, value: float) -> tuple[str, float]:
    """Return a coordinate as a person reads it, in mm and degrees."""
    return typed_name(name), math.degrees(value) if name.endswith("_rad") else value


def joint_name(name: str, kind: JointKind) -> str:
    """Return a joint's name with its unit."""
    return f"{name}_{'deg' if kind is JointKind.REVOLUTE else 'mm'}"


def shown_joints(chain: Chain, values: Sequence[float]) -> dict[str, float]:
    """Return joint values in degrees and mm, by names that say so."""
    return {
        joint_name(name, kind): math.degrees(value) if kind is JointKind.REVOLUTE else value
        for name, kind, value in zip(chain.joint_names, chain.kinds, values, strict=True)
    }
