"""Replay a flight recorder's file against a simulated twin, offline, and show where they part."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable

from armdrive.cli.presenter import emit, say
from armdrive.registry import simulated_kind
from armdrive.sim.device import Options
from armdrive.trace.files import Recording, read_recording
from armdrive.trace.log import Narrator, heading, lines
from armdrive.trace.replay import Replayed, config_of, replay, replayed_view

PARTED = 1


def run(options: argparse.Namespace) -> int:
    """Read, replay, print."""
    recording = read_recording(options.file)
    replayed = None if options.show else _replayed(recording, options.set)
    if options.json:
        _print_json(recording, replayed)
    else:
        _print(recording, replayed, options)
    return PARTED if replayed is not None and replayed.parting is not None else 0


def _replayed(recording: Recording, words: list[str]) -> Replayed:
    dialect = config_of(recording).connection.dialect
    return replay(recording, Options.parse(simulated_kind(dialect).options, words))


def _print_json(recording: Recording, replayed: Replayed | None) -> None:
    if replayed is not None:
        emit(replayed_view(recording, replayed))
        return
    narrator = Narrator(recording.header.dialect)
    for entry in recording.entries:
        emit(narrator.view(entry))


def _print(recording: Recording, replayed: Replayed | None, options: argparse.Namespace) -> None:
    say(heading(recording))
    parting = None if replayed is None else replayed.parting
    if not options.quiet:
        _print_timeline(lines(recording, parting), options.speed)
    if replayed is None:
        return
    for note in replayed.notes:
        say(f"note: {note}")
    if replayed.late_s > 0.0:
        say(f"note: the twin took {replayed.late_s:.3f} s longer than the arm, all in all")
    if parting is None:
        say(f"the twin answered as the arm did: {replayed.compared} answers and counts compared")
    else:
        say(str(parting))


def _print_timeline(timed: Iterable[tuple[float, str]], speed: float | None) -> None:
    before_s = None
    for time_s, text in timed:
        if speed is not None and before_s is not None and time_s > before_s:
            time.sleep((time_s - before_s) / speed)
        before_s = time_s
        say(text)
