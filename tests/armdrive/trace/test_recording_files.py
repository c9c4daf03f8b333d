"""Recordings as files: they read back as they were, and whatever is broken has a typed error."""

from __future__ import annotations

import json
import re
from dataclasses import replace

import pytest
from amounts import amount
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pages import blocks, page
from recorder_bench import recorded_arm, saved

from armdrive.errors import RecordingError
from armdrive.trace import entries, files
from armdrive.trace.entries import WIRE, EntryKind, TraceEntry
from armdrive.trace.files import LATEST_S, header_of, lines_of, parse_recording, read_recording
from armdrive.trace.log import BACK, KEPT, MOST, Narrator, Topic, heading, lines
from armdrive.trace.replay import config_of, replay

text_kinds = st.sampled_from([kind for kind in EntryKind if kind not in WIRE])
texts = st.text('a7"\\\n\x00\x7fé\u0394\u2028\U0001f916', max_size=20)
"""Of the characters that a line of JSON could get wrong."""

times = st.lists(st.floats(-LATEST_S, LATEST_S), max_size=12).map(sorted)


@st.composite
def entry_lists(draw):
    return tuple(
        TraceEntry(time_s, draw(st.sampled_from(sorted(WIRE))), draw(st.binary(max_size=20)))
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
def test_what_is_written_reads_back_the_same(recording, entries):
    text = "".join(f"{line}\n" for line in lines_of(recording.header, entries))
    back = parse_recording(text.encode())
    assert back.entries == entries
    assert back.header == recording.header
    assert not back.cut_off


def test_the_arm_in_a_recording_is_the_arm_to_the_last_bit(recording):
    config = config_of(recording)
    assert config.calibration == recording.header.calibration
    assert config.name == "sim:teachmover"


@given(st.data())
def test_a_cut_off_copy_is_read_up_to_its_last_whole_line(text, data):
    first = text.index(b"\n") + 1
    end = data.draw(st.integers(first, len(text)))
    recording = parse_recording(text[:end])
    assert len(recording.entries) == text[first:end].count(b"\n")
    assert recording.cut_off == (text[end - 1 : end] != b"\n")


@given(st.binary(max_size=300))
def test_any_bytes_are_a_recording_error(data):
    with pytest.raises(RecordingError):
        parse_recording(data)


def spoilt(text, at, length, new):
    return text[:at] + new + text[at + length :]


@given(st.data())
@settings(max_examples=amount(40, 1000))
def test_a_spoilt_recording_is_read_or_refused_and_its_replay_ends(text, data):
    at = data.draw(st.integers(0, len(text) - 1))
    length = data.draw(st.integers(0, 8))
    new = data.draw(st.binary(max_size=6) | st.sampled_from([b"9", b"-1", b"e9", b"null", b"[["]))
    try:
        recording = parse_recording(spoilt(text, at, length, new))
        replay(recording)
    except RecordingError:
        return
    for entry in recording.entries:
        Narrator(recording.header.dialect).line(0, entry).view()


json_values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | texts,
    lambda inner: st.lists(inner, max_size=2) | st.dictionaries(texts, inner),
    max_leaves=4,
)


@given(st.data())
def test_any_value_in_any_place_is_read_or_refused(text, data):
    lines = text.splitlines()
    number = data.draw(st.integers(0, len(lines) - 1))
    table = json.loads(lines[number])
    table[data.draw(st.sampled_from(sorted(table)))] = data.draw(json_values)
    lines[number] = json.dumps(table).encode()
    try:
        recording = parse_recording(b"\n".join(lines) + b"\n")
        replay(recording)
    except RecordingError:
        pass


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('{"t": 0, "kind": "dance", "text": ""}', "unknown kind 'dance'"),
        ('{"t": 0, "kind": "sent", "text": ""}', "must have t, kind and bytes"),
        ('{"t": 0, "kind": "sent", "bytes": "\\u0394"}', "beyond Latin-1"),
        ('{"t": NaN, "kind": "state", "text": ""}', "instead of a time"),
        ('{"t": true, "kind": "state", "text": ""}', "instead of a time"),
        ('{"t": -1, "kind": "state", "text": ""}', "earlier"),
        ("[" * 100_000, "not JSON"),
        ("7", "not a JSON object"),
    ],
)
def test_a_broken_line_is_named_with_its_number(text, line, words):
    lines = text.decode().splitlines()
    lines[3:3] = [line]
    with pytest.raises(RecordingError, match=words) as error:
        parse_recording("".join(f"{each}\n" for each in lines).encode())
    assert "line 4" in str(error.value) or "line 5" in str(error.value)


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


def test_an_arm_without_a_known_file_is_still_recorded(recording):
    config = replace(config_of(recording), source=None)
    header = header_of(config, link="bench", why="test", began=(0.0, 0.0))
    assert header.arm_file == ""
    bare = replace(recording, header=header)
    with pytest.raises(RecordingError, match="contains no arm file"):
        replay(bare)
    assert "1970-01-01" in heading(bare)
    assert len(list(lines(bare))) == len(bare.entries)


# -- the page on recordings -----------------------------------------------------------------------


PAGE = page("recordings")


def test_the_page_lists_every_kind_under_its_topic():
    rows = dict(re.findall(r"^\| `(\w+)` \| ([a-z, ]+) \|$", PAGE, re.MULTILINE))
    for topic in Topic:
        kinds = {kind.value for kind in entries.EntryKind if kind.topic is topic}
        assert set(rows[topic.value].split(", ")) == kinds


def test_the_page_names_the_bounds():
    assert "last five minutes" in PAGE
    assert entries.LONGEST_S == 5 * 60
    assert f"{entries.MOST_BYTES // 1_000_000} MB" in PAGE
    assert f"newest {files.MOST_FILES} are kept" in PAGE
    assert f"last {KEPT} lines" in PAGE
    assert f"last {BACK} entries" in PAGE
    assert f"at most {MOST} lines" in PAGE


def test_the_program_of_the_page_prints_the_motion(capsys):
    (program,) = [text for text in blocks(PAGE, "python") if "arm.log" in text]
    exec(compile(program, "recordings.md", "exec"), {})
    printed = capsys.readouterr().out
    assert "call: move_motors(37, 0, 0, 0, 0, 0)" in printed
    assert "step at speed" in printed
    assert "unknown: no position of this arm" not in printed
