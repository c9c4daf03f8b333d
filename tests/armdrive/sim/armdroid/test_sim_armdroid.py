"""The simulated Armdroid does what the serial driver sketch does, its surprises included."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from sim_bench import BYTE_S, TextBench

from armdrive.sim.armdroid import ArmdroidBoard, ArmdroidQuirks
from armdrive.sim.device import SimDevice
from armdrive.sim.mechanics.motors import MotorRack

ZERO = "offsets = 0,0,0,0,0,0\r\n"
WELCOME = "Welcome, Armdroid!\r\n"


def bench_of(**quirks):
    """Return a board that takes no time for a character, unless its quirks say so."""
    quirks = ArmdroidQuirks(**({"character_s": 0.0} | quirks))
    return TextBench(SimDevice(ArmdroidBoard(quirks=quirks)))


@pytest.fixture
def bench():
    return bench_of()


def moved(bench, call):
    before = bench.device.world.motors
    call()
    return tuple(bench.device.world.motors - before)


class TestMotion:
    def test_the_answer_comes_when_the_motion_has_ended(self, bench):
        text = "1,2,3,4-,5,60D"
        bench.send(text)
        assert bench.hear(59 * 0.012) == ""
        answer = "offsets = 1,2,3,-4,5,60\r\n"
        assert bench.hear((len(text) + len(answer)) * BYTE_S) == answer

    def test_channel_1_is_the_gripper_and_6_the_base(self, bench):
        assert moved(bench, lambda: bench.ask("1,20d")) == (0, 0, 0, 0, 0, 20)
        assert moved(bench, lambda: bench.ask("6,20-d")) == (-20, 0, 0, 0, 0, 0)

    @pytest.mark.parametrize(
        ("rpm", "interval_s"), [(100, 0.012), (250, 0.005), (240, 0.005), (9999, 0.00045)]
    )
    def test_a_speed_is_worth_whole_milliseconds(self, bench, rpm, interval_s):
        assert bench.ask(f"{rpm}s") == f"speed = {rpm}\r\n"
        bench.send("6,101d")
        bench.hear(6 * BYTE_S + 99.5 * interval_s)
        assert bench.board.offsets[5] == 100

    def test_at_speed_zero_a_motion_never_ends(self, bench):
        assert bench.ask("0s") == "speed = 0\r\n"
        assert bench.ask("6,3d", 3600.0) == ""
        assert bench.board.offsets[5] == 1

    def test_home_goes_back_the_whole_way(self, bench):
        bench.ask("5,6,7,8,9,200D", 4.0)
        assert moved(bench, lambda: bench.ask("h", 4.0)) == (-200, -9, -8, -7, -6, -5)

    def test_offsets_wrap_at_16_bits_where_the_arm_does_not(self, bench):
        bench.device.board.count_from((32760, 0, 0, 0, 0, 0))
        assert bench.ask("6,20d") == "offsets = 0,0,0,0,0,-32756\r\n"


class TestCharacters:
    def test_a_lost_comma_makes_a_motion_of_a_thousand_steps(self, bench):
        bench.send("0,0,0,11,11,12D".replace("11,11", "1111"))
        assert bench.hear(13.0) == ""
        assert bench.hear(1.0) == "offsets = 0,0,0,1111,0,12\r\n"

    def test_characters_beyond_the_buffer_during_a_motion_are_lost(self, bench):
        bench.send("6,50d")
        bench.hear(0.1)
        bench.ask("7" * 63 + "o", 3.0)
        assert bench.board.lost_bytes == 1
        assert not bench.device.busy

    def test_a_board_with_native_usb_takes_ten_milliseconds_for_a_character(self):
        bench = bench_of(character_s=0.010)
        bench.send("250s")
        answer = "speed = 250\r\n"
        took_s = 4 * (BYTE_S + 0.010) + len(answer) * BYTE_S
        assert bench.hear(took_s - 0.006) != answer
        assert bench.hear(0.006).endswith("\n")

    @pytest.mark.parametrize(
        ("said", "answer"),
        [
            ("v", "firmware version = 2.0/protocol = 1.0a\r\n"),
            ("100200g", f"debug = 0 0 0 0 0 {100200 - 131072}\r\n"),  # wraps at 16 bits
        ],
    )
    def test_what_it_tells_of_itself(self, bench, said, answer):
        assert bench.ask(said) == answer


class TestCurrent:
    def test_without_torque_the_arm_sags_and_a_motion_brings_it_back(self, bench):
        height = bench.device.world.pose.z_mm
        assert bench.ask("0t") == "torque = disabled\r\n"
        assert bench.device.world.pose.z_mm < height - 5
        assert moved(bench, lambda: bench.ask("1t")) == (0,) * 6
        assert bench.device.world.energised
        bench.ask("0t")
        bench.ask("6,1d")
        assert bench.device.world.energised


class TestOpening:
    def test_a_board_with_native_usb_greets_and_forgets_arguments(self, bench):
        bench.ask("5,6,7,8,9,20D")
        bench.board.opened()
        assert bench.hear() == WELCOME
        assert bench.board.details()["kept"] == [0] * 5
        assert bench.board.offsets == (5, 6, 7, 8, 9, 20)

    def test_a_board_in_motion_does_not_see_who_opens_its_port(self, bench):
        bench.send("6,50d")
        bench.hear(0.2)
        bench.board.opened()
        assert WELCOME not in bench.hear()

    def test_another_board_is_reset_and_deaf_for_a_while(self):
        bench = bench_of(native_usb=False)
        bench.ask("250s6,20d7")
        bench.board.opened()
        assert bench.ask("o", 1.0) == ""
        bench.hear(1.0)
        assert bench.ask("o") == ZERO
        assert bench.device.board.details() == {"rpm": 100, "speed_error": 0.0, "kept": [0] * 5}
        assert bench.ask("5g").startswith("debug = 0 0 0 0 0 5\r")


STEPS = st.tuples(*[st.integers(-60, 60)] * 6)


@given(STEPS, st.floats(0.001, 0.05), st.lists(st.floats(0.0, 4.0), max_size=8))
def test_each_motor_goes_its_own_way_without_turning_back_and_ends_on_it(steps, interval, looks):
    rack = MotorRack((0,) * 6)
    rack.start(steps, interval, 0.0, in_proportion=False)
    before = (0,) * 6
    for look in sorted(looks):
        now = rack.positions(look)
        assert all(abs(b) <= abs(a) <= abs(d) for a, b, d in zip(now, before, steps, strict=True))
        in_step = min(math.floor(look / interval + 1e-6) + 1, 60)
        assert max(map(abs, now)) <= in_step
        before = now
    done_s = rack.done_s
    rack.settle(done_s)
    assert not rack.moving
    assert rack.positions(done_s) == steps
    assert done_s == pytest.approx(max(max(map(abs, steps)) - 1, 0) * interval)
