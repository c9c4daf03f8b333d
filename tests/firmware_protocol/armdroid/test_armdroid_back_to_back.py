"""Host and device wired to each other, and a flood of damaged bytes at both ends."""

import random

from armdroid_strategies import COMMANDS, PLAIN, answer_to, events, some_answer
from chunks import chunked
from fuzzing_armdroid import MOST_HELD
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.armdroid import (
    ROOM_BYTES,
    Clear,
    Completed,
    Device,
    DriveAll,
    DriveNone,
    DriveOne,
    DropArguments,
    Host,
    Unreadable,
    Version,
)


def carry(draw, data: bytes, machine: Host | Device) -> None:
    for chunk in draw(chunked(data)):
        machine.receive_data(chunk)


@given(st.lists(COMMANDS, max_size=6), st.data())
def test_every_script_arrives_whole_at_both_ends(script, data):
    host, device = Host(), Device()
    for command in [Clear(), *script]:
        carry(data.draw, host.send(command), device)
        request = device.next_event()
        if isinstance(command, Clear | DropArguments):
            assert isinstance(request, DriveOne | DriveNone)
            assert request.steps == 0
        else:
            assert request == command
        answer = data.draw(answer_to(request))
        carry(data.draw, device.send(answer), host)
        assert events(host) == [Completed(command, answer)]
        assert (host.outstanding, device.unanswered) == (None, None)
        assert host.clean
        assert device.clean


@given(st.binary(max_size=100), PLAIN)
def test_after_noise_a_clear_makes_the_next_command_mean_what_it_says(noise, command):
    host, device = Host(), Device()
    device.receive_data(noise)
    events(device)
    for each in (Clear(), command):
        device.receive_data(host.send(each))
        request = device.next_event()
        host.receive_data(device.send(some_answer(device)))
        assert isinstance(host.next_event(), Completed)
    assert request == command


@given(st.lists(PLAIN, max_size=6))
def test_dropped_arguments_make_a_stray_letter_harmless(script):
    host, device = Host(), Device()
    for command in [Clear(), *script, DropArguments()]:
        device.receive_data(host.send(command))
        device.next_event()
        host.receive_data(device.send(some_answer(device)))
        host.next_event()
    device.receive_data(b"@READ\r")
    assert DriveAll((0,) * 6) in events(device)


def test_floods_that_nobody_fetches_stay_bounded():
    rng = random.Random(7)
    host, device = Host(), Device()
    device.receive_data(b"v")
    assert device.next_event() == Version()
    for _ in range(200):
        noise = rng.randbytes(1024)
        host.receive_data(noise)
        device.receive_data(noise)
        assert host.buffered <= MOST_HELD
        assert device.buffered <= ROOM_BYTES
    assert {type(event) for event in events(host)} == {Unreadable}
    device.send(some_answer(device))
    assert len(events(device)) <= ROOM_BYTES + 1


def test_a_host_that_only_sends_keeps_a_bounded_past():
    host = Host()
    for _ in range(20):
        host.receive_data(b"junk\r" * 100)
        host.send(Version())
        host.give_up()
    assert 0 < len(events(host)) <= 256
