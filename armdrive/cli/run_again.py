"""The commands that take an interrupted program up: on the same arm, no faster than before."""

from __future__ import annotations

import argparse
import shlex


def resume_command(options: argparse.Namespace) -> str:
    """Return the command that takes this run up again, as carefully as it was begun."""
    words = ["armdrive", "run", str(options.program), *_which(options), *_how(options)]
    return shlex.join([*words, "--resume"])


def move_command(options: argparse.Namespace) -> str:
    """Return the beginning of a command that moves the arm of this run."""
    speed = [] if options.speed is None else ["--speed", f"{options.speed / 100.0:g}"]
    return shlex.join(["armdrive", "move", *_which(options), *speed])


def _which(options: argparse.Namespace) -> list[str]:
    words = _given(options, "arm", "sim", "port", "dialect", "baud")
    return words + ["--allow-restored"] * options.allow_restored


def _how(options: argparse.Namespace) -> list[str]:
    words = _given(options, "speed", "pace", "assume_width")
    for number, on in options.input:
        words += ["--input", f"{number}={'on' if on else 'off'}"]
    return words + ["--step"] * options.step  # --yes is for a person to say anew


def _given(options: argparse.Namespace, *names: str) -> list[str]:
    words = []
    for name in names:
        value = getattr(options, name)
        if value is not None:
            words += [f"--{name.replace('_', '-')}", _text(value)]
    return words


def _text(value: str | float) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
