"""CiA 402 drives in motion, paused and blocked."""

import itertools
import re
from dataclasses import replace

import pytest
from amounts import every_row
from cia402_rig import QUICK, Rig, moving, steps

from armdrive.config.sections import HomingSettings
from armdrive.dialects.bus.paths import PlannedPath
from armdrive.dialects.cia402.compare import parsed_line
from armdrive.dialects.cia402.controller import Cia402Controller
from armdrive.errors import Refused
from armdrive.sim.cia402.motion import Homing
from armdrive.tasks import (
    AlertKind,
    ClearFault,
    DeviceSettings,
    Done,
    FixSetting,
    Halted,
    HomeDevice,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadSettings,
    RequestRejected,
    SwitchOn,
)
from firmware_protocol.canopen import (
    DriveState,
    OperationMode,
    Service,
    cob_id,
)
from kinematics import Joints, Motors

PERIOD_S = 0.01
SEEN_S = 0.6
"""The longest from the last step until the driver has seen that the drives stand."""
LINE = (MoveBy(steps(6000, -3000), 20_000.0), MoveBy(steps(6000, -3000), 20_000.0))


def differences(targets: list[tuple[float, int]]) -> list[int]:
    return [b - a for (_, a), (_, b) in itertools.pairwise(targets)]


# -- the way --------------------------------------------------------------------------------------


def test_smoothing_makes_ramps_of_jumps_in_speed():
    way = PlannedPath(Motors((0,)))
    way.append(MoveBy(Motors((1000,)), 10_000.0), 0.0)
    places = [round(way.averaged(turn * PERIOD_S, 0.03)[0]) for turn in range(15)]
    speeds = [b - a for a, b in itertools.pairwise(places)]
    changes = [abs(b - a) for a, b in itertools.pairwise((0, *speeds, 0))]
    assert max(changes) <= 35  # of 100 a turn
    assert places[-1] == 1000


# -- cyclic ---------------------------------------------------------------------------------------


def test_targets_come_with_every_sync_never_jump_and_keep_the_motors_in_proportion():
    rig = Rig(QUICK).ready()
    began_s, before = rig.now_s, rig.positions
    rig.begin(MoveAlong(iter(LINE), 0.3))
    while (reply := rig.reply()) is None:
        rig.run(0.007)
        base, shoulder, *_ = rig.positions - before
        assert abs(base + 2 * shoulder) <= 12
    assert reply == Done()
    assert rig.positions == before + steps(12_000, -6000)
    syncs = [at_s for at_s, _ in rig.frames(Service.SYNC, began_s)]
    gaps = [b - a for a, b in itertools.pairwise(syncs)]
    assert max(gaps) <= PERIOD_S + 1e-6
    check_targets_never_jump(rig, began_s)


def check_targets_never_jump(rig, since_s):
    assert max(map(abs, differences(rig.targets(1, since_s)))) <= 20_000 * PERIOD_S + 1


def test_a_drive_that_stands_while_others_turn_gets_its_target_too():
    rig = Rig({}, hold_after_loss="extrapolate").ready()
    before = rig.positions
    apart = (MoveBy(steps(0, -3000), 20_000.0), MoveBy(steps(6000, 0), 20_000.0))
    assert rig.along(*LINE, *apart, *LINE) == Done()
    assert rig.positions == before + steps(30_000, -15_000)


def test_a_motion_of_less_than_a_step_in_a_cycle_goes_to_its_end():
    rig = Rig({"period_ms": 4, "smoothing_ms": 200}).ready()
    before = rig.positions
    assert rig.along(MoveBy(steps(10), 20.0)) == Done()
    assert rig.positions == before + steps(10)


def be_late(rig):
    """Suspend the program for less than the drives' patience."""
    rig.suspend(0.08)


def mute_one(rig):
    rig.device.board.node(1).port.mute = True
    rig.run(0.1)
    rig.device.board.node(1).port.mute = False


