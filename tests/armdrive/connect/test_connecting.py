"""From what a person calls an arm to a connected one: names, files, ports, twins."""

from __future__ import annotations

import pytest
from cli_calls import write_arm_file

from armdrive import Arm, ArmFileError, BadRequest, PortUnavailable, SimulatedClock
from armdrive.arm import State
from armdrive.connect.parts import connect_real
from armdrive.connect.target import find, simulated_config, state_file
from armdrive.dialects.teachmover.controller import FIRST_LINE
from armdrive.errors.printable import quoted
from armdrive.runtime.clock import RealPace, SimulatedPace
from firmware_protocol import armdroid
from firmware_protocol.armdroid import Device as ArmdroidDevice
from firmware_protocol.armdroid import Host as ArmdroidHost

TWO_LINES = 'model = "teachmover"\n[connection]\nport = "/dev/ttyNOWHERE"\n'


def test_a_simulated_arm_is_found_by_its_dialect():
    found = find("sim:teachmover")
    assert found.simulated
    assert found.config.name == "sim:teachmover"


def test_an_arm_file_is_found_by_name_and_by_path(tmp_path):
    write_arm_file("bench", TWO_LINES)
    by_name = find("bench")
    assert not by_name.simulated
    assert by_name.config.connection.port == "/dev/ttyNOWHERE"
    path = tmp_path / "elsewhere.toml"
    path.write_text(TWO_LINES)
    assert find(str(path)).config.name == "elsewhere"


def test_a_port_needs_a_dialect_and_gets_its_baud_rate():
    with pytest.raises(BadRequest, match=r"teachmover.*armdrive doctor /dev/ttyNOWHERE"):
        find("/dev/ttyNOWHERE")
    with pytest.raises(BadRequest, match=f"armdrive doctor {quoted('/dev/my arm')}"):
        find("/dev/my arm")
    found = find("/dev/ttyNOWHERE", dialect_name="teachmover")
    assert found.config.connection.baud == 9600
    assert find("COM3", dialect_name="teachmover", baud=1200).config.connection.baud == 1200


def test_an_unknown_name_is_refused_with_the_known_and_the_nearest_one():
    write_arm_file("bench", TWO_LINES)
    with pytest.raises(ArmFileError, match="did you mean 'bench'") as refusal:
        find("bnech")
    assert "sim:teachmover" in str(refusal.value)


def test_an_unknown_dialect_is_refused_with_the_nearest_one():
    for call in (
        lambda: find("sim:teachmoover"),
        lambda: find("/dev/ttyNOWHERE", dialect_name="teachmoover"),
    ):
        with pytest.raises(BadRequest, match="did you mean 'teachmover'"):
            call()


def test_a_missing_arm_file_is_named():
    with pytest.raises(ArmFileError, match=r"nowhere\.toml cannot be read"):
        find("nowhere.toml")


def test_an_arm_file_without_a_port_says_where_to_write_it():
    write_arm_file("bench", 'model = "teachmover"\n')
    with pytest.raises(PortUnavailable, match=r"\[connection\]"):
        Arm.connect("bench")


def test_a_port_that_does_not_exist_is_named_and_gives_the_arm_back():
    for _ in range(2):
        with pytest.raises(PortUnavailable, match="/dev/ttyNOWHERE"):
            Arm.connect("/dev/ttyNOWHERE", dialect="teachmover")


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


@pytest.mark.parametrize("pace", ["fast", 0, -1, 0.0])
def test_other_paces_are_refused(pace):
    with pytest.raises(BadRequest, match=r"pace must be .*SimulatedClock"):
        Arm.connect("sim:teachmover", pace=pace)


@pytest.mark.parametrize("target", ["/dev/ttyNOWHERE", "socket://127.0.0.1:9"])
@pytest.mark.parametrize("pace", ["simulated", SimulatedClock()])
def test_a_real_arm_knows_real_time_alone(target, pace):
    with pytest.raises(BadRequest, match="real time"):
        Arm.connect(target, dialect="teachmover", pace=pace)


class TestForcedSimulation:
    """`ARMDRIVE_FORCE_SIM=1`: every arm is its simulated twin."""

    @pytest.fixture(autouse=True)
    def _forced(self, monkeypatch):
        monkeypatch.setenv("ARMDRIVE_FORCE_SIM", "1")

    def test_a_port_becomes_the_twin_of_its_arm(self):
        with Arm.connect("/dev/ttyNOWHERE", dialect="teachmover") as arm:
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
            connect_real(find("/dev/ttyNOWHERE", dialect_name="teachmover").config)

    @pytest.mark.parametrize("off", ["", "0"])
    def test_it_is_off_where_the_variable_says_so(self, monkeypatch, off):
        monkeypatch.setenv("ARMDRIVE_FORCE_SIM", off)
        with pytest.raises(PortUnavailable, match="no port /dev/ttyNOWHERE"):
            Arm.connect("/dev/ttyNOWHERE", dialect="teachmover")


def test_a_simulated_arm_accepts_longer_planned_bursts_than_a_real_one():
    real = find("/dev/ttyNOWHERE", dialect_name="teachmover").config
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
