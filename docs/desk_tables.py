"""Write the tables of the desk's pages anew from the program: `python docs/desk_tables.py`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from tui.gamepad import map as pad_map
from tui.keys.keyboard import DEFAULT_KEYS, as_markdown
from tui.keys.table import SCREENS
from tui.look import LOOKS

DOCS = Path(__file__).parent
PAGE = DOCS / "how-to" / "desk.md"
PAD_PAGE = DOCS / "gamepad.md"


def screens() -> Iterator[str]:
    """Yield the table of screens."""
    yield "| key | screen | what for |"
    yield "|---|---|---|"
    for entry in SCREENS:
        yield f"| `{entry.key}` | {entry.title} | {entry.summary} |"


def looks() -> Iterator[str]:
    """Yield the table of looks."""
    yield "| look | |"
    yield "|---|---|"
    for look in LOOKS:
        yield f"| {look.name} | {look.summary} |"


def filled(page: str) -> str:
    """Return a page with its tables as they are now, each between two marks of its name."""
    for name, lines in (
        ("screens", screens()),
        ("looks", looks()),
        ("keys", as_markdown(DEFAULT_KEYS)),
        ("gamepad", pad_map.as_markdown()),
    ):
        if f"<!-- {name} -->" not in page:
            continue
        before, _, rest = page.partition(f"<!-- {name} -->\n")
        _, mark, after = rest.partition(f"<!-- end of {name} -->")
        table = "".join(f"{line}\n" for line in lines)
        page = f"{before}<!-- {name} -->\n{table}{mark}{after}"
    return page


def main() -> None:
    """Fill the pages."""
    for page in (PAGE, PAD_PAGE):
        page.write_text(filled(page.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
