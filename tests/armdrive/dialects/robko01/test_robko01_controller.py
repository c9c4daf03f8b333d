"""Robko 01 driven through its controller: frames, pacing, stops."""

import math

import pytest
from amounts import amount, every_row, in_pairs
from driver_bench import SerialBench
from faults import Rule, garbled, instead, late_by, lost, twice
from hypothesis import example, given, settings
from hypothesis import strategies as st
from robko_bench import FrameLink, of, op_of, ready_robko, robko_config

from armdrive import Jog
from armdrive.dialects.robko01.controller import RobkoController
from armdrive.dialects.robko01.motion import OVERSHOOT_STEPS
from armdrive.dialects.robko01.settings import (
    BOARDS,
    SLACK_S,
    TOLD_BY_S,
    Pacing,
    RobkoBoard,
    RobkoSettings,
)
from armdrive.dialects.speed_table import PaceMeter
from armdrive.errors import ArmError, DeviceFault, NoAnswer, Stopped
from armdrive.registry import dialect
from armdrive.registry.arm_files import parse_arm
from armdrive.sim.device import SimDevice
from armdrive.sim.mechanics.accelstepper import UncoordinatedRack
from armdrive.sim.robko01 import AVR, RobkoQuirks, SimRobkoBoard
from armdrive.status import State, Trust
from armdrive.tasks import (
    AlertKind,
    Done,
    MoveBy,
    Progress,
    ProtocolWarning,
    ReadPosition,
    Registers,
    RequestRejected,
    SwitchOn,
)
from firmware_protocol.robko01 import Acknowledged, Op, Status
from firmware_protocol.robko01.messages import encode_answer
from kinematics import Motors, Pose


class Script(SerialBench):
    """A controller on the wire of a simulated board, one request at a time."""

    def __init__(self, **options):
        controller = RobkoController(dialect("robko01").abilities, robko_config())
        super().__init__(controller, SimDevice(SimRobkoBoard(**options)))

    @property
    def oddities(self):
        return [event for event in self.heard if isinstance(event, ProtocolWarning)]

    def ask(self, request, *, stop_after_s=math.inf):
        """Return the reply."""
        self.at_s[self.now_s + stop_after_s] = lambda: self.controller.stop(hard=False)
        return self.do(request)


def enabled(**options):
    return Script(**options).ready()


MOVE = MoveBy(Motors((30, -16, 0, 4, 0, 0)), 125.0)


