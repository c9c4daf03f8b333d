"""Who is recognised by what was heard, and which findings come of it."""

from __future__ import annotations

import pytest
from doctor_bench import BANNER, PROBES, SPOKEN, WHO, EchoDevice, ScriptedDevice, SimPort, made
from hypothesis import given
from hypothesis import strategies as st
from pages import page

from armdrive.config.sections import Connection
from armdrive.dialects.recognition import Identity
from armdrive.dialog.conversation import Grade, any_problem
from armdrive.registry import DIALECTS
from armdrive.runtime.engine import excerpt
from armdrive.setup import ports as before
from armdrive.setup import survey as after
from armdrive.setup.prober import Examination
from armdrive.setup.survey import of_settings
from armdrive.tasks import DeviceSettings, Difference


@pytest.mark.parametrize(
    ("heard", "dialect", "firmware", "restarted"),
    [
        (b"Welcome, Armdroid!\r\n", "armdroid", "Armdroid serial driver", True),
        (b"version = 1.3\r\n", "armdroid", "Armdroid serial driver 1.3", False),
        (b"xx\r\noffsets = 1,2,3,4,5,-6\r\n", "armdroid", "Armdroid serial driver", False),
        (BANNER, "grbl", "Grbl 1.1h", True),
        (b"\xfe\x00lo" + BANNER + b"<Idle|MPos:0.000,0.000,0.000>", "grbl", "Grbl 1.1h", True),
        (b"\r\nGrbl 1.1h ['$' fo", "grbl", "Grbl 1.1h", True),
        (b"GrblHAL 1.1f ['$' or '$HELP' for help]\r\n", "grbl", "GrblHAL 1.1f", True),
        (
            b"Grbl 3.7 [FluidNC v3.7.8 (wifi) '$' for help]\r\n",
            "grbl",
            "FluidNC v3.7.8 (wifi)",
            True,
        ),
        (b"<Idle|MPos:0.000,0.000,0.000|FS:0,0>\r\n", "grbl", "GRBL, version unknown", False),
        (b"error:9\r\n", "grbl", "GRBL, version unknown", False),
        (BANNER + b"[VER:1.1h.20190830:]\r\nok\r\n", "grbl", "Grbl 1.1h (1.1h.20190830)", True),
        (b"?\xaa\x02\x02\x01\x01\xa9\x03?", "robko01", "Robko 01 SUPER protocol", False),
        (b"0\r1\r1,-2,3,4,5,6,0\r", "teachmover", "TeachMover", False),
        (b"\r\n1, -2, 3, 4, 5, 6, 0\r\n", "", "Robko 01 retrofit, in its text mode", False),
        (b"start\necho:Marlin 2.1\n", "", "Marlin, the firmware of a 3D printer", False),
        (b"rst:0x1 (POWERON_RESET)\r\n", "", "an ESP32 whose firmware has sent nothing yet", False),
    ],
)
def test_each_is_known_by_what_it_says(heard, dialect, firmware, restarted):
    assert WHO.recognise(heard) == Identity(dialect, firmware, restarted)


@pytest.mark.parametrize(
    "heard",
    [b"", b"ok\r\n", b"0\r", b"1\r", b"1\r1,2,3", b"Gr", b"offsets = 1,2", b"\xaa\x02\x02\x01\x01"],
)
def test_too_little_is_nobody(heard):
    assert WHO.recognise(heard) is None


@given(st.binary(max_size=200))
def test_no_bytes_whatever_make_it_fail(heard):
    WHO.recognise(heard)
    excerpt(heard)


@pytest.mark.parametrize("dialect", SPOKEN)
@pytest.mark.parametrize("own_baud", [True, False])
def test_every_simulated_arm_is_found_with_what_to_do_next(dialect, own_baud):
    device = made(dialect)
    found = SimPort(device).examine(device.board.baud if own_baud else None)
    findings = after.of_examination(found)
    assert not any_problem(findings)
    assert f"it speaks {dialect}" in findings[0].what
    next_steps = after.next_steps("/dev/ttyUSB0", found)
    assert next_steps[-1] == f"armdrive status --port /dev/ttyUSB0 --dialect {dialect}"
    assert f'dialect = "{dialect}"' in after.arm_file_lines("/dev/ttyUSB0", found)


def test_a_rate_that_is_not_the_usual_one_is_part_of_what_to_do_next():
    port = SimPort(ScriptedDevice(answers=b"version = 1.3\r\n", baud=19200))
    found = port.examine(19200)
    assert after.next_steps("COM 3", found)[0].endswith("--dialect armdroid --baud 19200")
    assert "baud = 19200" in after.arm_file_lines("COM3", found)


def test_the_version_of_a_grbl_board_is_asked_only_when_it_has_just_started():
    still = ScriptedDevice(answers=b"<Idle|MPos:0.000,0.000,0.000>\r\n", baud=115200)
    SimPort(still).examine(115200)
    assert still.heard == b"?"
    started = ScriptedDevice((1.0, BANNER), baud=115200)
    found = SimPort(started).examine(115200)
    assert started.heard == b"$I\n"
    assert found.restarted


