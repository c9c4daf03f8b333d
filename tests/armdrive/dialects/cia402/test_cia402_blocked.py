"""The shaft of a CiA 402 drive is blocked as it is stopped, and comes free: it stays there."""

from __future__ import annotations

import pytest
from cia402_rig import Rig, steps

from armdrive.tasks import ClearFault, Done, Halted, MoveAlong, MoveBy, RequestRejected, SwitchOn
from firmware_protocol.canopen import Service, cob_id

LINE = tuple(MoveBy(steps(1000, -500), 20_000.0) for _ in range(20))
STRATEGIES = pytest.mark.parametrize("strategy", ["cyclic", "profile"])
BLOCKED_S = 0.05
"""Its set-point is ahead of it by then, and not yet by what drives fail for."""


def blocked(strategy: str, *, mute: bool) -> Rig:
    """Stop a motion in which the first shaft is blocked, and its drive not heard perhaps."""
    rig = Rig({"strategy": strategy}).ready()
    cyclic = strategy == "cyclic"
    rig.begin(MoveAlong(iter(LINE), 0.3) if cyclic else MoveBy(steps(8000, -4000), 20_000.0))
    rig.run(0.3)
    rig.twin.world.stalled.add(0)
    rig.run(BLOCKED_S)
    rig.device.board.drives.mute(0, mute)
    rig.stop()
    began_s, reply = rig.now_s, rig.finish()
    assert isinstance(reply, RequestRejected if mute else Halted)
    assert mute or rig.now_s - began_s <= rig.controller.stopping(0.3).confirmed_s
    return rig


def comes_free(rig: Rig) -> None:
    """See that nothing turns when the shaft can."""
    stood = rig.positions
    rig.twin.world.stalled.clear()
    rig.run(0.5)
    assert rig.positions == stood


@STRATEGIES
def test_a_blocked_shaft_is_held_where_it_stands(strategy):
    comes_free(blocked(strategy, mute=False))


@STRATEGIES
@pytest.mark.parametrize("request_", [ClearFault(), SwitchOn()], ids=["reset", "enable"])
def test_a_blocked_shaft_is_held_where_it_stands_once_its_drive_answers_again(strategy, request_):
    rig = blocked(strategy, mute=True)
    assert rig.node(1).motor.point.end != rig.node(1).motor.shaft
    rig.device.board.drives.mute(0, False)
    assert rig.do(request_) == Done()
    comes_free(rig)


@pytest.mark.parametrize(
    ("strategy", "rate_hz", "blocked_s"),
    [
        ("cyclic", 20_000.0, 0.005),
        ("cyclic", 20_000.0, 0.1),
        ("cyclic", 1000.0, 0.03),
        ("cyclic", 1000.0, 0.5),
        ("profile", 20_000.0, BLOCKED_S),
    ],
)
def test_a_shaft_that_blocks_a_jog_is_held_where_it_stands_within_the_announced_time(
    strategy, rate_hz, blocked_s
):
    """Its error is smaller than the one at which drives fault, so only its standing shows it."""
    rig, released = Rig({"strategy": strategy}).ready(), []
    if strategy == "cyclic":
        jog = (MoveBy(steps(1000, -500), rate_hz) for _ in range(40))
        rig.begin(MoveAlong(jog, 0.3, released=lambda: bool(released)))
    else:
        rig.begin(MoveBy(steps(6000, -3000), rate_hz, lambda: bool(released)))
    rig.run(0.2)
    rig.twin.world.stalled.add(0)
    rig.run(blocked_s)
    released.append(True)
    rig.run(rig.controller.stopping(0.3).silent_s)
    assert rig.reply() == Halted()
    assert not rig.alerts()
    comes_free(rig)


@pytest.mark.parametrize("rate_hz", [20_000.0, 300.0])
def test_a_blocked_shaft_is_found_in_the_same_time_at_any_speed(rate_hz):
    """A slow drive's error grows slowly, so that its own limit would take seconds."""
    rig = Rig().ready()
    rig.begin(MoveAlong((MoveBy(steps(300), rate_hz) for _ in range(400)), 0.3))
    rig.run(0.5)
    rig.twin.world.stalled.add(0)
    began_s, reply = rig.now_s, rig.finish()
    assert isinstance(reply, RequestRejected)
    assert "drive 1 (base)" in reply.reason
    assert rig.now_s < began_s + 1.0
    comes_free(rig)


def test_a_drive_that_sends_no_reports_but_answers_questions_ends_the_motion():
    rig = Rig().ready()
    rig.begin(MoveAlong((MoveBy(steps(1000, -500), 20_000.0) for _ in range(100)), 0.3))
    rig.run(0.3)
    rig.loses = lambda frame, host: not host and frame.can_id == cob_id(Service.TPDO1, 1)
    began_s, reply = rig.now_s, rig.finish()
    assert isinstance(reply, RequestRejected)
    assert reply.silent
    assert "drive 1 (base)" in reply.reason
    assert rig.now_s < began_s + 1.0


def test_a_silent_drive_is_not_turned_back_to_its_last_reading():
    """What it was heard at last is behind a shaft that has gone on."""
    rig = Rig().ready()
    rig.begin(MoveAlong(iter(LINE), 0.3))
    rig.run(0.3)
    rig.device.board.drives.mute(0, True)
    rig.stop()
    reply, farthest = None, rig.positions[0]
    while reply is None:
        rig.run(0.005)
        assert rig.positions[0] >= farthest
        farthest, reply = rig.positions[0], rig.reply()
    rig.run(1.0)
    assert rig.positions[0] == farthest
