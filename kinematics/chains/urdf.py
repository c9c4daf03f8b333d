"""An arm as URDF text, for other tools: links in m and rad, joints with their limits.

A chain's link table becomes one joint a row. In URDF a joint sits at its origin and then moves
about its axis, here always z; so in the standard convention a row's constant part moves on into
the next joint's origin, and in Craig's it is the joint's own. Links are drawn as cylinders along
the way to the next joint and have no masses. Lengths in mm and angles in rad here, m in the text.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.errors import KinematicsError, finite
from kinematics.frames.numbers import is_own_kind
from kinematics.frames.orientations import solve_rpy
from kinematics.frames.transforms import IN_PLACE, Transform, compose, position_of, rotation_of

MM_PER_M = 1000.0
TOOL_JOINT = "tool_joint"
THINNEST_MM = 1e-6
"""A link shorter than this is not drawn."""


def urdf_of_chain(
    chain: Chain,
    *,
    name: str = "",
    speeds: Sequence[float] | None = None,
    efforts: Sequence[float] | None = None,
    link_radius_mm: float = 15.0,
) -> str:
    """Return the URDF document of a chain.

    URDF wants a speed (rad/s or mm/s here) and an effort (N m or N) of every joint with limits;
    1 rad/s, 100 mm/s and 1 where none are given. Raises `KinematicsError` for a prismatic joint
    without limits, which URDF has no word for, for a joint named as the tool's, and for a chain of
    symbols.
    """
    robot = ET.Element("robot", name=name or chain.name or "arm")
    origins = _origins(chain)
    if TOOL_JOINT in chain.joint_names:
        raise KinematicsError(f"{TOOL_JOINT!r} names the fixed joint of the tool; rename the other")
    links = ["base_link", *(f"link_{number}" for number in range(1, len(chain) + 1)), "tool"]
    for link, after in zip(links, [*origins, None], strict=True):
        _add_link(robot, link, after, finite("link_radius_mm", link_radius_mm))
    for index, joint in enumerate(chain.joint_names):
        element = _add_joint(robot, joint, _kind(chain.links[index]), links[index : index + 2])
        _add_origin(element, origins[index])
        ET.SubElement(element, "axis", xyz="0 0 1")
        _add_limit(
            element,
            joint,
            chain.links[index],
            None if speeds is None else speeds[index],
            1.0 if efforts is None else efforts[index],
        )
    _add_origin(_add_joint(robot, TOOL_JOINT, "fixed", links[-2:]), origins[-1])
    ET.indent(robot)
    return '<?xml version="1.0"?>\n' + ET.tostring(robot, encoding="unicode") + "\n"


def _origins(chain: Chain) -> list[Transform]:
    """Return where each joint sits in the link before it, and last the tool in its link."""
    if any(is_own_kind(one) for link in chain.links for one in link.parameters(0.0)):
        raise KinematicsError("a URDF document is made of plain numbers, not of symbols")
    rows = chain.matrices(chain.zero)
    if chain.convention is Convention.CRAIG:
        return [compose(chain.base, rows[0]), *rows[1:], chain.tool]
    return [chain.base, *rows[:-1], compose(rows[-1], chain.tool)]


def _kind(link: DHLink) -> str:
    if link.kind is JointKind.PRISMATIC:
        return "prismatic"
    return "revolute" if link.bounded else "continuous"


def _add_link(robot: ET.Element, name: str, after: Transform | None, radius_mm: float) -> None:
    """Add a link, drawn from its own joint to the next one where that is somewhere else."""
    link = ET.SubElement(robot, "link", name=name)
    if after is None:
        return
    x, y, z = position_of(after)
    length = math.hypot(x, y, z)
    if length <= THINNEST_MM:
        return
    visual = ET.SubElement(link, "visual")
    turn = 0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x)
    ET.SubElement(visual, "origin", xyz=_metres(x / 2.0, y / 2.0, z / 2.0), rpy=_numbers(*turn))
    geometry = ET.SubElement(visual, "geometry")
    ET.SubElement(geometry, "cylinder", length=_metres(length), radius=_metres(radius_mm))


def _add_joint(robot: ET.Element, name: str, kind: str, links: Sequence[str]) -> ET.Element:
    joint = ET.SubElement(robot, "joint", name=name, type=kind)
    parent, child = links
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)
    return joint


def _add_origin(joint: ET.Element, frame: Transform) -> None:
    """Add an origin; URDF's rpy turns about the fixed x, y and z, which is Rz Ry Rx."""
    if frame == IN_PLACE:
        return
    angles = solve_rpy(rotation_of(frame)).first
    ET.SubElement(
        joint,
        "origin",
        xyz=_metres(*position_of(frame)),
        rpy=_numbers(angles.psi_rad, angles.theta_rad, angles.phi_rad),
    )


def _add_limit(
    element: ET.Element, joint: str, link: DHLink, speed: float | None, effort: float
) -> None:
    """Add the limits, in rad or m; a joint that turns without end has none."""
    if link.kind is JointKind.REVOLUTE:
        if not link.bounded:
            return
        scale, usual = 1.0, 1.0
    elif link.bounded:
        scale, usual = MM_PER_M, 100.0
    else:
        raise KinematicsError(
            f"joint {joint!r} slides without limits; URDF needs them: give its link low and high"
        )
    ET.SubElement(
        element,
        "limit",
        lower=_numbers(link.low / scale),
        upper=_numbers(link.high / scale),
        velocity=_numbers(finite("speed", usual if speed is None else speed) / scale),
        effort=_numbers(finite("effort", effort)),
    )


def _metres(*lengths_mm: float) -> str:
    return _numbers(*(length / MM_PER_M for length in lengths_mm))


def _numbers(*values: float) -> str:
    """Write numbers so that reading them gives them back."""
    return " ".join(repr(float(value) + 0.0) for value in values)
