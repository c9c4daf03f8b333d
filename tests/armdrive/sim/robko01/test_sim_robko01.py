"""The simulated Robko 01 does what was seen of the firmware, with its numbers."""

import pytest
from amounts import every_row
from sim_bench import RobkoBench, axes

from armdrive.sim.robko01 import ESP32, RobkoQuirks, SimRobkoBoard
from firmware_protocol.robko01 import (
    Axes,
    Busy,
    Clear,
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

ZEROS = (0,) * 6


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


# -- The wire --------------------------------------------------------------------------------------


def test_a_ping_goes_round_in_five_milliseconds_and_inputs_and_outputs_are_bytes(bench):
    before_s = bench.now_s
    assert bench.ask(Ping(b"01234567")) == Pong(b"01234567")
    assert bench.now_s - before_s == pytest.approx(0.005, abs=0.0005)
    bench.device.set_input(3, True)
    assert bench.ask(Inputs()) == InputsRead(8)
    assert bench.ask(Outputs(5)) == OutputsSet(5)
    assert bench.board.outputs == 5


def raw(bench, data):
    """Write bytes and return what comes back."""
    bench.link.write(data, bench.now_s)
    return bench.pass_time(0.1)


PING = frame_bytes(Kind.REQUEST, Op.PING, b"q")
PONG = frame_bytes(Kind.ANSWER, Op.PING, b"\x01q")


@every_row("spoilt", range(6))
def test_a_frame_with_a_wrong_byte_is_dropped_in_silence(spoilt):
    bench = RobkoBench()
    frame = bytearray(PING)
    frame[spoilt] ^= 0x40
    assert raw(bench, bytes(frame)) == b""
    raw(bench, bytes(33))  # whatever the reader believes to be in
    assert raw(bench, PING) == PONG


@every_row(
    "before, is_lost",
    [
        (bytes.fromhex("aa0100aa01"), True),  # a frame with a length of 0, and its check bytes
        (bytes.fromhex("aa0100"), False),
        (bytes.fromhex("aa"), True),  # doubled
        (bytes.fromhex("0001"), False),
    ],
)
def test_the_next_frame_is_lost_behind_some_bytes(before, is_lost):
    """Seen on the ARDN_Operation example, as short payloads are below."""
    bench = RobkoBench()
    assert raw(bench, before + PING) == (b"" if is_lost else PONG)
    assert raw(bench, PING) == PONG


def test_a_short_payload_is_read_on_in_stale_bytes(bench):
    assert bench.ask(Outputs(5)) == OutputsSet(5)
    assert raw(bench, frame_bytes(Kind.REQUEST, Op.OUTPUTS, b""))[5:6] == b"\x05"
    raw(bench, frame_bytes(Kind.REQUEST, Op.MOVE_ABSOLUTE, b"\x09\x00\x32"))
    bench.pass_time(1.0)
    assert positions(bench) == (9, 0, 0, 0, 0, 0)


# -- Motion ----------------------------------------------------------------------------------------


def test_a_move_before_the_motors_are_on_is_an_error_and_moves_nothing():
    bench = RobkoBench()
    for request in (MoveRelative(axes(5)), MoveAbsolute(axes(5)), MoveSpeed(axes(5))):
        assert bench.ask(request).status is Status.ERROR
    bench.pass_time(1.0)
    assert positions(bench) == ZEROS


def test_a_move_is_reported_as_none_at_first_and_refuses_others_until_it_ends(bench):
    start = bench.device.world.motors
    bench.ask(MoveAbsolute(axes(40, 0, -40)))
    assert bench.ask(IsMoving()) == Moving(0)
    assert bench.ask(MoveAbsolute(axes(1))) == Busy(Op.MOVE_ABSOLUTE, 0b101)
    bench.pass_time(0.01)
    assert bench.ask(IsMoving()) == Moving(0b101)
    for _ in range(5):
        bench.pass_time(0.1)
        came = bench.device.world.motors - start
        assert all(abs(a - b) <= 1 for a, b in zip(positions(bench), came, strict=True))
    bench.pass_time(2.0)
    assert positions(bench) == (40, 0, -40, 0, 0, 0)


@every_row("speed", [125, 200, 30_000])
def test_no_axis_exceeds_125_steps_a_second(speed):
    took_s, seen = run(RobkoBench().enabled(), MoveAbsolute(axes(200, speed=speed)), step_s=0.001)
    per_chance = [b[0] - a[0] for a, b in zip(seen[1:], seen[9:], strict=False)]
    assert max(per_chance) == 1
    assert 200 / took_s < 125


@every_row("speed, seen_s", [(20, 2.760), (50, 1.200), (100, 0.844)])
def test_fifty_steps_last_as_long_as_on_the_firmware(speed, seen_s):
    """From the first step to the last, in AVR cycles; the first comes within 8 ms."""
    took_s, _ = run(RobkoBench().enabled(), MoveAbsolute(axes(50, speed=speed)), step_s=0.001)
    assert 0.97 * seen_s <= took_s <= 1.03 * seen_s + 0.01


def test_operation_6_is_as_fast_as_the_last_operation_7_and_clear_zeroes_the_positions(bench):
    for top, seen_s in ((None, 0.586), (30, 2.0)):
        if top:
            run(bench, MoveAbsolute(axes(10, speed=top)))
        took_s, _ = run(bench, MoveRelative(axes(-50, speed=100)))
        assert took_s == pytest.approx(seen_s, abs=0.1)
    assert positions(bench) == (-40, 0, 0, 0, 0, 0)
    bench.ask(Clear())
    assert positions(bench) == ZEROS
    bench.board.reset()
    took_s, _ = run(bench.enabled(), MoveRelative(axes(50, speed=100)))
    assert took_s == pytest.approx(0.586, abs=0.1)


def test_an_axis_that_an_operation_6_left_hanging_is_freed_by_speeds_of_zero(bench):
    assert bench.ask(MoveAbsolute(Axes(ZEROS))).status is Status.OK  # a top speed of 0
    assert bench.ask(MoveRelative(axes(50))).status is Status.OK
    bench.pass_time(60.0)
    assert positions(bench) == (1, 0, 0, 0, 0, 0)
    assert bench.ask(Stop()).status is Status.OK
    assert bench.ask(MoveAbsolute(axes(9))) == Busy(Op.MOVE_ABSOLUTE, 1)
    assert bench.ask(MoveSpeed(Axes(ZEROS))).status is Status.OK
    assert bench.ask(IsMoving()) == Moving(0)
    run(bench, MoveAbsolute(axes(-9)))
    assert positions(bench) == (-9, 0, 0, 0, 0, 0)


def test_a_resting_axis_that_gets_a_speed_makes_a_step_and_takes_it_back(bench):
    _, seen = run(bench, MoveAbsolute(Axes((10, 0, 0, 0, 0, 0), (100, 100, 0, 0, 0, 0))))
    assert {one[1] for one in seen} == {0, 1}
    assert positions(bench) == (10, 0, 0, 0, 0, 0)


def test_an_absolute_move_takes_a_wrapped_count_for_another(bench):
    bench.device.board.count_from((40_000, 0, 0, 0, 0, 0))
    bench.ask(MoveAbsolute(Axes(positions(bench), (100, 0, 0, 0, 0, 0))))
    bench.pass_time(2.0)
    assert bench.board.drive.counts[0] < 39_900


def test_the_retrofit_obeys_no_speed():
    took_s = {run(esp32(), MoveAbsolute(axes(200, speed=speed)))[0] for speed in (20, 100, 30_000)}
    assert max(took_s) == pytest.approx(min(took_s))


# -- Stopping --------------------------------------------------------------------------------------


@every_row("speed, steps", [(125, 12), (100, 8), (50, 2), (20, 1)])
def test_a_move_is_stopped_in_as_few_steps_as_on_the_firmware(speed, steps):
    bench = RobkoBench().enabled()
    bench.ask(MoveAbsolute(axes(300, speed=speed)))
    bench.pass_time(2.0)
    before = bench.device.registers[0]
    bench.ask(Stop())
    bench.pass_time(1.0)
    assert positions(bench)[0] - before == pytest.approx(steps, abs=1)
    assert not bench.device.moving


def test_a_stopped_operation_6_goes_on_as_far_as_it_has_come(bench):
    bench.ask(MoveRelative(axes(900)))
    bench.pass_time(2.0)
    before = bench.device.registers[0]
    bench.ask(Stop())
    bench.pass_time(9.0)
    assert positions(bench)[0] == pytest.approx(2 * before, rel=0.05)


def test_an_axis_by_speed_runs_on_when_the_host_falls_silent_and_stop_does_not_end_it(bench):
    assert bench.ask(MoveSpeed(Axes(ZEROS, (50, 0, 0, 0, 0, 0)))).status is Status.OK
    bench.pass_time(1.0)
    assert positions(bench)[0] == pytest.approx(42, abs=1)
    bench.ask(Stop())
    bench.pass_time(2.08)
    assert positions(bench)[0] == pytest.approx(94, abs=1)  # slower, but for ever
    bench.pass_time(100.0)
    assert positions(bench)[0] == pytest.approx(94 + 100 * 24.8, rel=0.01)
    bench.ask(MoveSpeed(Axes(ZEROS)))
    bench.pass_time(1.0)
    stands = positions(bench)
    bench.pass_time(1.0)
    assert positions(bench) == stands


def test_disabled_motors_let_the_arm_sag_and_the_counts_go_on(bench):
    bench.ask(MoveAbsolute(axes(60)))
    bench.pass_time(0.3)
    height_mm = bench.device.world.pose.z_mm
    bench.ask(Disable())
    assert bench.device.world.pose.z_mm < height_mm - 5
    base = bench.device.world.motors[0]
    bench.pass_time(2.0)
    assert positions(bench)[0] == 60
    assert bench.device.world.motors[0] == base


def test_a_watchdog_that_is_not_fed_switches_the_motors_off():
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
