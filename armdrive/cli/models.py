"""Which model a command computes with: a built-in arm, a named system, or the reader's own file."""

from __future__ import annotations

from armdrive.config.link_model import Model, is_model_file, read_model
from armdrive.errors import BadRequest
from kinematics import PRESETS
from kinematics.errors import suggestion
from kinematics.textbook.systems import SYSTEMS

MODEL_HELP = (
    f"one of {', '.join(PRESETS)}, a named system of `armdrive explain --list`, or a .toml file "
    "with a link table"
)


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
