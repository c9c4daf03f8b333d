"""Stop an arm that another program of yours drives; without a name, every one of them."""

from __future__ import annotations

import argparse

from armdrive.cli.choosing import add_arm_options, chosen_target
from armdrive.cli.output import emit, say
from armdrive.errors import ArmError


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_arm_options(parser)


def run(options: argparse.Namespace) -> int:
    """Ask the holders to stop."""
    from armdrive.holder import ask_holder, held_arms

    named = options.arm or options.sim or options.port
    names = [chosen_target(options).config.name] if named else held_arms()
    failures = []
    for name in names:
        try:
            ask_holder(name, "stop")
        except ArmError as error:
            failures.append(str(error))
    if options.json:
        emit({"stopped": len(names) - len(failures), "failures": failures})
    elif not names:
        say("no program of yours holds an arm: nothing to stop")
    else:
        for text in failures or [f"asked {', '.join(names)} to stop"]:
            say(text)
    return 1 if failures else 0
