"""A rehearsal takes as long as the run, is refused what the run is, and says what it assumed."""

import math
from dataclasses import replace
from itertools import count

import pytest
from amounts import THOROUGH, every_row
from faults import arm_config, driven
from program_acts import fingers, go, ready
from running_bench import BLOCK, PICK_AND_PLACE, Script, down, performer, table_arm

from armdrive import Arm
from armdrive.config.sections import HomingSettings
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import Target, simulated_config
from armdrive.errors import ArmError, NotReferenced, SettingsDiffer
from armdrive.programs import read_program
from armdrive.programs.acts import AwaitInputs, Delay, Hold, Home, Outputs, ReadInput, Remember, Say
from armdrive.programs.problems import SourceMark
from armdrive.programs.program import ArmProgram
from armdrive.programs.progress import FOR_EVER, UNKNOWN, RunProgress, Took
from armdrive.programs.rehearsal import (
    RehearsalOptions,
    SeenArm,
    require_rehearsed,
    time_limit,
)
from armdrive.programs.rehearsal import rehearse as rehearse_within
from armdrive.programs.running import ProgramRun, RunPlan
from armdrive.registry import DIALECTS
from kinematics.errors import KinematicsError

AGES = time_limit(math.inf)


def rehearse(seen, plan, **said):
    return rehearse_within(seen, plan, AGES, RehearsalOptions(**said))


TOUR = (
    go(down(145, 20, 40), opening_mm=20.0),
    go(down(145, 20, 25), line=True, speed=0.7),
    fingers(10.0),
    go(down(145, -10, 30)),
    Delay(2.0),
    fingers(25.0),
    ready(),
)
"""Of an arm of any dialect: no grip switch is needed."""

REFUSED = {
    "into the table": go(down(250, 0, -40)),
    "beyond a joint's limit": go(
        {"base": 0.0, "shoulder": 200.0, "elbow": 0.0, "wrist_pitch": 0.0, "wrist_roll": 0.0}
    ),
    "fingers too wide": fingers(300.0),
}


def took_s(arm, script):
    began_s = arm.parts.pace.now_s()
    ProgramRun(RunPlan(script), performer(arm)).carry_out()
    return arm.parts.pace.now_s() - began_s


def test_a_rehearsal_is_refused_while_the_controllers_settings_differ():
    arm = driven(arm_config("grbl"), factory=True)
    seen = replace(SeenArm.of(arm), world=None)  # as of a real arm, whose world is not known
    rehearsal = rehearse(seen, RunPlan(Script((Say("begin"), ready()))))
    with pytest.raises(SettingsDiffer, match=r"\$1=255"):
        require_rehearsed(rehearsal, anyway=False)
    assert rehearsal.at.line == 2
    with pytest.raises(SettingsDiffer) as refused:
        ProgramRun(RunPlan(Script((ready(),))), performer(arm)).carry_out()
    assert str(refused.value) == str(rehearsal.refusal)


def test_a_real_arm_that_homes_is_rehearsed_although_a_board_like_its_own_starts_locked():
    made = arm_config("grbl", device={"homing": True})
    there = made.model.arm.ik(made.model.reference.pose)
    arm = driven(replace(made, homing=HomingSettings(there, 10.0)))
    seen = replace(SeenArm.of(arm), world=None)
    require_rehearsed(rehearse(seen, RunPlan(Script((ready(),)))), anyway=False)


@pytest.mark.parametrize("dialect", DIALECTS if THOROUGH else ["teachmover", "mks"])
def test_a_rehearsal_takes_as_long_as_the_run(dialect):
    arm = table_arm(dialect)
    arm.speed_override = 0.8
    before = arm.twin.save()
    acts = TOUR if dialect == "teachmover" or THOROUGH else TOUR[:3]  # a line and the fingers
    rehearsal = rehearse(SeenArm.of(arm), RunPlan(Script(acts)))
    assert arm.twin.save() == before
    assert (rehearsal.refusal, rehearsal.assumptions, rehearsal.whole) == (None, (), True)
    assert rehearsal.took_s == pytest.approx(took_s(arm, Script(acts)), rel=0.02)
    assert [each.mark.line for each in rehearsal.loops[0]] == [*range(1, len(acts) + 1)]


