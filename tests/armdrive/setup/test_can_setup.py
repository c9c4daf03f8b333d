"""Commissioning: new drives come out ready, and nothing is written or turned without a yes."""

from __future__ import annotations

import tomllib

import pytest
from can_setup_bench import NAMES, READING, TURNING, Bench, arm, really

from armdrive.dialog.conversation import About
from armdrive.errors import BadRequest
from armdrive.registry.arm_files import parse_arm
from armdrive.setup.filing import commissioned, new_text, signs_of
from armdrive.setup.plan import Notes, plan_of
from firmware_protocol.mks import (
    Code,
    Mode,
    ReplyMode,
    SetId,
    SetMode,
    SetReplies,
    SilenceWatchdog,
)

IDS = (1, 2, 3, 4, 5, 6)


SIGNS = (1, -1, 1, 1, -1, -1)
TRUTH = really(SIGNS, (1.0, 2.0, 1.0, 1.0, 1.0, 1.0))


@pytest.fixture(scope="module")
def walked():
    """Return a bus whose six drives were new, and what came of the whole talk."""
    bench = Bench(truth=TRUTH)
    before = bench.twin.world.motors
    outcome = bench.walk()
    assert bench.twin.world.motors == before  # every motor is back where it was
    return bench, outcome


def test_new_drives_come_out_with_ids_settings_and_a_watchdog_that_was_seen_to_work(walked):
    bench, outcome = walked
    assert outcome.finished
    assert bench.ids() == IDS
    for node in bench.board.nodes:
        assert node.flash.mode is Mode.BUS_FOC
        assert node.flash.of(SetReplies).mode is ReplyMode.FULL
        assert node.flash.of(SilenceWatchdog).timeout_ms == 500
        assert node.motion.watchdog_stops == 1
    assert set(outcome.notes) == set(NAMES)
    assert all(each.done and each.watchdog for each in outcome.notes.values())


def test_directions_are_found_by_looking(walked):
    bench, outcome = walked
    found = signs_of(bench.plan, outcome.notes)
    reversed_ones = [name for name, sign in zip(NAMES, SIGNS, strict=True) if sign < 0]
    assert sorted(found.motors) == sorted(reversed_ones)
    assert found.joints == found.unclear == ()


def test_the_arm_file_that_comes_of_it_is_the_arm_as_it_is_built(walked):
    bench, outcome = walked
    port = "can:slcan:/dev/ttyACM0?bitrate=500000"
    text = commissioned(new_text(bench.config), bench.config, bench.plan, outcome.notes, port)
    read = tomllib.loads(text)
    assert read["mks"]["ids"] == list(IDS)
    assert read["connection"] == {"dialect": "mks", "port": port}
    assert read["motor_signs"] == {"shoulder": -1, "left wrist": -1, "gripper": -1}
    built = parse_arm(read, name="bench").model.transmission
    for is_so, found in zip(TRUTH.transmission.motors, built.motors, strict=True):
        assert found.steps_per_unit == pytest.approx(is_so.steps_per_unit, rel=0.01)
        assert found.sees == is_so.sees


LINKED = """\
# mine
model = "models/a.toml"

# in the controller's order
[[motors]]
name = "base"
steps_per_turn = 1
sees = { base = 1 }

[[motors]]
name = "shoulder"
steps_per_turn = 1
sees = { shoulder = 1, elbow = -1 }

[[motors]]
name = "gripper"
steps_per_mm = 1

# slowly
[speeds_deg_s]
base = 30
"""


def test_an_arm_of_a_link_table_gets_its_numbers_where_its_motors_are(walked):
    bench, outcome = walked
    text = commissioned(LINKED, bench.config, bench.plan, outcome.notes, "")
    read = tomllib.loads(text)
    assert all(line in text for line in LINKED.splitlines() if line.startswith("#"))
    assert read["speeds_deg_s"] == {"base": 30}
    base, shoulder, gripper = read["motors"]
    assert base == {"name": "base", "steps_per_turn": 50 * 16384, "sees": {"base": 1}}
    assert shoulder["sees"] == {"shoulder": -1, "elbow": 1}
    assert shoulder["steps_per_turn"] == pytest.approx(100 * 16384, rel=0.01)
    assert gripper["steps_per_mm"] == 2400


