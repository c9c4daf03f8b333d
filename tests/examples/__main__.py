"""Run every example whole on the arm of every dialect, and write the table about them.

    python -m tests.examples
    python -m tests.examples --write docs/how-to/examples.md

Exit code 1 where the world is not as it should be afterwards.
"""

import argparse
import os
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from armdrive.registry import DIALECTS

from . import worlds
from .examples_table import EXAMPLES, cell, table, with_table
from .on_arms import Example, run_example


def tried(example: Example, dialect: str) -> tuple[str, list[str]]:
    """Run an example whole; return what the table says of it, and what was wrong."""
    if said := example.against(dialect):
        return said, []
    ran = run_example(example, example.whole, dialect)
    wrong = worlds.incidents(ran) + example.wrong(ran, example.whole.size)
    return (f"**no**: {wrong[0]}" if wrong else cell(example, example.whole, ran)), wrong


def main(words: Sequence[str] | None = None) -> int:
    """Run them all, print what came of it, and write the table if that is asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.examples", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("--write", metavar="PAGE", type=Path, help="write its table as well")
    chosen = parser.parse_args(words)
    cells, broken = {}, 0
    with tempfile.TemporaryDirectory(prefix="armdrive-") as home:
        os.environ["ARMDRIVE_HOME"] = home
        for example in EXAMPLES.values():
            for dialect in DIALECTS:
                said, wrong = tried(example, dialect)
                cells[example.file, dialect] = said
                broken += bool(wrong)
                sys.stdout.write(f"{example.file}, {dialect}: {said}\n")
    if chosen.write is not None:
        before = chosen.write.read_text(encoding="utf-8")
        made = table(list(EXAMPLES.values()), cells)
        chosen.write.write_text(with_table(before, made), encoding="utf-8")
    return int(broken > 0)


if __name__ == "__main__":
    sys.exit(main())
