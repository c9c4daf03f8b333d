"""A GRBL arm driven through its controller: motion, stops, pauses, and slow or hanging boards."""

import itertools
import math
from dataclasses import replace
from itertools import pairwise

import pytest
from amounts import amount, in_pairs
from backlash_bench import arm_with_play, off_steps
from faults import OVER_THE_TABLE, Rule, late_by, lost
from grbl_arm import (
    BEGINNINGS,
    FIRMWARES,
    begin_jog,
    begin_line,
    begin_planned,
    config,
    ready,
    standing_as_said,
    stands,
    tip_mm,
)
from grbl_bench import MACHINE, Bench

from armdrive import Jog
from armdrive.errors import Stopped
from armdrive.status import State, Trust
from firmware_protocol.grbl import State as BoardState
from kinematics import Pose

CANCEL, HOLD, RESUME, RESET = b"\x85", b"!", b"~", b"\x18"
JOG_LINE = rb"\$J="
BOARDS = ("mega5x", "grbl")


# -- Motion ----------------------------------------------------------------------------------------


def line(arm, speed):
    here, far = arm.pose, min(200 * speed, 40)
    return arm.move_l(
        Pose.of(x_mm=here.x_mm - far, y_mm=far, z_mm=here.z_mm + far / 2, pitch_deg=-75),
        speed=speed,
    )


def arc(arm, speed):
    here, far = arm.pose, min(200 * speed, 30)
    via = Pose.of(x_mm=here.x_mm, y_mm=here.y_mm + far, z_mm=here.z_mm + far, pitch_deg=-80)
    goal = Pose.of(x_mm=here.x_mm, y_mm=here.y_mm + 2 * far, z_mm=here.z_mm, pitch_deg=-80)
    return arm.move_c(via, goal, speed=speed)


@in_pairs("begin, firmware, speed", [line, arc], BOARDS, (1.0, 0.02, 0.1)[: amount(2, 3)])
def test_at_every_speed_a_motion_is_exact_believed_and_never_starves(begin, firmware, speed):
    arm = ready(firmware=firmware)
    begin(arm, speed)
    assert standing_as_said(arm)
    assert arm.status.trust is Trust.REFERENCED
    assert arm.status.underruns == 0


def test_many_ways_in_degrees_come_back_to_the_same_steps():
    arm = ready(config(device={"unit": "degrees"}, idle_poll_s=0.0))
    began = arm.twin.world.motors
    for _ in range(4):
        arm.move_j(base_deg=7.77, wrist_roll_deg=3.3)
        arm.move_j(base_deg=0.0, wrist_roll_deg=0.0)
    assert arm.twin.world.motors == began


@pytest.mark.parametrize("begin", [begin_planned, begin_jog])
def test_no_line_is_sent_before_the_one_before_it_is_answered(begin):
    arm = ready()
    arm.twin.link.back.append(Rule(rb"ok", late_by(0.06), times=1e9))
    begin(arm)
    arm.sleep(0.6)
    assert arm.status.state is State.MOVING
    sent_s = [time_s for time_s, piece in arm.twin.link.sent if piece.endswith(b"\n")]
    assert len(sent_s) > 5
    assert all(after_s - before_s > 0.06 for before_s, after_s in pairwise(sent_s))


def line_at(baud, ahead_s):
    made = config(planned_burst_s=ahead_s)
    arm = ready(replace(made, connection=replace(made.connection, baud=baud)))
    arm.move_to(Pose.of(x_mm=220, y_mm=-60, z_mm=120, pitch_deg=-60))
    before = arm.status.underruns
    moved = arm.move_l(Pose.of(x_mm=220, y_mm=60, z_mm=120, pitch_deg=-60))
    return arm.status.underruns - before, moved.duration_s


def test_a_queue_that_runs_empty_in_mid_motion_is_counted_and_shown():
    none, quick_s = line_at(115_200, 0.4)
    assert none == 0
    many, slow_s = line_at(9600, 0.1)  # at 9600 baud a line takes 35 ms, and a segment 33
    assert many >= 3
    assert slow_s > 1.5 * quick_s


