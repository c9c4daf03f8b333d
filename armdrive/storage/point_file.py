"""The file of one arm's points: read again for every query, and replaced whole when it changes."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping, MutableMapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from armdrive.errors import BadRequest, PointsChanged, PointsFileError, Refused, UnknownPoint
from armdrive.errors.arguments import BASIC, Rule, checked_calls, known_attributes, made_of
from armdrive.errors.printable import reason_of
from armdrive.moves import in_order
from armdrive.storage import files as places
from armdrive.storage.files import (
    DISK,
    NotWanted,
    StateFiles,
    replace_durably,
    stamp_of,
)
from armdrive.storage.points import (
    POINTS,
    Point,
    check_name,
    parse_points,
)
from armdrive.text.toml import FORMAT, FORMAT_KEY, key, value
from kinematics.errors import suggestion
from kinematics.geometry import ArmGeometry
from kinematics.spaces import Joints, Pose

LARGEST_BYTES = 4_000_000  # a larger file cannot be a file of points
TRIES = 5  # attempts at a change while other programs change the file

DECIMALS = 4  # of a degree: the tip of a table-top arm moves by less than 0.001 mm
HEADER_WIDTH = 24  # column of the comment with the pose, after a point's header

HEADING = """\
# Points of {arm}, in degrees and mm. Edit them as you like: they are checked before the arm moves.
# docs/how-to/points.md explains every key.
{key} = {format}
"""


@dataclass(frozen=True, slots=True, eq=False)
class PointWriter:
    """Writes the file of one arm's points; `fk` gives the pose for the comment at each point."""

    arm: str
    fk: Callable[[Joints], Pose]

    def document(self, points: Mapping[str, Point]) -> str:
        """Return the text of a new file."""
        heading = HEADING.format(arm=self.arm, key=FORMAT_KEY, format=FORMAT)
        return "\n".join([heading, *self._tables(points).values()])

    def edited(self, text: str, before: Mapping[str, Point], after: Mapping[str, Point]) -> str:
        """Return the text with the tables of changed points rewritten, and all else as it stands.

        A table keeps its place; new ones are appended. Returns an empty text where that fails.
        """
        if not text.strip():
            return self.document(after)
        import tomlkit  # takes 40 ms to load, and few programs change a point

        old, new = self._tables(before), self._tables(after)
        if old == new:
            return text
        try:
            found = tomlkit.parse(text)
            for name, table in old.items():
                points: Any = found[POINTS]
                if name not in new:
                    points.remove(name)
                elif new[name] != table:
                    points[name] = tomlkit.parse(new[name])[POINTS][name]
            added = [table.rstrip() for name, table in new.items() if name not in old]
        except (
            tomlkit.exceptions.TOMLKitError,
            LookupError,
            ValueError,
            AttributeError,
            TypeError,
        ):
            return ""
        return "\n\n".join([found.as_string().rstrip(), *added]) + "\n"

    def _tables(self, points: Mapping[str, Point]) -> dict[str, str]:
        return {name: self._table(name, each) for name, each in points.items()}

    def _table(self, name: str, point: Point) -> str:
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


def rounded(points: Mapping[str, Point]) -> dict[str, Point]:
    """Return the values as a file stores them, with angles and openings rounded.

    Values about to be written can then be compared with values that were read.
    """
    return {name: _rounded(each) for name, each in points.items()}


def _rounded(point: Point) -> Point:
    turned = (math.radians(round(angle, DECIMALS) + 0.0) for angle in point.joints.deg.values())
    opening = None if point.opening_mm is None else round(point.opening_mm, DECIMALS) + 0.0
    taught = None if point.taught is None else point.taught.replace(microsecond=0)
    return Point(Joints(tuple(turned), point.joints.names), opening, point.note, taught)


# The named points of one arm as a mapping, for programs.
#
# Every query reads the file again, and a change rewrites only the tables concerned, so that edits
# by a person or another program are kept.

A_POINT = 'arm.points.teach("pick")'

