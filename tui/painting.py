"""Painting less: texts that are repainted only when they change, and rows sent in part."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from rich.color import ColorSystem
from rich.console import Console
from textual._compositor import ChopsUpdate, Compositor
from textual.content import Content
from textual.screen import Screen
from textual.strip import Strip
from textual.widgets import Static

from armdrive.errors.printable import printable_lines

Span = tuple[str, str]
"""A text and its style."""


class PlainText(Static):
    """Text that is shown as it is, and repainted only when it has changed.

    The framework's own widget would read square brackets as markup, paint every update, and send
    an escape sequence in the text to the terminal: text may come from a file or a device.
    """

    def __init__(self, *, id: str, classes: str = "") -> None:  # noqa: A002
        super().__init__("", id=id, classes=classes, markup=False)
        self._spans: tuple[Span, ...] = ()

    @property
    def shown(self) -> str:
        """The text as it stands."""
        return "".join(text for text, _ in self._spans)

    def show(self, *parts: str | Span) -> None:
        """Show these texts from now on, one after the other."""
        spans = tuple(_printable_span(part) for part in parts)
        if spans != self._spans:
            self._spans = spans
            self.update(Content.assemble(*spans))

    def show_lines(self, lines: Iterable[Span]) -> None:
        """Show lines, each in its own style."""
        ended = [(f"{text}\n", style) for text, style in lines]
        self.show(*ended[:-1], *((text[:-1], style) for text, style in ended[-1:]))


def _printable_span(part: str | Span) -> Span:
    text, style = (part, "") if isinstance(part, str) else part
    return printable_lines(text), style


# Sending only the spans that changed, not each row from its beginning. When a widget asks for a
# part of a row to be painted again, the framework finds the row's part, but crops it on the right
# only (`ChopsUpdate.render_segments`, "crop to x extents"). A picture in which a little changes in
# many rows then costs three times as many bytes.

_ONE_CELL_EACH = re.compile(
    "[ -~\\xa0-\\xac\\xae-\\u02ff\\u2500-\\u259f\\u25cb\\u25cf\\u2800-\\u28ff]*"
).fullmatch
"""Latin letters, lines, blocks, dots and braille."""


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
                written.append(_cut(strip, first - x, last - x, console))
        return "".join(written)


def _cut(strip: Strip, left: int, right: int, console: Console) -> str:
    """Return a part of a strip as it is written to the terminal.

    `Strip.crop` and `render` do the same by way of a strip of its own for each span, with caches
    that are never asked. Letters that may not be one cell wide are left to them.
    """
    if not all(_ONE_CELL_EACH(segment.text) for segment in strip):
        return strip.crop(left, right).render(console)
    colours = console._color_system or ColorSystem.TRUECOLOR  # noqa: SLF001 - as Strip.render
    written, x = [], 0
    for text, style, _ in strip:
        piece = text[max(left - x, 0) : right - x] if x < right else ""
        x += len(text)
        if piece:
            drawn = Strip.render_style(style, piece, colours) if style is not None else piece
            written.append(drawn)
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
