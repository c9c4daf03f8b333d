"""What a flight recorder notes, when it writes by itself, and what it leaves alone."""

import threading

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st
from recorder_bench import of_kind, recorded_arm, saved, written

from armdrive import Arm, Jog, LinkLost, NotReferenced, OutOfBounds, Space
from armdrive.blocking import run_blocking
from armdrive.cli.program.run import MOVING
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import StateFileError
from armdrive.moves import ContinuousJog
from armdrive.registry import DIALECTS
from armdrive.sim.wire import MemoryLink
from armdrive.trace import files
from armdrive.trace.entries import ENTRY_BYTES, EntryKind, EntryRing, TraceEntry
from armdrive.trace.recorder import CALLS


@pytest.fixture
def arm():
    arm = recorded_arm()
    arm.home()
    arm.move_j(shoulder_deg=40)
    yield arm
    arm.close()


def spied_on(monkeypatch, kind):
    """Count what passes every wire of a kind from now on."""
    passed, write, read = {"sent": b"", "heard": b""}, kind.write, kind.read

    def noted_write(self, data, now_s):
        passed["sent"] += data
        write(self, data, now_s)

    def noted_read(self, now_s):
        data = read(self, now_s)
        passed["heard"] += data
        return data

    monkeypatch.setattr(kind, "write", noted_write)
    monkeypatch.setattr(kind, "read", noted_read)
    return passed


@pytest.mark.parametrize("dialect", DIALECTS)
def test_every_byte_of_the_wire_is_noted_in_order(dialect, tmp_path, monkeypatch):
    passed = spied_on(monkeypatch, MemoryLink)
    arm = recorded_arm(dialect)
    arm.move_motors(5, 5, 5, 5, 5, 5)
    entries = saved(arm, tmp_path).entries
    assert b"".join(of_kind(entries, EntryKind.SENT)) == passed["sent"]
    assert b"".join(of_kind(entries, EntryKind.RECEIVED)) == passed["heard"]
    arm.close()


def test_what_a_program_does_is_noted_in_words(arm, tmp_path):
    with pytest.raises(OutOfBounds):
        arm.move_j(shoulder_deg=200)
    arm.gripper.open(30.0)
    arm.move_motors(0, 0, 0, 0, 5, 0)
    registers = " ".join(map(str, arm.twin.device.registers))
    handle = arm.move_j(base_deg=60, speed=0.2, wait=False)
    arm.sleep(0.5)
    arm.stop()
    assert handle.done
    arm.estop()
    arm.sleep(0.5)
    arm.reset()
    arm.disable()
    entries = saved(arm, tmp_path).entries
    calls = of_kind(entries, EntryKind.CALL)
    assert {"move_j shoulder 200 deg", "gripper.open 30"} <= set(calls)
    raised = of_kind(entries, EntryKind.RAISED)
    assert [each.partition(":")[0] for each in raised] == ["OutOfBounds", "Stopped"]
    requests = of_kind(entries, EntryKind.REQUEST)
    assert any(each.startswith("MoveBy(0 0 0 0 5 0; ") for each in requests)
    assert "done" in of_kind(entries, EntryKind.REPLY)
    counts = of_kind(entries, EntryKind.REGISTERS)
    assert any(each.startswith(registers) for each in counts)
    states = of_kind(entries, EntryKind.STATE)
    assert states[:3] == ["disconnected", "standby", "homing"]
    assert states[-3:] == ["error-stop", "standby", "disabled"]
    trust = of_kind(entries, EntryKind.TRUST)
    assert "referenced: referenced in the reference posture" in trust
    assert trust[-1] == "suspect: the motor current was switched off, and the arm can sag"
    assert of_kind(entries, EntryKind.CURRENT)[-1] == "off"
    assert len(of_kind(entries, EntryKind.OFFSET)) >= 2
    assert of_kind(entries, EntryKind.STOP)[:2] == ["normal stop", "emergency stop"]


