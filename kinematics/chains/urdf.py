"""An arm from its URDF text, the chain from base to tip with its limits, and an arm as such text.

URDF gives each joint a frame in the link before it, and an axis in that frame. Frame assignment
turns the axes of the zero position into a link table, whose joint values are the URDF's own. What a
chain of links cannot represent is refused; what is read but not used is listed in `unused`.

This reader is our own, built on the standard library's XML parser. The alternatives: yourdfpy
(0.0.60) is maintained, but requires trimesh, scipy, networkx and shapely; urchin and urdfpy require
pycollada and a renderer; urdf_parser_py (0.0.4, from 2021) has no wheel. All of them read far more
than a chain and silently ignore what they do not know. A test compares the text that is written
with what pinocchio reads.

Lengths in mm and angles in rad here, m and rad in the text.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple
from xml.parsers import expat

from kinematics.chains.assignment import EXACTLY_PARALLEL, JointAxis, assign_frames
from kinematics.chains.chain import Chain
from kinematics.chains.links import DHLink, JointKind
from kinematics.errors import KinematicsError, require, suggestion
from kinematics.frames.orientations import RPY, solve_rpy
from kinematics.frames.transforms import (
    IN_PLACE,
    Transform,
    compose,
    homogeneous,
    position_of,
    rotation_of,
    transform_vector,
)
from kinematics.frames.vectors import (
    Vector,
    cross,
    dot,
    norm,
    scale,
    unit,
)

MM_PER_M = 1000.0

# A hundred times the size of an arm's URDF; meshes are files of their own.
MOST_CHARACTERS = 2_000_000

MOST_JOINTS = 200

# Axes within 0.1 degrees of parallel are taken as parallel.
#
# No printed arm is built more exactly. Taken literally, such axes have their common normal, where
# the link table puts a frame, tens of metres away.
STRAIGHT_RAD = 2e-3

# Names of the hand's link: first the one of ROS-Industrial (REP 199).
TIP_NAMES = ("tool0", "tcp", "tool")


@dataclass(frozen=True, slots=True)
class UrdfArm:
    """An arm as its URDF describes it.

    `chain` leads from the link `base` to the link `tip`. `unused` lists, one sentence each, what
    the chain leaves out of the URDF or reads differently.
    """

    name: str
    chain: Chain
    base: str
    tip: str
    unused: tuple[str, ...]


def read_urdf(text: str, *, base: str = "", tip: str = "") -> UrdfArm:
    """Return the arm of a URDF document.

    `base` and `tip` name links. The default base is the link that no joint moves. The default tip
    is a link named as in `TIP_NAMES`, else the link where moving joints branch, as at a gripper,
    else the last link. Raises `KinematicsError` for a document that describes no such chain, and
    for one that is too large or declares a document type.
    """
    robot = _tree(text)
    links = [_name(link, "link") for link in robot.findall("link")]
    above = _joints_by_child(robot, links)
    unused: list[str] = []
    base = base or _root(links, above)
    path = _path(links, above, base, tip, unused)
    axes, tool = _axes_at_zero(path, unused)
    chain = assign_frames(axes, tool, name=robot.get("name") or "arm").chain
    unused += _left_out(robot)
    return UrdfArm(chain.name, chain, base, path[-1].child, tuple(unused))


def _tree(text: str) -> ET.Element:
    require("the URDF", text, str, "'<robot ...>'")
    if len(text) > MOST_CHARACTERS:
        raise KinematicsError(
            f"a URDF has at most {MOST_CHARACTERS} characters, not {len(text)}: meshes belong "
            "into files of their own"
        )
    if "<!DOCTYPE" in text:
        raise KinematicsError(
            "the URDF declares a document type, which can hide entities that grow without end: "
            "remove the <!DOCTYPE ...> from it"
        )
    builder = ET.TreeBuilder()
    parser = expat.ParserCreate()  # without namespaces, which some tools use undeclared
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    try:
        parser.Parse(text, True)
    except (expat.ExpatError, ValueError) as error:
        raise KinematicsError(f"the URDF is not valid XML: {error}") from None
    robot = builder.close()
    if robot.tag != "robot":
        raise KinematicsError(f"a URDF's outer element is <robot>, not <{robot.tag}>")
    for element in robot.iter():
        values = " ".join(element.attrib.values())
        if element.tag.startswith("xacro:") or "${" in values or "$(" in values:
            raise KinematicsError(
                "this is a xacro file, which describes how to make a URDF: make it first, for "
                "example with `xacro arm.urdf.xacro > arm.urdf`"
            )
    return robot


# Links and joints, and the way from the base to the tip.


class _JointElement(NamedTuple):
    """A joint as it stands in the document."""

    name: str
    kind: str
    parent: str
    child: str
    element: ET.Element

    @property
    def moves(self) -> bool:
        return self.kind != "fixed"


JOINT_KINDS = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar")

# The joint that leads to each link.
_Above = dict[str, _JointElement]


def _joints_by_child(robot: ET.Element, links: Sequence[str]) -> _Above:
    """Return the joint that leads to each link. Raises `KinematicsError` for what is no tree."""
    joints = [_joint_element(element, links) for element in robot.findall("joint")]
    if len(joints) > MOST_JOINTS:
        raise KinematicsError(
            f"an arm has at most {MOST_JOINTS} joints, and this URDF {len(joints)}"
        )
    for what, names in (("link", links), ("joint", [one.name for one in joints])):
        doubled = [name for name, count in Counter(names).items() if count > 1]
        if doubled:
            raise KinematicsError(f"the URDF has several {what}s named {doubled[0]!r}")
    above: _Above = {}
    for joint in joints:
        if joint.child in above:
            raise KinematicsError(
                f"link {joint.child!r} is moved by two joints, {above[joint.child].name!r} and "
                f"{joint.name!r}: loops are not arms"
            )
        above[joint.child] = joint
    return above


def _joint_element(element: ET.Element, links: Sequence[str]) -> _JointElement:
    name, kind = _name(element, "joint"), element.get("type", "")
    if kind not in JOINT_KINDS:
        raise KinematicsError(
            f"joint {name!r} is of the type {kind!r}; URDF knows {', '.join(JOINT_KINDS)}"
        )
    ends = []
    for tag in ("parent", "child"):
        found = element.find(tag)
        end = "" if found is None else found.get("link", "")
        if end not in links:
            raise KinematicsError(
                f"joint {name!r} joins a link {end!r} as its {tag}, which the URDF does not "
                f"describe{suggestion(end, links)}"
            )
        ends.append(end)
    return _JointElement(name, kind, ends[0], ends[1], element)


def _name(element: ET.Element, what: str) -> str:
    name = element.get("name", "").strip()
    if not name:
        raise KinematicsError(f"the URDF has a {what} without a name")
    return name


def _root(links: Sequence[str], above: _Above) -> str:
    """Return the link that no joint moves."""
    roots = [link for link in links if link not in above]
    if len(roots) != 1:
        raise KinematicsError(
            "the URDF needs one base, a link that no joint moves, and has "
            f"{', '.join(roots) or 'none'}: name one link as base_link"
        )
    return roots[0]


def _path(
    links: Sequence[str], above: _Above, base: str, tip: str, unused: list[str]
) -> list[_JointElement]:
    """Return the joints from the base to the tip, and note those that are not among them."""
    for key, link in (("base_link", base), ("tip_link", tip)):
        if link and link not in links:
            raise KinematicsError(
                f"the URDF has no link {link!r} for {key}{suggestion(link, links)}"
            )
    ways = [_up(above, name, base) for name in ([tip] if tip else TIP_NAMES)]
    moving = [way for way in ways if way and any(joint.moves for joint in way)]
    if tip and ways[0] is None:
        raise KinematicsError(f"no joints lead from link {base!r} to link {tip!r}")
    path = moving[0] if moving else [] if tip else _down(above, base, unused)
    if not any(joint.moves for joint in path):
        where = f"between {base!r} and {tip!r}" if tip else f"from {base!r} on"
        raise KinematicsError(f"the URDF has no joint {where} that moves: it is no arm")
    aside = [joint.name for joint in above.values() if joint.moves and joint not in path]
    if aside:
        unused.append(
            f"the chain ends at link {path[-1].child!r}; joints that are not part of it: "
            f"{', '.join(aside)} (another end is tip_link in the arm file's [urdf])"
        )
    return path


def _up(above: _Above, tip: str, base: str) -> list[_JointElement] | None:
    """Return the joints from the base to a link, None if none lead there."""
    found: list[_JointElement] = []
    link = tip
    while link != base:
        if link not in above or len(found) > MOST_JOINTS:
            return None
        found.append(above[link])
        link = found[-1].parent
    return found[::-1]


def _down(above: _Above, base: str, unused: list[str]) -> list[_JointElement]:
    """Return the joints along the only branch that moves, then the fixed ones behind it."""
    to_motion = {
        joint.child
        for moving in above.values()
        if moving.moves
        for joint in _up(above, moving.child, base) or ()
    }
    found: list[_JointElement] = []
    while True:
        link = found[-1].child if found else base
        ways = [joint for joint in above.values() if joint.parent == link]
        leading = [joint for joint in ways if joint.child in to_motion]
        if len(leading) > 1 and not any(joint.moves for joint in found):
            names = ", ".join(repr(joint.child) for joint in leading)
            raise KinematicsError(
                f"the URDF branches at link {link!r}, to {names}: name the arm's end as tip_link"
            )
        if not leading and len(ways) > 1:
            ends = ", ".join(joint.child for joint in ways)
            unused.append(
                f"several links are fixed to {link!r} ({ends}); the arm ends there unless "
                "tip_link names one"
            )
        if len(leading or ways) != 1:
            return found
        if len(found) > MOST_JOINTS:
            raise KinematicsError("the joints of the URDF form a loop")
        found.append((leading or ways)[0])


# The joints in numbers: their axes in the zero position.


def _axes_at_zero(
    path: Sequence[_JointElement], unused: list[str]
) -> tuple[list[JointAxis], Transform]:
    """Return the axes of the joints that move in the zero position, and the tip's frame."""
    axes: list[JointAxis] = []
    rounded: dict[str, float] = {}
    frame = IN_PLACE
    for joint in path:
        frame = compose(frame, _origin(joint, rounded))
        if not joint.moves:
            continue
        direction = transform_vector(frame, _axis_of(joint))
        if axes:
            direction = _straightened(axes[-1].direction, direction, joint.name, unused)
        name = _identifier(joint.name, [axis.name for axis in axes], unused)
        kind, low, high = _motion_of(joint, unused)
        axes.append(JointAxis(position_of(frame), direction, kind, name, low, high))
    read = [
        f"{word} as {math.degrees(angle):g}°"
        for word, angle in rounded.items()
        if abs(float(word) - angle) > ROUNDING_RAD
    ]
    if read:
        unused.append(f"rounded angles are read as they are meant: {', '.join(read)}")
    return axes, frame


