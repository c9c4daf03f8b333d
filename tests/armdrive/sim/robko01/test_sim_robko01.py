"""The simulated Robko 01 does what was seen of the firmware, with its numbers."""

import pytest
from sim_bench import RobkoBench, axes

from armdrive.sim.robko01 import ESP32, RobkoQuirks, SimRobkoBoard
from firmware_protocol.robko01 import (
    Axes,
    Busy,
    Disable,
    Inputs,
    InputsRead,
    IsMoving,
    MoveAbsolute,
    MoveRelative,
    MoveSpeed,
    Moving,
    Op,
    Outputs,
    OutputsSet,
    Ping,
    Pong,
    Position,
    Status,
    Stop,
)
from firmware_protocol.robko01.frames import Kind, frame_bytes


@pytest.fixture
def bench():
    return RobkoBench().enabled()


def esp32(**quirks) -> RobkoBench:
    quirks = {"acceleration": 700.0, "grid_s": 0.0, "top_speed_hz": 100.0, **quirks}
    return RobkoBench(SimRobkoBoard(quirks=RobkoQuirks(ESP32, **quirks))).enabled()


def positions(bench):
    return bench.ask(Position()).axes.positions_steps


def run(bench, request, step_s=0.002):
    """Have a motion done; return how long it took, and the positions seen on the way."""
    assert bench.ask(request).status is Status.OK
    began_s, seen = bench.now_s, [positions(bench)]
    while bench.device.moving:
        bench.pass_time(step_s)
        seen.append(tuple(bench.device.registers))
    return bench.now_s - began_s, seen


class TestWire:
    def test_a_ping_goes_round_in_five_milliseconds_and_brings_its_bytes_back(self, bench):
        before_s = bench.now_s
        assert bench.ask(Ping(b"01234567")) == Pong(b"01234567")
        assert bench.now_s - before_s == pytest.approx(0.005, abs=0.0005)

    @pytest.mark.parametrize("spoilt", [0, 1, 2, 3, 4, 5])
    def test_a_frame_with_a_wrong_byte_is_dropped_in_silence(self, bench, spoilt):
        frame = bytearray(frame_bytes(Kind.REQUEST, Op.ENABLE, b""))
        frame[spoilt] ^= 0x40
        bench.link.write(bytes(frame), bench.now_s)
        assert bench.pass_time(1.0) == b""
        bench.link.write(bytes(33), bench.now_s)  # whatever the reader believes to be in
        bench.pass_time(0.1)
        assert bench.ask(Ping(b"again")) == Pong(b"again")
        assert bench.board.dropped

    def test_inputs_and_outputs(self, bench):
        bench.device.set_input(3, True)
        assert bench.ask(Inputs()) == InputsRead(8)
        assert bench.ask(Outputs(5)) == OutputsSet(5)
        assert bench.board.outputs == 5
        assert esp32().ask(Outputs(5)) == OutputsSet(5)


def raw(bench, data):
    """Write bytes and return what comes back."""
    bench.link.write(data, bench.now_s)
    return bench.pass_time(0.1)


PING = frame_bytes(Kind.REQUEST, Op.PING, b"q")
PONG = frame_bytes(Kind.ANSWER, Op.PING, b"\x01q")


class TestReader:
    """Each row was seen on the ARDN_Operation example on an atmega328p in an AVR simulator."""

    @pytest.mark.parametrize(
        ("before", "is_lost"),
        [
            (bytes.fromhex("aa0100aa01"), True),  # a frame with a length of 0, and its check bytes
            (bytes.fromhex("aa0100"), False),
            (bytes.fromhex("aa"), True),  # doubled
            (bytes.fromhex("0001"), False),
        ],
    )
    def test_the_next_frame_is_lost_behind_some_bytes(self, bench, before, is_lost):
        assert raw(bench, before + PING) == (b"" if is_lost else PONG)
        assert raw(bench, PING) == PONG

    def test_a_short_payload_is_read_on_in_stale_bytes(self, bench):
        assert bench.ask(Outputs(5)) == OutputsSet(5)
        assert raw(bench, frame_bytes(Kind.REQUEST, Op.OUTPUTS, b""))[5:6] == b"\x05"
        raw(bench, frame_bytes(Kind.REQUEST, Op.MOVE_ABSOLUTE, b"\x09\x00\x32"))
        bench.pass_time(1.0)
        assert positions(bench) == (9, 0, 0, 0, 0, 0)