# The rules for the arguments of `Points`, by the annotation of the parameter.
RULES: Mapping[str, Rule] = {
    **BASIC,
    "Point": made_of(Point, "a point", A_POINT),
    "Mapping[str, Point]": made_of(Mapping, "points by their names"),
}


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
            data = self._files.read(self.path, LARGEST_BYTES + 1)
        except FileNotFoundError:
            return b""
        except OSError as error:
            why = reason_of(error)
            raise PointsFileError(f"{self.path} cannot be read: {why}") from None
        if len(data) > LARGEST_BYTES:  # writing back a truncated file would lose points
            raise PointsFileError(f"{self.path} is larger than {LARGEST_BYTES} bytes")
        return data

    def _parsed(self, data: bytes) -> dict[str, Point]:
        try:
            return parse_points(data.decode("utf-8"), self._names)
        except (PointsFileError, UnicodeDecodeError) as error:
            raise PointsFileError(f"{self.path}: {error}") from None

    def _change(self, change: Callable[[dict[str, Point]], dict[str, Point]]) -> None:
        """Apply a change to the file; start over if another program changes the file meanwhile."""
        for _ in range(TRIES):
            data = self._bytes()
            before = self._parsed(data)
            after = {
                check_name(name): replace(each, joints=in_order(each.joints, self._names))
                for name, each in change(before).items()
            }
            try:
                self._write(data, before, rounded(after))
            except NotWanted:
                continue
            except OSError as error:
                why = reason_of(error)
                raise PointsFileError(f"{self.path} cannot be written: {why}") from None
            return
        raise PointsChanged(f"{self.path} is being written by another program: try again")

    def _write(self, data: bytes, before: dict[str, Point], after: dict[str, Point]) -> None:
        # `data` is what the change is based on; `wanted` sees whether it is still in the file.
        text = self._writer.edited(data.decode("utf-8"), before, after)
        # read again: tomlkit puts some keys of unusual layouts into a wrong table
        if not text or rounded(self._parsed(text.encode("utf-8"))) != after:
            raise PointsFileError(
                f"{self.path}: it is laid out in a way that cannot be edited here: write each "
                f"point as a table of its own, like [{POINTS}.pick]"
            )
        written = text.encode("utf-8")
        if len(written) > LARGEST_BYTES:  # it could not be read again
            raise BadRequest(f"the points would take more than {LARGEST_BYTES} bytes: not written")
        path = Path(os.path.realpath(self.path))  # a link to a person's own collection stays one
        replace_durably(self._files, path, written, wanted=lambda: self._bytes() == data)

    # -- reading ------------------------------------------------------------------------------

    def read(self) -> dict[str, Point]:
        """Return all points in the file now; none if there is no file."""
        return self._parsed(self._bytes())

    @property
    def stamp(self) -> tuple[int, int] | None:
        """A value that changes with the file, quick to get; None if there is no file."""
        return stamp_of(self.path)

    def __getitem__(self, name: str) -> Point:
        return _found(self.read(), name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.read())

    def __len__(self) -> int:
        return len(self.read())

    # -- changing -----------------------------------------------------------------------------

    def teach(self, name: str, *, note: str = "", again: bool = False) -> Point:
        """Save the arm's current posture under a name; `again` allows replacing a point.

        Raises `NotReferenced` if the position is unknown.
        """
        point = replace(self._here(), note=note)
        before = self.read().get(check_name(name))
        if before is not None and not again:
            raise _taken(name)
        if before is not None and not note:
            point = replace(point, note=before.note)
        self.put(name, point, instead_of=before)
        return point

    def __setitem__(self, name: str, point: Point) -> None:
        self._change(lambda points: {**points, name: point})

    def __delitem__(self, name: str) -> None:
        self.remove(name, instead_of=self[name])

    def put(self, name: str, point: Point, *, instead_of: Point | None) -> None:
        """Replace the point last seen under a name, or add one if `instead_of` is None.

        Raises `PointsChanged` if the file has changed there since.
        """

        def change(points: dict[str, Point]) -> dict[str, Point]:
            _require_unchanged(points, name, instead_of)
            return {**points, name: point}

        self._change(change)

    def remove(self, name: str, *, instead_of: Point) -> None:
        """Remove the point last seen under a name; raises `PointsChanged` like `put`."""

        def change(points: dict[str, Point]) -> dict[str, Point]:
            _require_unchanged(points, name, instead_of)
            return {each: point for each, point in points.items() if each != name}

        self._change(change)

    def rename(self, old: str, new: str) -> None:
        """Rename a point. Programs that name it have to be changed by hand."""

        def change(points: dict[str, Point]) -> dict[str, Point]:
            _found(points, old)
            if check_name(new) in points:
                raise BadRequest(f"there is {new} already: choose another name")
            return {new if name == old else name: each for name, each in points.items()}

        self._change(change)

    def put_all(self, points: Mapping[str, Point], *, again: bool = False) -> None:
        """Write points in one change; `again` allows replacing existing ones.

        Otherwise raises `BadRequest` for a name that is taken, and writes nothing.
        """

        def change(before: dict[str, Point]) -> dict[str, Point]:
            taken = [name for name in points if name in before]
            if taken and not again:
                raise _taken(*taken)
            return {**before, **points}

        self._change(change)


def points_of(arm: str, geometry: ArmGeometry, here: Callable[[], Point] = not_connected) -> Points:
    """Return the points of the arm with this name, which need not be connected."""
    return Points(places.points_file(arm), arm, geometry.joint_names, geometry.fk, here)


def _taken(*names: str) -> BadRequest:
    return BadRequest(
        f"there is {', '.join(names)} already: choose another name, or add `again=True` to replace "
        "the present one"
    )


def _found(known: Mapping[str, Point], name: str) -> Point:
    if name not in known:
        listed = f"known are {', '.join(known)}" if known else "no point has been saved yet"
        raise UnknownPoint(f"there is no point {name!r}: {listed}{suggestion(name, known)}")
    return known[name]


def _require_unchanged(points: Mapping[str, Point], name: str, seen: Point | None) -> None:
    """Raise `PointsChanged` unless the file has this point under a name, or none."""
    now = points.get(check_name(name))
    if now != seen:
        what = "has gone" if now is None else "is new" if seen is None else "was changed"
        raise PointsChanged(f"{name!r} {what} in the file meanwhile; nothing was written")
