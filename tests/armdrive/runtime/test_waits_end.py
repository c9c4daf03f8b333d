"""No call waits without an end: not on simulated time, and not in real time."""

from __future__ import annotations

import contextlib
import math

import pytest
from faults import as_it_stands, ready_arm

from armdrive.arm import Arm
from armdrive.blocking import run_blocking
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError, WrongState
from armdrive.motion import execute as pausing
from armdrive.moves import Jog
from armdrive.programs import running
from armdrive.programs.acts import Say
from armdrive.runtime import overrides
from armdrive.runtime.clock import RealPace, SimulatedClock, SimulatedPace
from armdrive.runtime.engine import Engine
from armdrive.runtime.overrides import LONGEST_PAUSE_S, NAPS
from armdrive.status import State
from armdrive.tasks import ReadPosition, RequestRejected, SleepUntil

LONGEST_WAIT_S = 3700.0
"""A pendant's program may be read for as long; nothing else comes near it."""


class SimulatedRealPace(RealPace):
    """What the driver takes for real time, and what passes as simulated time without a thread."""

    def __init__(self) -> None:
        super().__init__()
        self.clock = SimulatedClock()
        self.lock = self.clock.lock
        self.waits: list[float] = []

    def now_s(self) -> float:
        return self.clock.now_s

    def start(self, engine: Engine) -> None:
        self._engine = engine
        self.clock.add(engine)

    def wait(self, done, timeout_s):
        self.waits.append(timeout_s)
        end_s = self.clock.now_s + timeout_s
        return self.clock.wait(done, end_s, lambda: self._engine is not None)

    def wake(self) -> None:
        """Nothing sleeps."""

    def close(self) -> None:
        engine, self._engine = self._engine, None
        if engine is not None:
            self.clock.remove(engine)


class NotedPace(SimulatedPace):
    """Simulated time that notes how long it is waited for."""

    def __init__(self) -> None:
        super().__init__()
        self.waits: list[float] = []

    def wait(self, done, timeout_s):
        self.waits.append(timeout_s)
        return super().wait(done, timeout_s)


CALLS = {
    "move_j": lambda arm: arm.move_j(base_deg=3.0),
    "move_to": lambda arm: arm.move_to(arm.pose),
    "move_l": lambda arm: arm.move_l(arm.pose),
    "move_motors": lambda arm: arm.move_motors(*[5] * arm.abilities.motors),
    "park": lambda arm: arm.park(),
    "jog_j": lambda arm: arm.jog_j(base_deg=1.0),
    "jog_j for a time": lambda arm: arm.jog_j(base=1.0, duration_s=0.5),
    "jog_l": lambda arm: arm.jog_l(z_mm=1.0),
    "hold": lambda arm: arm.hold(Jog.joint(base=1.0), speed=0.3, for_s=0.5),
    "handle": lambda arm: arm.move_j(base_deg=2.0, wait=False).wait(),
    "cancel": lambda arm: arm.move_j(base_deg=9.0, wait=False).cancel(),
    "gripper": lambda arm: arm.gripper.move(15.0),
    "grasp": lambda arm: arm.gripper.grasp(),
    "home": lambda arm: arm.home(),
    "verify": lambda arm: arm.verify(operator=arm.operator),
    "confirm_reference": lambda arm: arm.confirm_reference(),
    "read_inputs": lambda arm: arm.read_inputs(),
    "set_outputs": lambda arm: arm.set_outputs(1),
    "wait_inputs": lambda arm: arm.wait_inputs(high=7, within_s=1.0),
    "sleep": lambda arm: arm.sleep(1.0),
    "stop": lambda arm: arm.stop(),
    "estop": lambda arm: arm.estop(),
    "reset": lambda arm: arm.reset(),
    "reconnect": lambda arm: arm.twin.link.unplug() or arm.sleep(1.0) or arm.reconnect(),
    "disable": lambda arm: arm.disable(),
    "enable": lambda arm: arm.enable(),
    "read_pendant_program": lambda arm: arm.read_pendant_program(),
    "close": lambda arm: arm.close(),
}


def referenced(pace) -> Arm:
    return as_it_stands(Arm(connect_simulated(simulated_config("teachmover"), pace=pace)))


def noted(monkeypatch, kind):
    """Return a connected arm whose pace is of a kind."""
    made = kind()
    monkeypatch.setattr("armdrive.connect.parts.pace_of", lambda _: made)
    return referenced(None), made


