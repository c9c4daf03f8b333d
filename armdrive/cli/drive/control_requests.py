"""Requests to programs that drive arms: the named one, or every one of this user."""

from __future__ import annotations

import argparse

from armdrive.cli.holders import ask, chosen_holders
from armdrive.cli.presenter import Result
from armdrive.errors import ArmError, HolderError
from armdrive.storage.lock_client import ask_holder


def _ask_all(
    options: argparse.Namespace, request: str, done: str, key: str, **words: object
) -> Result:
    """Send a request to the chosen programs; `key` is its count of successes in the JSON."""
    names, failures = chosen_holders(options), []
    for name in names:
        try:
            ask(name, request, **words)
        except ArmError as error:
            failures.append(str(error))
    lines = failures or [f"asked {', '.join(names)} to {done}"]
    if not names:
        lines = [f"no program of yours is driving an arm: there is nothing to {request}"]
    view = {key: len(names) - len(failures), "failures": failures}
    return Result(view, lines, 1 if failures else 0)


def stop(options: argparse.Namespace) -> Result:
    """Stop the chosen arms."""
    return _ask_all(options, "stop", "stop", "stopped")


def pause(options: argparse.Namespace) -> Result:
    """Pause the chosen arms."""
    return _ask_all(options, "pause", "pause; `armdrive resume` continues", "paused")


def resume(options: argparse.Namespace) -> Result:
    """Let the chosen arms go on."""
    return _ask_all(options, "resume", "resume", "resumed")


def slow(options: argparse.Namespace) -> Result:
    """Slow the chosen arms down."""
    percent = options.speed * 100.0
    done = f"go at {percent:g}% of its speed"
    return _ask_all(options, "slow", done, "slowed", percent=percent)


def record(options: argparse.Namespace) -> list[Result]:
    """Make the chosen arms record, and return the files."""
    names = chosen_holders(options)
    if not names:
        raise HolderError("no program of yours is driving an arm: there is nothing to record")
    files = [_recorded(name) for name in names]
    return [Result({"recording": file}, f"saved {file}") for file in files]


def _recorded(name: str) -> str:
    answer = ask_holder(name, "record")
    if "recording" not in answer:
        raise HolderError(f"{name} was not recorded: {answer.get('error', 'without a reason')}")
    return str(answer["recording"])
