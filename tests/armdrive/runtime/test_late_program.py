"""A program that is kept from its work, over and over, while its arm and the wire go on.

It is late as a busy computer is: too little for anyone to call it suspended. What has come
meanwhile is read before anything is judged to be missing, so that motions end as they were asked
to, and none is called a failure for the time that nobody looked.
"""

from __future__ import annotations

import math
import random

import pytest
from amounts import amount

from armdrive.arm import Arm
from armdrive.connect.parts import assemble
from armdrive.connect.target import simulated_config
from armdrive.dialects.controller import ScriptRunner
from armdrive.registry import DIALECTS, simulate
from armdrive.runtime.clock import SimulatedClock, SimulatedPace
from armdrive.status import State, Trust
from armdrive.tasks import ReadPosition, Registers, Timeout
from kinematics import Motors

LATE_S = {
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
    *((dialect, seed) for dialect in LATE_S for seed in range(amount(2, 4))),
    *(("mks", seed) for seed in (103, 127, 195)),
]
"""The last: drives were read a while before their motion was resumed."""


@pytest.mark.parametrize(("dialect", "seed"), LATE_MOTIONS)
def test_every_motion_ends_as_it_was_asked_to(dialect, seed):
    config = simulated_config(dialect)
    twin = simulate(config)
    clock = LateClock(seed, LATE_S[dialect])
    pace = SimulatedPace(clock)
    with Arm(assemble(config, twin.link, pace, simulated=True, operator=twin.operator)) as arm:
        if arm.status.state is State.DISABLED:
            arm.enable()
        joints, opening_mm = twin.world.body.transmission.to_joints(twin.world.motors)
        arm.declare_posture(joints, opening_mm=opening_mm)
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


@pytest.mark.parametrize(
    ("came", "reply"),
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
