"""Every public call refuses what it cannot take with an `ArmError` of a code, and nothing happens.

The laws go through every public call and every parameter that its signature names. A call that is
added later is held to them as well.
"""

import asyncio
import copy
import functools
import inspect
import math
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from types import MappingProxyType
from unittest import mock

import numpy as np
import pytest
from amounts import every_row
from faults import as_it_stands, ready_arm

import kinematics as mathematics
from armdrive import (
    ArcPart,
    Arm,
    AsyncArm,
    AsyncHandle,
    BadArgument,
    BadRequest,
    Handle,
    Jog,
    JointPart,
    Joints,
    LinePart,
    MoveSequence,
    PathMove,
    PendantProgram,
    Point,
    Pose,
    Refused,
    SimulatedClock,
    UnknownPoint,
    WaitTimeout,
)
from armdrive.aio import AsyncGripper
from armdrive.arm.arguments import RULES
from armdrive.arm.moving import Gripper
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError, arguments, kinematic
from armdrive.errors.table import entry
from armdrive.moves import JointMove, LineMove, PoseMove
from armdrive.sim.faults import Faults
from armdrive.sim.world import World
from armdrive.storage import point_file
from armdrive.storage.point_file import Points
from armdrive.testing import ArmWorld

A_POSE = Pose.of(x_mm=250, y_mm=0, z_mm=120, pitch_deg=-90)
RIGHT = MappingProxyType(
    {
        "Callable[[], None]": print,
        "FaultRequest": None,
        "Jog": Jog.joint(shoulder=1),
        "Motion": LineMove(A_POSE),
        "Move": LineMove(A_POSE),
        "Joints | Pose": A_POSE,
        "Mapping[str, Point]": {},
        "PendantProgram": None,
        "Place": A_POSE,
        "Point": Point(Joints.of(0, 40, -60, -70, 0), None),
        "Point | None": None,
        "Pose": A_POSE,
        "Sequence[PathPart]": [LinePart(A_POSE)],
        "T | None": None,
        "TableBlock": None,
        "Task[T]": None,
        "TaskBody[T]": None,
        "float": 0.5,
        "int": 1,
        "str": "pick",
    }
)
"""A value for each parameter that has to be given, by its annotation."""

WRONG = (object(), 1j, [object()], b"x", {"a": object()}, math.nan, math.inf, "\0", None, True, 7)
"""Values of many kinds. A parameter is given those that its rule does not take."""

HOME = Joints.of(0, 40, -60, -70, 0)

BELOW = frozenset({"known", "carry", "sync"})
"""Calls that take anything, and what carries the calls of an `AsyncArm`."""

KINDS = (Arm, Gripper, Handle, Faults, World, Points)
TWINS = (AsyncArm, AsyncGripper, AsyncHandle)


def calls(kind: type) -> Iterator[tuple[str, inspect.Signature]]:
    """Give the public calls of a class that are checked, and the setters of its properties."""
    for name in dir(kind):
        found = inspect.getattr_static(kind, name)
        if name.startswith("_") or name in BELOW:
            continue
        if isinstance(found, classmethod):
            found = found.__func__
        if isinstance(found, property) and found.fset is not None:
            found = found.fset
        if inspect.isfunction(found) and hasattr(found, "__wrapped__"):
            yield name, inspect.signature(found)


def parameters() -> Iterator[tuple[type, str, str]]:
    for kind in KINDS:  # the calls of twins are made of these, with their checks
        for name, signature in calls(kind):
            for each in list(signature.parameters.values())[1:]:
                if each.annotation is not inspect.Parameter.empty:
                    yield kind, name, each.name


def rules_of(kind: type) -> Mapping[str, arguments.Rule]:
    return {**RULES, **point_file.RULES} if kind is Points else RULES


