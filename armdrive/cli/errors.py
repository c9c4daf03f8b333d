"""Look an error up: `armdrive errors E502`; without a code, all of them in a list.

The code stands in brackets before the sentence of every error.
"""

from __future__ import annotations

import argparse
from dataclasses import asdict

from armdrive.catalogue import ENTRIES, by_code
from armdrive.catalogue.printing import in_full, listing, page
from armdrive.cli.choosing import add_json_option
from armdrive.cli.output import emit, say


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("code", nargs="?", metavar="CODE", help="the code of one error, E502 say")
    parser.add_argument("--markdown", action="store_true", help="print the page of the docs")
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Print the catalogue or a part of it."""
    rows = ENTRIES if options.code is None else (by_code(options.code),)
    if options.json:
        for row in rows:
            emit(asdict(row))
    elif options.markdown:
        say(page().rstrip("\n"))
    else:
        for line in listing() if options.code is None else in_full(rows[0]):
            say(line)
    return 0
