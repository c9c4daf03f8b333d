"""The simulated TeachMover, spoken to by the host's end of its dialect over a paced line."""

import pytest
from amounts import every_row
from sim_bench import BYTE_S, TeachMoverBench, grasp, spread

from armdrive.errors import BadRequest
from armdrive.sim.teachmover import TeachMoverBoard, TeachMoverQuirks
from firmware_protocol.teachmover import (
    Close,
    Key,
    ProgramRow,
    QDump,
    QWrite,
    Read,
    Reset,
    Run,
    Set,
    Status,
    Step,
)

STEP = Step(240, (470, -235, 0, 10, 0, 0))


@pytest.fixture
def bench():
    return TeachMoverBench()


def registers(bench):
    return bench.ask(Read()).registers.positions


class TestSteps:
    def test_the_answer_comes_when_the_motion_has_ended(self, bench):
        line = len(b"@STEP 240,470,-235,0,10,0,0\r")
        assert bench.ask(STEP).status is Status.DONE
        assert bench.now_s == pytest.approx((line + 2) * BYTE_S + 1.0, abs=1e-9)
        assert registers(bench) == (470, -235, 0, 10, 0, 0)

    def test_a_step_of_nothing_is_answered_at_once_and_writes_its_output(self, bench):
        bench.ask(Step(0, (0,) * 6, 21))
        assert bench.board.outputs == 21
        assert bench.now_s < 0.04
        bench.ask(Step(0, (0,) * 6))
        assert bench.board.outputs == 21

    def test_registers_wrap_at_16_bits_where_the_arm_does_not(self, bench):
        bench.device.board.count_from((32760, 0, 0, 0, 0, -32768))
        bench.ask(Step(240, (20, 0, 0, 0, 0, -1)))
        assert registers(bench) == (-32756, 0, 0, 0, 0, 32767)

    def test_lines_sent_during_a_motion_are_lost(self, bench):
        bench.begin(STEP)
        bench.pass_time(0.1)
        bench.link.write(b"@READ\r", bench.now_s)
        assert bench.pass_time(2.0).count(b"\r") == 1
        assert bench.board.lost_bytes == 6


@every_row(
    "line, answer",
    [
        (b"@JUMP 1", b"0\r"),
        (b"@STEP 240,1", b"0\r"),
        (b"@STEP " + b"1," * 25_000, b"0\r"),
        (b"@READ" + b" " * 300, b"0\r"),  # the beginning of an overlong line is no command
        (b"\0\0\n @RESET", b"1\r"),
        (b"READ", b""),
        (b"x@READ", b""),
        (b"#READ", b""),
        (b"noise" * 1000, b""),
        (b"\n\0 ", b""),
    ],
)
def test_nonsense_is_answered_0_and_what_is_not_for_it_not_at_all(line, answer):
    bench = TeachMoverBench()
    bench.link.write(line + b"\r", 0.0)
    assert bench.pass_time(100.0) == answer
    assert bench.ask(Read()).status is Status.DONE


class TestCommands:
    def test_the_grip_switch_has_an_input_bit(self):
        bench = TeachMoverBench(TeachMoverBoard(quirks=TeachMoverQuirks(grip_bit=2)))
        spread(bench.device.world, 5.0)
        assert bench.ask(Read()).registers.inputs == 0
        grasp(bench.device.world)
        assert bench.ask(Read()).registers.inputs == 0b100
        with pytest.raises(BadRequest, match="grip switch"):
            bench.device.set_input(2, True)

    def test_close_takes_four_seconds_for_the_whole_way(self, bench):
        spread(bench.device.world, 76.0)
        assert bench.ask(Close()).status is Status.DONE
        assert bench.now_s == pytest.approx(4.1, abs=0.1)
        assert bench.ask(Read()).registers.inputs == 1
        before = bench.now_s
        bench.ask(Close())
        assert bench.now_s - before < 0.05

    def test_reset_zeroes_the_registers_and_lets_the_arm_sag(self, bench):
        bench.ask(STEP)
        height = bench.device.world.pose.z_mm
        bench.ask(Reset())
        assert registers(bench) == (0,) * 6
        assert not bench.device.world.energised
        assert bench.device.world.pose.z_mm < height - 5
        bench.ask(Step(240, (1, 0, 0, 0, 0, 0)))
        assert bench.device.world.energised

    def test_a_program_runs_point_by_point_to_absolute_positions(self, bench):
        bench.device.board.count_from((5, 0, 0, 0, 0, 0))
        rows = [(2, (100, 50, 0, 0, 0, 0)), (1, (-100, 0, 0, 0, 0, 0))]
        for number, positions in rows:
            bench.ask(QWrite(ProgramRow.move(number, 240, positions)))
        before = bench.now_s
        assert bench.ask(Run()).status is Status.DONE
        assert bench.now_s - before == pytest.approx((105 + 200) / 470, abs=0.02)
        assert registers(bench) == (100, 50, 0, 0, 0, 0)
        assert [row.number for row in bench.ask(QDump()).rows] == [1, 2]


class TestPendant:
    def test_stop_ends_a_motion_at_its_present_step(self, bench):
        start = bench.device.world.motors
        bench.begin(STEP)
        bench.device.at(28 * BYTE_S + 0.5, lambda: bench.board.press(Key.STOP))
        assert bench.finish().status is Status.STOPPED
        assert bench.now_s == pytest.approx(30 * BYTE_S + 0.5, abs=1e-9)
        answer = bench.ask(Read()).registers
        assert answer.positions == bench.device.world.motors - start == (235, -117, 0, 5, 0, 0)
        assert answer.key is Key.STOP

    def test_stop_ends_a_whole_program(self, bench):
        for number in (1, 2):
            bench.ask(QWrite(ProgramRow.move(number, 240, (470 * number, 0, 0, 0, 0, 0))))
        bench.begin(Run())
        bench.device.at(bench.now_s + 0.5, lambda: bench.board.press(Key.STOP))
        assert bench.finish().status is Status.STOPPED
        assert 0 < registers(bench)[0] < 470

    def test_the_pendant_has_control_until_it_gives_it_back(self, bench):
        bench.begin(Set())
        bench.pass_time(60.0)
        bench.device.jog((10, 0, 0, 0, 0, 0))
        assert bench.board.return_control()
        assert bench.finish().status is Status.DONE
        assert registers(bench) == (10, 0, 0, 0, 0, 0)
        assert not bench.board.return_control()


class TestPower:
    def test_cut_in_motion_the_arm_stops_dead_sags_and_forgets(self, bench):
        bench.ask(QWrite(ProgramRow.move(1, 240, (1, 2, 3, 4, 5, 6))))
        bench.begin(STEP)
        bench.pass_time(0.5)
        base = bench.device.world.motors[0]
        bench.device.power_off()
        assert bench.pass_time(5.0) == b""
        assert bench.device.world.motors[0] == base
        bench.link.write(b"@READ\r", bench.now_s)
        assert bench.pass_time(1.0) == b""
        bench.host.give_up()
        bench.device.power_on()
        assert registers(bench) == (0,) * 6
        assert not bench.device.world.energised
        assert bench.ask(QDump()).rows == ()
