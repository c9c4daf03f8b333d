"""Time of an arm: its clock, late and suspended programs."""

import dis
import itertools
import math
import random
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import SimpleNamespace

import pytest
from amounts import amount, every_row
from faults import as_it_stands, ready_arm, sim_arm, standing
from hypothesis import given
from hypothesis import strategies as st
from waiting import returns, until

from armdrive import Arm
from armdrive.arm.connected import Handle
from armdrive.connect.parts import assemble, connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.dialects.controller import ScriptRunner
from armdrive.errors import ArmError, BadRequest, DeviceFault, Stopped
from armdrive.registry import DIALECTS, simulate
from armdrive.runtime import clock as pace
from armdrive.runtime.clock import SUSPENDED_S, RealPace, SimulatedClock, SimulatedPace
from armdrive.status import LATE_S, NEVER_WOKEN, SchedulingJitter, State, Trust, status_view
from armdrive.tasks import ReadPosition, Registers, Timeout
from kinematics import Motors


def test_sleep_follows_the_arms_own_clock():
    arm = ready_arm()
    began_s = arm.status.time_s
    returns(lambda: arm.sleep(300.0))
    assert arm.status.time_s - began_s == pytest.approx(300.0)
    arm.sleep(0)
    with pytest.raises(BadRequest, match=r"^time_s must be 0 or more seconds"):
        arm.sleep(-1.0)
    assert arm.status.time_s - began_s == pytest.approx(300.0)


@every_row(
    "name, call",
    [
        ("duration_s", lambda arm, time_s: arm.jog_j(base=1, duration_s=time_s)),
        ("time_s", lambda arm, time_s: arm.sleep(time_s)),
    ],
)
@every_row("time_s", [1.1e6, 1e300])
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
    link.next_s = lambda: min(inner_s(), arm.parts.pace.now_s() + creep_s)
    with pytest.raises(ArmError, match="time is stuck"):
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
    assert arm.parts.pace._thread is None


def test_in_real_time_a_lost_wire_ends_the_thread_and_every_later_wait_returns_at_once():
    arm = ready_arm(pace=100.0)
    thread = arm.parts.pace._thread
    arm.twin.link.cut()
    arm.parts.pace.wake()
    until(lambda: not thread.is_alive())
    for call in (arm.stop, arm.io.read):
        with pytest.raises(ArmError):
            returns(call)
    returns(arm.close)


class Interrupted(BaseException):
    """What a signal handler raises."""


@contextmanager
def interrupted_after(calls: int) -> Iterator[None]:
    """Raise `Interrupted` after so many calls made by the clock, or by a lock that it uses.

    Python looks for signals after a call, and at the start of a function or of another round of a
    loop, where the clock has made no call that it would have to undo.
    """
    left, after_call = iter(range(calls)), False

    def trace(frame, event, _):
        nonlocal after_call
        if frame.f_code.co_filename not in (pace.__file__, threading.__file__):
            return None
        frame.f_trace_opcodes = True
        if event == "opcode":
            if after_call and next(left, None) is None:
                sys.settrace(None)
                raise Interrupted
            after_call = dis.opname[frame.f_code.co_code[frame.f_lasti]].startswith("CALL")
        return trace

    sys.settrace(trace)
    try:
        yield
    finally:
        sys.settrace(None)


def test_a_signal_may_interrupt_a_wait_at_any_moment():
    """Its exception is raised as it is, and the engine's thread is not locked out."""
    real = RealPace()
    for calls in itertools.count():
        try:
            with interrupted_after(calls):
                waited = real.wait(lambda: False, 1e-4)
        except Interrupted:
            assert not real.lock._is_owned(), calls
        else:
            break
    assert not waited
    assert calls > 10


def test_a_failed_engine_raises_in_every_waiting_call():
    arm = ready_arm(pace=100.0)
    arm.parts.engine.advance = lambda now_s: 1 / 0
    arm.parts.pace.wake()
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

    broken = reconnect = None

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
    monkeypatch.setattr(pace, "SUSPENDED_S", SUSPENDED_S)
    real = RealPace()
    sleeper = Sleeper(clock, place, asleep_s)
    real._engine = sleeper
    real._drive()
    assert real._failure is None
    assert [(rounds, round(time_s, 3)) for rounds, time_s in sleeper.missed] == [(2, asleep_s)]
    if asleep_s > SUSPENDED_S:
        assert (2 in sleeper.waits) == (place == "wait")


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
def test_bytes_prepared_before_a_suspension_are_not_sent_after_it(dialect):
    with standing(dialect) as arm:
        handle = arm.move_j(base_deg=40, wait=False)
        arm.sleep(0.5)
        engine, think = arm.parts.engine, arm.parts.engine.controller.advance
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


# -- Scheduling jitter -----------------------------------------------------------------------------


