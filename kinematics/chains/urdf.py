"""An arm from its URDF text, the chain from base to tip with its limits, and an arm as such text.

URDF gives each joint a frame in the link before it, and an axis in that frame. Frame assignment
turns the axes of the zero position into a link table, whose joint values are the URDF's own. What a
chain of links cannot represent is refused; what is read but not used is listed in `unused`.

This reader is our own, built on the standard library's XML parser. The alternatives: yourdfpy
(0.0.60) is maintained, but requires trimesh, scipy, networkx and shapely; urchin and urdfpy require
pycollada and a renderer; urdf_parser_py (0.0.4, from 2021) has no wheel. All of them read far more
than a chain and silently ignore what they do not know. Tests compare this reader with yourdfpy and
pinocchio.

Lengths in mm and angles in rad here, m and rad in the text.
"""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.parsers import expat

from kinematics.chains.assignment import EXACTLY_PARALLEL, JointAxis, assign_frames
from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.errors import KinematicsError, require, suggestion
from kinematics.frames.orientations import RPY, AxisAngle, solve_rpy
from kinematics.frames.rotations import IDENTITY
from kinematics.frames.transforms import (
    IN_PLACE,
    Transform,
    compose,
    homogeneous,
    position_of,
    rotation_of,
    transform_vector,
)
from kinematics.frames.vectors import ZERO, Vector, cross, distance, dot, norm, scale, unit

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
    if robot.tag != "robot":
        raise KinematicsError(f"a URDF's outer element is <robot>, not <{robot.tag}>")
    _refuse_xacro(robot)
    unused: list[str] = []
    tree = _KinematicTree.of(robot)
    base = base or tree.root()
    path = tree.path(base, tip, unused)
    joints = tuple(_moving_joint(joint, unused) for joint in path)
    unused += _rounded_angles(path)
    axes, tool = _axes_at_zero(joints, unused)
    chain = assign_frames(axes, tool, name=robot.get("name") or "arm").chain
    off_mm = _deviation_mm(chain, joints)
    if off_mm > DEVIATION_MM:
        unused.append(f"axes taken as parallel move the tip by some {off_mm:.2g} mm")
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
    return builder.close()


def _refuse_xacro(robot: ET.Element) -> None:
    for element in robot.iter():
        values = " ".join(element.attrib.values())
        if element.tag.startswith("xacro:") or "${" in values or "$(" in values:
            raise KinematicsError(
                "this is a xacro file, which describes how to make a URDF: make it first, for "
                "example with `xacro arm.urdf.xacro > arm.urdf`"
            )


# Links and joints, and the way from the base to the tip.


@dataclass(frozen=True, slots=True)
class _JointElement:
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


