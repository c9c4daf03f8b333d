"""`log`: recordings of the flight recorder, in words."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from armdrive.cli.presenter import Result
from armdrive.errors import BadRequest
from armdrive.storage.files import recordings
from armdrive.trace.entries import Topic
from armdrive.trace.files import ENDING, read_recording
from armdrive.trace.log import SEPARATOR, LogFilter, heading, recorded
from kinematics.errors import suggestion


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
