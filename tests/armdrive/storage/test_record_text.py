"""The text of a record: it comes back as it was, and whatever else is there is a typed refusal."""

import contextlib
import json
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from armdrive.errors import StateFileError
from armdrive.status import Trust
from armdrive.storage import files as durable
from armdrive.storage import record as record_text
from armdrive.storage.files import replace_file
from armdrive.storage.record import (
    LONGEST,
    MOST_MOTORS,
    STEPS_MOST,
    FileRecorder,
    Record,
    from_text,
    to_text,
)

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


def test_a_record_that_was_cut_anywhere_is_refused():
    text = to_text(RECORD).rstrip()
    for length in range(len(text)):
        with pytest.raises(StateFileError):
            from_text(text[:length])


def test_a_record_with_any_bit_turned_is_refused_or_says_the_same():
    text = to_text(RECORD)
    for index in range(len(text)):
        for bit in range(8):
            turned = text[:index] + bytes([text[index] ^ 1 << bit]) + text[index + 1 :]
            with contextlib.suppress(StateFileError):
                assert from_text(turned) == RECORD  # a blank that became another blank


def test_a_record_whose_end_the_disk_filled_with_zeros_is_refused():
    text = to_text(RECORD)
    for length in (0, 1, len(text) // 2, len(text) - 2):
        with pytest.raises(StateFileError):
            from_text(text[:length] + bytes(len(text) - length))


@given(st.binary(max_size=300))
def test_any_bytes_are_a_typed_refusal(data):
    with pytest.raises(StateFileError):
        from_text(data)


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


@pytest.mark.parametrize(
    ("key", "value", "words"),
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


@pytest.mark.parametrize(
    ("text", "words"),
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
        (b" " * LONGEST + b"{}", "no record is longer"),
        (b'{"format": 2}', "'check' is missing"),
        (b'{"format": true}', "its format"),
        (b'{"format": 1}', "an older armdrive"),
        (b'{"format": 3, "anything": 1}', "a newer armdrive"),
    ],
)
def test_the_refusal_says_what_is_wrong(text, words):
    with pytest.raises(StateFileError, match=words):
        from_text(text)


def test_no_record_comes_near_the_longest():
    steps, most = (-STEPS_MOST,) * MOST_MOTORS, (-123456.7890123456,) * (MOST_MOTORS)
    long = Record("a" * 200, "b" * 16, steps, steps, most, "referenced", "r" * 500)
    assert len(to_text(long)) < LONGEST / 2


def names(folder):
    return sorted(path.name for path in folder.iterdir())


class TestTheFile:
    @pytest.fixture
    def recorder(self, tmp_path):
        return FileRecorder(tmp_path / "state" / "lab.json")

    def test_nothing_is_there_until_something_is_kept(self, recorder):
        assert recorder.load() is None
        recorder.save(RECORD)
        assert recorder.load() == RECORD
        recorder.remove()
        assert recorder.load() is None

    def test_nothing_else_is_left_in_the_folder(self, recorder):
        recorder.save(RECORD)
        for left in ("lab.json.new", "lab.json.0123456789abcdef.new"):
            recorder.path.with_name(left).write_text("left by a program that was killed in a save")
        others = ["lab.json.draft.new", "lab2.json.0123456789abcdef.new"]
        for other in others:
            recorder.path.with_name(other).write_text("another file's")
        FileRecorder(recorder.path).save(RECORD)
        assert names(recorder.path.parent) == sorted(["lab.json", *others])

    def test_a_file_that_was_refused_is_kept_aside_once(self, recorder):
        recorder.save(RECORD)
        for text in ("first", "second"):
            recorder.path.write_text(text)
            with pytest.raises(StateFileError):
                recorder.load()
            recorder.refuse()
            recorder.save(RECORD)
            recorder.save(RECORD)
            assert recorder.aside.read_text() == text
        assert names(recorder.path.parent) == ["lab.json", "lab.json.bad"]

    def test_a_file_that_is_not_plain_is_refused_without_waiting(self, recorder):
        recorder.path.mkdir(parents=True)
        with pytest.raises(StateFileError, match="cannot be read"):
            recorder.load()
        recorder.path.rmdir()
        if hasattr(os, "mkfifo"):
            os.mkfifo(recorder.path)
            with pytest.raises(StateFileError, match="not a regular file"):
                recorder.load()

    def test_a_huge_file_is_refused_unread(self, recorder):
        recorder.path.parent.mkdir()
        with recorder.path.open("wb") as file:
            file.truncate(2**32)
        with pytest.raises(StateFileError, match="no record is longer"):
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

    def test_any_other_file_is_replaced_the_same_way(self, tmp_path):
        path = tmp_path / "arms" / "lab.toml"
        for text in ("one", "two"):
            replace_file(path, text)
            assert path.read_text() == f"{text}\n"
        assert names(path.parent) == ["lab.toml"]