def test_a_motion_too_slow_for_the_board_takes_its_time_and_is_reported():
    arm = ready()
    slow = arm.move_j(base_deg=4, speed=0.02)  # 79 steps at 8.3 a second
    assert slow.duration_s == pytest.approx(math.radians(4) / (0.37 * 0.02), rel=0.05)
    assert "no slower than 30.5 steps/s" in slow.note
    assert not arm.move_j(base_deg=8, speed=0.3).note
    arm.move_j(base_deg=OVER_THE_TABLE.deg["base"] + 0.3, speed=0.01)
    assert arm.status.underruns == 0  # between single steps it stands anyway


def test_fluidnc_turns_too_fast_for_a_slow_motion_and_waits_between_its_portions():
    arm = ready(firmware="fluidnc")
    speed = 20.0 / arm.parts.core.controller.limits.rates_hz()[0]
    handle = arm.move_j(base_deg=arm.joints.deg["base"] + 10, speed=speed, wait=False)
    arm.sleep(0.5)
    before, began_s = arm.twin.world.motors[0], arm.status.time_s
    arm.sleep(3.0)
    made = abs(arm.twin.world.motors[0] - before)
    assert made / (arm.status.time_s - began_s) == pytest.approx(20.0, abs=2.0)
    handle.wait()
    assert arm.status.underruns == 0
    assert standing_as_said(arm)


# -- Stops -----------------------------------------------------------------------------------------


def test_a_stop_of_an_arm_that_stands_sends_nothing():
    arm = ready()
    arm.stop()
    arm.sleep(1.0)
    assert not arm.twin.link.pressed(HOLD)
    assert not arm.twin.link.pressed(RESET)
    arm.move_j(base_deg=3)


def test_a_stop_just_as_the_motion_ends_leaves_no_hold_behind():
    for early_s in (0.0, 0.02, 0.08):
        arm = ready()
        handle = arm.move_j(base_deg=2, wait=False)
        arm.sleep(math.radians(2) / 0.37 + 0.15 - early_s)
        arm.request_stop()
        arm.sleep(0.5)
        try:
            handle.wait()
        except Stopped:
            assert arm.status.state is State.STANDBY
        assert arm.twin.board.details()["state"] == "Idle"
        arm.move_j(base_deg=4)
        assert standing_as_said(arm)


def test_a_jog_that_is_let_go_ends_soon_and_only_cancels():
    arm = ready()
    arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=5.0)
    arm.sleep(0.8)
    before = arm.twin.world.joints.deg["base"]
    arm.jogging.release()
    released_s = arm.status.time_s
    assert stands(arm) - released_s < 0.2
    assert arm.twin.world.joints.deg["base"] - before < math.degrees(0.37) * 0.2
    assert arm.twin.link.pressed(CANCEL)
    assert not arm.twin.link.pressed(RESET)
    assert standing_as_said(arm)
    assert arm.status.state is State.STANDBY


def jogged(arm, speed, for_s):
    """Jog, with renewals like those of a held key."""
    for _ in range(round(for_s / 0.1)):
        arm.jogging.hold(Jog.joint(base=1.0), speed=speed, for_s=0.4)
        arm.sleep(0.1)


@pytest.mark.parametrize(("firmware", "speed"), [("mega5x", 0.05), ("grbl", 0.3)])
def test_a_held_jog_is_smooth_and_cancelled_once(firmware, speed):
    arm = ready(firmware=firmware)
    for _ in range(2):
        jogged(arm, speed, 0.9)
        arm.jogging.release()
        arm.sleep(1.5)
    assert arm.status.underruns == 0
    assert arm.twin.link.pressed(CANCEL) <= 2
    assert standing_as_said(arm)
    assert arm.status.trust is Trust.REFERENCED


def stops_as_announced(arm, stop):
    status, tip = arm.status, arm.twin.world.tip
    assert status.state is State.MOVING
    stop()
    assert stands(arm) - status.time_s <= status.stop_time_s
    assert tip_mm(arm, tip) <= status.stop_distance_mm


@in_pairs("firmware, speed, jogging", BOARDS, [0.05, 1.0, 0.13][: amount(2, 3)], [False, True])
def test_a_stop_is_no_later_than_announced_at_any_speed(firmware, speed, jogging):
    arm = ready(firmware=firmware)
    if jogging:
        jogged(arm, speed, 1.5)
    else:
        arm.move_j(base_deg=80, speed=speed, wait=False)
        arm.sleep(1.5)
    stops_as_announced(arm, arm.request_stop)
    assert arm.status.trust is Trust.REFERENCED
    assert standing_as_said(arm)


