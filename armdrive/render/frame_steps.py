"""The frames of an arm as they are assigned: joint axes, frames and the points b, step by step."""

from __future__ import annotations

from collections.abc import Iterator

from armdrive.render.camera import VIEWS, Dome
from armdrive.render.canvas import Ink, Layer, Letters, Stroke
from armdrive.render.figure import LETTER
from armdrive.render.scene import SceneSpace, Studio
from kinematics.chains.assignment import Assignment
from kinematics.chains.links import Convention
from kinematics.frames.rotations import columns
from kinematics.frames.transforms import position_of, rotation_of
from kinematics.frames.vectors import Vector, add, distance, scale, subtract

_ARROW = 0.3  # length of a frame's axes, as a share of half the arm's size
_BELOW = 0.09  # distance of an origin's letters from it, as a share of half the arm's size
_AXIS = 0.5  # length of a joint axis to either side of its origin, in the same measure
_LEAST_MM = 10.0  # half the size of an arm whose frames share one origin
_SAME_MM = 1e-3  # texts nearer to each other than this are written side by side

# What the legend calls the dotted lines.
AXIS_WORD = "joint axis"


class StepDrawing:
    """Draws the steps of one assignment, all to the same scale.

    The middle of the arm is the origin of the picture: a camera makes room for the table below
    an arm, and there is none here.
    """

    def __init__(self, found: Assignment) -> None:
        self._found = found
        self._origins = [position_of(frame) for frame in found.frames]
        places = [*self._origins, position_of(found.zero.tool)]
        corners = [(min(axis), max(axis)) for axis in zip(*places, *found.points, strict=True)]
        x, y, z = ((low + high) / 2.0 for low, high in corners)
        self._middle = (x, y, z)
        self._size_mm = max(_LEAST_MM, *(distance(self._middle, place) for place in places))
        self.dome = Dome((0.0, 0.0, 0.0), self._size_mm * (1.0 + _ARROW * LETTER))

    def space(self, index: int, *, linked: bool) -> SceneSpace:
        """Return the picture once frame `index`, or after the frames link `index`, is found.

        It has the frames found by then, the two at the end with axes, the others as origins. The
        frame, or the way along the link, that was just found is thick.
        """
        strokes = [
            Stroke(Ink.REACH, self._line(axis.line.point, axis.line.direction))
            for axis in self._found.zero.axes
        ]
        texts: list[tuple[Vector, str]] = []
        frames = self._frames(len(self._origins) - 1 if linked else index)
        for number in frames:
            texts.append((self._beneath(self._origins[number]), f"L{number}"))
            newest = not linked and number == index
            if number in (index - 1, index):
                for name, axis in self._axes(number, "xyz" if newest else "xz"):
                    ends = self._origins[number], self._end(number, axis, 1.0)
                    ink = Ink.ARM if newest else Ink.AXIS
                    strokes.append(Stroke(ink, tuple(map(self._placed, ends))))
                    texts.append((self._end(number, axis, LETTER), f"{name}{number}"))
        for number, point in enumerate(self._found.points[: index if linked else 0], 1):
            way = (self._origins[number - 1], point, self._origins[number])
            ink = Ink.ARM if number == index else Ink.GRIPPER
            strokes.append(Stroke(ink, tuple(map(self._placed, way))))
            texts.append((self._beneath(point), f"b{number}"))
        written = tuple(
            Letters(Ink.WORD, self._placed(at), text) for at, text in _side_by_side(texts)
        )
        joints = tuple(self._placed(self._origins[number]) for number in frames)
        return SceneSpace(Layer(tuple(strokes), written, joints), reach=AXIS_WORD)

    def rows(
        self, index: int, width: int, height: int, *, linked: bool, braille: bool
    ) -> list[str]:
        """Return the picture as rows of characters, without empty ones at its edges."""
        studio = Studio(self.dome, braille=braille)
        painted = studio.draw(self.space(index, linked=linked), VIEWS["iso"], width, height)
        _, *rows, legend = (row.rstrip() for row in painted.rows())  # without the view's name
        drawn = [index for index, row in enumerate(rows) if row]
        return [*rows[drawn[0] : drawn[-1] + 1], legend] if drawn else [legend]

    def _frames(self, newest: int) -> range:
        """Return the frames found by then: Craig's frame 0 is frame 1, so it comes last."""
        craig = self._found.chain.convention is Convention.CRAIG
        late = craig and newest + 1 < len(self._origins)
        return range(int(late), newest + 1)

    def _axes(self, number: int, shown: str) -> Iterator[tuple[str, Vector]]:
        axes = zip("xyz", columns(rotation_of(self._found.frames[number])), strict=True)
        return ((name, axis) for name, axis in axes if name in shown)

    def _end(self, number: int, axis: Vector, times: float) -> Vector:
        return add(self._origins[number], scale(self._size_mm * _ARROW * times, axis))

    def _line(self, point: Vector, direction: Vector) -> tuple[Vector, Vector]:
        """Return the part of a joint's axis that is in the picture."""
        half = self._size_mm * _AXIS
        ends = add(point, scale(-half, direction)), add(point, scale(half, direction))
        return self._placed(ends[0]), self._placed(ends[1])

    def _beneath(self, point: Vector) -> Vector:
        return add(point, (0.0, 0.0, -self._size_mm * _BELOW))

    def _placed(self, point: Vector) -> Vector:
        return subtract(point, self._middle)


def _side_by_side(texts: list[tuple[Vector, str]]) -> Iterator[tuple[Vector, str]]:
    """Yield texts with those at the same place joined to one."""
    joined: list[tuple[Vector, list[str]]] = []
    for at, text in texts:
        same = next((others for other, others in joined if distance(at, other) < _SAME_MM), None)
        if same is None:
            joined.append((at, [text]))
        else:
            same.append(text)
    for at, others in joined:
        yield at, " ".join(others)
