"""The singularities of the named systems: each with its reason in words, and how far away it is.

They are where the system's Jacobian in its own coordinates loses a rank, and nowhere else: the
determinants are products of the measures below. Sources: McKerrow, chapter 4, section 12; Craig,
chapter 5. Lengths in mm, angles in rad.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from kinematics.five_axis_singularities import five_axis_singularities
from kinematics.limits import wrap
from kinematics.spaces import Joints
from kinematics.systems.alpha2 import Alpha2
from kinematics.systems.mini_build import MiniBuild
from kinematics.systems.minimover import MiniMover
from kinematics.systems.named_system import ON_AXIS, System
from kinematics.systems.puma import Puma
from kinematics.systems.puma_tables import BASE_EDGE, BASE_FREE, WRIST_STRAIGHT
from kinematics.systems.revolute_transporter import RevoluteTransporter
from kinematics.systems.three_link import ThreeLink
from kinematics.systems.transporters import CylindricalTransporter, SphericalTransporter
from kinematics.systems.triangle import FOLDED, STRETCHED
from kinematics.systems.two_link_lifting import TwoLinkType4
from kinematics.systems.two_link_sliding import TwoLinkType3
from kinematics.systems.two_link_turning import TwoLinkType1, TwoLinkType2

LEVEL = "the link is level: the tip cannot move along it, and arm up and arm down are one"
DRAWN_IN = "the slide is drawn in: turning moves the tip no longer"


@dataclass(frozen=True, slots=True)
class Lost:
    """One singularity: what is lost there, and how far the posture is from it.

    `distance_rad` is the joint move that leads there, None where it takes a slide;
    `distance_mm` is how far the point in question (the tip, the wrist) has to go, None where it
    is no matter of a point.
    """

    reason: str
    distance_rad: float | None
    distance_mm: float | None


def named_singularities(system: System, values: Sequence[float]) -> tuple[Lost, ...]:
    """Return every singularity of a named system, in a fixed order; joint limits not looked at.

    Empty for a system that has none (all slides). Raises as `System.fk` does.
    """
    measure = _MEASURES.get(type(system))
    checked = system.chain().checked(values)
    return tuple(measure(system, checked)) if measure is not None else ()


def _elbow(bend_rad: float, first_mm: float, second_mm: float) -> list[Lost]:
    """Return how far an elbow of two links is from being straight, and from being folded."""
    bend = abs(wrap(bend_rad))
    square = first_mm**2 + second_mm**2 + 2.0 * first_mm * second_mm * math.cos(bend)
    span = math.sqrt(max(square, 0.0))
    return [
        Lost(f"elbow {STRETCHED}", bend, max(first_mm + second_mm - span, 0.0)),
        Lost(f"elbow {FOLDED}", math.pi - bend, max(span - abs(first_mm - second_mm), 0.0)),
    ]


def _line(angle_rad: float) -> float:
    """Return how far an angle is from a multiple of half a turn."""
    return abs(math.remainder(angle_rad, math.pi))


def _five_axis(system: MiniBuild, values: tuple[float, ...]) -> list[Lost]:
    found = five_axis_singularities(system.arm, Joints(tuple(system.relative(values))))
    order = sorted(found, key=lambda one: one.singularity.name)
    return [Lost(one.singularity.value, one.distance_rad, one.distance_mm) for one in order]


def _turret(system: TwoLinkType2, values: tuple[float, ...]) -> list[Lost]:
    out = abs(system.l2_mm * math.cos(values[1]))
    return [Lost(ON_AXIS, _line(values[1] - math.pi / 2.0), out)]


def _lifted(system: TwoLinkType4, values: tuple[float, ...]) -> list[Lost]:
    short = system.l2_mm * (1.0 - abs(math.cos(values[1])))
    return [Lost(LEVEL, _line(values[1]), short)]


def _sphere(_system: SphericalTransporter, values: tuple[float, ...]) -> list[Lost]:
    _, theta, r = values
    return [
        Lost(ON_AXIS, _line(theta - math.pi / 2.0), abs(r * math.cos(theta))),
        Lost(DRAWN_IN, None, abs(r)),
    ]


def _revolute(system: RevoluteTransporter, values: tuple[float, ...]) -> list[Lost]:
    _, second, third = values
    lean = math.sin(second) * system.l2_mm + math.sin(second + third) * system.l3_mm
    return [*_elbow(third, system.l2_mm, system.l3_mm), Lost(ON_AXIS, None, abs(lean))]


def _puma(system: Puma, values: tuple[float, ...]) -> list[Lost]:
    _, second, third, _, fifth, _ = values
    both = second + third
    out = system.a1_mm + system.a2_mm * math.cos(second)
    out += system.a3_mm * math.cos(both) + system.d4_mm * math.sin(both)
    forearm = math.hypot(system.a3_mm, system.d4_mm)
    bend = third - math.atan2(system.d4_mm, system.a3_mm)
    return [
        *_elbow(bend, system.a2_mm, forearm),
        Lost(WRIST_STRAIGHT, _line(fifth), None),
        Lost(BASE_EDGE if system.d2_mm else BASE_FREE, None, abs(out)),
    ]


_MEASURES: Mapping[type[System], Callable[[Any, tuple[float, ...]], list[Lost]]] = MappingProxyType(
    {
        TwoLinkType1: lambda one, at: _elbow(at[1], one.l1_mm, one.l2_mm),
        TwoLinkType2: _turret,
        TwoLinkType3: lambda one, at: [Lost(ON_AXIS, None, abs(at[1]))],  # noqa: ARG005
        TwoLinkType4: _lifted,
        ThreeLink: lambda one, at: _elbow(at[1], one.l1_mm, one.l2_mm),
        CylindricalTransporter: lambda one, at: [Lost(ON_AXIS, None, abs(at[2]))],  # noqa: ARG005
        SphericalTransporter: _sphere,
        RevoluteTransporter: _revolute,
        MiniMover: _five_axis,
        Alpha2: _five_axis,
        Puma: _puma,
    }
)
"""Who measures which build; the two of slides alone have no singularity and no row."""
