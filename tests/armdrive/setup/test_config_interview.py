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
from armdrive.setup.templates import TEMPLATES
from kinematics import preset

FIVE = ["base", "shoulder", "elbow", "wrist_pitch", "wrist_roll"]
OWN = {
    "own": {
        "links.file": "links.toml",
        **{f"gear.{joint}": "5:1" for joint in FIVE},
        "fingers.mm_per_turn": "12",
    }
}
BUS = "can:slcan:/dev/ttyACM0?bitrate=500000"
BUSES = ("can:socketcan:can0", BUS)


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


def draft_of(template, answers=(), **around):
    given = {"name": "bench", "template": template, **OWN.get(template, {}), **dict(answers)}
    return interview_of(given, **around).draft


def files(template, answers=()):
    return files_of(draft_of(template, answers))


def loaded(folder, template, answers=()):
    write(files(template, answers), folder / "bench.toml")
    return load_arm(folder / "bench.toml")


# -- templates --------------------------------------------------------------------------------


@every_row("template", TEMPLATES)
def test_every_template_loads_and_every_question_explains_itself(tmp_path, template):
    assert loaded(tmp_path, template).connection.dialect == TEMPLATES[template].dialect
    made = files(template)
    texts = [made.arm, made.model] if template == "printed-six" else [made.arm]
    assert {next(iter(tomllib.loads(text))) for text in texts} == {"format"}
    interview = Interview(Surroundings())
    answers = {"name": "a", "template": template, **OWN.get(template, {})}
    while (question := interview.question) is not None:
        assert question.why.endswith((".", "NAME.")), question.key
        interview.answer(answers.get(question.key, ""))


@pytest.mark.parametrize("template", list(TEMPLATES) if THOROUGH else ["own", "printed-six"])
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


def test_what_a_template_knows_is_left_to_it_and_may_be_given(tmp_path):
    assert set(tomllib.loads(files("teachmover").arm)) == {"format", "model", "title", "connection"}
    assert loaded(tmp_path, "teachmover").model == preset("teachmover")
    assert not loaded(tmp_path, "armdroid1").model.verified
    assert not loaded(tmp_path, "printed-six").model.verified
    given = {"limits.base": "-80 80", "lengths.hand_mm": "97", "speeds.elbow": "5"}
    table = tomllib.loads(files("teachmover", given).arm)
    assert table["limits_deg"] == {"base": [-80, 80]}
    assert table["lengths"] == {"hand_mm": 97}
    assert table["speeds_deg_s"] == {"elbow": 5}
    assert "limits.base" not in draft_of("teachmover").answers


def test_measured_lengths_go_into_the_model_file_with_its_comments(tmp_path):
    answers = {"lengths.tool": "80", "lengths.upper_arm": "300", "speeds.base": "11"}
    text = files("printed-six", answers).model
    assert "z_mm = 80" in text
    assert "a_mm = 300 " in text
    assert "# from the shoulder's axis to the elbow's axis" in text
    assert 'name = "bench"' in text
    config = loaded(tmp_path, "printed-six", answers)
    assert config.model.verified
    speeds = [round(math.degrees(each)) for each in config.model.joint_speeds_rad_s]
    assert speeds == [11, 15, 15, 30, 30, 40]


def test_an_arm_that_was_measured_is_no_template(tmp_path):
    gears = {f"gear.{motor}": "30:1" for motor in (*FIVE[:3], "right wrist", "left wrist")}
    lengths = {f"lengths.{key}_mm": "190" for key in ("base_height", "upper_arm", "forearm")}
    answers = {"measured": "yes", **gears, **lengths, "fingers.mm_per_turn": "8"}
    text = files("armdroid1", answers).arm
    assert "base = 96000                  # 200 full steps x 16 microsteps x 30:1 = 96000" in text
    config = loaded(tmp_path, "armdroid1", answers)
    assert config.model.verified
    turn = config.model.transmission.motors[0].steps_per_unit * math.tau
    assert turn == pytest.approx(200 * 16 * 30)


