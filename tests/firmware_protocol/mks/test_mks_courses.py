"""Which motion of an MKS drive a reply is about, lost and unexpected ones among them."""

import pytest
from chunks import events
from hypothesis import given
from hypothesis import strategies as st
from mks_bus import (
    BY,
    DONE,
    FAILED,
    HALT,
    LIMIT,
    NODES,
    ONE,
    STARTED,
    STORED,
    THREE,
    TWO,
    asked,
    outcome,
    said,
)
from mks_strategies import MOTIONS, REQUESTS

from firmware_protocol import mks
from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.frames import Frame, pack


def test_a_stop_is_never_refused():
    host = asked(*[mks.EmergencyStop()] * 3, *[HALT] * 20)
    assert host.unanswered(1)[0] == mks.EmergencyStop()
    assert len(host.unanswered(1)) == 1 + 8
    stopped = mks.Status(mks.Code.EMERGENCY_STOP, mks.Outcome.DONE)
    assert events(host, said(1, stopped)) == [mks.Done(1, mks.EmergencyStop())]


def test_a_motion_starts_and_ends():
    host = asked(ONE)
    assert events(host, said(1, STARTED)) == [mks.Started(1, ONE)]
    assert host.unanswered(1) == ()
    assert events(host, said(1, DONE)) == [mks.Done(1, ONE)]
    assert events(host, said(1, DONE)) == [mks.Stray(1, DONE)]


@pytest.mark.parametrize(
    ("sent", "replies", "heard"),
    [
        ([ONE], [FAILED], [mks.Failed(1, ONE)]),
        ([ONE], [STARTED, LIMIT], [mks.Started(1, ONE), mks.LimitStop(1, ONE)]),
        ([ONE], [STARTED, FAILED], [mks.Started(1, ONE), mks.Failed(1, ONE)]),
        ([ONE], [DONE], [mks.Done(1, ONE)]),  # its STARTED was lost
        ([ONE], [STARTED, STARTED], [mks.Started(1, ONE), mks.Stray(1, STARTED)]),
        ([], [STARTED], [mks.Stray(1, STARTED)]),
        ([], [STORED], [mks.Stray(1, STORED)]),
        ([], [FAILED], [mks.Stray(1, FAILED)]),
        (
            [ONE, TWO],
            [STARTED, STARTED, DONE],
            [mks.Started(1, ONE), mks.Started(1, TWO), mks.Done(1, TWO)],
        ),
        # the old one's failure, before and after the new one's start
        (
            [ONE, TWO],
            [STARTED, FAILED, STARTED, DONE],
            [mks.Started(1, ONE), mks.Superseded(1, ONE), mks.Started(1, TWO), mks.Done(1, TWO)],
        ),
        (
            [ONE, TWO],
            [STARTED, STARTED, FAILED, DONE],
            [mks.Started(1, ONE), mks.Started(1, TWO), mks.Superseded(1, ONE), mks.Done(1, TWO)],
        ),
        (
            [ONE, HALT],
            [STARTED, STARTED, FAILED, DONE],
            [mks.Started(1, ONE), mks.Started(1, HALT), mks.Superseded(1, ONE), mks.Done(1, HALT)],
        ),
        # what is over is not superseded by what is refused next
        (
            [ONE, TWO, THREE],
            [STARTED, STARTED, DONE, FAILED],
            [mks.Started(1, ONE), mks.Started(1, TWO), mks.Done(1, TWO), mks.Failed(1, THREE)],
        ),
    ],
)
def test_replies_belong_to_motions_in_their_order(sent, replies, heard):
    assert events(asked(*sent), said(1, *replies)) == heard


def test_another_motion_than_f5_is_refused_and_does_not_supersede():
    host = asked(BY, BY)
    replies = [
        outcome(what, BY.code)
        for what in (mks.Outcome.STARTED, mks.Outcome.FAILED, mks.Outcome.DONE)
    ]
    assert events(host, said(1, *replies)) == [
        mks.Started(1, BY),
        mks.Failed(1, BY),
        mks.Done(1, BY),
    ]


def test_what_is_known_to_be_over_is_not_superseded():
    host = asked(ONE)
    events(host, said(1, STARTED))
    host.settle(1)
    host.send(1, TWO)
    assert events(host, said(1, FAILED)) == [mks.Failed(1, TWO)]


def test_homing_starts_and_ends():
    host = asked(mks.Home())
    replies = [mks.Status(mks.Code.HOME, what) for what in (mks.Outcome.STARTED, mks.Outcome.DONE)]
    assert events(host, said(1, *replies)) == [mks.Started(1, mks.Home()), mks.Done(1, mks.Home())]


@pytest.mark.parametrize("says_started", [False, True])
def test_stored_motions_are_under_way_from_the_synchronous_start_on(says_started):
    host = mks.Host(NODES)
    assert host.send(mks.BROADCAST, mks.ArmSynchronous(True)) == pack(Frame(0, b"\x4a\1\x4b"))
    for node in NODES:
        host.send(node, ONE)
        assert events(host, said(node, STORED)) == [mks.StoredForStart(node, ONE)]
    assert host.send(mks.BROADCAST, mks.GoSynchronous()) == pack(Frame(0, b"\x4b\x4b"))
    host.send(mks.BROADCAST, mks.GoSynchronous())  # the manual advises to say it again
    for node in NODES:
        if says_started:
            assert events(host, said(node, STARTED)) == [mks.Started(node, ONE)]
        assert events(host, said(node, DONE)) == [mks.Done(node, ONE)]


@given(st.lists(st.one_of(MOTIONS, REQUESTS), max_size=8), st.data())
def test_lost_doubled_and_reordered_replies_never_raise(requests, data):
    host = mks.Host(NODES)
    frames = []
    for request in requests:
        try:
            host.send(1, request)
        except LocalProtocolError:
            continue
        for what in mks.Outcome:
            try:
                frames.append(said(1, mks.Status(request.code, what)))
            except LocalProtocolError:
                continue
    if frames:
        for frame in data.draw(st.lists(st.sampled_from(frames), max_size=20)):
            (event,) = events(host, frame)
            assert not isinstance(event, mks.Foreign)
    host.settle(1)
    host.forget(1)
    assert host.unanswered(1) == ()