def begin_held_jog(arm):
    arm.jogging.hold(Jog.joint(base=1.0), speed=1.0, for_s=3.0)


def lose(arm, what):
    """Lose one byte, or all that the next message says."""
    if what == "message":
        arm.twin.faults.add("drop", "next", side="host")
    else:
        arm.twin.link.to.append(Rule(what, lost))


BYTES = [rb"\?", HOLD, RESET, CANCEL]
"""What the board reads between the characters of a line."""
CANCELS = {"mega5x": 1, "grblhal": 2}
"""How often a jog is cancelled as it is released."""
LOST = [
    *itertools.product(BEGINNINGS, [RESET, "message"], ["estop"], FIRMWARES[1:2]),
    *itertools.product([begin_planned], [RESET], ["estop"], FIRMWARES),
    *itertools.product([begin_planned], [*BYTES, "message"], ["request_stop"], FIRMWARES[1:3]),
    *itertools.product([begin_line], [HOLD, "message"], ["request_stop"], FIRMWARES[1:2]),
    *itertools.product([begin_held_jog], [*BYTES, "message"], ["release"], FIRMWARES[1:3]),
]  # fmt: skip


@pytest.mark.parametrize(("begin", "what", "stop", "firmware"), LOST[:: amount(3, 1)])
def test_a_lost_stop_is_repeated_within_the_announced_time(begin, what, stop, firmware):
    arm = ready(firmware=firmware)
    begin(arm)
    arm.sleep(0.5)
    lose(arm, what)
    began_s = arm.status.time_s
    stops_as_announced(arm, arm.jogging.release if stop == "release" else getattr(arm, stop))
    arm.sleep(2.0)
    if stop == "estop":
        resets = [sent_s - began_s for sent_s, piece in arm.twin.link.sent if piece == RESET]
        assert resets[1] <= 0.03
        assert (arm.status.state, arm.status.trust) == (State.ERROR_STOP, Trust.SUSPECT)
        arm.reset()
    else:
        assert arm.status.trust is Trust.REFERENCED
        assert standing_as_said(arm)
        assert arm.twin.link.pressed(CANCEL) == CANCELS[firmware] * (stop == "release")
        assert arm.twin.board.details()["state"] == "Idle"
    assert arm.status.state is State.STANDBY


@pytest.mark.parametrize(("begin", "jogs"), [(begin_planned, False), (begin_held_jog, True)])
def test_an_emergency_stop_overtakes_a_stop(begin, jogs):
    arm = ready()
    begin(arm)
    arm.sleep(0.5)
    (arm.jogging.release if jogs else arm.request_stop)()
    arm.sleep(0.03)
    assert arm.twin.link.pressed(CANCEL if jogs else HOLD)
    arm.estop()
    arm.sleep(0.01)
    assert arm.twin.link.pressed(RESET)
    arm.sleep(2.0)
    assert (arm.status.state, arm.status.trust) == (State.ERROR_STOP, Trust.SUSPECT)


@pytest.mark.parametrize("firmware", FIRMWARES)
def test_a_jog_that_is_let_go_while_a_line_is_on_its_way_ends_in_time(firmware):
    """A cancel ends only what the planner holds."""
    arm = ready(firmware=firmware)
    begin_held_jog(arm)
    arm.sleep(0.5)
    arm.twin.link.to.append(Rule(JOG_LINE, late_by(0.03), times=1e9))
    sent = len(arm.twin.link.motions)
    while len(arm.twin.link.motions) == sent:
        arm.sleep(0.002)
    stops_as_announced(arm, arm.jogging.release)
    arm.sleep(1.0)
    assert standing_as_said(arm)
    assert arm.status.trust is Trust.REFERENCED


def test_an_emergency_stop_before_the_first_report_of_motion_is_repeated_in_time():
    for later_s in (0.0, 0.02, 0.04):
        arm = ready()
        begin_planned(arm)
        while len(arm.twin.link.motions) < 1:
            arm.sleep(0.001)
        arm.sleep(later_s)
        lose(arm, RESET)
        stops_as_announced(arm, arm.estop)


@pytest.mark.parametrize(
    ("begin", "firmware", "resets"), [*zip(BEGINNINGS, FIRMWARES, [2, 2, 1, 1], strict=True)]
)
def test_an_emergency_stop_is_sent_twice_to_a_board_that_does_not_answer_it_soon(
    begin, firmware, resets
):
    """GRBL and grbl-Mega-5X answer only after the time in $1."""
    arm = ready(firmware=firmware)
    begin(arm)
    arm.sleep(0.06)
    arm.estop()
    arm.sleep(2.5)
    assert arm.twin.link.pressed(RESET) == resets
    assert "emergency stop" in arm.status.error


