"""Named frames and the transforms known between them: any frame in any other, and closed loops.

Chains of frames follow equations 2.42 to 2.48 of chapter 2, with positions in mm as well as
rotations. Where frames form a loop, one transform of it may be unknown and follows from the rest.
Angles in rad.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType

from kinematics.errors import (
    FramesDisagree,
    FramesNotConnected,
    KinematicsError,
    UnknownFrame,
)
from kinematics.frames.orientations import turn_between
from kinematics.frames.transforms import (
    IN_PLACE,
    Transform,
    check_transform,
    compose,
    inverted,
    position_of,
    rotation_of,
)
from kinematics.frames.vectors import distance

Relation = tuple[str, str]
"""A reference frame, and the frame observed in it."""


@dataclass(frozen=True, slots=True)
class FrameGraph:
    """Frames by name, and what is known of one in another: `{("table", "base"): transform}`.

    Two routes between the same frames must agree within the tolerances, else `FramesDisagree`
    says on which relation and by how much. Raises as `check_transform` does for a transform that
    is none.
    """

    relations: Mapping[Relation, Transform]
    tolerance_mm: float = 1e-6
    tolerance_rad: float = 1e-9
    _neighbours: dict[str, dict[str, Transform]] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        checked = {pair: check_transform(frame) for pair, frame in self.relations.items()}
        neighbours: dict[str, dict[str, Transform]] = {}
        for (reference, name), frame in checked.items():
            neighbours.setdefault(reference, {}).setdefault(name, frame)
            neighbours.setdefault(name, {}).setdefault(reference, inverted(frame))
        object.__setattr__(self, "relations", MappingProxyType(checked))
        object.__setattr__(self, "_neighbours", neighbours)
        self._check_loops()

    @property
    def frames(self) -> tuple[str, ...]:
        """The names of all frames, in the order in which relations mention them."""
        return tuple(self._neighbours)

    def between(self, reference: str, name: str) -> Transform:
        """Return the transform of a frame observed in another, over the fewest relations.

        Raises `UnknownFrame`, or `FramesNotConnected` where nothing known joins the two.
        """
        for frame in (reference, name):
            if frame not in self._neighbours:
                raise UnknownFrame(frame, self.frames)
        seen = []
        for found, placed in self._spread(reference):
            if found == name:
                return placed
            seen.append(found)
        raise FramesNotConnected(reference, name, seen)

    def _spread(self, reference: str) -> Iterator[tuple[str, Transform]]:
        """Yield every frame that is joined to a reference, nearest first, observed in it."""
        placed = {reference: IN_PLACE}
        waiting = [reference]
        for current in waiting:
            yield current, placed[current]
            for name, frame in self._neighbours[current].items():
                if name not in placed:
                    placed[name] = compose(placed[current], frame)
                    waiting.append(name)

    def _check_loops(self) -> None:
        placed: dict[str, tuple[str, Transform]] = {}
        for root in self.frames:
            if root not in placed:
                placed.update((name, (root, frame)) for name, frame in self._spread(root))
        for (reference, name), stated in self.relations.items():
            around = compose(inverted(placed[reference][1]), placed[name][1])
            gap_mm = distance(position_of(around), position_of(stated))
            gap_rad = turn_between(rotation_of(around), rotation_of(stated))
            if gap_mm > self.tolerance_mm or gap_rad > self.tolerance_rad:
                raise FramesDisagree(reference, name, gap_mm, gap_rad)


def solve_loop(left: Sequence[Transform | None], right: Sequence[Transform | None]) -> Transform:
    """Return the one unknown transform, given as None, of two chains that end in the same frame.

    The chains state that the product of `left` equals that of `right`; both start in the same
    frame too. Raises `KinematicsError` unless exactly one of all is None.
    """
    unknowns = [*left, *right].count(None)
    if unknowns != 1:
        raise KinematicsError(
            f"a loop is solved for one unknown transform, not for {unknowns}; give exactly one None"
        )
    if None in right:
        left, right = right, left
    at = left.index(None)
    before = compose(*_known(left[:at]))
    after = compose(*_known(left[at + 1 :]))
    return compose(inverted(before), *_known(right), inverted(after))


def _known(frames: Sequence[Transform | None]) -> tuple[Transform, ...]:
    return tuple(check_transform(frame) for frame in frames if frame is not None)
