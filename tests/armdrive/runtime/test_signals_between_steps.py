"""Ending signals during a step of the engine: handled after it, and never lost."""

import signal

import pytest

from armdrive.runtime import clock
from armdrive.runtime.clock import SignalsBetweenSteps


@pytest.fixture
def handled():
    """Record SIGINT and SIGTERM instead of ending the tests."""
    numbers = []
    before = {each: signal.getsignal(each) for each in (signal.SIGINT, signal.SIGTERM)}
    for number in before:
        signal.signal(number, lambda number, _: numbers.append(number))
    yield numbers
    for number, handler in before.items():
        signal.signal(number, handler)


def test_a_signal_waits_for_the_end_of_the_step(handled):
    with SignalsBetweenSteps() as signals:
        signal.raise_signal(signal.SIGINT)
        assert handled == []
        signals.deliver()
        assert handled == [signal.SIGINT]
        signal.raise_signal(signal.SIGTERM)
    assert handled == [signal.SIGINT, signal.SIGTERM]


def interrupting(number, _):
    raise InterruptedError(number)


@pytest.mark.parametrize(
    ("interrupted", "other", "sets"),
    [(signal.SIGTERM, signal.SIGINT, 1), (signal.SIGINT, signal.SIGTERM, 3)],
    ids=["as it begins", "as it ends"],
)
def test_a_handler_that_raises_in_between_leaves_the_other_signals_working(
    handled, monkeypatch, interrupted, other, sets
):
    """The signal comes after as many handlers have been set: two at first, two at the end."""
    signal.signal(interrupted, interrupting)
    left = iter([False] * (sets - 1) + [True])
    change = signal.signal

    def changing(number, handler):
        before = change(number, handler)
        if next(left, False):
            signal.raise_signal(interrupted)
        return before

    monkeypatch.setattr(clock.signal, "signal", changing)
    with pytest.raises(InterruptedError), SignalsBetweenSteps():
        pass
    signal.raise_signal(other)
    assert handled == [other]
