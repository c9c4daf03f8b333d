"""What one program leaves to the next: records right, marked, corrupt, or of another arm."""

import contextlib
import json
from dataclasses import replace

import pytest
from amounts import every_row
from faults import OVER_THE_TABLE, FaultyLink, sim_config
from hypothesis import given
from hypothesis import strategies as st

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import state_file
from armdrive.errors import ArmError, NotReferenced, StateFileError
from armdrive.registry import simulate
from armdrive.status import Evidence, State, Trust
from armdrive.storage import files as durable
from armdrive.storage import record as record_text
from armdrive.storage.files import StateFiles, file_name
from armdrive.storage.record import (
    LONGEST_RECORD,
    STEPS_MOST,
    Record,
    RecordFile,
    RecordWriter,
    WriteOutcome,
    from_text,
    to_text,
)


@pytest.fixture
def bench(tmp_path):
    """One physical arm and its state file, to which programs connect one after the other."""
    config = sim_config()
    twin = simulate(config)
    world = twin.world
    world.drive_to(world.body.transmission.to_motors(OVER_THE_TABLE, 20.0))

    class Bench:
        path = tmp_path / "arm.json"
        recorder = RecordFile(path)

        def connect(self, **options):
            inner = simulate(options.get("config", config)).link
            inner._line.device = twin.device
            self.link = FaultyLink(inner)
            options.setdefault("config", config)
            used = replace(twin, link=self.link)
            return Arm(connect_simulated(twin=used, record_store=self.recorder, **options))

        def edit(self, **changes):
            """Write other entries with a checksum that fits them, as another program would."""
            entries = json.loads(self.path.read_text()) | changes
            del entries["check"]
            entries["check"] = record_text.checksum(entries)
            self.path.write_text(json.dumps(entries))

    made = Bench()
    made.twin, made.config = twin, config
    return made


def referenced(bench):
    arm = bench.connect()
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    arm.move_j(base_deg=12.345)
    return arm


def test_the_next_program_takes_up_where_the_last_one_ended(bench):
    arm = referenced(bench)
    last = arm.parts.core.position.coordinates
    arm.close()
    after = bench.connect()
    assert after.status.trust is Trust.RESTORED
    assert after.parts.core.position.coordinates == last
    assert after.status.acknowledged == bench.twin.world.motors
    with pytest.raises(NotReferenced, match="confirm"):
        after.move_j(base_deg=0)
    after.reference.confirm_restored()
    after.move_j(base_deg=0)
    assert bench.twin.world.joints.deg["base"] == pytest.approx(0.0, abs=0.03)


def test_a_restored_position_allows_motion_if_the_caller_said_so(bench):
    referenced(bench).close()
    arm = bench.connect(allow_restored=True)
    arm.move_j(base_deg=0)
    arm.jog_l(x_mm=-5)
    assert arm.status.trust is Trust.RESTORED
    assert arm.status.acknowledged == bench.twin.world.motors


@pytest.mark.parametrize("after_s", [0.01, 0.5, 1.5])
def test_a_program_that_dies_in_mid_motion_leaves_a_mark(bench, after_s):
    arm = referenced(bench)
    arm.move_j(base_deg=80, wait=False)
    arm.sleep(after_s)
    assert bench.recorder.load().in_motion
    bench.twin.device.transmit(arm.status.time_s + 5.0)
    after = bench.connect()
    assert after.status.trust is Trust.SUSPECT
    assert after.status.trust_reason == Evidence.ENDED_IN_MOTION.value  # and not that it was moved


def test_counts_that_agree_by_chance_do_not_hide_an_end_in_mid_motion(bench):
    """The house lost its power: counts that were zero before are zero again."""
    arm = bench.connect()
    arm.reference.declare(OVER_THE_TABLE, opening_mm=20.0)
    assert not arm.parts.core.position.counts.largest
    arm.move_j(base_deg=80, wait=False)
    arm.sleep(0.5)
    power_cut(bench.twin.device)
    after = bench.connect()
    assert after.status.trust is Trust.SUSPECT
    assert after.status.trust_reason == Evidence.ENDED_IN_MOTION.value