@pytest.mark.parametrize("what", REFUSED)
def test_a_refusal_comes_before_anything_moves(what):
    arm = table_arm()
    script = Script((TOUR[0], REFUSED[what], *TOUR[1:]))
    rehearsal = rehearse(SeenArm.of(arm), RunPlan(script))
    with pytest.raises((ArmError, KinematicsError)) as refused:
        ProgramRun(RunPlan(script), performer(arm)).carry_out()
    assert type(rehearsal.refusal) is type(refused.value)
    assert str(rehearsal.refusal) == str(refused.value)
    assert rehearsal.at.line == 2
    with pytest.raises(type(refused.value)):
        require_rehearsed(rehearsal, anyway=True)


@pytest.mark.parametrize(("width_mm", "found_mm"), [(None, 0.0), (30.0, 30.0), (70.0, 0.0)])
def test_unknown_widths_are_assumed(width_mm, found_mm):
    arm = table_arm("teachmover")
    arm.twin = None  # its world is unknown, like that of a real one
    script = Script(PICK_AND_PLACE)
    rehearsal = rehearse(SeenArm.of(arm), RunPlan(script), width_mm=width_mm)
    assert script.made[0].answers[2] == pytest.approx(found_mm, abs=0.5)
    word = "nothing" if width_mm is None else f"something {width_mm:g} mm wide"
    assert [str(each) for each in rehearsal.assumptions] == [f"line 3: the fingers find {word}"]
    assert rehearsal.in_doubt


def test_assumed_inputs_are_reported():
    arm = table_arm("teachmover")
    arm.twin.device.set_input(2, True)  # which the rehearsal does not look at
    script = Script(
        (
            ReadInput(3),
            ReadInput(4),
            AwaitInputs(high=(5,)),
            AwaitInputs(high=(6,), within_s=100.0),
            AwaitInputs(low=(4,), within_s=100.0),
            AwaitInputs(low=(4,)),
        )
    )
    rehearsal = rehearse(SeenArm.of(arm), RunPlan(script), inputs={4: True})
    assert script.made[0].answers == [False, True, True, True, False, True]
    assert [each.took_s for each in rehearsal.loops[0]] == [0, 0, 0, 0, 100, 0]
    assert [(str(each), each.matters) for each in rehearsal.assumptions] == [
        ("line 1: input 3 is off", True),
        ("line 2: input 4 is on", False),
        ("line 3: input 5 is on at once", True),
        ("line 4: input 6 is on at once", True),
        ("line 5: in 100 s it does not happen that input 4 is off", True),
        ("line 6: input 4 is off at once", True),
    ]


def test_a_rehearsal_leaves_nothing_behind():
    arm = table_arm("teachmover")
    there = Remember("there", {**arm.joints.deg})
    script = Script((there, Outputs(on=(1,)), Say("hello"), Hold("turn it"), Delay(3600.0)))
    rehearsal = rehearse(SeenArm.of(arm), RunPlan(script))
    assert "there" not in arm.points
    assert arm.status.outputs is None
    assert rehearsal.took_s == pytest.approx(3600, abs=1)
    assert [each.matters for each in rehearsal.assumptions] == [False]
    assert not rehearsal.in_doubt


def test_a_rehearsal_ends_after_its_time():
    acts = count()
    plan = RunPlan(Script((Delay(1.0),) * 1000))
    rehearsal = rehearse_within(SeenArm.of(table_arm()), plan, lambda: next(acts) == 50)
    assert (rehearsal.whole, rehearsal.endless) == (False, None)
    assert len(rehearsal.loops[0]) == 50
    assert time_limit(-1.0)()


