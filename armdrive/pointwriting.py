"""Writing a file of points, so that a person can read it, compare it and edit it.

A change rewrites the tables of what has changed and leaves every other line alone, comments too.
"""

from __future__ import annotations

import math
import re
import tomllib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from armdrive.errors import PointsFileError
from armdrive.interview.toml_text import key, value
from armdrive.points import Point, Step, StepList, Taught
from armdrive.pointtext import POINTS, SEQUENCES, parse_points
from kinematics import Joints

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from kinematics import Pose

DECIMALS = 4
"""Of a degree in the file: the tip of a table-top arm moves by less than 0.001 mm."""

HEADER_WIDTH = 24
"""The pose of a point stands beside its header from this column on."""

HEADING = """\
# Points and sequences of {arm}: degrees, mm, seconds. Edit them as you like; whatever is
# written here is audited before the arm moves. docs/points.md tells every key.
"""

_HEADER = re.compile(r"\s*\[[^\[\]]+\]\s*(#.*)?")


@dataclass(frozen=True, slots=True)
class Writer:
    """Writes the tables of one arm's file; `fk` gives the pose for the comment of a point."""

    arm: str
    fk: Callable[[Joints], Pose]

    def document(self, taught: Taught) -> str:
        """Return a whole new file."""
        return "\n".join([HEADING.format(arm=self.arm), *self._tables(taught).values()])

    def edited(self, text: str, before: Taught, after: Taught) -> str | None:
        """Return the text with what has changed rewritten; None where it is laid out otherwise.

        A table keeps its place and the comment lines above it; a new one comes at the end.
        """
        if not text.strip():
            return self.document(after)
        old, new = self._tables(before), self._tables(after)
        found = []
        for place, lines in _blocks(text):
            if place in old and place not in new:
                continue
            if place in old and old[place] != new[place]:
                lines = f"{_above(lines)}{new[place]}{_below(lines)}"
            found.append(lines)
        made = "".join(found)
        for place, table in new.items():
            if place not in old:
                made = f"{made.rstrip()}\n\n{table}"
        return made if _same(made, after) else None

    def _tables(self, taught: Taught) -> dict[tuple[str, str], str]:
        points = {(POINTS, name): self._point(name, each) for name, each in taught.points.items()}
        lists = {(SEQUENCES, name): _lines(name, each) for name, each in taught.sequences.items()}
        return points | lists

    def _point(self, name: str, point: Point) -> str:
        angles = {joint: round(angle, DECIMALS) + 0.0 for joint, angle in point.joints.deg.items()}
        header = f"[{POINTS}.{key(name)}]"
        tip = f"# the tip then: {self.fk(point.joints)}"
        rows = [f"{header.ljust(HEADER_WIDTH)} {tip}", f"joints_deg = {value(angles)}"]
        if point.opening_mm is not None:
            rows.append(f"gripper_mm = {value(round(point.opening_mm, DECIMALS) + 0.0)}")
        if point.taught is not None:
            rows.append(f"taught = {point.taught.isoformat(timespec='seconds')}")
        rows += [f"note = {value(point.note)}"] * bool(point.note)
        return "\n".join([*rows, ""])


def rounded(taught: Taught) -> Taught:
    """Return what a file holds of this: angles and openings with as many decimals as are written.

    So that what is written can be compared with what is read.
    """
    return Taught({name: _rounded(each) for name, each in taught.points.items()}, taught.sequences)


def _rounded(point: Point) -> Point:
    turned = (math.radians(round(angle, DECIMALS) + 0.0) for angle in point.joints.deg.values())
    opening = None if point.opening_mm is None else round(point.opening_mm, DECIMALS) + 0.0
    taught = None if point.taught is None else point.taught.replace(microsecond=0)
    return Point(Joints(tuple(turned), point.joints.names), opening, point.note, taught)


def _lines(name: str, steps: StepList) -> str:
    rows = [f"[{SEQUENCES}.{key(name)}]"]
    rows += [f"note = {value(steps.note)}"] * bool(steps.note)
    rows += ["steps = [", *(f"  {value(_step_table(each))}," for each in steps.steps), "]", ""]
    return "\n".join(rows)


def _step_table(step: Step) -> dict[str, Any]:
    said: dict[str, Any] = {}
    if step.point:
        said["point"] = step.point
    if step.how != "joint":
        said["how"] = step.how
    if step.gripper is not None:
        said["gripper"] = step.gripper
    if step.wait_s is not None:
        said["wait_s"] = step.wait_s
    if step.speed < 1.0:
        said["speed"] = step.speed
    return said


def _blocks(text: str) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the text in pieces, each from the comments above a table's header to the next such.

    With each the names in its header; none for what stands before the first.
    """
    place: tuple[str, ...] = ()
    block: list[str] = []
    for line in text.splitlines(keepends=True):
        named = _named(line)
        if named is not None:
            above = _comments_at_end(block)
            yield place, "".join(block[: len(block) - above])
            place, block = named, block[len(block) - above :]
        block.append(line if line.endswith("\n") else f"{line}\n")
    yield place, "".join(block)


def _named(line: str) -> tuple[str, ...] | None:
    """Return the names in a line that is a table's header."""
    if not _HEADER.fullmatch(line.rstrip("\r\n")):
        return None
    try:
        table = tomllib.loads(line)
    except tomllib.TOMLDecodeError:
        return None
    names = []
    while table:
        ((name, table),) = table.items()
        names.append(name)
    return tuple(names)


def _comments_at_end(block: list[str]) -> int:
    count = 0
    while count < len(block) and block[-1 - count].lstrip().startswith("#"):
        count += 1
    return count


def _above(block: str) -> str:
    """Return the comment lines above a table's header."""
    lines = block.splitlines(keepends=True)
    return "".join(lines[: next(i for i, line in enumerate(lines) if _named(line) is not None)])


def _below(block: str) -> str:
    """Return the empty lines under a table."""
    return "\n" * (len(block) - len(block.rstrip("\n")) - 1)


def _same(text: str, wanted: Taught) -> bool:
    """Tell whether a text reads as what it should hold."""
    names = next((point.joints.names for point in wanted.points.values()), ())
    try:
        return rounded(parse_points(text, names)) == rounded(wanted)
    except PointsFileError:
        return False
