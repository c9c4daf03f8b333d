"""The program that an arm keeps in its own memory, for its pendant: into a file, and back.

Nothing moves. A file can be read, compared and edited; every row comes back word for word.

Examples:
  armdrive pendant show                              what is in the arm, row by row
  armdrive pendant read monday.pendant               into a file
  armdrive pendant write monday.pendant              back, and read once more to be sure
  armdrive pendant write monday.pendant --shift      after the arm was homed anew
  armdrive pendant points monday.pendant stack       as points and a sequence `stack`
  armdrive pendant make stack stack.pendant          and a sequence as rows for the pendant

Every action prints JSON with --json.

"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from armdrive.cli.arm_options import add_allow_restored, add_arm_options
from armdrive.cli.chosen_arm import connect_chosen
from armdrive.cli.pendant_files import from_file, into_file, require_free, text_of
from armdrive.cli.pendant_points import make_points, make_rows
from armdrive.cli.presenter import emit, put_error, say, say_lines, say_which
from armdrive.cli.terminal_person import agreed, settle_trust
from armdrive.errors import OperatorNeeded
from armdrive.status import Trust

if TYPE_CHECKING:
    from armdrive.arm import Arm
    from armdrive.config.arm import ArmConfig
    from armdrive.dialects.teachmover.pendant import PendantProgram

Deed = Callable[[argparse.Namespace], int]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the actions, each with its own options."""
    actions = parser.add_subparsers(dest="action", required=True, metavar="ACTION")
    for name, (_, words, summary) in ACTIONS.items():
        action = actions.add_parser(name, help=summary, description=summary)
        for word in words:
            action.add_argument(word, metavar=word.upper())
        if name in ("read", "make"):
            action.add_argument("--force", action="store_true", help="overwrite another file")
        if name == "write":
            _add_write_options(action)
        if name == "points":
            action.add_argument("--again", action="store_true", help="write over what is there")
        else:
            add_allow_restored(action)
        add_arm_options(action)


def _add_write_options(action: argparse.ArgumentParser) -> None:
    action.add_argument("--yes", action="store_true", help="do not ask before writing")
    action.add_argument(
        "--leave-others", action="store_true", help="let rows stay that the file does not have"
    )
    meant = action.add_mutually_exclusive_group()
    meant.add_argument("--shift", action="store_true", help="so that rows lead where they led")
    meant.add_argument("--as-is", action="store_true", help="the numbers, wherever they lead now")


def run(options: argparse.Namespace) -> int:
    """Do what was asked for."""
    deed, _, _ = ACTIONS[options.action]
    return deed(options)


def _read_from(options: argparse.Namespace) -> tuple[ArmConfig, PendantProgram]:
    with _connected(options) as arm:
        return arm.config, arm.read_pendant_program()


def _connected(options: argparse.Namespace) -> Arm:
    arm = connect_chosen(options, allow_restored=options.allow_restored)
    try:
        if not options.json:
            say_which(arm.status)
        settle_trust(arm)
    except BaseException:
        arm.close()
        raise
    return arm


def _show(options: argparse.Namespace) -> int:
    config, program = _read_from(options)
    if options.json:
        emit(_view(config, program))
    else:
        say_lines(text_of(config, program).rstrip("\n"))
    return 0


def _read(options: argparse.Namespace) -> int:
    path = Path(options.file)
    require_free(path, force=options.force)
    config, program = _read_from(options)
    into_file(path, config, program)
    if options.json:
        emit({"file": str(path), **_view(config, program)})
    else:
        say(f"{len(program.rows)} rows are in {path} now")
    return 0


def _make(options: argparse.Namespace) -> int:
    require_free(Path(options.file), force=options.force)
    with _connected(options) as arm:
        return make_rows(options, arm)


def _write(options: argparse.Namespace) -> int:
    program = from_file(Path(options.file))
    with _connected(options) as arm:
        if options.as_is:
            program = program.without_origin()
        if options.shift:
            program = program.moved_to(arm.read_pendant_program().origin)
        count = len(program.rows)
        if not options.yes and (options.json or not agreed(_question(arm, program))):
            raise OperatorNeeded("not confirmed, nothing was written: say --yes to write unasked")
        written = _written(arm, program, leave_others=options.leave_others)
    if options.json:
        emit({"rows": count, "written": written})
    else:
        say(f"{count} rows are in the arm: {written} written, and all read back as they should")
    return 0


def _question(arm: Arm, program: PendantProgram) -> str:
    known = arm.status.trust in (Trust.REFERENCED, Trust.RESTORED)
    if program.origin is not None and not known:
        say("Nobody has homed this arm: its rows may lead elsewhere than when they were read.")
    return (
        f"Write {len(program.rows)} rows into the memory of {arm.status.arm}? Nothing moves. yes: "
    )


def _written(arm: Arm, program: PendantProgram, *, leave_others: bool) -> int:
    """Write, and say which rows are in the arm where somebody interrupts it."""
    done: list[int] = []
    try:
        return arm.write_pendant_program(program, leave_others=leave_others, told=done.append)
    except Exception:
        raise  # its own words name the rows
    except BaseException:
        from armdrive.motion.device import named_rows

        new = f"{named_rows(done)} new in the arm" if done else "nothing new in the arm"
        put_error(f"{new}; the next one perhaps, the others as before\n")
        raise


def _view(config: ArmConfig, program: PendantProgram) -> dict[str, Any]:
    from armdrive.dialects.teachmover.pendant import place_of
    from armdrive.status import joints_view

    rows = []
    for row in program.rows:
        place = place_of(config, program, row)
        rows.append(
            {
                "row": row.number,
                "words": list(row.words),
                "joints": None if place is None else joints_view(place.joints),
                "gripper_mm": None if place is None else round(place.opening_mm, 3),
            }
        )
    return {"origin": program.origin, "rows": rows}


ACTIONS: Mapping[str, tuple[Deed, tuple[str, ...], str]] = MappingProxyType(
    {
        "show": (_show, (), "print the program in the arm, row by row"),
        "read": (_read, ("file",), "read the program out of the arm into a file"),
        "write": (_write, ("file",), "write a file's rows into the arm, and read them back"),
        "points": (make_points, ("file", "name"), "make points and a sequence of a file's rows"),
        "make": (_make, ("name", "file"), "make a file of rows of a taught sequence"),
    }
)
"""Every action: what does it, the names that it wants, and its line of help."""
