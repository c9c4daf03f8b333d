"""Which motion of an MKS drive a reply is about, lost and unexpected ones among them."""

import pytest
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
from mks_strategies import MOTIONS, REQUESTS, events

from firmware_protocol.errors import LocalProtocolError
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import (
    BROADCAST,
    ArmSynchronous,
    Code,
    Done,
    EmergencyStop,
    Failed,
    Foreign,
    GoSynchronous,
    Home,
    Host,
    LimitStop,
    Outcome,
    Started,
    Status,
    StoredForStart,
    Stray,
    Superseded,
)


def test_a_stop_is_never_refused():
    host = asked(*[EmergencyStop()] * 3, *[HALT] * 20)
    assert host.unanswered(1)[0] == EmergencyStop()
    assert len(host.unanswered(1)) == 1 + 8
    stopped = Status(Code.EMERGENCY_STOP, Outcome.DONE)
    assert events(host, said(1, stopped)) == [Done(1, EmergencyStop())]


def test_a_motion_starts_and_ends():
    host = asked(ONE)
    assert events(host, said(1, STARTED)) == [Started(1, ONE)]
    assert (host.unanswered(1), host.under_way(1)) == ((), (ONE,))
    assert events(host, said(1, DONE)) == [Done(1, ONE)]
    assert host.under_way(1) == ()
    assert events(host, said(1, DONE)) == [Stray(1, DONE)]


@pytest.mark.parametrize(
    ("sent", "replies", "heard"),
    [
        ([ONE], [FAILED], [Failed(1, ONE)]),
        ([ONE], [STARTED, LIMIT], [Started(1, ONE), LimitStop(1, ONE)]),
        ([ONE], [STARTED, FAILED], [Started(1, ONE), Failed(1, ONE)]),
        ([ONE], [DONE], [Done(1, ONE)]),  # its STARTED was lost
        ([ONE], [STARTED, STARTED], [Started(1, ONE), Stray(1, STARTED)]),
        ([], [STARTED], [Stray(1, STARTED)]),
        ([], [STORED], [Stray(1, STORED)]),
        ([], [FAILED], [Stray(1, FAILED)]),
        (
            [ONE, TWO],
            [STARTED, STARTED, DONE],
            [Started(1, ONE), Started(1, TWO), Done(1, TWO)],
        ),
        # the old one's failure, before and after the new one's start
        (
            [ONE, TWO],
            [STARTED, FAILED, STARTED, DONE],
            [Started(1, ONE), Superseded(1, ONE), Started(1, TWO), Done(1, TWO)],
        ),
        (
            [ONE, TWO],
            [STARTED, STARTED, FAILED, DONE],
            [Started(1, ONE), Started(1, TWO), Superseded(1, ONE), Done(1, TWO)],
        ),
        (
            [ONE, HALT],
            [STARTED, STARTED, FAILED, DONE],
            [Started(1, ONE), Started(1, HALT), Superseded(1, ONE), Done(1, HALT)],
        ),
        # what is over is not superseded by what is refused next
        (
            [ONE, TWO, THREE],
            [STARTED, STARTED, DONE, FAILED],
            [Started(1, ONE), Started(1, TWO), Done(1, TWO), Failed(1, THREE)],
        ),
    ],
)
def test_replies_belong_to_motions_in_their_order(sent, replies, heard):
    assert events(asked(*sent), said(1, *replies)) == heard


def test_another_motion_than_f5_is_refused_and_does_not_supersede():
    host = asked(BY, BY)
    replies = [outcome(what, BY.code) for what in (Outcome.STARTED, Outcome.FAILED, Outcome.DONE)]
    assert events(host, said(1, *replies)) == [Started(1, BY), Failed(1, BY), Done(1, BY)]


def test_what_is_known_to_be_over_is_not_superseded():
    host = asked(ONE)
    events(host, said(1, STARTED))
    host.settle(1)
    assert host.under_way(1) == ()
    host.send(1, TWO)
    assert events(host, said(1, FAILED)) == [Failed(1, TWO)]


def test_homing_starts_and_ends():
    host = asked(Home())
    replies = [Status(Code.HOME, what) for what in (Outcome.STARTED, Outcome.DONE)]
    assert events(host, said(1, *replies)) == [Started(1, Home()), Done(1, Home())]


@pytest.mark.parametrize("says_started", [False, True])
def test_stored_motions_are_under_way_from_the_synchronous_start_on(says_started):
    host = Host(NODES)
    assert host.send(BROADCAST, ArmSynchronous(True)) == pack(Frame(0, b"\x4a\1\x4b"))
    for node in NODES:
        host.send(node, ONE)
        assert events(host, said(node, STORED)) == [StoredForStart(node, ONE)]
        assert (host.stored(node), host.under_way(node)) == ((ONE,), ())
    assert host.send(BROADCAST, GoSynchronous()) == pack(Frame(0, b"\x4b\x4b"))
    host.send(BROADCAST, GoSynchronous())  # the manual advises to say it again
    for node in NODES:
        assert (host.stored(node), host.under_way(node)) == ((), (ONE,))
        if says_started:
            assert events(host, said(node, STARTED)) == [Started(node, ONE)]
        assert events(host, said(node, DONE)) == [Done(node, ONE)]


@given(st.lists(st.one_of(MOTIONS, REQUESTS), max_size=8), st.data())
def test_lost_doubled_and_reordered_replies_never_raise(requests, data):
    host = Host(NODES)
    frames = []
    for request in requests:
        try:
            host.send(1, request)
        except LocalProtocolError:
            continue
        for what in Outcome:
            try:
                frames.append(said(1, Status(request.code, what)))
            except LocalProtocolError:
                continue
    if frames:
        for frame in data.draw(st.lists(st.sampled_from(frames), max_size=20)):
            (event,) = events(host, frame)
            assert not isinstance(event, Foreign)
    host.settle(1)
    host.forget(1)
    assert (host.unanswered(1), host.under_way(1)) == ((), ())
