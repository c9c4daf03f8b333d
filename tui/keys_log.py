"""Rows of the table of keys for the log and its dialogs. None of them moves the arm."""

from __future__ import annotations

from armdrive.trace.log import Topic
from tui.key_row import DeskKey

LOG_KEYS = (
    DeskKey("log-open", ("enter",), "open_line", "open",
            "Show the whole line; of an error its cause and what to do.", "log"),
    DeskKey("log-find", ("slash",), "find", "find",
            "Show only the lines with a text; commas between words that must all be there.", "log"),
    DeskKey("log-all", ("a",), "all", "all", "Show everything again, the newest last.", "log"),
    DeskKey("log-pause", ("p",), "pause", "hold",
            "Hold the lines still, or let them come again. The arm is not paused by it.", "log"),
    DeskKey("log-save", ("s",), "save", "save",
            "Write what the flight recorder holds to a file, and say where it is.", "log"),
    DeskKey("log-catalogue", ("e",), "catalogue", "all errors",
            "Look up what every error means and what to do.", "log"),
    DeskKey("log-up", ("up",), "go(-1)", "older", "Choose the line before.", "log"),
    DeskKey("log-down", ("down",), "go(1)", "", "Choose the next line.", "log"),
    DeskKey("log-page-up", ("pageup",), "page(-1)", "", "Go back by a page.", "log"),
    DeskKey("log-page-down", ("pagedown",), "page(1)", "", "Go on by a page.", "log"),
    DeskKey("log-first", ("home",), "first", "", "Go to the oldest line.", "log"),
    DeskKey("log-last", ("end",), "last", "newest", "Follow the newest line again.", "log"),
    *(
        DeskKey(f"log-{topic.value}", (str(number),), f"topic('{topic.value}')", topic.value,
                f"Show the {topic.value} or leave them out.", "log")
        for number, topic in enumerate(Topic, 1)
    ),
)  # fmt: skip
"""The head of the screen names the keys of the topics, so that they come last in the footer."""

LOG_DIALOG_KEYS = (
    DeskKey("line-close", ("enter", "n"), "close", "close", "Close it.", "line"),
    DeskKey("find-done", ("enter",), "close", "done", "Keep the text, and close.", "find"),
    DeskKey("find-erase", ("backspace",), "erase", "", "Take the last character away.", "find"),
    DeskKey("find-clear", ("delete",), "clear", "", "Take all characters away.", "find"),
    DeskKey("catalogue-close", ("enter",), "close", "close", "Close it.", "catalogue"),
    DeskKey("catalogue-erase", ("backspace",), "erase", "",
            "Take the last character away.", "catalogue"),
    DeskKey("catalogue-clear", ("delete",), "clear", "",
            "Take all characters away.", "catalogue"),
    DeskKey("catalogue-up", ("up",), "choose(-1)", "", "Choose the error before.", "catalogue"),
    DeskKey("catalogue-down", ("down",), "choose(1)", "", "Choose the next error.", "catalogue"),
)  # fmt: skip
"""What is typed into a search is no row of the table."""
