"""Look an error up: `armdrive errors E502`, or `--find WORDS`; without either, list all."""

from __future__ import annotations

import argparse
import shutil
import sys
import textwrap
from collections.abc import Iterator
from dataclasses import asdict

from armdrive.cli.presenter import Outcome, Result, as_json, put
from armdrive.errors.actions import COMMAND_LINE, presented
from armdrive.errors.table import (
    ENTRIES,
    INDENT,
    CatalogueEntry,
    by_code,
    found,
    in_full,
    listing,
    page,
)


def errors(options: argparse.Namespace) -> Outcome:
    """Print the catalogue or a part of it."""
    rows = ENTRIES if options.code is None else (by_code(options.code),)
    if options.find is not None:
        rows = tuple(row for row in found(options.find) if row in rows)
    if as_json(options):
        return [Result(asdict(row)) for row in rows]
    if options.markdown:
        put(page())  # for all interfaces, so without the words of the command line
        return 0
    if options.code is None and options.find is None:
        return Result(None, listing())
    return Result(None, _in_full(rows))


def _in_full(rows: tuple[CatalogueEntry, ...]) -> Iterator[str]:
    """Yield the lines of rows; a terminal gets them folded to its width."""
    width = shutil.get_terminal_size().columns - 1 if sys.stdout.isatty() else sys.maxsize
    for row in rows:
        for line in in_full(row):
            text = presented(line, COMMAND_LINE)  # before it is folded: words may span a fold
            yield from textwrap.wrap(
                text, width, subsequent_indent=" " * INDENT, break_on_hyphens=False
            )
    if not rows:
        yield "no error has these words; `armdrive errors` lists them all"
