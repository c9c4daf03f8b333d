"""The interview as data: questions, answers, steps back, and the files that come of them."""

import math
import tomllib
from pathlib import Path

import pytest
from amounts import THOROUGH, every_row
from chain_files import shown_files
from pages import blocks, page

from armdrive import Arm
from armdrive.connect.parts import connect_simulated
from armdrive.dialog import WrongAnswer
from armdrive.errors import BadRequest
from armdrive.registry.arm_files import load_arm
from armdrive.setup.draft import Surroundings
from armdrive.setup.filing import after_writing, checked, files_of, write
from armdrive.setup.interview import Interview
from armdrive.setup.questions import homing_order
from armdrive.setup.templates import TEMPLATES, available
from kinematics import Joints, preset

FIVE = ["base", "shoulder", "elbow", "wrist_pitch", "wrist_roll"]
OWN = {
    "own": {
        "links.file": "links.toml",
        **{f"gear.{joint}": "5:1" for joint in FIVE},
        "fingers.mm_per_turn": "12",
    }
}


@pytest.fixture(autouse=True)
def _links(tmp_path, monkeypatch):
    """Write the link table of a TeachMover into the current folder."""
    (tmp_path / "links.toml").write_text(shown_files()[0], encoding="utf-8")
    monkeypatch.chdir(tmp_path)


def interview_of(answers, **around):
    interview = Interview(Surroundings(given=answers, **around))
    while interview.question is not None:
        interview.answer("")
    return interview


def files(template, answers=(), **around):
    given = {"name": "bench", "template": template, **OWN.get(template, {}), **dict(answers)}
    return files_of(interview_of(given, **around).draft)


def loaded(folder, template, answers=(), **around):
    write(files(template, answers, **around), folder / "bench.toml")
    return load_arm(folder / "bench.toml")


# -- templates --------------------------------------------------------------------------------


@every_row("template", available())
def test_every_template_loads(tmp_path, template):
    assert loaded(tmp_path, template).connection.dialect == TEMPLATES[template].dialect


@pytest.mark.parametrize("template", list(available()) if THOROUGH else ["own", "printed-six"])
def test_a_template_drives_its_simulated_twin(tmp_path, template):
    config = loaded(tmp_path, template)
    first, second = config.model.arm.joint_names[:2]
    with Arm(connect_simulated(config)) as arm:
        if config.homing is None:
            arm.jog_j(**{f"{first}_deg": -2.0})
            arm.reference.declare(arm.twin.world.joints)
        else:
            arm.home()
        before = arm.joints
        arm.move_j(**{f"{first}_deg": math.degrees(before[0]) - 10.0})
        arm.jog_j(**{f"{second}_deg": 2.0})
        moved = [after - was for after, was in zip(arm.joints, before, strict=True)]
        assert math.degrees(moved[0]) == pytest.approx(-10.0, abs=0.3)
        assert math.degrees(moved[1]) == pytest.approx(2.0, abs=0.3)
        assert tuple(arm.twin.world.joints) == pytest.approx(tuple(arm.joints), abs=0.01)


def test_the_published_numbers_of_a_preset_are_left_to_it(tmp_path):
    text = files("teachmover").arm
    assert set(tomllib.loads(text)) == {"format", "model", "title", "connection"}
    config = loaded(tmp_path, "teachmover")
    assert config.model == preset("teachmover")


@pytest.mark.parametrize("template", ["armdroid1", "printed-six"])
def test_an_arm_nobody_has_measured_stays_a_template(tmp_path, template):
    assert not loaded(tmp_path, template).model.verified


def test_measured_lengths_go_into_the_model_file_with_its_comments(tmp_path):
    answers = {"lengths.tool": "80", "lengths.upper_arm": "300"}
    text = files("printed-six", answers).model
    assert "z_mm = 80" in text
    assert "a_mm = 300 " in text
    assert "# from the shoulder's axis to the elbow's axis" in text
    assert 'name = "bench"' in text
    assert loaded(tmp_path, "printed-six", answers).model.verified


def test_an_arm_that_was_measured_is_no_template(tmp_path):
    gears = {f"gear.{motor}": "30:1" for motor in (*FIVE[:3], "right wrist", "left wrist")}
    answers = {"measured": "yes", **gears, "fingers.mm_per_turn": "8"}
    text = files("armdroid1", answers).arm
    assert "base = 96000                  # 200 full steps x 16 microsteps x 30:1 = 96000" in text
    config = loaded(tmp_path, "armdroid1", answers)
    assert config.model.verified
    turn = config.model.transmission.motors[0].steps_per_unit * math.tau
    assert turn == pytest.approx(200 * 16 * 30)


