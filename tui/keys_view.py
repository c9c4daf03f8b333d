"""Rows of the table of keys that move the watcher about the arm; they never move the arm.

None of them is an arrow with shift: terminals that cannot tell those from plain arrows would jog.
"""

from __future__ import annotations

from tui.key_row import DeskKey

VIEW_KEYS = (
    DeskKey("view-next", ("v",), "view('next')", "view",
            "Look at the arm from the next side: iso, side, top, front."),
    DeskKey("view-left", ("left_parenthesis",), "view('left')", "",
            "Go round the arm to the left; the mouse does it by dragging."),
    DeskKey("view-right", ("right_parenthesis",), "view('right')", "",
            "Go round the arm to the right."),
    DeskKey("view-up", ("i",), "view('up')", "", "Look at the arm from higher up."),
    DeskKey("view-down", ("k",), "view('down')", "", "Look at the arm from lower down."),
    DeskKey("view-nearer", ("z",), "view('nearer')", "",
            "Come nearer to the tip; the mouse wheel does it too."),
    DeskKey("view-farther", ("x",), "view('farther')", "", "Go farther away."),
    DeskKey("view-fit", ("o",), "view('fit')", "", "Show all of the arm's reach again."),
    DeskKey("view-clear", ("c",), "view('clear')", "",
            "Forget the way that the tip has gone, as it is drawn."),
)  # fmt: skip
"""What can be done wherever an arm is drawn."""
