"""Connecting: foreign boards, wrong dialects, and what is left open when it fails."""

import itertools
import sys
from dataclasses import replace

import pytest
from amounts import amount
from cli_calls import write_arm_file
from doctor_bench import (
    LINE_ENDS_ACT,
    PREPARED,
    SPOKEN,
    EchoDevice,
    EchoingBoard,
    ScriptedDevice,
    SimPort,
    TableDevice,
    check_unmoved,
    made,
    prepared,
)
from served import Served

from armdrive import Arm, ArmFileError, BadRequest, PortUnavailable, SimulatedClock
from armdrive.arm import State
from armdrive.config.sections import Connection
from armdrive.connect.parts import assemble, connect_real, connect_simulated
from armdrive.connect.port import explained, explaining
from armdrive.connect.target import find, simulated_config, state_file
from armdrive.dialects.recognition import comes_back
from armdrive.dialects.teachmover.controller import HARMLESS_LINE
from armdrive.dialog import Grade
from armdrive.errors import DeviceFault, NoAnswer, SettingsDiffer
from armdrive.errors.printable import command_line
from armdrive.motion import connecting
from armdrive.registry import DIALECTS, simulate
from armdrive.runtime.clock import RealPace, SimulatedPace
from armdrive.setup import survey as after
from armdrive.status import Trust
from armdrive.storage.lock_client import held_arms
from armdrive.storage.record import RecordFile
from armdrive.tasks import Difference, SleepUntil, listed
from armdrive.trace.recorder import FlightRecorder
from firmware_protocol import armdroid
from firmware_protocol.armdroid import Device as ArmdroidDevice
from firmware_protocol.armdroid import Host as ArmdroidHost
from firmware_protocol.frames import Frame, pack

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
        connection = found.config.connection
        assert (found.simulated, found.config.name) == (simulated, called)
        assert (connection.port, connection.baud) == (port, baud)


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
def test_a_failed_connection_gives_the_reason_and_releases_the_arm(target, options, error, words):
    write_arm_file("bench", 'model = "teachmover"\n')
    for _ in range(2):
        with pytest.raises(error, match=words):
            Arm.connect(target, **options)


def test_a_simulated_arm_lives_at_the_pace_asked_for():
    for pace, kind in ((None, SimulatedPace), ("simulated", SimulatedPace), ("real", RealPace)):
        with Arm.connect("sim:teachmover", pace=pace) as arm:
            assert isinstance(arm.parts.pace, kind)
    with Arm.connect("sim:teachmover", pace=500) as arm:
        before_s = arm.parts.pace.now_s()
        arm.sleep(5.0)
        assert arm.parts.pace.now_s() - before_s >= 5.0


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
    def test_the_environment_variable_switches_it_off(self, monkeypatch, off):
        monkeypatch.setenv("ARMDRIVE_FORCE_SIM", off)
        with pytest.raises(PortUnavailable, match="no port /dev/ttyNOWHERE"):
            Arm.connect(NOWHERE, dialect="teachmover")


@pytest.mark.parametrize("left_over", [b"", b"17", b"1,2,3,4,5,", b"-8,"])
def test_the_first_line_to_a_teachmover_leaves_an_armdroid_nothing_to_repeat(left_over):
    host, droid = ArmdroidHost(), ArmdroidDevice()
    last = host.send(armdroid.DriveAll((10, 20, 30, 40, 50, 60)))
    droid.receive_data(last + left_over + HARMLESS_LINE + b"@READ\r")
    heard = []
    while (event := droid.next_event()) is not None:
        heard.append(event)
        if droid.unanswered is not None:
            droid.send(
                armdroid.SpeedReported(25)
                if isinstance(event, armdroid.SetSpeed)
                else armdroid.OffsetsReported((0, 0, 0, 0, 0, 0))
            )
    motions = [each for each in heard if isinstance(each, armdroid.DriveAll | armdroid.DriveOne)]
    assert motions[0] == armdroid.DriveAll((10, 20, 30, 40, 50, 60))
    assert armdroid.DriveAll((0, 0, 0, 0, 0, 0)) in motions[1:]
    for motion in motions[1:]:
        assert not any(motion.steps if isinstance(motion, armdroid.DriveAll) else (motion.steps,))


# -- Wrong dialects --------------------------------------------------------------------------------

ON_SERIAL = [name for name, row in DIALECTS.items() if not row.can]
PAIRS = [(x, y) for x, y in itertools.product(ON_SERIAL, SPOKEN) if x != y]
PORT = "/dev/ttyARM"


