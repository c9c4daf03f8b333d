"""From what a person calls an arm to a connected one: names, files, ports, twins."""

from __future__ import annotations

import pytest
from cli_calls import write_arm_file

from armdrive import Arm, ArmFileError, BadRequest, PortUnavailable, SimulatedClock
from armdrive.arm import State
from armdrive.connect.parts import connect_real
from armdrive.connect.target import find, simulated_config, state_file
from armdrive.dialects.teachmover.controller import FIRST_LINE
from armdrive.errors.printable import command_line
from armdrive.runtime.clock import RealPace, SimulatedPace
from firmware_protocol import armdroid
from firmware_protocol.armdroid import Device as ArmdroidDevice
from firmware_protocol.armdroid import Host as ArmdroidHost

NOWHERE = "/dev/ttyNOWHERE"
TWO_LINES = f'model = "teachmover"\n[connection]\nport = "{NOWHERE}"\n'


def test_an_arm_is_found_by_its_dialect_its_file_or_its_port(tmp_path):
    write_arm_file("bench", TWO_LINES)
    path = tmp_path / "elsewhere.toml"
    path.write_text(TWO_LINES)
    slow = {"dialect_name": "teachmover", "baud": 1200}
    for name, options, simulated, called, port, baud in (
        ("sim:teachmover", {}, True, "sim:teachmover", "", 9600),
        ("bench", {}, False, "bench", NOWHERE, 9600),
        (str(path), {}, False, "elsewhere", NOWHERE, 9600),
        (NOWHERE, {"dialect_name": "teachmover"}, False, NOWHERE, NOWHERE, 9600),
        ("COM3", slow, False, "COM3", "COM3", 1200),
    ):
        found = find(name, **options)
        wire = found.config.connection
        assert (found.simulated, found.config.name) == (simulated, called)
        assert (wire.port, wire.baud) == (port, baud)


@pytest.mark.parametrize(
    ("target", "options", "error", "words"),
    [
        (NOWHERE, {}, BadRequest, rf"teachmover.*armdrive doctor {NOWHERE}"),
        ("/dev/my arm", {}, BadRequest, command_line("doctor", "/dev/my arm")),
        (NOWHERE, {"dialect": "teachmoover"}, BadRequest, "did you mean 'teachmover'"),
        ("sim:teachmoover", {}, BadRequest, "did you mean 'teachmover'"),
        ("bnech", {}, ArmFileError, "sim:teachmover.*did you mean 'bench'"),
        ("nowhere.toml", {}, ArmFileError, r"nowhere\.toml cannot be read"),
        ("bench", {}, PortUnavailable, r"\[connection\]"),
        (NOWHERE, {"dialect": "teachmover"}, PortUnavailable, NOWHERE),
        *(("sim:teachmover", {"pace": pace}, BadRequest, r"pace must be .*SimulatedClock")
          for pace in ("fast", 0, -1, 0.0)),
        *((target, {"dialect": "teachmover", "pace": pace}, BadRequest, "real time")
          for target in (NOWHERE, "socket://127.0.0.1:9")
          for pace in ("simulated", SimulatedClock())),
    ],
    ids=lambda value: "" if isinstance(value, dict) else str(value),  # a clock's text varies
)  # fmt: skip
def test_what_leads_to_no_arm_is_refused_with_the_reason_and_the_arm_is_given_back(
    target, options, error, words
):
    write_arm_file("bench", 'model = "teachmover"\n')
    for _ in range(2):
        with pytest.raises(error, match=words):
            Arm.connect(target, **options)


@pytest.mark.parametrize(
    ("pace", "kind"), [(None, SimulatedPace), ("simulated", SimulatedPace), ("real", RealPace)]
)
def test_a_simulated_arm_lives_at_the_pace_asked_for(pace, kind):
    with Arm.connect("sim:teachmover", pace=pace) as arm:
        assert isinstance(arm.pace, kind)


def test_a_factor_is_a_pace_too():
    with Arm.connect("sim:teachmover", pace=500) as arm:
        before_s = arm.pace.now_s()
        arm.sleep(5.0)
        assert arm.pace.now_s() - before_s >= 5.0


class TestForcedSimulation:
    """`ARMDRIVE_FORCE_SIM=1`: every arm is its simulated twin."""

    @pytest.fixture(autouse=True)
    def _forced(self, monkeypatch):
        monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")

    def test_a_port_becomes_the_twin_of_its_arm(self):
        with Arm.connect(NOWHERE, dialect="teachmover") as arm:
            assert arm.status.simulated
            assert "SIMULATED" in arm.status.which
            arm.home()
            assert arm.status.state is State.STANDBY

    def test_an_arm_file_becomes_its_own_twin(self):
        write_arm_file("bench", TWO_LINES + "[motion]\nplanned_burst_s = 0.4\n")
        with Arm.connect("bench") as arm:
            assert arm.simulated
            assert arm.config.motion.planned_burst_s == 0.4

    def test_the_twin_never_touches_the_record_of_the_real_arm(self):
        write_arm_file("bench", TWO_LINES)
        twin = find("bench").config.name
        assert twin != "bench"
        assert state_file(twin) != state_file("bench")

    def test_opening_a_real_port_is_an_error(self):
        with pytest.raises(PortUnavailable, match="ARMDRIVE_FORCE_SIM"):
            connect_real(find(NOWHERE, dialect_name="teachmover").config)

    @pytest.mark.parametrize("off", ["", "0"])
    def test_it_is_off_where_the_variable_says_so(self, monkeypatch, off):
        monkeypatch.setenv("ARMDRIVE_FORCE_SIM", off)
        with pytest.raises(PortUnavailable, match="no port /dev/ttyNOWHERE"):
            Arm.connect(NOWHERE, dialect="teachmover")


def test_a_simulated_arm_accepts_longer_planned_bursts_than_a_real_one():
    real = find(NOWHERE, dialect_name="teachmover").config
    assert simulated_config("teachmover").motion.planned_burst_s > real.motion.planned_burst_s


@pytest.mark.parametrize("left_over", [b"", b"17", b"1,2,3,4,5,", b"-8,"])
def test_the_first_line_to_a_teachmover_leaves_an_armdroid_nothing_to_repeat(left_over):
    host, droid = ArmdroidHost(), ArmdroidDevice()
    last = host.send(armdroid.DriveAll((10, 20, 30, 40, 50, 60)))
    droid.receive_data(last + left_over + FIRST_LINE + b"@READ\r")
    heard = []
    while (event := droid.next_event()) is not None:
        heard.append(event)
        if droid.unanswered is not None:
            droid.send(
                armdroid.SpeedReported(25)
                if isinstance(event, armdroid.SetSpeed | armdroid.OddSpeed)
                else armdroid.OffsetsReported((0, 0, 0, 0, 0, 0))
            )
    motions = [each for each in heard if isinstance(each, armdroid.DriveAll | armdroid.DriveOne)]
    assert motions[0] == armdroid.DriveAll((10, 20, 30, 40, 50, 60))
    assert armdroid.DriveAll((0, 0, 0, 0, 0, 0)) in motions[1:]
    for motion in motions[1:]:
        assert not any(motion.steps if isinstance(motion, armdroid.DriveAll) else (motion.steps,))
