"""The programs that hold arms: which of them the options of a command mean, and asking one.

A program may hold an arm under the arm's name, or under the name of its port alone. Every command
that looks for a program looks under both.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping

from armdrive.cli.options import names_arm
from armdrive.errors import BadRequest, HolderError
from armdrive.storage.lock_client import ask_holder, held_arms, name_held


def chosen_holders(options: argparse.Namespace) -> list[str]:
    """Return the arm that the options name, or else every arm that a program is driving."""
    return [held_name(options)] if names_arm(options) else held_arms()


def held_name(options: argparse.Namespace) -> str:
    """Return the name by which a program holds the chosen arm; the arm's own if none holds it."""
    # loads everything that drives an arm; `armdrive stop` without a name does not wait for that
    from armdrive.cli.arm_files import chosen_target
    from armdrive.connect.port import lock_names

    target = chosen_target(options)
    return name_held(*([target.config.name] if target.simulated else lock_names(target.config)))


def one_holder(options: argparse.Namespace) -> str:
    """Return the one arm that is being driven.

    Raises `HolderError` if there is none, and `BadRequest` if there are several.
    """
    names = chosen_holders(options)
    if len(names) == 1:
        return names[0]
    if not names:
        raise HolderError(
            "no program of yours is driving an arm: start one in another terminal, such as "
            "`armdrive jog`"
        )
    raise BadRequest(f"several arms are being driven ({', '.join(names)}): name one with --arm")


def ask(name: str, request: str, **words: object) -> Mapping[str, object]:
    """Send a request to the program that drives an arm. Raises `HolderError` if it refuses."""
    answer = ask_holder(name, request, **words)
    if "error" in answer and "state" not in answer:
        raise HolderError(str(answer["error"]))
    return answer