def connected(dialect: str, port: SimPort, baud: int | None = None) -> Arm:
    config = simulated_config(dialect)
    connection = replace(config.connection, port=PORT)
    port.tune(baud or connection.baud)
    pace = SimulatedPace()
    pace.clock.now_s = port.now
    try:
        recorder = FlightRecorder()
        with explaining(recorder.ring.entries, connection):
            return Arm(assemble(config, port, pace, simulated=True, tracer=recorder))
    finally:
        port.now = max(port.now, pace.clock.now_s)


def refused(dialect: str, port: SimPort, baud: int | None = None) -> str:
    with pytest.raises(DeviceFault) as fault:
        connected(dialect, port, baud).close()
    sentence = str(fault.value)
    assert f"`armdrive doctor {PORT}`" in sentence
    assert "\n" not in sentence
    return sentence


@pytest.mark.parametrize(("asked", "there"), PAIRS)
@pytest.mark.parametrize("same_baud", amount([True], [True, False]))
def test_the_wrong_dialect_moves_nothing_and_is_reported(asked, there, same_baud):
    for state in PREPARED[there]:
        if (there, state) not in LINE_ENDS_ACT:
            port = prepared(there, state)
            refused(asked, port, port.device.board.baud if same_baud else None)
            check_unmoved(port, there, state)


@pytest.mark.parametrize(
    ("asked", "says", "named"),
    [
        ("teachmover", b"Welcome, Armdroid!\r\n", "set the dialect to armdroid"),
        (
            "teachmover",
            b"\r\nGrbl 1.1h ['$' for help]\r\n",
            "it is Grbl 1.1h; set the dialect to grbl",
        ),
        ("armdroid", b"1\r0,0,0,0,0,0,0\r", "set the dialect to teachmover"),
        ("armdroid", b"\xaa\x02\x02\x01\x01\xa9\x03", "set the dialect to robko01"),
        ("teachmover", b"0,0,0,0,0,0,0\r", "Robko 01 retrofit, in its text mode"),
        ("teachmover", b"\x00\x80\xe0\x00\xf8", "is the baud rate right?"),
        ("teachmover", b"hello, who is there?\r\n", "dialect: 'hello, who is there?"),
        ("teachmover", b"@,d,,,", "The bytes received are not in the teachmover dialect"),
    ],
)
def test_the_error_quotes_what_was_received(asked, says, named):
    port = SimPort(ScriptedDevice(answers=says))
    assert named in refused(asked, port)


def test_silence_is_reported_as_silence():
    sentence = refused("teachmover", SimPort(ScriptedDevice()))
    assert "The bytes received" not in sentence
    assert "The device" not in sentence
    assert "no answer" in sentence


@pytest.mark.parametrize("half", [b"1", b"1\r0,0,0", b"1\r0,0,0,0,0,0,"])
def test_half_an_answer_of_the_right_dialect_does_not_count(half):
    port = SimPort(ScriptedDevice(answers=half))
    assert "no answer" in refused("teachmover", port)


@pytest.mark.parametrize("asked", SPOKEN)
def test_a_banner_in_mid_stream_does_no_harm(asked):
    """The board starts while its port is opened: what it had begun to say breaks off."""
    port = prepared(asked, "fresh")
    before = port.device.world.motors
    if hasattr(port.device.board, "opened"):
        port.device.board.opened()
    port.line.say(b"offse\r\n<Idle|MP\xaa\x02\x0e", port.now)
    connected(asked, port).close()
    port.pass_time(20.0)
    assert port.device.world.motors == before


@pytest.mark.parametrize(
    ("port", "named"),
    [
        (PORT, f"`armdrive doctor {PORT}` finds"),
        ("/dev/my arm", f"`{command_line('doctor', '/dev/my arm')}` finds"),
        ("", "`armdrive ports` shows"),
    ],
)
def test_an_arm_that_is_found_by_its_number_alone_has_no_port_to_name(port, named):
    connection = Connection("teachmover", port, usb_serial="A50285BI")
    assert named in str(explained(DeviceFault("no answer"), b"", connection))


def test_a_bus_is_looked_at_by_the_survey_of_buses():
    connection = Connection("mks", "can:slcan:/dev/ttyACM0?bitrate=500000")
    heard = pack(Frame(0x701, b"\x05")) * 2 + pack(Frame(0x81))
    sentence = str(explained(NoAnswer("no answer"), heard, connection))
    assert "but not the answer: ids 701, 81" in sentence
    assert "Nothing was received" in str(explained(NoAnswer("no answer"), b"", connection))
    assert "`armdrive doctor --can 'slcan:/dev/ttyACM0?bitrate=500000'`" in sentence


# -- Foreign boards --------------------------------------------------------------------------------