def _motion_of(joint: _JointElement, unused: list[str]) -> tuple[JointKind, float, float]:
    """Return kind and limits of a joint. Raises `KinematicsError` if no chain has such.

    Exporters write two equal limits for a joint that was given none.
    """
    where = f"joint {joint.name!r}"
    if joint.kind in ("floating", "planar"):
        raise KinematicsError(f"{where} is {joint.kind}: an arm's joints turn or slide")
    mimic = joint.element.find("mimic")
    if mimic is not None:
        raise KinematicsError(
            f"{where} follows joint {mimic.get('joint', '')!r} (mimic), and every joint of a chain "
            "moves by itself: name another tip_link, or the base_link behind it"
        )
    kind = JointKind.PRISMATIC if joint.kind == "prismatic" else JointKind.REVOLUTE
    limit = joint.element.find("limit")
    low, high = (
        _value(limit.get(key, "0") if limit is not None else "0", f"{where}: limit {key}")
        for key in ("lower", "upper")
    )
    if low > high:
        raise KinematicsError(f"{where}: its lower limit {low:g} is above its upper one {high:g}")
    if low == high and joint.kind != "continuous":
        unused.append(f"{where} gives no limits")
    elif joint.kind == "continuous" and low != high:
        unused.append(f"{where} is continuous: URDF ignores its limits")
    if low == high or joint.kind == "continuous":
        return kind, -math.inf, math.inf
    size = MM_PER_M if kind is JointKind.PRISMATIC else 1.0
    return kind, low * size, high * size


