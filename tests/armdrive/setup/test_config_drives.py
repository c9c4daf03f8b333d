"""A Mini-mover on drives of a CAN bus is a template of the interview; new MKS drives a command."""

from __future__ import annotations

import math

import pytest
from test_config_interview import OWN, files

from armdrive.errors import BadRequest
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


# -- CiA 402 -------------------------------------------------------------------------------------


def test_the_template_of_canopen_drives_asks_for_their_nodes():
    made = files("minimover5-cia402", {"connection.port": BUS, "device.ids": "11 12 13,14 15 16"})
    assert "ids = [11, 12, 13, 14, 15, 16]" in made.arm
    config = checked(made, "bench")
    assert config.connection.dialect == "cia402"
    assert config.device.ids == (11, 12, 13, 14, 15, 16)
    assert checked(files("minimover5-cia402"), "bench").device.ids == (1, 2, 3, 4, 5, 6)


def test_it_says_who_sets_node_numbers():
    told = " ".join(files("minimover5-cia402").arm.replace("#", "").split())
    assert "switches" in told
    assert "armdrive doctor --can" in told


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
