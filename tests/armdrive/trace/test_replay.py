"""Files of recordings, and their replay."""

import json
import re
from dataclasses import replace

import pytest
from amounts import amount, every_row
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pages import page
from recorder_bench import recorded_arm, saved, written

from armdrive import Arm, ArmError
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config, state_file
from armdrive.errors import RecordingError
from armdrive.registry import DIALECTS, simulate
from armdrive.sim.device import state_json
from armdrive.storage.record import RecordFile
from armdrive.trace import entries
from armdrive.trace import replay as replaying
from armdrive.trace.entries import TRAFFIC, EntryKind, EntryRing, TraceEntry
from armdrive.trace.files import LATEST_S, lines_of, parse_recording, read_recording
from armdrive.trace.log import (
    Narrator,
    Topic,
    lines,
)
from armdrive.trace.recorder import FlightRecorder
from armdrive.trace.replay import config_of, replay, replayed_view

# -- Files -----------------------------------------------------------------------------------------

text_kinds = st.sampled_from([kind for kind in EntryKind if kind not in TRAFFIC])
texts = st.text('a7"\\\n\x00\x7fé\u0394\u2028\U0001f916', max_size=20)
"""Of the characters that a line of JSON could get wrong."""

times = st.lists(st.floats(-LATEST_S, LATEST_S), max_size=12).map(sorted)


@st.composite
def entry_lists(draw):
    return tuple(
        TraceEntry(time_s, draw(st.sampled_from(sorted(TRAFFIC))), draw(st.binary(max_size=20)))
        if draw(st.booleans())
        else TraceEntry(time_s, draw(text_kinds), draw(texts))
        for time_s in draw(times)
    )


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    arm = recorded_arm()
    arm.move_motors(0, 0, 0, 0, 5, 0)
    arm.estop()
    arm.sleep(0.1)
    recording = saved(arm, tmp_path_factory.mktemp("recording"))
    arm.close()
    return recording


@pytest.fixture(scope="module")
def text(recording):
    lines = lines_of(recording.header, recording.entries)
    return "".join(f"{line}\n" for line in lines).encode()


@given(entries=entry_lists())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_a_written_recording_reads_back_the_same(recording, entries):
    text = "".join(f"{line}\n" for line in lines_of(recording.header, entries))
    back = parse_recording(text.encode())
    assert back.entries == entries
    assert back.header == recording.header
    assert not back.cut_off


@given(st.data())
def test_a_cut_off_copy_is_read_up_to_its_last_whole_line(text, data):
    first = text.index(b"\n") + 1
    end = data.draw(st.integers(first, len(text)))
    recording = parse_recording(text[:end])
    assert len(recording.entries) == text[first:end].count(b"\n")
    assert recording.cut_off == (text[end - 1 : end] != b"\n")


@given(st.data())
@settings(max_examples=amount(40, 1000))
def test_a_spoilt_recording_is_read_or_refused_and_its_replay_ends(text, data):
    at = data.draw(st.integers(0, len(text) - 1))
    length = data.draw(st.integers(0, 8))
    new = data.draw(st.binary(max_size=6) | st.sampled_from([b"9", b"-1", b"e9", b"null", b"[["]))
    try:
        recording = parse_recording(text[:at] + new + text[at + length :])
        replay(recording)
    except RecordingError:
        return
    for entry in recording.entries:
        Narrator(recording.header.dialect).line(0, entry).view()


@every_row(
    "line, words",
    [
        ('{"t": 0, "kind": "dance", "text": ""}', "line 4 is no entry"),
        ('{"t": 0, "kind": ["sent"], "bytes": ""}', "line 4 is no entry"),
        ('{"t": 0, "kind": "sent", "text": ""}', "line 4 is no entry"),
        ('{"t": 0, "kind": "sent", "bytes": "\\u0394"}', "line 4 is no entry"),
        ('{"t": 0, "kind": "state", "text": 3}', "line 4 is no entry"),
        ('{"t": NaN, "kind": "state", "text": ""}', "line 4 is no entry"),
        ('{"t": true, "kind": "state", "text": ""}', "line 4 is no entry"),
        ('{"t": -1, "kind": "state", "text": ""}', "line 4 has an earlier time"),
        ("[" * 100_000, "line 4 is no entry"),
        ("7", "line 4 is no entry"),
    ],
)
def test_a_broken_line_is_named_with_its_number(text, line, words):
    lines = text.decode().splitlines()
    lines[3:3] = [line]
    with pytest.raises(RecordingError, match=words):
        parse_recording("".join(f"{each}\n" for each in lines).encode())


def test_a_file_that_is_not_there_too_large_or_of_tomorrow(tmp_path, text, monkeypatch):
    with pytest.raises(RecordingError, match="cannot be read"):
        read_recording(tmp_path / "none.jsonl")
    with pytest.raises(RecordingError, match="cannot be read"):
        read_recording(tmp_path)
    later = text.replace(b'"armdrive_recording": 1', b'"armdrive_recording": 2', 1)
    (tmp_path / "later.jsonl").write_bytes(later)
    with pytest.raises(RecordingError, match="format is 2"):
        read_recording(tmp_path / "later.jsonl")
    monkeypatch.setattr("armdrive.trace.files.MOST_FILE_BYTES", 100)
    with pytest.raises(RecordingError, match="larger"):
        read_recording(tmp_path / "later.jsonl")


