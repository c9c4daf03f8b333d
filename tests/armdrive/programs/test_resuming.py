"""Programs interrupted at every act by a kill, a stop, a fault or a pulled cable: which resume."""

from functools import partial

import pytest
from amounts import THOROUGH, amount
from program_acts import go
from running_bench import (
    BLOCK,
    PICK_AND_PLACE,
    At,
    Killed,
    Script,
    begin,
    down,
    recorded,
    restarted,
    twin_at_reference,
)

from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError, NotReferenced, Refused, StateFileError, Stopped
from armdrive.moves import GripperMove, MoveSequence
from armdrive.programs.acts import Home, Outputs
from armdrive.programs.journal import (
    interrupted,
    journal_file,
    require_same_program,
)
from armdrive.programs.program import ArmProgram, read_program
from armdrive.registry import DIALECTS, simulate
from armdrive.status import Trust

ACTS = range(1, len(PICK_AND_PLACE) + 1)


@pytest.fixture
def path(tmp_path):
    return tmp_path / "t.arm"


@pytest.fixture
def arm():
    """An arm whose record outlives it, with a block on its table."""
    config = simulated_config("teachmover")
    made = recorded(config, simulate(config, blocks=[BLOCK]))
    made.home()
    return made


def killed(arm, path, number, when="begins", acts=PICK_AND_PLACE):
    """Return a program that was killed at the beginning or the end of an act."""
    script = Script(acts)
    with pytest.raises(Killed):
        begin(arm, script, path, At(number, when=when))
    return script


def resume(arm, script, path):
    machine, _ = begin(arm, script, path, resume=True)
    return machine


def placed(arm):
    """Tell whether the block stands where the program brings it, and the arm holds nothing."""
    x_mm, y_mm, z_mm = arm.twin.world.scene.blocks["A"].place
    there = abs(x_mm - 250) < 1.5 and abs(y_mm + 60) < 1.5 and abs(z_mm) < 0.1
    return there and arm.twin.world.scene.held is None and not arm.twin.world.incidents


def test_an_uninterrupted_program_leaves_no_journal(arm, path):
    begin(arm, Script(PICK_AND_PLACE), path)
    assert placed(arm)
    assert not journal_file(arm.config.name).exists()
    with pytest.raises(Refused, match="no program of sim:teachmover was interrupted"):
        interrupted(arm.config.name)


@pytest.mark.parametrize(
    ("number", "when"),
    [*((act, "begins") for act in ACTS[:: amount(3, 1)]), (1, "ended"), (3, "ended"), (9, "ended")],
)
def test_a_program_killed_at_any_act_resumes_and_ends_the_same(arm, path, number, when):
    script = killed(arm, path, number, when)
    assert interrupted(arm.config.name).line == number
    arm.sleep(3.0)  # it has stood for a while when the program is begun again
    again = restarted(arm)
    machine = resume(again, script, path)
    assert placed(again)
    assert machine.answers[2] == pytest.approx(30, abs=1)


TIMES = amount(3, 28)


@pytest.mark.parametrize("after_s", [0.2 + 26.6 * number / TIMES for number in range(TIMES)])
def test_a_program_stopped_twice_at_any_time_ends_the_same(arm, path, after_s):
    script = Script(PICK_AND_PLACE)
    device = arm.twin.device
    device.at(device.now_s + after_s, arm.request_stop)
    with pytest.raises(Stopped):
        begin(arm, script, path)
    device.at(device.now_s + 0.7, arm.request_stop)
    with pytest.raises(Stopped):
        resume(arm, script, path)
    machine = resume(arm, script, path)
    assert placed(arm)
    assert machine.answers[2] == pytest.approx(30, abs=1)


def test_after_a_pulled_cable_and_a_reference_the_error_says_where_to_bring_the_arm(arm, path):
    script = Script(PICK_AND_PLACE)
    device = arm.twin.device
    device.at(device.now_s + 12.0, arm.twin.link.unplug)
    with pytest.raises(ArmError):
        begin(arm, script, path)
    again = restarted(arm)
    with pytest.raises(NotReferenced):
        resume(again, script, path)
    again.twin.world.take("A")  # as whoever guides it to its reference has to
    again.home()
    with pytest.raises(Refused, match="--joint base=") as refused:
        resume(again, script, path)
    assert "check that the fingers still hold what they held" in str(refused.value)