SMOOTHIE_STATUS = b"<Idle|MPos:0.0000,0.0000,0.0000|WPos:0.0000,0.0000,0.0000|F:0,100.0>\r\n"
OLD_STATUS = b"<Idle,MPos:0.000,0.000,0.000,WPos:0.000,0.000,0.000>\r\n"
OLD_GREETING = b"\r\nGrbl 0.9j ['$' for help]\r\n"
FOREIGN = {
    "Marlin, the firmware of a 3D printer": TableDevice(
        {}, b'echo:Unknown command: ""\nok\n', b"start\r\necho:Marlin 2.1.2\r\n"
    ),
    "Smoothieware": TableDevice({b"?": SMOOTHIE_STATUS}, b"ok\r\n", b"Smoothie\r\nok\r\n"),
    "Grbl 0.9j, whose reports have an older form": TableDevice(
        {b"?": OLD_STATUS, b"\x18": OLD_GREETING, b"$I": b"[0.9j.20150930:]\r\nok\r\n"},
        b"ok\r\n",
        OLD_GREETING,
    ),
    "an ESP32 whose firmware has sent nothing yet": TableDevice(
        {}, b"", b"ets Jun  8 2016 00:22:57\r\n\r\nrst:0x1 (POWERON_RESET),boot:0x13\r\n"
    ),
}
MOTION = (b"G1", b"G0", b"$J", b"$H", b"X")


@pytest.mark.parametrize("name", FOREIGN)
def test_other_firmware_is_named_with_the_remedy_and_gets_no_motion(name):
    device = FOREIGN[name]
    sentence = refused("grbl", SimPort(device))
    assert f"The device does not speak grbl: it is {name}; " in sentence
    assert not any(word in device.heard for word in MOTION)


def test_the_doctor_says_what_helps_where_it_knows_the_firmware():
    found = SimPort(TableDevice({}, b"ok\r\n", OLD_GREETING)).examine(115_200)
    (first, *_) = after.of_examination(found, connection=Connection("grbl"))
    assert first.grade is Grade.PROBLEM
    assert "Grbl 0.9j" in first.what
    assert "grblHAL" in first.fix


@pytest.mark.parametrize("dialect", ON_SERIAL)
def test_an_echoing_line_is_recognised(dialect):
    sentence = refused(dialect, SimPort(EchoDevice(baud=115_200)), 115_200)
    assert "Everything that is sent comes straight back" in sentence


def test_a_board_behind_such_a_line_moves_nothing():
    board = made("grbl")
    before = board.world.motors
    sentence = refused("grbl", SimPort(EchoingBoard(board)))
    assert "Everything that is sent comes straight back" in sentence
    assert board.world.motors == before


def test_the_doctor_finds_an_echo_and_takes_it_for_no_answer():
    echo = SimPort(EchoDevice(baud=115_200)).examine()
    assert echo.identity is None
    assert "comes straight back" in after.of_examination(echo)[0].what
    board = SimPort(EchoingBoard(made("robko01"))).examine(115_200)
    assert board.identity.dialect == "robko01"
    assert any(
        "echoes everything that is sent" in each.what for each in after.of_examination(board)
    )


@pytest.mark.parametrize(
    ("sent", "heard", "echoed"),
    [
        ([b"?", b"?", b"\x18"], b"??\x18", True),
        ([b"P\n", b"P\n", b"P\n"], b"P\nP\nP\n", True),
        ([b"P\n", b"P\n"], b"P\nok\nP\n", False),
        ([b"?", b"?", b"?"], b"<Idle|MPos:0,0,0>", False),
        ([b"$I\n", b"$$\n"], b"$I\r\n[VER:1.1h]\r\nok\r\n$$\r\nok\r\n", True),
        ([b"$I\n", b"$$\n"], b"$$\r\n$I\r\n", False),
        ([b"?", b"$I\n"], b"?ok\r\n", False),
        ([b"?"], b"?", False),
        ([], b"ok", False),
    ],
)
def test_an_echo_is_what_was_sent_in_its_order(sent, heard, echoed):
    assert comes_back(sent, heard) is echoed


@pytest.mark.parametrize(
    ("key", "value", "named"),
    [
        (13, 1.0, "reports in inches"),
        (10, 1.0, "what reports contain"),
        (100, 250.0, "steps per unit of X"),
        (104, 80.0, "steps per unit of B"),
        (1, 25.0, "motors on while standing"),
    ],
)
def test_a_foreign_setting_is_named_and_nothing_moves_before_it_is_mended(key, value, named):
    board = made("grbl")
    board.board.settings.values[key] = value
    arm = connected("grbl", SimPort(board))
    before = board.world.motors
    assert named in arm.status.notice
    for move in (
        lambda: arm.move_motors(1, 0, 0, 0, 0, 0),
        lambda: arm.jog_j(base_deg=1.0),
    ):
        with pytest.raises(SettingsDiffer, match=named):
            move()
    assert board.world.motors == before


