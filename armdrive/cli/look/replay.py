"""`replay`: a recording, compared with a simulated arm.

In a file of its own, because it loads the simulation, which `log` does without.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from armdrive.cli.presenter import Result
from armdrive.registry import simulated_kind
from armdrive.sim.device import parse_settings
from armdrive.trace.files import read_recording
from armdrive.trace.log import heading, lines
from armdrive.trace.replay import Replayed, config_of, replay, replayed_view
from kinematics.text import counted

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
