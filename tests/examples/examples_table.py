"""The examples that run on every arm, and what has to be there afterwards."""

from collections.abc import Mapping
from types import MappingProxyType

from armdrive.abilities import Abilities
from armdrive.registry import DIALECTS

from . import worlds
from .on_arms import Example, Form


def no_grip_switch(abilities: Abilities) -> str:
    """Say that an arm cannot measure what is between its fingers."""
    return "" if abilities.grip_switch else "needs a grip switch"


_ROW = {"repeat 2 as row": "repeat 1 as row"}
_ONE = {**_ROW, "repeat 2 as column": "repeat 1 as column"}
_ONLY_TEACHMOVER = dict.fromkeys(set(DIALECTS) - {"teachmover"})
"""Every day, other dialects show the same with `stacking.arm` or `circle.py`."""

_ROWS = {
    "A": (230.0, -30.0, 0.0),
    "B": (180.0, -30.0, 0.0),
    "C": (280.0, -30.0, 0.0),
    "D": (180.0, -80.0, 0.0),
}

EXAMPLES: Mapping[str, Example] = MappingProxyType({each.file: each for each in (
    Example(
        "stacking.arm", Form(4), worlds.tower,
        shorter={"robko01": None, "armdroid": Form(2, _ROW), "grbl": Form(1, _ONE),
                 "mks": None, "cia402": None},
    ),
    Example(
        "stacking.py", Form(4), worlds.tower, shorter=_ONLY_TEACHMOVER,
    ),
    Example(
        "hanoi.arm", Form(3), worlds.hanoi, shorter=_ONLY_TEACHMOVER,
    ),
    Example(
        "sorting.arm", Form(_ROWS), worlds.sorted_rows, no_grip_switch,
    ),
    Example(
        "circle.py", Form(35.0), worlds.circle,
        shorter={"robko01": None, "grbl": None, "mks": None, "cia402": None},
    ),
    Example(
        "lettering.py", Form("ARM"), worlds.letters, shorter=_ONLY_TEACHMOVER,
    ),
)})  # fmt: skip
"""Every example that carries or draws something, by its file."""
