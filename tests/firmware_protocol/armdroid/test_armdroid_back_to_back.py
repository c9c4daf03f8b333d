"""Host and device wired to each other."""

from armdroid_strategies import COMMANDS, PLAIN, answer_to, events, some_answer
from chunks import chunked
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import armdroid


def carry(draw, data: bytes, machine: armdroid.Host | armdroid.Device) -> None:
    for chunk in draw(chunked(data)):
        machine.receive_data(chunk)


@given(st.lists(COMMANDS, max_size=6), st.data())
def test_every_script_arrives_whole_at_both_ends(script, data):
    host, device = armdroid.Host(), armdroid.Device()
    for command in [armdroid.Clear(), *script]:
        carry(data.draw, host.send(command), device)
        request = device.next_event()
        if isinstance(command, armdroid.Clear | armdroid.DropArguments):
            assert isinstance(request, armdroid.DriveOne | armdroid.DriveNone)
            assert request.steps == 0
        else:
            assert request == command
        answer = data.draw(answer_to(request))
        carry(data.draw, device.send(answer), host)
        assert events(host) == [armdroid.Completed(command, answer)]
        assert (host.outstanding, device.unanswered) == (None, None)
        assert host.clean
        assert device.clean


@given(st.binary(max_size=100), PLAIN)
def test_after_noise_a_clear_makes_the_next_command_mean_what_it_says(noise, command):
    host, device = armdroid.Host(), armdroid.Device()
    device.receive_data(noise)
    events(device)
    for each in (armdroid.Clear(), command):
        device.receive_data(host.send(each))
        request = device.next_event()
        host.receive_data(device.send(some_answer(device)))
        assert isinstance(host.next_event(), armdroid.Completed)
    assert request == command


@given(st.lists(PLAIN, max_size=6))
def test_dropped_arguments_make_a_stray_letter_harmless(script):
    host, device = armdroid.Host(), armdroid.Device()
    for command in [armdroid.Clear(), *script, armdroid.DropArguments()]:
        device.receive_data(host.send(command))
        device.next_event()
        host.receive_data(device.send(some_answer(device)))
        host.next_event()
    device.receive_data(b"@READ\r")
    assert armdroid.DriveAll((0,) * 6) in events(device)
