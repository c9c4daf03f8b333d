"""Look an error up: `armdrive errors E502`, or `--find WORDS`; without either, list all."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import asdict

from armdrive.cli.presenter import Outcome, Result, as_json
from armdrive.errors.table import (
    ENTRIES,
    CatalogueEntry,
    by_code,
    found,
    in_full,
    listing,
)


def errors(options: argparse.Namespace) -> Outcome:
    """Print the catalogue or a part of it."""
    rows = ENTRIES if options.code is None else (by_code(options.code),)
    if options.find is not None:
        rows = tuple(row for row in found(options.find) if row in rows)
    if as_json(options):
        return [Result(asdict(row)) for row in rows]
    if options.code is None and options.find is None:
        return Result(None, listing())
    return Result(None, _in_full(rows))


def _in_full(rows: tuple[CatalogueEntry, ...]) -> Iterator[str]:
    for row in rows:
        yield from in_full(row)
    if not rows:
        yield "no error contains these words; `armdrive errors` lists them all"
