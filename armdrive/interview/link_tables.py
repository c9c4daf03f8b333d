"""Link tables of templates: joints by name, lengths that the interview asks for, and as a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from armdrive.interview.toml_text import Entry, Section, document


@dataclass(frozen=True, slots=True)
class Length:
    """A length of a template in mm, and what it is measured from and to."""

    key: str
    mm: float
    words: str


@dataclass(frozen=True, slots=True)
class Joint:
    """One row, limits in degrees and speed in degrees a second; `d` and `a` name lengths.

    `sees` is 1, or -1 where the motor counts up as the joint goes down. Homing is taken to end at
    the motor's upper end, as GRBL does it unless it is told otherwise.
    """

    name: str
    limits_deg: tuple[float, float]
    speed_deg_s: float
    ratio: str
    d: str = ""
    a: str = ""
    alpha_deg: float = 0.0
    offset_deg: float = 0.0
    sees: int = 1


@dataclass(frozen=True, slots=True)
class LinkTable:
    """A template's arm: its joints from the table to the hand, and the length of its tool."""

    convention: str
    source: str
    lengths: tuple[Length, ...]
    joints: tuple[Joint, ...]
    tool: str


def model_text(table: LinkTable, lengths_mm: Mapping[str, float], name: str, title: str) -> str:
    """Return the model file of a template with these lengths.

    With the template's own lengths it says that nobody has measured them.
    """
    measured = any(lengths_mm[length.key] != length.mm for length in table.lengths)
    top = Section(
        "",
        (
            Entry("name", name),
            Entry("title", title),
            Entry("source", table.source),
            Entry("verified", measured, "true once you have measured your arm: allows Cartesian"),
            Entry("convention", table.convention),
        ),
    )
    tool = Section("tool", (Entry("z_mm", lengths_mm[table.tool], _words(table, table.tool)),))
    links = [_link(table, joint, lengths_mm) for joint in table.joints]
    return document((top, tool, *links), "A link table; docs/model-file.md explains the keys.")


def typed_text(rows: Mapping[str, tuple[float, ...]], name: str, title: str) -> str:
    """Return the model file of rows that were typed: theta, d, a, alpha of each joint."""
    keys = ("offset_deg", "d_mm", "a_mm", "alpha_deg")
    top = Section("", (Entry("name", name), Entry("title", title)))
    links = [
        Section("links", (Entry("joint", joint), *map(Entry, keys, row)), array=True)
        for joint, row in rows.items()
    ]
    return document((top, *links), "A link table; docs/model-file.md explains the keys.")


def _link(table: LinkTable, joint: Joint, lengths_mm: Mapping[str, float]) -> Section:
    entries = [Entry("joint", joint.name)]
    for key, length in (("d_mm", joint.d), ("a_mm", joint.a)):
        if length:
            entries.append(Entry(key, lengths_mm[length], _words(table, length)))
    entries += [
        Entry(key, degrees)
        for key, degrees in (("alpha_deg", joint.alpha_deg), ("offset_deg", joint.offset_deg))
        if degrees
    ]
    return Section("links", tuple(entries), array=True)


def _words(table: LinkTable, key: str) -> str:
    return next(length.words for length in table.lengths if length.key == key)
