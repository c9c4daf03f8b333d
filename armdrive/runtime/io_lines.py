"""Inputs and outputs by their numbers: which there are on an arm, and the bits that they are."""

from __future__ import annotations

from collections.abc import Iterable

from armdrive.abilities import OUTPUTS
from armdrive.errors import BadRequest, Refused
from armdrive.runtime.arm_state import Core

Lines = int | Iterable[int]
"""One input or output, or several, counted from 1."""


def output_bits(lines: Lines) -> int:
    """Return the bits of outputs. Raises `BadRequest` for numbers that no output has."""
    return _bits(lines, "outputs", OUTPUTS)


def input_bits(core: Core, lines: Lines) -> int:
    """Return the bits of an arm's inputs.

    Raises `BadRequest` for numbers that it has not, and `Refused` where it has no inputs: whoever
    waited for one would wait for ever.
    """
    most = core.controller.abilities.inputs
    if not most:
        raise Refused(
            f"the controller of the {core.config.title} tells no inputs: nothing can be read there "
            "or waited for"
        )
    return _bits(lines, f"the inputs of the {core.config.title}", most)


def _bits(lines: Lines, what: str, most: int) -> int:
    bits = 0
    for number in [lines] if isinstance(lines, int) else lines:
        whole = isinstance(number, int) and not isinstance(number, bool)
        if not whole or not 1 <= number <= most:
            raise BadRequest(f"{what} are counted from 1 to {most}, not {number!r}")
        bits |= 1 << number - 1
    return bits