def refused(kind: type, name: str, parameter: inspect.Parameter) -> list[object]:
    """Return the values that a parameter does not take."""
    rule = arguments.rule_of(parameter.name, parameter.annotation, rules_of(kind))
    if rule is None:  # the rules of a simulated arm stand with it
        return [object(), 1j]
    found = []
    for value in WRONG:
        try:
            rule(parameter.name, value)
        except (ArmError, mathematics.KinematicsError):
            found.append(value)
    return found


@functools.cache
def bench() -> Arm:
    return ready_arm()


def owner(kind: type) -> object:
    """Return what the calls of a class are made of."""
    arm = bench()
    if kind is Handle:
        return done()
    twin = AsyncArm(arm)
    return {
        Arm: arm, Gripper: arm.gripper, Faults: arm.twin.faults, World: arm.twin.world,
        Points: arm.points, AsyncArm: twin, AsyncGripper: twin.gripper,
        AsyncHandle: AsyncHandle(done(), twin.carry),
    }[kind]  # fmt: skip


@functools.cache
def done() -> Handle:
    handle = bench().move_j(base_deg=0, wait=False)
    handle.wait()
    return handle


def make(kind: type, name: str, words: list[object], named: dict[str, object]) -> None:
    """Make a call, or set a property; await what is to be awaited."""
    if isinstance(inspect.getattr_static(kind, name), property):
        setattr(owner(kind), name, words[0])
        return
    made = getattr(owner(kind), name)(*words, **named)
    if hasattr(made, "__await__"):

        async def awaited() -> None:
            await made

        asyncio.run(awaited())


def seen() -> tuple[object, ...]:
    """Return all that a refused call must leave as it is."""
    done()
    arm = bench()
    status = arm.status
    return (
        len(arm.twin.link.sent), arm.twin.world.motors, status.state, status.acknowledged,
        status.trust, status.outputs, arm.parts.core.hold, list(arm.parts.core.nudges), arm.stops,
        arm.speed_override, status.paused, dict(arm.points), arm.twin.faults.active, arm.closed,
        arm.parts.pace.now_s(), arm.operator,
    )  # fmt: skip


def given(signature: inspect.Signature, wrong: str, value: object):
    """Return arguments that are right but for one."""
    words, named = [], {}
    for each in list(signature.parameters.values())[1:]:
        if each.name == wrong:
            use = value
        elif each.default is not inspect.Parameter.empty or "VAR" in each.kind.name:
            continue
        else:
            use = RIGHT[each.annotation]
        if each.kind is inspect.Parameter.KEYWORD_ONLY:
            named[each.name] = use
        elif each.kind is inspect.Parameter.VAR_KEYWORD:
            named["base_deg" if "Joint" in each.annotation else "x_mm"] = use
        else:
            words.append(use)
    return words, named


@every_row("kind, name, wrong", parameters(), ids=str)
def test_a_wrong_argument_is_refused_by_name_and_nothing_happens(kind, name, wrong):
    signature = dict(calls(kind))[name]
    values = refused(kind, name, signature.parameters[wrong])
    if signature.parameters[wrong].annotation == "object":
        return
    assert values
    for value in values:
        words, named = given(signature, wrong, value)
        before = seen()
        with pytest.raises(ArmError) as raised:
            make(kind, name, words, named)
        assert seen() == before
        error = raised.value
        assert entry(error).code == error.code
        assert issubclass(type(error), BadRequest), error
        # one that has to be given first is refused first, where there is no right one here
        firsts = [each for each in signature.parameters if each != "self"]
        assert any(
            word in str(error)
            for word in (*firsts[: firsts.index(wrong) + 1], "base_deg", "x_mm", "a must")
        ), error


