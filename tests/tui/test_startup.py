"""While the desk runs, threads take turns quickly; afterwards as they did before."""

import sys
from collections.abc import Iterator

import pytest

import tui
from tests.tui.desk_fake import FakeArm
from tui.desk import Desk
from tui.startup import TURN_S, short_turns


@pytest.fixture(autouse=True)
def usual_turns() -> Iterator[None]:
    before_s = sys.getswitchinterval()
    sys.setswitchinterval(0.005)
    yield
    sys.setswitchinterval(before_s)


def test_turns_are_short_while_the_desk_runs(monkeypatch):
    seen = []
    monkeypatch.setattr(Desk, "run", lambda _: seen.append(sys.getswitchinterval()))
    tui.run_desk(FakeArm())
    assert seen == [pytest.approx(TURN_S)]
    assert sys.getswitchinterval() == pytest.approx(0.005)


def test_turns_that_are_shorter_already_stay_so():
    sys.setswitchinterval(TURN_S / 2)
    with short_turns():
        assert sys.getswitchinterval() == pytest.approx(TURN_S / 2)


def test_a_failing_desk_leaves_the_turns_as_they_were(monkeypatch):
    def fail(_):
        raise RuntimeError("the desk fell over")

    monkeypatch.setattr(Desk, "run", fail)
    with pytest.raises(RuntimeError):
        tui.run_desk(FakeArm())
    assert sys.getswitchinterval() == pytest.approx(0.005)
