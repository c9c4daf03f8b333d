"""Places that chains reach, from some thousand postures and from a million."""

import numpy as np
import pytest
from amounts import every_row

from kinematics.chains.chain import Chain
from kinematics.chains.generated import generated
from kinematics.chains.links import DHLink, JointKind
from kinematics.chains.many import BLOCK, reach_maps, spans_of
from kinematics.errors import KinematicsError
from kinematics.frames.transforms import position_of
from kinematics.limits import spread_over
from kinematics.presets import PRESETS
from kinematics.textbook.systems import SYSTEMS
from kinematics.textbook.systems.mini_movers import MINI_MOVER, with_arm

REAL_ARMS = {
    **{name: with_arm(MINI_MOVER, PRESETS[name].arm).chain() for name in ("minimover5", "alpha2")},
    "puma": SYSTEMS["puma"].chain(),
}


def spread(chain, count):
    return list(spread_over(spans_of(chain), count).postures())


def sampled(chain, count):
    """The tips of the spread postures, one by one."""
    fk = generated(chain).fk
    return np.array([position_of(fk(posture)) for posture in spread(chain, count)])


def test_samples_are_spread_evenly():
    chain = Chain((DHLink(kind=JointKind.PRISMATIC, low=0.0, high=100.0), DHLink(a_mm=10.0)))
    heights = sorted(sampled(chain, 1000)[4:, 2])
    for share in (0.1, 0.5, 0.9):
        assert heights[int(share * 1000)] == pytest.approx(100.0 * share, abs=1.0)


def test_a_reach_without_end_is_refused():
    endless = Chain((DHLink(kind=JointKind.PRISMATIC),))
    for take in (spans_of, lambda chain: reach_maps(chain, ((0, 1),), 10, 10)):
        with pytest.raises(KinematicsError, match="slides without limits"):
            take(endless)
    with pytest.raises(KinematicsError, match="at least one posture"):
        spread_over(spans_of(Chain((DHLink(),))), 0)


@every_row("arm", REAL_ARMS.values(), ids=REAL_ARMS)
def test_a_map_shows_one_place_of_each_cell_and_how_far_the_arm_reaches(arm):
    cells, count, planes = 40, BLOCK + 900, ((0, 2), (0, 1), (1, 2))
    places = sampled(arm, count)
    for plane, found in zip(planes, reach_maps(arm, planes, count, cells), strict=True):
        tips = places[:, plane]
        low, high = tips.min(axis=0), tips.max(axis=0)
        np.testing.assert_allclose(found.min(axis=0), low, atol=1e-9)
        np.testing.assert_allclose(found.max(axis=0), high, atol=1e-9)
        size = (high - low).max() / cells
        shown, reached = cells_of(found, low, size, cells), cells_of(tips, low, size, cells)
        assert len(shown ^ reached) <= 2  # a place on the rim of two cells is in either
        assert len(found) <= len(shown) + 4
        for place in found[::50]:
            assert np.abs(tips - place).max(axis=1).min() < 1e-9


def cells_of(places, low, size, cells):
    return {tuple(cell) for cell in np.minimum((places - low) / size, cells - 1).astype(int)}