@pytest.mark.parametrize("fail", [be_late, mute_one])
def test_a_motion_slows_down_for_a_moment_of_silence_and_does_not_jump_ahead(fail):
    rig = Rig(QUICK).ready()
    began_s, before = rig.now_s, rig.positions
    rig.begin(MoveAlong(iter(LINE), 0.3))
    rig.run(0.2)
    fail(rig)
    assert rig.finish() == Done()
    assert rig.positions == before + steps(12_000, -6000)
    check_targets_never_jump(rig, began_s)
    assert rig.controller.underruns


def test_a_motion_goes_on_slowly_after_an_outage():
    rig = Rig(QUICK).ready()
    rig.begin(MoveAlong(iter(LINE), 0.3))
    rig.run(0.2)
    rig.suspend(0.14)  # the drives may have stopped by themselves, and have not
    last = rig.targets(1)[-1][1]
    while (after := rig.targets(1)[-1][1]) == last:
        rig.run(0.001)
    assert after - last < 20_000 * PERIOD_S / 2
    assert rig.finish() == Done()


def lose(is_lost):
    """Return what loses some of the program's frames, and what ends that."""
    keep = lambda *_: False  # noqa: E731
    return (
        lambda rig: setattr(rig, "loses", is_lost),
        lambda rig: setattr(rig, "loses", keep),
    )


def fault(name):
    return lambda rig: rig.twin.faults.add(name), lambda rig: rig.twin.faults.end()


@pytest.mark.parametrize(
    ("happens", "lasts_s", "most_turns"),
    [
        (lose(lambda frame, _: frame.can_id == 0x201), 0.08, 5),  # the targets of one drive
        (lose(lambda frame, _: frame.can_id == 0x201), 0.15, 5),
        (lose(lambda frame, _: frame.can_id == 0x80), 0.08, 7),  # every SYNC
        (lose(lambda frame, _: frame.can_id == 0x80), 0.15, 7),
        (fault("alone"), 0.04, 5),
        (fault("alone"), 0.25, 5),  # without a heartbeat they have stopped by themselves
        (fault("mute"), 0.04, 1.5),
        (fault("mute"), 0.25, 1.5),
    ],
    ids=[
        "targets-0.08", "targets-0.15", "SYNC-0.08", "SYNC-0.15",
        "alone-0.04", "alone-0.25", "mute-0.04", "mute-0.25",
    ],
)  # fmt: skip
def test_drives_that_miss_their_targets_are_sent_no_farther_and_do_not_jump_far(
    happens, lasts_s, most_turns
):
    """At most over what they were told, and did not hear, until that was noticed."""
    rig = Rig(QUICK).ready()
    before = rig.positions
    rig.begin(MoveAlong(iter(LINE * 2), 0.3))
    rig.run(0.2)
    there, ways = rig.positions, []
    begins, ends = happens
    begins(rig)
    rig.at_s[rig.now_s + lasts_s] = lambda: ends(rig)
    for _ in range(60):
        rig.run(PERIOD_S)
        ways.append((rig.positions - there).largest)
        there = rig.positions
    assert max(ways) <= most_turns * 20_000 * PERIOD_S + 1
    assert all(sum(ways[i : i + 20]) <= 1.2 * 20_000 * 20 * PERIOD_S for i in range(40))
    reply = rig.finish()
    assert (reply == Done()) == ((most_turns, lasts_s) != (5, 0.25))
    if reply == Done():
        assert rig.positions == before + steps(24_000, -12_000)
    else:
        assert sum(ways[12:]) == 0
        # its emergency message may be lost, too
        assert re.search("stopped by itself|missed a heartbeat", reply.reason)


