"""Chains that several tests share, and strategies that draw chains of every build."""

import math

from hypothesis import strategies as st

from kinematics import system
from kinematics.chains.assignment import JointAxis, tip_frame
from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink, JointKind
from kinematics.frames.orientations import Quaternion
from kinematics.frames.rotations import multiply, rot_x, rot_z
from kinematics.frames.transforms import IN_PLACE, transform
from kinematics.frames.vectors import norm

QUARTER = math.pi / 2

ALPHA_II = Chain(
    (
        DHLink(0.0, 215.0, 0.0, -QUARTER),
        DHLink(0.0, 0.0, 177.8, 0.0),
        DHLink(0.0, 0.0, 177.8, 0.0),
        DHLink(0.0, 0.0, 0.0, -QUARTER),
        DHLink(0.0, 129.5, 0.0, 0.0),
    ),
    name="Alpha II",
    joint_names=("base", "shoulder", "elbow", "pitch", "roll"),
)

ALPHA_II_AXES = (
    JointAxis((0, 0, 0), (0, 0, 1), name="base"),
    JointAxis((0, 0, 215), (0, 1, 0), name="shoulder"),
    JointAxis((177.8, 0, 215), (0, 1, 0), name="elbow"),
    JointAxis((355.6, 0, 215), (0, 1, 0), name="pitch"),
    JointAxis((355.6, 0, 215), (1, 0, 0), name="roll"),
)
ALPHA_II_TOOL = tip_frame(ALPHA_II_AXES[-1], (485.1, 0.0, 215.0), normal=(0, 0, 1))
"""The joints and the hand of the Alpha II, stretched out level."""

MINI_MOVER = system("minimover5").chain()

PUMA = Chain(
    (
        DHLink(0.0, 0.0, 0.0, QUARTER),
        DHLink(0.0, 0.0, 431.8, 0.0),
        DHLink(0.0, 150.05, 20.3, -QUARTER),
        DHLink(0.0, 431.8, 0.0, QUARTER),
        DHLink(0.0, 0.0, 0.0, -QUARTER),
        DHLink(0.0, 0.0, 0.0, 0.0),
    ),
    name="Puma 560",
)

ASKEW = transform(multiply(rot_x(0.3), rot_z(-0.7)), (12.0, -5.0, 40.0))


def gap(a, b):
    """The largest difference of two vectors or two matrices; infinite where one holds a NaN."""
    if hasattr(a[0], "__len__"):
        return max(gap(x, y) for x, y in zip(a, b, strict=True))
    off = [abs(x - y) for x, y in zip(a, b, strict=True)]
    return math.inf if any(map(math.isnan, off)) else max(off)


def turn_gap(a, b):
    """The largest turn between two lists of angles, angle by angle."""
    return max(abs(math.remainder(x - y, math.tau)) for x, y in zip(a, b, strict=True))


angles = st.one_of(
    st.sampled_from([0.0, QUARTER, -QUARTER, math.pi]), st.floats(-3.125, 3.125, width=32)
)
coordinates = st.sampled_from([0.0, 100.0, -40.0])
directions = st.tuples(*[st.sampled_from([0.0, 1.0, -1.0, 0.3])] * 3).filter(any)
joint_axes = st.builds(
    JointAxis, st.tuples(*[coordinates] * 3), directions, st.sampled_from(JointKind)
)
lengths = st.one_of(st.just(0.0), st.floats(-200.0, 200.0, width=32))


@st.composite
def chains(draw, most=7, kinds=tuple(JointKind)):
    links = draw(
        st.lists(
            st.builds(
                DHLink,
                angles,
                lengths,
                lengths,
                angles,
                st.sampled_from(kinds),
                st.sampled_from([0.0, 0.3]),
            ),
            min_size=1,
            max_size=most,
        )
    )
    places = st.sampled_from([IN_PLACE, ASKEW])
    return Chain(tuple(links), draw(st.sampled_from(Convention)), draw(places), draw(places))


@st.composite
def chains_and_values(draw, most=7, kinds=tuple(JointKind)):
    chain = draw(chains(most, kinds))
    values = draw(
        st.lists(st.floats(-3.0, 3.0), min_size=len(chain), max_size=len(chain)).map(tuple)
    )
    return chain, values


def columns_by_differences(chain, values, step=1e-5):
    """The geometric Jacobian's columns from central differences of the forward kinematics."""
    here = chain.fk(values)
    columns = []
    for index in range(len(values)):
        moved = [
            chain.fk([*values[:index], values[index] + sign * step, *values[index + 1 :]])
            for sign in (1, -1)
        ]
        rates = [
            [(moved[0][r][c] - moved[1][r][c]) / (2 * step) for c in range(4)] for r in range(3)
        ]
        spin = [
            [sum(rates[r][k] * here[s][k] for k in range(3)) for s in range(3)] for r in range(3)
        ]
        turning = [spin[2][1], spin[0][2], spin[1][0]]
        columns.append([rates[0][3], rates[1][3], rates[2][3], *turning])
    return columns


# Vectors, rotations and frames.

components = st.floats(-1000.0, 1000.0).map(lambda x: round(x, 6))
vectors = st.tuples(components, components, components)
directed = vectors.filter(lambda v: norm(v) > 1e-3)
quarters = st.integers(-4, 4).map(lambda n: n * math.pi / 2)
any_angle = st.floats(-math.pi, math.pi) | quarters | quarters.map(lambda a: a + 3e-7)
parts = st.floats(-1.0, 1.0)
rotations = (
    st.tuples(parts, parts, parts, parts)
    .filter(lambda q: math.hypot(*q) > 0.1)
    .map(lambda q: Quaternion(*q).rotation())
)
transforms = st.builds(transform, rotations, vectors)