def test_no_file_that_a_recording_names_is_opened(text, tmp_path):
    (tmp_path / "model.toml").write_text("secret = 1")
    word = json.dumps(f'model = "{tmp_path}/model.toml"')[1:-1].encode()
    named = text.replace(rb"model = \"teachmover\"", word, 1)
    assert named != text
    with pytest.raises(RecordingError) as error:
        config_of(parse_recording(named))
    assert "secret" not in str(error.value)


def test_a_replay_notes_what_makes_it_less_certain(recording, text):
    assert any("incomplete" in note for note in replay(parse_recording(text[:-3])).notes)
    other = replace(recording, header=replace(recording.header, calibration="another"))
    assert any("which wrote the recording, read the arm" in note for note in replay(other).notes)


# -- the page on recordings -----------------------------------------------------------------------

PAGE = page("recordings")


def test_the_page_lists_every_kind_under_its_topic():
    rows = dict(re.findall(r"^\| `(\w+)` \| ([a-z, ]+) \|$", PAGE, re.MULTILINE))
    for topic in Topic:
        kinds = {kind.value for kind in entries.EntryKind if kind.topic is topic}
        assert set(rows[topic.value].split(", ")) == kinds


# -- Replay ----------------------------------------------------------------------------------------

SMALL = ("teachmover", "armdroid", "grbl")
"""The dialects whose recordings are short: a Robko is asked for its position all the time."""


def work(arm):
    referenced(arm)
    for base_deg in (3, 6) * 4:  # enough messages also of a device that is never polled
        arm.move_j(base_deg=base_deg)
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
    recording, _ = days[dialect]
    told = [text for _, text in lines(recording)]
    assert len(told) == len(recording.entries)
    unreadable = [text for text in told if "unreadable" in text]
    assert len(unreadable) <= 1, unreadable  # the first line to a TeachMover is one on purpose


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
    arm.reference.declare(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)


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
@pytest.mark.parametrize("dialect", amount(SMALL[:1], SMALL))
def test_a_fault_is_where_they_part(dialect, fault, tmp_path):
    recording = faulty(dialect, tmp_path, FAULTS[fault])
    replayed = replay(recording)
    parting = replayed.divergence
    assert parting is not None
    moved = next(e for e in recording.entries if "move_j shoulder 40 deg" in str(e.what))
    assert moved.time_s < parting.time_s <= recording.entries[-1].time_s
    assert parting.arm != parting.twin
    assert "registers" in parting.twin_state
    view = replayed_view(recording, replayed)
    assert view["agree"] is False
    assert view["parting"]["twin_state"]["joints_deg"]


def test_registers_that_were_moved_by_others_part(tmp_path):
    with recorded_arm() as arm:
        placed(arm)
        arm.sleep(2.0)
        arm.twin.device.jog([0, 5, 0, 0, 0, 0])
        arm.sleep(2.0)
        assert "5" in replay(saved(arm, tmp_path)).divergence.arm


def test_a_lost_wire_is_no_difference(tmp_path):
    recording = faulty("teachmover", tmp_path, lambda twin: twin.faults.add("unplug", after_s=0.7))
    replayed = replay(recording)
    assert replayed.divergence is None
    assert replayed.compared > 20


@pytest.mark.parametrize("dialect", amount(["teachmover", "mks"], list(DIALECTS)))
def test_a_truncated_run_is_replayed_from_the_first_read_counts(dialect, tmp_path):
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


def test_what_follows_missing_entries_without_counts_is_no_difference(days):
    recording, _ = days["teachmover"]
    at = replaying.next_counts(recording.entries, len(recording.entries) // 2) + 1
    before, after = recording.entries[:at], recording.entries[at:]
    last_s = after[-1].time_s
    entries = (
        *before,
        TraceEntry(after[0].time_s, EntryKind.DROPPED, ""),
        *(each for each in after if each.kind is not EntryKind.REGISTERS),
        TraceEntry(last_s + 2.0 * replaying.GRACE_S, EntryKind.STATE, ""),
    )
    replayed = replay(replace(recording, entries=entries))
    assert replayed.divergence is None
    assert replayed.notes == ("entries are missing, and the rest cannot be compared",)


def test_a_position_that_was_restored_is_where_the_twin_stands(tmp_path, monkeypatch):
    placed, place = [], replaying.ReplayBench.place

    def noted(bench, registers, position):
        placed.append(tuple(position))
        place(bench, registers, position)

    monkeypatch.setattr(replaying.ReplayBench, "place", noted)
    config = simulated_config("teachmover")
    twin = simulate(config)
    memory = RecordFile(state_file(config.name))
    with Arm(connect_simulated(config, twin=twin, record_store=memory)) as arm:
        arm.home()
        arm.move_j(shoulder_deg=40)
        arm.sleep(3.0)
    later = Arm(
        connect_simulated(
            config, twin=simulate(config, twin.save()), record_store=memory, tracer=FlightRecorder()
        )
    )
    with later:
        later.reference.confirm_restored()
        later.move_j(base_deg=15)
        recording = saved(later, tmp_path)
    replayed = replay(recording)
    assert replayed.divergence is None
    assert replayed.notes == ()
    assert placed == [tuple(twin.world.motors)]
