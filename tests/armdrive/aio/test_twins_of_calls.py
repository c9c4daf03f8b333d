"""The twins of calls, and their clock."""

import inspect
import math

import async_twin
import pytest

from armdrive import Arm, AsyncHandle, Handle, SimulatedClock
from armdrive.errors import ArmError, LinkLost, Stopped
from armdrive.status import State

OWN = {"sync", "carry"}
"""What only a twin has."""
AT_ONCE = {"estop", "log", "pause", "pose_in", "request", "request_stop", "resume"}
"""The calls that never wait for the arm, and are not awaited. `connect` can be both."""

PAIRS = [*((kind, twin) for twin, kind in async_twin.KINDS), (Handle, AsyncHandle)]


def public(kind):
    """Return the public names of a class that are calls or properties."""
    return {
        name
        for name in dir(kind)
        if not name.startswith("_")
        and (callable(found := inspect.getattr_static(kind, name)) or hasattr(found, "__get__"))
    } - OWN


@pytest.mark.parametrize(("sync", "twin"), PAIRS, ids=lambda kind: kind.__name__)
def test_each_call_has_its_twin_and_no_twin_is_left_over(sync, twin):
    missing = public(sync) - public(twin)
    assert not missing, f"make their twins, with async_twin.py: {', '.join(sorted(missing))}"
    beside = {"config", "simulated", "twin", "stops"}  # an Arm has them as plain attributes
    assert public(twin) - public(sync) <= beside


def test_a_twin_is_called_as_its_call_is_and_awaited_if_that_may_wait():
    for sync, twin in PAIRS:
        for name in public(sync):
            if not inspect.isfunction(inspect.getattr_static(sync, name)):
                continue
            ours, theirs = (inspect.signature(getattr(kind, name)) for kind in (twin, sync))
            assert [*map(str, ours.parameters.values())] == [*map(str, theirs.parameters.values())]
            assert inspect.getdoc(getattr(twin, name)), name
            assert inspect.iscoroutinefunction(getattr(twin, name)) == (name not in AT_ONCE), name


def test_type_checkers_read_the_async_signatures():
    kept = async_twin.parts(async_twin.FILE.read_text(encoding="utf-8"))
    assert kept == async_twin.parts(async_twin.text()), (
        "run python tests/armdrive/aio/async_twin.py"
    )


# -- One clock -------------------------------------------------------------------------------------


def two(clock):
    """Return two referenced arms on one clock."""
    arms = [Arm.connect("sim:teachmover", pace=clock) for _ in range(2)]
    for arm in arms:
        arm.enable()
        arm.home()
    return arms


def test_two_motions_that_were_begun_run_side_by_side():
    clock = SimulatedClock()
    arms = two(clock)
    began_s = clock.now_s
    handles = [arm.move_j(base_deg=20, wait=False) for arm in arms]
    arms[0].sleep(0.5)
    assert {arm.status.state for arm in arms} == {State.MOVING}
    assert len({arm.status.time_s for arm in arms}) == 1
    for arm, handle in zip(arms, handles, strict=True):
        handle.wait()
        assert arm.joints.deg["base"] == pytest.approx(20, abs=0.2)
    both_s = clock.now_s - began_s

    alone = []
    for arm in arms:
        began_s = clock.now_s
        arm.move_j(base_deg=0)
        alone.append(clock.now_s - began_s)
    assert both_s == pytest.approx(max(alone), rel=0.1)
    assert both_s < 0.6 * sum(alone)


@pytest.mark.parametrize(
    ("end", "error"),
    [
        (lambda arm: arm.close(), Stopped),
        (lambda arm: arm.stop(), Stopped),
        (lambda arm: arm.twin.link.unplug(), LinkLost),
    ],
    ids=["closed", "stopped", "lost"],
)
def test_ending_the_motion_of_one_arm_ends_no_other(end, error):
    clock = SimulatedClock()
    a, b = two(clock)
    first, second = (arm.move_j(base_deg=20, wait=False) for arm in (a, b))
    a.sleep(0.5)
    end(a)
    second.wait()
    with pytest.raises(error):
        first.wait()
    assert b.joints.deg["base"] == pytest.approx(20, abs=0.2)
    assert b.status.state is State.STANDBY


def test_a_wait_for_ever_is_an_error_once_nothing_is_left_to_do():
    clock = SimulatedClock()
    a, b = two(clock)
    for arm in (a, b):
        arm.twin.link.unplug()
        arm.sleep(0.1)
    with pytest.raises(ArmError, match="nothing left"):
        a.parts.pace.wait(lambda: False, math.inf)
