"""Programs without an arm: their acts get replies from a table."""

import json

import pytest
from program_acts import goal_of, travels

from armdrive.moves import GraspMove
from armdrive.programs import read_program
from armdrive.programs.acts import AwaitInputs, Go, Look, ReadInput, Say
from armdrive.programs.language.values import PlaceValue
from armdrive.programs.problems import ProgramError
from kinematics import JOINT_NAMES, Joints, Pose, preset

HERE_DEG = {"base": 0.0, "shoulder": 40.0, "elbow": -60.0, "wrist_pitch": -70.0, "wrist_roll": 0.0}
BOOK = {
    "pick": HERE_DEG,
    "Place-2": {**HERE_DEG, "base": 30.0},
    "tray": {**HERE_DEG, "base": -20.0},
}
MOST = 2000


def fk(joints_deg):
    return preset("teachmover").arm.fk(Joints.of(*(joints_deg[name] for name in JOINT_NAMES)))


HERE = PlaceValue(Pose.of(x_mm=200.0, y_mm=0.0, z_mm=100.0, pitch_deg=-90.0), HERE_DEG, 40.0)


def at(x, y, z, pitch=-90.0, roll=0.0):
    return Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=pitch, roll_deg=roll)


def started(text, points=BOOK, joint_names=JOINT_NAMES):
    return read_program(text, "test.arm").machine(points, fk, joint_names)


def reply(act, inputs=(), widths=None):
    match act:
        case Look():
            return HERE
        case ReadInput():
            return act.number in inputs
        case AwaitInputs():
            return set(act.high) <= set(inputs) and not set(act.low) & set(inputs)
        case Go(GraspMove()):
            return widths.pop(0) if widths else 30.0
    return None


def run(machine, inputs=(), widths=None):
    """Return all acts up to the end; check that every state can be saved and restored."""
    acts, widths = [], list(widths or [])
    for _ in range(MOST):
        stage = machine.next()
        again = machine.program.restored(json.loads(json.dumps(machine.snapshot())), fk=fk)
        assert again.next() == stage
        if stage is None:
            return acts
        acts.append(stage.act)
        machine.answer(reply(stage.act, inputs, widths))
    raise AssertionError("no end")


def acts(text, *, inputs=(), widths=None, points=BOOK):
    return run(started(text, points), inputs, widths)


def told(text, **more):
    """Return the texts that a program says."""
    return [act.text for act in acts(text, **more) if isinstance(act, Say)]


def goals(text, **more):
    return [goal_of(act) for act in acts(text, **more) if travels(act)]


def refused(text, **more):
    """Return all problems of a program: line, column, text."""
    with pytest.raises(ProgramError) as caught:
        acts(text, **more)
    return [(each.mark.line, each.mark.column, each.text) for each in caught.value.problems]
