"""Recordings of the flight recorder: read them in words, or replay them on a simulated arm."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

from armdrive.cli.presenter import Result
from armdrive.errors import BadRequest
from armdrive.registry import simulated_kind
from armdrive.sim.device import parse_settings
from armdrive.storage.files import recordings
from armdrive.trace.entries import Topic
from armdrive.trace.files import ENDING, Recording, read_recording
from armdrive.trace.log import SEPARATOR, LogFilter, heading, lines, recorded
from armdrive.trace.replay import Replayed, config_of, replay, replayed_view
from kinematics.errors import suggestion
from kinematics.text import counted


def log(options: argparse.Namespace) -> Iterator[Result]:
    """Print a recording in words: bytes, requests, results."""
    log_filter = LogFilter(_topics(options.only), options.find)
    file = options.file or _newest()
    recording = read_recording(file)
    yield Result(None, f"{file}: {heading(recording)}")
    for line in filter(log_filter.passes, recorded(recording)):
        yield Result(line.view(), str(line))


def _topics(words: str | None) -> frozenset[Topic]:
    if words is None:
        return frozenset(Topic)
    for word in words.split(SEPARATOR):
        if word not in list(Topic):
            near = suggestion(word, list(Topic))
            raise BadRequest(f"there is no topic {word!r}{near}; the topics are {', '.join(Topic)}")
    return frozenset(Topic(word) for word in words.split(SEPARATOR))


def _newest() -> Path:
    # by time: names begin with the arm's, and several arms share the folder
    files = sorted(recordings().glob(f"*{ENDING}"), key=lambda path: path.stat().st_mtime_ns)
    if not files:
        raise BadRequest(
            f"there is no recording in {recordings()}: name a file, or run `armdrive record` while "
            "another program drives an arm"
        )
    return files[-1]


# Replaying on a simulated arm: where do the two differ?

PARTED = 1


def replay_recording(options: argparse.Namespace) -> Iterator[Result]:
    """Replay a recording, or with --show only print it."""
    recording = read_recording(options.file)
    replayed = None if options.show else _replayed(recording, options.set)
    yield Result(None, heading(recording))
    if not options.quiet:
        parting = None if replayed is None else replayed.divergence
        yield Result(None, _in_time(lines(recording, parting), options.pace))
    if replayed is None:
        yield from (Result(line.view()) for line in recorded(recording))
    else:
        code = 0 if replayed.divergence is None else PARTED
        yield Result(replayed_view(recording, replayed), _verdict(replayed), code)


def _replayed(recording: Recording, words: list[str]) -> Replayed:
    dialect = config_of(recording).connection.dialect
    return replay(recording, parse_settings(simulated_kind(dialect).settings, words))


def _in_time(timed: Iterable[tuple[float, str]], pace: float | None) -> Iterator[str]:
    """Yield the lines of a timeline; with a pace, that many times as fast as they happened."""
    before_s = None
    for time_s, text in timed:
        if pace is not None and before_s is not None and time_s > before_s:
            time.sleep((time_s - before_s) / pace)
        before_s = time_s
        yield text


def _verdict(replayed: Replayed) -> Iterator[str]:
    for note in replayed.notes:
        yield f"note: {note}"
    if replayed.late_s > 0.0:
        yield f"note: the simulated arm took {replayed.late_s:.3f} s longer in total"
    if replayed.divergence is None:
        yield (
            "no difference: "
            f"{counted(replayed.compared, 'answer or count', 'answers and counts')} compared"
        )
    else:
        yield str(replayed.divergence)
