"""On every controller a program that was interrupted ends where the uninterrupted one does."""

from dataclasses import dataclass

import pytest
from running_bench import Listener, standing_twin

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config, state_file
from armdrive.errors import Stopped
from armdrive.programs.journal import Journal, interrupted, require_place, require_same_program
from armdrive.programs.program import ArmProgram, read_program
from armdrive.programs.running import Performer, ProgramRun, RunPlan
from armdrive.registry import DIALECTS
from armdrive.registry.simulate import simulate
from armdrive.status import State
from armdrive.storage.record import FileRecorder

TOUR = """\
point a = at(180, 10, 50, -90)
move a
count = 1
repeat 2 as turn
  move_line shifted(a, 0, 0, -10 * turn)
  if turn > 1
    open_now 20
    count = count + turn
  end
end
delay 0.5
move at(180, -5 * count, 50, -90)
"""


class Killed(BaseException):
    """The program is no more."""


@dataclass
class At:
    """Does something when an act of this number begins."""

    number: int
    act: object

    def begins(self, step, machine):
        if step.number == self.number:
            self.act(step)

    def ended(self, step, answer, took_s):
        pass


def kill(step):
    raise Killed


def connected(config, twin):
    recorder = FileRecorder(state_file(config.name))
    arm = Arm(connect_simulated(config, twin=twin, recorder=recorder, allow_restored=True))
    if arm.status.state is State.DISABLED:
        arm.enable()
    return arm


def homed(dialect):
    config = simulated_config(dialect)
    arm = connected(config, standing_twin(config))
    arm.confirm_reference()
    return arm


def run(arm, tmp_path, *onlookers, resume=False):
    program = read_program(TOUR, "t.arm")
    source = ArmProgram(program, arm.config)
    machine, outputs = None, 0
    if resume:
        entry = interrupted(arm.config.name)
        require_same_program(entry, program.digest, "t.arm")
        machine, outputs = source.restored(entry.snapshot), entry.outputs
        require_place(arm, entry, machine.next().act, "armdrive run t.arm --resume")
    performer = Performer(arm, Listener(), outputs=outputs)
    journal = Journal(arm, performer, tmp_path / "t.arm", program.digest, 1)
    plan = RunPlan(source.machine, machine=machine and (lambda: machine))
    made = ProgramRun(plan, performer, [journal, *onlookers])
    made.carry_out()
    journal.finish()
    return made.done


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    """Where each controller's arm ends, and after how many acts."""
    ends = {}

    def ended(dialect):
        if dialect not in ends:
            arm = homed(dialect)
            done = run(arm, tmp_path_factory.mktemp(dialect))
            ends[dialect] = (arm.twin.world.joints, done)
        return ends[dialect]

    return ended


def same_end(arm, uninterrupted, dialect):
    joints, _ = uninterrupted(dialect)
    return arm.twin.world.joints.angles_rad == pytest.approx(joints.angles_rad, abs=0.01)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_killed_between_two_acts_it_goes_on_and_ends_where_it_should(
    dialect, uninterrupted, tmp_path
):
    done = uninterrupted(dialect)[1]
    arm = homed(dialect)
    for number in (2, done):
        with pytest.raises(Killed):
            run(arm, tmp_path, At(number, kill))
        arm.sleep(3.0)
        arm = connected(arm.config, simulate(arm.config, arm.twin.save()))
        assert run(arm, tmp_path, resume=True) == done - number + 1
        assert same_end(arm, uninterrupted, dialect)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_stopped_in_every_motion_it_goes_on_and_ends_where_it_should(
    dialect, uninterrupted, tmp_path
):
    arm = homed(dialect)
    stops = []

    def stop_soon(step):
        if step.moves and step.mark.line not in stops:
            stops.append(step.mark.line)
            device = arm.twin.device
            device.at(device.now_s + 0.3, arm.request_stop)

    resume = False
    for _ in range(20):
        try:
            run(arm, tmp_path, *(At(number, stop_soon) for number in range(1, 30)), resume=resume)
        except Stopped:
            resume = True
        else:
            break
    assert len(stops) >= 3
    assert same_end(arm, uninterrupted, dialect)