ENDLESS = {
    "words alone": ("while 1 > 0\ntype 1\nend", 1, 2),
    "a wait": ("repeat\ndelay 60\nend", 1, 2),
    "after a beginning": ("move p\nrepeat\nmove q\nmove p\nend", 3, 3),
    "a block that is carried to and fro": (
        "repeat\n" + "".join(
            f"open 60\nmove {a}\nmove_line shifted({a}, 0, 0, -50)\nclose_now\nmove_line {a}\n"
            f"move {b}\nmove_line shifted({b}, 0, 0, -50)\nopen_now 60\nmove_line {b}\n"
            for a, b in ("pq", "qp")
        ) + "end", None, 3,
    ),
}  # fmt: skip
PLACES = "point p = at(250, 60, 65, -90)\npoint q = at(250, -60, 65, -90)\n"


def rehearsed(arm, text, patience=AGES, **said):
    source = ArmProgram(read_program(text), arm.config).machine
    return rehearse_within(SeenArm.of(arm), RunPlan(source), patience, RehearsalOptions(**said))


@pytest.mark.parametrize("name", ENDLESS)
def test_an_endless_loop_is_rehearsed_until_it_repeats_and_found_to_be_endless(name):
    text, acts, line = ENDLESS[name]
    rehearsal = rehearsed(table_arm("teachmover", BLOCK), PLACES + text)
    assert rehearsal.refusal is None
    assert rehearsal.whole
    assert rehearsal.endless.line == line + 2
    assert len(rehearsal.loops[0]) == acts or acts is None
    assert len(rehearsal.loops[0]) < 60


def test_a_loop_that_waits_for_an_input_is_left_when_the_input_comes():
    arm = table_arm()
    text = "while input(1) is off\ndelay 1\nend\nwhile input(2) is off\ndelay 1\nend\nready"
    rehearsal = rehearsed(arm, text)
    assert (rehearsal.whole, rehearsal.endless) == (True, None)
    assert [str(each) for each in rehearsal.assumptions] == [
        "line 1: input 1 is off",
        "line 1: input 1 is on later",
        "line 4: input 2 is off",
        "line 4: input 2 is on later",
    ]
    assert rehearsal.loops[0][-1].mark.line == 7
    stays_off = rehearsed(arm, text, inputs={1: False})
    assert stays_off.endless.line == 1
    assert [str(each) for each in stays_off.assumptions] == ["line 1: input 1 is off"]


def test_two_loops_stand_for_all_that_follow():
    arm = table_arm("teachmover")
    for loops, rehearsed in ((1, 1), (2, 2), (7, 2), (FOR_EVER, 2)):
        rehearsal = rehearse(SeenArm.of(arm), RunPlan(Script(TOUR[:1]), loops=loops))
        assert len(rehearsal.loops) == rehearsed
    # the second begins where the first has ended
    assert rehearsal.loops[1][0].took_s < rehearsal.loops[0][0].took_s


def test_an_arm_without_a_reference_is_refused_unless_one_may_be_assumed():
    config = simulated_config("teachmover")
    arm = Arm(connect_simulated(config))
    arm.enable()
    script = Script(TOUR)
    refused = rehearse(SeenArm.of(arm), RunPlan(script))
    assert isinstance(refused.refusal, NotReferenced)
    assert refused.at.line == 1
    assumed = rehearse(SeenArm.of(arm), RunPlan(script), settle=True)
    assert assumed.refusal is None
    assert "reference posture" in str(assumed.assumptions[0])
    homed = Script((Home(), *TOUR))
    homes = rehearse(SeenArm.of(arm), RunPlan(homed), settle=True)
    assert homes.refusal is None
    assert homes.loops[0][0].took_s > 1.0  # the reference is taken, as in the run
    assert rehearse(SeenArm.of(arm), RunPlan(homed)).refusal is None
    for dialect in ("teachmover", "grbl", "mks"):  # an arm that cannot be asked
        unasked = rehearse(
            SeenArm(simulated_config(dialect)), RunPlan(Script(TOUR[:1])), settle=True
        )
        assert unasked.refusal is None
        assert unasked.assumptions[0].mark is None