@dataclass(frozen=True, slots=True)
class _KinematicTree:
    """The links' names, the joint that leads to each link, and the joints that leave it."""

    links: tuple[str, ...]
    above: dict[str, _JointElement]
    below: dict[str, tuple[_JointElement, ...]]

    @classmethod
    def of(cls, robot: ET.Element) -> _KinematicTree:
        links = tuple(_name(link, "link") for link in robot.findall("link"))
        joints = [_joint_element(element) for element in robot.findall("joint")]
        for what, names in (("link", links), ("joint", tuple(one.name for one in joints))):
            doubled = [name for name, count in Counter(names).items() if count > 1]
            if doubled:
                raise KinematicsError(f"the URDF has several {what}s named {doubled[0]!r}")
        if len(joints) > MOST_JOINTS:
            raise KinematicsError(
                f"an arm has at most {MOST_JOINTS} joints, and this URDF {len(joints)}"
            )
        above: dict[str, _JointElement] = {}
        for joint in joints:
            for end in (joint.parent, joint.child):
                if end not in links:
                    raise KinematicsError(
                        f"joint {joint.name!r} joins a link {end!r}, which the URDF does not "
                        f"describe{suggestion(end, links)}"
                    )
            if joint.child in above:
                raise KinematicsError(
                    f"link {joint.child!r} is moved by two joints, {above[joint.child].name!r} and "
                    f"{joint.name!r}: loops are not arms"
                )
            above[joint.child] = joint
        below = {link: tuple(one for one in joints if one.parent == link) for link in links}
        return cls(links, above, below)

    def root(self) -> str:
        """Return the link that no joint moves."""
        roots = [link for link in self.links if link not in self.above]
        if len(roots) == 1:
            return roots[0]
        if not self.links:
            raise KinematicsError("the URDF describes no link")
        raise KinematicsError(
            f"the URDF has several bases ({', '.join(roots)}): name one as base_link"
            if roots
            else "the joints of the URDF form a loop, so that it has no base"
        )

    def path(self, base: str, tip: str, unused: list[str]) -> tuple[_JointElement, ...]:
        """Return the joints from the base to the tip, and note those that are not among them."""
        for key, link in (("base_link", base), ("tip_link", tip)):
            if link and link not in self.links:
                raise KinematicsError(
                    f"the URDF has no link {link!r} for {key}{suggestion(link, self.links)}"
                )
        joints = self._up(tip, base) if tip else self._to_named_tip(base)
        if joints is None and tip:
            raise KinematicsError(f"no joints lead from link {base!r} to link {tip!r}")
        if joints is None:
            joints = self._down(base, unused)
        if not any(joint.moves for joint in joints):
            where = f"between {base!r} and {tip!r}" if tip else f"from {base!r} on"
            raise KinematicsError(f"the URDF has no joint {where} that moves: it is no arm")
        end = joints[-1].child
        on_path = {base, *(joint.child for joint in joints)}
        aside = [
            joint.name
            for joint in self.above.values()
            if joint.moves and joint.child not in on_path
        ]
        if aside:
            unused.append(
                f"the chain ends at link {end!r}; joints that are not part of it: "
                f"{', '.join(aside)} (another end is tip_link in the arm file's [urdf])"
            )
        return joints

    def _up(self, tip: str, base: str) -> tuple[_JointElement, ...] | None:
        """Return the joints from the base to a link, None if none lead there."""
        found: list[_JointElement] = []
        link = tip
        while link != base:
            if link not in self.above or len(found) > MOST_JOINTS:
                return None
            found.append(self.above[link])
            link = found[-1].parent
        return tuple(reversed(found))

    def _to_named_tip(self, base: str) -> tuple[_JointElement, ...] | None:
        """Return the joints to the first of `TIP_NAMES` that moves against the base, if any."""
        ways = (self._up(name, base) for name in TIP_NAMES if name in self.links)
        return next((way for way in ways if way and any(one.moves for one in way)), None)

    def _down(self, base: str, unused: list[str]) -> tuple[_JointElement, ...]:
        """Return the joints along the only branch that moves, then the fixed ones behind it."""
        found: list[_JointElement] = []
        link = base
        while len(found) <= MOST_JOINTS:
            ways = self.below[link]
            moving = [joint for joint in ways if self._leads_to_motion(joint)]
            if len(moving) > 1:
                if any(joint.moves for joint in found):
                    return tuple(found)
                names = ", ".join(repr(joint.child) for joint in moving)
                raise KinematicsError(
                    f"the URDF branches at link {link!r}, to {names}: name the arm's end as "
                    "tip_link"
                )
            if not moving and len(ways) > 1:
                ends = ", ".join(joint.child for joint in ways)
                unused.append(
                    f"several links are fixed to {link!r} ({ends}); the arm ends there unless "
                    "tip_link names one"
                )
                return tuple(found)
            if not ways:
                return tuple(found)
            found.append((moving or ways)[0])
            link = found[-1].child
        raise KinematicsError("the joints of the URDF form a loop")

    def _leads_to_motion(self, joint: _JointElement) -> bool:
        """Return whether this joint or any joint after it moves."""
        waiting, seen = [joint], 0
        while waiting and seen <= MOST_JOINTS:
            one = waiting.pop()
            seen += 1
            if one.moves:
                return True
            waiting += self.below[one.child]
        return False


def _joint_element(element: ET.Element) -> _JointElement:
    name, kind = _name(element, "joint"), element.get("type", "")
    if kind not in JOINT_KINDS:
        raise KinematicsError(
            f"joint {name!r} is of the type {kind!r}; URDF knows {', '.join(JOINT_KINDS)}"
        )
    ends = []
    for tag in ("parent", "child"):
        end = element.find(tag)
        if end is None or not end.get("link"):
            raise KinematicsError(f"joint {name!r} does not say which link is its {tag}")
        ends.append(str(end.get("link")))
    return _JointElement(name, kind, ends[0], ends[1], element)


def _name(element: ET.Element, what: str) -> str:
    name = element.get("name", "").strip()
    if not name:
        raise KinematicsError(f"the URDF has a {what} without a name")
    return name


# One joint in numbers.


@dataclass(frozen=True, slots=True)
class _UrdfJoint:
    """A joint's frame in the link before, its axis there, and its limits in rad or mm.

    `kind` is None for a joint that is fixed.
    """

    name: str
    kind: JointKind | None
    origin: Transform
    axis: Vector
    low: float = -math.inf
    high: float = math.inf

    def frame(self, value: float) -> Transform:
        """Return the frame of the link behind the joint in the one before it."""
        if self.kind is JointKind.REVOLUTE:
            return compose(self.origin, homogeneous(AxisAngle(self.axis, value).rotation(), ZERO))
        return compose(self.origin, homogeneous(IDENTITY, scale(value, self.axis)))


