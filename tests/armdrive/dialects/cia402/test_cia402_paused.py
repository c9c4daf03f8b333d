"""A pause while a CiA 402 drive is not heard: the arm stands where it was, until it is resumed."""

from __future__ import annotations

import pytest
from cia402_rig import Rig, steps
from faults import arm_config, driven

from armdrive.status import State, Trust
from armdrive.tasks import AlertKind, Done, Halted, MoveAlong, MoveBy, RequestRejected

LINE = tuple(MoveBy(steps(1000, -500), 20_000.0) for _ in range(20))
MUTE_S = 0.15
"""Long enough to be waited for, and too short to be lost."""
PAUSED_S = 3.0


class Pause:
    """A motion in which one drive is not heard for a while, and which somebody pauses."""

    def __init__(self, pause_s: float) -> None:
        """Have it paused so long after that drive was heard last."""
        self.rig = Rig().ready()
        self.paused, self.before = False, self.rig.positions
        self.rig.begin(MoveAlong(iter(LINE), 0.3, held_back=lambda: self.paused))
        self.rig.run(0.3)
        mute_s = self.rig.now_s
        acts = ((pause_s, self._pause), (0.0, self._mute), (MUTE_S, self._receive))
        for after_s, act in sorted(acts, key=lambda each: each[0]):
            self.rig.run(mute_s + after_s - self.rig.now_s)
            act()
        self.rig.run(mute_s + pause_s + self.rig.controller.stopping(0.3).silent_s - self.rig.now_s)

    def _pause(self) -> None:
        self.paused = True

    def _mute(self) -> None:
        self.rig.device.board.drives.mute(1, True)

    def _receive(self) -> None:
        self.rig.device.board.drives.mute(1, False)


WAITED_IN = (0.04, 0.12, MUTE_S + 0.005)
"""The motion itself waits, since that drive is not heard."""


@pytest.mark.parametrize("pause_s", [-0.02, 0.0, *WAITED_IN, MUTE_S + 0.05])
def test_a_paused_arm_stands_within_the_announced_time_and_resumes(pause_s):
    pause = Pause(pause_s)
    rig, stood = pause.rig, pause.rig.positions
    assert stood != pause.before
    rig.run(0.5)
    assert rig.positions == stood
    ended, pause.paused = rig.reply(), False
    waits = ended is None
    assert (ended or rig.finish()) == Done()  # of all of it, or of what was drawn and not waited in
    assert not rig.alerts()
    assert waits or pause_s not in WAITED_IN
    assert not waits or rig.positions == pause.before + steps(20_000, -10_000)


def test_drives_that_answer_now_and_then_in_a_pause_do_not_move():
    pause = Pause(0.08)
    rig, stood = pause.rig, pause.rig.positions
    for turn in range(40):
        rig.device.board.drives.mute(1 + turn % 3, bool(turn // 3 % 2))
        rig.run(0.02)
    assert rig.positions == stood
    assert rig.controller.busy


def test_a_stop_in_such_a_pause_ends_the_motion_and_nothing_moves():
    pause = Pause(0.08)
    rig, stood = pause.rig, pause.rig.positions
    rig.stop()
    assert rig.finish() == Halted()
    assert rig.positions == stood
    assert not rig.alerts()


def test_a_drive_that_falls_silent_in_such_a_pause_is_reported():
    pause = Pause(0.08)
    pause.rig.device.board.drives.mute(2, True)  # counted from 0
    reply = pause.rig.finish()
    assert isinstance(reply, RequestRejected)
    assert "drive 3 (elbow)" in reply.reason


def test_a_shaft_that_is_blocked_in_such_a_pause_does_not_spring_when_it_is_free():
    pause = Pause(0.08)
    rig = pause.rig
    target = rig.positions[0]
    rig.twin.world.stalled.add(0)
    rig.device.push([-400, 0, 0, 0, 0, 0])  # less than what drives fail for
    rig.run(0.01)
    assert rig.positions[0] < target
    reply = rig.finish()
    assert isinstance(reply, RequestRejected)
    assert "drive 1 (base) is at" in reply.reason
    assert [alert.kind for alert in rig.alerts()] == [AlertKind.OFF_PATH]
    rig.twin.world.stalled.clear()
    rig.check_stands(1.0)


def test_a_whole_arm_says_that_it_is_paused_stands_and_goes_on_when_it_is_resumed():
    with driven(arm_config("cia402")) as arm:
        twin = arm.twin
        began_s = arm.pace.now_s()
        twin.device.at(began_s + 0.4, lambda: twin.board.drives.mute(3, True))
        twin.device.at(began_s + 0.4 + MUTE_S, lambda: twin.board.drives.mute(3, False))
        motion = arm.move_j(base_deg=30, wait=False)
        arm.sleep(0.5)
        arm.pause()
        arm.sleep(arm.status.pause_time_s)
        stood = twin.world.motors
        arm.sleep(PAUSED_S)
        assert twin.world.motors == stood
        assert arm.status.paused
        assert arm.status.state is State.MOVING
        arm.resume()
        motion.wait()
        assert twin.world.motors != stood
        assert arm.status.trust is Trust.REFERENCED
        assert twin.world.motors == arm.status.acknowledged