def test_a_board_that_restarts_is_a_note_with_what_spares_it_the_next_time():
    found = SimPort(ScriptedDevice((1.0, BANNER), baud=115200)).examine(115200)
    plain = after.of_examination(found)[-1]
    assert plain.grade is Grade.NOTE
    assert "keep_dtr_on_close = true" in plain.mend
    wire = Connection("grbl", raise_dtr=True, keep_dtr_on_close=True)
    spared = after.of_examination(found, wire=wire)[-1]
    assert "the first opening after plugging in" in spared.what


def test_a_greeting_over_a_network_is_not_taken_for_a_reset_of_dtr():
    found = Examination(Identity("grbl", "FluidNC v3", restarted=True), None)
    assert "serial server" in after.of_examination(found)[-1].what
    assert "raise_dtr = true" not in after.arm_file_lines("socket://arm:23", found)


def test_first_words_at_another_rate_are_a_restart_too():
    device = ScriptedDevice((0.5, b"Welcome, Armdroid!\r\n"), answers=b"version = 1.3\r\n")
    found = SimPort(device).examine()
    assert (found.identity.dialect, found.baud) == ("armdroid", 9600)
    assert found.restarted


NO_ARM = {
    # what is behind the port, the only rate that was tried if there was one, and what is said
    "silence at every rate": (ScriptedDevice(), None, "no device answers at 9600 and 115200 baud"),
    "silence at one rate": (ScriptedDevice(), 2400, "no device answers at 2400 baud; "),
    "an echo": (EchoDevice(), 9600, "comes straight back"),
    "half a line": (ScriptedDevice((1.0, b"Gr")), 9600, "'Gr'"),
    "a printer": (ScriptedDevice(answers=b"echo:Marlin 2.1\n"), 9600, "3D printer"),
    "text mode": (ScriptedDevice(answers=b"\r\n1, 2, 3, 4, 5, 6, 0\r\n"), 9600, "SUPER"),
    "unreadable bytes": (ScriptedDevice((1.0, bytes(range(0x80, 0xA0)))), 9600, "(--baud N)"),
    "an answer to STATUS alone": (
        ScriptedDevice(answers=b"0\r"), 9600, "not in a dialect that armdrive knows"),
}  # fmt: skip


@pytest.mark.parametrize("what", NO_ARM)
def test_what_is_no_arm_is_one_problem_with_a_remedy(what):
    device, baud, said = NO_ARM[what]
    (found,) = after.of_examination(SimPort(device).examine(baud), baud)
    assert found.grade is Grade.PROBLEM
    assert found.mend
    assert said in f"{found.what}; {found.mend}"


def test_another_dialect_than_expected_is_a_problem():
    found = SimPort(ScriptedDevice(answers=b"version = 1.3\r\n")).examine(9600)
    _, differs = after.of_examination(found, 9600, Connection("teachmover"))
    assert differs.grade is Grade.PROBLEM
    assert "the device speaks armdroid, not teachmover" in differs.what
    assert 'dialect = "armdroid"' in differs.mend


def test_every_dialect_can_be_recommended():
    for name in DIALECTS:
        found = Examination(Identity(name, name), DIALECTS[name].baud)
        assert after.next_steps("/dev/ttyUSB0", found)


def test_settings_that_differ_are_findings_with_the_line_that_mends_them():
    must = Difference("step idle delay $1", "25", "255", "$1=255")
    may = Difference("max rate $110", "500", "600", "$110=600", must=False)
    listed = of_settings(DeviceSettings((must, may)))
    assert [each.grade for each in listed] == [Grade.PROBLEM, Grade.NOTE]
    assert [each.mend for each in listed] == ["$1=255", "$110=600"]
    assert of_settings(DeviceSettings(firmware="Grbl 1.1h"))[0].grade is Grade.OK


def test_an_adapter_that_holds_bytes_back_is_found(tmp_path):
    timer = tmp_path / "ttyUSB0" / "latency_timer"
    timer.parent.mkdir()
    timer.write_text("16\n")
    (found,) = before.latency("/dev/ttyUSB0", tmp_path)
    assert (found.grade, found.mend) == (Grade.NOTE, f"echo 1 | sudo tee {timer}")
    timer.write_text("1\n")
    assert before.latency("/dev/ttyUSB0", tmp_path)[0].grade is Grade.OK
    timer.write_text("?")
    assert before.latency("/dev/ttyUSB0", tmp_path) == []
    assert before.latency("/dev/ttyACM0", tmp_path) == []


def test_the_page_shows_every_probe_as_it_is_said():
    text = page("protocols")
    for probe in PROBES:
        said = probe.data.decode("latin-1").encode("unicode_escape").decode("ascii")
        assert f"`{said}` |" in text, probe
        assert f"| {probe.baud} |" in text
