"""The twins of calls, and their clock."""

import inspect
import math

import async_twin
import pytest

from armdrive import Arm, AsyncHandle, Handle, SimulatedClock
from armdrive.aio.calls import twin_of
from armdrive.errors import ArmError, LinkLost, Stopped, WrongState
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


def test_properties_stay_properties():
    for sync, twin in PAIRS:
        for name in public(sync):
            if isinstance(inspect.getattr_static(sync, name), property):
                ours = inspect.getattr_static(twin, name)
                theirs = inspect.getattr_static(sync, name)
                assert isinstance(ours, property), name
                assert (ours.fset is None) == (theirs.fset is None), name


def test_type_checkers_read_the_async_signatures():
    kept = async_twin.parts(async_twin.FILE.read_text(encoding="utf-8"))
    assert kept == async_twin.parts(async_twin.text()), (
        "run python tests/armdrive/aio/async_twin.py"
    )


def test_a_call_that_neither_waits_nor_begins_a_motion_has_to_be_in_a_table(monkeypatch):
    monkeypatch.setattr("armdrive.aio.calls.AT_ONCE", AT_ONCE - {"pause"})
    with pytest.raises(LookupError, match="pause: make the call `blocking`"):
        twin_of(Arm)(type("Twin", (), {}))


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


def test_an_arm_that_connects_later_begins_now_and_the_other_goes_on():
    clock = SimulatedClock()
    a = Arm.connect("sim:teachmover", pace=clock)
    a.home()
    a.sleep(20.0)
    handle = a.move_j(base_deg=30, wait=False)
    b = Arm.connect("sim:grbl", pace=a.parts.pace)
    assert b.status.time_s >= 20.0
    b.sleep(10.0)
    assert handle.done


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


def test_a_closed_arm_is_off_its_clock():
    clock = SimulatedClock()
    a, _ = two(clock)
    a.close()
    assert a.status.state is State.DISCONNECTED
    assert len(clock.engines) == 1
    with pytest.raises(WrongState, match="closed for good"):
        a.io.read()


def test_arms_without_a_clock_in_common_do_not_wait_for_one_another():
    a, b = Arm.connect("sim:teachmover"), Arm.connect("sim:teachmover")
    a.sleep(5.0)
    assert b.parts.pace.now_s() < 1.0


@pytest.mark.parametrize("creep_s", [0.0, 1e-15])
def test_of_several_arms_the_one_is_named_that_lets_no_time_pass(creep_s, monkeypatch):
    monkeypatch.setattr("armdrive.runtime.clock.STUCK_TURNS", 200)
    clock = SimulatedClock()
    a, b = (Arm.connect(f"sim:{each}", pace=clock) for each in ("teachmover", "grbl"))
    link, inner_s = a.twin.link, a.twin.link.next_s
    link.next_s = lambda: min(inner_s(), clock.now_s + creep_s)
    with pytest.raises(ArmError, match="time is stuck") as raised:
        b.sleep(1.0)
    assert a.parts.engine.link.description in str(raised.value)
    assert b.parts.engine.link.description not in str(raised.value)


def test_a_wait_for_ever_is_an_error_once_nothing_is_left_to_do():
    clock = SimulatedClock()
    a, b = two(clock)
    for arm in (a, b):
        arm.twin.link.unplug()
        arm.sleep(0.1)
    with pytest.raises(ArmError, match="nothing left"):
        a.parts.pace.wait(lambda: False, math.inf)