@pytest.mark.parametrize(
    ("meanwhile", "why"),
    [
        (lambda arm: arm.move_j(base_deg=40), r"base 40\.0° instead of"),
        (lambda arm: arm.gripper.open(), "fingers 76.0 mm instead of"),
    ],
)
def test_a_program_does_not_resume_if_the_arm_stands_otherwise(arm, path, meanwhile, why):
    script = killed(arm, path, 5)
    meanwhile(arm)
    with pytest.raises(Refused, match=why):
        resume(arm, script, path)


def test_another_or_a_changed_program_does_not_resume(arm, path):
    killed(arm, path, 5)
    entry = interrupted(arm.config.name)
    with pytest.raises(Refused, match="was changed since it was interrupted in line 5"):
        require_same_program(entry, "1" * 64, entry.program)
    with pytest.raises(Refused, match=r"and not other\.arm"):
        require_same_program(entry, "1" * 64, "other.arm")


def test_a_damaged_journal_says_so(arm, path):
    killed(arm, path, 5)
    path = journal_file(arm.config.name)
    other = path.read_text().replace("under", "over").replace("30", "31")
    for text, words in (("", "is empty"), *((text, "is damaged") for text in ("[1]", other, "{}"))):
        path.write_text(text)
        with pytest.raises(StateFileError, match=f"cannot be used: it {words}"):
            interrupted(arm.config.name)
    path.unlink()
    path.mkdir()
    with pytest.raises(StateFileError, match="cannot be read"):
        interrupted(arm.config.name)


def test_a_disk_that_is_full_lets_no_act_begin(arm, path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("armdrive.programs.journal.replace_durably", full)
    before = arm.joints
    with pytest.raises(StateFileError, match="No space left"):
        begin(arm, Script(PICK_AND_PLACE), path)
    assert arm.joints == before


def test_a_journal_that_cannot_be_removed_says_that_it_could_be_resumed(arm, path, monkeypatch):
    def fail(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("armdrive.programs.journal.remove_durably", fail)
    with pytest.raises(StateFileError, match=r"has ended, but .* could be resumed once more"):
        begin(arm, Script(PICK_AND_PLACE), path)


def test_resuming_a_sequence_does_only_the_remaining_steps(arm, path):
    """The fingers were open and the arm on its way: only the way is left."""
    act = go(down(250, 60, 80), opening_mm=60.0)
    script = Script((act,))
    device = arm.twin.device
    takes_s = arm.preview(act.move).duration_s
    device.at(device.now_s + 0.8 * takes_s, arm.request_stop)
    with pytest.raises(Stopped):
        begin(arm, script, path)
    opened, way = interrupted(arm.config.name).move.moves
    assert opened == GripperMove(60.0)
    left = []
    begin(arm, script, path, At(1, lambda step: left.append(step.move)), resume=True)
    assert left == [MoveSequence((way,))]


def test_a_program_resumes_in_its_loop_and_with_the_outputs_that_it_had_set(arm, path):
    script = Script((Outputs(on=(1,)), Outputs(on=(2,))))
    with pytest.raises(Killed):
        begin(arm, script, path, At(4), loops=2)
    again = restarted(arm)
    assert begin(again, script, path, resume=True)[1] == 1
    assert again.status.outputs == 3


def test_a_program_that_was_interrupted_while_it_homed_homes(path):
    arm = recorded(simulated_config("teachmover"), simulate(simulated_config("teachmover")))
    script = Script((Home(), PICK_AND_PLACE[-1]))
    with pytest.raises(Killed):
        begin(arm, script, path, At(1))
    assert begin(arm, script, path, resume=True)[1] == 2
    assert arm.status.trust is Trust.REFERENCED


# -- on every controller --------------------------------------------------------------------------


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
    arm.reference.confirm()
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


@pytest.mark.parametrize("dialect", DIALECTS if THOROUGH else ["mks"])
def test_a_program_that_was_killed_or_stopped_resumes_and_reaches_its_goal(dialect, run):
    arm = homed(dialect)
    end = arm.model.arm.ik(down(145, -15, 30)).angles_rad
    for number, resume in ((2, False), (5, True)):  # the second counts from the first
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
