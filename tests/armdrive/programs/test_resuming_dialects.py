"""On every controller a program that was interrupted ends where the uninterrupted one does."""

from functools import partial

import pytest
from running_bench import At, Killed, begin, recorded, restarted, twin_at_reference

from armdrive.connect.target import simulated_config
from armdrive.errors import Stopped
from armdrive.programs.program import ArmProgram, read_program
from armdrive.registry import DIALECTS

TOUR = """\
point a = at(145, 10, 30, -90)
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
move at(145, -5 * count, 30, -90)
"""


def homed(dialect):
    config = simulated_config(dialect)
    arm = recorded(config, twin_at_reference(config))
    arm.confirm_reference()
    return arm


@pytest.fixture
def run(tmp_path):
    """Run or resume the program on an arm; returns the number of acts."""
    program = read_program(TOUR, "t.arm")

    def carried_out(arm, *onlookers, resume=False):
        source = ArmProgram(program, arm.config)
        path, sha256 = tmp_path / "t.arm", program.digest
        return begin(arm, source, path, *onlookers, resume=resume, sha256=sha256)[1]

    return carried_out


@pytest.mark.parametrize("dialect", DIALECTS)
def test_killed_or_stopped_it_goes_on_and_ends_where_it_should(dialect, run):
    arm = homed(dialect)
    done, end = run(arm), arm.twin.world.joints.angles_rad

    arm = homed(dialect)
    for number, resume in ((2, False), (done - 1, True)):  # the second counts from the first
        with pytest.raises(Killed):
            run(arm, At(number), resume=resume)
        arm.sleep(3.0)
        arm = restarted(arm)
    assert run(arm, resume=True) == 1
    assert arm.twin.world.joints.angles_rad == pytest.approx(end, abs=0.01)

    arm, stops, resume = homed(dialect), [], False

    def stop_soon(step):
        if step.moves and step.mark.line not in stops:
            stops.append(step.mark.line)
            device = arm.twin.device
            device.at(device.now_s + 0.3, arm.request_stop)

    stopping = partial(run, arm, *(At(number, stop_soon) for number in range(1, 30)))
    for _ in range(20):
        try:
            stopping(resume=resume)
        except Stopped:
            resume = True
        else:
            break
    assert len(stops) >= 3
    assert arm.twin.world.joints.angles_rad == pytest.approx(end, abs=0.01)