def test_an_error_is_noted_once_however_many_calls_it_passes_through(tmp_path):
    with recorded_arm() as arm:
        with pytest.raises(NotReferenced):
            arm.reference.verify()
        entries = saved(arm, tmp_path).entries
    assert [each.split()[0] for each in of_kind(entries, EntryKind.CALL)] == [
        "reference.verify", "start",
    ]  # fmt: skip
    assert len(of_kind(entries, EntryKind.RAISED)) == 1


def lose_the_wire(arm):
    arm.twin.link.unplug()
    with pytest.raises(LinkLost):
        arm.io.read()


def run_into_a_flaw(arm):
    def flawed():
        yield from ()
        raise ZeroDivisionError("one of ours")

    with pytest.raises(ZeroDivisionError):
        run_blocking(arm.parts.runner.perform(flawed()))


@pytest.mark.parametrize(
    ("fail", "why", "words"),
    [
        (lambda arm: arm.estop(), "error-stop", "emergency stop"),
        (lose_the_wire, "link-lost", "LinkLost: "),
        (run_into_a_flaw, "engine-failed", "ZeroDivisionError: one of ours"),
    ],
)
def test_a_fault_is_written_by_itself_at_once_and_a_closed_arm_is_not(fail, why, words, tmp_path):
    arm = recorded_arm(folder=tmp_path / "failed")
    fail(arm)
    arm.parts.tracer.close()
    (file,) = written(tmp_path / "failed")
    assert file.name.endswith(f"-001-{why}.jsonl")
    assert words in file.read_text()
    arm.close()
    assert written(tmp_path / "failed") == [file]
    recorded_arm(folder=tmp_path / "closed").close()
    assert written(tmp_path / "closed") == []


def test_another_thread_writes_so_that_a_slow_disk_delays_no_motion(tmp_path, monkeypatch):
    seen = []
    monkeypatch.setattr(
        "armdrive.trace.files.write_recording",
        lambda *_, **__: seen.append(threading.current_thread().name),
    )
    arm = recorded_arm(folder=tmp_path)
    arm.estop()
    arm.close()
    assert seen == ["armdrive-recorder"]


def test_only_so_many_files_are_left_and_the_oldest_go(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "MOST_FILES", 3)
    arm = recorded_arm(folder=tmp_path)
    made = [arm.recorder.save() for _ in range(5)]
    assert written(tmp_path) == sorted(made[-3:])
    arm.close()


def test_a_folder_that_cannot_be_written_is_an_error_of_the_call_and_none_of_the_motion(tmp_path):
    (tmp_path / "blocked").write_text("a file")
    arm = recorded_arm(folder=tmp_path / "blocked")
    arm.estop()
    arm.parts.tracer.files.finish()
    arm.sleep(1.0)
    assert "could not write a recording: " in arm.status.notice
    assert "cannot be written" in arm.status.notice
    arm.reset()
    arm.sleep(1.0)
    assert arm.status.notice == ""  # told once
    with pytest.raises(StateFileError, match="cannot be written"):
        arm.recorder.save()
    arm.close()


def test_a_file_is_whole_or_not_there(tmp_path, monkeypatch):
    def full(_handle):
        raise OSError(28, "No space left on device")

    with recorded_arm() as arm, monkeypatch.context() as patched:
        patched.setattr("os.fsync", full)
        with pytest.raises(StateFileError, match="No space left"):
            arm.recorder.save(tmp_path / "recording.jsonl")
    assert written(tmp_path) == []


def test_scripts_on_a_simulated_arm_leave_no_files(tmp_path, monkeypatch):
    monkeypatch.setenv("ARMDRIVE_HOME", str(tmp_path))
    arm = Arm(connect_simulated(simulated_config("teachmover")))
    arm.estop()
    arm.close()
    assert written(tmp_path) == []
    assert arm.recorder.save().is_file()  # asked for, it is written all the same


LETTING_GO = [
    ("estop", lambda arm: arm.estop()),
    ("jogging.release", lambda arm: arm.jogging.release()),
]