def test_a_link_table_is_the_arm_that_it_describes(tmp_path):
    config = loaded(tmp_path, "own", {"gripper.over": "elbow"})
    ours, known = config.model.arm, preset("teachmover").arm
    joints = Joints((0.1, 0.4, -0.9, -0.3, 0.2))
    assert ours.fk(joints).x_mm == pytest.approx(known.fk(joints).x_mm)
    assert ours.fk(joints).z_mm == pytest.approx(known.fk(joints).z_mm)
    assert ours.fk(joints).pitch_deg == pytest.approx(known.fk(joints).pitch_deg)
    assert config.model.transmission.motors[-1].follows == ((2, 1),)


def test_a_model_file_is_taken_over_with_its_limits(tmp_path):
    rows = "".join(
        f'[[links]]\njoint = "j{n}"\nd_mm = 100\na_mm = {n}\nalpha_deg = {90 * (n % 2)}\n'
        f"low_deg = -{100 + n}\nhigh_deg = {100 + n}\n"
        for n in range(1, 7)
    )
    (tmp_path / "six.toml").write_text(rows, encoding="utf-8")
    answers = {
        "links.file": str(tmp_path / "six.toml"),
        "gripper.kind": "none",
        **{f"gear.j{n}": "20:1" for n in range(1, 7)},
    }
    given = {"name": "bench", "template": "own", **answers}
    texts = files_of(interview_of(given).draft)
    write(texts, tmp_path / "bench.toml")
    config = load_arm(tmp_path / "bench.toml")
    assert texts.model == rows
    assert config.model.arm.joint_names == tuple(f"j{n}" for n in range(1, 7))
    assert math.degrees(config.model.arm.limits[5].high_rad) == pytest.approx(106)


def test_the_urdf_of_the_page_is_taken_over_as_a_urdf(tmp_path):
    (urdf,) = blocks(page("urdf"), "xml")
    (tmp_path / "six.urdf").write_text(urdf, encoding="utf-8")
    joints = ("base", "shoulder", "elbow", "forearm_roll", "wrist_pitch", "wrist_roll")
    answers = {
        "links.file": str(tmp_path / "six.urdf"),
        "gripper.kind": "none",
        "limits.wrist_roll": "-155, 155",
        **{f"gear.{joint}": "20:1" for joint in joints},
    }
    given = {"name": "bench", "template": "own", **answers}
    texts = files_of(interview_of(given).draft)
    write(texts, tmp_path / "bench.toml")
    config = load_arm(tmp_path / "bench.toml")
    assert (tmp_path / "models" / "bench.urdf").read_text(encoding="utf-8").strip() == urdf.strip()
    assert config.model.arm.joint_names == joints
    assert config.model.arm.limits[0].high_rad == pytest.approx(2.9, abs=1e-4)


def test_known_directions_are_written(tmp_path):
    answers = {
        "signs": "known",
        "reversed.motors": "elbow, left wrist",
        "reversed.joints": "wrist_roll",
    }
    config = loaded(tmp_path, "teachmover", answers)
    expected = preset("teachmover").transmission.with_signs(
        motors=(1, 1, -1, 1, -1, 1), coordinates=(1, 1, 1, 1, -1, 1)
    )
    assert config.model.transmission.matrix == expected.matrix


def test_reversed_motors_of_a_link_table_turn_what_follows_them(tmp_path):
    answers = {"signs": "known", "reversed.motors": "elbow"}
    plain, turned = loaded(tmp_path, "own"), loaded(tmp_path, "own", answers)
    signs = (1, 1, -1, 1, 1, 1)
    assert turned.model.transmission.matrix == plain.model.transmission.with_signs(signs).matrix


# -- going through it -------------------------------------------------------------------------


def test_an_empty_line_is_the_default_and_a_wrong_one_changes_nothing():
    interview = Interview(Surroundings())
    with pytest.raises(WrongAnswer, match="no default"):
        interview.answer("")
    with pytest.raises(WrongAnswer, match="cannot name a file"):
        interview.answer("my arm!")
    interview.answer("bench")
    with pytest.raises(WrongAnswer, match="did you mean 'teachmover'"):
        interview.answer("teachmoover")
    with pytest.raises(WrongAnswer, match="answer one of"):
        interview.answer("9" * 5000)
    assert interview.question.key == "template"
    interview.answer("1")
    assert interview.draft.template.key == next(iter(available()))
    assert interview.question.default == "Microbot TeachMover"