def test_an_arm_that_was_moved_before_it_was_confirmed_is_not_confirmed(bench):
    referenced(bench).close()
    arm = bench.connect()
    bench.twin.device.jog((0, 25, 0, 0, 0, 0))
    with pytest.raises(NotReferenced, match="no restored position"):
        arm.reference.confirm_restored()
    assert arm.status.trust is Trust.SUSPECT


def test_a_wire_that_is_lost_soon_after_a_motion_leaves_the_mark(bench):
    """The arm was not at rest for two seconds, and this program cannot look any more."""
    arm = referenced(bench)
    bench.link.cut()
    arm.sleep(2.5)
    assert arm.status.state is State.DISCONNECTED
    arm.close()
    assert bench.recorder.load().in_motion
    assert bench.connect().status.trust is Trust.SUSPECT


def test_a_program_that_has_ended_changes_nothing_on_the_disk_any_more(tmp_path):
    """Its last thread may still be at work on a slow disk while the next program moves the arm."""
    recorder = RecordFile(tmp_path / "arm.json")
    good = Record("lab", "0123", (0, 7), (-3, 5), (0.1, 20.0), "restored", "by the next program")
    recorder.save(good)
    writer = RecordWriter(recorder)
    writer.finish(0.0)
    writer.put(replace(good, trust="suspect"))
    assert writer.outcome == WriteOutcome()
    assert recorder.load() == good


class Full(StateFiles):
    def write(self, handle, data):
        raise OSError(28, "No space left on device")


def test_a_mark_that_cannot_be_written_leaves_no_position_of_an_earlier_reference(tmp_path):
    """The record of the new reference was dropped on a slow disk, in favour of the mark."""
    path = tmp_path / "arm.json"
    good = Record("lab", "0123", (0, 7), (-3, 5), (0.1, 20.0), "restored", "as it was left")
    RecordFile(path).save(good)
    writer = RecordWriter(RecordFile(path, Full()))
    writer.found(good)
    writer.put(replace(good, offset=(1, 7), trust="referenced", in_motion=True))
    assert not path.exists()


@pytest.mark.parametrize("trust", ["suspect", "referenced"])
def test_a_record_that_cannot_be_written_leaves_no_position_that_is_doubted_now(tmp_path, trust):
    path = tmp_path / "arm.json"
    good = Record("lab", "0123", (0, 7), (-3, 5), (0.1, 20.0), "restored", "as it was left")
    RecordFile(path).save(good)
    writer = RecordWriter(RecordFile(path, Full()))
    writer.found(good)
    writer.put(replace(good, trust=trust, in_motion=True))  # the mark of a motion that begins
    assert "No space" in writer.outcome.error
    assert path.exists() is (trust == "referenced")
    writer.put(replace(good, trust=trust))  # the arm has stood for two seconds
    assert path.exists() is (trust == "referenced")
    writer.put(replace(good, trust="referenced", offset=(1, 7)))
    assert not path.exists()


def jogged(device):
    device.jog((0, 25, 0, 0, 0, 0))


def power_cut(device):
    device.power_off()
    device.power_on()


@pytest.mark.parametrize("meanwhile", [jogged, power_cut])
def test_an_arm_that_was_touched_between_programs_is_suspect(bench, meanwhile):
    """The registers follow a jog; after a power cut they show nothing, and the posture is kept."""
    arm = referenced(bench)
    before = arm.status.acknowledged
    arm.close()
    meanwhile(bench.twin.device)
    arm = bench.connect()
    assert arm.status.trust is Trust.SUSPECT
    there = bench.twin.world.motors if meanwhile is jogged else before
    assert arm.status.acknowledged == there


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"calibration": "0123456789abcdef"}, "another calibration"),
        ({"arm": "the other one"}, "it belongs to the arm the other one"),
        ({"offset": [0], "registers": [0]}, "different number of motors"),
        ({"trust": "certain"}, "damaged"),
    ],
)
def test_a_record_that_does_not_fit_is_refused_with_the_reason(bench, changes, words):
    referenced(bench).close()
    bench.edit(**changes)
    arm = bench.connect(allow_restored=True)
    assert arm.status.trust is Trust.UNKNOWN
    assert words in arm.status.trust_reason
    with pytest.raises(NotReferenced):
        arm.move_j(base_deg=0)


