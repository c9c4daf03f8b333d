"""The frames of an arm as they are assigned: joint axes, frames and the points b, step by step."""

from __future__ import annotations

from collections.abc import Iterator

from armdrive.render.camera import VIEWS, Dome
from armdrive.render.canvas import Ink, Layer, Letters, Stroke
from armdrive.render.figure import LETTER
from armdrive.render.scene import SceneSpace, Studio
from kinematics.chains.assignment import Assignment, FoundFrame, KnownFrames
from kinematics.frames.rotations import columns
from kinematics.frames.transforms import position_of, rotation_of
from kinematics.frames.vectors import Vector, add, distance, scale, subtract

_ARROW = 0.3  # length of a frame's axes, as a share of half the arm's size
_BELOW = 0.09  # distance of an origin's letters from it, as a share of half the arm's size
_AXIS = 0.5  # length of a joint axis to either side of its origin, in the same measure
_LEAST_MM = 10.0  # half the size of an arm whose frames share one origin
_SAME_MM = 1e-3  # texts nearer to each other than this are written side by side

AXIS_WORD = "joint axis"
"""What the legend calls the dotted lines."""


class StepDrawing:
    """Draws the steps of one assignment, all to the same scale.

    The middle of the arm is the origin of the picture: a camera makes room for the table below
    an arm, and there is none here.
    """

    def __init__(self, found: Assignment) -> None:
        origins = [position_of(frame) for frame in (*found.frames, found.zero.tool)]
        corners = [(min(axis), max(axis)) for axis in zip(*origins, *found.points, strict=True)]
        x, y, z = ((low + high) / 2.0 for low, high in corners)
        self._middle = (x, y, z)
        self._size_mm = max(_LEAST_MM, *(distance(self._middle, origin) for origin in origins))
        self._lines = [axis.line for axis in found.zero.axes]
        self.dome = Dome((0.0, 0.0, 0.0), self._size_mm * (1.0 + _ARROW * LETTER))

    def space(self, known: KnownFrames) -> SceneSpace:
        """Return the picture of a step: the frames that it is about with axes, the others' origins.

        The frame, or the way along the link, that is being found is thick.
        """
        strokes = [
            Stroke(Ink.REACH, self._line(line.point, line.direction)) for line in self._lines
        ]
        texts: list[tuple[Vector, str]] = []
        for frame in known.frames:
            strokes += self._arrows(frame, known)
            texts += self._names(frame, known)
        origins = {each.number: position_of(each.frame) for each in known.frames}
        for number, point in enumerate(known.points, 1):
            way = (origins[number - 1], point, origins[number])
            ink = Ink.ARM if number == len(known.points) else Ink.GRIPPER
            strokes.append(Stroke(ink, tuple(map(self._placed, way))))
            texts.append((self._beneath(point), f"b{number}"))
        written = tuple(
            Letters(Ink.WORD, self._placed(at), text) for at, text in _side_by_side(texts)
        )
        joints = tuple(
            self._placed(origins[each.number]) for each in known.frames if "o" in each.parts
        )
        return SceneSpace(Layer(tuple(strokes), written, joints), reach=AXIS_WORD)

    def rows(self, known: KnownFrames, width: int, height: int, *, braille: bool) -> list[str]:
        """Return the picture of a step as rows of characters, without empty ones at its edges."""
        studio = Studio(self.dome, braille=braille)
        painted = studio.draw(self.space(known), VIEWS["iso"], width, height)
        _, *rows, legend = (row.rstrip() for row in painted.rows())  # without the view's name
        drawn = [index for index, row in enumerate(rows) if row]
        return [*rows[drawn[0] : drawn[-1] + 1], legend] if drawn else [legend]

    def _arrows(self, found: FoundFrame, known: KnownFrames) -> Iterator[Stroke]:
        ink = Ink.ARM if known.is_new(found) else Ink.AXIS
        for name, axis in _axes(found, known):
            if "o" in found.parts:
                ends = position_of(found.frame), self._end(found, axis, 1.0)
                yield Stroke(ink, tuple(map(self._placed, ends)))
            elif name == "z":  # the origin is not known yet, only the line that z lies on
                yield Stroke(ink, self._line(position_of(found.frame), axis))

    def _names(self, found: FoundFrame, known: KnownFrames) -> Iterator[tuple[Vector, str]]:
        if "o" not in found.parts:
            return
        yield self._beneath(position_of(found.frame)), f"L{found.number}"
        for name, axis in _axes(found, known):
            yield self._end(found, axis, LETTER), f"{name}{found.number}"

    def _end(self, found: FoundFrame, axis: Vector, times: float) -> Vector:
        return add(position_of(found.frame), scale(self._size_mm * _ARROW * times, axis))

    def _line(self, point: Vector, direction: Vector) -> tuple[Vector, Vector]:
        """Return the part of a joint's axis that is in the picture."""
        half = self._size_mm * _AXIS
        ends = add(point, scale(-half, direction)), add(point, scale(half, direction))
        return self._placed(ends[0]), self._placed(ends[1])

    def _beneath(self, point: Vector) -> Vector:
        return add(point, (0.0, 0.0, -self._size_mm * _BELOW))

    def _placed(self, point: Vector) -> Vector:
        return subtract(point, self._middle)


def _axes(found: FoundFrame, known: KnownFrames) -> list[tuple[str, Vector]]:
    """Return the axes of a frame to draw: y only of a new frame, none of a frame further away."""
    if found.number not in (known.index - 1, known.index):
        return []
    shown = found.parts if known.is_new(found) else "xz"
    axes = zip("xyz", columns(rotation_of(found.frame)), strict=True)
    return [(name, axis) for name, axis in axes if name in shown and name in found.parts]


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
