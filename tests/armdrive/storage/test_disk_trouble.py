"""A disk that is slow, full, dying or read-only: what moves, what is believed, and what is said."""

import io
import math
import os
import sys
import threading
import time
from pathlib import Path

import pytest
from faults import OVER_THE_TABLE, sim_config
from power_disk import Moments
from power_life import PATH, believed, move, recorded_life, wrong
from served import Served
from waiting import LONG_S, returns

from armdrive import Arm
from armdrive.connect import connection
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config, state_file
from armdrive.errors import ArmError, StateFileError, Stopped
from armdrive.moves import Jog, Space
from armdrive.registry import simulate
from armdrive.runtime import persistence
from armdrive.runtime.position import ArmCoordinates
from armdrive.status import Current, State, Trust
from armdrive.storage import files as places
from armdrive.storage.files import UNFINISHED, StateFiles
from armdrive.storage.record import RecordFile, from_text

# A disk that takes its time, in real time: it delays motion, never a stop, and never the wire.

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
        self.recorder = RecordFile(path, self.disk)
        self.arm = Arm(
            connect_simulated(self.config, twin=self.twin, record_store=self.recorder, pace=FASTER)
        )
        self.arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
        self.start = self.motors

    @property
    def motors(self):
        return self.twin.world.motors

    def let_time_pass(self, time_s):
        """Let the engine run for this long."""
        until_s = self.arm.parts.engine.now_s + time_s
        assert self.arm.parts.pace.wait(
            lambda: self.arm.parts.engine.now_s >= until_s, LONG_S * FASTER
        )


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


@pytest.mark.parametrize("resumed", [False, True])
def test_a_stop_does_not_wait_for_the_disk_and_lets_nothing_begin(bench, resumed):
    if resumed:  # a pause has taken the mark away
        bench.arm.pause()
    else:
        bench.disk.hold()
    handle = bench.arm.move_j(base_deg=5.0, wait=False)
    if resumed:
        bench.let_time_pass(1.0)
        assert not bench.recorder.load().in_motion
        bench.disk.hold()
        bench.arm.resume()
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
    bench.arm.jogging.hold(Jog(Space.JOINT, (("base", 1.0),)), speed=1.0, for_s=0.5)
    assert bench.disk.is_waited_for()
    bench.let_time_pass(2.0)
    bench.disk.free.set()
    bench.let_time_pass(2.0)
    assert bench.arm.status.state is State.STANDBY
    assert bench.motors == bench.start


def test_changes_while_the_disk_is_slow_are_noticed_before_the_arm_moves(bench):
    bench.disk.hold()
    handle = bench.arm.move_j(base_deg=5.0, wait=False)
    assert bench.disk.is_waited_for()
    bench.let_time_pass(1.0)
    with bench.arm.parts.pace.lock:
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
        with bench.arm.parts.pace.lock:
            bench.arm.parts.core.fault("the board was reset")
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
    monkeypatch.setattr(connection, "CLOSING_S", 0.05)
    monkeypatch.setattr(persistence, "STILL_S", math.inf)
    bench.arm.move_j(base_deg=2.0)
    marked = bench.path.read_bytes()
    bench.disk.hold()
    returns(bench.arm.close)
    bench.disk.free.set()
    assert bench.arm.parts.core.memory._writer.finish(LONG_S)
    assert bench.path.read_bytes() == marked
    assert [each.name for each in bench.path.parent.iterdir()] == ["arm.json"]


def test_of_many_beliefs_a_slow_disk_writes_the_newest(bench, monkeypatch):
    monkeypatch.setattr(persistence, "STILL_S", math.inf)
    writes, core = [], bench.arm.parts.core
    replace = bench.disk.replace
    bench.disk.replace = lambda *names: (replace(*names), writes.append(bench.recorder.load()))
    bench.arm.move_j(base_deg=1.0)
    bench.disk.hold()
    for angle_deg in (10.0, 20.0, 30.0):
        there = ArmCoordinates(OVER_THE_TABLE.replace(base=math.radians(angle_deg)), 20.0)
        with bench.arm.parts.pace.lock:
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


# A disk without room, a dying one, a folder that is read-only, a clock that is set: what moves.


@pytest.mark.parametrize("also_removing", [False, True])
def test_a_disk_that_fills_up_or_dies_at_any_moment_leads_to_nothing_wrong(also_removing):
    moment, outcomes = 0, set()
    while True:
        life = recorded_life()
        life.disk.moments = Moments()
        life.disk.fails_from, life.disk.fails_to_remove = moment, also_removing
        try:
            move(life)
        except StateFileError:
            life.arm.close()
        life.end()
        if not life.disk.failed:
            break
        trust, position = believed(life, life.disk.after_kill(PATH))
        outcomes.add(trust)
        assert not list(wrong([(moment, trust, position, life.motors)])), moment
        moment += 1
    found = {Trust.RESTORED, Trust.SUSPECT}
    assert outcomes == found if also_removing else found | {Trust.UNKNOWN}