@every_row(
    "kind, name",
    [(kind, name) for kind in KINDS for name, _ in calls(kind)],
    ids=str,
)
def test_a_wrong_count_and_an_unknown_option_are_refused(kind, name):
    signature = dict(calls(kind))[name]
    kinds = {each.kind for each in signature.parameters.values()}
    before = seen()
    if isinstance(inspect.getattr_static(kind, name), property):
        return
    if inspect.Parameter.VAR_POSITIONAL not in kinds:
        with pytest.raises(BadArgument, match=rf"{name}\(\): too many positional arguments"):
            make(kind, name, [object()] * 12, {})
    if inspect.Parameter.VAR_KEYWORD not in kinds:
        with pytest.raises(BadArgument, match=r"unexpected keyword argument|required argument"):
            make(kind, name, [], {"spede": 1})
    needed = [
        each.name
        for each in list(signature.parameters.values())[1:]
        if each.default is inspect.Parameter.empty and "VAR" not in each.kind.name
    ]
    if needed:
        with pytest.raises(BadArgument, match=f"missing a required argument: '{needed[0]}'"):
            make(kind, name, [], {})
    assert seen() == before


@every_row("kind, name, time", [each for each in parameters() if each[2].endswith("_s")], ids=str)
def test_a_time_below_zero_is_refused_and_nothing_happens(kind, name, time):
    words, named = given(dict(calls(kind))[name], time, -0.5)
    before = seen()
    with pytest.raises(BadRequest, match=f"^{time} must be 0 or more seconds, not -0.5"):
        make(kind, name, words, named)
    assert seen() == before


@every_row("time_s", [-0.5, math.nan, math.inf, "1", None])
def test_a_world_of_a_test_takes_no_time_that_is_none(time_s):
    with pytest.raises(BadRequest, match=r"^by_s must "):
        ArmWorld().after(time_s, print)
    if time_s != -0.5:  # the origin of a clock is anywhere
        with pytest.raises(BadRequest, match=r"^now_s must be a finite"):
            SimulatedClock(time_s)


@every_row("kind", [Arm, Gripper, Handle, AsyncArm, AsyncHandle, Points])
def test_every_annotation_of_a_public_call_has_a_rule(kind):
    for name, signature in calls(kind):
        for each in list(signature.parameters.values())[1:]:
            if each.annotation is not inspect.Parameter.empty:
                found = arguments.rule_of(each.name, each.annotation, rules_of(kind))
                assert found is not None, f"{name}: give {each.annotation!r} a rule"


@every_row("kind", [Arm, Gripper, Handle, Points])
def test_every_public_call_is_checked(kind):
    for name in dir(kind):
        found = inspect.getattr_static(kind, name)
        if not name.startswith("_") and inspect.isfunction(found):
            assert hasattr(found, "__wrapped__"), name


# Attributes that a program assigns.


def others() -> dict[type, Callable[[], object]]:
    """Return how to make objects of the public classes that have no checked calls."""
    return {
        ArmWorld: ArmWorld,
        SimulatedClock: SimulatedClock,
    }


@every_row("kind", [*KINDS, *TWINS, *others()], ids=str)
def test_an_unknown_attribute_is_refused_and_not_created(kind):
    thing = others()[kind]() if kind in others() else owner(kind)
    with pytest.raises(BadArgument, match=f"^{kind.__name__} has no attribute 'zzz'\n"):
        thing.zzz = 1
    assert not hasattr(thing, "zzz")
    thing._private = 1


@every_row("kind", [Arm, AsyncArm])
@every_row(
    "name, said",
    [
        ("speed_overide", r"has no attribute 'speed_overide'; did you mean 'speed_override'\?\n"),
        ("speed_overrides", "did you mean 'speed_override'"),
        ("pause", r"\.pause is a call, not a value: write pause\(\.\.\.\)\n"),
        ("estop", "is a call"),
        ("paus", "has no attribute 'paus'\n"),  # neither a call nor what is only read is near
    ],
)
def test_a_misspelt_attribute_changes_nothing_and_the_nearest_one_is_named(kind, name, said):
    before = seen()
    with pytest.raises(BadArgument, match=f"^{kind.__name__}.*{said}"):
        setattr(owner(kind), name, 0.5)
    assert seen() == before