class TestMotion:
    def test_a_move_before_the_motors_are_on_is_an_error_and_moves_nothing(self):
        bench = RobkoBench()
        for request in (MoveRelative(axes(5)), MoveAbsolute(axes(5)), MoveSpeed(axes(5))):
            assert bench.ask(request).status is Status.ERROR
        bench.pass_time(1.0)
        assert positions(bench) == (0,) * 6

    def test_a_move_during_a_move_is_refused_with_the_axes_that_move(self, bench):
        bench.ask(MoveRelative(axes(40, 0, -40)))
        bench.pass_time(0.1)
        assert bench.ask(MoveRelative(axes(1))) == Busy(Op.MOVE_RELATIVE, 0b101)
        bench.pass_time(2.0)
        assert positions(bench) == (40, 0, -40, 0, 0, 0)

    def test_is_moving_answers_zero_just_behind_an_accepted_move_that_keeps_it_busy(self, bench):
        bench.ask(MoveRelative(axes(40)))
        assert bench.ask(IsMoving()) == Moving(0)
        assert isinstance(bench.ask(MoveRelative(axes(1))), Busy)
        bench.pass_time(0.01)
        assert bench.ask(IsMoving()) == Moving(1)

    @pytest.mark.parametrize("speed", [125, 200, 30_000])
    def test_no_axis_exceeds_125_steps_a_second(self, bench, speed):
        took_s, seen = run(bench, MoveRelative(axes(200, speed=speed)), step_s=0.001)
        per_chance = [b[0] - a[0] for a, b in zip(seen[1:], seen[9:], strict=False)]
        assert max(per_chance) == 1
        assert 200 / took_s < 125

    @pytest.mark.parametrize(
        ("speed", "relative_s", "absolute_s"),
        [(20, 0.586, 2.760), (50, 0.586, 1.200), (100, 0.586, 0.844)],
    )
    def test_fifty_steps_last_as_long_as_on_the_firmware(self, speed, relative_s, absolute_s):
        """From the first step to the last, in AVR cycles; the first comes within 8 ms."""
        for move, steps_s in ((MoveRelative, relative_s), (MoveAbsolute, absolute_s)):
            bench = RobkoBench().enabled()
            took_s, _ = run(bench, move(axes(50, speed=speed)), step_s=0.001)
            assert 0.97 * steps_s <= took_s <= 1.03 * steps_s + 0.01

    def test_the_top_speed_of_an_absolute_move_sticks_to_its_axis(self, bench):
        run(bench, MoveAbsolute(axes(10, 10, speed=30)))
        one_s, _ = run(bench, MoveRelative(axes(50, speed=100)))
        assert one_s == pytest.approx(50 / 25, abs=0.1)  # as every motion at 30
        bench.board.reset()
        bench.enabled()
        reset_s, _ = run(bench, MoveRelative(axes(50, speed=100)))
        assert reset_s < 0.7

    def test_a_top_speed_of_zero_leaves_an_axis_hanging(self, bench):
        assert bench.ask(MoveAbsolute(Axes((0,) * 6))).status is Status.OK
        assert bench.ask(MoveRelative(axes(50))).status is Status.OK
        bench.pass_time(60.0)
        assert positions(bench) == (1, 0, 0, 0, 0, 0)
        assert bench.ask(Stop()).status is Status.OK
        assert bench.ask(IsMoving()) == Moving(1)
        assert bench.ask(MoveAbsolute(axes(9))) == Busy(Op.MOVE_ABSOLUTE, 1)
        assert bench.ask(MoveSpeed(Axes((0,) * 6))).status is Status.OK
        assert bench.ask(IsMoving()) == Moving(0)
        run(bench, MoveAbsolute(axes(-9)))
        assert positions(bench) == (-9, 0, 0, 0, 0, 0)

    def test_a_resting_axis_that_gets_a_speed_makes_a_step_and_takes_it_back(self, bench):
        speeds = (100, 100, 0, 0, 0, 0)
        _, seen = run(bench, MoveAbsolute(Axes((10, 0, 0, 0, 0, 0), speeds)))
        assert {one[1] for one in seen} == {0, 1}
        assert positions(bench) == (10, 0, 0, 0, 0, 0)

    def test_an_absolute_move_takes_a_wrapped_count_for_another(self, bench):
        bench.device.board.count_from((40_000, 0, 0, 0, 0, 0))
        bench.ask(MoveAbsolute(Axes(positions(bench), (100, 0, 0, 0, 0, 0))))
        bench.pass_time(2.0)
        assert bench.board.drive.counts[0] < 39_900

    @pytest.mark.parametrize("move", [MoveRelative, MoveAbsolute])
    def test_the_retrofit_obeys_no_speed(self, move):
        took_s = {run(esp32(), move(axes(200, speed=speed)))[0] for speed in (20, 100, 30_000)}
        assert max(took_s) == pytest.approx(min(took_s))

    def test_positions_are_true_while_it_moves(self, bench):
        start = bench.device.world.motors
        bench.ask(MoveRelative(axes(-60, 30)))
        for _ in range(5):
            bench.pass_time(0.1)
            told = positions(bench)
            came = bench.device.world.motors - start
            assert all(abs(a - b) <= 1 for a, b in zip(told, came, strict=True))


