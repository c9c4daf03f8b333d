"""A Mini-mover on MKS drives is a template of the interview; new drives have a command."""

from __future__ import annotations

import pytest
from test_config_interview import files

from armdrive.setup.filing import checked

BUS = "can:slcan:/dev/ttyACM0?bitrate=500000"


def test_the_template_writes_a_file_that_is_an_arm_on_drives():
    made = files("minimover5-mks", {"connection.port": BUS})
    config = checked(made, "bench")
    assert config.connection.dialect == "mks"
    assert config.connection.port == BUS
    assert len(config.device.ids) == 6


@pytest.mark.parametrize("words", ["armdrive can setup", "id 1"])
def test_it_says_how_new_drives_get_their_ids(words):
    assert words in " ".join(files("minimover5-mks", {}).arm.replace("#", "").split())
