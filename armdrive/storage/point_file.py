"""The file of one arm's points: read again for every query, and replaced whole when it changes."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from armdrive.errors import BadRequest, PointsChanged, PointsFileError, Refused, UnknownPoint
from armdrive.errors.arguments import BASIC, Rule, checked_calls, known_attributes, made_of
from armdrive.errors.printable import reason_of
from armdrive.moves import in_order
from armdrive.storage import files as places
from armdrive.storage.files import DISK, NotWanted, StateFiles, followed, replace_durably, stamp_of
from armdrive.storage.points import (
    POINTS,
    SEQUENCES,
    Point,
    Step,
    StepList,
    Taught,
    check_name,
    parse_points,
)
from armdrive.text.toml import FORMAT, FORMAT_KEY, key, value
from kinematics.errors import suggestion
from kinematics.geometry import ArmGeometry
from kinematics.spaces import Joints, Pose

# Writes a file of points that a person can read, compare and edit.
#
# A change rewrites only the tables of the points and sequences that changed, and leaves every other
# line alone, comments included.

DECIMALS = 4  # of a degree: the tip of a table-top arm moves by less than 0.001 mm
HEADER_WIDTH = 24  # column of the comment with the pose, after a point's header

HEADING = """\
# Points and sequences of {arm}, in degrees, mm and seconds. Edit them as you like: they are
# checked before the arm moves. docs/how-to/points.md explains every key.
{key} = {format}
"""

_HEADER = r"\s*\[[^\[\]]+\]\s*(#.*)?"


@dataclass(frozen=True, slots=True, eq=False)
class PointWriter:
    """Writes the tables of one arm's file; `fk` gives the pose for the comment at each point."""

    arm: str
    fk: Callable[[Joints], Pose]

    def document(self, taught: Taught) -> str:
        """Return the text of a new file."""
        heading = HEADING.format(arm=self.arm, key=FORMAT_KEY, format=FORMAT)
        return "\n".join([heading, *self._tables(taught).values()])

    def edited(self, text: str, before: Taught, after: Taught) -> str | None:
        """Return the text with the changed tables rewritten; None if its layout prevents that.

        A table keeps its place and the comment lines above it. New tables are appended.
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
    """Return the values as a file stores them, with angles and openings rounded.

    Values about to be written can then be compared with values that were read.
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
    table: dict[str, Any] = {}
    if step.point:
        table["point"] = step.point
    if step.how != "joint":
        table["how"] = step.how
    if step.gripper is not None:
        table["gripper"] = step.gripper
    if step.wait_s is not None:
        table["wait_s"] = step.wait_s
    if step.speed < 1.0:
        table["speed"] = step.speed
    return table


def _blocks(text: str) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the blocks of a text: the names in a table's header, and the table's text.

    A block begins with the comments above its header. The text before the first table is a block
    without names.
    """
    place: tuple[str, ...] = ()
    block: list[str] = []
    for line in _toml_lines(text):
        named = _named(line)
        if named is not None:
            above = _comments_at_end(block)
            yield place, "".join(block[: len(block) - above])
            place, block = named, block[len(block) - above :]
        block.append(line if line.endswith("\n") else f"{line}\n")
    yield place, "".join(block)


def _toml_lines(text: str) -> list[str]:
    """Return the lines with their ends. Only a newline ends one: notes may contain other breaks."""
    return re.findall(r"[^\n]*\n|[^\n]+", text)


def _named(line: str) -> tuple[str, ...] | None:
    """Return the names in a table's header; None for any other line."""
    if not re.fullmatch(_HEADER, line.rstrip("\r\n")):
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
    """Return the comment lines above the header in a block."""
    lines = _toml_lines(block)
    return "".join(lines[: next(i for i, line in enumerate(lines) if _named(line) is not None)])


def _below(block: str) -> str:
    """Return the empty lines at the end of a block."""
    return "\n" * (len(block) - len(block.rstrip("\n")) - 1)


def _same(text: str, wanted: Taught) -> bool:
    """Return whether a text parses to the wanted points and sequences."""
    names = next((point.joints.names for point in wanted.points.values()), ())
    try:
        return rounded(parse_points(text, names)) == rounded(wanted)
    except PointsFileError:
        return False


LARGEST_BYTES = 4_000_000  # a larger file cannot be a file of points
TRIES = 5  # attempts at a change while other programs change the file
ASIDE = ".before"  # ending of the old file if its layout could not be kept


# The named points and sequences of one arm as a mapping, for programs.
#
# Every query reads the file again, and a change rewrites only the tables concerned, so that edits
# by a person or another program are kept.

V = TypeVar("V")


A_POINT = 'arm.points.teach("pick")'

