"""Who answers to an id: its firmware, and whether it is alone. One way to find out, for all."""

from __future__ import annotations

import pytest
from amounts import every_row
from can_setup_bench import Bench

from armdrive.dialects.mks.commissioning import alone
from armdrive.dialects.mks.exchange import SurplusAnswers
from armdrive.dialects.mks.survey import is_shared, known
from firmware_protocol.mks import Code


def on_bus(*motors, **settings):
    bench = Bench(factory=False, **settings)
    for motor in motors:
        bench.board.node(motor).port.plugged = True
    return bench


@pytest.mark.parametrize(
    ("settings", "words", "told"),
    [
        ({"firmware": "1.0.9"}, "1.0.9", True),
        ({"firmware": "1.0.8"}, "1.0.8", True),
        ({"firmware": "1.0.6"}, "1.0.6", False),
        ({"firmware": "1.0.4"}, "1.0.4", False),
    ],
)
def test_firmware_is_reported_or_concluded_from_answers(settings, words, told):
    found = on_bus(0, **settings).script(known, 1).firmware
    assert (str(found), found.reported) == (words, told)
    assert (found.board is None) is (words < "1.0.8")


@every_row("asked, answered, shared", [(3, 1, ()), (3, 3, ()), (3, 4, ()), (3, 5, (1,))])
def test_two_more_answers_than_questions_are_those_of_two_drives(asked, answered, shared):
    surplus = SurplusAnswers()
    for _ in range(asked):
        surplus.asked(1, Code.ENCODER)
        surplus.asked(1, Code.STATE)
        surplus.answered(1, Code.STATE)
    for _ in range(answered):
        surplus.answered(1, Code.ENCODER)
    assert surplus.shared == shared
    assert surplus.owed is (answered < asked)
    surplus.clear()
    assert surplus.shared == ()


def test_a_shared_id_is_found_by_its_answers():
    bench = on_bus(0, 1, keeps_angle=True)
    bench.board.node(1).set_id(1, bench.board.now_s)
    assert bench.script(is_shared, 1)
    assert not bench.script(alone, 1)
    bench.board.node(1).set_id(2, bench.board.now_s)
    assert not bench.script(is_shared, 1)
    assert bench.script(alone, 1)
    assert not bench.script(alone, 3)
