"""Commissioning, who is on the bus: old firmware, two at once, nobody, another program."""

from __future__ import annotations

import pytest
from can_setup_bench import NAMES, Bench

from armdrive.setup.commissioning import together
from firmware_protocol.frames import pack
from firmware_protocol.mks import Code, Mode, ReadEncoder, SetCurrent, SetId, encode


def test_two_new_drives_at_once_are_found_out_and_explained():
    bench = Bench(keeps_angle=True)  # so that their encoders say different things
    plugged: list[int] = []

    def two_then_one() -> str:
        bench.board.drives.plug(2, not plugged)
        plugged.append(1)
        return "yes"

    bench.person.says["drive of the shoulder plugged"] = two_then_one
    assert bench.one()
    assert "More than one drive answers as id 1" in bench.person.text
    assert "plug in one new drive at a time" in bench.person.text
    assert len(plugged) == 2
    assert bench.ids() == (1, 2, 1, 1, 1, 1)


def test_a_second_new_drive_that_speaks_up_once_the_id_was_given_is_told_of():
    bench = Bench()
    taken, put = bench.board.nodes[1].flash, []

    def plug_another(data: bytes, now_s: float) -> None:
        if taken.of(SetId).node == 2 and not put:
            bench.board.drives.plug(0, True)
            put.append(1)
        send(data, now_s)

    send, bench.twin.link.line.send = bench.twin.link.line.send, plug_another
    turns = iter(["yes", "no"])
    bench.person.says["drive of the shoulder plugged"] = lambda: next(turns)
    assert not bench.one()
    assert "but id 1 still does as well" in bench.person.text


def test_a_drive_without_power_is_looked_for_with_what_to_check():
    bench = Bench()
    bench.twin.faults.add("drive-dead", "shoulder")
    turns = iter(["yes", "no"])
    bench.person.says["drive of the shoulder plugged"] = lambda: next(turns)
    assert not bench.one()
    assert "motor supply" in bench.person.text
    assert "120 ohm" in bench.person.text


def test_at_last_all_are_asked_together_and_who_is_missing_is_named():
    bench = Bench(factory=False)
    for motor in (0, 1, 2, 3, 5):
        bench.board.drives.plug(motor, True)
    answers = iter(["yes", "no"])
    bench.person.says["drives plugged in? Then they are asked"] = lambda: next(answers)
    missing = bench.run(together(bench.plan))
    assert "Not there, or two drives with one id: left wrist (drive 5)" in bench.person.text
    assert missing == NAMES


@pytest.mark.parametrize("firmware", ["1.0.4", "1.0.6", "1.0.8", "1.0.9"])
def test_every_firmware_is_set_up_as_far_as_it_goes(firmware):
    bench = Bench(firmware=firmware)
    bench.person.says["Current of the"] = "900"  # the oldest does not tell what it has
    assert bench.one()
    node = bench.board.nodes[1]
    assert (node.device.node, node.flash.mode) == (2, Mode.BUS_FOC)
    assert node.flash.of(SetCurrent).current_ma == 900
    guarded = bench.kept["shoulder"].watchdog is True
    assert guarded is (firmware == "1.0.9")
    assert ("no watchdog (98" in bench.person.text) is not guarded


def test_a_drive_that_answers_its_new_id_by_the_old_one_is_no_trouble():
    bench = Bench(new_id_answers=False)
    assert bench.one()
    assert bench.ids()[1] == 2


def test_a_drive_far_from_its_zero_is_offered_a_new_one():
    bench = Bench()
    bench.board.nodes[1].motor.zero -= 3_000_000
    bench.one()
    assert any(request.code is Code.ZERO and node == 2 for node, request in bench.said)
    assert abs(bench.board.nodes[1].motor.counts) < 1000


def test_beside_another_program_that_commands_drives_nothing_is_asked():
    bench = Bench()
    sleep = bench.clock.sleep

    def spoken_meanwhile(link, until_s):
        bench.clock.sleep = sleep
        bench.twin.link.line.say(pack(encode(2, ReadEncoder())), 0.0)

    bench.clock.sleep = spoken_meanwhile
    outcome = bench.walk()
    assert outcome.left_out == NAMES
    assert bench.said == bench.person.asked == []
    assert "Another program commands drives" in bench.person.text