class TestRequests:
    def test_registers_and_inputs_are_read_together(self):
        script = Script()
        script.device.board.count_from((1, -2, 3, -4, 5, -6))
        script.device.set_input(2, True)
        assert script.ask(ReadPosition()) == Registers(Motors((1, -2, 3, -4, 5, -6)), 4)

    def test_a_move_is_done_when_the_positions_are_its_targets(self):
        script = enabled()
        assert script.ask(MOVE) == Done()
        assert script.device.registers == MOVE.steps
        seen = [each.registers.positions for each in script.heard if isinstance(each, Progress)]
        assert len(seen) > 5
        assert seen == sorted(seen, key=lambda at: at[0])

    def test_a_move_may_follow_another_though_the_board_reports_busy(self):
        script = enabled()
        for _ in range(4):
            assert script.ask(MOVE) == Done()
        assert script.device.registers == Motors((120, -64, 0, 16, 0, 0))

    @pytest.mark.parametrize("counts", [(32_760, 0, 0, 0, 0, 0), (0, -32_760, 0, 0, 0, 0)])
    def test_a_move_past_sixteen_bits_is_denied_before_it_begins(self, counts):
        script = enabled()
        script.device.board.count_from(counts)
        reply = script.ask(MOVE)
        assert isinstance(reply, RequestRejected)
        assert not reply.moved
        assert "32790" in str(reply) or "-32776" in str(reply)
        assert script.device.registers == Motors(counts)

    def test_a_board_that_has_counted_past_sixteen_bits_turns_one_step_at_most(self):
        script = enabled()
        script.device.board.count_from((40_000, 0, 0, 0, 0, 0))
        assert script.device.registers[0] == 40_000 - 65_536
        reply = script.ask(MOVE)
        assert "counted past 32767" in str(reply)
        script.now_s += 5.0
        assert isinstance(script.ask(ReadPosition()), Registers)
        assert script.device.board.drive.counts == (39_999, 0, 0, 0, 0, 0)
        assert not script.device.board.drive.rack.mask(script.now_s)

    @pytest.mark.parametrize(("fraction", "error"), [(1.0, 0.2), (0.5, 0.0), (0.3, 0.2)])
    def test_a_motion_is_as_fast_as_was_asked_for(self, fraction, error):
        script = enabled(quirks=RobkoQuirks(AVR, 700.0, speed_error=error))
        wanted_hz = script.controller.usable_rate_hz(125.0 * fraction)
        for steps in (100, -100):
            began_s = script.now_s
            assert script.ask(MoveBy(Motors((steps, 40, 0, 0, 0, 0)), wanted_hz)) == Done()
            took_s = script.now_s - began_s
        ramps_s = wanted_hz / 700.0
        assert took_s == pytest.approx((100 / wanted_hz + ramps_s) * (1.0 + error), abs=0.12)

    def test_a_single_step_takes_as_long_as_its_rate_says(self):
        script = enabled()
        assert script.ask(MoveBy(Motors((1, 0, 0, 0, 0, 0)), 2.0)) == Done()
        assert script.now_s > 0.5

    def test_an_axis_that_another_program_left_hanging_is_freed_and_the_move_made(self):
        script = enabled()
        rack = script.device.board.drive.rack
        rack.move_at(1, 0, 0.0, script.now_s)
        rack.move_to(1, 50, 100.0, script.now_s)
        script.now_s += 1.0
        assert script.ask(MOVE) == Done()
        assert script.device.registers == Motors((30, 1 - 16, 0, 4, 0, 0))
        assert [event.text for event in script.oddities] == [
            "freed axes that a speed of 0 had left hanging: shoulder"
        ]

    def test_an_axis_that_cannot_be_freed_keeps_no_motion_waiting(self, monkeypatch):
        script = enabled()
        rack = script.device.board.drive.rack
        rack.move_at(1, 0, 0.0, script.now_s)
        rack.move_to(1, 50, 100.0, script.now_s)
        monkeypatch.setattr(rack, "run", lambda *_: None)
        script.now_s += 1.0
        assert script.ask(MOVE) == RequestRejected("it is still moving", moved=False)

    def test_a_board_that_another_program_moves_is_waited_for_and_never_freed(self):
        script = enabled()
        rack = script.device.board.drive.rack
        rack.move_at(1, 20, 20.0, script.now_s)
        assert script.ask(MOVE) == Done()
        rack.move_at(1, 500, 20.0, script.now_s)
        reply = script.ask(MOVE)
        assert reply == RequestRejected("it is still moving", moved=False)
        assert rack.mask(script.now_s) == 2
        assert script.oddities == []

    def test_motors_that_go_off_between_the_two_requests_of_a_motion_are_reported(self):
        script = enabled()
        assert script.ask(MOVE) == Done()
        script.link = FrameLink(script.link)

        def reset(written):
            if op_of(written) is Op.MOVE_ABSOLUTE and script.link.count(Op.MOVE_ABSOLUTE) == 2:
                script.device.board.reset()

        script.link.on_write = reset
        reply = script.ask(MOVE)
        assert reply == RequestRejected("its motors are disabled: call `enable()`", moved=False)
        assert [each.kind for each in script.alerts()] == [AlertKind.SWITCHED_OFF]

    def test_motors_that_do_not_come_to_rest_are_told(self):
        script = enabled()

        def run():
            for axis in range(2):
                script.device.board.drive.rack.run(axis, 4.0, script.device.now_s)

        script.device.at(script.now_s + 0.15, run)
        assert "come to rest" in str(script.ask(MOVE, stop_after_s=0.2))

    @pytest.mark.parametrize(
        ("happens", "words", "alerts"),
        [
            (
                lambda board, _: board.reset(),
                "reset or lost its power in mid-motion",
                [AlertKind.RESTARTED],
            ),
            (
                lambda board, _: board.count_from((900, 0, 0, 0, 0, 0)),
                "is not on the way that was sent",
                [AlertKind.OFF_PATH],
            ),
            (lambda board, now_s: board.drive.rack.stop(now_s), "steps short of its target", []),
        ],
        ids=["reset", "off its path", "short"],
    )
    def test_a_motion_that_does_not_end_where_it_should_is_told(self, happens, words, alerts):
        script = enabled()
        board = script.device.board
        board.count_from((200, 100, 0, 0, 0, 0))
        script.device.at(script.now_s + 0.1, lambda: happens(board, script.device.now_s))
        reply = script.ask(MOVE)
        assert isinstance(reply, RequestRejected)
        assert reply.moved
        assert words in str(reply)
        assert [each.kind for each in script.alerts()] == alerts
        assert not board.drive.rack.mask(script.now_s)

    def test_a_suspension_of_this_program_does_not_make_the_arm_seem_slow(self):
        script = enabled()
        script.ask(MOVE)
        assumed_s = script.controller.duration_s(100, 125.0)
        script.begin(MOVE)
        script.run(0.1)
        script.now_s += 5.0
        assert script.finish() == Done()
        assert script.controller.duration_s(100, 125.0) <= assumed_s

    def test_a_motion_that_lasts_much_longer_than_planned_is_stopped(self):
        script = enabled(quirks=RobkoQuirks(AVR, 700.0, speed_error=8.0))
        reply = script.ask(MoveBy(Motors((200, 0, 0, 0, 0, 0)), 125.0))
        assert "the motion had not ended after" in str(reply)
        assert not script.device.board.drive.rack.mask(script.now_s)

    def test_a_board_that_refuses_to_switch_its_motors_on_is_believed(self):
        script = Script()
        script.link = FrameLink(script.link)
        refusal = encode_answer(Acknowledged(Op.ENABLE, Status.ERROR))
        script.link.back.append(Rule(of(Op.ENABLE), instead(refusal)))
        assert script.ask(SwitchOn()) == RequestRejected("it answered ERROR", moved=False)

    def test_the_next_request_after_an_abandoned_one_begins_with_a_ping(self):
        script = enabled()
        script.link = FrameLink(script.link)
        script.begin(ReadPosition())
        script.controller.abandon()
        assert isinstance(script.ask(ReadPosition()), Registers)
        assert script.link.count(Op.PING) == 1

    def test_a_move_with_the_motors_off_is_denied_and_nothing_has_moved(self):
        script = Script()
        reply = script.ask(MOVE)
        assert reply == RequestRejected("its motors are disabled: call `enable()`", moved=False)
        assert script.alerts() == []

    @pytest.mark.parametrize("op", [Op.POSITION, Op.INPUTS])
    def test_positions_are_no_older_than_a_silence_in_the_same_look(self, op):
        script = enabled()
        script.ask(MOVE)
        script.link = FrameLink(script.link)

        def fail_power(written):
            if op_of(written) is op and script.device.powered:
                script.device.power_off()
                script.device.at(script.device.now_s + 0.4, script.device.power_on)
                script.link.on_write = lambda _: None

        script.link.on_write = fail_power
        assert not script.ask(ReadPosition()).positions.largest
        assert [each.kind for each in script.alerts()] == [AlertKind.RESTARTED]


