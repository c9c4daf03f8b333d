"""The Jacobian of a named system in its own coordinates, and its singularities with reasons.

A planar arm has no z and a five-axis one no yaw: judged by all six rows of the geometric Jacobian
the first is always singular, and the second never where its tip is over the base. Lengths in mm,
angles in rad, rates per second of whatever the joint is measured in.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from kinematics.chains.chain import Chain
from kinematics.chains.generated import Jacobian, generated
from kinematics.chains.jacobians import ALL_ROWS, dimensionless
from kinematics.chains.singularities import Condition, condition_of, default_rows, length_of
from kinematics.five_axis.singularities import five_axis_singularities, task_jacobian
from kinematics.limits import wrap
from kinematics.spaces import Joints
from kinematics.textbook.systems.mini_movers import Alpha2, MiniBuild, MiniMover
from kinematics.textbook.systems.named import ON_AXIS, System
from kinematics.textbook.systems.puma import BASE_EDGE, BASE_FREE, WRIST_STRAIGHT, Puma
from kinematics.textbook.systems.three_link import ThreeLink
from kinematics.textbook.systems.transporters import (
    CylindricalTransporter,
    RevoluteTransporter,
    SphericalTransporter,
)
from kinematics.textbook.systems.triangle import FOLDED, STRETCHED
from kinematics.textbook.systems.two_link import (
    TwoLinkType1,
    TwoLinkType2,
    TwoLinkType3,
    TwoLinkType4,
)
from kinematics.textbook.worked_example import example_posture

PITCH_ROW, ROLL_ROW = 6, 7
"""Rows that no geometric Jacobian has: those of the five-axis build's own angles."""

ROW_NAMES = ("x", "y", "z", "about x", "about y", "about z", "pitch", "roll")
"""What each row's number stands for."""

_STILL = 1e-9
"""An entry below this moves nothing, in mm or rad a unit of the joint."""

_ROWS: Mapping[str, int] = MappingProxyType(
    {
        "x_mm": 0,
        "y_mm": 1,
        "z_mm": 2,
        "phi_rad": 3,
        "theta_rad": 4,
        "psi_rad": 5,
        "pitch_rad": PITCH_ROW,
        "roll_rad": ROLL_ROW,
    }
)
_IN_THE_PLANE = 5
"""The only angle of a planar arm is about z."""


def own_rows(system: System) -> tuple[int, ...]:
    """Return the numbers of the rows that a system's own coordinates stand for.

    The three angles of a whole orientation stand for turning about x, y and z.
    """
    rows = tuple(_ROWS[name] for name in system.coordinates)
    angles = [row for row in rows if row >= 3]
    planar = angles == [_ROWS["phi_rad"]]
    return (*(row for row in rows if row < 3), *((_IN_THE_PLANE,) if planar else angles))


def own_jacobian(system: System, values: Sequence[float]) -> Jacobian:
    """Return the rows of `own_rows`, a column a joint. Raises as `System.fk` does.

    Pitch and roll of the five-axis build are those of `task_jacobian`, with the roll in the hand.
    """
    checked = system.chain().checked(values)
    if isinstance(system, MiniBuild):
        return _five_axis(system, checked)
    whole = generated(system.chain()).jacobian(checked)
    return tuple(whole[row] for row in own_rows(system))


def chain_rows(chain: Chain) -> tuple[int, ...]:
    """Return the rows that a chain is judged by: `default_rows`, without those it never moves in.

    A planar arm leaves some out; two postures tell which, as good as any others.
    """
    made = generated(chain)
    first = example_posture(chain)
    postures = (first, tuple(0.7 * value for value in first))
    seen = [made.jacobian(posture) for posture in postures]
    return tuple(
        row
        for row in default_rows(chain)
        if any(abs(entry) > _STILL for one in seen for entry in one[row])
    )


def chain_jacobian(
    chain: Chain, values: Sequence[float], rows: Sequence[int] = ALL_ROWS
) -> Jacobian:
    """Return some rows of the geometric Jacobian. Raises as `Chain.fk` does."""
    whole = generated(chain).jacobian(chain.checked(values))
    return tuple(whole[row] for row in rows)


def judged(chain: Chain, jacobian: Jacobian, rows: Sequence[int]) -> Condition:
    """Return how well a posture can move by these rows, mm counted in the length of the arm."""
    positions = [index for index, row in enumerate(rows) if row < 3]
    scaled = dimensionless(jacobian, length_of(chain), chain.kinds, positions)
    return condition_of(chain, scaled, rows)


def _five_axis(system: MiniBuild, values: Sequence[float]) -> Jacobian:
    """Return the task Jacobian with each column in the sense of the system's own joint."""
    zero = tuple(0.0 for _ in values)
    at_zero, at_one = system.relative(zero), system.relative(tuple(1.0 for _ in values))
    senses = [one - none for none, one in zip(at_zero, at_one, strict=True)]
    rows = task_jacobian(system.arm, Joints(tuple(system.relative(tuple(values)))))
    return tuple(
        tuple(entry * sense for entry, sense in zip(row, senses, strict=True)) for row in rows
    )


# The singularities of the named systems: each with its reason in words, and how far away it is.
#
# They are where the system's Jacobian in its own coordinates loses a rank, and nowhere else: the
# determinants are products of the measures below. Sources: McKerrow, chapter 4, section 12; Craig,
# chapter 5.

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


def _five_axis_losses(system: MiniBuild, values: tuple[float, ...]) -> list[Lost]:
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
        MiniMover: _five_axis_losses,
        Alpha2: _five_axis_losses,
        Puma: _puma,
    }
)
"""Who measures which build; the two of slides alone have no singularity and no row."""