@given(st.lists(st.floats(-0.5, 3.0), min_size=1))
def test_every_deadline_counts_and_early_ones_are_punctual(late_s):
    jitter = NEVER_WOKEN
    for each in late_s:
        jitter = jitter.after(each)
    late = sum(each > LATE_S for each in late_s)
    assert jitter == SchedulingJitter(len(late_s), late, max(0.0, *late_s))


def test_on_simulated_time_nothing_is_late():
    with sim_arm() as arm:
        arm.sleep(1.0)
        assert arm.status.scheduling_jitter.count == 0
        assert "scheduling: " not in str(arm.status)


def test_a_thread_that_drives_an_arm_counts_its_deadlines():
    config = simulated_config("teachmover")
    with Arm(connect_simulated(config, pace="real")) as arm:
        until(lambda: arm.status.scheduling_jitter.count)
        status = arm.status
    assert status.scheduling_jitter.count > 0
    assert "scheduling: " in str(status)
    assert status_view(status)["scheduling_jitter"]["deadlines"] == status.scheduling_jitter.count


# -- A program that is called late -----------------------------------------------------------------
# It is late as a busy computer is: too little for anyone to call it suspended. What has come
# meanwhile is read before anything is judged to be missing, so that motions end as they were asked
# to, and none is called a failure for the time that nobody looked.

LATEST_S = {
    "teachmover": 0.9,
    "robko01": 0.9,
    "armdroid": 0.9,
    "grbl": 0.3,
    "mks": 0.2,
    "cia402": 0.1,
}
"""How late the program is at most. Drives on a bus stop by themselves where they hear nothing for
longer, and rightly. The banner of a GRBL board that is read later may be that of its button.
"""


class LateClock(SimulatedClock):
    """Simulated time in which the engine is called late, by a random time, at random."""

    def __init__(self, seed: int, latest_s: float) -> None:
        super().__init__()
        self._random = random.Random(seed)
        self._latest_s = latest_s
        self.late = False

    def advance(self) -> float:
        """Have the engine do what is due, and now and then call it later than it asked for."""
        next_s = super().advance()
        for engine in self.engines:  # a busy program is kept from what the device does, too
            engine.due_s = -math.inf
        if self.late and self._random.random() < 0.1:
            return max(next_s, self.now_s) + self._random.uniform(0.0, self._latest_s)
        return next_s


LATE_MOTIONS = [
    *((dialect, seed) for dialect in LATEST_S for seed in range(amount(1, 4))),
    *(("mks", seed) for seed in amount((103,), (103, 127, 195))),
]
"""The last: drives were read a while before their motion was resumed."""


@pytest.mark.parametrize(("dialect", "seed"), LATE_MOTIONS)
def test_every_motion_ends_as_it_was_asked_to(dialect, seed):
    config = simulated_config(dialect)
    twin = simulate(config)
    clock = LateClock(seed, LATEST_S[dialect])
    pace = SimulatedPace(clock)
    with Arm(assemble(config, twin.link, pace, simulated=True, operator=twin.operator)) as arm:
        arm.twin = twin
        as_it_stands(arm)
        first = arm.model.arm.joint_names[0]
        start_deg = arm.joints.deg[first]
        clock.late = True
        for way_deg in (10.0, -10.0, 3.0):
            arm.move_j(**{f"{first}_deg": start_deg + way_deg})
            assert twin.world.joints.deg[first] == pytest.approx(start_deg + way_deg, abs=0.5)
        motion = arm.move_j(wait=False, **{f"{first}_deg": start_deg - 30.0})
        arm.sleep(0.3)
        arm.stop()
        assert motion.done
        assert arm.status.state is State.STANDBY, arm.status.error
        assert arm.status.trust is Trust.REFERENCED


class Words:
    """A codec whose messages are words."""

    def __init__(self):
        self._words = []

    def receive_data(self, data):
        self._words += data.decode().split()

    def next_event(self):
        return self._words.pop(0) if self._words else None


class Waiting(ScriptRunner):
    """A driver that waits a second for the word `ready`."""

    def script(self, request):
        heard = yield from self.io.wait_for(self.io.now_s + 1.0, lambda word: word == "ready")
        return Registers(Motors((0,)), 0) if heard else self.io.silence(0.0)

    def unsolicited(self, heard):
        pass

    usable_rate_hz = duration_s = stopping = None  # nobody asks for a motion


@every_row(
    "came, reply",
    [(b"ready", Registers), (b"noise more ready", Registers), (b"noise", Timeout), (b"", Timeout)],
)
def test_a_late_program_reads_all_that_has_come_before_it_calls_an_answer_missing(came, reply):
    driver = Waiting(DIALECTS["teachmover"].abilities, Words())
    driver.begin(ReadPosition(), 0.0)
    driver.receive(came, 5.0)
    driver.advance(5.0)
    assert isinstance(driver.next_event(), reply)


