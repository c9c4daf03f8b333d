"""Print how fast paths are planned, and how long motions take: `python benchmarks/trajectories.py`.

Three sections: `lines` (dense straight lines, beside the Robotics Toolbox's and pinocchio's ways),
`moves` (durations of joint motions, beside ruckig's) and `chords` (durations of straight lines of
the tip, beside toppra's). All cases of a section are measured in turn in one process; ratios are
what to read. A peer that is missing is named and left out. They come with

    pip install ruckig toppra pin roboticstoolbox-python

best into an environment of their own (`python -m venv`), with this folder's parent on
PYTHONPATH. Nothing here passes or fails.
"""

from __future__ import annotations

import sys

from reporting import report
from trajectories_chords import chords
from trajectories_lines import lines
from trajectories_moves import moves

SECTIONS = {"lines": lines, "moves": moves, "chords": chords}


if __name__ == "__main__":
    sys.exit(report(None, __doc__, SECTIONS))
