"""Recordings of the flight recorder: in words, and compared with a simulated arm."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from armdrive.cli.presenter import Result
from armdrive.errors import BadRequest
from armdrive.registry import simulated_kind
from armdrive.sim.device import parse_settings
from armdrive.storage.files import recordings
from armdrive.trace.entries import Topic
from armdrive.trace.files import ENDING, read_recording
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


# A recording, replayed on a simulated arm.

PARTED, NOTHING_COMPARED = 1, 2  # exit codes


def replay_recording(options: argparse.Namespace) -> Iterator[Result]:
    """Replay a recording: print its timeline, the first difference, and what was compared."""
    recording = read_recording(options.file)
    dialect = config_of(recording).connection.dialect
    settings = parse_settings(simulated_kind(dialect).settings, options.set)
    replayed = replay(recording, settings)
    yield Result(None, heading(recording))
    if not options.quiet:
        timeline = lines(recording, replayed.divergence)
        yield Result(None, (text for _, text in timeline))
    agreed = 0 if replayed.compared else NOTHING_COMPARED
    code = agreed if replayed.divergence is None else PARTED
    yield Result(replayed_view(recording, replayed), _verdict(replayed), code)


def _verdict(replayed: Replayed) -> Iterator[str]:
    for note in replayed.notes:
        yield f"note: {note}"
    if replayed.late_s > 0.0:
        yield f"note: the simulated arm took {replayed.late_s:.3f} s longer in total"
    if replayed.divergence is not None:
        yield str(replayed.divergence)
    elif not replayed.compared:
        yield "nothing was compared: the recording holds no answer of the arm"
    else:
        compared = counted(replayed.compared, "answer or count", "answers and counts")
        yield f"no difference: {compared} compared"
