"""The command line: finds the command in the table and runs it. A command loads only what it needs.

    commands           every command with its description and module; the exit codes
    options            parsers made from the text of `--help`, which stands in docstrings of the
                       `arguments` beside each group of commands; options that commands share
    runner             runs one command: imports its module; signals, one-line errors, the exit
                       code
    presenter          printing, JSON or text, and reading a line
    arm_files          which arm `--arm` and the default name
    chosen_arm         a connection to it; the saved world of a simulated one
    holders            the programs that hold arms: which are meant, and asking one
    questions          questions in a terminal; `terminal_operator` asks those of `home`
    unexpected         an internal error
    drive/, program/, set_up/, look/, learn/   the commands

Nothing heavy is imported on the way to `armdrive --help`.
"""

from __future__ import annotations

import sys

from armdrive.cli.commands import EXIT_CODES, EXIT_CODES_TOPIC, GROUPS, ROWS

TYPE_CHECKING = False  # as typing's, which is slow to import
if TYPE_CHECKING:
    from collections.abc import Sequence

HELP = "help"


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code."""
    words = list(sys.argv[1:] if argv is None else argv)
    if words[:1] == [HELP]:  # `help points go` is `points go --help`
        if words[1:] == [EXIT_CODES_TOPIC]:
            return _print(_exit_codes())
        words = [*words[1:], "--help"]
    word = words[0] if words else "--help"
    if word in ("-h", "--help"):
        return _print(_help())
    if word == "--version":
        from importlib.metadata import version

        return _print(f"armdrive {version('armdrive')}\n")
    from armdrive.cli.runner import refuse, run_command

    if word not in ROWS:
        return refuse(words)
    function, _ = ROWS[word]
    return run_command(word, function, words[1:])


def _print(text: str) -> int:
    """Print a text and return the exit code."""
    if sys.stdout is None:  # closed, as with `>&-`
        return 0
    try:
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        from armdrive.cli.runner import report_output

        return report_output(error)
    return 0


# Widths of a name and of its few words. Two commands stand side by side, so that all of them fit
# on a screen of 80 by 24.
_COLUMNS = ((9, 27), (11, 24))


def _help() -> str:
    """Return the help of the whole, made from the table above.

    Written out here because argparse alone would take longer than everything else on this path.
    """
    lines = []
    for group, rows in GROUPS.items():
        cells = []
        for at, (name, (_, brief)) in enumerate(rows.items()):
            name_width, brief_width = _COLUMNS[at % 2]
            cells.append(f"{name:<{name_width}}{brief:<{brief_width}}")
        labels = [group, *[""] * len(cells)]
        lines += [
            f"{label:<8}{left}{right}".rstrip()
            for label, left, right in zip(labels, cells[::2], [*cells[1::2], ""], strict=False)
        ]
    table = "\n".join(lines)
    return (
        "usage: armdrive COMMAND [OPTIONS]\n\n"
        f"{table}\n\n"
        "`armdrive help COMMAND` shows options and examples, `armdrive help exit-codes`\n"
        "the exit codes, and `armdrive --version` the version.\n"
        "Without --arm, --sim or --port, a command uses the simulated TeachMover.\n"
    )


def _exit_codes() -> str:
    lines = "".join(f"  {code:<5}{text}\n" for code, text in EXIT_CODES.items())
    return f"Every command ends with one of these exit codes:\n\n{lines}"
