"""A disk that takes its time, in real time: it delays motion, never a stop, and never the wire."""

from __future__ import annotations

import math
import threading

import pytest
from faults import OVER_THE_TABLE, sim_config
from waiting import LONG_S, returns

from armdrive import Arm
from armdrive.connect import parts
from armdrive.connect.parts import connect_simulated
from armdrive.errors import ArmError, StateFileError, Stopped
from armdrive.motion import connecting
from armdrive.moves import Jog, Space
from armdrive.registry import simulate
from armdrive.runtime.position import ArmCoordinates
from armdrive.status import State
from armdrive.storage.files import StateFiles
from armdrive.storage.record import FileRecorder

FASTER = 20.0


class SlowDisk(StateFiles):
    """Brings nothing to the disk while it is held; says who waits for it."""

    def __init__(self):
        self.free = threading.Event()
        self.free.set()
        self.asked = threading.Event()
        self.threads = set()

    def sync(self, handle):
        self.threads.add(threading.current_thread().name)
        self.asked.set()
        assert self.free.wait(LONG_S)
        super().sync(handle)

    def hold(self):
        self.asked.clear()
        self.free.clear()

    def is_waited_for(self):
        return self.asked.wait(LONG_S)


class Bench:
    def __init__(self, path):
        self.path = path
        self.config = sim_config()
        self.twin = simulate(self.config)
        world = self.twin.world
        world.drive_to(world.body.transmission.to_motors(OVER_THE_TABLE, 20.0))
        self.disk = SlowDisk()
        self.recorder = FileRecorder(path, self.disk)
        self.arm = Arm(
            connect_simulated(self.config, twin=self.twin, recorder=self.recorder, pace=FASTER)
        )
        self.arm.declare_posture(OVER_THE_TABLE, opening_mm=20.0)
        self.start = self.motors

    @property
    def motors(self):
        return self.twin.world.motors

    def let_time_pass(self, time_s):
        """Let the engine run for this long."""
        until_s = self.arm.engine.now_s + time_s
        assert self.arm.pace.wait(lambda: self.arm.engine.now_s >= until_s, LONG_S * FASTER)


@pytest.fixture
def bench(tmp_path):
    made = Bench(tmp_path / "arm.json")
    yield made
    made.disk.free.set()
    made.arm.close()


def test_no_motion_begins_before_its_mark_is_on_the_disk_and_then_it_does(bench):
    bench.disk.hold()
    handle = bench.arm.move_j(base_deg=5.0, wait=False)
    assert bench.disk.is_waited_for()
    bench.let_time_pass(3.0)
    assert bench.motors == bench.start
    bench.disk.free.set()
    handle.wait()
    assert bench.motors != bench.start
    assert bench.recorder.load().in_motion


def test_a_stop_does_not_wait_for_the_disk(bench):
    bench.disk.hold()
    handle = bench.arm.move_j(base_deg=5.0, wait=False)
    assert bench.disk.is_waited_for()
    bench.arm.stop()
    assert not bench.disk.free.is_set()
    with pytest.raises(Stopped):
        handle.wait()
    assert bench.arm.status.state is State.STANDBY
    bench.disk.free.set()
    bench.let_time_pass(1.0)
    assert bench.motors == bench.start


def test_a_jog_released_while_the_disk_was_busy_does_not_begin(bench):
    bench.disk.hold()
    bench.arm.hold(Jog(Space.JOINT, (("base", 1.0),)), speed=1.0, for_s=0.5)
    assert bench.disk.is_waited_for()
    bench.let_time_pass(2.0)
    bench.disk.free.set()
    bench.let_time_pass(2.0)
    assert bench.arm.status.state is State.STANDBY
    assert bench.motors == bench.start


def test_what_happens_to_the_arm_meanwhile_is_seen_before_it_moves(bench):
    bench.disk.hold()
    handle = bench.arm.move_j(base_deg=5.0, wait=False)
    assert bench.disk.is_waited_for()
    bench.let_time_pass(1.0)
    with bench.arm.pace.lock:
        bench.twin.device.jog((300, 0, 0, 0, 0, 0))
    bench.disk.free.set()
    with pytest.raises(Exception, match="pendant"):
        handle.wait()
    assert bench.motors[0] == bench.start[0] + 300


@pytest.mark.parametrize("alarmed", ["estop", "reset by somebody"])
def test_an_error_while_the_disk_is_busy_ends_the_motion_before_it_began(bench, alarmed):
    bench.disk.hold()
    handle = bench.arm.move_j(base_deg=5.0, wait=False)
    assert bench.disk.is_waited_for()
    if alarmed == "estop":
        bench.arm.estop()
    else:
        with bench.arm.pace.lock:
            bench.arm.core.fault("the board was reset")
    bench.disk.free.set()
    with pytest.raises(ArmError):
        handle.wait()
    assert bench.arm.status.state is State.ERROR_STOP
    assert bench.motors == bench.start


def test_the_wires_thread_never_writes(bench):
    for angle_deg in (2.0, 0.0):
        bench.arm.move_j(base_deg=angle_deg)
        bench.arm.sleep(2.5)
    bench.arm.close()
    assert bench.disk.threads == {"armdrive-record"}
    assert not bench.recorder.load().in_motion


def test_a_disk_that_is_stuck_at_the_end_is_given_up_and_puts_nothing_in_place_later(
    bench, monkeypatch
):
    monkeypatch.setattr(parts, "CLOSING_S", 0.05)
    monkeypatch.setattr(connecting, "STILL_S", math.inf)
    bench.arm.move_j(base_deg=2.0)
    marked = bench.path.read_bytes()
    bench.disk.hold()
    returns(bench.arm.close)
    bench.disk.free.set()
    assert bench.arm.core.memory._writer.finish(LONG_S)
    assert bench.path.read_bytes() == marked
    assert [each.name for each in bench.path.parent.iterdir()] == ["arm.json"]


def test_of_many_beliefs_a_slow_disk_writes_the_newest(bench, monkeypatch):
    monkeypatch.setattr(connecting, "STILL_S", math.inf)
    writes, core = [], bench.arm.core
    replace = bench.disk.replace
    bench.disk.replace = lambda *names: (replace(*names), writes.append(bench.recorder.load()))
    bench.arm.move_j(base_deg=1.0)
    bench.disk.hold()
    for angle_deg in (10.0, 20.0, 30.0):
        there = ArmCoordinates(OVER_THE_TABLE.replace(base=math.radians(angle_deg)), 20.0)
        with bench.arm.pace.lock:
            core.position.refer(core.position.acknowledged - core.position.offset, there)
            core.remember()
        assert bench.disk.is_waited_for()
    bench.disk.free.set()
    bench.arm.close()
    written = [round(math.degrees(each.coordinates[0])) for each in writes[1:]]
    assert list(dict.fromkeys(written)) == [10, 30]  # closing may write the newest once more


def test_a_disk_that_fills_up_refuses_motion_in_real_time_too(bench):
    def full(handle, data):
        raise OSError(28, "No space left on device")

    bench.disk.write = full
    with pytest.raises(StateFileError, match="No space left"):
        bench.arm.move_j(base_deg=5.0)
    assert bench.motors == bench.start
    del bench.disk.write
    bench.arm.move_j(base_deg=5.0)
    assert bench.motors != bench.start
