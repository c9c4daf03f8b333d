"""A sample of the long fuzz run over every codec, and proof that the run finds what is wrong."""

import random
import sys
from pathlib import Path

import pytest
from amounts import amount, every_row
from chunks import events
from fuzz_rounds import (
    CODECS,
    Violation,
    damaged,
    grown_bytes,
    registered,
    run,
)
from fuzzing import FuzzCase
from hypothesis import strategies as st

import firmware_protocol

sys.path.insert(0, str(Path(__file__).parents[2] / "benchmarks"))
import fuzz_codecs

CASES = registered()


class Echo:
    """A machine of one-byte frames, with the mistakes that it is told to make."""

    def __init__(self, mistake: str = "") -> None:
        self.mistake = mistake
        self.kept: list[bytes] = []
        self.waiting: list[int] = []
        self.calls = 0

    def receive_data(self, data: bytes) -> None:
        self.calls += 1
        if self.mistake == "raises" and self.calls > 50:
            raise IndexError("out of range")
        if self.mistake == "grows":
            self.kept.append(bytes(20_000))
        if self.mistake != "deaf" or self.calls < 50:
            self.waiting = [*self.waiting, *data][-8:]

    def next_event(self) -> int | None:
        return self.waiting.pop() if self.waiting else None


def heard(machine: Echo) -> bool:
    return 0xA5 in events(machine)


def case_of(mistake: str) -> FuzzCase:
    return FuzzCase("echo", lambda: Echo(mistake), st.just(b"\xa5"), heard)


def test_every_codec_is_registered():
    rooms = Path(firmware_protocol.__file__).parent
    assert set(CODECS) >= {path.parent.name for path in rooms.glob("*/host.py")}


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_codec_survives_damaged_frames(case):
    frames = amount(100, 5000)
    tally = run(case, seed=7, frames=frames)
    assert tally.frames == frames
    assert tally.resyncs == frames // 10


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_codec_takes_no_more_memory_with_time(case):
    grown_bytes(case, seed=7, frames=amount(50, 1000))


def fetched(case: FuzzCase, machine) -> list:
    """Return the events that a case fetches from its machine, which it answers meanwhile."""
    found, fetch = [], machine.next_event

    def next_event():
        event = fetch()
        found.extend(() if event is None else (event,))
        return event

    machine.next_event = next_event
    case.sign_of_good(machine)
    return found


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_the_chunks_make_no_difference(case):
    rng = random.Random(7)
    for _ in range(amount(15, 3000)):
        stream = b"".join(damaged(rng, case.good) for _ in range(4))
        whole, watched, cut = case.make(), case.make(), case.make()
        whole.receive_data(stream)
        found, at = [], 0
        while at < len(stream):
            size = rng.randint(1, 12)
            for machine in (watched, cut):
                machine.receive_data(stream[at : at + size])
            found += events(watched)
            at += size
        assert found == events(whole)
        assert fetched(case, cut)[: len(found)] == found


@every_row("case", CASES, ids=lambda case: case.name)
def test_a_case_registers_frames_that_its_machine_hears(case):
    rng = random.Random(7)
    for _ in range(50):
        machine = case.make()
        case.sign_of_good(machine)
        machine.receive_data(case.good(rng))
        assert case.sign_of_good(machine)


@pytest.mark.parametrize(
    ("mistake", "what"),
    [
        ("raises", "raised IndexError: out of range"),
        ("deaf", "good frames were not heard"),
    ],
)
def test_a_faulty_machine_is_found(mistake, what):
    with pytest.raises(Violation, match=what) as first:
        run(case_of(mistake), 1, 500)
    with pytest.raises(Violation) as again:
        run(case_of(mistake), 1, first.value.frames)
    assert str(again.value) == str(first.value)


def test_a_growing_machine_is_found():
    with pytest.raises(Violation, match="more in use"):
        grown_bytes(case_of("grows"), 1, 20)


def test_the_command_prints_a_row_for_each_end_and_how_to_repeat_a_failure(capsys, monkeypatch):
    assert fuzz_codecs.main(["--frames", "120", "--codec", "armdroid"]) == 0
    printed = capsys.readouterr().out
    assert "armdroid host " in printed
    assert "armdroid device " in printed
    monkeypatch.setattr(fuzz_codecs, "registered", lambda codecs: [case_of("deaf")])
    assert fuzz_codecs.main(["--frames", "120", "--seed", "5"]) == 1
    assert "--codec echo --seed 5 --frames 50" in capsys.readouterr().out
