"""The interview about drives on a CAN bus: it asks for the adapter, and for no baud rate."""

from __future__ import annotations

import pytest
from test_config_interview import files, interview_of

from armdrive.dialog.conversation import WrongAnswer
from armdrive.setup.draft import Surroundings
from armdrive.setup.interview import Interview

BUS = "can:slcan:/dev/ttyACM0?bitrate=500000"
BUSES = ("can:socketcan:can0", BUS)


def at_the_port(dialect, **around):
    """Return an interview that has come to the question for the port."""
    interview = Interview(Surroundings(**around))
    given = {"name": "bench", "template": "minimover5-grbl", "dialect": dialect}
    while interview.question.key != "connection.port":
        interview.answer(given.get(interview.question.key, ""))
    return interview


def test_a_bus_is_asked_for_its_adapter_and_for_no_baud_rate():
    interview = at_the_port("mks", ports=("/dev/ttyACM0",), buses=BUSES)
    assert "CAN adapter" in interview.question.words
    assert interview.question.choices == tuple((bus, "") for bus in BUSES)
    interview.answer("2")
    assert interview.draft.get("connection.port") == BUS
    assert interview.question.key != "connection.baud"


def test_a_serial_line_is_asked_for_its_port_and_its_baud_rate():
    interview = at_the_port("grbl", ports=("/dev/ttyACM0",), buses=BUSES)
    assert interview.question.choices == (("/dev/ttyACM0", ""),)
    interview.answer("1")
    assert interview.question.key == "connection.baud"


@pytest.mark.parametrize("port", ["/dev/ttyACM0", "COM3", "socket://host:1", "7", "can0"])
def test_what_is_no_adapter_is_refused_with_an_example(port):
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
