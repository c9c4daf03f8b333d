"""Every public call of an arm and of its gripper has its async twin, with the same signature."""

from __future__ import annotations

import inspect

import async_twin
import pytest

from armdrive import Arm, AsyncArm, AsyncHandle, Handle
from armdrive.aio import AsyncGripper
from armdrive.aio.calls import twin_of
from armdrive.arm.moving import Gripper

INNER = {"submit", "finish", "perform", "known", "goal_of"}
"""What the calls are made of: they take and give what only armdrive itself has."""
OWN = {"sync", "carry"}
"""What only a twin has."""
AT_ONCE = {
    "above_mark", "estop", "hold", "log", "nudge", "on_close", "pause", "pose_in",
    "reference_request", "release", "request_stop", "resume",
}  # fmt: skip
"""The calls that never wait for the arm, and are not awaited. `connect` can be both."""

PAIRS = [(Arm, AsyncArm), (Gripper, AsyncGripper), (Handle, AsyncHandle)]


def public(kind):
    """Return the public names of a class that are calls or properties."""
    return {
        name
        for name in dir(kind)
        if not name.startswith("_")
        and (callable(found := inspect.getattr_static(kind, name)) or hasattr(found, "__get__"))
    } - OWN


def calls():
    return [
        (sync, twin, name)
        for sync, twin in PAIRS
        for name in sorted(public(sync) - INNER)
        if inspect.isfunction(inspect.getattr_static(sync, name))
    ]


@pytest.mark.parametrize(("sync", "twin"), PAIRS, ids=lambda kind: kind.__name__)
def test_each_call_has_its_twin_and_no_twin_is_left_over(sync, twin):
    missing = public(sync) - INNER - public(twin)
    assert not missing, f"make their twins, with async_twin.py: {', '.join(sorted(missing))}"
    beside = {"config", "simulated", "twin", "stops"}  # an Arm has them as plain attributes
    assert public(twin) - public(sync) <= beside


@pytest.mark.parametrize(("sync", "twin", "name"), calls(), ids=str)
def test_a_twin_is_called_as_its_call_is_and_awaited_if_that_may_wait(sync, twin, name):
    ours, theirs = (inspect.signature(getattr(kind, name)) for kind in (twin, sync))
    assert [*map(str, ours.parameters.values())] == [*map(str, theirs.parameters.values())]
    assert inspect.getdoc(getattr(twin, name))
    assert inspect.iscoroutinefunction(getattr(twin, name)) == (name not in AT_ONCE)


def test_properties_stay_properties():
    for sync, twin in PAIRS:
        for name in public(sync) - INNER:
            if isinstance(inspect.getattr_static(sync, name), property):
                ours = inspect.getattr_static(twin, name)
                theirs = inspect.getattr_static(sync, name)
                assert isinstance(ours, property), name
                assert (ours.fset is None) == (theirs.fset is None), name


def test_what_type_checkers_read_are_the_twins():
    kept = async_twin.parts(async_twin.FILE.read_text(encoding="utf-8"))
    assert kept == async_twin.parts(async_twin.text()), (
        "run python tests/armdrive/aio/async_twin.py"
    )


def test_a_call_that_neither_waits_nor_begins_a_motion_has_to_be_in_a_table(monkeypatch):
    monkeypatch.setattr("armdrive.aio.calls.AT_ONCE", AT_ONCE - {"pause"})
    with pytest.raises(LookupError, match="pause: make the call `blocking`"):
        twin_of(Arm)(type("Twin", (), {}))