def test_coordinates_that_are_not_those_of_the_steps_are_not_believed(bench):
    referenced(bench).close()
    bench.edit(coordinates=[1.0, 1.0, -1.0, 0.0, 0.0, 5.0])
    arm = bench.connect(allow_restored=True)
    before = bench.twin.world.motors
    arm.jog_j(base_deg=1)
    moved = bench.twin.world.motors - before
    assert abs(moved[0]) <= 20
    assert not any(moved[1:])


def test_a_connection_that_fails_or_does_nothing_leaves_the_record_alone(bench):
    referenced(bench).close()
    kept = bench.path.read_text()
    other = replace(bench.config, name="another")
    bench.connect(config=other).close()
    assert bench.path.read_text() == kept
    bench.link.cut()
    broken = simulate(bench.config)
    link = FaultyLink(broken.link)
    link.cut()
    with pytest.raises(ArmError):
        connect_simulated(
            bench.config, twin=replace(broken, link=link), record_store=bench.recorder
        )
    assert bench.path.read_text() == kept


def test_a_cable_pulled_in_mid_motion_leaves_a_suspect_record(bench):
    arm = referenced(bench)
    arm.sleep(3.0)
    bench.link.on_write = lambda data: bench.link.cut() if data.startswith(b"@STEP") else None
    with pytest.raises(ArmError):
        arm.move_j(base_deg=50)
    arm.close()
    record = bench.recorder.load()
    assert record.trust == "suspect"
    assert record.in_motion


SIMILAR = ("lab3", "lab 3", "lab_3", "lab/3", "lab3 ", "Lab:3", "lab-3", ".lab3")
ALIKE = (
    *SIMILAR,
    *("Lab3", "LAB3", "lab3.world", "lab3_world", "l\u00e4b3", "l\u00f6b3"),
    *("/dev/lab3", "_dev_lab3", "..."),
    *("l" * 100, "l" * 101, "l" * 102, "L" * 300),
)


def test_arms_of_similar_names_have_files_of_their_own_on_any_disk():
    """Some disks take capitals for small letters."""
    files = {file_name(name).lower() for name in ALIKE}
    assert len(files) == len({state_file(name) for name in ALIKE}) == len(ALIKE)
    assert all("." not in name for name in files)
    assert all(len(name) < 120 for name in files)
    assert file_name("bench") == "bench"


def test_a_call_that_changes_trust_returns_when_the_disk_has_it(bench):
    """A declared posture, a confirmed one, and dropped current are on the disk at the return."""
    arm = referenced(bench)
    assert bench.recorder.load().trust == "referenced"
    arm.close()
    arm = bench.connect()
    arm.reference.confirm_restored()
    assert bench.recorder.load().trust == "referenced"
    arm.disable()
    assert bench.recorder.load().trust == "suspect"


# The text of a record: it comes back as it was, and whatever else is there is a typed refusal.


STEPS = st.integers(-STEPS_MOST, STEPS_MOST)
NUMBERS = st.floats(-1e6, 1e6)
WORDS = st.text(st.characters(codec="utf-8"), max_size=40)
RECORD = Record("lab", "0123", (0, 7), (-3, 5), (0.1, 20.0), "referenced", "homed", in_motion=True)


@st.composite
def records(draw):
    motors = draw(st.integers(1, 8))
    steps = st.lists(STEPS, min_size=motors, max_size=motors).map(tuple)
    return Record(
        draw(WORDS),
        draw(WORDS),
        draw(steps),
        draw(steps),
        tuple(draw(st.lists(NUMBERS, min_size=1, max_size=9))),
        draw(st.sampled_from(Trust)).value,
        draw(WORDS),
        draw(st.booleans()),
    )


