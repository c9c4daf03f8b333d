"""A dialect's own section of an arm file is refused by the name of its key."""

import pytest

from armdrive.errors import ArmFileError
from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import parse_arm

REFUSED = [
    ("grbl", "minimover5", {"axes": "XYZ"}, "6 motors"),
    ("grbl", "minimover5", {"axes": "XYZABX"}, "its own letter"),
    ("grbl", "minimover5", {"unit": "inches"}, "steps, degrees"),
    ("grbl", "minimover5", {"rates": [1.0, 2.0]}, "6 entries"),
    ("grbl", "minimover5", {"rates": [0.0] * 6}, "grbl.rates"),
    ("grbl", "minimover5", {"outputs": ["laser"]}, "flood, mist"),
    ("grbl", "minimover5", {"servo": "M5"}, "grbl.servo"),
    ("grbl", "minimover5", {"poll_s": 0.0}, "grbl.poll_s"),
    ("grbl", "minimover5", {"ramp": 1.0}, "ramp_s"),
    ("armdroid", "armdroid1", {"channels": [6, 5, 4, 3, 2, 2]}, "armdroid.channels"),
    ("armdroid", "armdroid1", {"speed_table": [[0, 20.0], [250, 200.0]]}, "armdroid.speed_table"),
    ("armdroid", "armdroid1", {"character_s": 1.0}, "armdroid.character_s"),
    ("armdroid", "armdroid1", {"boot_s": -1.0}, "armdroid.boot_s"),
    ("armdroid", "armdroid1", {"speed_doubt": 0.5}, "armdroid.speed_doubt"),
    ("armdroid", "armdroid1", {"answer_margin_s": 0.0}, "armdroid.answer_margin_s"),
    ("robko01", "robko01", {"board": "uno"}, "robko01.board"),
    ("robko01", "robko01", {"acceleration_steps_s2": 1.0}, "robko01.acceleration_steps_s2"),
    ("robko01", "robko01", {"max_rate_hz": 0.5}, "robko01.max_rate_hz"),
    ("robko01", "robko01", {"step_chance_s": -0.1}, "robko01.step_chance_s"),
    ("robko01", "robko01", {"speed_doubt": 0.5}, "robko01.speed_doubt"),
    ("robko01", "robko01", {"watchdog_s": -1.0}, "robko01.watchdog_s"),
    ("robko01", "robko01", {"boot_s": 100.0}, "robko01.boot_s"),
    ("robko01", "robko01", {"answer_margin_s": 0.0}, "robko01.answer_margin_s"),
]


@pytest.mark.parametrize(("dialect", "model", "section", "words"), REFUSED)
def test_a_section_is_refused_by_the_name_of_its_key(dialect, model, section, words):
    table = {"model": model, "connection": {"dialect": dialect}, dialect: section}
    with pytest.raises(ArmFileError, match=words):
        DIALECTS[dialect].controller(parse_arm(table, name="bench"))