def _axis_of(joint: _JointElement) -> Vector:
    words = _words(joint.element.find("axis"), "xyz", "1 0 0", joint)
    axis = _vector(words, joint, "axis xyz")
    if norm(axis) == 0.0:
        raise KinematicsError(f"joint {joint.name!r}: axis xyz 0 0 0 has no direction")
    return unit(axis)


def _origin(joint: _JointElement, rounded: dict[str, float]) -> Transform:
    """Return a joint's frame in the link before it; `rounded` gets the angles as they are read."""
    origin = joint.element.find("origin")
    place = _vector(_words(origin, "xyz", "0 0 0", joint), joint, "origin xyz")
    words = _words(origin, "rpy", "0 0 0", joint)
    written = _vector(words, joint, "origin rpy")
    rounded |= {word: _meant(word, angle) for word, angle in zip(words, written, strict=True)}
    roll, pitch, yaw = (rounded[word] for word in words)
    return homogeneous(RPY(yaw, pitch, roll).rotation(), scale(MM_PER_M, place))


def _words(element: ET.Element | None, key: str, without: str, joint: _JointElement) -> list[str]:
    text = without if element is None else element.get(key, without)
    words = text.split()
    if len(words) != len(without.split()):
        what = "" if element is None else element.tag
        raise KinematicsError(f"joint {joint.name!r}: {what} {key} has three numbers, not {text!r}")
    return words


