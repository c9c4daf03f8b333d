"""Asking the programs that hold arms: the one that is named, or every one of this user's."""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Mapping
from pathlib import Path

from armdrive.cli.presenter import Result
from armdrive.errors import ArmError, BadRequest
from armdrive.storage.lock_client import ask_holder, held_arms


def chosen_holders(options: argparse.Namespace) -> list[str]:
    """Return the arm that the options name; without a name, all that are held."""
    if not (options.arm or options.sim or options.port):
        return held_arms()
    # loads all that drives an arm, which a stop of every arm has no time for
    from armdrive.cli.arm_files import chosen_target

    return [chosen_target(options).config.name]


def one_holder(options: argparse.Namespace) -> str:
    """Return the one arm that is meant. Raises `ArmError` where none is held, or several are."""
    names = chosen_holders(options)
    if len(names) == 1:
        return names[0]
    if not names:
        raise ArmError("no program of yours holds an arm")
    raise ArmError(f"several arms are held ({', '.join(names)}): name one with --arm")


def ask(name: str, request: str, **words: object) -> Mapping[str, object]:
    """Ask a holder. Raises `ArmError` where there is none, or where it says no."""
    answer = ask_holder(name, request, **words)
    if "error" in answer and "state" not in answer:
        raise ArmError(str(answer["error"]))
    return answer


def _ask_all(
    options: argparse.Namespace, request: str, done: str, told: str, **words: object
) -> Result:
    """Ask the chosen holders, and return what came of it.

    `told` is the word under which `--json` counts those that were asked.
    """
    names, failures = chosen_holders(options), []
    for name in names:
        try:
            ask(name, request, **words)
        except ArmError as error:
            failures.append(str(error))
    lines = failures or [f"asked {', '.join(names)} to {done}"]
    if not names:
        lines = [f"no program of yours holds an arm: nothing to {request}"]
    view = {told: len(names) - len(failures), "failures": failures}
    return Result(view, lines, 1 if failures else 0)


def stop(options: argparse.Namespace) -> Result:
    """Ask the holders to stop."""
    return _ask_all(options, "stop", "stop", "stopped")


def pause(options: argparse.Namespace) -> Result:
    """Ask the holders to pause."""
    return _ask_all(options, "pause", "pause; `armdrive resume` lets them go on", "paused")


def resume(options: argparse.Namespace) -> Result:
    """Ask the holders to resume."""
    return _ask_all(options, "resume", "resume", "resumed")


def slow(options: argparse.Namespace) -> Result:
    """Ask the holders to go slower."""
    percent = options.speed * 100.0
    done = f"go at {percent:g}% of its speed"
    return _ask_all(options, "slow", done, "slowed", percent=percent)


def record(options: argparse.Namespace) -> list[Result]:
    """Ask the holders to write, and say which files they wrote."""
    names = chosen_holders(options)
    if not names:
        raise ArmError("no program of yours holds an arm: there is nothing to be written")
    if options.output is not None and len(names) > 1:
        raise BadRequest(f"several arms are held ({', '.join(names)}): name the one for --output")
    files = [_recorded(name) for name in names]
    if options.output is not None:
        files = [Path(shutil.copyfile(files[0], options.output))]
    return [Result({"recording": str(file)}, f"written: {file}") for file in files]


def _recorded(name: str) -> Path:
    answer = ask_holder(name, "record")
    if "recording" not in answer:
        raise ArmError(f"{name} was not recorded: {answer.get('error', 'no reason was given')}")
    return Path(str(answer["recording"]))
