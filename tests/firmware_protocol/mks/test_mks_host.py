"""The host's end of a bus of MKS drives: whose answer it is, and what does not belong."""

import pytest
from mks_bus import BY, HERE, NODES, ONE, STARTED, asked, said
from mks_strategies import events

from firmware_protocol.errors import BadField, LocalProtocolError
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import (
    BROADCAST,
    EVENTS_MAX,
    Answered,
    Code,
    Done,
    EmergencyStop,
    Enable,
    EncoderRead,
    Failed,
    Foreign,
    Garbled,
    GoSynchronous,
    Host,
    Mode,
    MotorState,
    Outcome,
    Overrun,
    ReadEncoder,
    ReadSetting,
    ReadStall,
    ReadState,
    ReportByItself,
    Reported,
    Restart,
    SetGroup,
    SetId,
    SetMode,
    SettingRead,
    SilenceWatchdog,
    StallRead,
    StateRead,
    Status,
    Stray,
    encode,
)


def test_a_request_is_a_record_of_its_frame():
    assert Host(NODES).send(3, ReadEncoder()) == pack(encode(3, ReadEncoder()))


def test_an_answer_belongs_to_the_request_of_its_drive_and_code():
    host = Host(NODES)
    for node in NODES:
        host.send(node, ReadEncoder())
        host.send(node, ReadState())
    for node in reversed(NODES):
        assert events(host, said(node, StateRead(MotorState.STOPPED), EncoderRead(node))) == [
            Answered(node, ReadState(), StateRead(MotorState.STOPPED)),
            Answered(node, ReadEncoder(), EncoderRead(node)),
        ]
        assert host.unanswered(node) == ()


@pytest.mark.parametrize("request_", [Enable(True), SetMode(Mode.BUS_FOC), SilenceWatchdog(500)])
def test_a_setting_is_done_or_failed(request_):
    for what, kind in ((Outcome.DONE, Done), (Outcome.FAILED, Failed)):
        host = asked(request_)
        assert events(host, said(1, Status(request_.code, what))) == [kind(1, request_)]
        assert host.unanswered(1) == ()


def test_nothing_is_asked_twice_before_it_is_answered():
    host = asked(ReadEncoder())
    with pytest.raises(LocalProtocolError, match="ReadEncoder to drive 1 is unanswered: wait"):
        host.send(1, ReadEncoder())
    host.send(2, ReadEncoder())
    host.forget(1, ReadEncoder())
    host.send(1, ReadEncoder())


def test_a_setting_is_not_read_while_it_is_set():
    host = asked(SetMode(Mode.BUS_FOC))
    with pytest.raises(LocalProtocolError, match="SetMode to drive 1 is unanswered"):
        host.send(1, ReadSetting(Code.MODE))
    assert events(host, said(1, Status(Code.MODE, Outcome.DONE))) == [
        Done(1, SetMode(Mode.BUS_FOC))
    ]
    host.send(1, ReadSetting(Code.MODE))
    told = SettingRead(Code.MODE, b"\5")
    assert events(host, said(1, told)) == [Answered(1, ReadSetting(Code.MODE), told)]


def test_what_is_for_several_awaits_no_answer():
    host = Host(NODES, groups=[0x50])
    for many in (BROADCAST, 0x50):
        host.send(many, ONE)
        host.send(many, EmergencyStop())
        for lonely in (ReadEncoder(), ReadSetting(Code.MODE), SetId(9)):
            with pytest.raises(LocalProtocolError, match="is put to one drive alone"):
                host.send(many, lonely)
    assert all(host.unanswered(node) == () for node in NODES)
    for few in (1, 0x50):
        with pytest.raises(LocalProtocolError, match="GoSynchronous is broadcast"):
            host.send(few, GoSynchronous())
    assert host.unanswered(1) == ()


def test_the_id_of_a_drive_is_no_group():
    with pytest.raises(LocalProtocolError, match="2 is a drive"):
        Host(NODES).send(1, SetGroup(2))


