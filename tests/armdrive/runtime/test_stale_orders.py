"""An order prepared before a suspension is not sent on waking: drives may have stopped."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from faults import as_it_stands

from armdrive import Arm
from armdrive.arm.connected import Handle
from armdrive.errors import Stopped


@pytest.fixture
def arm() -> Iterator[Arm]:
    with Arm.connect("sim:cia402") as arm:
        yield as_it_stands(arm)


def moving(arm: Arm) -> Handle:
    handle = arm.move_j(base_deg=40.0, wait=False)
    arm.sleep(0.3)
    return handle


@pytest.fixture
def said(arm, monkeypatch) -> list[bytes]:
    said: list[bytes] = []
    write = arm.engine.link.write
    monkeypatch.setattr(
        arm.engine.link, "write", lambda data, now_s: (said.append(data), write(data, now_s))
    )
    return said


def test_bytes_prepared_before_the_drives_stopped_are_not_sent(arm, said):
    moving(arm)
    arm.engine.round_s = lambda: arm.engine.controller.abilities.order_s + 0.01
    said.clear()
    arm.sleep(0.05)
    assert said == []


def test_a_stop_is_sent_however_late_it_is(arm, said):
    handle = moving(arm)
    arm.engine.round_s = lambda: 0.9
    said.clear()
    arm.request_stop()
    with pytest.raises(Stopped):
        handle.wait()
    assert said


def test_bytes_of_a_round_of_usual_length_are_sent(arm, said):
    handle = moving(arm)
    arm.engine.round_s = lambda: arm.engine.controller.abilities.order_s - 0.01
    said.clear()
    handle.wait()
    assert len(said) > 50


def test_orders_of_other_arms_may_be_late():
    with Arm.connect("sim:teachmover") as arm:
        arm.engine.round_s = lambda: 0.9
        arm.home()
        arm.move_j(base_deg=10.0)
        assert arm.joints.deg["base"] == pytest.approx(10.0, abs=0.5)