def test_checked_objects_still_work_in_python():
    arm, clock = bench(), SimulatedClock()
    with mock.patch.object(arm, "stop") as stopped:
        arm.stop()
        with pytest.raises(BadArgument, match="is a call"):  # also while another one replaces it
            arm.stop = True
    stopped.assert_called_once_with()
    assert "stop" not in vars(arm)
    assert mock.create_autospec(Arm, instance=True).speed_override is not None
    again = copy.copy(clock)
    again.now_s = 2.0
    assert (clock.now_s, again.now_s) == (0.0, 2.0)
    with pytest.raises(BadArgument, match="did you mean 'now_s'"):
        again.now = 3.0
    assert list(inspect.signature(Arm).parameters) == ["parts"]


def test_a_subclass_has_attributes_of_its_own():
    class Counted(Handle):
        def __init__(self, *words):
            super().__init__(*words)
            self.calls = 0

    counted = Counted(None, None, 1.0)
    counted.later = 1
    assert (counted.calls, counted.later) == (0, 1)


# What the sentences say.

FAR = Pose.of(x_mm=1000, y_mm=0, z_mm=100, pitch_deg=0)


@every_row(
    "call, said",
    [
        (
            lambda arm: arm.move_to((1, 2, 3)),
            r"^goal must be a pose, joint angles, a point .* not \(1, 2, 3\)",
        ),
        (lambda arm: arm.move_j(30), r'not 30; for example {"shoulder_deg": 40}, or as keywords'),
        (lambda arm: arm.move_j(), "for example shoulder_deg=40"),
        (lambda arm: arm.move_j(shoulder_deg="x"), "shoulder_deg must be a finite number"),
        (lambda arm: arm.move_j(sholder_deg=3), "did you mean 'shoulder_deg'"),
        (lambda arm: arm.move_j(shoulder_rad=3), r"; write shoulder_deg=math\.degrees\(\.\.\.\)\n"),
        (lambda arm: arm.move_j(base_deg=3, sped=0.5), "did you mean 'speed'"),
        (lambda arm: arm.move_j({"base_deg": 1}, base_deg=2), "base_deg is given twice"),
        (lambda arm: arm.preview(JointMove({"sholder_deg": 3})), "did you mean 'shoulder_deg'"),
        (
            lambda arm: arm.preview(A_POSE),
            r"^move must be a move, not Pose.*for example LineMove\(",
        ),
        (lambda arm: arm.move_path([]), "at least one part"),
        (lambda arm: arm.move_to(HOME, frame="tool"), "the same in every frame"),
        (lambda arm: arm.run(PoseMove("pick", frame="tool")), "the same in every frame"),
        (lambda arm: arm.gripper.grasp(force_n=36.0), "0 to 35 N, not 36"),
        (lambda arm: arm.gripper.grasp(force_n=-1.0), "0 to 35 N, not -1"),
        (lambda arm: arm.move_path("abc"), "^parts must be a list of parts"),
        (
            lambda arm: arm.move_path([JointPart(Joints((1.0,), ("turret",)))]),
            "a goal for this arm needs the joints base, .* not turret",
        ),
        (lambda arm: arm.move_path([A_POSE]), r"^parts\[0\] must be a part of a path"),
        (
            lambda arm: arm.move_to(A_POSE, sped=1),
            r"'sped'; did you mean 'speed'\?; it takes goal,",
        ),
        (lambda arm: arm.move_motors(1, 2), "6 step counts are needed"),
        (lambda arm: arm.move_motors(1.5, 0, 0, 0, 0, 0), "steps must be a whole number, not 1.5"),
        (
            lambda arm: arm.move_motors(10**9, 0, 0, 0, 0, 0),
            "would turn for .* at most 600 s: use fewer steps or a higher speed; nothing was moved",
        ),
        (lambda arm: arm.jog_j(base_deg=1, sped=1), "did you mean 'speed'"),
        (lambda arm: arm.run(LineMove("nowhere")), "nowhere"),
        (lambda arm: arm.start(LineMove(A_POSE, frame="moon")), "no frame is called 'moon'"),
        (lambda arm: arm.io.set(99), "counted from 1 to"),
        (lambda arm: arm.io.wait(high="x"), "for example high=3, or high="),
        (lambda arm: arm.pose_in(5), 'frame must be the name of a frame, not 5; .* "base"'),
        (lambda arm: Arm.connect(5), 'target must be .* for example "sim:teachmover"'),
        (lambda arm: Arm.connect("sim:x"), "no dialect is named 'x'"),
        (
            lambda arm: Arm.connect("sim:grbl", dialect="mks"),
            "the dialect of sim:grbl is grbl, not mks: leave dialect out",
        ),
        (lambda arm: Arm.connect("sim:grbl", baud=9600), "the baud of sim:grbl is 115200, not"),
        (lambda arm: Arm.connect("sim:grbl", dialct="grbl"), "did you mean 'dialect'"),
        (lambda arm: Arm.connect("sim:grbl", pace="slow"), "pace must be"),
        (lambda arm: Arm.connect("sim:grbl", twin=5), "twin must be a simulated arm"),
        (lambda arm: AsyncArm.connect(5), "target must be the name of an arm"),
        (lambda arm: arm.twin.faults.add("drop", "x"), "'x' is not a number"),
        (lambda arm: arm.points[5], "name must be text, not 5"),
        (lambda arm: Jog("joint", (("base", 1),)), "space must be Space.JOINT or"),
    ],
)
def test_the_sentence_says_what_was_expected(call, said):
    before = seen()
    with pytest.raises(BadRequest, match=said) as raised:
        call(bench())
    assert seen() == before
    assert raised.value.code == entry(raised.value).code