def _vector(words: Sequence[str], joint: _JointElement, what: str) -> Vector:
    x, y, z = (_value(word, f"joint {joint.name!r}: {what}") for word in words)
    return x, y, z


_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)


def _value(word: str, where: str) -> float:
    if not _NUMBER.fullmatch(word.strip()) or not math.isfinite(float(word)):
        raise KinematicsError(f"{where}: {word!r} is not a number")
    return float(word)


# An angle changed by less was written in full.
ROUNDING_RAD = 1e-9

_TWELFTH = math.pi / 12.0
_QUARTER_IN_TWELFTHS = 6
_LEAST_DECIMALS = 4
_LEAST_DECIMALS_OF_A_QUARTER = 2


def _meant(word: str, angle: float) -> float:
    """Return the multiple of 15 degrees that a number rounds or cuts off; any other as it is.

    1.5708 means a quarter turn: taken literally, axes 100 mm apart that should be parallel would
    meet 27 km away. Short numbers such as 1.57 are only read as quarter turns.
    """
    decimals = len(word.partition(".")[2]) if "e" not in word.lower() else 0
    twelfths = round(angle / _TWELFTH)
    quarter = twelfths % _QUARTER_IN_TWELFTHS == 0
    if decimals < (_LEAST_DECIMALS_OF_A_QUARTER if quarter else _LEAST_DECIMALS):
        return angle
    whole, digit = twelfths * _TWELFTH, 10.0**-decimals
    off = abs(angle) - abs(whole)
    return whole if -digit < off <= digit / 2.0 else angle


def _straightened(before: Vector, direction: Vector, name: str, unused: list[str]) -> Vector:
    """Return the direction, made parallel to the axis before where it nearly is."""
    sine = norm(cross(before, direction))
    if not EXACTLY_PARALLEL < sine <= STRAIGHT_RAD:
        return direction
    unused.append(
        f"joint {name!r}: its axis is {math.degrees(sine):.2g}° off the one before, and is taken "
        "as parallel"
    )
    return scale(math.copysign(1.0, dot(before, direction)), before)


def _identifier(name: str, taken: Sequence[str], unused: list[str]) -> str:
    """Return the joint's name as one word that calls can use: `Revolute 1` is Revolute_1."""
    word = re.sub(r"\W", "_", name, flags=re.ASCII)
    word = f"joint_{word}" if word[0].isdigit() else word
    while word in taken:
        word += "_"
    if word != name:
        unused.append(f"joint {name!r} is called {word} here")
    return word


# What the document holds besides the chain.

_KNOWN = {
    "robot": {"link", "joint"},
    "link": {"visual"},
    "joint": {"parent", "child", "origin", "axis", "limit", "mimic"},
}
_WORDS = {"collision": "collision shapes", "inertial": "masses", "transmission": "transmissions"}


def _left_out(robot: ET.Element) -> Iterator[str]:
    counts: Counter[str] = Counter()
    for element in (robot, *robot.findall("link"), *robot.findall("joint")):
        counts.update(child.tag for child in element if child.tag not in _KNOWN[element.tag])
    if counts:
        said = (f"{_WORDS.get(tag, f'<{tag}>')} ({count})" for tag, count in counts.items())
        yield f"not used: {', '.join(said)}"
    found = (mesh.get("filename") for mesh in robot.iterfind("link/visual/geometry/mesh"))
    meshes = [name for name in found if name]
    if meshes:
        ros = ", named by package:// paths, which only ROS resolves"
        named = ros if any(mesh.startswith("package://") for mesh in meshes) else ""
        yield f"not drawn: mesh files ({len(meshes)}){named}; the arm is drawn as lines"