def _moving_joint(joint: _JointElement, unused: list[str]) -> _UrdfJoint:
    """Return a joint of the arm. Raises `KinematicsError` for one that no chain can have."""
    where = f"joint {joint.name!r}"
    origin = _origin(joint.element, where)
    if joint.kind == "fixed":
        return _UrdfJoint(joint.name, None, origin, ZERO)
    if joint.kind in ("floating", "planar"):
        raise KinematicsError(f"{where} is {joint.kind}: an arm's joints turn or slide")
    mimic = joint.element.find("mimic")
    if mimic is not None:
        raise KinematicsError(
            f"{where} follows joint {mimic.get('joint', '')!r} (mimic), and every joint of a chain "
            "moves by itself: name another tip_link, or the base_link behind it"
        )
    slides = joint.kind == "prismatic"
    axis = _numbers(joint.element.find("axis"), "xyz", (1.0, 0.0, 0.0), f"{where}: axis")
    if norm(axis) == 0.0:
        raise KinematicsError(f"{where}: axis xyz 0 0 0 has no direction")
    low, high = _limits(joint, where, unused)
    unit_size = MM_PER_M if slides else 1.0
    return _UrdfJoint(
        joint.name,
        JointKind.PRISMATIC if slides else JointKind.REVOLUTE,
        origin,
        unit(axis),
        low * unit_size,
        high * unit_size,
    )


def _limits(joint: _JointElement, where: str, unused: list[str]) -> tuple[float, float]:
    """Return the lowest and the highest value, in rad or m.

    Exporters write two equal limits for a joint that was given none.
    """
    limit = joint.element.find("limit")
    low = _number(limit, "lower", 0.0, f"{where}: limit")
    high = _number(limit, "upper", 0.0, f"{where}: limit")
    if joint.kind == "continuous":
        if low != high:
            unused.append(f"{where} is continuous: URDF ignores its limits")
        return -math.inf, math.inf
    if low > high:
        raise KinematicsError(f"{where}: its lower limit {low:g} is above its upper one {high:g}")
    if low == high:
        unused.append(f"{where} gives no limits")
        return -math.inf, math.inf
    return low, high


def _origin(element: ET.Element, where: str) -> Transform:
    origin = element.find("origin")
    if origin is None:
        return IN_PLACE
    place = _numbers(origin, "xyz", ZERO, f"{where}: origin")
    written = _numbers(origin, "rpy", ZERO, f"{where}: origin")
    words = origin.get("rpy", "0 0 0").split()
    roll, pitch, yaw = (_meant(word, angle) for word, angle in zip(words, written, strict=True))
    return homogeneous(RPY(yaw, pitch, roll).rotation(), scale(MM_PER_M, place))


def _rounded_angles(joints: Sequence[_JointElement]) -> Iterator[str]:
    """Say which angles were read as the ones that they round."""
    origins = (joint.element.find("origin") for joint in joints)
    words = [word for each in origins if each is not None for word in each.get("rpy", "").split()]
    meant = {word: _meant(word, float(word)) for word in words}
    read = [
        f"{word} as {math.degrees(angle):g}°"
        for word, angle in meant.items()
        if abs(float(word) - angle) > ROUNDING_RAD
    ]
    if read:
        yield f"rounded angles are read as they are meant: {', '.join(read)}"


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


_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)


def _number(element: ET.Element | None, key: str, without: float, where: str) -> float:
    word = None if element is None else element.get(key)
    return without if word is None else _value(word.strip(), f"{where} {key}")


def _numbers(element: ET.Element | None, key: str, without: Vector, where: str) -> Vector:
    text = None if element is None else element.get(key)
    if text is None:
        return without
    words = text.split()
    if len(words) != len(without):
        raise KinematicsError(f"{where} {key} has three numbers, not {text!r}")
    x, y, z = (_value(word, f"{where} {key}") for word in words)
    return x, y, z


def _value(word: str, where: str) -> float:
    if not _NUMBER.fullmatch(word) or not math.isfinite(float(word)):
        raise KinematicsError(f"{where}: {word!r} is not a number")
    return float(word)


# From the joints' frames to a chain with a link table.


