"""The named points and sequences of one arm, as a program sees them: a mapping over their file.

The file is read anew for every question, and only the tables that a change concerns are written,
so that what a person or another program writes meanwhile stays.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, MutableMapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from armdrive import places
from armdrive.durable import DISK, Files
from armdrive.errors import BadRequest, PointsChanged, Refused, UnknownPoint
from armdrive.pointfile import PointFile
from armdrive.points import Point, StepList, Taught, check_name
from armdrive.pointwriting import Writer
from kinematics.errors import suggestion

if TYPE_CHECKING:
    from armdrive.armfile import ArmConfig
    from kinematics import Joints, Pose

V = TypeVar("V")


def nobody_there() -> Point:
    """Refuse to say where an arm is that is not connected."""
    raise Refused("the arm is not connected: nobody knows where it stands")


class Points(MutableMapping[str, Point]):
    """`points["pick"]`, `points.teach("pick")`, `del points["pick"]`; see docs/points.md.

    Every call may raise `PointsFileError`, and `UnknownPoint` (a `KeyError`) for a name there is
    not.
    """

    def __init__(
        self,
        path: Path,
        arm: str,
        names: tuple[str, ...],
        fk: Callable[[Joints], Pose],
        here: Callable[[], Point],
        files: Files = DISK,
    ) -> None:
        """Take the points of the arm whose joints are `names`; `here` is where it stands now."""
        self.path = path
        self._file = PointFile(path, names, Writer(arm, fk), files)
        self._here = here

    # -- reading ------------------------------------------------------------------------------

    def read(self) -> Taught:
        """Return all points and sequences as they stand in the file now; none of no file."""
        return self._file.read()

    @property
    def stamp(self) -> tuple[int, int] | None:
        """What changes when the file does, quick to ask for; None of no file."""
        return self._file.stamp

    def __getitem__(self, name: str) -> Point:
        return _found(self.read().points, name, "point")

    def __iter__(self) -> Iterator[str]:
        return iter(self.read().points)

    def __len__(self) -> int:
        return len(self.read().points)

    @property
    def sequences(self) -> Mapping[str, StepList]:
        """The sequences by name, as they stand in the file now."""
        return self.read().sequences

    def sequence(self, name: str) -> StepList:
        """Return a sequence by its name."""
        return _found(self.read().sequences, name, "sequence")

    # -- changing -----------------------------------------------------------------------------

    def teach(self, name: str, *, note: str = "", again: bool = False) -> Point:
        """Name the place where the arm stands now; with `again` a point that there is already.

        Raises `NotReferenced` where nobody knows the place.
        """
        point = replace(self._here(), note=note)
        before = self.read().points.get(check_name(name))
        if before is not None and not again:
            raise BadRequest(f"there is a point {name!r} already: teach it again, or take another")
        if before is not None and not note:
            point = replace(point, note=before.note)
        self.put(name, point, instead_of=before)
        return point

    def __setitem__(self, name: str, point: Point) -> None:
        self._file.change(lambda taught: _with(taught, points={name: point}))

    def __delitem__(self, name: str) -> None:
        self.remove(name, instead_of=self[name])

    def put(self, name: str, point: Point, *, instead_of: Point | None) -> None:
        """Write a point in the place of what was last seen under that name, None for nothing.

        Raises `PointsChanged` where something else stands there now.
        """

        def change(taught: Taught) -> Taught:
            _unchanged(taught.points, name, instead_of)
            return _with(taught, points={name: point})

        self._file.change(change)

    def remove(self, name: str, *, instead_of: Point | None) -> None:
        """Take a point away; raises `BadRequest` while a sequence goes to it."""

        def change(taught: Taught) -> Taught:
            _unchanged(taught.points, name, instead_of)
            if users := taught.users(name):
                raise BadRequest(f"the point {name!r} is used by {', '.join(users)}")
            rest = {other: each for other, each in taught.points.items() if other != name}
            return Taught(rest, taught.sequences)

        self._file.change(change)

    def rename(self, old: str, new: str) -> None:
        """Give a point another name, in the sequences that go to it as well."""

        def change(taught: Taught) -> Taught:
            _found(taught.points, old, "point")
            if check_name(new) in taught.points:
                raise BadRequest(f"there is a point {new!r} already")
            points = {new if name == old else name: each for name, each in taught.points.items()}
            return Taught(
                points, {name: _gone_to(each, old, new) for name, each in taught.sequences.items()}
            )

        self._file.change(change)

    def put_sequence(self, name: str, steps: StepList, *, instead_of: StepList | None) -> None:
        """Write a sequence in the place of what was last seen under that name; see `put`."""

        def change(taught: Taught) -> Taught:
            _unchanged(taught.sequences, name, instead_of)
            return _with(taught, sequences={name: steps})

        self._file.change(change)

    def put_all(
        self, points: Mapping[str, Point], sequences: Mapping[str, StepList], *, again: bool = False
    ) -> None:
        """Write points and sequences at once; with `again` also over others of those names.

        Raises `BadRequest` for a name that is taken, and writes nothing then.
        """

        def change(taught: Taught) -> Taught:
            taken = [name for name in points if name in taught.points]
            taken += [name for name in sequences if name in taught.sequences]
            if taken and not again:
                raise BadRequest(
                    f"there is {', '.join(taken)} already: take another name, or say --again"
                )
            return _with(taught, points=points, sequences=sequences)

        self._file.change(change)

    def remove_sequence(self, name: str, *, instead_of: StepList | None) -> None:
        """Take a sequence away; see `put` for what raises `PointsChanged`."""

        def change(taught: Taught) -> Taught:
            _unchanged(taught.sequences, name, instead_of)
            _found(taught.sequences, name, "sequence")
            rest = {other: each for other, each in taught.sequences.items() if other != name}
            return Taught(taught.points, rest)

        self._file.change(change)


def points_of(config: ArmConfig, here: Callable[[], Point] = nobody_there) -> Points:
    """Return the points of an arm, which need not be connected."""
    geometry = config.model.arm
    path = places.points_file(config.name)
    return Points(path, config.name, geometry.joint_names, geometry.fk, here)


def _found(known: Mapping[str, V], name: str, what: str) -> V:
    if name not in known:
        words = ", ".join(known) or "none"
        hint = suggestion(name, known)
        raise UnknownPoint(f"there is no {what} {name!r}: known are {words}{hint}")
    return known[name]


def _unchanged(known: Mapping[str, V], name: str, seen: V | None) -> None:
    now = known.get(check_name(name))
    if now != seen:
        what = "has gone" if now is None else "is new" if seen is None else "was changed"
        raise PointsChanged(f"{name!r} {what} in the file meanwhile; nothing was written")


def _with(
    taught: Taught,
    points: Mapping[str, Point] | None = None,
    sequences: Mapping[str, StepList] | None = None,
) -> Taught:
    return Taught({**taught.points, **(points or {})}, {**taught.sequences, **(sequences or {})})


def _gone_to(steps: StepList, old: str, new: str) -> StepList:
    renamed = (replace(each, point=new) if each.point == old else each for each in steps.steps)
    return replace(steps, steps=tuple(renamed))