@pytest.mark.parametrize(
    ("strategy", "hard"), [("cyclic", False), ("cyclic", True), ("profile", False)]
)
def test_a_stop_is_a_quick_stop_that_keeps_the_current_and_the_drives_obey_again(strategy, hard):
    rig = moving(steps(20_000, -10_000), 0.407, {"strategy": strategy})
    rig.stop(hard=hard)
    asked_s, there, reply = rig.now_s, rig.positions[0], None
    rig.run(0.001)
    assert rig.words(1)[-1] == 0x0002
    moved_s, place = rig.now_s, there
    while reply is None:
        rig.run(0.002)
        assert all(node.motor.holding for node in rig.device.board.nodes)
        if rig.positions[0] != place:
            moved_s, place = rig.now_s, rig.positions[0]
        reply = rig.reply()
    assert reply == Halted()
    stopping = rig.controller.stopping(0.3)
    assert moved_s - asked_s <= stopping.asked_s
    assert rig.now_s - asked_s <= stopping.asked_s + SEEN_S
    assert rig.positions[0] - there <= 20_000 * stopping.asked_motion_s
    assert 0x0002 in rig.words(1)
    assert rig.states() == {DriveState.ENABLED}
    held = rig.positions
    rig.check_stands(1.0)
    assert (rig.along(*LINE[:1]) if strategy == "cyclic" else rig.do(LINE[0])) == Done()
    assert rig.positions == held + LINE[0].steps


@pytest.mark.parametrize("period_ms", [4, 50])
@pytest.mark.parametrize("window", [8, 1000])
def test_a_drive_that_brakes_is_not_taken_to_stand(period_ms, window):
    settings = {"period_ms": period_ms, "position_window": window, "quick_stop_s": 1.0}
    rig = moving(steps(40_000, -20_000), 0.3, settings)
    rig.stop()
    asked_s, there, reply = rig.now_s, rig.positions[0], None
    while reply is None:
        rig.run(0.001)
        assert rig.positions[0] >= there  # it would be held where it was some cycles ago
        there, reply = rig.positions[0], rig.reply()
    assert reply == Halted()
    assert rig.now_s - asked_s <= rig.controller.stopping(0.3).asked_s + SEEN_S
    rig.check_stands(0.5)


@pytest.mark.parametrize(
    ("how", "after_s"), [("released", 0.58), ("paused", 0.4)], ids=["released", "paused"]
)
def test_a_released_jog_and_a_paused_arm_slow_down_on_their_path_and_draw_no_more(how, after_s):
    rig, asked, drawn = Rig().ready(), [False], []

    def segments():
        for each in LINE * 4:
            drawn.append(each)
            yield each

    ask = lambda: asked[0]  # noqa: E731
    never = lambda: False  # noqa: E731
    released, held_back = (ask, never) if how == "released" else (never, ask)
    before = rig.positions
    rig.begin(MoveAlong(segments(), 1.0, released=released, held_back=held_back))
    rig.run(after_s)  # a jog: shortly before the end of a segment
    there, count, asked[0] = rig.positions, len(drawn), True
    rig.run(0.25)
    base, shoulder, *_ = rig.positions - before
    assert abs(base + 2 * shoulder) <= 2
    assert 0 < (rig.positions - there)[0] < 20_000 * 0.15
    rig.check_stands(1.0)
    assert len(drawn) == count < 8
    assert 0x0002 not in rig.words(1)
    asked[0] = how == "released"
    assert rig.finish() == (Halted() if how == "released" else Done())
    assert rig.positions[0] == 6000 * 8 or how == "released"


# -- profile position -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("strategy", "options"),
    [
        ("cyclic", {"csp": False}),
        ("profile", {}),
        ("profile", {"missing": "6084"}),
        ("profile", {"constant": "6084:00=400000"}),  # a braking ramp of their own
    ],
)
def test_bursts_by_profile_position_begin_and_arrive_together_in_the_announced_time(
    strategy, options
):
    rig = Rig({"strategy": strategy}, **options).ready()
    assert rig.controller.abilities.queued_segments == 0
    rig.do(ReadPosition())
    before, began_s = rig.positions, rig.now_s
    rig.begin(MoveBy(steps(6000, -3000), 20_000.0))
    while (reply := rig.reply()) is None:
        rig.run(0.007)
        base, shoulder, *_ = rig.positions - before
        assert abs(base + 2 * shoulder) <= 4 or "constant" in options
    assert reply == Done()
    assert rig.now_s - began_s <= rig.controller.duration_s(6000, 20_000.0) + 0.15
    assert (rig.positions - before)[:2] == (6000, -3000)
    assert {node.states.mode for node in rig.device.board.nodes} == {OperationMode.PROFILE_POSITION}