@pytest.mark.parametrize("room", [0, 1, 100, 200])
def test_without_room_for_the_mark_nothing_moves_and_the_position_stays_known(room):
    life = recorded_life()
    arm = life.connect(allow_restored=True)
    life.disk.room = room
    before = life.motors
    with pytest.raises(StateFileError, match=r"No space left on device.*free some disk space"):
        arm.move_j(base_deg=4.0)
    assert arm.status.state is State.STANDBY
    assert life.motors == before
    arm.sleep(3.0)  # the mark is taken away meanwhile, in vain too
    assert not from_text(life.disk.after_kill(PATH)).in_motion
    life.disk.room = math.inf
    arm.move_j(base_deg=4.0)
    assert life.motors != before
    arm.close()
    life.end()
    assert believed(life, life.disk.after_kill(PATH)) == (Trust.RESTORED, life.motors)


def test_a_full_disk_in_mid_motion_is_reported_and_the_motion_goes_on():
    life = recorded_life()
    arm = life.connect(allow_restored=True)
    handle = arm.move_j(base_deg=10.0, wait=False)
    arm.sleep(0.3)
    life.disk.room = 0
    handle.wait()
    arm.sleep(3.0)
    assert "No space" in arm.status.notice
    assert "Errno" not in arm.status.notice
    life.disk.room = math.inf
    arm.sleep(3.0)
    life.end()
    assert believed(life, life.disk.after_kill(PATH)) == (Trust.RESTORED, life.motors)


def test_a_record_that_is_no_longer_true_is_removed_from_a_full_disk():
    life = recorded_life()
    arm = life.connect()
    life.disk.room = 0
    life.twin.device.jog((30, 0, 0, 0, 0, 0))
    arm.io.read()
    assert arm.status.trust is Trust.SUSPECT
    assert life.disk.after_kill(PATH) is None
    life.twin.device.jog((-30, 0, 0, 0, 0, 0))
    life.end()
    assert believed(life, None)[0] is Trust.UNKNOWN


def test_a_full_disk_keeps_no_motor_on_and_leaves_nothing_to_believe():
    life = recorded_life()
    arm = life.connect(allow_restored=True)
    life.disk.room = 0
    arm.reference.declare(arm.joints)
    assert "No space" in arm.status.notice
    life.disk.room = math.inf
    arm.sleep(3.0)
    assert from_text(life.disk.after_kill(PATH)).trust == "referenced"  # it was tried again
    life.disk.room = 0
    arm.disable()
    assert arm.status.current is Current.OFF
    assert life.disk.after_kill(PATH) is None


@pytest.mark.parametrize("to_s", [-1e6, 0.0, 4e9])
def test_a_clock_that_is_set_changes_nothing(monkeypatch, to_s):
    life = recorded_life()
    arm = life.connect(allow_restored=True)
    arm.move_j(base_deg=4.0)
    monkeypatch.setattr(time, "time", lambda: to_s)
    assert from_text(life.disk.after_kill(PATH)).in_motion
    arm.sleep(2.5)
    assert not from_text(life.disk.after_kill(PATH)).in_motion
    life.end()
    assert believed(life, life.disk.after_kill(PATH)) == (Trust.RESTORED, life.motors)


def test_the_mark_is_written_once_for_many_bursts_and_moves_and_cleared_once():
    life = recorded_life()
    arm = life.connect(allow_restored=True)
    kept = []
    replace = life.disk.replace
    life.disk.replace = lambda *names: (replace(*names), kept.append(life.disk.after_kill(PATH)))
    for angle_deg in (10.0, 0.0, 10.0):
        arm.move_j(base_deg=angle_deg)
    arm.jog_j(base_deg=-2.0)
    arm.sleep(10.0)
    assert [from_text(text).in_motion for text in kept] == [True, False]


# A state folder that cannot be written: one sentence from every command, and nothing moves.


DRIVING = [
    ("status", "--json"),
    ("home", "--fresh"),
    ("shell",),
    ("points", "save", "pick"),
]
"""Commands that hold the arm: without the lock nobody may, not even to look."""

WRITING = [
    ("config", "new", "lab", "--yes", "--template", "teachmover"),
]
HOLDING_NOTHING = [
    ("stop",),
    ("points", "list"),
    ("config", "list"),
    ("log",),
    ("teach", "pick.arm"),
]
"""Commands that hold no arm, and do what they can, or say a sentence."""


def a_file_in_its_place(monkeypatch, tmp_path):
    (tmp_path / "home").write_text("")
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path / "home"))


def a_place_where_nothing_is_made(monkeypatch, tmp_path):
    if not Path("/proc/self").exists():
        pytest.skip("there is no /proc")
    monkeypatch.setenv("ARMDRIVE_HOME", "/proc/self/armdrive")


