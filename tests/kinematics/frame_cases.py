"""Strategies and comparisons for vectors, rotations and frames."""

import math

from hypothesis import strategies as st

from kinematics.frames.orientations import Quaternion
from kinematics.frames.transforms import transform
from kinematics.frames.vectors import norm

components = st.floats(-1000.0, 1000.0).map(lambda x: round(x, 6))
vectors = st.tuples(components, components, components)
directed = vectors.filter(lambda v: norm(v) > 1e-3)
angles = st.floats(-math.pi, math.pi)
quarters = st.integers(-4, 4).map(lambda n: n * math.pi / 2)
any_angle = angles | quarters | quarters.map(lambda a: a + 3e-7)
parts = st.floats(-1.0, 1.0)
rotations = (
    st.tuples(parts, parts, parts, parts)
    .filter(lambda q: math.hypot(*q) > 0.1)
    .map(lambda q: Quaternion(*q).rotation())
)
transforms = st.builds(transform, rotations, vectors)