def test_who_says_no_to_everything_has_nothing_written_and_nothing_turned():
    bench = Bench()
    bench.person.says[About.AGREEMENT] = bench.person.says[About.CONNECT] = "no"
    flashes, motors = bench.flashes(), bench.twin.world.motors
    outcome = bench.walk()
    assert sorted(outcome.left_out) == sorted(NAMES)
    assert bench.codes() <= READING
    assert bench.flashes() == flashes
    assert bench.twin.world.motors == motors


SETTINGS = {Code.MODE, Code.WATCHDOG}
CURRENT = {Code.ENABLE, Code.ARM}
"""Whoever switches a motor on sees to it that its orders are not kept for a common start."""
AFTER = (
    set(),
    {Code.NODE},
    {Code.NODE, *SETTINGS},
    {Code.NODE, *SETTINGS},
    {Code.NODE, *SETTINGS, *CURRENT},
    {Code.NODE, *SETTINGS, *CURRENT, Code.ABSOLUTE_AXIS},
    {Code.NODE, *SETTINGS, *CURRENT, Code.ABSOLUTE_AXIS},
)
"""What may have been said, beside readings, after so many yeses: id, settings, built in, current,
the smallest motion, the trial."""


@pytest.mark.parametrize("yeses", range(len(AFTER)))
def test_no_is_no_at_every_single_question(yeses):
    """From the first no on, only what was agreed to before has been said to drives."""
    bench = Bench(arm(ids=(2, 3, 4, 5, 6, 7)))
    met = [0]

    def sometimes() -> str:
        met[0] += 1
        return "yes" if met[0] <= yeses else "no"

    bench.person.says["It says that it is calibrated"] = "no"
    for kind in (About.AGREEMENT, About.MOUNTED):
        bench.person.says[kind] = sometimes
    bench.walk()
    assert bench.codes() - READING == AFTER[yeses]
    assert {node for node, request in bench.said if request.code not in READING} <= {1, 2}


class Leaves(Exception):
    """Somebody has had enough."""


def leaves() -> str:
    raise Leaves


def test_left_in_the_middle_and_taken_up_again_it_goes_on_there():
    bench = Bench()
    bench.person.says["Try the watchdog?"] = leaves
    with pytest.raises(Leaves):
        bench.one()
    del bench.person.says["Try the watchdog?"]
    bench.said.clear()
    bench.person.asked.clear()
    assert bench.one()
    words = [ask.question.words for ask in bench.person.asked]
    assert not any("plugged in" in each or "Write" in each or "Which way" in each for each in words)
    assert any("Try the watchdog?" in each for each in words)
    assert bench.kept["shoulder"].way
    assert SetId(2) not in [request for _, request in bench.said]
    bench.said.clear()
    assert bench.one()
    assert "its settings: nothing to do" in bench.person.text
    assert bench.codes() <= READING


def test_what_was_done_before_is_said_at_the_beginning():
    bench = Bench()
    bench.person.says[About.CONNECT] = bench.person.says[About.AGREEMENT] = "no"
    bench.walk({"elbow": Notes(done=True)})
    assert "Done in an earlier run: elbow" in bench.person.text


def test_a_drive_that_was_done_and_has_lost_its_mode_is_set_up_once_more():
    bench = Bench(factory=False)
    bench.board.drives.plug(2, True)
    bench.board.drives.set_mode(2, Mode.PULSE_FOC)
    bench.kept["elbow"] = Notes(done=True, watchdog=True)
    assert bench.one("elbow")
    assert (3, SetMode(Mode.BUS_FOC)) in bench.said
    assert not bench.codes() & TURNING


def test_an_arm_without_such_drives_is_refused():
    from armdrive.connect.target import simulated_config

    with pytest.raises(BadRequest, match='dialect = "mks"'):
        plan_of(simulated_config("grbl"))
    with pytest.raises(BadRequest, match="6 motors"):
        plan_of(arm(ids=(1, 2, 3)))
