"""A sample of the jogs of benchmarks/jog_limits.py: into limits and guards, and out again."""

import pytest
from amounts import amount
from jog_trials import Ground, trials

SEED = 22
COUNTS = {"teachmover": 4, "robko01": amount(1, 2), "armdroid": amount(1, 2), "grbl": amount(1, 3)}
LATER_S = 0.2
NEAR_STEPS = 3.0


@pytest.mark.parametrize("dialect", COUNTS)
def test_a_jog_at_full_speed_ends_at_its_bound_and_turns_back_at_once(dialect):
    ground = Ground(dialect, SEED)
    for one in trials(dialect, SEED, COUNTS[dialect]):
        assert one.kept, one
        assert one.left_steps is None or one.left_steps <= NEAR_STEPS, one
        assert one.back_s <= ground.begins_s + LATER_S, one
        assert one.stall_s <= ground.stands_s + LATER_S, one
