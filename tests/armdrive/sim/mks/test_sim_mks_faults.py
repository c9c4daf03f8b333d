"""What can go wrong with a simulated arm on a CAN bus, as it is asked for by name."""

from __future__ import annotations

import pytest
from bus_sim import IDS
from mks_sim import TURN, Bench
from mks_sim import outcomes as said

from armdrive.errors import BadRequest, LinkLost
from armdrive.sim.device import SimDevice
from armdrive.sim.faults import parse_option
from armdrive.sim.faults.table import check_faults
from armdrive.sim.teachmover import TeachMoverBoard
from firmware_protocol import mks

CARRIED_OUT, GIVEN_UP = [mks.Started, mks.Done], [mks.Started, mks.Failed]


@pytest.fixture
def bench():
    return Bench()


class TestFrames:
    @pytest.mark.parametrize("side", ["host", "device"])
    def test_one_is_lost(self, bench, side):
        bench.twin.faults.add("lose-frame", "next", side=side)
        assert bench.ask(1, mks.ReadEncoder()) == []
        assert bench.counts(2) == 0

    def test_a_share_of_them_is_lost(self, bench):
        bench.twin.faults.add("lose-frame", 0.3, side="host", seed=1)
        answered = 0
        for _ in range(100):
            answered += bool(bench.ask(1, mks.ReadEncoder()))
            bench.host.forget(1)
        assert 55 < answered < 85

    def test_one_comes_twice(self, bench):
        bench.twin.faults.add("double-frame", "next", side="device")
        assert said(bench.ask(1, mks.ReadEncoder())) == [mks.Answered, mks.Stray]
        bench.twin.faults.add("double-frame", "next", side="host")
        assert said(bench.ask(1, mks.ReadState())) == [mks.Answered, mks.Stray]

    def test_one_comes_late(self, bench):
        bench.twin.faults.add("delay", 0.5, "next", side="device")
        assert bench.ask(1, mks.ReadEncoder(), 0.4) == []
        assert said(bench.run(0.2)) == [mks.Answered]

    def test_one_is_overtaken(self, bench):
        bench.twin.faults.add("overtake", "next", side="device")
        bench.send(1, mks.ReadState())
        bench.send(2, mks.ReadInputs())
        assert [event.node for event in bench.run()] == [2, 1]
        assert [event.node for event in bench.ask(3, mks.ReadState())] == [3]

    def test_a_spoilt_one_is_lost_by_its_crc(self, bench):
        bench.twin.faults.add("corrupt", "next", side="device")
        assert bench.ask(1, mks.ReadEncoder()) == []


