"""Chains and named systems whose numbers are symbols: the same code, seen as formulas.

Lengths become names (d1, a2), and so do joint variables: a joint that is not named as a symbol
already becomes theta or d with its number, as in the notes. Lengths that are zero stay zero, and
constant angles stay numbers, so that what the notes leave out is left out here too.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from kinematics.chains.chain import Chain
from kinematics.chains.links import JointKind
from kinematics.textbook.notation import GREEK
from kinematics.textbook.symbols import coordinate, named
from kinematics.textbook.systems.named import System

_SYMBOL = re.compile(rf"(?:[a-z]|{'|'.join(sorted(GREEK))})_?\d*")


def joint_symbols(chain: Chain) -> tuple[Any, ...]:
    """Return a symbol for each joint's value: its own name, or theta and d with its number."""
    if all(_SYMBOL.fullmatch(name) for name in chain.joint_names):
        return tuple(map(named, chain.joint_names))
    return tuple(
        named(f"{'theta' if kind is JointKind.REVOLUTE else 'd'}{number}")
        for number, kind in enumerate(chain.kinds, 1)
    )


def symbolic_chain(chain: Chain) -> Chain:
    """Return the chain with its constant lengths as names: d1, a2 and so on.

    A revolute joint's distance is d with the link's number, a prismatic one's constant part D.
    In Craig's convention the length in a row is the one of the link before, and numbered so.
    """
    shift = 0 if chain.convention.value == "standard" else 1
    links = tuple(
        replace(
            link,
            a_mm=_name(link.a_mm, f"a{number - shift}"),
            d_mm=_name(
                link.d_mm, f"d{number}" if link.kind is JointKind.REVOLUTE else f"D{number}"
            ),
        )
        for number, link in enumerate(chain.links, 1)
    )
    return replace(chain, links=links)


def symbolic_system(system: System) -> System:
    """Return the system with its lengths as the names that its figure and derivation use."""
    names = map(_name, system.sizes, system.length_names)
    return replace(system, sizes=tuple(names))


def symbolic_goal(coordinates: Sequence[str]) -> tuple[Any, ...]:
    """Return the coordinates of a goal as symbols, their units left out: x, y, phi."""
    return tuple(coordinate(name.rpartition("_")[0] or name) for name in coordinates)


def _name(value: float, name: str) -> Any:
    return named(name) if value != 0.0 else 0.0