class TestArm:
    def test_motors_are_sent_to_absolute_positions_and_what_they_stray_is_told(self):
        arm = ready_robko()
        arm.jog_j(base_deg=2, shoulder_deg=1)
        moved = arm.move_to(Pose.of(x_mm=280, y_mm=20, z_mm=130, pitch_deg=-80))
        assert moved.deviation_mm > 0.0
        assert arm.twin.link.count(Op.MOVE_SPEED) == 0

    def test_a_reset_at_zero_is_detected_by_the_boards_refusal(self):
        arm = ready_robko()
        arm.twin.board.reset()
        with pytest.raises(DeviceFault, match="switched its motors off"):
            arm.move_j(base_deg=3)
        arm.reset()
        assert arm.status.state is State.DISABLED


CHANGES = {
    "lost": lost,
    "twice": twice,
    "late": late_by(0.15),
    "very late": late_by(1.2),
    "length garbled": garbled(2, 0x1B),
    "operation garbled": garbled(3, 0x0A),
    "check garbled": garbled(-1),
}


class TestDisturbedWire:
    @in_pairs(
        "side, op, change",
        ["to", "back"],
        [Op.POSITION, Op.INPUTS, Op.MOVE_ABSOLUTE],
        [*CHANGES.values()][:: amount(2, 1)],
    )
    def test_a_disturbed_frame_costs_only_time(self, change, op, side):
        arm = ready_robko()
        getattr(arm.twin.link, side).append(Rule(of(op), change, skip=1))
        arm.move_j(base_deg=3)
        arm.jog_j(shoulder_deg=1)
        arm.sleep(1.5)
        status = arm.status
        assert status.state is State.STANDBY
        assert status.trust is Trust.REFERENCED
        assert arm.twin.world.motors == status.acknowledged
        assert arm.twin.world.joints.deg["base"] == pytest.approx(3.0, abs=0.1)

    def test_a_motion_whose_request_was_lost_is_sent_once_more(self):
        arm = ready_robko()
        arm.twin.link.to.append(Rule(of(Op.MOVE_ABSOLUTE), lost, skip=1))
        arm.move_motors(3, 0, 0, 0, 0, 0)
        assert arm.twin.link.count(Op.MOVE_ABSOLUTE) == 1 + 2

    def test_a_motion_whose_answer_was_lost_is_not_sent_again(self):
        arm = ready_robko()
        arm.twin.link.back.append(Rule(of(Op.MOVE_ABSOLUTE), lost, skip=1))
        arm.move_motors(3, 0, 0, 0, 0, 0)
        assert arm.twin.link.count(Op.MOVE_ABSOLUTE) == 1 + 1

    @pytest.mark.parametrize("skip", [0, 1])
    def test_a_motion_that_is_lost_twice_is_a_fault_and_nothing_has_moved(self, skip):
        arm = ready_robko()
        before = arm.twin.world.motors
        arm.twin.link.to.append(Rule(of(Op.MOVE_ABSOLUTE), lost, skip=skip, times=1e9))
        with pytest.raises(NoAnswer):
            arm.move_motors(3, 0, 0, 0, 0, 0)
        assert arm.twin.world.motors == before
        assert arm.status.state is State.ERROR_STOP