def test_all_drives_wait_for_one_that_has_no_room_for_a_target_yet():
    rig = Rig({"strategy": "profile"}).ready()
    rig.node(2).states.machine.points._acknowledged = True
    rig.do(ReadPosition())
    before = rig.positions
    rig.begin(MoveBy(steps(6000, -3000), 20_000.0))
    while (reply := rig.reply()) is None:
        rig.run(0.007)
        base, shoulder, *_ = rig.positions - before
        assert abs(base + 2 * shoulder) <= 4
    assert reply == Done()


def test_a_burst_ends_though_a_drive_at_its_target_never_takes_it():
    rig = Rig({"strategy": "profile"}).ready()
    rig.node(1).states.machine.points.control = lambda _word: False
    reply = rig.do(MoveBy(steps(4), 20_000.0))
    assert "drive 1 (base)" in reply.reason


BEYOND = re.escape("drive 1 (base) would turn to 21474") + ".*beyond what can be commanded"


@every_row("strategy, near_end, missing, words", [
    ("cyclic", True, "", BEYOND),
    ("profile", True, "", BEYOND),
    ("profile", False, "6081", "refused object 6081:00 Profile velocity"),
])  # fmt: skip
def test_drives_hold_that_cannot_be_given_a_target_or_a_speed(strategy, near_end, missing, words):
    rig = Rig({"strategy": strategy}, missing=missing)
    if near_end:
        rig.device.board.count_from([2**31 - 1000] * 6)
    rig.ready()
    reply = rig.along(*LINE) if strategy == "cyclic" else rig.do(LINE[0])
    assert isinstance(reply, RequestRejected)
    assert re.search(words, reply.reason)
    assert rig.states() == {DriveState.ENABLED}
    rig.check_stands(0.5)


def test_a_burst_that_is_released_before_it_begins_moves_nothing():
    rig = Rig({"strategy": "profile"}).ready()
    before = rig.positions
    assert rig.do(MoveBy(steps(6000), 20_000.0, lambda: True)) == Halted()
    assert rig.positions == before
    assert rig.do(LINE[0]) == Done()
    assert rig.positions == before + LINE[0].steps


# -- homing and settings --------------------------------------------------------------------------


@pytest.mark.parametrize("group", [0, 1])
def test_drives_that_missed_a_heartbeat_before_a_group_home_no_further(group):
    rig = Rig({"homing_methods": (37,) * 6}).ready()
    if group:
        assert rig.do(HomeDevice(((0,),))) == Done()
    rig.dead = True
    rig.run(1.0)
    rig.dead = False
    rig.run(1.0)
    zeros = [node.motor.zero for node in rig.device.board.nodes]
    reply = rig.do(HomeDevice(((group,),)))
    assert "has stopped by itself, and holds" in reply.reason
    assert [node.motor.zero for node in rig.device.board.nodes] == zeros
    assert rig.do(ClearFault()) == Done()
    assert rig.do(HomeDevice(((group,),))) == Done()


AT_SWITCH = {"homing_methods": (18,) * 6, "period_ms": 40}
BASE = HomeDevice(((0,),))


def test_a_slow_drive_has_the_time_that_its_homing_speeds_give_for_its_range():
    rig = Rig({**AT_SWITCH, "homing_speeds": (200, 50), "homing_s": 1.0}).ready()
    rig.node(1).motor.switch.at = rig.positions[0] + 2000
    began_s = rig.now_s
    assert rig.do(BASE, 40.0) == Done()
    assert rig.now_s - began_s > 10.0


