"""The host's end of a bus of MKS drives: whose answer it is, and what does not belong."""

import pytest
from chunks import events
from mks_bus import BY, HERE, NODES, ONE, STARTED, asked, said

from firmware_protocol import mks
from firmware_protocol.errors import BadField, LocalProtocolError
from firmware_protocol.frames import Frame, pack


def test_a_request_is_a_record_of_its_frame():
    assert mks.Host(NODES).send(3, mks.ReadEncoder()) == pack(mks.encode(3, mks.ReadEncoder()))


def test_an_answer_belongs_to_the_request_of_its_drive_and_code():
    host = mks.Host(NODES)
    for node in NODES:
        host.send(node, mks.ReadEncoder())
        host.send(node, mks.ReadState())
    for node in reversed(NODES):
        assert events(
            host, said(node, mks.StateRead(mks.MotorState.STOPPED), mks.EncoderRead(node))
        ) == [
            mks.Answered(node, mks.ReadState(), mks.StateRead(mks.MotorState.STOPPED)),
            mks.Answered(node, mks.ReadEncoder(), mks.EncoderRead(node)),
        ]
        assert host.unanswered(node) == ()


@pytest.mark.parametrize(
    "request_", [mks.Enable(True), mks.SetMode(mks.Mode.BUS_FOC), mks.SilenceWatchdog(500)]
)
def test_a_setting_is_done_or_failed(request_):
    for what, kind in ((mks.Outcome.DONE, mks.Done), (mks.Outcome.FAILED, mks.Failed)):
        host = asked(request_)
        assert events(host, said(1, mks.Status(request_.code, what))) == [kind(1, request_)]
        assert host.unanswered(1) == ()


def test_nothing_is_asked_twice_before_it_is_answered():
    host = asked(mks.ReadEncoder())
    with pytest.raises(LocalProtocolError, match="ReadEncoder to drive 1 is unanswered: wait"):
        host.send(1, mks.ReadEncoder())
    host.send(2, mks.ReadEncoder())
    host.forget(1, mks.ReadEncoder())
    host.send(1, mks.ReadEncoder())


def test_a_setting_is_not_read_while_it_is_set():
    host = asked(mks.SetMode(mks.Mode.BUS_FOC))
    with pytest.raises(LocalProtocolError, match="SetMode to drive 1 is unanswered"):
        host.send(1, mks.ReadSetting(mks.Code.MODE))
    assert events(host, said(1, mks.Status(mks.Code.MODE, mks.Outcome.DONE))) == [
        mks.Done(1, mks.SetMode(mks.Mode.BUS_FOC))
    ]
    host.send(1, mks.ReadSetting(mks.Code.MODE))
    told = mks.SettingRead(mks.Code.MODE, b"\5")
    assert events(host, said(1, told)) == [mks.Answered(1, mks.ReadSetting(mks.Code.MODE), told)]


def test_what_is_for_several_awaits_no_answer():
    host = mks.Host(NODES, groups=[0x50])
    for many in (mks.BROADCAST, 0x50):
        host.send(many, ONE)
        host.send(many, mks.EmergencyStop())
        for lonely in (mks.ReadEncoder(), mks.ReadSetting(mks.Code.MODE), mks.SetId(9)):
            with pytest.raises(LocalProtocolError, match="is put to one drive alone"):
                host.send(many, lonely)
    assert all(host.unanswered(node) == () for node in NODES)
    for few in (1, 0x50):
        with pytest.raises(LocalProtocolError, match="GoSynchronous is broadcast"):
            host.send(few, mks.GoSynchronous())
    assert host.unanswered(1) == ()


def test_the_id_of_a_drive_is_no_group():
    with pytest.raises(LocalProtocolError, match="2 is a drive"):
        mks.Host(NODES).send(1, mks.SetGroup(2))


def test_an_id_is_one_of_a_drive_or_a_group():
    with pytest.raises(BadField, match="groups"):
        mks.Host(NODES, groups=[3])
    with pytest.raises(BadField, match="node"):
        mks.Host([0])
    host = mks.Host(NODES)
    with pytest.raises(LocalProtocolError, match="no drive of this host has the id 9"):
        host.send(9, mks.ReadEncoder())
    host.add(9)
    assert host.nodes == {*NODES, 9}
    assert host.send(9, mks.ReadEncoder())