def test_a_model_file_or_a_urdf_is_taken_over_with_its_limits(tmp_path):
    rows = "".join(
        f'[[links]]\njoint = "j{n}"\nd_mm = 100\na_mm = {n}\nalpha_deg = {90 * (n % 2)}\n'
        f"low_deg = -{100 + n}\nhigh_deg = {100 + n}\n"
        for n in range(1, 7)
    )
    (urdf,) = blocks(page("urdf"), "xml")
    names = ("base", "shoulder", "elbow", "forearm_roll", "wrist_pitch", "wrist_roll")
    cases = [
        ("six.toml", rows, tuple(f"j{n}" for n in range(1, 7)), {}, 5, math.radians(106)),
        ("six.urdf", urdf, names, {"limits.wrist_roll": "-155, 155"}, 0, 2.9),
    ]
    for name, text, joints, more, at, high_rad in cases:
        (tmp_path / name).write_text(text, encoding="utf-8")
        gears = {f"gear.{joint}": "20:1" for joint in joints}
        answers = {"links.file": str(tmp_path / name), "gripper.kind": "none", **more, **gears}
        config = loaded(tmp_path, "own", answers)
        taken = tmp_path / "models" / f"bench{Path(name).suffix}"
        assert taken.read_text(encoding="utf-8").strip() == text.strip()
        assert config.model.arm.joint_names == joints
        assert config.model.arm.limits[at].high_rad == pytest.approx(high_rad, abs=1e-4)


@every_row(
    "template, dialect, joints, kinds",
    [
        ("minimover5-grbl", "grbl", 5, ("coupled", "servo", "output", "none")),
        ("own", "grbl", 5, ("stepper", "servo", "output", "none")),
        ("own", "teachmover", 5, ("stepper",)),
        ("own", "grbl", 6, ("servo", "output", "none")),
        ("own", "teachmover", 6, ("none",)),
    ],
)
def test_a_gripper_is_moved_by_what_the_controller_has_left(
    tmp_path, template, dialect, joints, kinds
):
    six = shown_files()[0] + '[[links]]\njoint = "sixth"\nlow_deg = -9\nhigh_deg = 9\n'
    (tmp_path / "links.toml").write_text(shown_files()[0] if joints == 5 else six)
    gears = {"gear.sixth": "5:1"} if joints == 6 else {}
    unused = {"fingers.mm_per_turn"} if "stepper" not in kinds else set()
    answers = OWN["own"] | gears | {"dialect": dialect}
    draft = draft_of(template, {key: each for key, each in answers.items() if key not in unused})
    assert draft.grippers == kinds


def test_published_motors_take_more_steps_with_more_microsteps(tmp_path):
    ours = loaded(tmp_path, "minimover5-grbl", {"microsteps": "16"}).model.transmission.motors
    known = preset("minimover5").transmission.motors
    assert [each.steps_per_unit for each in ours] == [
        pytest.approx(8 * each.steps_per_unit) for each in known
    ]


@every_row("kind, keys", [("servo", 3), ("output", 2), ("none", 0)])
def test_what_a_gripper_is_tuned_by_is_written_with_its_meaning(tmp_path, kind, keys):
    text = files("printed-six", {"gripper.kind": kind}).arm
    section = text[text.index("[grbl]") :].partition("\n\n")[0]
    tuned = [line for line in section.splitlines() if "servo" in line or "gripper" in line]
    assert len(tuned) == keys
    assert section.count("# the servo's number") == 2 * (kind == "servo")
    assert loaded(tmp_path, "printed-six", {"gripper.kind": kind}).gripper.kind == kind


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
    assert interview.draft.template.key == next(iter(TEMPLATES))
    assert interview.question.default == "Microbot TeachMover"
    assert interview.back() == "template"
    interview.answer("robko01")
    assert interview.question.default == "Robko 01"


def test_given_answers_are_not_asked_also_when_going_back():
    around = Surroundings(given={"template": "teachmover", "dialect": "teachmover"})
    interview = Interview(around)
    assert interview.back() is None
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


def at_question(key, dialect="grbl", template="minimover5-grbl", **around):
    """Return an interview that has come to a question."""
    interview = Interview(Surroundings(**around))
    given = {"name": "bench", "template": template, "dialect": dialect}
    while interview.question.key != key:
        interview.answer(given.get(interview.question.key, ""))
    return interview


