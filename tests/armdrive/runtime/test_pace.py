"""The two clocks: simulated time that jumps, and real time with a thread of its own."""

import math
import threading
from types import SimpleNamespace

import pytest
from faults import as_it_stands, ready_arm
from waiting import returns, until

from armdrive import Arm
from armdrive.errors import ArmError, BadRequest, Stopped
from armdrive.runtime import clock as pace
from armdrive.runtime.clock import RealPace, SimulatedPace
from armdrive.status import State


def test_sleep_follows_the_arms_own_clock():
    arm = ready_arm()
    began_s = arm.status.time_s
    returns(lambda: arm.sleep(300.0))
    assert arm.status.time_s - began_s == pytest.approx(300.0)
    arm.sleep(0)
    with pytest.raises(BadRequest, match=r"^time_s must be 0 or more seconds"):
        arm.sleep(-1.0)
    assert arm.status.time_s - began_s == pytest.approx(300.0)


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("duration_s", lambda arm, time_s: arm.jog_j(base=1, duration_s=time_s)),
        ("time_s", lambda arm, time_s: arm.sleep(time_s)),
    ],
)
@pytest.mark.parametrize("time_s", [1.1e6, 1e300])
def test_a_time_that_no_simulation_reaches_the_end_of_is_refused(name, call, time_s):
    arm = ready_arm()
    with pytest.raises(BadRequest, match=f"^{name} must be at most 1000000 seconds, not"):
        call(arm, time_s)
    assert arm.status.state is State.STANDBY


def test_a_wait_without_an_end_that_nothing_can_end_is_an_error_and_no_hang():
    class Nothing:
        broken = None

        def advance(self, now_s):
            return math.inf

    pace = SimulatedPace()
    pace.start(Nothing())
    with pytest.raises(ArmError):
        pace.wait(lambda: False, math.inf)


@pytest.mark.parametrize("creep_s", [0.0, 1e-15])
def test_simulated_time_that_is_stuck_raises_an_error_naming_what_waits(creep_s, monkeypatch):
    monkeypatch.setattr("armdrive.runtime.clock.STUCK_TURNS", 1000)
    arm = ready_arm()
    link, inner_s = arm.twin.link, arm.twin.link.next_s
    link.next_s = lambda: min(inner_s(), arm.pace.now_s() + creep_s)
    with pytest.raises(ArmError, match=r"time is stuck.*the wire"):
        arm.sleep(1.0)


@pytest.mark.parametrize("speed", [1.0, 200.0])
def test_an_accelerated_clock_waits_for_an_engine_that_a_busy_computer_holds_up(monkeypatch, speed):
    """At 200 times real time, two seconds of a busy computer were 400 s without an answer."""
    rounds, real_s = threading.Semaphore(0), 100.0

    class Busy:
        broken = reconnect = None
        link = SimpleNamespace(wait=lambda _: None, wake=lambda: None)

        def __init__(self):
            self.seen_s = []

        def absent(self, _):
            pass

        def advance(self, now_s):
            self.seen_s.append(now_s)
            rounds.acquire()
            return now_s

    monkeypatch.setattr(pace, "time", SimpleNamespace(monotonic=lambda: real_s))
    real, engine = RealPace(speed=speed), Busy()
    real.start(engine)
    until(lambda: len(engine.seen_s) == 1)
    real_s += 60.0
    held_up_s = real.now_s() - engine.seen_s[0]
    assert held_up_s == (60.0 if speed == 1.0 else pytest.approx(pace.LONGEST_STEP_S * speed))
    engine.broken = ArmError("unplugged")
    rounds.release()
    until(lambda: not real._thread.is_alive())
    before_s = real.now_s()
    real_s += 60.0  # nobody drives it any more: who waits for a time is not kept for ever
    assert real.now_s() - before_s == pytest.approx(60.0 * speed)


def test_in_real_time_a_thread_moves_the_arm_while_the_program_does_something_else():
    arm = ready_arm(pace=20.0)
    handle = arm.move_j(base_deg=6, wait=False)
    assert handle.wait().bursts > 1
    assert arm.twin.world.motors == arm.status.acknowledged
    second = arm.move_j(base_deg=60, speed=0.05, wait=False)
    until(lambda: arm.status.state is State.MOVING)
    arm.stop()
    with pytest.raises(Stopped):
        second.wait()
    arm.close()
    assert arm.pace._thread is None


