"""The desk's colours: one table of themes, one of great contrast and one of the terminal's own.

No theme is needed to understand the desk: whatever has a colour has a word or a mark as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from textual.theme import Theme

if TYPE_CHECKING:
    from textual.app import App

HIGH_CONTRAST = Theme(
    name="high-contrast",
    primary="#00ffff",
    secondary="#ffffff",
    accent="#ffff00",
    warning="#ffff00",
    error="#c00000",
    success="#00ff00",
    foreground="#ffffff",
    background="#000000",
    surface="#000000",
    panel="#000000",
    boost="#000000",
    dark=True,
    luminosity_spread=0.0,
    text_alpha=1.0,
)
"""White on black, and black or white on whatever is filled: 7 to 1 at least."""


@dataclass(frozen=True, slots=True)
class Look:
    """A theme by the name people choose it by, and what it is for. `theme` is the framework's."""

    name: str
    theme: str
    summary: str


LOOKS = (
    Look("dark", "textual-dark", "Light on dark."),
    Look("light", "textual-light", "Dark on light, for a bright room or a projector."),
    Look("high-contrast", HIGH_CONTRAST.name, "White on black, few and strong colours."),
    Look("terminal", "ansi-dark", "The sixteen colours that your terminal has, on its own ground."),
)

COLOURLESS = LOOKS[3]
"""With NO_COLOR set: the only one that sends no colours at all."""


def look_named(name: str) -> Look:
    """Return a look, the first one where there is none of that name."""
    return next((look for look in LOOKS if look.name == name), LOOKS[0])


def look_after(name: str) -> Look:
    """Return the next look, after the last one the first."""
    names = [look.name for look in LOOKS]
    return LOOKS[(names.index(look_named(name).name) + 1) % len(LOOKS)]


def put_on(app: App[int], name: str) -> str:
    """Have an app look so, and return the name of the look that it then has."""
    look = COLOURLESS if app.no_color else look_named(name)
    if HIGH_CONTRAST.name not in app.available_themes:
        app.register_theme(HIGH_CONTRAST)
    app.theme = look.theme
    return look.name
