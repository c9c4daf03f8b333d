"""Scripted programs for tests of the program runner, and a pick-and-place program."""

from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from types import SimpleNamespace
from typing import Any

from program_acts import fingers, go, grasp, ready

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config, state_file
from armdrive.programs.acts import RunStage
from armdrive.programs.journal import Journal, resumed_plan
from armdrive.programs.problems import SourceMark
from armdrive.programs.running import Performer, ProgramRun, RunPlan
from armdrive.registry import simulate
from armdrive.sim.world.table import TableBlock
from armdrive.status import State
from armdrive.storage.record import RecordFile
from kinematics import Pose


class Keys:
    """A person who presses Enter at once; `taken` counts how often."""

    taken = 0

    @contextmanager
    def keys(self):
        yield self.take

    def take(self):
        self.taken += 1
        return True


class ScriptedMachine:
    """Yields its stages one after the other, and records the answers."""

    def __init__(self, stages, at=0, answers=()):
        self.stages = stages
        self.at = at
        self.answers = list(answers)

    def next(self):
        return self.stages[self.at] if self.at < len(self.stages) else None

    def answer(self, answer):
        self.answers.append(answer)
        self.at += 1

    def require_fingers_moved(self):
        """Its acts move the fingers at once."""

    def snapshot(self):
        return {"at": self.at, "answers": list(self.answers)}

    @property
    def fingerprint(self):
        return self.at


@dataclass
class Script:
    """A source of scripted machines, with one act in each line."""

    acts: tuple[Any, ...]
    made: list[ScriptedMachine] = field(default_factory=list)

    @property
    def stages(self):
        return [
            RunStage(act, SourceMark(number, 1, "t.arm")) for number, act in enumerate(self.acts, 1)
        ]

    def machine(self):
        self.made.append(ScriptedMachine(self.stages))
        return self.made[-1]

    __call__ = machine

    def restored(self, snapshot):
        return ScriptedMachine(self.stages, snapshot["at"], snapshot["answers"])


@dataclass
class Listener:
    """A person who records the texts, and never holds up the program."""

    said: list[str] = field(default_factory=list)
    held: list[str] = field(default_factory=list)

    def say(self, text):
        self.said.append(text)

    def hold(self, text, over):
        self.held.append(text)


def down(x, y, z):
    return Pose.of(x_mm=x, y_mm=y, z_mm=z, pitch_deg=-90)


PICK_AND_PLACE = (
    go(down(250, 60, 80), opening_mm=60.0),
    go(down(250, 60, 15), line=True, speed=0.7),
    grasp(),
    go(down(250, 60, 80), line=True),
    go(down(250, -60, 80)),
    go(down(250, -60, 16), line=True),
    fingers(55.0),
    go(down(250, -60, 80), line=True),
    ready(),
)
"""A program that carries block A from y 60 to y -60."""

BLOCK = TableBlock("A", 250.0, 60.0, 0.0, 30.0, 30.0)


def table_arm(dialect="teachmover", *blocks):
    """Return a simulated arm in its reference posture, with blocks on its table."""
    config = simulated_config(dialect)
    arm = Arm(connect_simulated(config, twin=twin_at_reference(config, blocks)))
    arm.enable()
    arm.reference.confirm()
    return arm


def twin_at_reference(config, blocks=()):
    """Return a simulated arm in its reference posture."""
    twin, reference = simulate(config, blocks=blocks), config.model.reference
    twin.device.bring_to(config.model.arm.ik(reference.pose), reference.opening_mm)
    return twin


def performer(arm, person=None):
    return Performer(arm, person or Listener())


# -- programs that are killed and resumed ---------------------------------------------------------


RESUME = "armdrive run t.arm --resume"


class Killed(BaseException):
    """The program was killed: it neither stops the arm nor closes anything."""


def kill(*_):
    raise Killed


@dataclass
class At:
    """Calls `act` at the beginning or the end of an act; acts count from 1."""

    number: int
    act: Any = kill
    when: str = "begins"
    begun: int = 0

    def begins(self, step, machine):
        self.begun += 1
        if (self.begun, "begins") == (self.number, self.when):
            self.act(step)

    def ended(self, step, answer, took_s):
        if (self.begun, "ended") == (self.number, self.when):
            self.act(step)


def recorded(config, twin):
    """Return an enabled arm that records its position."""
    recorder = RecordFile(state_file(config.name))
    arm = Arm(connect_simulated(config, twin=twin, record_store=recorder, allow_restored=True))
    if arm.status.state is State.DISABLED:
        arm.enable()
    return arm


def restarted(arm):
    """Return the arm as the next program finds it after a kill."""
    return recorded(arm.config, simulate(arm.config, arm.twin.save()))


def begin(arm, source, path, *onlookers, resume=False, sha256="0" * 64, loops=1):
    """Run a program with its journal, or resume it; return its first machine and its acts."""
    plan = RunPlan(source.machine, loops=loops)
    if resume:
        program = SimpleNamespace(digest=sha256)
        saved = SimpleNamespace(config=arm.config, program=program, restored=source.restored)
        plan = resumed_plan(plan, saved, path, arm, how=RESUME, move="armdrive move")
    first, performer = plan.first(), Performer(arm, Listener(), outputs=plan.outputs)
    journal = Journal(arm, performer, path.resolve(), sha256, plan.loops)
    before = [journal.begins, *(each.begins for each in onlookers)]
    after = [each.ended for each in onlookers]
    run = ProgramRun(replace(plan, machine=lambda: first), performer, before=before, after=after)
    run.carry_out()
    journal.finish()
    return first, run.done
