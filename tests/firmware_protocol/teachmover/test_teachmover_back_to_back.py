"""Host and device wired to each other: what one sends the other reads, whatever the wire does."""

from chunks import carried, events
from hypothesis import given
from hypothesis import strategies as st
from teachmover_strategies import COMMANDS, REGISTERS, ROWS, STATUSES

from firmware_protocol import teachmover

NOISE_BYTES = st.binary(min_size=1, max_size=400).filter(lambda b: b"\r" not in b)
DUMPS = st.lists(ROWS, max_size=4)


@st.composite
def exchanges(draw: st.DrawFn) -> tuple[teachmover.Command, list[teachmover.Reply]]:
    """Draw a command and the replies that make up its whole answer."""
    command = draw(COMMANDS)
    status = draw(STATUSES)
    if status is teachmover.Status.DONE and isinstance(command, teachmover.Read):
        return command, [status, draw(REGISTERS)]
    if status is teachmover.Status.DONE and isinstance(command, teachmover.QDump):
        return command, [status, *draw(DUMPS)]
    return command, [status]


def expected(command: teachmover.Command, replies: list[teachmover.Reply]) -> teachmover.Completed:
    status, *rest = replies
    if isinstance(command, teachmover.Read) and rest:
        return teachmover.Completed(command, status, registers=rest[0])
    return teachmover.Completed(command, status, rows=tuple(rest))


@given(st.lists(exchanges(), max_size=5), st.data())
def test_every_script_arrives_whole_at_both_ends(script, data):
    host, device = teachmover.Host(), teachmover.Device()
    for command, replies in script:
        assert carried(data.draw, host.send(command), device) == [command]
        answer = b"".join(device.send(reply) for reply in replies)
        found = carried(data.draw, answer, host)
        if isinstance(command, teachmover.QDump) and replies[0] is teachmover.Status.DONE:
            assert found == []
            host.end_dump()
            found = events(host)
        assert found == [expected(command, replies)]
        assert host.attention == device.attention
        assert (host.outstanding, device.unanswered) == (None, None)


@given(st.lists(st.sampled_from("@#!/$~"), min_size=1, max_size=6), st.data())
def test_the_attention_character_can_change_again_and_again(signs, data):
    host, device = teachmover.Host(), teachmover.Device()
    for sign in signs:
        assert carried(data.draw, host.send(teachmover.Arm(sign)), device) == [teachmover.Arm(sign)]
        carried(data.draw, device.send(teachmover.Status.DONE), host)
        line = host.send(teachmover.Read())
        assert line == f"{sign}READ\r".encode()
        assert carried(data.draw, line, device) == [teachmover.Read()]
        carried(data.draw, device.send(teachmover.Status.FAILED), host)


@given(NOISE_BYTES, exchanges(), st.data())
def test_after_noise_both_ends_agree_again_at_the_next_carriage_return(noise, exchange, data):
    host, device = teachmover.Host(), teachmover.Device()
    for event in carried(data.draw, noise + b"\r", device):
        if isinstance(event, teachmover.Unreadable):
            device.send(teachmover.Status.FAILED)
        elif device.unanswered is not None or event == teachmover.QDump():
            device.forget()  # the noise happened to be a command
    carried(data.draw, noise + b"\r", host)
    command, replies = exchange
    assert carried(data.draw, host.send(command), device) == [command]
    found = carried(data.draw, b"".join(device.send(reply) for reply in replies), host)
    if isinstance(command, teachmover.QDump) and replies[0] is teachmover.Status.DONE:
        host.end_dump()
        found = events(host)
    assert found == [expected(command, replies)]


@given(exchanges(), st.binary(min_size=1, max_size=40), st.data())
def test_garbage_lines_before_an_answer_do_not_change_it(exchange, garbage, data):
    command, replies = exchange
    host, device = teachmover.Host(), teachmover.Device()
    device.receive_data(host.send(command))
    assert device.next_event() == command
    answer = b"".join(device.send(reply) for reply in replies)
    told = b"?" + garbage.replace(b"\r", b"?") + b"\r"
    found = carried(data.draw, told + answer, host)
    if isinstance(command, teachmover.QDump) and replies[0] is teachmover.Status.DONE:
        host.end_dump()
        found += events(host)
    assert [type(event) for event in found] == [teachmover.Unreadable, teachmover.Completed]
    assert found[1] == expected(command, replies)


def test_the_longest_line_of_the_dialect_passes():
    longest = teachmover.QWrite(teachmover.ProgramRow(65535, 0, (-1,) * 6, 255))
    host, device = teachmover.Host(), teachmover.Device()
    line = host.send(longest)
    assert line == b"@QWRITE" + b" 65535" + b",65535" * 7 + b"\r"
    device.receive_data(line)
    assert device.next_event() == longest