WATCHED = robko_config(
    device={"board": "esp32", "watchdog_s": 1.0, "acceleration_steps_s2": 700.0},
    idle_poll_s=0.0,
)
WATCHDOG = {"board": "esp32", "watchdog_s": 1.0, "acceleration": 700.0}


class TestWatchdog:
    def test_it_is_kept_fed_while_the_program_lives_even_in_error_stop(self):
        arm = ready_robko(WATCHED, **WATCHDOG)
        arm.sleep(10.0)
        arm.estop()
        arm.sleep(10.0)
        assert arm.twin.board.enabled
        pings = [each for each in arm.twin.link.messages if op_of(each) is Op.PING]
        assert len({*pings}) == len(pings) > 50  # so none has the late answer to another
        arm.reset()
        arm.move_j(base_deg=3)
        assert arm.status.trust is Trust.REFERENCED

    def test_a_lost_ping_does_not_let_the_arm_sag(self):
        arm = ready_robko(WATCHED, **WATCHDOG)
        arm.twin.link.to.append(Rule(of(Op.PING), lost))
        arm.sleep(3.0)
        assert not arm.twin.link.to[0].times
        assert arm.twin.board.enabled
        assert arm.status.trust is Trust.REFERENCED

    def test_it_is_fed_no_more_once_the_motors_are_off(self):
        arm = ready_robko(WATCHED, **WATCHDOG)
        arm.disable()
        fed = arm.twin.link.count(Op.PING)
        arm.sleep(10.0)
        assert arm.twin.link.count(Op.PING) == fed
        assert not arm.status.error

    def test_a_program_that_has_ended_feeds_it_no_more_and_the_arm_sags(self):
        arm = ready_robko(WATCHED, **WATCHDOG)
        device, height_mm = arm.twin.device, arm.twin.world.pose.z_mm
        now_s = arm.status.time_s
        arm.close()
        device.transmit(now_s + 5.0)
        assert not device.board.enabled
        assert device.world.pose.z_mm < height_mm

    def test_a_wire_that_was_silent_for_too_long_makes_the_position_suspect(self):
        arm = ready_robko(WATCHED, **WATCHDOG)
        arm.twin.link.to += [Rule(of(op), lost, times=1e9) for op in Op]
        arm.sleep(3.0)
        arm.twin.link.to.clear()
        arm.sleep(1.0)  # nothing feeds it now, which would hide that it has expired
        with pytest.raises(ArmError, match="watchdog"):
            arm.move_j(base_deg=3)
        assert arm.status.trust is Trust.SUSPECT
        assert arm.status.state is State.ERROR_STOP
        assert arm.twin.link.count(Op.MOVE_ABSOLUTE) == 0


@every_row(
    "reported, near, position",
    [(-32768, 32767, 32768), (32767, -32768, -32769), (5, 65536, 65541), (0, 0, 0)],
)
def test_positions_are_unwrapped_across_the_seam(reported, near, position):
    controller = Script().controller
    assert controller.unwrap(Motors([reported] * 6), Motors([near] * 6)) == Motors([position] * 6)


