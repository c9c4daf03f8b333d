"""The desk: terminal screens from which a person drives an arm.

Which file decides what:

    app         how keys and clicks are handled, stops first; which are stale and dropped
    keys/       the keys, their names, and which presses count
    desk        the app of one arm: its link, its calls, the keys of all screens, and how it is run
    safety      the panel on every screen: state, trust, stopping distance; why keys do nothing
    jog/, move/, points/, program/, setup/, log   one screen each
    watch       an arm that another program drives; `model_desk` a model without an arm
    settings    the operator's settings, such as steps and speeds, and which are saved
    axes, arm_view, widgets, dialogs   parts of screens
    terminal    what a terminal can show, and how it is restored
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tui.desk import run_desk
    from tui.watch import run_watch

__all__ = ["run_desk", "run_watch"]


def __getattr__(name: str) -> Any:
    """Load the desk on first use: the table of keys, or a model, works without it."""
    if name not in __all__:
        raise AttributeError(f"module 'tui' has no attribute {name!r}")
    from tui import desk, watch

    return getattr(watch if name == "run_watch" else desk, name)