def test_a_board_that_reports_the_work_position_is_refused_with_the_line_to_send():
    board = made("grbl")
    board.board.settings.values[10] = 0.0
    assert "its reports lack the machine position: send `$10=3`" in refused("grbl", SimPort(board))


def test_a_new_board_differs_in_many_settings_and_three_are_named():
    may = [Difference(f"$11{axis}", "500", "600", f"$11{axis}=600", must=False) for axis in "01"]
    must = [Difference(f"$10{axis}", "400", "1", f"$10{axis}=1") for axis in "012"]
    assert listed([*may, *must]) == "; ".join(
        [*(f"$10{axis} is 400, expected 1: send `$10{axis}=1`" for axis in "012"),
         "and 2 more, which `armdrive doctor` lists"]
    )  # fmt: skip
    assert listed(may).count("expected") == 2


# -- What a saved position is worth ----------------------------------------------------------------

AT_ZERO = {
    "an Uno is reset, and deaf for a while": ("armdroid", {"board": "uno"}, True, Trust.SUSPECT),
    "an Uno that answers at once was not": ("armdroid", {"board": "uno"}, False, Trust.RESTORED),
    "a Leonardo is not reset": ("armdroid", {}, True, Trust.RESTORED),
    "a GRBL board greets after a reset": ("grbl", {}, True, Trust.SUSPECT),
    "a GRBL board that was not does not": ("grbl", {}, False, Trust.RESTORED),
    "a TeachMover is not reset": ("teachmover", {}, True, Trust.RESTORED),
}
"""Registers of zero in the record and on the board: dialect, board, whether DTR rises, trust."""


def open_port(twin, *, dtr_rises):
    """Open the port of a standing board, which some boards notice."""
    twin.link.reopen()
    if dtr_rises and hasattr(twin.board, "opened"):
        twin.board.opened()
    elif dtr_rises and twin.board.title == "GRBL board":
        twin.board.reset()


def saved_at_zero(tmp_path, dialect, board):
    """Return a simulated arm whose registers are zero, and the record of its reference."""
    twin, config = simulate(simulated_config(dialect), **board), simulated_config(dialect)
    recorder = RecordFile(tmp_path / "record.json")
    with Arm(connect_simulated(config, twin=twin, record_store=recorder)) as arm:
        arm.reference.declare(twin.world.joints, opening_mm=twin.world.opening_mm)
        assert not twin.board.registers.largest
    return twin, config, recorder


@pytest.mark.parametrize("name", AT_ZERO)
def test_registers_of_zero_prove_nothing_if_opening_the_port_may_have_reset_the_board(
    tmp_path, name
):
    dialect, board, dtr_rises, trust = AT_ZERO[name]
    twin, config, recorder = saved_at_zero(tmp_path, dialect, board)
    open_port(twin, dtr_rises=dtr_rises)
    with Arm(connect_simulated(config, twin=twin, record_store=recorder)) as arm:
        assert arm.status.trust is trust
        assert ("zero" in arm.status.trust_reason) is (trust is Trust.SUSPECT)


def test_a_position_is_judged_after_the_settings_were_read(tmp_path, monkeypatch):
    twin, config, recorder = saved_at_zero(tmp_path, "teachmover", {})
    read = connecting.compare_settings

    def slow_board(context):
        found = yield from read(context)
        yield SleepUntil(context.now_s + 1.0)
        twin.device.jog((30, 0, 0, 0, 0, 0))
        return found

    monkeypatch.setattr(connecting, "compare_settings", slow_board)
    twin.link.reopen()
    with Arm(connect_simulated(config, twin=twin, record_store=recorder)) as arm:
        assert arm.status.trust is Trust.SUSPECT
        assert arm.status.acknowledged == twin.world.motors


# -- A connection that cannot be handed to its caller is closed ------------------------------------

UNFINISHED = (
    "armdrive.connect.parts.Core",
    "armdrive.connect.parts.connecting.connect",
    "armdrive.connect.parts.replace",
    "armdrive.arm.Recorder",
    "armdrive.arm.serve",
)
"""Calls on the way from the open port to the arm that its caller gets."""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no pseudo-terminals")
def test_ctrl_c_while_an_arm_is_built_leaves_neither_its_port_nor_its_lock_held(
    tmp_path, monkeypatch
):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    with Served("teachmover", pty=tmp_path / "arm") as there:
        for place in UNFINISHED:
            with monkeypatch.context() as patched:
                patched.setattr(place, interrupted)
                with pytest.raises(KeyboardInterrupt):
                    Arm.connect(there.port, dialect="teachmover")
            assert held_arms() == [], place
            Arm.connect(there.port, dialect="teachmover").close()
