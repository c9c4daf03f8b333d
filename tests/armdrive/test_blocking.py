"""Calls that wait, written once: made as plain calls, and taken as coroutines."""

import inspect

import pytest

from armdrive.blocking import Wait, blocking, coroutine_of, has_ended, resume, run_blocking


class Pace:
    """Answers each wait with what comes next, or raises it."""

    def __init__(self, *outcomes):
        self.outcomes = list(outcomes)
        self.waits = []

    def wait(self, done, timeout_s):
        self.waits.append(timeout_s)
        outcome = self.outcomes.pop(0)
        if isinstance(outcome, BaseException):
            raise outcome
        return outcome


class Owner:
    """Has one call that waits, and one that does not."""

    @blocking
    async def wait(self, pace, *, timeout_s: float = 1.0) -> bool:
        """Wait once."""
        return await Wait(pace, bool, timeout_s)

    def think(self, amount):
        return amount + 1


async def waited_twice(pace):
    return await Wait(pace, bool, 1.0), await Wait(pace, bool, 2.0)


def test_a_plain_call_waits_where_it_stands_and_returns_the_result():
    pace = Pace(True, False)
    assert run_blocking(waited_twice(pace)) == (True, False)
    assert pace.waits == [1.0, 2.0]


@pytest.mark.parametrize("error", [KeyboardInterrupt, ZeroDivisionError])
def test_an_interrupt_is_raised_in_the_waiting_call_which_may_wait_again(error):
    async def stopping(pace):
        try:
            await Wait(pace, bool, 1.0)
        except BaseException:
            await Wait(pace, bool, 60.0)
            raise

    pace = Pace(error(), True)
    with pytest.raises(error):
        run_blocking(stopping(pace))
    assert pace.waits == [1.0, 60.0]


def test_a_call_may_answer_an_interruption_with_a_result():
    async def forgiving(pace):
        try:
            return await Wait(pace, bool, 1.0)
        except KeyboardInterrupt:
            return "interrupted"

    assert run_blocking(forgiving(Pace(KeyboardInterrupt()))) == "interrupted"


def test_a_call_is_resumed_from_wait_to_wait_without_waiting():
    call = waited_twice(None)
    assert resume(call, None).timeout_s == 1.0
    assert resume(call, True).timeout_s == 2.0
    assert not has_ended(call)
    with pytest.raises(StopIteration) as end:
        resume(call, False)
    assert end.value.value == (True, False)
    assert has_ended(call)


def test_a_blocking_method_keeps_its_signature_and_gives_its_coroutine():
    owner, pace = Owner(), Pace(True, False)
    assert owner.wait(pace) is True
    assert list(inspect.signature(owner.wait).parameters) == ["pace", "timeout_s"]
    assert inspect.getdoc(Owner.wait) == "Wait once."
    assert not inspect.iscoroutinefunction(Owner.wait)
    assert run_blocking(coroutine_of(owner.wait)(pace, timeout_s=3.0)) is False
    assert pace.waits == [1.0, 3.0]
    call = coroutine_of(Owner.wait)(owner, pace, timeout_s=4.0)
    assert resume(call, None).timeout_s == 4.0
    call.close()


def test_a_call_that_never_waits_is_a_coroutine_too():
    assert run_blocking(coroutine_of(Owner().think)(1)) == 2