@pytest.mark.parametrize(
    ("options", "settings", "time_s"),
    [
        ({"constant": "6099:01=100000+6099:02=10000"}, {}, None),
        ({"missing": "6099"}, {}, 1.0),
        ({"constant": "6098:00=-1"}, {"homing_methods": ()}, 1.0),  # a method of its maker's own
    ],
)
def test_a_search_that_stands_ends_in_time_and_names_only_a_key_that_helps(
    options, settings, time_s
):
    rig = Rig({**AT_SWITCH, "homing_s": 1.0, **settings}, **options).ready()
    node = rig.node(1)
    node.motion.home = lambda _now_s: None  # it stands, and reports neither success nor failure
    began_s = rig.now_s
    reply = rig.do(BASE, 40.0)
    assert isinstance(reply, RequestRejected)
    lasts = rig.controller.search(BASE).lasts
    assert lasts.s == time_s if time_s else lasts.s > 1.0
    assert rig.now_s - began_s <= lasts.waited_s + 1.0
    assert "drive 1 (base) found no switch in time, after" in reply.reason
    assert ("raise cia402.homing_s in the arm file" in reply.reason) is bool(time_s)


def test_drives_that_watch_no_heartbeat_go_on_as_long_as_their_speeds_give():
    config = replace(Rig(AT_SWITCH).config, homing=HomingSettings(Joints.of(0, 0, 0, 0, 0)))
    rig = Rig(AT_SWITCH, missing="6007")
    rig.controller = Cia402Controller(rig.controller.abilities, config)
    rig.do(ReadPosition())
    found = rig.controller.search(BASE)
    assert found.time_s == found.lasts.s
    assert found.time_s > config.motor_ranges[0] / 10_000.0


@pytest.mark.parametrize("before", [Homing.FAILED, Homing.DONE])
def test_a_drive_that_still_reports_how_an_earlier_homing_ended_homes_again(before):
    rig = Rig(AT_SWITCH).ready()
    node = rig.node(1)
    node.motor.switch.at = rig.positions[0] + 3000
    node.motion.homing, node.motion.end_search = before, lambda: None
    assert rig.do(BASE) == Done()
    assert abs(node.motor.shaft - node.motor.switch.at) < 10


def test_settings_that_differ_are_reported_with_the_line_that_mends_them():
    rig = Rig({"encoder_increments": 4096})
    told = rig.do(ReadSettings())
    assert isinstance(told, DeviceSettings)
    first = next(each for each in told.differences if "608F:01" in each.setting)
    assert (first.found, first.expected, first.must) == ("10000", "4096", True)
    assert first.fix == "1: 608F:01 u32 4096"
    assert "can only be read" in rig.do(FixSetting(first.fix)).reason
    rig = Rig({"encoder_increments": 10_000})
    assert rig.do(FixSetting("1: 6065:00 u32 4321")) == Done()
    (wrong,) = rig.do(ReadSettings()).differences
    assert wrong.found == "4321"
    assert rig.do(FixSetting(wrong.fix)) == Done()
    assert rig.do(ReadSettings()).differences == ()


@pytest.mark.parametrize(("turns", "differs"), [(2, False), (3, True)])
def test_a_ratio_in_other_numbers_is_the_same_ratio(turns, differs):
    rig = Rig({"encoder_increments": 10_000}, constant=f"608F:01=20000+608F:02={turns}")
    assert bool(rig.do(ReadSettings()).differences) is differs


@every_row(
    "line",
    [
        "nonsense",
        "1: 6040:00 u16 15",
        "1: 60B0:00 i32 999",
        "1: 60FF:00 i32 999",
        "1: 1016:01 u32 0",
    ],
)
def test_a_line_that_would_move_or_unguard_a_drive_is_refused(line):
    with pytest.raises(Refused):
        parsed_line(line)