@given(records())
def test_a_record_comes_back_as_it_was(record):
    assert from_text(to_text(record)) == record


def test_a_record_that_was_cut_anywhere_is_refused_also_if_the_disk_filled_it_up_with_zeros():
    text = to_text(RECORD).rstrip()
    for length in range(len(text)):
        for end in (b"", bytes(len(text) - length)):
            with pytest.raises(StateFileError):
                from_text(text[:length] + end)


def test_a_record_with_any_bit_turned_is_refused_or_says_the_same():
    text = to_text(RECORD)
    for index in range(len(text)):
        for bit in range(8):
            turned = text[:index] + bytes([text[index] ^ 1 << bit]) + text[index + 1 :]
            with contextlib.suppress(StateFileError):
                assert from_text(turned) == RECORD  # a blank that became another blank


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner),
    max_leaves=8,
)


@given(st.sampled_from([*json.loads(to_text(RECORD))]), JSON)
def test_any_value_in_any_place_is_a_typed_refusal_or_a_record(key, value):
    """Even under a checksum that fits, as only a program could make it."""
    try:
        record = from_text(with_value(key, value))
    except StateFileError:
        return
    assert from_text(to_text(record)) == record


def with_value(key, value):
    """Return the text of a record with another value, under a checksum that fits."""
    entries = json.loads(to_text(RECORD)) | {key: value}
    if key != "check":
        del entries["check"]
        entries["check"] = record_text.checksum(entries)
    return json.dumps(entries).encode()


@every_row(
    "key, value, words",
    [
        ("offset", [0, STEPS_MOST + 1], r"offset\[1\] must be from"),
        ("registers", [True, 5], r"registers\[0\] must be a whole number"),
        ("registers", [1], "different number of registers and offsets"),
        ("coordinates", [1e7, 0.0], r"coordinates\[0\] must be from"),
        ("trust", "certain", "trust is one of"),
        ("in_motion", 1, "in_motion must be true or false"),
        ("reason", 3, "reason must be text"),
        ("unsure", [0], "'unsure' names motors"),
        ("extra", 1, "unknown key 'extra'"),
    ],
)
def test_a_value_that_no_record_has_is_refused(key, value, words):
    with pytest.raises(StateFileError, match=words):
        from_text(with_value(key, value))


@every_row(
    "text, words",
    [
        (b"", "empty"),
        (b"\n \n", "empty"),
        (bytes(600), "empty"),
        (b"{", "damaged"),
        (b"null", "not a JSON object"),
        (b"[]", "not a JSON object"),
        (b"\x80abc", "damaged"),
        (b"[" * 9000, "damaged"),
        (b"9" * 9000, "damaged"),
        (b" " * LONGEST_RECORD + b"{}", "longer than"),
        (b'{"format": 2}', "'check' is missing"),
        (b'{"format": true}', "its format"),
        (b'{"format": 1}', "an older armdrive"),
        (b'{"format": 3, "anything": 1}', "a newer armdrive"),
    ],
)
def test_the_refusal_says_what_is_wrong(text, words):
    with pytest.raises(StateFileError, match=words):
        from_text(text)


class TestTheFile:
    @pytest.fixture
    def recorder(self, tmp_path):
        return RecordFile(tmp_path / "state" / "lab.json")

    def test_a_huge_file_is_refused_unread(self, recorder):
        recorder.path.parent.mkdir()
        with recorder.path.open("wb") as file:
            file.truncate(2**32)
        with pytest.raises(StateFileError, match="longer than"):
            recorder.load()

    def test_a_file_system_that_cannot_bring_a_folder_to_the_disk_is_put_up_with(
        self, recorder, monkeypatch
    ):
        synced = []

        def sync(handle):
            synced.append(handle)
            if len(synced) % 2 == 0:
                raise OSError(22, "Invalid argument")

        monkeypatch.setattr(durable.os, "fsync", sync)
        recorder.save(RECORD)
        assert len(synced) == 2
        assert recorder.load() == RECORD
