"""How an app looks: its themes. The layout is in desk.tcss.

No theme is needed to understand the desk: whatever has a colour has a word or a mark as well.
"""

from __future__ import annotations

from dataclasses import dataclass

from textual.theme import Theme

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
class DeskTheme:
    """A theme by the name people choose it by, and what it is for. `theme` is the framework's."""

    name: str
    theme: str
    summary: str


LOOKS = (
    DeskTheme("dark", "textual-dark", "Light on dark."),
    DeskTheme("light", "textual-light", "Dark on light, for a bright room or a projector."),
    DeskTheme("high-contrast", HIGH_CONTRAST.name, "White on black, few and strong colours."),
    DeskTheme(
        "terminal", "ansi-dark", "The sixteen colours that your terminal has, on its own ground."
    ),
)

COLOURLESS = LOOKS[3]
"""With NO_COLOR set: the only one that sends no colours at all."""


def look_named(name: str) -> DeskTheme:
    """Return a look, the first one where there is none of that name."""
    return next((look for look in LOOKS if look.name == name), LOOKS[0])


def look_after(name: str) -> DeskTheme:
    """Return the next look, after the last one the first."""
    names = [look.name for look in LOOKS]
    return LOOKS[(names.index(look_named(name).name) + 1) % len(LOOKS)]