@pytest.mark.parametrize(("name", "call"), LETTING_GO)
def test_calls_that_let_go_of_an_arm_wait_for_no_lock(arm, name, call, tmp_path):
    """Somebody plans a long motion, and has the lock; letting go works all the same."""
    planning, planned = threading.Event(), threading.Event()

    def plan():
        with arm.parts.pace.lock:
            planning.set()
            planned.wait(10.0)

    planner = threading.Thread(target=plan)
    planner.start()
    planning.wait(10.0)
    stopper = threading.Thread(target=call, args=(arm,))
    arm.parts.core.hold = ContinuousJog(Jog(Space.JOINT, (("base", 1.0),)), 0.1, 1e9)
    stopper.start()
    let_go = threading.Event()
    for _ in range(5000):
        if arm.parts.core.hold is None or let_go.wait(0.001):
            break
    let_go_first = arm.parts.core.hold is None
    planned.set()
    stopper.join()
    planner.join()
    assert let_go_first
    assert name in of_kind(saved(arm, tmp_path).entries, EntryKind.CALL)


# -- its memory -----------------------------------------------------------------------------------

kinds = st.sampled_from(
    [EntryKind.SENT, EntryKind.RECEIVED, EntryKind.REQUEST, EntryKind.REPLY, EntryKind.OFFSET]
)
words = st.sampled_from(["MoveBy(1)", "SwitchOn()", "SetOutputs(bits=3)", "1 2 3", "done"])


@st.composite
def runs(draw):
    time_s, run = 0.0, []
    for _ in range(draw(st.integers(0, 60))):
        time_s += draw(st.floats(0.0, 20.0))
        kind, text = draw(kinds), draw(words)
        run.append(TraceEntry(time_s, kind, text.encode() if kind is EntryKind.SENT else text))
    return run


def filled(entries, sealed_after, **bounds):
    ring = EntryRing(**bounds)
    for index, entry in enumerate(entries):
        if index == sealed_after:
            ring.seal()
        ring.add(entry)
    return ring


@given(runs(), st.integers(0, 10), st.integers(200, 3000), st.floats(1.0, 100.0))
def test_it_keeps_the_beginning_the_end_and_lasting_settings_within_bounds(
    run, sealed_after, most_bytes, longest_s
):
    assert list(filled(run, sealed_after, longest_s=1e9).entries()) == run  # what fits is whole
    opening = 1500
    ring = filled(
        run,
        sealed_after,
        most_bytes=most_bytes,
        longest_s=longest_s,
        most_opening_bytes=opening,
    )
    kept = ring.entries()
    assert ring.bytes <= most_bytes
    size = sum(ENTRY_BYTES + len(each.what) for each in kept if each.kind is not EntryKind.DROPPED)
    assert size <= most_bytes + opening + ENTRY_BYTES + 20  # the entry that closes the beginning
    assert [each.time_s for each in kept] == sorted(each.time_s for each in kept)
    kept = filled(run, sealed_after, most_bytes=most_bytes, longest_s=1e9).entries()
    if sealed_after:
        assert list(kept[:sealed_after]) == run[:sealed_after]
        assert not run or kept[-1] == run[-1] or kept[-1].kind is EntryKind.DROPPED
    for entry in run:
        lasting = entry.kind is EntryKind.REQUEST and entry.what.startswith(
            ("SwitchOn", "SetOutputs")
        )
        assert entry in kept or not (lasting or entry.kind is EntryKind.OFFSET)


def test_a_gap_stands_where_something_went():
    run = [TraceEntry(float(t), EntryKind.REPLY, "done") for t in range(100)]
    kept = filled(run, 1, longest_s=10.0).entries()
    assert [each.kind for each in kept[:3]] == [
        EntryKind.REPLY,
        EntryKind.DROPPED,
        EntryKind.DROPPED,
    ]
    assert kept[3].time_s == 89.0


# -- the calls that it notes ----------------------------------------------------------------------

PREFIXES = ("move_", "jog_")
CALLS_THAT_MOVE = sorted(name for name in dir(Arm) if name.startswith(PREFIXES))


@every_row("name", CALLS_THAT_MOVE)
def test_a_call_that_moves_is_noted_and_waited_before(name):
    assert name in CALLS[""]
    assert name in MOVING
