"""One arm as it is to be drawn in space, from moment to moment: what changed is made anew.

It keeps the way that the tip has gone, and the outlines of the reach that were worked out.
"""

from __future__ import annotations

import math
from collections import OrderedDict
from dataclasses import dataclass

from armdrive.draw.figure import Stance, dome, figure, ghost, stance
from armdrive.draw.inks import Ink, Layer, Stroke
from armdrive.draw.outline import Key, Outline, in_plane, key_of, outline
from armdrive.draw.studio import Space
from armdrive.draw.surroundings import surroundings
from armdrive.draw.trail import Trail
from kinematics import ArmModel
from kinematics.five_axis.arm import FiveAxisArm
from kinematics.geometry import Point
from kinematics.spaces import Joints

MOST_OUTLINES = 128
"""Outlines of the reach that are kept: about a hundred kilobytes each at most."""

PLANE_DEG = 3
"""The outline is laid in the nearest plane that is a multiple of this: a dot or two off."""

_NO_LAYER = Layer()


@dataclass(frozen=True, slots=True)
class Moment:
    """What is known of the arm at one moment, and what is wanted of it.

    `joints` are None while nobody knows the posture. `goal` is drawn as a ghost, `planned` as the
    way there: points of the tip in mm. `goal_opening_mm` is how far its fingers are open.
    """

    joints: Joints | None = None
    opening_mm: float | None = None
    goal: Joints | None = None
    goal_opening_mm: float | None = None
    planned: tuple[Point, ...] = ()


class Scene:
    """Makes the layers of one arm. Only `work_out` may be called from another thread."""

    def __init__(self, model: ArmModel) -> None:
        self.arm = model.arm
        self.dome = dome(model.arm)
        self.trail = Trail(self.dome.reach_mm)
        self.tip: Point | None = None
        self._backdrop = (surroundings(model.arm, model.guards, self.dome),)
        self._ahead: tuple[Layer, ...] = ()
        self._wanted_ahead: tuple[Joints | None, float | None, tuple[Point, ...]] | None = None
        self._outlines: OrderedDict[Key, Outline] = OrderedDict()
        self._outline: Outline | None = None
        self._wanted: Key | None = None
        self._azimuth_deg = 0
        self._reach = _NO_LAYER
        self._reach_of: tuple[Outline | None, int] = (None, 0)

    @property
    def missing(self) -> Key | None:
        """The outline that should be worked out now; None where it is there, or not wanted."""
        return None if self._wanted in self._outlines else self._wanted

    def stance(self, joints: Joints, opening_mm: float | None) -> Stance:
        """Return where everything of the arm is in a posture."""
        return stance(self.arm, joints, opening_mm, self.dome.reach_mm)

    def work_out(self, key: Key) -> Outline:
        """Work an outline out, which takes some hundredths of a second; changes nothing here."""
        return outline(self.arm, key)

    def keep(self, key: Key, found: Outline) -> None:
        """Draw this outline where it is wanted, from now on."""
        self._outlines[key] = found
        while len(self._outlines) > MOST_OUTLINES:
            self._outlines.popitem(last=False)

    def space(self, moment: Moment, notice: str = "") -> Space:
        """Return what there is to see; `notice` is said while nobody knows the posture."""
        self._want(moment)
        if moment.joints is None:
            self.trail.add(None)
            self.tip = None
            return Space((self._backdrop, self._ahead, self.trail.full, ()), notice=notice)
        here = self.stance(moment.joints, moment.opening_mm)
        self.tip = here.tip
        self.trail.add(here.tip)
        self._turn_reach(moment.joints)
        words = self._outline.words if self._outline is not None else ""
        moving = (self.trail.latest, figure(here))
        sheets = (self._backdrop, self._ahead, self.trail.full, (self._reach,), moving)
        return Space(sheets, words)

    def _want(self, moment: Moment) -> None:
        """Draw the way that is planned and the ghost at its end, where they are other ones."""
        wanted = (moment.goal, moment.goal_opening_mm, moment.planned)
        if wanted == self._wanted_ahead:
            return
        self._wanted_ahead = wanted
        way = (Stroke(Ink.PLANNED, moment.planned),) if len(moment.planned) > 1 else ()
        layers = [Layer(way)]
        if moment.goal is not None:
            layers.append(ghost(self.stance(moment.goal, moment.goal_opening_mm)))
        self._ahead = tuple(layers)

    def _turn_reach(self, joints: Joints) -> None:
        """Lay this posture's outline in the arm's plane; the last one as long as it is missing."""
        azimuth_rad = self._azimuth_rad(joints)
        self._wanted = key_of(self.arm, self.arm.fk(joints).pitch_rad, azimuth_rad)
        found = self._outlines.get(self._wanted)
        if found is not None:
            self._outline = found
            self._outlines.move_to_end(self._wanted)
        turned = (self._outline, round(math.degrees(azimuth_rad) / PLANE_DEG) * PLANE_DEG)
        if self._outline is not None and turned != self._reach_of:
            self._reach_of = turned
            self._reach = in_plane(self._outline, self.dome.centre, math.radians(turned[1]))

    def _azimuth_rad(self, joints: Joints) -> float:
        """Return which way the arm's plane lies: by its base, or by where its tip is."""
        if isinstance(self.arm, FiveAxisArm):
            return joints[0]
        assert self.tip is not None  # noqa: S101 - `space` has set it
        x, y, _ = self.dome.centre
        return math.atan2(self.tip[1] - y, self.tip[0] - x)
