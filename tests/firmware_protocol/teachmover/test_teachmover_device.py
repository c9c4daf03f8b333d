"""The arm's machine: what each line of a host means to it, and what it may answer."""

import pytest

from firmware_protocol import teachmover
from firmware_protocol.errors import LocalProtocolError

ROW = teachmover.ProgramRow(1, 240, (100, -200, 300, -400, 500, -600))
REGISTERS = teachmover.Registers((1, -2, 3, -4, 5, -6), 7, 65)


def given(*lines: bytes, **settings) -> teachmover.Device:
    device = teachmover.Device(**settings)
    device.receive_data(b"".join(line + b"\r" for line in lines))
    return device


def test_commands_come_one_at_a_time_and_the_next_waits_for_the_answer():
    device = given(b"@CLOSE", b"@RUN")
    assert device.next_event() == teachmover.Close()
    assert device.unanswered == teachmover.Close()
    assert device.next_event() is None
    assert device.send(teachmover.Status.DONE) == b"1\r"
    assert device.unanswered is None
    assert device.next_event() == teachmover.Run()


@pytest.mark.parametrize("status", teachmover.Status)
def test_a_status_answers_a_command(status):
    device = given(b"@STEP 240,1,2,3,4,5,6")
    assert device.next_event() == teachmover.Step(240, (1, 2, 3, 4, 5, 6))
    assert device.send(status) == b"%d\r" % status
    with pytest.raises(LocalProtocolError, match="nothing is owed"):
        device.send(status)


def test_a_read_is_answered_with_a_status_and_then_the_registers():
    device = given(b"@READ", b"@READ")
    assert device.next_event() == teachmover.Read()
    with pytest.raises(LocalProtocolError, match="a Status is owed, so a Registers"):
        device.send(REGISTERS)
    assert device.send(teachmover.Status.DONE) == b"1\r"
    assert device.next_event() is None
    with pytest.raises(LocalProtocolError, match="a Registers is owed, so a Status"):
        device.send(teachmover.Status.DONE)
    assert device.send(REGISTERS) == b"1,-2,3,-4,5,-6,1857\r"
    assert device.next_event() == teachmover.Read()


@pytest.mark.parametrize("status", [teachmover.Status.FAILED, teachmover.Status.STOPPED])
@pytest.mark.parametrize("line", [b"@READ", b"@QDUMP"])
def test_nothing_follows_a_status_other_than_done(line, status):
    device = given(line)
    device.next_event()
    device.send(status)
    for reply in (REGISTERS, ROW):
        with pytest.raises(LocalProtocolError):
            device.send(reply)


def test_a_dump_is_answered_with_a_status_and_rows_until_the_next_command():
    device = given(b"@QDUMP", b"@RUN")
    assert device.next_event() == teachmover.QDump()
    assert device.send(teachmover.Status.DONE) == b"1\r"
    for _ in range(3):
        assert device.send(ROW) == b"1,3841,14436,28716,43252,65280,65025,64769\r"
    assert device.next_event() == teachmover.Run()
    with pytest.raises(LocalProtocolError):
        device.send(ROW)


def test_the_attention_character_changes_with_the_answer_and_for_what_waits_behind():
    device = given(b"@ARM #", b"@READ", b"#RUN")
    assert device.next_event() == teachmover.Arm("#")
    assert device.attention == "@"
    device.send(teachmover.Status.DONE)
    assert device.attention == "#"
    assert device.next_event() == teachmover.Ignored(b"@READ")
    assert device.next_event() == teachmover.Run()


@pytest.mark.parametrize("status", [teachmover.Status.FAILED, teachmover.Status.STOPPED])
def test_the_attention_character_stays_when_the_answer_is_not_done(status):
    device = given(b"@ARM #", b"@RUN")
    device.next_event()
    device.send(status)
    assert device.attention == "@"
    assert device.next_event() == teachmover.Run()


def test_a_malformed_line_says_why_and_is_answered():
    device = given(b"@STEP 240,1", b"@RUN")
    event = device.next_event()
    assert event == teachmover.Unreadable(
        b"@STEP 240,1", "numbers after the name: 2 where 7 or 8 belong"
    )
    assert device.unanswered == event
    assert device.send(teachmover.Status.FAILED) == b"0\r"
    assert device.next_event() == teachmover.Run()


def test_a_line_without_the_attention_character_gets_no_answer():
    device = given(b"READ", b"x@READ", b"#READ", b"@RUN")
    assert [device.next_event() for _ in range(4)] == [
        *(teachmover.Ignored(b"READ"), teachmover.Ignored(b"x@READ"), teachmover.Ignored(b"#READ")),
        teachmover.Run(),
    ]


def test_padding_before_the_attention_character_means_nothing():
    device = given(b"\0\0\n @RUN", b"\n", b"\0", b"")
    assert device.next_event() == teachmover.Run()
    device.send(teachmover.Status.DONE)
    assert device.next_event() is None


@pytest.mark.parametrize(
    ("start", "kind"), [(b"@STEP ", teachmover.Unreadable), (b"noise", teachmover.Ignored)]
)
def test_an_endless_line_is_told_once_and_takes_no_memory(start, kind):
    device = teachmover.Device()
    device.receive_data(start)
    for _ in range(500):
        device.receive_data(b"1," * 50)
        assert device.buffered <= 256 + 64
    event = device.next_event()
    assert isinstance(event, kind)
    assert event.data.startswith(start)
    device.forget()
    device.receive_data(b"\r@RUN\r")
    assert device.next_event() == teachmover.Run()


def test_the_beginning_of_an_over_long_line_is_no_command():
    device = given(b"@RUN" + b" " * 300)
    assert isinstance(device.next_event(), teachmover.Unreadable)


def test_after_a_loss_of_power_nothing_is_owed():
    device = given(b"@READ", b"@RUN")
    device.next_event()
    device.send(teachmover.Status.DONE)
    assert device.forget() == teachmover.Read()
    assert device.forget() is None
    device.discard()
    assert device.buffered == 0
    assert device.next_event() is None
