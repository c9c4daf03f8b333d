"""Rows of the table of keys for watching an arm that another program drives."""

from __future__ import annotations

from tui.key_row import DeskKey

WATCH_KEYS = (
    DeskKey("watch-pause", ("p",), "ask('pause')", "pause",
            "Have the arm wait behind what is under way; it goes on when it is resumed.", "watch"),
    DeskKey("watch-resume", ("r",), "ask('resume')", "resume",
            "Let a paused arm go on: it moves again.", "watch"),
    DeskKey("watch-slower", ("minus",), "tempo(-1)", "slower",
            "Have the arm go slower than it is asked to.", "watch"),
    DeskKey("watch-faster", ("plus", "equals_sign"), "tempo(1)", "faster",
            "Have the arm go less slow, at most as fast as it is asked to.", "watch"),
)  # fmt: skip
"""All that may be done to somebody else's arm, beside the stop."""