@every_row(
    "key, more, line, why",
    [
        ("device.axes", {"template": "printed-six"}, "QWERTU", "its own letter from"),
        ("device.axes", {"template": "printed-six"}, "XYZABB", "different letters are needed"),
        ("connection.port", {"dialect": "mks"}, "/dev/ttyACM0", "can:slcan:/dev/ttyACM0"),
        ("connection.port", {"dialect": "mks"}, "can:x:y?bitrate", "can:slcan:/dev/ttyACM0"),
        ("connection.port", {}, "7", "names no port of a grbl"),
        ("connection.baud", {}, "7", "from 50 to 4e"),
        ("microsteps", {}, "2.5", "a whole number is needed"),
        ("homing.own", {}, "perhaps", "answer yes or no"),
        ("fingers.range", {"template": "printed-six"}, "76 0", "must be below the second"),
        ("fingers.range", {"template": "printed-six"}, "1 2 3", "2 numbers are needed"),
    ],
)
def test_what_the_arm_file_would_not_take_is_refused_at_its_question(key, more, line, why):
    with pytest.raises(WrongAnswer, match=why):
        at_question(key, **more).answer(line)


def test_a_bus_is_asked_for_its_adapter_and_a_serial_line_for_its_baud_rate_too():
    around = {"ports": ("/dev/ttyACM0",), "buses": BUSES}
    interview = at_question("connection.port", "mks", **around)
    assert interview.question.choices == tuple((bus, "") for bus in BUSES)
    interview.answer("2")
    assert interview.draft.get("connection.port") == BUS
    assert interview.question.key != "connection.baud"
    interview = at_question("connection.port", **around)
    assert interview.question.choices == (("/dev/ttyACM0", ""),)
    interview.answer("1")
    assert interview.question.key == "connection.baud"
    given = draft_of("minimover5-grbl", {"dialect": "mks", "connection.baud": "500000"})
    assert given.get("connection.baud") == 500_000


@every_row(
    "order, why",
    [("3; 2; 3 1 4 5", "listed twice"), ("3; 2; 1", "4, 5 would seek no switch"), ("9", "from 1")],
)
def test_a_joint_that_would_seek_no_switch_is_named(order, why):
    draft = draft_of("minimover5-grbl")
    with pytest.raises(WrongAnswer, match=why):
        homing_order(draft)(order)
    assert homing_order(draft)("3; 2; 1 4 5") == ((3,), (2,), (1, 4, 5))


# -- drives on a CAN bus ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("template", "measures", "words"),
    [
        ("minimover5-mks", False, ("armdrive can setup", "id 1")),
        ("minimover5-cia402", True, ("switches", "armdrive doctor --can")),
    ],
)
def test_the_file_of_an_arm_on_drives_says_how_they_get_their_numbers(template, measures, words):
    made = files(template, {"connection.port": BUS})
    config = checked(made, "bench")
    assert config.connection.dialect == TEMPLATES[template].dialect
    assert config.connection.port == BUS
    assert config.device.ids == (1, 2, 3, 4, 5, 6)
    assert "baud =" not in made.arm
    text = " ".join(made.arm.replace("#", "").split())
    assert all(word in text for word in words)
    named = "\n".join(after_writing(Path("bench.toml"), config))
    assert ("armdrive can setup bench" in named) is measures


def test_canopen_drives_are_asked_for_their_nodes_and_others_are_not():
    made = files("minimover5-cia402", {"device.ids": "11 12 13,14 15 16"})
    assert checked(made, "bench").device.ids == (11, 12, 13, 14, 15, 16)
    for ids in ("1 2 3", "1 2 3 4 5 5", "0 1 2 3 4 5", "1 2 3 4 5 128", "a b"):
        with pytest.raises(BadRequest, match=r"the answer device\.ids: "):
            files("minimover5-cia402", {"device.ids": ids})
    for template in ("minimover5-mks", "minimover5-grbl", "teachmover"):
        assert "ids" not in files(template).arm


def test_an_own_arm_on_such_drives_counts_increments():
    links = {**OWN["own"], "dialect": "cia402", "connection.port": BUS}
    config = checked(files("own", links), "bench")
    turn = config.model.transmission.motors[0].steps_per_unit * math.tau
    assert turn == pytest.approx(10_000 * 5)
    assert config.model.gripper_range_mm == (0.0, 76.0)
    assert config.device.ids == (1, 2, 3, 4, 5, 6)
