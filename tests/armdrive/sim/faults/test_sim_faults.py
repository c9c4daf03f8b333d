"""Faults on request befall a simulated arm: its wire, its power, its motors, its switches."""

import random

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st
from sim_bench import SilentDevice, WireBench

from armdrive.connect.target import simulated_config
from armdrive.errors import BadRequest, LinkLost
from armdrive.registry import simulate
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.device import SaysEmergencies, SimDevice
from armdrive.sim.faults import (
    FAULTS,
    Cable,
    Faults,
    faults_of,
    parse_option,
    parse_words,
)
from armdrive.sim.mechanics.motors import SwitchState
from armdrive.sim.teachmover import TeachMoverBoard
from armdrive.sim.wire import (
    Amount,
    DeviceLine,
    Rule,
    WireDirection,
    changed,
    lost,
    repeated,
)

STEP = b"@STEP 240,470,0,0,0,0,0\r"


class Wired(WireBench):
    """A TeachMover, and a host that writes and reads bytes."""

    def __init__(self):
        self.twin = simulate(simulated_config("teachmover"))
        self.faults = self.twin.faults
        super().__init__(self.twin.device, self.twin.link)

    def ask(self, data, seconds=0.2):
        self.send(data)
        return self.pass_time(seconds)


@pytest.fixture
def wired():
    return Wired()


READ = b"@READ\r"
ANSWER = b"1\r0,0,0,0,0,0,0\r"


class TestOnTheWire:
    def test_the_nth_byte_from_the_host_is_lost_and_no_other(self, wired):
        wired.faults.add("drop", "#8", side="host")
        assert wired.ask(READ) == ANSWER
        assert wired.faults.active == ("drop #8",)
        assert wired.ask(READ) == b"0\r"
        assert wired.faults.active == ()
        assert wired.ask(READ) == ANSWER

    def test_the_next_message_is_lost_or_comes_twice(self, wired):
        wired.faults.add("drop", "next", side="device")
        assert wired.ask(READ) == b""
        wired.faults.add("duplicate", "next", side="host")
        assert wired.ask(READ) == ANSWER * 2
        wired.faults.add("duplicate", "#1", side="device")
        assert wired.ask(READ) == b"1" + ANSWER

    def test_one_bit_of_one_byte_is_changed(self, wired):
        wired.faults.add("corrupt", "next", side="device")
        heard = wired.ask(READ)
        bits = [(a ^ b).bit_count() for a, b in zip(heard, ANSWER, strict=True)]
        assert sorted(bits)[-2:] == [0, 1]

    def test_a_late_answer_comes_as_much_later(self, wired):
        wired.faults.add("delay", 1.5, side="device")
        assert wired.ask(READ, 1.5) == b""
        assert wired.pass_time(0.1) == ANSWER

    def test_it_says_nothing_for_a_while(self, wired):
        wired.faults.add("mute", for_s=4.0)
        assert wired.ask(STEP, 2.0) == b""
        assert wired.twin.device.registers[0] == 470  # it has heard and obeyed
        wired.pass_time(2.0)
        assert wired.ask(READ) == b"1\r470,0,0,0,0,0,0\r"

    def test_it_says_noise_and_the_same_one_again(self, wired):
        wired.faults.add("garbage", 20, seed=7)
        wired.faults.add("garbage", 20, seed=7)
        heard = wired.pass_time(1.0)
        assert len(heard) == 40
        assert heard[:20] == heard[20:]

    def test_the_cable_is_pulled_and_put_back_each_at_its_time(self, wired):
        wired.faults.add("unplug", after_s=1.0)
        wired.faults.add("replug", "as", "another wire", after_s=3.0)
        assert wired.ask(READ, 0.9) == ANSWER
        wired.pass_time(0.2)
        with pytest.raises(LinkLost):
            wired.pass_time(0.0)
        with pytest.raises(LinkLost):
            wired.pass_time(2.0)
        assert wired.ask(READ) == ANSWER
        assert "another wire" in wired.twin.link.description

    def test_a_late_message_is_lost_with_the_cable(self, wired):
        wired.faults.add("delay", 1.0, "next", side="host")
        wired.send(STEP)
        wired.faults.add("unplug", for_s=0.1)
        with pytest.raises(LinkLost):
            wired.pass_time(0.3)
        assert wired.ask(READ) == ANSWER
        wired.pass_time(3.0)
        assert wired.ask(READ) == ANSWER

    def test_chance_is_the_same_for_the_same_seed(self):
        said = []
        for seed in (1, 1, 2):
            wired = Wired()
            wired.faults.add("drop", 0.2, side="device", seed=seed)
            said.append(b"".join(wired.ask(READ) for _ in range(20)))
        assert said[0] == said[1] != said[2]
        assert len(said[0]) == pytest.approx(0.8 * 20 * len(ANSWER), rel=0.15)


