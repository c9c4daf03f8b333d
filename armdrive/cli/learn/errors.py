"""Look an error up: `armdrive errors E502`, or `--find WORDS`; without either, all in a list."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from armdrive.cli.presenter import emit, put, say
from armdrive.errors.printing import in_full, listing, page
from armdrive.errors.table import ENTRIES, CatalogueEntry, by_code, found


def run(options: argparse.Namespace) -> int:
    """Print the catalogue or a part of it."""
    rows = ENTRIES if options.code is None else (by_code(options.code),)
    if options.find is not None:
        rows = tuple(row for row in found(options.find) if row in rows)
    if options.json:
        for row in rows:
            emit(asdict(row))
    elif options.markdown:
        put(page())
    elif options.code is None and options.find is None:
        for line in listing():
            say(line)
    else:
        _print_in_full(rows)
    return 0


def _print_in_full(rows: tuple[CatalogueEntry, ...]) -> None:
    for row in rows:
        for line in in_full(row):
            say(line)
    if not rows:
        say("no error has these words; `armdrive errors` lists them all")