def test_a_line_for_a_drive_of_another_arm_is_refused():
    with pytest.raises(Refused, match="no drive of this arm"):
        Rig().do(FixSetting("9: 607E:00 u8 0"))


def test_shafts_that_press_against_each_other_do_not_turn_when_their_drives_are_taken_back():
    """One of the two drives of a joint has pressed it against its stop, in a mode of its own."""
    rig = Rig({**AT_SWITCH, "period_ms": 10}).ready()
    assert rig.along(MoveBy(Motors((0, 0, 0, 28_000, 28_000, 0)), 20_000.0)) == Done()
    rig.node(4).motor.switch.at = 10_000_000
    rig.begin(HomeDevice(((3,),)))
    while rig.positions[4] > 27_800:  # until it turns the other one back
        rig.run(0.01)
    stood = rig.suspend(0.5)
    assert rig.states() == {DriveState.QUICK_STOP}
    rig.finish()
    assert rig.do(ClearFault()) == Done()
    assert (rig.positions - stood).largest <= 8
    rig.check_stands(0.5)


# -- Paused while a drive is not heard: the arm stands where it was, until it is resumed -----------

LONG_LINE = tuple(MoveBy(steps(1000, -500), 20_000.0) for _ in range(20))
MUTE_S = 0.15
"""Long enough to be waited for, and too short to be lost."""


class Pause:
    """A motion in which one drive is not heard for a while, and which somebody pauses."""

    def __init__(self, pause_s: float) -> None:
        """Have it paused so long after that drive was heard last."""
        self.rig = Rig().ready()
        self.paused, self.before = False, self.rig.positions
        self.rig.begin(MoveAlong(iter(LONG_LINE), 0.3, held_back=lambda: self.paused))
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
        self.rig.device.board.node(1).port.mute = True

    def _receive(self) -> None:
        self.rig.device.board.node(1).port.mute = False


WAITED_IN = (0.08, 0.12, MUTE_S + 0.005)
"""The motion itself waits, since that drive is not heard."""


@pytest.mark.parametrize("pause_s", [0.0, WAITED_IN[1], MUTE_S + 0.05])
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


def push_aside(rig: Rig) -> None:
    """Push the first shaft off its target, by less than drives fail for, and block it there."""
    rig.twin.world.stalled.add(0)
    rig.device.push([-400, 0, 0, 0, 0, 0])


def test_a_shaft_that_is_blocked_in_such_a_pause_does_not_spring_when_it_is_free():
    pause = Pause(0.08)
    rig = pause.rig
    target = rig.positions[0]
    push_aside(rig)
    rig.run(0.01)
    assert rig.positions[0] < target
    reply = rig.finish()
    assert isinstance(reply, RequestRejected)
    assert "drive 1 (base) is at" in reply.reason
    assert [alert.kind for alert in rig.alerts()] == [AlertKind.OFF_PATH]
    rig.twin.world.stalled.clear()
    rig.check_stands(1.0)


# -- A shaft that is blocked as it is stopped, and comes free, stays there -------------------------

BLOCKED_S = 0.05
"""Its set-point is ahead of it by then, and not yet by what drives fail for."""


def blocked(strategy: str, *, mute: bool) -> Rig:
    """Stop a motion in which the first shaft is blocked, and its drive not heard perhaps."""
    rig = Rig({"strategy": strategy}).ready()
    cyclic = strategy == "cyclic"
    rig.begin(MoveAlong(iter(LONG_LINE), 0.3) if cyclic else MoveBy(steps(8000, -4000), 20_000.0))
    rig.run(0.3)
    rig.twin.world.stalled.add(0)
    rig.run(BLOCKED_S)
    rig.device.board.node(0).port.mute = mute
    rig.stop()
    began_s, reply = rig.now_s, rig.finish()
    assert isinstance(reply, RequestRejected if mute else Halted)
    assert mute or rig.now_s - began_s <= rig.controller.stopping(0.3).asked_s + SEEN_S
    return rig


