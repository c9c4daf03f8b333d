"""Choose the arm that commands use where none is named."""

from __future__ import annotations

import argparse

from armdrive.cli.arm_files import SIM, choose_default, default_arm, path_of
from armdrive.cli.presenter import emit, say
from armdrive.errors import BadRequest
from armdrive.registry import dialect
from armdrive.registry.arm_files import load_arm


def run(options: argparse.Namespace) -> int:
    """Remember the name."""
    if (options.name is None) != options.none:
        raise BadRequest("give the name of an arm, or --none")
    if options.name is not None:
        _check(options.name)
    choose_default(options.name)
    used = default_arm()
    if options.json:
        emit({"default": used})
    else:
        say(f"commands that name no arm use {used}")
        if options.name not in (None, used):
            say("ARMDRIVE_ARM is set and goes before it")
    return 0


def _check(name: str) -> None:
    """Raise for what is no usable arm."""
    if name.startswith(SIM):
        dialect(name.removeprefix(SIM))
        return
    if name.endswith(".toml"):
        raise BadRequest(f"the name of an arm file, not its path: {name!r}")

    load_arm(path_of(name))