# -- Pacing ----------------------------------------------------------------------------------------

BOARD = st.sampled_from(
    [
        *BOARDS.values(),
        RobkoBoard(700.0, 300.0, 0.0),
        RobkoBoard(75.0, 125.0, 0.008),
        RobkoBoard(75.0, 150.0, 0.0, obeys_speed=False),
    ]
)
STEPS = st.tuples(*[st.integers(-90, 90)] * 6).filter(any)
RATES = st.one_of(st.floats(1.0, 400.0), st.sampled_from([31.25, 62.0, 62.5, 63.0, 125.0]))


def moved(board, steps, speeds, start_s=0.0):
    rack = UncoordinatedRack(
        (0,) * 6,
        acceleration_hz_s=board.acceleration_steps_s2,
        grid_s=board.step_chance_s,
        stagger_s=board.step_chance_s / 8,
    )
    for axis, (each, speed) in enumerate(zip(steps, speeds, strict=True)):
        if each:
            rack.move_at(axis, each, speed, start_s)
    return rack


@settings(max_examples=amount(50, 1000))
@given(BOARD, STEPS, RATES, st.floats(0.0, 0.05))
@example(BOARDS["avr"], (30, 16, 0, 0, 0, 0), 125.0, 0.0)
@example(BOARDS["avr"], (0, 0, 0, 0, 13, 20), 1.5, 0.0)
def test_no_axis_lasts_longer_or_strays_further_than_was_computed(board, steps, rate_hz, start_s):
    pacing = Pacing(board)
    speeds = pacing.speeds(steps, rate_hz)
    rack = moved(board, steps, speeds, start_s)
    took_s, longest = rack.done_s - start_s, max(map(abs, steps))
    assert took_s <= pacing.lasts_s(longest, rate_hz) + 1e-9
    lead = next(axis for axis, each in enumerate(steps) if abs(each) == longest)
    bound = pacing.deviation_steps(steps, rate_hz)
    for look in range(41):
        seen = rack.positions(start_s + took_s * look / 40)
        share = seen[lead] / steps[lead]
        strays = (abs(at - share * each) for at, each in zip(seen, steps, strict=True))
        assert all(far <= most + 1e-9 for far, most in zip(strays, bound, strict=True))
    assert all(0 < speed <= 30_000 for speed, each in zip(speeds, steps, strict=True) if each)


@every_row("board", BOARDS.values())
def test_a_stop_takes_an_axis_no_farther_beyond_its_target_than_is_announced(board):
    rates = [125.0, 62.5, 25.0, 5.0] if board.obeys_speed else [125.0]
    farthest = []
    for rate_hz in rates:
        for steps in range(1, 11):
            whole = (steps, 0, 0, 0, 0, 0)
            speeds = Pacing(board).speeds(whole, rate_hz)
            # after each step in turn, the moment when the library has planned the next one
            for made in range(1, steps):
                rack, now_s = moved(board, whole, speeds), 0.0
                while rack.positions(now_s)[0] < made:
                    now_s += 0.004
                rack.ramp_down(now_s)
                seen = [rack.positions(now_s + 0.02 * look)[0] for look in range(100)]
                farthest.append(max(seen) - steps)
    assert max(farthest) == OVERSHOOT_STEPS


@settings(max_examples=amount(50, 1000))
@given(BOARD, RATES, st.integers(1, 200), st.integers(1, 50))
def test_more_steps_last_longer_and_no_usable_rate_is_above_the_one_wanted(
    board, rate_hz, steps, more
):
    pacing = Pacing(board)
    most_hz = min(max(rate_hz, 1.0), board.max_rate_hz) if board.obeys_speed else board.max_rate_hz
    assert pacing.usable_hz(rate_hz) <= most_hz + 1e-6
    assert pacing.usable_hz(pacing.usable_hz(rate_hz)) == pytest.approx(pacing.usable_hz(rate_hz))
    assert pacing.lasts_s(steps, rate_hz) <= pacing.lasts_s(steps + more, rate_hz)
    assert pacing.lasts_s(0.0, rate_hz) == 0.0