@pytest.mark.parametrize("call", CALLS)
@pytest.mark.parametrize("kind", [NotedPace, SimulatedRealPace])
def test_every_wait_of_a_call_has_an_end(monkeypatch, kind, call):
    arm, pace = noted(monkeypatch, kind)
    pace.waits.clear()
    with contextlib.suppress(ArmError):
        CALLS[call](arm)
    assert pace.waits or call in ("hold", "estop")
    assert all(math.isfinite(each) and each <= LONGEST_WAIT_S for each in pace.waits)


def test_only_a_wait_for_an_input_without_a_deadline_is_for_as_long_as_that_takes(monkeypatch):
    arm, pace = noted(monkeypatch, SimulatedRealPace)
    arm.twin.device.at(pace.now_s() + 30.0, arm.request_stop)
    pace.waits.clear()
    with pytest.raises(ArmError, match="stop"):
        arm.wait_inputs(high=7)
    assert pace.waits == [math.inf]
    assert pace.now_s() >= 30.0


def test_a_pause_in_real_time_costs_a_waiting_call_nothing(monkeypatch):
    arm, pace = noted(monkeypatch, SimulatedRealPace)
    arm.pause()
    arm.twin.device.at(pace.now_s() + 400.0, arm.resume)
    handle = arm.move_j(base_deg=5.0, wait=False)
    handle._timeout_s = 5.0  # the looks at a paused arm, counted as its patience, were 14 s
    handle.wait()
    assert arm.joints.deg["base"] == pytest.approx(5.0, abs=0.1)
    assert pace.now_s() > 400.0


def test_an_endless_pause_in_real_time_gives_up_the_motion_and_stays_paused(monkeypatch):
    monkeypatch.setattr(pausing, "LONGEST_PAUSE_S", 300.0)
    arm, pace = noted(monkeypatch, SimulatedRealPace)
    arm.pause()
    began_s, stood = pace.now_s(), arm.twin.world.motors
    with pytest.raises(WrongState, match=r"paused for 300 s.*`resume\(\)`.*`armdrive resume`"):
        arm.move_j(base_deg=5.0)
    assert pace.now_s() - began_s == pytest.approx(300.0, abs=2.0)
    assert arm.status.paused
    assert arm.status.state is State.STANDBY
    assert arm.twin.world.motors == stood
    arm.resume()
    arm.move_j(base_deg=5.0)


def test_eight_hours_are_what_is_waited_in_real_time():
    assert pausing.LONGEST_PAUSE_S == LONGEST_PAUSE_S == 8 * 3600.0


@pytest.mark.parametrize("dialect", ["teachmover", "grbl"])
def test_a_pause_on_simulated_time_that_cannot_end_does_not_hang(monkeypatch, dialect):
    breaths = []
    monkeypatch.setattr(overrides, "LONGEST_SIMULATED_PAUSE_S", 60.0)
    monkeypatch.setattr("armdrive.runtime.overrides.time.sleep", breaths.append)
    arm = Arm.connect(f"sim:{dialect}")
    arm.enable()
    as_it_stands(arm)
    handle = arm.move_j(base_deg=30.0, wait=False)
    arm.sleep(0.5)
    arm.pause()
    arm.sleep(2.0)
    stood, began_s = arm.twin.world.motors, arm.pace.now_s()
    with pytest.raises(WrongState, match="still paused"):
        handle.wait()
    assert arm.pace.now_s() - began_s == pytest.approx(60.0, abs=3.0)
    assert len(breaths) == NAPS
    assert arm.status.paused
    assert arm.twin.world.motors == stood
    arm.resume()
    arm.move_j(base_deg=30.0)


def test_a_program_that_paused_its_own_arm_does_not_hang(monkeypatch):
    slept = []
    monkeypatch.setattr(running.time, "sleep", slept.append)
    arm = Arm.connect("sim:teachmover")
    arm.pause()
    with pytest.raises(WrongState, match="still paused"):
        running.Performer(arm, None).perform(Say("on"))
    assert sum(slept) == pytest.approx(5.0, abs=0.05)


# -- tasks that never wait ------------------------------------------------------------------------


def restless(now_s):
    while True:
        yield SleepUntil(now_s)


def test_a_flow_that_goes_round_without_waiting_is_ended():
    arm = ready_arm()
    with pytest.raises(ArmError, match="without waiting"):
        run_blocking(arm.runner.perform(restless(arm.pace.now_s() - 1.0)))
    assert arm.move_j(base_deg=2).joints.deg["base"] == pytest.approx(2.0, abs=0.05)


def test_a_script_that_goes_round_without_waiting_is_ended():
    controller = ready_arm().core.controller
    controller.script = lambda _request: restless_script()
    controller.begin(ReadPosition(), 0.0)
    controller.advance(0.0)
    assert isinstance(controller.next_event(), RequestRejected)
    assert not controller.busy


def restless_script():
    while True:
        yield -1.0
