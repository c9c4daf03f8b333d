"""A replay agrees with an arm that did as its twin does, and finds where one did not."""

from __future__ import annotations

import pytest
from recorder_bench import recorded_arm, saved, written

from armdrive import Arm, ArmError
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config, state_file
from armdrive.registry import DIALECTS, simulate
from armdrive.sim.device import state_json
from armdrive.storage.record import FileRecorder
from armdrive.trace import replay as replaying
from armdrive.trace.entries import EntryRing
from armdrive.trace.files import read_recording
from armdrive.trace.log import lines
from armdrive.trace.recorder import FlightRecorder
from armdrive.trace.replay import ReplayBench, replay, replayed_view

SMALL = ("teachmover", "armdroid", "grbl")
"""The dialects whose recordings are short: a Robko is asked for its position all the time."""


def work(arm):
    referenced(arm)
    arm.move_j(base_deg=6)
    arm.jog_j(base=1.0, duration_s=0.3)
    handle = arm.move_j(base_deg=30, speed=0.3, wait=False)
    arm.sleep(0.4)
    arm.stop()
    assert handle.done
    arm.sleep(0.2)


@pytest.fixture(scope="module")
def days(tmp_path_factory):
    """A day's work of each dialect, recorded."""
    found = {}
    for dialect in DIALECTS:
        arm = recorded_arm(dialect)
        work(arm)
        found[dialect] = saved(arm, tmp_path_factory.mktemp(dialect)), arm.twin.world.motors
        arm.close()
    return found


@pytest.fixture(scope="module")
def replays(days):
    """What came of replaying each day, and where the twin's motors stood at its end."""
    benches, bench = [], replaying.ReplayBench

    def remembered(*words):
        benches.append(bench(*words))
        return benches[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(replaying, "ReplayBench", remembered)
        return {
            dialect: (replay(recording), tuple(state_json(benches[-1].device)["motors"]))
            for dialect, (recording, _) in days.items()
        }


@pytest.mark.parametrize("dialect", DIALECTS)
def test_a_twin_repeats_what_a_simulated_arm_said_to_the_byte_and_the_moment(
    days, replays, dialect
):
    replayed, stood = replays[dialect]
    assert replayed.divergence is None
    assert replayed.compared > 30
    assert replayed.late_s == pytest.approx(0.0, abs=1e-9)
    assert replayed.notes == ()
    assert stood == tuple(days[dialect][1])


@pytest.mark.parametrize("dialect", DIALECTS)
def test_the_timeline_tells_every_entry_and_reads_every_message(days, dialect):
    recording, _ = days[dialect]
    told = [text for _, text in lines(recording)]
    assert len(told) == len(recording.entries)
    unreadable = [text for text in told if "unreadable" in text]
    assert len(unreadable) <= 1, unreadable  # the first line to a TeachMover is one on purpose
    assert any("call: move_j(base_deg=6)" in text for text in told)


def test_a_twin_is_placed_by_the_counts_and_by_where_the_motors_are():
    bench = ReplayBench(simulated_config("teachmover"))
    counts, motors = (1, 2, 3, 4, 5, 6), (10, 20, 30, 40, 50, 60)
    bench.place(counts, motors)
    assert tuple(bench.device.registers) == counts
    assert tuple(bench.device.world.motors) == motors


def test_a_slower_twin_gets_its_bytes_later_and_still_agrees(days):
    recording, _ = days["teachmover"]
    replayed = replay(recording, {"speed_error": 0.3})
    assert replayed.divergence is None
    assert replayed.late_s > 0.5


def referenced(arm):
    """Home an arm where that is a short recording: an operator's jogs are those of any dialect."""
    if arm.config.connection.dialect in SMALL:
        arm.home()
    else:
        placed(arm)


def placed(arm):
    """Have the arm referenced where it stands: that takes less of the simulator than to home."""
    arm.declare_posture(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)


def faulty(dialect, tmp_path, go_wrong):
    """Record a move in which something goes wrong; return what was written at the fault."""
    arm = recorded_arm(dialect, tmp_path / "records")
    placed(arm)
    arm.move_j(shoulder_deg=30)
    go_wrong(arm.twin)
    with pytest.raises(ArmError):
        arm.move_j(shoulder_deg=40, elbow_deg=-60, speed=0.5)
    arm.close()
    return read_recording(written(tmp_path / "records")[0])


def power_fails(twin):
    device = twin.device
    device.at(device.now_s + 0.7, device.power_off)
    device.at(device.now_s + 0.9, device.power_on)


FAULTS = {
    "bytes to the arm are lost": lambda twin: twin.faults.add("drop", 0.03, side="host"),
    "bytes to the arm are garbled": lambda twin: twin.faults.add("corrupt", 0.03, side="host"),
    "the power fails": power_fails,
    "the arm falls mute": lambda twin: twin.faults.add("mute", after_s=0.5),
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("dialect", SMALL)
def test_a_fault_is_where_they_part(dialect, fault, tmp_path):
    recording = faulty(dialect, tmp_path, FAULTS[fault])
    replayed = replay(recording)
    parting = replayed.divergence
    assert parting is not None
    moved = next(e for e in recording.entries if "move_j(shoulder_deg=40" in str(e.what))
    assert moved.time_s < parting.time_s <= recording.entries[-1].time_s
    assert parting.arm != parting.twin
    assert "registers" in parting.twin_state
    view = replayed_view(recording, replayed)
    assert view["agree"] is False
    assert view["parting"]["twin_state"]["joints_deg"]


def test_registers_that_were_moved_by_others_part(tmp_path):
    arm = recorded_arm()
    arm.home()
    arm.sleep(2.0)
    arm.twin.device.jog([0, 5, 0, 0, 0, 0])
    arm.sleep(2.0)
    recording = saved(arm, tmp_path)
    arm.close()
    assert "5" in replay(recording).divergence.arm


def test_a_lost_wire_is_no_difference(tmp_path):
    recording = faulty("teachmover", tmp_path, lambda twin: twin.faults.add("unplug", after_s=0.7))
    replayed = replay(recording)
    assert replayed.divergence is None
    assert replayed.compared > 20


@pytest.mark.parametrize("dialect", DIALECTS)
def test_what_remains_of_a_long_run_is_replayed_from_where_counts_were_read(dialect, tmp_path):
    kept_s = 1.5
    arm = recorded_arm(dialect, ring=EntryRing(longest_s=kept_s))
    placed(arm)
    arm.move_j(base_deg=8)
    arm.sleep(1.0)
    arm.move_j(base_deg=5)
    recording = saved(arm, tmp_path)
    arm.close()
    replayed = replay(recording)
    assert replayed.divergence is None
    assert any("comparison starts again" in note for note in replayed.notes)
    assert replayed.compared > 3
    assert recording.entries[-1].time_s > kept_s


def test_a_position_that_was_restored_is_where_the_twin_stands(tmp_path):
    config = simulated_config("teachmover")
    twin = simulate(config)
    memory = FileRecorder(state_file(config.name))
    with Arm(connect_simulated(config, twin=twin, recorder=memory)) as arm:
        arm.home()
        arm.move_j(shoulder_deg=40)
        arm.sleep(3.0)
    later = Arm(
        connect_simulated(
            config, twin=simulate(config, twin.save()), recorder=memory, tracer=FlightRecorder()
        )
    )
    with later:
        later.confirm_restored()
        later.move_j(base_deg=15)
        recording = saved(later, tmp_path)
    replayed = replay(recording)
    assert replayed.divergence is None
    assert replayed.notes == ()