def test_the_rates_of_an_avr_board_are_parts_of_125_and_others_have_a_single_one():
    pacing = Pacing(BOARDS["avr"])
    wanted = [float("inf"), 124.0, 100.0, 62.0, 42.0, 0.0]
    real = [pacing.usable_hz(rate_hz) for rate_hz in wanted]
    assert real == pytest.approx([125.0, 62.5, 62.5, 125 / 3, 125 / 3, 1.0])
    single = Pacing(RobkoBoard(75.0, 150.0, 0.0, obeys_speed=False))
    assert {single.usable_hz(rate_hz) for rate_hz in wanted} == {150.0}


def meter_of(doubt: float) -> PaceMeter:
    return PaceMeter(doubt, TOLD_BY_S, SLACK_S, SLACK_S)


def test_the_meter_believes_slowness_at_once_and_speed_bit_by_bit():
    meter = meter_of(1.5)
    assert meter.doubt == 1.5
    assert meter.learn(0.05, 0.2)  # too short to tell
    assert meter.doubt == 1.5
    assert meter.learn(0.4, 0.4)
    assert meter.doubt == 1.0
    assert meter.learn(0.4, 0.6)
    assert meter.doubt == pytest.approx(1.5)
    assert meter.learn(0.4, 0.4)
    assert 1.3 < meter.doubt < 1.4
    assert not meter.learn(0.4, 3.0)
    assert not meter_of(1.0).learn(0.4, 0.01)


def test_an_arm_file_corrects_what_is_known_of_a_board():
    table = {
        "model": "robko01",
        "connection": {"dialect": "robko01", "port": "udp://192.168.1.9:10182"},
        "robko01": {"board": "esp32", "acceleration_steps_s2": 700, "watchdog_s": 3},
    }
    config = parse_arm(table, name="bench")
    assert config.connection.baud == 115_200
    assert config.motion.planned_burst_s == 0.5
    assert config.device.known == RobkoBoard(700.0, 100.0, 0.0, obeys_speed=False)
    assert RobkoSettings().known == BOARDS["avr"]


# -- Stops -----------------------------------------------------------------------------------------

ANSWERED_S = 0.01
"""A look and its answer take 4 ms on the wire."""
FAR_STEPS = 200
"""More than a burst makes."""


@pytest.mark.parametrize("awaited", [Op.POSITION, Op.MOVE_ABSOLUTE])
def test_a_stop_goes_out_as_soon_as_what_was_sent_before_it_is_answered(awaited):
    arm = ready_robko()
    link, asked_s, said_s = arm.twin.link, [], []

    def watch(written):
        op = op_of(written)
        under_way = op is Op.MOVE_ABSOLUTE or arm.twin.device.moving
        if op is awaited and under_way and link.count(Op.MOVE_ABSOLUTE) == 2 and not asked_s:
            arm.request_stop()
            asked_s.append(arm.parts.engine.now_s)
        elif op is Op.STOP:
            said_s.append(arm.parts.engine.now_s)

    arm.move_j(base_deg=40, wait=False)
    link.on_write = watch
    with pytest.raises(Stopped):
        arm.sleep(2.0)
    arm.sleep(1.0)
    assert asked_s
    assert said_s[0] - asked_s[0] <= ANSWERED_S


def test_a_motor_that_a_stop_left_far_beyond_its_target_is_not_believed():
    """The firmware's arithmetic takes it four steps beyond at most; what goes further is moved."""
    arm = ready_robko()
    link, stopped, moved = arm.twin.link, [], []

    def watch(written):
        op = op_of(written)
        if op is Op.STOP:
            stopped.append(op)
        elif op is Op.POSITION and stopped and not moved and not arm.twin.device.moving:
            moved.append(op)
            arm.twin.device.jog((FAR_STEPS, 0, 0, 0, 0, 0))

    arm.move_j(base_deg=40, wait=False)
    link.on_write = watch
    arm.sleep(0.5)
    arm.request_stop()
    arm.sleep(2.0)
    assert moved
    assert arm.status.trust is Trust.SUSPECT
    assert arm.twin.world.motors == arm.status.acknowledged


def test_a_lost_jog_is_not_sent_again_once_it_is_released():
    arm = ready_robko()
    link, sent, before = arm.twin.link, [], arm.twin.world.motors

    def lose(frame):
        sent.append(frame)
        arm.jogging.release()
        return []

    link.to.append(Rule(of(Op.MOVE_ABSOLUTE), lose, skip=1, times=9))  # the first one is at speed 0
    arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=1.0)
    arm.sleep(2.0)
    assert len(sent) == 1
    assert arm.twin.world.motors == before
