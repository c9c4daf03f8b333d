"""Look an error up: `armdrive errors E502`; without a code, list all."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from armdrive.cli.presenter import Outcome, Result, as_json
from armdrive.errors import BadRequest
from armdrive.errors.table import ENTRIES, by_code, in_full, listing
from kinematics.errors import nearest_word


def errors(options: argparse.Namespace) -> Outcome:
    """Print the catalogue, or one row of it."""
    if options.code is None:
        if as_json(options):
            return [Result(asdict(each)) for each in ENTRIES]
        return Result(None, listing())
    row = by_code(options.code)
    if row is None:
        near = nearest_word(options.code.upper(), (each.code for each in ENTRIES))
        hint = "" if near is None else f"did you mean {near}? "
        raise BadRequest(
            f"there is no error {options.code!r}; {hint}`armdrive errors` lists them all"
        )
    return Result(asdict(row), in_full(row))