def test_an_arm_whose_lengths_are_not_measured_is_refused_cartesian_goals_in_the_rehearsal():
    """The first act is allowed: without the rehearsal's refusal, the arm would stop half-way."""
    arm = table_arm("mks")
    arm.parts.core.geometry_known = False  # as of every real arm with the lengths of the template
    joints = {"base": 20.0, "shoulder": 40.0, "elbow": -60.0, "wrist_pitch": -70.0, "wrist_roll": 0}
    rehearsal = rehearse(SeenArm.of(arm), RunPlan(Script((go(joints), go(down(170, 20, 50))))))
    assert "unverified template values" in str(rehearsal.refusal)
    assert rehearsal.at.line == 2
    for simulated in (True, False):
        assert SeenArm.unasked(Target(arm.config, simulated)).geometry_known is simulated


def test_a_suspect_position_is_assumed_right_if_that_is_allowed():
    arm = table_arm("teachmover")
    arm.move_j(base_deg=30)
    arm.disable()
    arm.enable()
    assumed = rehearse(SeenArm.of(arm), RunPlan(Script(TOUR)), settle=True)
    assert "where it was last seen" in str(assumed.assumptions[0])
    refusal = rehearse(SeenArm.of(arm), RunPlan(Script(TOUR))).refusal
    assert isinstance(refusal, NotReferenced)
    with pytest.raises(NotReferenced) as own:
        arm.park()
    assert str(refusal) == str(own.value)  # and not the twin's, of which nothing is recorded


def test_the_path_of_the_tip_is_kept_where_it_is_wanted():
    arm = table_arm("teachmover")
    path = rehearse(SeenArm.of(arm), RunPlan(Script(TOUR)), traced=True).path
    assert path[0] == pytest.approx((arm.pose.x_mm, arm.pose.y_mm, arm.pose.z_mm), abs=0.5)
    assert path[-1] == pytest.approx((127, 0, 30), abs=1)
    lowest = min(z for _, y, z in path if y > 15)
    assert lowest == pytest.approx(25, abs=0.5)
    assert rehearse(SeenArm.of(arm), RunPlan(Script(TOUR))).path == ()


# -- how far a run has come, by its rehearsal -----------------------------------------------------


def took(*pairs):
    return [Took(SourceMark(line), "Go", time_s) for line, time_s in pairs]


ONCE = took((1, 10.0), (2, 20.0), (3, 10.0), (2, 20.0), (4, 40.0))


LOOPS = [took((1, 40.0)), took((1, 20.0))]
RUNS = {
    # what was rehearsed, how often it is repeated, and the loops in which acts begin, with their
    # percent, and the seconds left 5 s later
    "as rehearsed": ([ONCE], 1, [(1, 0, 95), (1, 10, 85), (1, 30, 65), (1, 40, 55), (1, 60, 35)]),
    "more acts than rehearsed": ([took((1, 40.0))], 1, [(1, 0, 35), (1, 100, 0), (1, 100, 0)]),
    "the last rehearsed loop stands for the rest": (
        LOOPS, 4, [(1, 0, 95), (2, 40, 55), (3, 60, 35), (4, 80, 15)]),
    "more loops than anyone counts": (LOOPS, 10**12, [(10**12, 100, 15)]),
    "without an end it is the loop that counts": (LOOPS, FOR_EVER, [(700, 0, 15)]),
    "nothing is known without a rehearsal": ((), 1, [(1, None, None)]),
    "nothing takes time": ([took((1, 0.0))], 1, [(1, 0, 0)]),
}  # fmt: skip


@every_row("name", RUNS)
def test_how_far_a_run_has_come(name):
    rehearsed, repeated, acts = RUNS[name]
    progress = RunProgress(rehearsed, repeated=repeated)
    assert progress.estimate(0.0) is UNKNOWN
    for loop, percent, left_s in acts:
        progress.begins(loop)
        found = progress.estimate(0.0).percent, progress.estimate(5.0).left_s
        assert found == pytest.approx((percent, left_s))
    if rehearsed:
        assert progress.estimate(0.0, 0.5).left_s == 2.0 * progress.estimate(0.0).left_s