def test_in_real_time_a_lost_wire_ends_the_thread_and_every_later_wait_returns_at_once():
    arm = ready_arm(pace=100.0)
    thread = arm.pace._thread
    arm.twin.link.cut()
    arm.pace.wake()
    until(lambda: not thread.is_alive())
    for call in (arm.stop, arm.read_inputs):
        with pytest.raises(ArmError):
            returns(call)
    returns(arm.close)


def test_a_failed_engine_raises_in_every_waiting_call():
    arm = ready_arm(pace=100.0)
    arm.engine.advance = lambda now_s: 1 / 0
    arm.pace.wake()
    with pytest.raises(ArmError, match="thread ended"):
        arm.sleep(1e6)
    with pytest.raises(ArmError, match="thread ended"):
        arm.close()
    assert arm.status.state is State.DISCONNECTED


class Clock:
    def __init__(self):
        self.now_s = 100.0

    def monotonic(self):
        return self.now_s


class Sleeper:
    """An engine's stand-in whose computer is suspended once, at a stated place."""

    broken = None
    mending = None

    def __init__(self, clock, asleep_in, asleep_s):
        self.clock, self.asleep_in, self.link = clock, asleep_in, self
        self.asleep_s = asleep_s
        self.rounds, self.missed, self.waits = 0, [], []

    def advance(self, now_s):
        self.rounds += 1
        if self.rounds == 2 and self.asleep_in == "advance":
            self.clock.now_s += self.asleep_s
        if self.rounds == 4:
            self.broken = "the test is over"
        return now_s + 0.2

    def suspended(self, time_s):
        self.missed.append((self.rounds, time_s))

    def wait(self, timeout_s):
        self.waits.append(self.rounds)
        asleep_s = self.asleep_s if self.rounds == 2 and self.asleep_in == "wait" else 0.0
        self.clock.now_s += timeout_s + asleep_s

    def wake(self):
        pass


@pytest.mark.parametrize(("place", "asleep_s"), [("advance", 1.5), ("wait", 1.5), ("wait", 0.9)])
def test_a_suspension_is_noticed_wherever_it_falls(place, asleep_s, monkeypatch):
    clock = Clock()
    monkeypatch.setattr(pace, "time", clock)
    real = RealPace()
    sleeper = Sleeper(clock, place, asleep_s)
    real._engine = sleeper
    real._drive()
    assert [(rounds, round(time_s, 3)) for rounds, time_s in sleeper.missed] == [(2, asleep_s)]
    if asleep_s > pace.SUSPENDED_S:
        assert (2 in sleeper.waits) == (place == "wait")


def test_bytes_prepared_before_a_suspension_are_not_sent_after_it():
    arm = ready_arm()
    handle = arm.move_j(base_deg=40, wait=False)
    arm.sleep(0.5)
    before = len(arm.twin.link.named(b"@STEP"))
    arm.engine.asleep_s = lambda: 1.5
    with pytest.raises(Stopped, match="was suspended"):
        handle.wait()
    assert len(arm.twin.link.named(b"@STEP")) <= before + 1


@pytest.mark.parametrize("dialect", ["teachmover", "robko01", "armdroid", "grbl"])
def test_a_suspension_between_a_thought_and_its_word_leaves_the_word_unsaid(dialect):
    with Arm.connect(f"sim:{dialect}") as arm:
        arm.enable()
        as_it_stands(arm)
        handle = arm.move_j(base_deg=40, wait=False)
        arm.sleep(0.5)
        engine, think = arm.engine, arm.engine.controller.advance
        asleep_s, unsaid, said = [0.0], [], []

        def suspended(now_s):
            asleep_s[0] = 0.0
            words = think(now_s)
            if words and not unsaid:
                unsaid.append(words)
                asleep_s[0] = 1.5
            return words

        def written(data, now_s, write=engine.link.write):
            said.append(data)
            write(data, now_s)

        engine.controller.advance, engine.link.write = suspended, written
        engine.asleep_s = lambda: asleep_s[0]
        with pytest.raises(ArmError):
            handle.wait()
        assert unsaid
        assert unsaid[0] not in said[:1]
        arm.sleep(3.0)
        stood = arm.twin.world.motors
        arm.sleep(3.0)
        assert arm.twin.world.motors == stood
        if arm.status.state is not State.STANDBY:
            arm.reset()
        assert arm.status.state is State.STANDBY
