"""The desk: terminal screens from which a person drives an arm."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tui.startup import DeskEnd, run_desk
    from tui.watch import run_watch

__all__ = ["DeskEnd", "run_desk", "run_watch"]


def __getattr__(name: str) -> Any:
    """Load the desk on first use: the table of keys, or a model, works without it."""
    if name not in __all__:
        raise AttributeError(f"module 'tui' has no attribute {name!r}")
    from tui import startup, watch

    return getattr(watch if name == "run_watch" else startup, name)