def _axes_at_zero(
    joints: Sequence[_UrdfJoint], unused: list[str]
) -> tuple[list[JointAxis], Transform]:
    """Return the axes of the joints that move in the zero position, and the tip's frame."""
    axes: list[JointAxis] = []
    frame = IN_PLACE
    for joint in joints:
        frame = compose(frame, joint.frame(0.0))
        if joint.kind is None:
            continue
        direction = transform_vector(frame, joint.axis)
        if axes:
            direction = _straightened(axes[-1].direction, direction, joint.name, unused)
        name = _identifier(joint.name, [axis.name for axis in axes], unused)
        axes.append(
            JointAxis(position_of(frame), direction, joint.kind, name, joint.low, joint.high)
        )
    return axes, frame


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


# Rounding moves no tip further.
DEVIATION_MM = 1e-6


def _deviation_mm(chain: Chain, joints: Sequence[_UrdfJoint]) -> float:
    """Return how far apart the tips of the chain and of the URDF itself are in some postures."""
    worst = 0.0
    for share in (0.3, -0.5, 0.8):
        values = tuple(share * (number % 3 - 1.2) for number in range(1, len(chain) + 1))
        rest = iter(values)
        frame = IN_PLACE
        for joint in joints:
            frame = compose(frame, joint.frame(0.0 if joint.kind is None else next(rest)))
        worst = max(worst, distance(position_of(frame), position_of(chain.fk(values))))
    return worst


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
# about its axis, here always z; so in the standard convention a row's constant part moves on into
# the next joint's origin, and in Craig's it is the joint's own. Links are drawn as cylinders along
# the way to the next joint and have no masses.

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
    robot = ET.Element("robot", name=chain.name or "arm")
    origins = _origins_of(chain)
    if TOOL_JOINT in chain.joint_names:
        raise KinematicsError(f"{TOOL_JOINT!r} names the fixed joint of the tool; rename the other")
    links = ["base_link", *(f"link_{number}" for number in range(1, len(chain) + 1)), "tool"]
    for link, after in zip(links, [*origins, None], strict=True):
        _add_link(robot, link, after)
    for index, joint in enumerate(chain.joint_names):
        element = _add_joint(robot, joint, _kind_of(chain.links[index]), links[index : index + 2])
        _add_origin(element, origins[index])
        ET.SubElement(element, "axis", xyz="0 0 1")
        _add_limit(element, joint, chain.links[index])
    _add_origin(_add_joint(robot, TOOL_JOINT, "fixed", links[-2:]), origins[-1])
    ET.indent(robot)
    return '<?xml version="1.0"?>\n' + ET.tostring(robot, encoding="unicode") + "\n"


def _origins_of(chain: Chain) -> list[Transform]:
    """Return where each joint sits in the link before it, and last the tool in its link."""
    if not chain.is_plain:
        raise KinematicsError("a URDF document is made of plain numbers, not of symbols")
    rows = chain.matrices(chain.zero)
    if chain.convention is Convention.CRAIG:
        return [compose(chain.base, rows[0]), *rows[1:], chain.tool]
    return [chain.base, *rows[:-1], compose(rows[-1], chain.tool)]


def _kind_of(link: DHLink) -> str:
    if link.kind is JointKind.PRISMATIC:
        return "prismatic"
    return "revolute" if link.bounded else "continuous"


def _add_link(robot: ET.Element, name: str, after: Transform | None) -> None:
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
    ET.SubElement(visual, "origin", xyz=_metres(x / 2.0, y / 2.0, z / 2.0), rpy=_written(*turn))
    geometry = ET.SubElement(visual, "geometry")
    ET.SubElement(geometry, "cylinder", length=_metres(length), radius=_metres(LINK_RADIUS_MM))


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
        rpy=_written(angles.psi_rad, angles.theta_rad, angles.phi_rad),
    )


def _add_limit(element: ET.Element, joint: str, link: DHLink) -> None:
    """Add the limits, in rad or m; a joint that turns without end has none."""
    if link.kind is JointKind.REVOLUTE:
        if not link.bounded:
            return
        scale, speed = 1.0, 1.0
    elif link.bounded:
        scale, speed = MM_PER_M, 100.0
    else:
        raise KinematicsError(
            f"joint {joint!r} slides without limits; URDF needs them: give its link low and high"
        )
    ET.SubElement(
        element,
        "limit",
        lower=_written(link.low / scale),
        upper=_written(link.high / scale),
        velocity=_written(speed / scale),
        effort=_written(1.0),
    )


def _metres(*lengths_mm: float) -> str:
    return _written(*(length / MM_PER_M for length in lengths_mm))


def _written(*values: float) -> str:
    """Write numbers so that reading them gives them back."""
    return " ".join(repr(float(value) + 0.0) for value in values)