class TestStopping:
    def test_a_stop_ramps_down(self):
        bench = esp32(top_speed_hz=140.0)
        bench.ask(MoveRelative(axes(300, speed=140)))
        bench.pass_time(1.0)
        before = bench.device.registers[0]
        assert bench.ask(Stop()).status is Status.OK
        bench.pass_time(1.0)
        assert not bench.device.moving
        assert positions(bench)[0] - before == pytest.approx(140**2 / 1400, abs=2)

    @pytest.mark.parametrize(("speed", "steps"), [(125, 12), (100, 8), (50, 2), (20, 1)])
    def test_an_absolute_move_is_stopped_in_as_few_steps_as_on_the_firmware(
        self, bench, speed, steps
    ):
        bench.ask(MoveAbsolute(axes(300, speed=speed)))
        bench.pass_time(2.0)
        before = bench.device.registers[0]
        bench.ask(Stop())
        bench.pass_time(1.0)
        assert positions(bench)[0] - before == pytest.approx(steps, abs=1)
        assert not bench.device.moving

    def test_a_relative_move_goes_on_as_far_as_it_has_come(self, bench):
        bench.ask(MoveRelative(axes(900)))
        bench.pass_time(2.0)
        before = bench.device.registers[0]
        bench.ask(Stop())
        bench.pass_time(9.0)
        assert positions(bench)[0] == pytest.approx(2 * before, rel=0.05)

    def test_an_axis_by_speed_runs_on_when_the_host_falls_silent_and_stop_does_not_end_it(
        self, bench
    ):
        assert bench.ask(MoveSpeed(Axes((0,) * 6, (50, 0, 0, 0, 0, 0)))).status is Status.OK
        bench.pass_time(1.0)
        assert positions(bench)[0] == pytest.approx(42, abs=1)
        bench.ask(Stop())
        bench.pass_time(2.08)
        assert positions(bench)[0] == pytest.approx(94, abs=1)  # slower, but for ever
        bench.pass_time(100.0)
        assert positions(bench)[0] == pytest.approx(94 + 100 * 24.8, rel=0.01)
        bench.ask(MoveSpeed(Axes((0,) * 6)))
        bench.pass_time(1.0)
        stands = positions(bench)
        bench.pass_time(1.0)
        assert positions(bench) == stands

    def test_disabled_motors_let_the_arm_sag_and_the_counts_go_on(self, bench):
        bench.ask(MoveRelative(axes(60)))
        bench.pass_time(0.3)
        height_mm = bench.device.world.pose.z_mm
        bench.ask(Disable())
        assert bench.device.world.pose.z_mm < height_mm - 5
        base = bench.device.world.motors[0]
        bench.pass_time(2.0)
        assert positions(bench)[0] == 60
        assert bench.device.world.motors[0] == base


class TestPower:
    def test_a_watchdog_that_is_not_fed_switches_the_motors_off(self):
        bench = esp32(watchdog_s=3.0)
        for feed in (Ping(), Inputs(), Position()):
            bench.pass_time(2.0)
            assert bench.ask(feed).status is Status.OK
        bench.pass_time(2.0)
        bench.ask(IsMoving())  # feeds nothing
        assert bench.board.enabled
        bench.pass_time(1.2)
        assert not bench.board.enabled
        assert not bench.device.world.energised
        assert bench.ask(MoveRelative(axes(1))).status is Status.ERROR
