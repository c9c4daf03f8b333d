"""`armdrive doctor --can`: polite questions, and what their answers mean."""

from __future__ import annotations

import sys
from dataclasses import replace
from functools import partial

import pytest
from can_setup_bench import READING, Bench, ServedBus, another_program
from cli_calls import write_arm_file
from waiting import looks

from armdrive.dialects.bus import tools
from armdrive.dialects.bus.tools import Listened, listen
from armdrive.dialects.mks import survey as mks
from armdrive.dialects.mks.survey import Survey
from armdrive.dialog.conversation import Grade
from armdrive.errors import BadRequest
from armdrive.setup import survey as can_findings
from armdrive.setup.bus_survey import ids_of
from armdrive.transports.can_health import BusHealth, BusState
from armdrive.transports.ports import CanPort
from firmware_protocol.mks import (
    EncoderRead,
    Mode,
    MoveAbsoluteAxis,
    ReadEncoder,
    encode,
)
from kinematics.text import counted

needs_pty = pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")


def bench(**settings):
    """Return a bus with commissioned drives, all plugged in."""
    found = Bench(factory=False, **settings)
    for motor in range(6):
        found.device.board.drives.plug(motor, True)
    return found


def words(findings):
    return "\n".join(f"{each.grade.value} {each.what} | {each.mend}" for each in findings)


# The survey.


def test_nothing_but_readings_is_ever_sent_and_everybody_is_found():
    on = bench()
    motors, flashes = on.twin.world.motors, on.flashes()
    found = on.survey()
    assert [each.node for each in found.drives] == [1, 2, 3, 4, 5, 6]
    assert on.codes() <= READING
    assert on.flashes() == flashes
    assert on.twin.world.motors == motors
    assert not any(each.doubled or each.missed for each in found.drives)
    told = words(mks.of_answers(found, BusHealth()))
    assert "of the ids 1 to 16 these answer: 1, 2, 3, 4, 5, 6" in told
    assert "problem" not in told


def test_a_drives_problem_is_reported_with_its_remedy():
    on = bench()
    on.device.board.drives.set_mode(1, Mode.PULSE_FOC)
    on.device.board.nodes[2].stalled = True
    on.device.board.nodes[3].calibrated = False
    found = on.survey()
    told = words(mks.of_answers(found, BusHealth(), "bench"))
    assert "drive 2: mode 2 (PULSE_FOC) obeys no motion" in told
    assert "`armdrive doctor --arm bench --mend`" in told
    assert "drive 3: its protection has let the shaft go" in told
    assert "drive 4: its encoder is not calibrated" in told
    assert told.count("problem") == 3


def test_two_drives_with_one_id_are_reported_and_a_late_answer_is_not():
    on = bench(keeps_angle=True)
    on.device.board.drives.set_id(4, 2)
    found = on.survey((1, 2))
    assert [each.doubled for each in found.drives] == [False, True]
    assert "two drives have this id" in words(mks.of_answers(found, BusHealth()))
    late = bench()
    late.twin.faults.add("double-frame", 0.02, seed=3)
    assert not any(each.doubled for each in late.survey((1, 2, 3)).drives)


def test_an_arm_files_drives_are_compared_with_who_answers():
    on = bench()
    there = [each.node for each in on.survey().drives]
    assert "and no other" in words(can_findings.of_arm((1, 2, 3, 4, 5, 6), there, "bench"))
    told = words(can_findings.of_arm((2, 3, 4, 5, 6, 7), there, "bench"))
    assert "the arm file's drives 7 do not answer" in told
    assert "`armdrive can setup bench`" in told
    assert "drives 1 answer that are not in the arm file" in told


def test_old_firmware_is_reported_as_far_as_it_is_known():
    found = bench(firmware="1.0.4").survey((1,))
    told = words(mks.of_answers(found, BusHealth()))
    assert "it does not report" in told
    assert "no watchdog before firmware 1.0.9" in told


# What the evidence means.


@pytest.mark.parametrize(
    ("health", "what", "grade"),
    [
        (BusHealth(sent=32), "though the adapter took every frame", Grade.PROBLEM),
        (BusHealth(sent=32, refused=31), "no node acknowledges a frame", Grade.PROBLEM),
        (BusHealth(BusState.PASSIVE, sent=9), "no node acknowledges a frame", Grade.PROBLEM),
        (BusHealth(sent=9, error_frames=4), "a node uses another bit rate", Grade.PROBLEM),
    ],
)
def test_causes_of_silence_are_distinguished_as_far_as_possible(health, what, grade):
    (finding,) = mks.of_answers(Survey(asked=(1, 2, 3)), health)
    assert what in finding.what
    assert finding.grade is grade
    assert "--every-rate" in finding.mend


def test_a_bus_that_was_left_is_a_problem_and_one_that_warns_a_note():
    off = can_findings.of_health(BusHealth(BusState.OFF, sent=3, error_frames=9))
    assert off[0].grade is Grade.PROBLEM
    assert "bit rate" in off[0].mend
    warned = can_findings.of_health(BusHealth(BusState.WARNING, last_trouble="it says so"))
    assert warned[0].grade is Grade.NOTE
    assert "60 ohm" in warned[0].mend
    assert can_findings.of_health(BusHealth(sent=3))[0].grade is Grade.OK