def test_an_id_is_one_of_a_drive_or_a_group():
    with pytest.raises(BadField, match="groups"):
        Host(NODES, groups=[3])
    with pytest.raises(BadField, match="node"):
        Host([0])
    host = Host(NODES)
    with pytest.raises(LocalProtocolError, match="no drive of this host has the id 9"):
        host.send(9, ReadEncoder())
    host.add(9)
    assert host.nodes == {*NODES, 9}
    assert host.send(9, ReadEncoder())


@pytest.mark.parametrize("by", [1, 9])
def test_a_new_id_is_answered_by_the_old_one_or_the_new(by):
    host = asked(SetId(9))
    assert events(host, said(by, Status(Code.NODE, Outcome.DONE))) == [Done(1, SetId(9))]
    assert 9 in host.nodes
    assert host.unanswered(1) == ()


def test_reports_are_told_apart_from_answers_and_from_what_nobody_asked_for():
    host = Host(NODES)
    assert events(host, said(1, HERE)) == [Stray(1, HERE)]
    report = ReportByItself(Code.ENCODER, 100)
    host.send(1, report)
    found = events(host, said(1, Status(Code.REPORT, Outcome.DONE, Code.ENCODER), HERE))
    assert found == [Done(1, report), Reported(1, HERE)]
    host.send(1, ReadEncoder())
    assert events(host, said(1, HERE, HERE)) == [
        Answered(1, ReadEncoder(), HERE),
        Reported(1, HERE),
    ]
    host.send(1, ReportByItself(Code.ENCODER, 0))
    other = Status(Code.REPORT, Outcome.DONE, Code.SPEED)
    assert events(host, said(1, other, HERE)) == [Stray(1, other), Stray(1, HERE)]
    host.forget(1)
    host.send(1, ReportByItself(Code.STALL, 50))
    stalled = StallRead(True)
    assert events(host, said(1, stalled)) == [Reported(1, stalled)]
    assert events(asked(ReadStall()), said(1, stalled)) == [Answered(1, ReadStall(), stalled)]


def test_a_second_drive_of_an_id_is_a_stray():
    host = asked(ReadEncoder())
    assert events(host, said(1, HERE, HERE)) == [Answered(1, ReadEncoder(), HERE), Stray(1, HERE)]


def test_the_late_answer_to_a_forgotten_request_is_a_stray():
    host = asked(ReadEncoder(), ONE)
    host.forget(1, ReadEncoder())
    host.forget(1, ONE)
    host.forget(1, BY)
    assert events(host, said(1, HERE, STARTED)) == [Stray(1, HERE), Stray(1, STARTED)]


def test_what_came_before_a_request_does_not_answer_it():
    host = Host(NODES)
    host.receive_data(said(1, HERE))
    host.send(1, ReadEncoder())
    assert events(host) == [Stray(1, HERE)]
    assert host.unanswered(1) == (ReadEncoder(),)


def test_a_drive_that_is_restarted_owes_nothing_but_that():
    host = asked(ReadEncoder(), ONE, ReportByItself(Code.ENCODER, 50), Restart())
    assert host.unanswered(1) == (Restart(),)
    assert events(host, said(1, HERE, Status(Code.RESTART, Outcome.DONE))) == [
        Stray(1, HERE),
        Done(1, Restart()),
    ]


def test_what_is_not_from_a_drive_is_foreign():
    frames = [Frame(0x181, b"\1"), Frame(1, b"\x31", extended=True), Frame(1, remote=True)]
    host = asked(ReadEncoder())
    assert events(host, b"".join(map(pack, frames))) == [Foreign(frame) for frame in frames]


def test_a_bad_check_byte_is_garbled_and_answers_nothing():
    host = asked(ReadEncoder())
    good = encode(1, HERE)
    bad = Frame(1, good.data[:-1] + b"\0")
    assert events(host, pack(bad) + pack(good)) == [
        Garbled(bad, "the check byte should be ad"),
        Answered(1, ReadEncoder(), HERE),
    ]


def test_a_flood_that_nobody_fetches_is_bounded_and_ends_with_the_newest():
    host = Host(NODES)
    for counts in range(EVENTS_MAX + 10):
        host.receive_data(said(1, EncoderRead(counts)))
    lost, *kept = events(host)
    assert lost == Overrun(10)
    assert len(kept) == EVENTS_MAX
    assert kept[-1] == Stray(1, EncoderRead(EVENTS_MAX + 9))