class TestOnTheArm:
    def test_a_brown_out_loses_the_registers_and_lets_the_arm_sag(self, wired):
        wired.ask(STEP, 2.0)
        height = wired.twin.world.pose.z_mm
        wired.faults.add("brown-out", after_s=1.0)
        wired.pass_time(1.2)
        assert not wired.twin.device.powered
        assert wired.ask(READ) == b""
        wired.pass_time(0.5)
        assert wired.twin.world.pose.z_mm < height - 5
        assert wired.ask(READ) == ANSWER
        wired.twin.device.power_off()
        wired.faults.add("brown-out")
        wired.pass_time(1.0)
        assert not wired.twin.device.powered

    def test_after_two_brown_outs_of_which_one_began_in_the_other_the_power_is_on(self, wired):
        wired.faults.add("brown-out")
        wired.faults.add("brown-out", after_s=0.2)
        wired.pass_time(1.0)
        assert wired.twin.device.powered

    @pytest.mark.parametrize("motor", ["1", "base"])
    def test_lost_steps_are_counted_and_not_made(self, wired, motor):
        before = wired.twin.world.motors
        wired.faults.add("lose-steps", motor, 30)
        wired.ask(STEP, 2.0)
        wired.ask(b"@STEP 240,-20,5,0,0,0,0\r", 2.0)
        assert wired.faults.active == ()
        wired.faults.add("lose-steps", motor, 30)
        assert wired.faults.end() == (f"lose-steps {motor} 30",)
        wired.ask(b"@STEP 240,0,1,0,0,0,0\r", 2.0)
        wired.ask(b"@STEP 240,20,-1,0,0,0,0\r", 2.0)
        wired.ask(b"@STEP 240,-20,0,0,0,0,0\r", 2.0)
        assert wired.twin.device.registers == (450, 5, 0, 0, 0, 0)
        assert wired.twin.world.motors - before == (420, 5, 0, 0, 0, 0)

    def test_a_stalled_motor_does_not_follow_until_it_is_freed(self, wired):
        before = wired.twin.world.motors
        wired.faults.add("stall", 1)
        wired.faults.add("stall", "base")  # the same motor
        wired.ask(STEP, 2.0)
        assert wired.twin.world.motors == before
        wired.twin.device.push((7, 0, 0, 0, 0, 0))
        assert wired.twin.world.motors - before == (7, 0, 0, 0, 0, 0)
        assert wired.faults.end("stall") == ("stall base",)
        wired.ask(STEP, 2.0)
        assert wired.twin.world.motors - before == (477, 0, 0, 0, 0, 0)


class Board(TeachMoverBoard):
    """A board that has what the TeachMover lacks."""

    title = "board"

    def __init__(self):
        super().__init__()
        self.resets = 0
        self.switches = {}

    def reset(self):
        self.resets += 1

    def set_switch(self, axis, state):
        self.switches[axis] = state


def faults_for(device):
    def put_back(_):
        raise BadRequest("it does not fit")

    line = DeviceLine(device, None)
    return Faults(device, line, Cable(line, lambda: None, put_back))


def test_a_board_resets_and_its_switches_stick():
    board = Board()
    device = SimDevice(board)
    faults = faults_for(device)
    faults.add("reset")
    faults.add("switch", 2, "closed", for_s=1.0)
    assert (board.resets, board.switches) == (1, {1: SwitchState.CLOSED})
    device.transmit(1.5)
    assert board.switches == {1: SwitchState.FREE}
    assert faults.active == ()
    with pytest.raises(BadRequest, match="a switch is free, open, closed"):
        faults.add("switch", 2, "stuck")
    for state in ("open", "closed", "free"):
        faults.add("switch", 2, state)
        assert board.switches == {1: SwitchState(state)}
        assert faults.active == (() if state == "free" else (f"switch 2 {state}",))


def test_a_scheduled_fault_that_fails_is_reported():
    board = Board()
    device = SimDevice(board)
    faults = faults_for(device)
    faults.add("replug", after_s=1.0)
    device.transmit(2.0)
    assert faults.troubles == ["it does not fit"]