def test_going_back_asks_the_question_before_once_more():
    interview = Interview(Surroundings())
    assert interview.back() is None
    interview.answer("bench")
    interview.answer("teachmover")
    assert interview.back() == "template"
    assert interview.question.key == "template"
    interview.answer("robko01")
    assert interview.question.default == "Robko 01"


def test_given_answers_are_not_asked_also_when_going_back():
    around = Surroundings(given={"template": "teachmover", "dialect": "teachmover"})
    interview = Interview(around)
    interview.answer("bench")
    assert (interview.question.key, interview.draft.answers["template"]) == ("title", "teachmover")
    interview.answer("mine")
    assert interview.question.key == "connection.port"
    assert [interview.back(), interview.back(), interview.back()] == ["title", "name", None]
    assert interview.question.key == "name"


def test_an_impossible_given_answer_is_refused_or_asked_again():
    around = Surroundings(given={"name": "bench", "template": "teachmoover"})
    with pytest.raises(BadRequest, match=r"the answer template: .*did you mean 'teachmover'"):
        Interview(around)
    interview = Interview(around, strict=False)
    assert interview.question.key == "template"
    interview.answer("teachmover")
    assert interview.back() == "template"


def test_a_gate_that_is_kept_closed_hides_what_is_behind_it():
    kept = interview_of({"name": "a", "template": "teachmover"}).draft.answers
    opened = {"name": "a", "template": "teachmover", "limits.base": "-80 80"}
    asked = interview_of(opened).draft
    assert "limits.base" not in kept
    assert asked.answers["limits.base"] == (-80.0, 80.0)
    assert asked.answers["limits.elbow"] == (-149.0, 0.0)


def test_a_port_may_be_named_by_its_number():
    interview = interview_of(
        {"name": "a", "template": "teachmover", "connection.port": "2"},
        ports=("/dev/ttyS0", "/dev/ttyUSB0"),
    )
    assert interview.draft.answers["connection.port"] == "/dev/ttyUSB0"


def test_every_question_explains_itself():
    for template in available():
        interview = Interview(Surroundings())
        answers = {"name": "a", "template": template, **OWN.get(template, {})}
        while (question := interview.question) is not None:
            assert question.why.endswith((".", "NAME.")), question.key
            interview.answer(answers.get(question.key, ""))


# Drives on a CAN bus: the interview asks for the adapter, and for no baud rate.

BUS = "can:slcan:/dev/ttyACM0?bitrate=500000"
BUSES = ("can:socketcan:can0", BUS)


def at_question(key, dialect="grbl", template="minimover5-grbl", around=None, **more):
    """Return an interview that has come to a question."""
    interview = Interview(Surroundings(**(around or {})))
    given = {"name": "bench", "template": template, "dialect": dialect, **more}
    while interview.question.key != key:
        interview.answer(given.get(interview.question.key, ""))
    return interview


def at_the_port(dialect, **around):
    return at_question("connection.port", dialect, around=around)


@every_row(
    "key, answers, line, why",
    [
        ("device.axes", {}, "QWERTU", "its own letter from"),
        ("device.axes", {}, "XYZABB", "different letters are needed"),
    ],
)
def test_what_the_arm_file_would_not_take_is_refused_at_its_question(key, answers, line, why):
    interview = at_question(key, template="printed-six", **answers)
    with pytest.raises(WrongAnswer, match=why):
        interview.answer(line)


@every_row("kind, keys", [("servo", 3), ("output", 2), ("none", 0)])
def test_what_a_gripper_is_tuned_by_is_written_with_its_meaning(tmp_path, kind, keys):
    text = files("printed-six", {"gripper.kind": kind}).arm
    section = text[text.index("[grbl]") :].partition("\n\n")[0]
    tuned = [line for line in section.splitlines() if "servo" in line or "gripper" in line]
    assert len(tuned) == keys
    assert section.count("# the servo's number") == 2 * (kind == "servo")
    assert loaded(tmp_path, "printed-six", {"gripper.kind": kind}).gripper.kind == kind


def test_a_bus_is_asked_for_its_adapter_and_for_no_baud_rate():
    interview = at_the_port("mks", ports=("/dev/ttyACM0",), buses=BUSES)
    assert "CAN adapter" in interview.question.words
    assert interview.question.choices == tuple((bus, "") for bus in BUSES)
    interview.answer("2")
    assert interview.draft.get("connection.port") == BUS
    assert interview.question.key != "connection.baud"