class TestDrives:
    def test_a_mute_one_obeys(self, bench):
        bench.twin.faults.add("drive-mute", 2)
        there = bench.world.motors
        assert bench.ask(2, mks.MoveAbsoluteAxis(500, 60, 0), 0.5) == []
        assert bench.world.motors[1] == there[1] + 500
        bench.twin.faults.end("drive-mute")
        assert bench.counts(2) == 500

    def test_a_dead_one_lets_its_shaft_go_and_comes_back_at_zero(self, bench):
        bench.ask(2, mks.MoveAbsoluteAxis(500, 60, 0), 0.5)
        height_mm = bench.world.pose.z_mm
        bench.twin.faults.add("drive-dead", 2, for_s=1.0)
        assert bench.ask(2, mks.ReadEncoder(), 0.5) == []
        assert bench.world.pose.z_mm < height_mm
        assert not bench.world.energised
        bench.host.forget(2)
        bench.run(0.6)
        assert bench.counts(2) == 0
        assert bench.world.energised

    def test_reset_in_motion_it_stops_and_knows_nothing_any_more(self, bench):
        bench.send(1, mks.MoveAbsoluteAxis(5 * TURN, 60, 0))
        bench.twin.faults.add("drive-reset", "base", after_s=1.0)
        assert said(bench.run(3.0)) == [mks.Started]
        bench.host.forget(1)
        assert bench.counts(1) == 0
        assert bench.state(1) is mks.MotorState.STOPPED
        assert bench.world.joints.deg["base"] == pytest.approx(360 / 50, abs=0.1)

    def test_the_whole_board_resets(self, bench):
        bench.ask(1, mks.MoveAbsoluteAxis(500, 60, 0), 0.5)
        bench.twin.faults.add("reset")
        assert not bench.world.energised
        bench.run(1.0)
        assert [bench.counts(node) for node in IDS] == [0] * 6

    def test_one_in_a_wrong_mode_refuses(self, bench):
        bench.twin.faults.add("drive-mode", 3, 2)
        assert said(bench.ask(3, mks.MoveAbsoluteAxis(500, 60, 0))) == [mks.Failed]
        bench.twin.faults.end()
        assert said(bench.ask(3, mks.MoveAbsoluteAxis(10, 60, 0))) == CARRIED_OUT

    def test_two_of_one_id_are_heard_as_one_where_they_agree_and_else_both(self, bench):
        bench.ask(2, mks.MoveAbsoluteAxis(500, 60, 0), 0.5)
        bench.twin.faults.add("drive-id", 2, 1)
        assert said(bench.ask(1, mks.ReadVersion())) == [mks.Answered]
        heard = bench.ask(1, mks.ReadEncoder(), 0.1)
        assert said(heard) == [mks.Answered, mks.Stray]
        assert [heard[0].answer.counts, heard[1].answer.counts] == [0, 500]
        there = bench.world.motors
        bench.ask(1, mks.MoveAbsoluteAxis(900, 60, 0), 0.5)
        assert tuple(bench.world.motors - there) == (900, 400, 0, 0, 0, 0)
        assert bench.ask(2, mks.ReadEncoder()) == []
        bench.twin.faults.end()
        bench.host.forget(2)
        assert bench.counts(2) == 900

    def test_one_that_is_given_two_ids_in_turn_has_its_own_in_the_end(self, bench):
        bench.twin.faults.add("drive-id", 2, 9, for_s=1.0)
        bench.run(0.5)
        bench.twin.faults.add("drive-id", 2, 10, for_s=1.0)
        assert bench.twin.faults.active == ("drive-id 2 10",)
        bench.run(0.7)
        assert bench.ask(2, mks.ReadEncoder()) == []
        bench.run(0.5)
        assert said(bench.ask(2, mks.ReadState())) == [mks.Answered]

    def test_one_does_not_say_when_it_is_done(self, bench):
        bench.twin.faults.add("no-done", 1)
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(500, 60, 0), 0.5)) == [mks.Started]
        assert said(bench.ask(2, mks.MoveAbsoluteAxis(500, 60, 0), 0.5)) == CARRIED_OUT

    def test_a_stalled_motor_ends_its_motion(self, bench):
        bench.twin.faults.add("stall", 1, after_s=0.3)
        assert said(bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0), 1.0)) == GIVEN_UP

    @pytest.mark.parametrize(
        ("words", "named"),
        [
            (("drive-mode", 1, 9), "modes are 0 to 5"),
            (("drive-id", 1, 4000), "node must be"),
            (("drive-mute", 7), "motors are 1 to 6"),
        ],
    )
    def test_a_fault_that_no_drive_can_have_is_refused(self, bench, words, named):
        with pytest.raises(BadRequest, match=named):
            bench.twin.faults.add(*words)


class TestAdapter:
    def test_bus_off_the_link_is_lost_and_the_drives_live_on(self, bench):
        bench.send(1, mks.MoveAbsoluteAxis(TURN, 60, 0))
        bench.run(0.5)
        bench.twin.faults.add("bus-off")
        with pytest.raises(LinkLost, match="bus-off"):
            bench.link.read(2.0)
        assert bench.twin.faults.active == ("bus-off",)
        bench.link.close()
        bench.link.reopen()
        bench.now_s = 2.0
        bench.host.forget(1)
        assert bench.twin.faults.active == ()
        assert bench.counts(1) == TURN

    def test_unplugged_and_plugged_in_again(self, bench):
        bench.twin.faults.add("unplug", after_s=0.1, for_s=0.2)
        with pytest.raises(LinkLost, match="unplugged"):
            bench.run(0.2)
        bench.link.line.advance(0.5)
        bench.now_s = 0.5
        assert bench.counts(1) == 0

    def test_alone_nobody_hears_anybody(self, bench):
        bench.twin.faults.add("alone", for_s=1.0)
        assert bench.ask(1, mks.MoveAbsoluteAxis(TURN, 60, 0), 0.5) == []
        bench.run(1.0)
        bench.host.forget(1)
        assert bench.counts(1) == 0

    def test_no_other_arm_has_such_faults(self):
        for name in ("drive-mute:1", "bus-off", "alone"):
            with pytest.raises(BadRequest, match="no drives on a bus"):
                check_faults(SimDevice(TeachMoverBoard()), [parse_option(name)])

    def test_those_of_a_command_line_are_checked_before_the_arm_lives(self, bench):
        check_faults(bench.device, [parse_option("bus-off@3"), parse_option("drive-reset:1@2")])
