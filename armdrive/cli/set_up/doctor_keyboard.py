"""`armdrive doctor --keyboard`: hold a key, and hear whether holding will work here."""

from __future__ import annotations

import dataclasses
import os
import sys

from armdrive.cli.presenter import emit, put_error, say, say_lines
from armdrive.errors import OperatorNeeded
from armdrive.setup.keyboard import Examined, examine, raw_terminal, sentence

WORKS, WORKS_NOT = 0, 1


def run(as_json: bool) -> int:
    """Examine the keyboard at this terminal; touches no port. 1 where holding does not work."""
    if not (sys.stdin.isatty() and sys.stdout.isatty()):
        raise OperatorNeeded(
            "somebody has to hold a key at a terminal: run `armdrive doctor --keyboard` there"
        )
    with raw_terminal() as terminal:
        found = examine(terminal, os.environ, _whisper if as_json else say)
    if as_json:
        emit(_view(found))
    else:
        say_lines("\n".join(_lines(found)))
    return WORKS if found.works else WORKS_NOT


def _whisper(text: str) -> None:
    """Tell the person, and leave the output to the document."""
    put_error(f"{text}\n")


def _lines(found: Examined) -> list[str]:
    releases = "can" if found.releases else "cannot"
    focus = {True: "can", False: "cannot", None: "did not say whether it can"}[found.focus]
    where = [word for word, here in (("tmux", found.tmux), ("screen", found.screen)) if here]
    where += ["a remote shell"] * found.remote
    place = f" (in {', '.join(where)})" if where else ""
    terminal = (
        f"Terminal{place}: it {releases} tell that a key is let go; it {focus} tell when its "
        "window loses the focus."
    )
    return [
        f"Held key: {sentence(found.press)}.",
        terminal,
        *(f"- {remedy}." for remedy in found.remedies),
        f"Verdict: {found.verdict}.",
    ]


def _view(found: Examined) -> dict[str, object]:
    press = dataclasses.asdict(found.press) | {"rate_hz": found.press.rate_hz}
    return {
        "held": press,
        "focus_events": found.focus,
        "key_releases": found.releases,
        "tmux": found.tmux,
        "screen": found.screen,
        "remote": found.remote,
        "works": found.works,
        "verdict": found.verdict,
        "remedies": found.remedies,
    }
