"""The pages of the documentation, found by their names in any folder of docs/."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = tuple(sorted([*DOCS.rglob("*.md"), ROOT / "README.md"]))


def page_path(name: str) -> Path:
    """Return the path of the page with this name."""
    (found,) = DOCS.rglob(f"{name}.md")
    return found


def page(name: str) -> str:
    """Return the text of a page."""
    return page_path(name).read_text(encoding="utf-8")


def blocks(text: str, language: str = "") -> list[str]:
    """Return the fenced blocks of a language in a page."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
