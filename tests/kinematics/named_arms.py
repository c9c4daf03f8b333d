"""Link tables of real arms and of every structure, as published or near to it (mm and rad)."""

import math
from dataclasses import replace

from kinematics.chains.chain import Chain
from kinematics.chains.links import Convention, DHLink

QUARTER = math.pi / 2


def table(*rows, convention=Convention.STANDARD):
    """A chain of rows of theta, d, a and alpha."""
    return Chain(tuple(DHLink(*row) for row in rows), convention)


PUMA_560 = table(
    (0, 0, 0, QUARTER), (0, 0, 431.8, 0), (0, 150.05, 20.3, -QUARTER),
    (0, 431.8, 0, QUARTER), (0, 0, 0, -QUARTER), (0, 56.25, 0, 0),
)  # fmt: skip
KUKA_KR6 = table(
    (0, 400, 25, -QUARTER), (0, 0, 455, 0), (-QUARTER, 0, 35, -QUARTER),
    (0, 420, 0, QUARTER), (0, 0, 0, -QUARTER), (math.pi, 80, 0, 0),
)  # fmt: skip
AR4 = table(
    (0, 169.77, 64.2, -QUARTER), (-QUARTER, 0, 305, 0), (math.pi, 0, 0, QUARTER),
    (0, 222.63, 0, -QUARTER), (0, 0, 0, QUARTER), (math.pi, 36.25, 0, 0),
)  # fmt: skip
THOR = table(
    (0, 202, 0, QUARTER), (QUARTER, 0, 160, 0), (0, 0, 0, QUARTER),
    (0, 195, 0, -QUARTER), (0, 0, 0, QUARTER), (0, 67, 0, 0),
)  # fmt: skip
SKEW_WRIST = table(
    (0, 400, 25, -QUARTER), (0, 0, 455, 0), (0.2, 0, 35, -QUARTER),
    (0, 420, 0, 1.2), (0.4, 0, 0, -1.1), (0, 80, 0, 0),
)  # fmt: skip
UR5 = table(
    (0, 89.159, 0, QUARTER), (0, 0, -425, 0), (0, 0, -392.25, 0),
    (0, 109.15, 0, QUARTER), (0, 94.65, 0, -QUARTER), (0, 82.3, 0, 0),
)  # fmt: skip
NOTHING_MEETS_BUT_THE_WRIST = table(
    (0, 200, 100, 0.9), (0, 30, 200, 1.2), (0, 20, 300, QUARTER),
    (0, 250, 0, 1.2), (0, 0, 0, -1.1), (0, 60, 0, 0),
)  # fmt: skip
PARALLEL_AND_OFFSET = table(
    (0, 162.5, 30, QUARTER), (0, 10, -425, 0), (0, 0, -392.2, 0),
    (0.3, 133.3, 20, 1.1), (0, 99.7, 44, -0.9), (0, 99.6, 0, 0),
)  # fmt: skip
MINI_MOVER = table(
    (0, 195, 0, QUARTER), (0, 0, 177.8, 0), (0, 0, 177.8, 0), (QUARTER, 0, 0, QUARTER),
    (0, 96.5, 0, 0),
)  # fmt: skip
SCORBOT = table(
    (0, 349, 16, -QUARTER), (0, 0, 221, 0), (0, 0, 221, 0), (-QUARTER, 0, 0, -QUARTER),
    (0, 145, 0, 0),
)  # fmt: skip
BESIDE_THE_BASE = table(
    (0, 200, 0, QUARTER), (0, 60, 250, 0), (0, 0, 200, 0), (QUARTER, 0, 0, QUARTER),
    (0, 80, 0, 0),
)  # fmt: skip
FIVE_ASKEW = table(
    (0, 200, 50, QUARTER), (0, 60, 250, 0.4), (0, 0, 200, QUARTER), (QUARTER, 200, 0, QUARTER),
    (0, 80, 30, 0.3),
)  # fmt: skip
SEVEN_JOINTS = table(
    (0, 340, 0, -QUARTER), (0, 0, 0, QUARTER), (0, 400, 0, QUARTER), (0, 0, 0, -QUARTER),
    (0, 400, 0, -QUARTER), (0, 0, 0, QUARTER), (0, 126, 0, 0),
)  # fmt: skip
"""KUKA's LBR iiwa."""

COBOT_WITHOUT_WRIST = table(
    (0, 150, 20, 1.2), (0, 30, 250, 0.4), (0, 20, 200, 0.9), (0, 130, 15, 1.1), (0, 100, 30, -0.9),
    (0, 99, 10, 0.2),
)  # fmt: skip
"""No axes meet and none are parallel: this arm has no closed form."""

ARMS = {
    "Puma 560": PUMA_560,
    "KUKA KR 6": KUKA_KR6,
    "AR4": AR4,
    "Thor": THOR,
    "UR5": UR5,
    "a wrist of other angles": SKEW_WRIST,
    "Mini-mover": MINI_MOVER,
    "SCORBOT": SCORBOT,
    "beside the base": BESIDE_THE_BASE,
}


def calibrated(chain, by):
    """The arm as measured: every length, distance and twist a little off."""
    off = iter(range(1, 100))

    def changed(value, scale=1.0):
        return value + by * scale * math.sin(7.0 * next(off))

    links = tuple(
        replace(
            link,
            a_mm=changed(link.a_mm, 300.0),
            d_mm=changed(link.d_mm, 300.0) if link.d_mm else 0.0,
            alpha_rad=changed(link.alpha_rad),
        )
        for link in chain.links
    )
    return replace(chain, links=links)
