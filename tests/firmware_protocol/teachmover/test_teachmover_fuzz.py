"""Thousands of damaged lines at both ends: typed events only, and never more memory."""

import random

import pytest
from fuzz_rounds import damaged
from fuzzing_teachmover import MOST_HELD

from firmware_protocol.teachmover import (
    Arm,
    Close,
    Completed,
    Delay,
    Device,
    Host,
    Ignored,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Registers,
    Status,
    Step,
    Stray,
    Unreadable,
)
from firmware_protocol.teachmover.messages import encode_command, encode_reply

ROW = ProgramRow(1, 240, (100, -200, 300, -400, 500, -600))
REGISTERS = Registers((1, -2, 3, -4, 5, -6), 7, 65)
COMMANDS = [Step(240, (1, -2, 3, -4, 5, -6), 3), Read(), Close(9), QDump(), QWrite(ROW), Delay(5)]
REPLIES = [*Status, REGISTERS, ROW]
FRAMES = 3000


@pytest.mark.parametrize("seed", range(3))
def test_a_device_survives_damaged_commands(seed):
    rng = random.Random(seed)
    device = Device()
    seen = set()

    def good(rng):
        return encode_command(rng.choice(COMMANDS), device.attention)

    for _ in range(FRAMES):
        device.receive_data(damaged(rng, good))
        assert device.buffered <= MOST_HELD
        while (event := device.next_event()) is not None:
            seen.add(type(event))
            if isinstance(event, Ignored):
                continue
            device.send(Status.FAILED if isinstance(event, Unreadable) else Status.DONE)
            if isinstance(event, Read):
                device.send(REGISTERS)
    assert seen >= {Unreadable, Ignored, Step, Read, Close, QDump, QWrite, Delay}


@pytest.mark.parametrize("seed", range(3))
def test_a_host_survives_damaged_replies(seed):
    rng = random.Random(seed)
    host = Host()
    seen = set()

    def good(rng):
        return encode_reply(rng.choice(REPLIES))

    for _ in range(FRAMES):
        if host.outstanding is None:
            host.send(rng.choice([*COMMANDS, Arm("#"), Arm("@")]))
        elif rng.random() < 0.02:
            host.give_up()
        host.receive_data(damaged(rng, good))
        assert host.buffered <= MOST_HELD
        while (event := host.next_event()) is not None:
            seen.add(type(event))
    assert seen == {Completed, Unreadable, Stray}


@pytest.mark.parametrize("machine", [Host, Device])
def test_a_flood_that_nobody_fetches_stays_bounded(machine):
    rng = random.Random(7)
    end = machine()
    for _ in range(200):
        end.receive_data(rng.randbytes(4096))
        assert end.buffered <= MOST_HELD
    fetched = 0
    while (event := end.next_event()) is not None:
        assert isinstance(event, Unreadable | Stray | Ignored)
        if machine is Device and isinstance(event, Unreadable):
            end.send(Status.FAILED)
        fetched += 1
    assert 0 < fetched <= 256


def test_a_host_that_only_sends_keeps_a_bounded_past():
    host = Host()
    for _ in range(20):
        host.receive_data(b"junk\r" * 100)
        host.send(Read())
        host.give_up()
    fetched = 0
    while (event := host.next_event()) is not None:
        assert isinstance(event, Unreadable)
        fetched += 1
    assert 0 < fetched <= 256
