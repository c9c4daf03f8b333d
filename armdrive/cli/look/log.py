"""Read a recording in words: what passed on the wire, what was asked, what came of it."""

from __future__ import annotations

import argparse
from pathlib import Path

from armdrive.cli.presenter import emit, say
from armdrive.errors import BadRequest
from armdrive.storage.files import recordings
from armdrive.trace.entries import Topic
from armdrive.trace.files import ENDING, read_recording
from armdrive.trace.log import BETWEEN, Sieve, heading, recorded
from kinematics.errors import suggestion


def run(options: argparse.Namespace) -> int:
    """Read, sieve, print."""
    sieve = Sieve(_topics(options.only), options.find)
    file = options.file or _newest()
    recording = read_recording(file)
    if not options.json:
        say(f"{file}: {heading(recording)}")
    for line in filter(sieve.passes, recorded(recording)):
        if options.json:
            emit(line.view())
        else:
            say(str(line))
    return 0


def _topics(words: str | None) -> frozenset[Topic]:
    if words is None:
        return frozenset(Topic)
    for word in words.split(BETWEEN):
        if word not in list(Topic):
            near = suggestion(word, list(Topic))
            raise BadRequest(f"there is no topic {word!r}{near}: choose of {', '.join(Topic)}")
    return frozenset(Topic(word) for word in words.split(BETWEEN))


def _newest() -> Path:
    files = sorted(recordings().glob(f"*{ENDING}"), key=lambda path: path.stat().st_mtime_ns)
    if not files:
        raise BadRequest(
            f"there is no recording in {recordings()}: name a file, or have `armdrive record` "
            "write one while an arm is driven"
        )
    return files[-1]