AT_A_SPEED = {
    "move_j": lambda arm, speed: arm.move_j(base_deg=1, speed=speed),
    "gripper.open": lambda arm, speed: arm.gripper.open(20.0, speed=speed),
    "speed_override": lambda arm, speed: setattr(arm, "speed_override", speed),
}


@every_row("speed", [0.0, -0.5, 1.01, 5])
@every_row("name", AT_A_SPEED)
def test_a_speed_that_is_no_fraction_is_refused(name, speed):
    before = seen()
    with pytest.raises(BadRequest, match=r"speed.*(fraction|above 0 and up to 1|from )"):
        AT_A_SPEED[name](bench(), speed)
    assert seen() == before


def test_a_wrong_argument_is_a_type_error_as_well():
    with pytest.raises(TypeError):
        bench().move_to((1, 2, 3))
    assert (BadArgument.code, WaitTimeout.code) == ("E115", "E106")


@every_row(
    "made, said",
    [
        (lambda: MoveSequence(LineMove(A_POSE)), "moves must be a list of moves, not LineMove"),
        (lambda: MoveSequence((LineMove(A_POSE), 1)), r"moves\[1\] must be a move, not 1"),
        (lambda: PathMove(LinePart(A_POSE)), "parts must be a list of parts, not LinePart"),
        (lambda: Point("pick"), "joints must be joint angles, not 'pick'"),
        (lambda: Point(HOME, note=5), "note must be text, not 5"),
        (lambda: Point(HOME, note="\udcff"), "note must be text that a file can hold, not"),
        (lambda: Point(HOME, taught="now"), "taught must be a date and a time, not 'now'"),
        (lambda: PendantProgram("rows"), "rows must be the rows of a program, not 'rows'"),
        (lambda: SimulatedClock("noon"), "now_s must be a finite number, not 'noon'"),
        (lambda: Point(HOME, "wide"), "opening_mm must be a finite number, not 'wide'"),
        (lambda: Arm.connect(""), "the name of the arm is empty: name one"),
        (lambda: Arm("bench"), r'parts of a connection, not .bench.; for example Arm.connect\("'),
        (lambda: AsyncArm("bench"), r'for example AsyncArm.connect\("'),
        (lambda: ArmWorld(5), "target must be the name of an arm, not 5"),
    ],
)
def test_a_value_that_cannot_be_is_refused_where_it_is_made(made, said):
    with pytest.raises(BadRequest, match=said) as raised:
        made()
    assert raised.value.code in ("E101", "E115", "E602")


