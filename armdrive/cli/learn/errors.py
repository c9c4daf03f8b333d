"""Look an error up: `armdrive errors E502`, or `--find WORDS`; without either, list all."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import asdict

from armdrive.cli.presenter import Outcome, Result, as_json
from armdrive.errors import BadRequest
from armdrive.errors.table import (
    ENTRIES,
    CatalogueEntry,
    by_code,
    found,
    in_full,
    listing,
)
from kinematics.errors import nearest_word


def errors(options: argparse.Namespace) -> Outcome:
    """Print the catalogue or a part of it."""
    rows = ENTRIES if options.code is None else (_row(options.code),)
    if options.find is not None:
        rows = tuple(row for row in found(options.find) if row in rows)
    if as_json(options):
        return [Result(asdict(row)) for row in rows]
    if options.code is None and options.find is None:
        return Result(None, listing())
    return Result(None, _in_full(rows))


def _row(code: str) -> CatalogueEntry:
    """Return the row of a code. Raises `BadRequest` with the nearest one."""
    row = by_code(code)
    if row is None:
        near = nearest_word(code.upper(), (each.code for each in ENTRIES))
        hint = "" if near is None else f"did you mean {near}? "
        raise BadRequest(f"there is no error {code!r}; {hint}`armdrive errors` lists them all")
    return row


def _in_full(rows: tuple[CatalogueEntry, ...]) -> Iterator[str]:
    for row in rows:
        yield from in_full(row)
    if not rows:
        yield "no error contains these words; `armdrive errors` lists them all"