def test_a_wire_that_never_falls_silent_does_not_keep_a_driver_waiting():
    driver = Waiting(DIALECTS["teachmover"].abilities, Words())
    driver.begin(ReadPosition(), 0.0)
    for now_s in (0.25, 0.5, 0.75, 1.0):
        assert driver.busy
        driver.receive(b"noise", now_s)
        driver.advance(now_s)
    assert isinstance(driver.next_event(), Timeout)


# -- A program that is suspended -------------------------------------------------------------------

ASLEEP_S = 400.0


class SleepyPace(SimulatedPace):
    """Simulated time that can jump, and tells the engine as the thread of real time does."""

    def sleep(self):
        with self.lock:
            self.clock.now_s += ASLEEP_S
            self._engine.suspended(ASLEEP_S)


def connected(dialect):
    config = simulated_config(dialect)
    twin = simulate(config)
    arm = Arm(assemble(config, twin.link, SleepyPace(), simulated=True, operator=twin.operator))
    arm.twin = twin
    return as_it_stands(arm), twin


def jogged_deg(arm, twin, direction):
    first = arm.model.arm.joint_names[0]
    before = twin.world.joints.deg[first]
    arm.jog_j(**{first: direction}, speed=1.0, duration_s=0.5)
    return abs(twin.world.joints.deg[first] - before)


@pytest.mark.parametrize("dialect", ["teachmover", "grbl", "mks"])
def test_a_motion_does_not_go_on_when_its_program_wakes_and_the_arm_is_no_slower(dialect):
    arm, twin = connected(dialect)
    jogged_deg(arm, twin, 1.0)
    as_before_deg = jogged_deg(arm, twin, -1.0)
    first = arm.model.arm.joint_names[0]
    handle = arm.move_j(wait=False, **{f"{first}_deg": arm.joints.deg[first] + 40.0})
    arm.sleep(0.3)
    assert twin.device.moving
    arm.parts.pace.sleep()
    arm.sleep(1.0)
    woken = twin.world.motors
    with pytest.raises((Stopped, DeviceFault)):  # or the deadline of an answer has passed
        handle.wait()
    arm.sleep(2.0)
    assert twin.world.motors == woken
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
        as_it_stands(arm)
    # what was measured over the sleep is not taken for the arm's speed
    assert jogged_deg(arm, twin, -1.0) == pytest.approx(as_before_deg, rel=0.2)


def test_a_lost_answer_makes_a_robko_no_slower():
    with standing("robko01") as arm:
        arm.move_j(base_deg=15.0)
        arm.move_j(base_deg=0.0)
        as_before_s = arm.move_j(base_deg=15.0).duration_s
        arm.twin.faults.add("drop", 0.005, side="device", seed=2, for_s=5.0)
        arm.move_j(base_deg=0.0)
        assert arm.move_j(base_deg=15.0).duration_s == pytest.approx(as_before_s, rel=0.05)


# -- orders that were prepared before a suspension ------------------------------------------------


@pytest.fixture
def arm() -> Iterator[Arm]:
    with standing("cia402") as arm:
        yield arm


def moving(arm: Arm) -> Handle:
    handle = arm.move_j(base_deg=40.0, wait=False)
    arm.sleep(0.3)
    return handle


@pytest.fixture
def said(arm, monkeypatch) -> list[bytes]:
    said: list[bytes] = []
    write = arm.parts.engine.link.write
    monkeypatch.setattr(
        arm.parts.engine.link, "write", lambda data, now_s: (said.append(data), write(data, now_s))
    )
    return said


def test_bytes_prepared_before_the_drives_stopped_are_not_sent(arm, said):
    moving(arm)
    arm.parts.engine.round_s = lambda: arm.parts.engine.controller.abilities.order_s + 0.01
    said.clear()
    arm.sleep(0.05)
    assert said == []


def test_bytes_of_a_round_of_usual_length_are_sent_and_a_stop_however_late_it_is(arm, said):
    handle = moving(arm)
    arm.parts.engine.round_s = lambda: arm.parts.engine.controller.abilities.order_s - 0.01
    said.clear()
    arm.sleep(0.6)
    assert not handle.done
    assert len(said) > 50
    arm.parts.engine.round_s = lambda: 0.9
    said.clear()
    arm.request_stop()
    with pytest.raises(Stopped):
        handle.wait()
    assert said


def test_orders_of_other_arms_may_be_late():
    with Arm.connect("sim:teachmover") as arm:
        arm.parts.engine.round_s = lambda: 0.9
        arm.home()
        arm.move_j(base_deg=10.0)
        assert arm.joints.deg["base"] == pytest.approx(10.0, abs=0.5)


def test_the_drives_of_a_closed_arm_hold_without_an_alarm(arm):
    """The last frames end the watch for a heartbeat that stays away from now on."""
    began_s = arm.parts.pace.now_s()
    arm.close()
    arm.twin.link.line.advance(began_s + 2.0)
    assert not any(node.states.watch_stops for node in arm.twin.device.board.nodes)