# -- Pauses: a segment already drawn is not sent ---------------------------------------------------

GOAL = {"base_deg": 18.0, "shoulder_deg": 52.0}


def test_a_motion_that_is_paused_again_and_again_ends_on_the_same_steps():
    arm = ready()
    arm.move_j(**GOAL)
    goal = arm.twin.world.motors
    arm.move_j(base_deg=0.0, shoulder_deg=OVER_THE_TABLE.deg["shoulder"])
    handle = arm.move_j(wait=False, **GOAL)
    for moving_s, paused_s in ((0.03, 1.0), (0.05, 0.01), (0.11, 1.0), (0.13, 0.01), (0.3, 1.0)):
        arm.sleep(moving_s)
        arm.pause()
        arm.sleep(paused_s)
        arm.resume()
    handle.wait()
    assert arm.twin.world.motors == goal
    assert arm.status.underruns == 0


@pytest.mark.parametrize("after_s", [0.1, 1.0][: amount(1, 2)])
def test_backlash_that_was_to_be_taken_up_is_taken_up_after_the_pause(after_s):
    """At first a segment is drawn that has no room yet, and a pause takes it back."""
    arm = arm_with_play("grbl", motion={"planned_burst_s": 0.1})
    there = arm.joints.deg
    arm.move_j(base_deg=there["base"] + 8.0)
    handle = arm.move_j(
        base_deg=there["base"] - 12.0, shoulder_deg=there["shoulder"] + 7.0, wait=False
    )
    arm.sleep(after_s)
    arm.pause()
    arm.sleep(1.0)
    assert off_steps(arm) <= 1
    arm.resume()
    handle.wait()
    assert off_steps(arm) <= 1
    assert arm.status.trust is Trust.REFERENCED


# -- Slow and hanging boards -----------------------------------------------------------------------
# The figures were seen on the real firmware (docs/background/testing.md).

STEPS = {**MACHINE, **{100 + axis: 1.0 for axis in range(6)}, 110: 60_000.0, 120: 4000.0}
"""One step per unit, and a ramp of 0.1 s to 400 steps/s."""


@pytest.mark.parametrize(("firmware", "seen_s"), [("mega5x", 1.278), ("fluidnc", 1.022)])
def test_no_motor_turns_slower_than_the_boards_timer_can_count(firmware, seen_s):
    bench = Bench(STEPS, firmware=firmware)
    bench.put("G1X40F300\n")
    times = []
    for tick in range(4000):
        before = bench.x
        bench.put("?" if tick == 500 else "")
        bench.wait(0.001)
        times += [bench.now_s] * (bench.x != before)
    assert bench.reports[-1].feed == 300.0  # it reports what was planned: observed on the Mega
    assert len(times) == 40
    assert times[-1] - times[0] == pytest.approx(seen_s, rel=0.02)


SEEN = {
    "mega5x": [(31, 0.43, 14), (50, 0.27, 14), (100, 0.21, 20), (400, 0.19, 62)],
    "grbl": [(31, 0.24, 8), (50, 0.15, 8), (100, 0.13, 14), (400, 0.15, 44)],
    "fluidnc": [(31, 0.43, 17), (50, 0.33, 17), (100, 0.23, 23), (400, 0.20, 63)],
}
"""How long a board goes on after a hold or a cancel, by the steps a second at which it turns."""
GRBLHAL_HOLDS = [(31, 0.44, 14), (50, 0.27, 13), (100, 0.19, 19), (400, 0.18, 55)]
GRBLHAL_CANCELS = [(31, 0.11, 4), (50, 0.06, 3), (100, 0.07, 7), (400, 0.11, 26)]
"""It drops segments that it has computed already."""
GOES_ON = [
    *((firmware, press, *row) for firmware in SEEN for press in (HOLD, CANCEL)
      for row in SEEN[firmware]),
    *(("grblhal", HOLD, *row) for row in GRBLHAL_HOLDS),
    *(("grblhal", CANCEL, *row) for row in GRBLHAL_CANCELS),
]  # fmt: skip