@pytest.mark.parametrize("by", [1, 9])
def test_a_new_id_is_answered_by_the_old_one_or_the_new(by):
    host = asked(mks.SetId(9))
    assert events(host, said(by, mks.Status(mks.Code.NODE, mks.Outcome.DONE))) == [
        mks.Done(1, mks.SetId(9))
    ]
    assert 9 in host.nodes
    assert host.unanswered(1) == ()


def test_reports_are_told_apart_from_answers_and_from_what_nobody_asked_for():
    host = mks.Host(NODES)
    assert events(host, said(1, HERE)) == [mks.Stray(1, HERE)]
    report = mks.ReportByItself(mks.Code.ENCODER, 100)
    host.send(1, report)
    found = events(
        host, said(1, mks.Status(mks.Code.REPORT, mks.Outcome.DONE, mks.Code.ENCODER), HERE)
    )
    assert found == [mks.Done(1, report), mks.Reported(1, HERE)]
    host.send(1, mks.ReadEncoder())
    assert events(host, said(1, HERE, HERE)) == [
        mks.Answered(1, mks.ReadEncoder(), HERE),
        mks.Reported(1, HERE),
    ]
    host.send(1, mks.ReportByItself(mks.Code.ENCODER, 0))
    other = mks.Status(mks.Code.REPORT, mks.Outcome.DONE, mks.Code.SPEED)
    assert events(host, said(1, other, HERE)) == [mks.Stray(1, other), mks.Stray(1, HERE)]
    host.forget(1)
    host.send(1, mks.ReportByItself(mks.Code.STALL, 50))
    stalled = mks.StallRead(True)
    assert events(host, said(1, stalled)) == [mks.Reported(1, stalled)]
    assert events(asked(mks.ReadStall()), said(1, stalled)) == [
        mks.Answered(1, mks.ReadStall(), stalled)
    ]


def test_a_second_drive_of_an_id_is_a_stray():
    host = asked(mks.ReadEncoder())
    assert events(host, said(1, HERE, HERE)) == [
        mks.Answered(1, mks.ReadEncoder(), HERE),
        mks.Stray(1, HERE),
    ]


def test_the_late_answer_to_a_forgotten_request_is_a_stray():
    host = asked(mks.ReadEncoder(), ONE)
    host.forget(1, mks.ReadEncoder())
    host.forget(1, ONE)
    host.forget(1, BY)
    assert events(host, said(1, HERE, STARTED)) == [mks.Stray(1, HERE), mks.Stray(1, STARTED)]


def test_what_came_before_a_request_does_not_answer_it():
    host = mks.Host(NODES)
    host.receive_data(said(1, HERE))
    host.send(1, mks.ReadEncoder())
    assert events(host) == [mks.Stray(1, HERE)]
    assert host.unanswered(1) == (mks.ReadEncoder(),)


def test_a_drive_that_is_restarted_owes_nothing_but_that():
    host = asked(mks.ReadEncoder(), ONE, mks.ReportByItself(mks.Code.ENCODER, 50), mks.Restart())
    assert host.unanswered(1) == (mks.Restart(),)
    assert events(host, said(1, HERE, mks.Status(mks.Code.RESTART, mks.Outcome.DONE))) == [
        mks.Stray(1, HERE),
        mks.Done(1, mks.Restart()),
    ]


def test_what_is_not_from_a_drive_is_foreign():
    frames = [Frame(0x181, b"\1"), Frame(1, b"\x31", extended=True), Frame(1, remote=True)]
    host = asked(mks.ReadEncoder())
    assert events(host, b"".join(map(pack, frames))) == [mks.Foreign(frame) for frame in frames]


def test_a_bad_check_byte_is_garbled_and_answers_nothing():
    host = asked(mks.ReadEncoder())
    good = mks.encode(1, HERE)
    bad = Frame(1, good.data[:-1] + b"\0")
    assert events(host, pack(bad) + pack(good)) == [
        mks.UnreadableFrame(bad, "the check byte should be ad"),
        mks.Answered(1, mks.ReadEncoder(), HERE),
    ]


def test_a_flood_that_nobody_fetches_is_bounded_and_ends_with_the_newest():
    host = mks.Host(NODES)
    for counts in range(mks.EVENTS_MAX + 10):
        host.receive_data(said(1, mks.EncoderRead(counts)))
    lost, *kept = events(host)
    assert lost == mks.Overrun(10)
    assert len(kept) == mks.EVENTS_MAX
    assert kept[-1] == mks.Stray(1, mks.EncoderRead(mks.EVENTS_MAX + 9))
