"""The tables of words for people, made from the vocabulary: docs/programs.md has them."""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.programs.vocabulary import FIELDS, FORMS, FUNCTIONS, GROUPS, Slot, Word


def tables() -> str:
    """Return every word, form of a line and function as tables in Markdown."""
    parts = [_section(title, _words(words)) for title, words in GROUPS.items()]
    forms = [f"| `{row.pattern}` | {row.says} |" for row in FORMS]
    parts.append(
        _section(
            "Lines that give a program its shape", ["| line | what it does |", "|---|---|", *forms]
        )
    )
    parts.append(_section("Values", _functions()))
    return "\n".join(parts)


def usage(word: Word) -> str:
    """Return how a word is written: `wait NUMBER, ... [within TIME] [into NAME]`."""
    links = "".join(
        f" {link} {_slots(slots)}" if link in word.needs else f" [{link} {_slots(slots)}]"
        for link, slots in word.links
    )
    return f"{word.name} {_slots(word.slots)}".rstrip() + links


def _section(title: str, rows: Sequence[str]) -> str:
    return "\n".join((f"### {title}", "", *rows, ""))


def _words(words: Sequence[Word]) -> list[str]:
    rows = ["| word | what it does | example | old spelling |", "|---|---|---|---|"]
    for word in words:
        old = ", ".join(f"`{each.upper()}`" for each in word.old)
        rows.append(f"| `{usage(word)}` | {word.says} | `{word.example}` | {old} |")
    return rows


def _functions() -> list[str]:
    rows = ["| value | what it is | example |", "|---|---|---|"]
    rows += [
        f"| `{row.name}({_slots(row.slots)})` | {row.says} | `{row.example}` |"
        for row in FUNCTIONS.values()
    ]
    rows.append(
        "| `joints(NAME ANGLE, ...)` | The place with these joint angles, deg; every joint of the "
        "arm is named. | `joints(base 0, shoulder 40, elbow -60, wrist_pitch -70, wrist_roll 0)` |"
    )
    rows.append("| `here` | The place where the arm stands. | `above(here, 20)` |")
    parts = ", ".join(f"`.{name}`" for name in FIELDS)
    rows.append(f"| {parts} | The parts of a place, mm and deg. | `pick.z` |")
    return rows


def _slots(slots: Sequence[Slot]) -> str:
    shown = []
    for slot in slots:
        name = slot.title.split(",")[0].split(" in ")[0].upper()
        text = f"{name}, ..." if slot.many else name
        shown.append(f"[{text}]" if slot.optional else text)
    return ", ".join(shown)