@pytest.mark.parametrize(
    ("firmware", "press", "rate_hz", "seen_s", "seen_steps"), GOES_ON[:: amount(3, 1)]
)
def test_a_board_goes_on_for_as_long_as_a_real_one(firmware, press, rate_hz, seen_s, seen_steps):
    bench = Bench(STEPS, firmware=firmware)
    jog = "$J=G91" if press == CANCEL else "G91G1"
    bench.say(f"{jog}X2000F{rate_hz * 60}", 1.5)
    pressed_s, at, last_s = bench.now_s, bench.x, bench.now_s
    bench.put(press)
    for _ in range(550):
        before = bench.x
        bench.wait(0.001)
        last_s = bench.now_s if bench.x != before else last_s
    assert last_s - pressed_s == pytest.approx(seen_s, abs=0.035)  # a step at the slowest rate
    assert (bench.x - at) * 10 == pytest.approx(seen_steps, abs=3 + 0.01 * rate_hz)


@pytest.mark.parametrize("firmware", BOARDS)
def test_the_planner_reads_empty_while_motion_is_still_to_come(firmware):
    bench = Bench(STEPS, firmware=firmware)
    bench.say("G1X30F1860", 0.75)
    report = bench.ask()
    assert (report.state, report.feed) == (BoardState.RUN, 0.0)
    assert report.free_blocks == bench.board.firmware.blocks
    assert bench.x * 10 < 26


@pytest.mark.parametrize("firmware", [*BOARDS, "grblhal"])
def test_a_cancel_as_the_jog_ends_leaves_a_board_idle_that_reads_no_line(firmware):
    bench = Bench(STEPS, firmware=firmware)
    bench.say("$J=G91X20F6000", 0.05)
    bench.wait(bench.board.drive.done_s - bench.now_s - 1e-4)
    bench.board.receive(CANCEL)
    bench.wait(0.1)
    assert bench.say("G91", 0.5) == []
    assert bench.ask().state is BoardState.IDLE
    bench.put(RESUME)
    assert bench.wait(0.2) == ([] if firmware == "grblhal" else ["ok"])
    if firmware == "grblhal":
        bench.put(RESET)
        assert bench.wait(0.3)[0] == "ALARM:3"


class Hangs:
    """Makes a simulated board hang as soon as it is Idle after a cancel."""

    def __init__(self, arm):
        cycle = arm.twin.board.cycle
        self.inner = cycle.ended
        cycle.ended = self

    def __call__(self, board):
        cancelling = board.cycle.cancelling
        self.inner(board)
        board.main_loop.hung |= cancelling


@pytest.mark.parametrize("firmware", BOARDS)
def test_a_board_that_a_cancel_has_hung_is_freed_and_keeps_its_position(firmware):
    arm = ready(firmware=firmware)
    Hangs(arm)
    for way in (1.0, -1.0):
        arm.jogging.hold(Jog.joint(base=way), speed=0.5, for_s=0.5)
        arm.sleep(0.4)
        arm.jogging.release()
        arm.sleep(5.0)
        assert not arm.twin.board.main_loop.hung
        assert (arm.status.state, arm.status.trust) == (State.STANDBY, Trust.REFERENCED)
        assert standing_as_said(arm)
    arm.twin.board.main_loop.hung = True  # as another program may leave it
    arm.move_j(base_deg=10)
    assert standing_as_said(arm)
    arm.estop()
    arm.sleep(2.0)
    arm.twin.board.main_loop.hung = True
    arm.reset()
    assert not arm.twin.board.main_loop.hung
    assert arm.status.state is State.STANDBY


@pytest.mark.parametrize("unheard", [0, 2])
def test_grblhal_that_a_cancel_has_hung_is_reset_and_its_position_suspect(unheard):
    arm = ready(firmware="grblhal")
    Hangs(arm)
    arm.twin.link.back.append(Rule(rb"ALARM|GrblHAL", lost, times=unheard))
    begin_held_jog(arm)
    arm.sleep(0.4)
    arm.jogging.release()
    released_s = arm.status.time_s
    while arm.status.state in (State.MOVING, State.STOPPING):
        arm.sleep(0.01)
    # three times it reads no line, and ignores a hold; without its greeting the reset takes longer
    assert arm.status.time_s - released_s < 4.0 + unheard
    assert not arm.twin.board.main_loop.hung
    assert (arm.status.state, arm.status.trust) == (State.STANDBY, Trust.SUSPECT)