@pytest.mark.parametrize("dialect", ["teachmover", "robko01", "armdroid"])
def test_writing_settings_is_refused_without_settings(dialect):
    with (
        Arm(connect_simulated(simulated_config(dialect))) as arm,
        pytest.raises(Refused, match="has no settings that can be written"),
    ):
        arm.controller.fix_settings(["$100=250"])


def test_the_message_about_an_unknown_point_has_no_quotes_around_it():
    with pytest.raises(UnknownPoint) as raised:
        bench().move_to("nowhere")
    assert str(raised.value).startswith("there is no point 'nowhere'")


def test_numbers_of_numpy_are_numbers():
    arm = ready_arm()
    arm.move_j(base_deg=np.float64(5), speed=np.float32(0.5))
    assert arm.joints.base_deg == pytest.approx(5, abs=0.2)
    arm.move_j({"base_deg": np.int64(0)}, wait=np.True_)
    arm.move_motors(*np.ones(6, dtype=int))
    arm.io.set(np.int32(1), np.False_)
    arm.io.set(1, 1)
    assert arm.status.outputs == 1


@every_row(
    "call, kind, code",
    [
        (lambda arm: arm.move_to(FAR), kinematic.Unreachable, "E604"),
        (lambda arm: arm.move_l(FAR), kinematic.Unreachable, "E604"),
        (lambda arm: arm.move_path([LinePart(FAR)]), kinematic.Unreachable, "E604"),
        (lambda arm: arm.move_c(FAR, FAR), kinematic.NoArc, "E618"),
        (lambda arm: arm.move_path([ArcPart(FAR, FAR)]), kinematic.NoArc, "E618"),
        *(
            (call, kinematic.BadNumber, "E602")
            for call in (
                lambda arm: arm.move_j(base_deg=math.nan),
                lambda arm: arm.move_j(base_deg=True),
                lambda arm: arm.jog_j(base_deg=True),
                lambda arm: arm.gripper.open(True),
                lambda arm: arm.move_motors(True, 0, 0, 0, 0, 0),
            )
        ),
        (lambda arm: arm.reference.declare(FAR), kinematic.Unreachable, "E604"),
        (
            lambda arm: arm.reference.declare(Joints.of(500, 0, 0, 0, 0)),
            kinematic.JointLimit,
            "E603",
        ),
        (
            lambda arm: arm.move_to(replace(A_POSE, yaw_rad=0.0)),
            kinematic.KinematicsError,
            "E601",
        ),
    ],
)
def test_a_refusal_of_the_kinematics_is_an_error_of_both_packages(call, kind, code):
    arm, before = bench(), seen()
    with pytest.raises(getattr(mathematics, kind.__name__)) as raised:
        call(arm)
    error = raised.value
    assert isinstance(error, kind)
    assert isinstance(error, ArmError)
    assert error.code == code
    assert seen() == before


def test_a_refusal_keeps_what_the_error_of_the_kinematics_tells():
    with pytest.raises(ArmError) as raised:
        bench().move_to(FAR)
    error = raised.value
    assert error.goal == FAR
    assert error.nearest.x_mm < 500
    assert error.excess > 100
    assert error.exit_code == 3
    assert "out of reach" in str(error)
    problem = bench().preview(PoseMove(FAR)).refusal
    assert isinstance(problem, kinematic.Unreachable)
    assert problem.code == "E604"


def test_an_error_of_the_kinematics_that_has_no_twin_keeps_its_sentence():
    error = mathematics.ZeroVector()
    assert str(kinematic.refusal_of(error)) == str(error)
    assert type(kinematic.refusal_of(error)) is kinematic.KinematicsError
    broken = kinematic.refusal_of(mathematics.PathBroken(0.5, A_POSE, "too far"))
    assert (type(broken), broken.fraction, broken.code) == (kinematic.PathBroken, 0.5, "E605")
    assert kinematic.refusal_of(broken) is broken


