"""Has the framework send the spans that changed, and not each row from its beginning.

A work-around: when a widget asks for a part of a row to be painted again, the framework finds the
row's part, but crops it on the right only (`ChopsUpdate.render_segments`, "crop to x extents").
A picture in which a little changes in many rows then costs three times as many bytes.
"""

from __future__ import annotations

from typing import Any

from rich.console import Console
from textual._compositor import ChopsUpdate, Compositor
from textual.screen import Screen


class SpansUpdate(ChopsUpdate):
    """Spans of rows, cropped on both sides."""

    def render_segments(self, console: Console) -> str:
        """Return what is to be written to the terminal."""
        written: list[str] = []
        for y, left, right in self.spans:
            for end, (x, strip) in zip(self.chop_ends[y], self.chops[y].items(), strict=False):
                first, last = max(x, left), min(end, right)
                if strip is None or first >= last:
                    continue
                written.append(f"\x1b[{y + 1};{first + 1}H")
                written.append(strip.crop(first - x, last - x).render(console))
        return "".join(written)


class SpansCompositor(Compositor):
    """The framework's compositor with partial updates of its own."""

    def render_partial_update(self) -> ChopsUpdate | None:
        """Return what changed since the last update, None where nothing did."""
        update = super().render_partial_update()
        if update is None:
            return None
        return SpansUpdate(update.chops, update.spans, update.chop_ends)


def send_spans_alone(screen: Screen[Any]) -> None:
    """Have a screen that is not shown yet send spans from now on."""
    screen._compositor = SpansCompositor()  # noqa: SLF001 - there is no other way in