def comes_free(rig: Rig) -> None:
    """See that nothing turns when the shaft can."""
    stood = rig.positions
    rig.twin.world.stalled.clear()
    rig.run(0.5)
    assert rig.positions == stood


@pytest.mark.parametrize(
    ("strategy", "request_"),
    [("cyclic", None), ("profile", None), ("cyclic", ClearFault()), ("profile", SwitchOn())],
)
def test_a_blocked_shaft_is_held_where_it_stands_also_once_its_drive_answers_again(
    strategy, request_
):
    mute = request_ is not None
    rig = blocked(strategy, mute=mute)
    if mute:
        assert rig.node(1).motor.point.end != rig.node(1).motor.shaft
        rig.device.board.node(0).port.mute = False
        assert rig.do(request_) == Done()
    comes_free(rig)


def test_a_shaft_that_is_off_its_target_at_rest_is_reported_once():
    rig = Rig().ready()
    push_aside(rig)
    for _ in range(2):
        assert rig.do(ReadPosition()).positions[0] == -400
    (alert,) = rig.alerts()
    assert alert.kind is AlertKind.OFF_PATH
    assert "drive 1 (base) is at -400, not at 0 increments" in alert.text


@pytest.mark.parametrize("request_", [ClearFault(), SwitchOn()])
def test_a_shaft_that_was_pushed_off_its_target_is_held_where_it_is(request_):
    rig = Rig().ready()
    push_aside(rig)
    assert rig.do(request_) == Done()
    comes_free(rig)


@pytest.mark.parametrize(
    ("strategy", "rate_hz", "blocked_s"),
    [
        ("cyclic", 20_000.0, 0.005),
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


@every_row("late_s, lost", [(0.0, Service.TPDO1), (0.14, Service.SDO_RESPONSE)])
def test_a_drive_that_sends_only_reports_or_only_answers_ends_the_motion(late_s, lost):
    rig = Rig().ready()
    rig.begin(MoveAlong((MoveBy(steps(1000, -500), 20_000.0) for _ in range(100)), 0.3))
    rig.run(0.3)
    rig.suspend(late_s)  # after that, drives are asked whether they have stopped
    rig.loses = lambda frame, host: not host and frame.can_id == cob_id(lost, 1)
    began_s, reply = rig.now_s, rig.finish()
    assert isinstance(reply, RequestRejected)
    assert reply.silent
    assert "drive 1 (base)" in reply.reason
    assert rig.now_s < began_s + 1.2


def test_a_drive_that_stays_in_its_quick_stop_is_reported_and_the_others_hold():
    rig = Rig().ready()
    rig.begin(MoveAlong(iter(LONG_LINE), 0.3))
    rig.run(0.3)
    node, stopped = rig.node(1), DriveState.QUICK_STOP
    rig.loses = lambda frame, _: frame.can_id == 0x201 and node.states.state is stopped
    rig.stop()
    reply = rig.finish()
    assert isinstance(reply, RequestRejected)
    assert reply.moved
    assert "drive 1 (base) holds in its quick stop and no command brings it back" in reply.reason
    assert [each.states.state is stopped for each in rig.device.board.nodes].count(True) == 1
    rig.check_stands(0.5)


def test_a_silent_drive_is_not_turned_back_to_its_last_reading():
    """What it was heard at last is behind a shaft that has gone on."""
    rig = Rig().ready()
    rig.begin(MoveAlong(iter(LONG_LINE), 0.3))
    rig.run(0.3)
    rig.device.board.node(0).port.mute = True
    rig.stop()
    reply, farthest = None, rig.positions[0]
    while reply is None:
        rig.run(0.005)
        assert rig.positions[0] >= farthest
        farthest, reply = rig.positions[0], rig.reply()
    rig.run(1.0)
    assert rig.positions[0] == farthest