def a_read_only_disk(monkeypatch, tmp_path):
    """Root ignores modes, so the system's own answer is given here."""

    def refused(*words, **named):
        raise OSError(30, "Read-only file system", str(words[-1]))

    places.states().mkdir(parents=True, exist_ok=True)
    for name in ("create", "make_folder", "replace", "remove"):
        monkeypatch.setattr(StateFiles, name, refused)
    monkeypatch.setattr(StateFiles, "may_change", lambda files, folder: False)
    monkeypatch.setattr(Path, "unlink", refused)


@pytest.fixture
def unwritable(request, monkeypatch, tmp_path):
    monkeypatch.setattr(sys, "stdin", io.StringIO())
    with monkeypatch.context() as patched:
        getattr(request, "param", a_read_only_disk)(patched, tmp_path)
        yield


@pytest.mark.parametrize(
    "unwritable", [a_file_in_its_place, a_place_where_nothing_is_made], indirect=True
)
def test_a_place_that_can_be_no_folder_is_named(call, unwritable):
    assert "is not writable" in call.refused("status", code=1)
    with pytest.raises(StateFileError, match="no arm can be locked"):
        Arm.connect("/dev/no-such-port", dialect="teachmover")


@pytest.mark.parametrize("words", [*DRIVING, *WRITING], ids=" ".join)
def test_a_command_that_needs_the_folder_fails_with_one_sentence(call, unwritable, words):
    said = call.refused(*words, code=1)
    assert "Errno" not in said
    assert os.environ["ARMDRIVE_HOME"] in said
    assert "writable" in said
    assert "no arm can be locked" in said or words in WRITING or "--fresh" in words


@pytest.mark.parametrize("words", [("home",), ("points", "save", "pick")], ids=" ".join)
@pytest.mark.parametrize("operation", ["create", "write"])
def test_a_command_on_a_full_disk_names_the_file_that_has_no_room(
    call, monkeypatch, operation, words
):
    create = StateFiles.create

    def no_room(files, what, *_) -> int:
        if operation == "create" and not what.name.endswith(UNFINISHED):
            return create(files, what)  # an empty file still fits
        raise OSError(28, "No space left on device", *([what] if operation == "create" else []))

    monkeypatch.setattr(StateFiles, operation, no_room)
    said = call.refused(*words, code=1)
    assert "Errno" not in said
    assert f"{os.environ['ARMDRIVE_HOME']}{os.sep}" in said
    assert UNFINISHED not in said
    assert "(No space left on device): free some space" in said


@pytest.mark.parametrize("words", HOLDING_NOTHING, ids=" ".join)
def test_a_command_that_holds_no_arm_does_what_it_can(call, unwritable, words):
    called = call(*words)
    assert called.err.count("\n") <= 1
    assert "Errno" not in called.err


def test_the_demo_needs_no_folder(call, unwritable):
    assert call("demo", code=0).err == ""


def test_without_a_writable_folder_the_position_is_unknown_and_nothing_moves(monkeypatch, tmp_path):
    """What docs/background/trust.md promises of an arm that is connected all the same."""
    path = state_file("bench")
    config = simulated_config("teachmover")
    with Arm(connect_simulated(config, record_store=RecordFile(path))) as arm:
        arm.reference.confirm()
        world = arm.twin.save()
    before = path.read_bytes()
    with monkeypatch.context() as patched:
        a_read_only_disk(patched, tmp_path)
        with Arm(
            connect_simulated(config, twin=simulate(config, world), record_store=RecordFile(path))
        ) as arm:
            assert arm.status.trust is Trust.UNKNOWN
            assert "make the folder writable" in arm.status.trust_reason
            motors = arm.twin.world.motors
            with pytest.raises(StateFileError, match="free some disk space or make the folder"):
                arm.jog_j(base_deg=1.0)
            assert arm.twin.world.motors == motors
    assert path.read_bytes() == before


# -- a disk that is full when an arm is locked ----------------------------------------------------


@pytest.fixture
def full(monkeypatch):
    create = StateFiles.create

    def created(files, path):
        if ".holder" in path.name:
            raise OSError(28, "No space left on device")
        return create(files, path)

    monkeypatch.setattr(StateFiles, "create", created)
    return monkeypatch


def test_a_command_says_which_file_cannot_be_written(call, full):
    said = call.refused("enable", code=1)
    assert ".holder cannot be written (No space left on device); free disk space" in said
    full.undo()
    call("enable", code=0)


def test_a_real_arm_can_be_read_with_a_full_disk(call, full, tmp_path):
    with Served("teachmover", pty=tmp_path / "arm") as served:
        port = ("--port", served.port, "--dialect", "teachmover")
        assert "motors" in call("status", *port, code=0).out
        assert ".holder cannot be written" in call.refused("enable", *port, code=1)
        full.undo()
        call("enable", *port, code=0)  # the lock was given back


def test_the_port_and_the_lock_are_given_back(full, tmp_path):
    with Served("teachmover", pty=tmp_path / "arm") as served:
        with pytest.raises(StateFileError, match="cannot be written"):
            Arm.connect(served.port, dialect="teachmover")
        full.undo()
        with Arm.connect(served.port, dialect="teachmover") as arm:
            assert not arm.simulated