@pytest.mark.parametrize(
    ("order", "why"),
    [("3; 2; 3 1 4 5", "listed twice"), ("3; 2; 1", "4, 5 would seek no switch"), ("9", "from 1")],
)
def test_a_joint_that_would_seek_no_switch_is_named(order, why):
    draft = interview_of({"name": "bench", "template": "minimover5-grbl"}).draft
    with pytest.raises(WrongAnswer, match=why):
        homing_order(draft)(order)
    assert homing_order(draft)("3; 2; 1 4 5") == ((3,), (2,), (1, 4, 5))


def test_a_serial_line_is_asked_for_its_port_and_its_baud_rate():
    interview = at_the_port("grbl", ports=("/dev/ttyACM0",), buses=BUSES)
    assert interview.question.choices == (("/dev/ttyACM0", ""),)
    interview.answer("1")
    assert interview.question.key == "connection.baud"


@every_row("port", ["/dev/ttyACM0", "COM3", "socket://host:1", "7", "can0"])
def test_a_line_that_is_no_adapter_is_refused_with_an_example(port):
    with pytest.raises(WrongAnswer, match="can:slcan:/dev/ttyACM0"):
        at_the_port("mks").answer(port)


def test_a_rate_that_was_given_beforehand_is_still_taken():
    answers = {"name": "bench", "template": "minimover5-grbl", "dialect": "mks"}
    given = interview_of({**answers, "connection.port": BUS, "connection.baud": "500000"})
    assert given.draft.get("connection.baud") == 500_000


def test_the_arm_file_has_the_adapter_and_no_rate():
    text = files("minimover5-grbl", {"dialect": "mks", "connection.port": BUS}).arm
    assert f'port = "{BUS}"' in text
    assert "baud =" not in text


# A Mini-mover on drives of a CAN bus is a template of the interview.


def test_the_template_writes_a_file_that_is_an_arm_on_drives():
    made = files("minimover5-mks", {"connection.port": BUS})
    config = checked(made, "bench")
    assert config.connection.dialect == "mks"
    assert config.connection.port == BUS
    assert len(config.device.ids) == 6


@pytest.mark.parametrize(
    ("template", "words"),
    [
        ("minimover5-mks", "armdrive can setup"),
        ("minimover5-mks", "id 1"),
        ("minimover5-cia402", "switches"),
        ("minimover5-cia402", "armdrive doctor --can"),
    ],
)
def test_the_file_says_how_drives_get_their_numbers(template, words):
    assert words in " ".join(files(template).arm.replace("#", "").split())


# -- CiA 402 -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("template", "measures"), [("minimover5-cia402", True), ("minimover5-mks", False)]
)
def test_the_next_commands_measure_the_units_of_drives_that_may_not_tell_them(template, measures):
    config = checked(files(template, {"connection.port": BUS}), "bench")
    named = "\n".join(after_writing(Path("bench.toml"), config))
    assert ("armdrive can setup bench" in named) is measures


def test_the_template_of_canopen_drives_asks_for_their_nodes():
    made = files("minimover5-cia402", {"connection.port": BUS, "device.ids": "11 12 13,14 15 16"})
    assert "ids = [11, 12, 13, 14, 15, 16]" in made.arm
    config = checked(made, "bench")
    assert config.connection.dialect == "cia402"
    assert config.device.ids == (11, 12, 13, 14, 15, 16)
    assert checked(files("minimover5-cia402"), "bench").device.ids == (1, 2, 3, 4, 5, 6)


@pytest.mark.parametrize("ids", ["1 2 3", "1 2 3 4 5 5", "0 1 2 3 4 5", "1 2 3 4 5 128", "a b"])
def test_node_numbers_that_cannot_be_are_refused_by_their_key(ids):
    with pytest.raises(BadRequest, match=r"the answer device\.ids: "):
        files("minimover5-cia402", {"device.ids": ids})


def test_no_other_controller_is_asked_for_nodes():
    for template in ("minimover5-mks", "minimover5-grbl", "teachmover"):
        assert "ids" not in files(template).arm


def test_an_own_arm_on_such_drives_counts_increments():
    links = {**OWN["own"], "dialect": "cia402", "connection.port": BUS}
    config = checked(files("own", links), "bench")
    turn = config.model.transmission.motors[0].steps_per_unit * math.tau
    assert turn == pytest.approx(10_000 * 5)
    assert config.device.ids == (1, 2, 3, 4, 5, 6)
