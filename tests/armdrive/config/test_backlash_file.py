"""Backlash in the arm file: read as whole steps, refused by name, and written back as it was."""

import tomllib

import pytest
from chain_files import six_arm, six_links, written

from armdrive.errors import ArmFileError
from armdrive.registry.arm_files import parse_arm
from armdrive.registry.simulate import simulate


def of(text):
    return parse_arm(tomllib.loads(text), name="lab")


TEACHMOVER = 'model = "teachmover"\n'


def test_the_arm_file_gives_backlash_in_degrees_of_what_the_motor_turns():
    text = '[backlash_deg]\nbase = 0.5\n"right wrist" = 1.0\n'
    config = of(TEACHMOVER + "backlash_mm = 0.5\n" + text)
    assert config.backlash_steps == (10, 0, 0, 4, 0, 7)
    assert of(TEACHMOVER + "[backlash_deg]\nbase = 0\n").backlash_steps == ()


def test_backlash_makes_another_calibration_and_none_makes_none():
    plain = of(TEACHMOVER)
    some, more = (of(f"{TEACHMOVER}[backlash_deg]\nbase = {deg}\n") for deg in (0.5, 1.0))
    assert len({plain.calibration, some.calibration, more.calibration}) == 3
    assert of(TEACHMOVER + "[backlash_deg]\n").calibration == plain.calibration


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("[backlash_deg]\nbase = 11", "backlash_deg.base must be from 0 to 10"),
        ("[backlash_deg]\nbase = -1", "backlash_deg.base must be from 0 to 10"),
        ("[backlash_deg]\nwrist = 1", "wrist"),
        ("[backlash_deg]\ngripper = 1", "gripper"),
        ('[backlash_deg]\nbase = "much"', "backlash_deg.base"),
        ("backlash_mm = 6", "backlash_mm must be from 0 to 5"),
        ('backlash_mm = 1\n[gripper]\nkind = "servo"', "this arm has none"),
        ("backlash_deg = 3", "must be a table"),
        ("backlash = 3", "backlash_mm"),
    ],
)
def test_backlash_that_cannot_be_is_refused_by_name(text, named):
    with pytest.raises(ArmFileError, match=named):
        of(TEACHMOVER + text)


def test_an_arm_of_a_model_file_gives_backlash_with_its_motors(tmp_path):
    (tmp_path / "six.toml").write_text(six_links(), encoding="utf-8")
    text = six_arm().replace("sees = { elbow = 1 }", "sees = { elbow = 1 }\nbacklash_deg = 0.5")
    config = written(tmp_path, text)
    assert config.backlash_steps == (0, 0, 20, 0, 0, 0)
    assert simulate(config).world.play.widths == config.backlash_steps