RULES: Mapping[str, Rule] = {
    **BASIC,
    "Point": made_of(Point, "a point", A_POINT),
    "StepList": made_of(StepList, "a sequence"),
    "Mapping[str, Point]": made_of(Mapping, "points by their names"),
    "Mapping[str, StepList]": made_of(Mapping, "sequences by their names"),
}
"""The rules for the arguments of `Points`, by the annotation of the parameter."""


def not_connected() -> Point:
    """Raise `Refused`: an arm that is not connected has no known posture."""
    raise Refused("the arm is not connected, so its posture is unknown: connect first")


@known_attributes
@checked_calls(RULES)
class Points(MutableMapping[str, Point]):
    """`points["pick"]`, `points.teach("pick")`, `del points["pick"]`; see docs/how-to/points.md.

    Every call may raise `PointsFileError`, and `UnknownPoint` (a `KeyError`) for an unknown name.
    """

    def __init__(
        self,
        path: Path,
        arm: str,
        names: tuple[str, ...],
        fk: Callable[[Joints], Pose],
        here: Callable[[], Point],
        files: StateFiles = DISK,
    ) -> None:
        """Use the points of an arm with the joints `names`; `here` returns its current posture.

        The file need not exist yet.
        """
        self.path = path
        self._names = names
        self._writer = PointWriter(arm, fk)
        self._here = here
        self._files = files

    def __repr__(self) -> str:
        return f"<{type(self).__name__} in {self.path}>"

    # -- the file -----------------------------------------------------------------------------

    def _bytes(self) -> bytes:
        try:
            data = self._files.read(followed(self.path), LARGEST_BYTES + 1)
        except FileNotFoundError:
            return b""
        except OSError as error:
            why = reason_of(error)
            raise PointsFileError(f"{self.path} cannot be read: {why}") from None
        if len(data) > LARGEST_BYTES:  # writing back a truncated file would lose points
            raise PointsFileError(f"{self.path} is larger than {LARGEST_BYTES} bytes")
        return data

    def _parsed(self, data: bytes) -> Taught:
        try:
            return parse_points(data.decode("utf-8"), self._names)
        except (PointsFileError, UnicodeDecodeError) as error:
            raise PointsFileError(f"{self.path}: {error}") from None

    def _change(self, change: Callable[[Taught], Taught]) -> None:
        """Apply a change to the file; start over if another program changes the file meanwhile."""
        for _ in range(TRIES):
            data = self._bytes()
            before = self._parsed(data)
            try:
                self._write(data, before, rounded(self._in_order(change(before))))
            except NotWanted:
                continue
            except OSError as error:
                why = reason_of(error)
                raise PointsFileError(f"{self.path} cannot be written: {why}") from None
            return
        raise PointsChanged(f"{self.path} is being written by another program: try again")

    def _in_order(self, taught: Taught) -> Taught:
        """Return the points with their joints in the arm's order."""
        points = {
            name: replace(each, joints=in_order(each.joints, self._names))
            for name, each in taught.points.items()
        }
        return replace(taught, points=points)

    def _write(self, data: bytes, before: Taught, after: Taught) -> None:
        # `data` is what the change is based on; `wanted` sees whether it is still in the file.
        text = self._writer.edited(data.decode("utf-8"), before, after)
        path = followed(self.path)
        aside = None
        if text is None:  # a layout that we cannot edit: keep the old file and write a new one
            text, aside = self._writer.document(after), path.with_name(path.name + ASIDE)
        written = text.encode("utf-8")
        self._require_readable(written)
        replace_durably(
            self._files,
            path,
            written,
            aside=aside,
            wanted=lambda: self._bytes() == data,
        )

    def _require_readable(self, data: bytes) -> None:
        """Raise `BadRequest` for a file that could not be read again: it would lose every point."""
        if len(data) > LARGEST_BYTES:
            raise BadRequest(f"the points would take more than {LARGEST_BYTES} bytes: not written")
        try:
            parse_points(data.decode("utf-8"), self._names)
        except PointsFileError as error:
            raise BadRequest(
                f"these points could not be read again, so nothing was written: {error}"
            ) from None

    # -- reading ------------------------------------------------------------------------------

    def read(self) -> Taught:
        """Return all points and sequences in the file now; none if there is no file."""
        return self._parsed(self._bytes())

    @property
    def stamp(self) -> tuple[int, int] | None:
        """A value that changes with the file, quick to get; None if there is no file."""
        return stamp_of(self.path)

    def __getitem__(self, name: str) -> Point:
        return _found(self.read().points, name, "point")

    def __iter__(self) -> Iterator[str]:
        return iter(self.read().points)

    def __len__(self) -> int:
        return len(self.read().points)

    @property
    def sequences(self) -> Mapping[str, StepList]:
        """The sequences in the file now, by name."""
        return self.read().sequences

    def sequence(self, name: str) -> StepList:
        """Return a sequence by its name."""
        return _found(self.read().sequences, name, "sequence")

    # -- changing -----------------------------------------------------------------------------

    def teach(self, name: str, *, note: str = "", again: bool = False) -> Point:
        """Save the arm's current posture under a name; `again` allows replacing a point.

        Raises `NotReferenced` if the position is unknown.
        """
        point = replace(self._here(), note=note)
        before = self.read().points.get(check_name(name))
        if before is not None and not again:
            raise BadRequest(
                f"there is a point {name!r} already: teach it again, or choose another name"
            )
        if before is not None and not note:
            point = replace(point, note=before.note)
        self.put(name, point, instead_of=before)
        return point

    def __setitem__(self, name: str, point: Point) -> None:
        self._change(lambda taught: replace(taught, points={**taught.points, name: point}))

    def __delitem__(self, name: str) -> None:
        self.remove(name, instead_of=self[name])

    def put(self, name: str, point: Point, *, instead_of: Point | None) -> None:
        """Replace the point last seen under a name, or add one if `instead_of` is None.

        Raises `PointsChanged` if the file has changed there since.
        """
        self._replace(POINTS, name, instead_of, point)

    def remove(self, name: str, *, instead_of: Point | None) -> None:
        """Remove a point; raises `BadRequest` while a sequence uses it."""
        self._replace(POINTS, name, instead_of, None)

    def put_sequence(self, name: str, steps: StepList, *, instead_of: StepList | None) -> None:
        """Replace the sequence last seen under a name, or add one; see `put`."""
        self._replace(SEQUENCES, name, instead_of, steps)

    def remove_sequence(self, name: str, *, instead_of: StepList | None) -> None:
        """Remove a sequence; raises `PointsChanged` like `put`."""
        self._replace(SEQUENCES, name, instead_of, None)

    def _replace(
        self, kind: str, name: str, seen: Point | StepList | None, new: Point | StepList | None
    ) -> None:
        """Replace the entry last seen under a name; with None for `new`, remove it."""

        def change(taught: Taught) -> Taught:
            known: dict[str, Any] = dict(getattr(taught, kind))
            now = known.get(check_name(name))
            if now != seen:
                what = "has gone" if now is None else "is new" if seen is None else "was changed"
                raise PointsChanged(f"{name!r} {what} in the file meanwhile; nothing was written")
            if new is not None:
                return replace(taught, **{kind: known | {name: new}})
            if kind == POINTS and (users := taught.users(name)):
                raise BadRequest(f"the point {name!r} is used by {', '.join(users)}")
            _found(known, name, kind.removesuffix("s"))
            del known[name]
            return replace(taught, **{kind: known})

        self._change(change)

    def rename(self, old: str, new: str) -> None:
        """Rename a point, also in the sequences that use it."""

        def change(taught: Taught) -> Taught:
            _found(taught.points, old, "point")
            if check_name(new) in taught.points:
                raise BadRequest(f"there is a point {new!r} already")
            points = {new if name == old else name: each for name, each in taught.points.items()}
            return Taught(
                points, {name: _gone_to(each, old, new) for name, each in taught.sequences.items()}
            )

        self._change(change)

    def put_all(
        self, points: Mapping[str, Point], sequences: Mapping[str, StepList], *, again: bool = False
    ) -> None:
        """Write points and sequences in one change; `again` allows replacing existing ones.

        Otherwise raises `BadRequest` for a name that is taken, and writes nothing.
        """

        def change(taught: Taught) -> Taught:
            taken = [name for name in points if name in taught.points]
            taken += [name for name in sequences if name in taught.sequences]
            if taken and not again:
                raise BadRequest(
                    f"there is {', '.join(taken)} already: choose another name, or add --again"
                )
            return Taught({**taught.points, **points}, {**taught.sequences, **sequences})

        self._change(change)


def points_of(arm: str, geometry: ArmGeometry, here: Callable[[], Point] = not_connected) -> Points:
    """Return the points of the arm with this name, which need not be connected."""
    return Points(places.points_file(arm), arm, geometry.joint_names, geometry.fk, here)


def _found(known: Mapping[str, V], name: str, what: str) -> V:
    if name not in known:
        listed = f"known are {', '.join(known)}" if known else f"no {what} has been saved yet"
        raise UnknownPoint(f"there is no {what} {name!r}: {listed}{suggestion(name, known)}")
    return known[name]


def _gone_to(steps: StepList, old: str, new: str) -> StepList:
    renamed = (replace(each, point=new) if each.point == old else each for each in steps.steps)
    return replace(steps, steps=tuple(renamed))