# An arm as URDF text, for other tools: links in m and rad, joints with their limits.
#
# A chain's link table becomes one joint a row. In URDF a joint sits at its origin and then moves
# about its axis, here always z: its origin is one of the chain's constant frames. Links are drawn
# as cylinders along the way to the next joint and have no masses.

TOOL_JOINT = "tool_joint"
LINK_RADIUS_MM = 15.0
# A link shorter than this is not drawn.
THINNEST_MM = 1e-6


def urdf_of_chain(chain: Chain) -> str:
    """Return the URDF document of a chain.

    URDF wants a speed and an effort of every joint with limits, which a chain does not know: 1
    rad/s or 100 mm/s, and 1. Raises `KinematicsError` for a prismatic joint without limits, which
    URDF has no word for, for a joint named as the tool's, and for a chain of symbols.
    """
    if not chain.is_plain:
        raise KinematicsError("a URDF document is made of plain numbers, not of symbols")
    if TOOL_JOINT in chain.joint_names:
        raise KinematicsError(f"{TOOL_JOINT!r} names the fixed joint of the tool; rename the other")
    origins = chain.constants
    robot = ET.Element("robot", name=chain.name or "arm")
    links = ["base_link", *(f"link_{number}" for number in range(1, len(chain) + 1)), "tool"]
    for link, after in zip(links, [*origins, IN_PLACE], strict=True):
        _add_link(robot, link, position_of(after))
    joints = [*zip(chain.joint_names, chain.links, strict=True), (TOOL_JOINT, None)]
    for (name, row), ends, origin in zip(joints, pairwise(links), origins, strict=True):
        element = ET.SubElement(robot, "joint", name=name, type="fixed")
        for tag, link in zip(("parent", "child"), ends, strict=True):
            ET.SubElement(element, tag, link=link)
        if origin != IN_PLACE:
            angles = solve_rpy(rotation_of(origin)).first
            # URDF's rpy turns about the fixed x, y and z, which is Rz Ry Rx
            rpy = _written(angles.psi_rad, angles.theta_rad, angles.phi_rad)
            ET.SubElement(element, "origin", xyz=_metres(*position_of(origin)), rpy=rpy)
        if row is not None:
            _add_motion(element, name, row)
    ET.indent(robot)
    return '<?xml version="1.0"?>\n' + ET.tostring(robot, encoding="unicode") + "\n"


def _add_link(robot: ET.Element, name: str, after: Vector) -> None:
    """Add a link, drawn from its own joint to the next one where that is somewhere else."""
    link = ET.SubElement(robot, "link", name=name)
    x, y, z = after
    length = norm(after)
    if length > THINNEST_MM:
        visual = ET.SubElement(link, "visual")
        turn = _written(0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x))
        ET.SubElement(visual, "origin", xyz=_metres(x / 2.0, y / 2.0, z / 2.0), rpy=turn)
        geometry = ET.SubElement(visual, "geometry")
        size = {"length": _metres(length), "radius": _metres(LINK_RADIUS_MM)}
        ET.SubElement(geometry, "cylinder", size)


def _add_motion(element: ET.Element, joint: str, link: DHLink) -> None:
    """Add kind, axis and limits (rad or m) of a joint; one that turns without end has none."""
    slides = link.kind is JointKind.PRISMATIC
    if slides and not link.bounded:
        raise KinematicsError(
            f"joint {joint!r} slides without limits; URDF needs them: give its link low and high"
        )
    kind = "prismatic" if slides else "revolute" if link.bounded else "continuous"
    element.set("type", kind)
    ET.SubElement(element, "axis", xyz="0 0 1")
    if link.bounded:
        size = MM_PER_M if slides else 1.0
        limit = {"lower": link.low / size, "upper": link.high / size}
        limit |= {"velocity": 0.1 if slides else 1.0, "effort": 1.0}
        ET.SubElement(element, "limit", {key: _written(one) for key, one in limit.items()})


def _metres(*lengths_mm: float) -> str:
    return _written(*(length / MM_PER_M for length in lengths_mm))


def _written(*values: float) -> str:
    """Write numbers so that reading them gives them back."""
    return " ".join(repr(float(value) + 0.0) for value in values)
