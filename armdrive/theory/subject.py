"""What is studied: a named system of the textbook, a built-in arm, or a link table of one's own."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

from armdrive.errors import BadRequest
from armdrive.modelfile import is_model_file, read_model
from kinematics import PRESETS, ArmGeometry, FiveAxisArm, preset
from kinematics.chain_arm import ChainArm
from kinematics.chains import Chain
from kinematics.near_words import suggestion
from kinematics.own_jacobian import chain_rows, own_rows
from kinematics.systems import SYSTEMS, MiniMover, System
from kinematics.tool_arm import ToolArm


@dataclass(frozen=True, slots=True)
class Subject:
    """An arm as a chain of links, and the named system with closed forms where it is one.

    `rows` number the rows of its Jacobian: `kinematics.own_jacobian.ROW_NAMES` has their names.
    """

    name: str
    title: str
    source: str
    chain: Chain
    system: System | None
    rows: tuple[int, ...]


def subject_names() -> tuple[str, ...]:
    """Return every name that can be studied; .toml files can be too."""
    return tuple(dict.fromkeys((*SYSTEMS, *PRESETS)))


def find_subject(word: str) -> Subject:
    """Return what a name or the path of a model file stands for.

    Raises `BadRequest` for a name that nothing has, with the nearest one, and `ArmFileError` for
    a file that cannot be used.
    """
    if is_model_file(word):
        model = read_model(word)
        return _of_chain(model.name, model.title, model.source, model.chain)
    if word in SYSTEMS:
        found = SYSTEMS[word]
        return _of_system(word, found.title, found)
    if word in PRESETS:
        return _of_system(word, preset(word).title, MiniMover(preset(word).arm))
    names = subject_names()
    raise BadRequest(
        f"no model is named {word!r}{suggestion(word, names)} "
        f"(there are {', '.join(names)}, and .toml files with a link table)"
    )


@lru_cache(maxsize=8)
def subject_of_arm(name: str, arm: ArmGeometry) -> Subject | None:
    """Return the theory of an arm that is driven; None for a build that none is known of.

    Of an arm that holds a tool it is the theory of its finger tips.
    """
    if isinstance(arm, ToolArm):
        return subject_of_arm(f"{name}, without its tool", arm.bare)
    if isinstance(arm, FiveAxisArm):
        return _of_system(name, name, MiniMover(arm))
    if isinstance(arm, ChainArm):
        return _of_chain(name, name, "", arm.chain)
    return None


def _of_system(name: str, title: str, system: System) -> Subject:
    return Subject(name, title, system.source, system.chain(), system, own_rows(system))


def _of_chain(name: str, title: str, source: str, chain: Chain) -> Subject:
    return Subject(name, title, source, chain, None, chain_rows(chain))