def test_a_kind_of_device_can_have_what_it_is_made_for():
    of_drives = (DrivesBoard, SaysEmergencies)
    on_a_bus = {name for name, kind in FAULTS.items() if kind.needs in of_drives}
    assert on_a_bus
    assert {kind.name for kind in faults_of(Board)} == set(FAULTS) - on_a_bus
    lacking = set(FAULTS) - {kind.name for kind in faults_of(TeachMoverBoard)}
    assert lacking == {"reset", "switch"} | on_a_bus


@every_row(
    "line, said",
    [
        ("dorp 0.1", "did you mean 'drop'?"),
        ("drop", "drop P|#N|next"),
        ("drop often", "not a number"),
        ("drop 2", "from 0 to 1"),
        ("drop #0", "from #1"),
        ("drop 0.1 from=nobody", "not from 'nobody'"),
        ("drop 0.1 sed=3", "write it like this: drop"),
        ("mute for=-1", "0 or more"),
        ("drop 0.1 seed=one", "not a whole number"),
        ("drop 0.1 @-1", "0 or more"),
        ("drop 0.1 @nan", "not a finite number"),
        ("drop 0.1 @soon", "not a number"),
        ("delay -1", "above 0"),
        ("garbage 0", "1 to 4096"),
        ("reset", "the simulated TeachMover has no reset"),
        ("switch 1 open", "no limit switches"),
        ("overtake next", "no drives on a bus"),
        ("lose-steps 7 5", "1 to 6 or base"),
        ("lose-steps 1 -5", "a count is from 1"),
        ("stall", "stall MOTOR"),
        ("stall x", "1 to 6 or base"),
        ("@5", "name a fault"),
    ],
)
def test_a_fault_that_cannot_be_is_refused_at_once(line, said):
    faults = faults_for(SimDevice(TeachMoverBoard()))
    with pytest.raises(BadRequest) as refused:
        faults.ask(parse_words(line.split()))
    assert said in str(refused.value)
    assert faults.active == ()


@every_row(
    "option, words",
    [
        ("mute", "mute"),
        ("drop:0.01,from=host,seed=3@5", "drop 0.01 from=host seed=3 @5"),
        ("delay:0.2,next,for=1.5", "delay 0.2 next for=1.5"),
        ("replug:as,/tmp/arm2@8", "replug as /tmp/arm2 @8"),
        ("switch:2,closed", "SWITCH 2 closed"),
    ],
)
def test_a_fault_is_the_same_on_the_command_line_and_at_the_console(option, words):
    assert parse_option(option) == parse_words(words.split())


messages = st.lists(st.binary(min_size=1, max_size=12), max_size=8)
seeds = st.integers(0, 1000)


def through(effect, amount, data):
    lane = WireDirection()
    lane.rules.append(Rule(amount, effect))
    return b"".join(lane.passed(one, 0.0)[0] for one in data)


def amount(seed=0, **which):
    return Amount(random.Random(seed), **which)


@given(messages, seeds, st.floats(0, 1))
def test_dropped_bytes_are_missing_and_the_rest_keeps_its_order(data, seed, share):
    rest = iter(b"".join(data))
    assert all(byte in rest for byte in through(lost, amount(seed, share=share), data))


@given(messages, seeds, st.floats(0, 1))
def test_changed_data_keep_their_length_and_repeated_data_are_complete(data, seed, share):
    whole = b"".join(data)
    effect = changed(random.Random(seed))
    assert len(through(effect, amount(seed, share=share), data)) == len(whole)
    rest = iter(through(repeated, amount(seed, share=share), data))
    assert all(byte in rest for byte in whole)


@given(messages, st.integers(1, 60))
def test_the_nth_byte_is_that_byte_however_it_comes(data, number):
    whole = b"".join(data)
    assert through(lost, amount(nth=number), data) == whole[: number - 1] + whole[number:]


@given(messages, st.floats(0.01, 5.0), st.floats(0, 1), seeds)
def test_late_messages_come_whole_and_in_order(data, delay_s, share, seed):
    line = DeviceLine(SilentDevice(), None)
    line.faults.host.rules.append(Rule(amount(seed, share=share), late_s=delay_s))
    for number, one in enumerate(data):
        line.send(one, 0.3 * number)
    line.advance(0.3 * len(data) + delay_s)
    assert [one for _, one in line.device.received] == data
    for number, (time_s, _) in enumerate(line.device.received):
        assert 0.3 * number <= time_s <= 0.3 * number + delay_s