def test_answers_that_get_lost_point_to_the_wiring():
    on = bench()
    on.twin.faults.add("lose-frame", 0.2, seed=5)
    found = on.survey((1, 2, 3))
    assert found.drives
    missed = sum(each.missed for each in found.drives)
    told = words(mks.of_answers(found, BusHealth(error_frames=2)))
    assert f"problem {counted(missed, 'answer')} came only after a second question" in told
    late = Survey(drives=(replace(found.drives[0], missed=1),))
    told = words(mks.of_answers(late, BusHealth()))
    assert "note 1 answer came only after a second question, 0 frames were unreadable" in told
    assert "busy computer" in told
    assert "120" in told
    told = words(mks.of_answers(replace(late, garbled=1), BusHealth(error_frames=1)))
    assert "1 frame was unreadable, 1 error frame was seen" in told


def test_bus_load_is_reported_and_other_masters_are_named():
    on = bench()
    told = can_findings.of_listening(on.listen(0.1), 0.1, 500_000)
    assert "nothing passed" in told[0].what
    reports = tuple(encode(1, EncoderRead(count)) for count in range(100))
    told = can_findings.of_listening(Listened(reports), 0.1, 500_000)
    assert "a load of 2" in told[0].what
    assert told[0].grade is Grade.OK
    command = encode(1, MoveAbsoluteAxis(5, 60, 2))
    told = can_findings.of_listening(Listened((command,), (command,)), 0.1, 0)
    assert told[0].grade is Grade.PROBLEM
    assert "drive 1: go to 5 at 60 rpm" in told[0].what


@pytest.mark.parametrize("text", ["0", "x", "1-", "1-3000", "", "3-1"])
def test_ids_are_read_or_refused(text):
    with pytest.raises(BadRequest):
        ids_of(text)
    assert ids_of("1-3, 20") == (1, 2, 3, 20)


# The command, in real time.

ARM = 'model = "minimover5-mks"\n\n[connection]\ndialect = "mks"\nport = "{port}"\n'


@pytest.fixture
def served(tmp_path, monkeypatch, _punctual):
    monkeypatch.setattr(tools, "listen", partial(listen, seconds=0.1))
    monkeypatch.setattr(mks, "LINGER_S", 0.002)  # no drive here has another one's id
    bus = ServedBus(tmp_path)
    yield bus
    bus.end()


@needs_pty
def test_a_bus_is_looked_at_and_an_arm_file_mended(call, served):
    for _ in looks("not all drives ever answered in time"):  # they are another process
        called = call("doctor", "--can", served.port.removeprefix("can:"), "--json")
        if called.code == 0 and len(called.json["drives"]) == 6:
            break
    assert [each["id"] for each in called.json["drives"]] == [1, 2, 3, 4, 5, 6]
    assert called.json["bus"]["state"] == "active"
    named = served.port.removeprefix("can:")
    ids = ("--ids", "1-6")
    said = call("doctor", "--can", named, "--dialect", "mks", *ids, code=0).out
    assert "every drive of the arm file answers" in said
    write_arm_file("bench", ARM.format(port=served.port))
    served.tell("fault drive-mode 3 2")
    said = call("doctor", "--arm", "bench", *ids, code=1).out
    assert "drive 3: mode 2 (PULSE_FOC)" in said
    assert "`armdrive doctor --arm bench --mend`" in said
    said = call("doctor", "--arm", "bench", *ids, "--mend", "--yes", code=0).out
    assert "1 setting was written" in said
    assert "every drive of the arm file answers" in said


@needs_pty
def test_trying_rates_distinguishes_an_empty_bus_from_a_wrong_rate(call, served):
    wrong = served.port.replace("500000", "250000")
    said = call("doctor", wrong, "--ids", "1-2", "--every-rate", code=6).out
    assert "no node acknowledges a frame" in said
    assert "no drive answers at 125 kbit/s" in said
    assert "at 500 kbit/s these answer: 1, 2" in said
    served.tell("plug none")
    assert "took every frame" in call("doctor", served.port, "--ids", "1-2", code=6).out


@needs_pty
def test_a_bus_on_which_another_program_commands_drives_is_left_alone(call, served, monkeypatch):
    monkeypatch.setattr(tools, "listen", partial(listen, seconds=0.4))
    with another_program(served.beside, encode(2, ReadEncoder())):
        for _ in looks("the other program was never heard"):  # it may be kept from its work
            called = call("doctor", "--can", served.port)
            if "nothing passed" not in called.out:
                break
    assert called.code == 1
    assert "another program commands drives (drive 2: read encoder" in called.out
    assert "answer" not in called.out.replace("answers", "")
    assert served.server.adapter.refused == 0


@pytest.mark.parametrize("words", [("doctor", "--yes", "--can"), ("status", "--port")])
def test_a_controller_that_is_not_on_a_bus_is_not_looked_for_there(call, words):
    sentence = call.refused(*words, "can:socketcan:can0", "--dialect", "teachmover", code=4)
    assert "can:socketcan:can0 is a CAN bus, but a controller that speaks teachmover" in sentence


def test_without_a_bus_the_adapters_are_listed(call, monkeypatch):
    monkeypatch.setattr("serial.tools.list_ports.comports", list)
    listed = "armdrive.transports.ports.list_can_ports"
    monkeypatch.setattr(listed, lambda ports: [])
    assert "knows no adapter" in call.refused("doctor", "--can", code=4)
    two = [CanPort("can:socketcan:can0", ""), CanPort("can:socketcan:can1", "")]
    monkeypatch.setattr(listed, lambda ports: two)
    assert "can:socketcan:can0, can:socketcan:can1" in call.refused("doctor", "--can", code=4)
    assert "which bus?" in call.refused("doctor", "--can", "--dialect", "mks", code=4)