def test_a_wait_that_times_out_has_its_own_error():
    arm = ready_arm()
    handle = arm.move_j(base_deg=60, speed=0.1, wait=False)
    with pytest.raises(WaitTimeout, match="had not ended after") as raised:
        handle.wait(0.01)
    assert isinstance(raised.value, TimeoutError)
    assert raised.value.code == "E106"
    assert not handle.done
    handle.wait(math.inf)
    assert arm.joints.base_deg == pytest.approx(60, abs=0.2)


def test_joints_give_their_angles_by_name():
    joints = Joints((1.0, -0.5), ("base", "turret"))
    assert joints.base_rad == 1.0
    assert joints.turret_deg == pytest.approx(math.degrees(-0.5))
    assert "turret_deg" in dir(joints)
    with pytest.raises(AttributeError, match="'turet_deg'; did you mean 'turret_deg'"):
        joints.turet_deg  # noqa: B018 - the look-up is the test
    with pytest.raises(AttributeError, match="no attribute 'elbow_deg'"):
        joints.elbow_deg  # noqa: B018
    assert not hasattr(joints, "_turret")
    with pytest.raises(mathematics.KinematicsError, match="did you mean 'turret'"):
        joints["turet"]


# What a person sees at Python's prompt.


def test_an_arm_at_the_prompt_shows_its_name_state_and_trust():
    with Arm.connect("sim:grbl") as arm:
        twin = AsyncArm(arm)
        assert repr(arm) == "<Arm sim:grbl, SIMULATED: standby, position unknown>"
        as_it_stands(arm)
        handle = arm.move_j(base_deg=5, wait=False)
        assert repr(handle) == "<Handle: under way>"
        handle.wait()
        assert repr(handle) == "<Handle: done>"
        stopped = arm.move_j(base_deg=0, wait=False)
        stopped.cancel()
        assert repr(AsyncHandle(stopped, twin.carry)) == "<AsyncHandle: ended by Stopped>"
        assert repr(twin) == "<AsyncArm sim:grbl, SIMULATED: standby, position referenced>"
        assert repr(twin.gripper) == "<AsyncGripper of sim:grbl>"
        assert repr(arm.points) == f"<Points in {arm.points.path}>"
        assert repr(SimulatedClock(1.5)) == "SimulatedClock(1.5)"
        arm.estop()
        assert "error-stop" in repr(arm)
    assert repr(arm) == "<Arm sim:grbl, SIMULATED: closed, position referenced>"


def test_an_arm_at_the_prompt_is_shown_while_the_engine_is_at_work():
    arm, seen = bench(), []
    with arm.parts.pace.lock:
        thread = threading.Thread(target=lambda: seen.append(repr(arm)))
        thread.start()
        thread.join(timeout=10.0)
    assert seen


# Joints by their names.

TURNED = Joints.of(3, 40, -60, -70, 5)
OTHER_ORDER = Joints(TURNED.angles_rad[::-1], TURNED.names[::-1])
"""The same posture, whose joints stand in another order."""


@pytest.mark.parametrize(
    "call",
    [
        lambda arm: arm.run(JointMove(OTHER_ORDER)),
        lambda arm: arm.run(LineMove(OTHER_ORDER)),
        lambda arm: arm.move_to(Point(OTHER_ORDER)),
        lambda arm: arm.move_l(Point(OTHER_ORDER)),
        lambda arm: arm.move_path([JointPart(OTHER_ORDER)]),
        lambda arm: arm.reference.declare(OTHER_ORDER),
    ],
)
def test_joints_are_known_by_their_names_and_not_by_their_order(call):
    arm = ready_arm()
    call(arm)
    assert arm.joints.deg == pytest.approx(TURNED.deg, abs=0.5)
