"""Say everything that is wrong with an arm file at once; nothing is opened and nothing moves."""

from __future__ import annotations

import argparse

from armdrive.cli.arm_files import arm_paths, read
from armdrive.cli.presenter import emit, say
from armdrive.config.check import remarks_on
from armdrive.errors import ArmFileError
from armdrive.registry.arm_files import arm_problems, load_arm
from armdrive.setup.limits import limit_remarks

WRONG = 2


def run(options: argparse.Namespace) -> int:
    """Check each file; 2 where one cannot be used."""
    names = options.arms or [str(path) for path in arm_paths()]
    wrong = [_check(name, options.json) for name in names]
    if not names and not options.json:
        say("no arm files to check; `armdrive config new` writes one")
    return WRONG if any(wrong) else 0


def _check(name: str, json: bool) -> bool:
    remarks: list[str] = []
    try:
        arm = read(name)
    except ArmFileError as error:
        called, problems = name, [str(error)]
    else:
        called = arm.name
        problems = arm_problems(arm.table, arm.name, arm.path.parent)
        if not problems:
            config = load_arm(arm.path)
            remarks += [*remarks_on(config), *limit_remarks(config)]
    if json:
        emit({"arm": called, "ok": not problems, "problems": problems, "remarks": remarks})
        return bool(problems)
    say(f"{called}: " + (f"{len(problems)} to mend" if problems else "fine"))
    for sentence in problems:
        say(f"  ! {sentence}")
    for sentence in remarks:
        say(f"  - {sentence}")
    return bool(problems)
