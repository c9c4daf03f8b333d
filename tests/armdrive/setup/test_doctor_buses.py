"""A bus is asked politely who is on it, and what is answered is told in words."""

from dataclasses import replace
from functools import partial

import pytest
from amounts import every_row
from can_setup_bench import READING, Bench
from canopen_nodes import NAME, Device, NodesBus

from armdrive.dialects.bus.tools import (
    Answers,
    Listened,
    Survey,
    of_nobody,
)
from armdrive.dialects.cia402 import survey as canopen
from armdrive.dialects.cia402.survey import (
    QUESTIONS,
    SERIAL_NUMBER,
    VENDOR,
    ask_nodes,
    seen_nodes,
    survey_scripts,
)
from armdrive.dialects.mks import survey as mks
from armdrive.dialog import Grade, any_problem
from armdrive.errors import BadRequest
from armdrive.setup import prober
from armdrive.setup import survey as can_findings
from armdrive.setup.bus_survey import ids_of
from armdrive.setup.dialog_runner import DialogClock, carry_out
from armdrive.setup.prober import ask_bus, harmless_ids, protocols
from armdrive.transports.can_health import BusHealth, BusState, frame_bits
from firmware_protocol.canopen import (
    CONSUMER_HEARTBEAT,
    DEVICE_TYPE,
    ERROR_CODE,
    ERROR_REGISTER,
    HEARTBEAT_REACTION,
    INCREMENTS_A_SECOND,
    MODE_SHOWN,
    NODE_MAX,
    POSITION,
    SPEED_UNIT,
    STATUSWORD,
    SUPPORTED_MODES,
    DriveState,
    Heartbeat,
    Nmt,
    NmtCommand,
    NodeState,
    SdoClient,
    Service,
    StatusBit,
    Statusword,
    Sync,
    cob_id,
)
from firmware_protocol.errors import ProtocolError
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import (
    EncoderRead,
    Mode,
    MoveAbsoluteAxis,
    ReadVersion,
    decode_request,
    encode,
)
from kinematics.text import counted

ALL_MODES = 0xA1
HEALTHY = Statusword.of(DriveState.DISABLED, StatusBit.REMOTE).value


def drive(number, **values):
    """Return a drive with nothing wrong; `values` are what it holds otherwise, by name."""
    places = {
        "kind": DEVICE_TYPE, "name": NAME, "serial": SERIAL_NUMBER, "vendor": VENDOR,
        "at": POSITION, "status": STATUSWORD, "modes": SUPPORTED_MODES, "error": ERROR_CODE,
        "register": ERROR_REGISTER, "mode": MODE_SHOWN, "unit": SPEED_UNIT,
    }  # fmt: skip
    usual = {"name": "a stepper", "serial": 100 + number, "status": HEALTHY, "modes": ALL_MODES}
    usual["unit"] = INCREMENTS_A_SECOND
    holds = {key: value for key, value in (usual | values).items() if value is not None}
    return Device(number).has({places[key]: value for key, value in holds.items()})


def survey(bus, ids=range(1, 7), heard=None, clock=None):
    scripts = survey_scripts()
    ask = partial(ask_nodes, scripts.io, tuple(ids), heard or {})
    return carry_out(scripts, ask, bus, clock or DialogClock())


def words(findings):
    return "\n".join(f"{each.grade.value} {each.what} | {each.fix}" for each in findings)


def told(*devices, heard=None, health=None):
    bus = NodesBus(*devices)
    found = survey(bus, [each.number for each in devices], heard)
    return words(canopen.of_answers(found, health or BusHealth(), "bench"))


# A CANopen bus.


def test_a_canopen_survey_finds_every_node_and_only_reads_objects():
    bus = NodesBus(*(drive(number) for number in (1, 2, 5)))
    before = [each.store.value(POSITION) for each in bus.devices]
    found = survey(bus)
    assert canopen.there(found) == (1, 2, 5)
    assert {each.can_id & 0x780 for each in bus.said} == {0x600}
    assert {each.data[0] for each in bus.said} <= {0x40, 0x60, 0x70}  # uploads, segments of them
    assert [each.store.value(POSITION) for each in bus.devices] == before
    assert not any(each.doubled or each.missed for each in found.nodes)
    assert found.garbled == 0


def test_a_drives_identity_is_described():
    said = told(drive(3, vendor=0xAB, at=-500))
    assert "of the nodes 3 these answer: 3 (CANopen)" in said
    assert "node 3: CiA 402, a drive (stepper), called a stepper, vendor 000000AB" in said
    assert "serial number 103" in said
    assert "node 3: 0240 disabled, mode 0, none, at -500, can do profile position" in said
    assert "problem" not in said
    assert "note" not in said


@every_row(
    "values, sentence",
    [
        ({"status": 0x0208, "error": 0x8611}, "problem node 4: fault: error 8611, following error"),
        ({"status": 0x020F, "error": 0x2310}, "problem node 4: fault: error 2310, continuous over"),
        ({"register": 0x08}, "note node 4: it still reports an error without a code (temperature)"),
        (
            {"status": 0x0697, "error": 0x8130, "register": 0x11},
            "(generic, communication) | the program that drove it has ended: `armdrive enable",
        ),
        ({"kind": 0x0191}, "note node 4: not a CiA 402 drive (CiA 401, an I/O module)"),
        ({"modes": 0x21}, "note node 4: without cyclic position mode its arm moves in bursts"),
        ({"modes": 0x80}, "problem node 4: it has no profile position"),
        ({"unit": None}, "note node 4: it does not report its unit of speed (60A9)"),
    ],
)
def test_problems_of_a_node_are_reported(values, sentence):
    said = told(drive(4, **values))
    assert sentence in said
    assert said.count("problem") + said.count("note") == 1


def test_missing_objects_of_a_device_are_reported_and_tolerated():
    lacking = Device(2, missing=frozenset({SUPPORTED_MODES, POSITION, NAME}))
    found = survey(NodesBus(lacking), (2,))
    (node,) = found.nodes
    assert node.refused[SUPPORTED_MODES] == "there is no such object"
    assert not node.name
    said = words(canopen.of_answers(found, BusHealth()))
    assert "6064:00 Position actual value is not reported" in said
    assert "it does not report which modes it has" in said


@every_row("place", [CONSUMER_HEARTBEAT, HEARTBEAT_REACTION])
def test_a_drive_that_would_not_stop_without_a_program_is_told_to_move_in_bursts(place):
    lacking = Device(2, missing=frozenset({place}))
    lacking.has({DEVICE_TYPE: 402, SUPPORTED_MODES: ALL_MODES, STATUSWORD: HEALTHY})
    said = words(canopen.of_answers(survey(NodesBus(lacking), (2,)), BusHealth()))
    assert f"note node 2: without object {place} it does not stop if this program dies" in said


def test_nodes_that_were_only_heard_are_told_with_what_they_say():
    heard = {9: NodeState.STOPPED, 20: NodeState.OPERATIONAL}
    bus = NodesBus(Device(9, NodeState.STOPPED))
    found = survey(bus, (1,), heard)
    assert found.asked == (1, 9, 20)
    assert canopen.there(found) == ()
    said = words(canopen.of_answers(found, BusHealth()))
    assert "problem node 9: stopped (NMT)" in said
    assert "problem node 20: sends heartbeats, but does not answer" in said


def test_two_devices_of_one_number_are_told_and_one_repeated_frame_is_not():
    twins = (drive(3, serial=7, at=1), drive(3, serial=8, at=2))
    assert "problem node 3: two devices have this number" in told(*twins)
    repeated = []

    def once(frame):  # an answer that comes twice, one time
        if frame.data[1:4] == SERIAL_NUMBER.packed and len(repeated) < 1:
            repeated.append(frame)
            again = b"\x43" + SERIAL_NUMBER.packed + (103).to_bytes(4, "little")
            bus._coming.append((0.0, pack(Frame(0x583, again))))
        return False

    bus = NodesBus(drive(3), lose=once)
    assert not survey(bus, (3,)).nodes[0].doubled


def test_answers_that_get_lost_are_asked_for_again_and_counted():
    count = iter(range(10_000))
    bus = NodesBus(drive(1), lose=lambda _: next(count) % 4 == 3)
    (node,) = survey(bus, (1,)).nodes
    assert node.missed
    assert len(node.values) + 1 == len(QUESTIONS)  # and its name
    lost = words(canopen.of_answers(survey(bus, (1,)), BusHealth(error_frames=2)))
    assert "came only after a second question" in lost
    assert "2 error frames were seen" in lost
    assert "resistor" in lost


def test_the_bus_is_not_loaded_by_being_asked():
    bus, clock = NodesBus(*(drive(number) for number in range(1, 7))), DialogClock()
    survey(bus, range(1, 128), clock=clock)
    bits = 2.2 * sum(map(frame_bits, bus.said))  # questions, and answers of the same length
    assert bits / clock.now_s() < 0.05 * 500_000
    assert clock.now_s() < 15.0


# What may be asked on whose bus.


def test_canopen_reads_command_no_mks_drive():
    for node in range(1, NODE_MAX + 1):
        bus = NodesBus(drive(node))
        survey(bus, (node,))
        for frame in bus.said:
            try:
                assert isinstance(decode_request(frame), ReadVersion)
            except ProtocolError:
                continue


def test_ids_that_mean_something_to_canopen_are_not_asked_as_mks_drives():
    ids = (1, 127, 128, 0x201, 0x601)
    there = [Answers("canopen", (1,), (1,))]
    assert harmless_ids(ids, [Answers("canopen", (1,), ())], {}) == list(ids)
    assert harmless_ids(ids, there, {}) == [1, 127]
    assert harmless_ids(ids, [], {5: NodeState.OPERATIONAL}) == [1, 127]
    assert cob_id(Service.SYNC) == 128


def test_a_bus_without_an_arm_file_is_asked_in_every_protocol():
    answers = ask_bus(NodesBus(drive(1), drive(2)), DialogClock(), (1, 2, 0x201))
    assert [each.protocol for each in answers] == ["canopen", "mks"]
    assert [each.there for each in answers] == [(1, 2), ()]
    assert [each.asked for each in answers] == [(1, 2), (1, 2)]
    on = Bench(factory=False)
    on.device.board.node(0).port.plugged = True
    line = on.twin.link.line
    line.send = type(line).send.__get__(line)  # nobody looks that all is of the MKS protocol
    answers = ask_bus(on.twin.link, DialogClock(), (1,))
    assert [each.there for each in answers] == [(), (1,)]


def test_an_arm_files_bus_is_asked_as_that_says_and_otherwise_where_nobody_answers():
    bus = NodesBus(drive(1))
    assert [each.protocol for each in ask_bus(bus, DialogClock(), (1,), {}, "cia402")] == [
        "canopen"
    ]
    answers = ask_bus(bus, DialogClock(), (1,), {}, "mks")
    assert [(each.protocol, each.there) for each in answers] == [("mks", ()), ("canopen", (1,))]
    assert {row.dialect for row in protocols().values()} == {"mks", "cia402"}


@every_row(
    "frame, commands",
    [
        (Nmt(NmtCommand.START).frame, True),
        (Sync().frame, True),
        (Frame(0x201, bytes(7)), True),
        (SdoClient(3).upload(POSITION), True),
        (Heartbeat(127, NodeState.OPERATIONAL).frame, True),
        (Heartbeat(3, NodeState.OPERATIONAL).frame, False),
        (Frame(0x183, bytes(7)), False),
        (Frame(0x583, bytes(8)), False),
        (Frame(0x083, bytes(8)), False),
        (Frame(0x7F0), False),
        (encode(2, ReadVersion()), True),
        (encode(0x201, EncoderRead(5)), False),  # an answer, whatever the id means elsewhere
    ],
)
def test_a_masters_frames_are_known(frame, commands):
    assert prober.is_command(frame, 127) is commands


def test_a_bus_that_a_canopen_master_commands_is_left_alone_and_it_is_quoted():
    frame = Nmt(NmtCommand.START).frame
    findings = can_findings.of_listening(Listened((frame,), (frame,)), 1.0, 500_000)
    assert any_problem(findings)
    assert "another program commands drives (all: start: become operational)" in words(findings)
    beats = (Heartbeat(3, NodeState.OPERATIONAL).frame, Heartbeat(4, NodeState.STOPPED).frame)
    assert seen_nodes((*beats, Sync().frame)) == {
        3: NodeState.OPERATIONAL, 4: NodeState.STOPPED
    }  # fmt: skip
    assert not any_problem(can_findings.of_listening(Listened(beats), 1.0, 500_000))


# Against an arm file, and as plain data.


def test_canopen_nodes_that_answer_are_compared_with_the_arm_file():
    found = survey(NodesBus(drive(1), drive(2, kind=0x0191)), (1, 2))
    said = words(canopen.of_arm((1, 2), found))
    assert "problem node 2 of the arm file is not a CiA 402 drive (CiA 401, an I/O module)" in said
    assert "cia402.ids" in said
    assert not canopen.of_arm((1,), found)
    said = words(can_findings.of_arm((1, 3), canopen.there(found), "bench", "cia402"))
    assert "the arm file's drives 3 do not answer" in said
    assert "can setup" not in said
    assert "drives 2 answer that are not in the arm file's cia402.ids" in said


# A bus of MKS drives, and what is the same on every bus.


def bus_bench(**settings):
    """Return a bus with commissioned drives, all plugged in."""
    found = Bench(factory=False, **settings)
    for motor in range(6):
        found.device.board.node(motor).port.plugged = True
    return found


def test_an_mks_survey_finds_every_drive_and_only_sends_readings():
    on = bus_bench()
    motors, flashes = on.twin.world.motors, on.flashes()
    found = on.survey()
    assert [each.node for each in found.nodes] == [1, 2, 3, 4, 5, 6]
    assert on.codes() <= READING
    assert on.flashes() == flashes
    assert on.twin.world.motors == motors
    assert not any(each.doubled or each.missed for each in found.nodes)
    told = words(mks.of_answers(found, BusHealth()))
    assert "of the ids 1 to 16 these answer: 1, 2, 3, 4, 5, 6" in told
    assert "problem" not in told


def test_a_drives_problem_is_reported_with_its_remedy():
    on = bus_bench()
    on.device.board.node(1).set_mode(Mode.PULSE_FOC, on.device.board.now_s)
    on.device.board.nodes[2].stalled = True
    on.device.board.nodes[3].calibrated = False
    found = on.survey()
    told = words(mks.of_answers(found, BusHealth(), "bench"))
    assert "drive 2: mode 2 (CR_vFOC) obeys no motion" in told
    assert "`armdrive doctor --arm bench --fix`" in told
    assert "drive 3: its protection has let the shaft go" in told
    assert "drive 4: its encoder is not calibrated" in told
    assert told.count("problem") == 3


@every_row("more", [(4,), (2, 3, 4, 5)])
def test_drives_with_one_id_are_reported(more):
    on = bus_bench()
    for motor in more:
        on.device.board.node(motor).set_id(2, on.device.board.now_s)
    found = on.survey((1, 2))
    assert [each.doubled for each in found.nodes] == [False, True]
    assert "more than one drive has this id" in words(mks.of_answers(found, BusHealth()))


LATE_S = 0.13
"""A little later than the first question is waited for."""


class LateBus(NodesBus):
    """A bus on which every tenth question is answered late."""

    def write(self, data, now_s):
        late = now_s + LATE_S if len(self.said) % 10 == 5 else now_s
        super().write(data, late)


def test_answers_of_a_node_that_are_only_late_do_not_point_to_the_wiring():
    bus = LateBus(*(drive(number) for number in (1, 2, 3)))
    nodes = survey(bus).nodes
    places = [frame.data[1:4] for frame in bus.said]
    assert any(places.count(each.packed) > len(nodes) for each in (VENDOR, ERROR_CODE, SPEED_UNIT))
    assert [each.missed for each in nodes] == [0, 0, 0]


@pytest.mark.parametrize("number", [1, 13, 28])
def test_answers_of_an_mks_drive_that_are_only_late_do_not_point_to_the_wiring(number):
    on = bus_bench()
    on.twin.faults.add("delay", LATE_S, f"#{number}", side="device")
    assert [each.missed for each in on.survey((1, 2, 3)).nodes] == [0, 0, 0]


def test_mks_drives_that_answer_are_compared_with_the_arm_file():
    on = bus_bench()
    there = [each.node for each in on.survey().nodes]
    assert "and no other" in words(can_findings.of_arm((1, 2, 3, 4, 5, 6), there, "bench", "mks"))
    told = words(can_findings.of_arm((2, 3, 4, 5, 6, 7), there, "bench", "mks"))
    assert "the arm file's drives 7 do not answer" in told
    assert "`armdrive can setup bench`" in told
    assert "drives 1 answer that are not in the arm file" in told


def test_of_a_drive_of_the_e_series_nothing_else_is_a_problem():
    on = bus_bench(e_series=True)
    on.device.board.node(0).set_mode(Mode.PULSE_FOC, on.device.board.now_s)
    told = words(mks.of_answers(on.survey((1,)), BusHealth()))
    assert "drive 1 is of the E series" in told
    assert told.count("problem") == 1
    told = words(mks.of_answers(bus_bench(firmware="1.0.4").survey((1,)), BusHealth()))
    assert "it does not report" in told
    assert "no watchdog before firmware 1.0.9" in told


# What the evidence means.


@every_row(
    "health, what, grade",
    [
        (BusHealth(sent=32), "though the adapter took every frame", Grade.PROBLEM),
        (BusHealth(sent=32, refused=31), "no node acknowledges a frame", Grade.PROBLEM),
        (BusHealth(BusState.PASSIVE, sent=9), "no node acknowledges a frame", Grade.PROBLEM),
        (BusHealth(sent=9, error_frames=4), "a node uses another bit rate", Grade.PROBLEM),
    ],
)
def test_causes_of_silence_are_distinguished_as_far_as_possible(health, what, grade):
    finding = of_nobody((1, 2, 3), health)
    assert what in finding.what
    assert finding.grade is grade
    assert "write another one into the adapter's address" in finding.fix


@every_row(
    "health, grade, fix",
    [
        (BusHealth(BusState.OFF, sent=3, error_frames=9), Grade.PROBLEM, "bit rate"),
        (BusHealth(BusState.WARNING, last_trouble="it says so"), Grade.NOTE, "60 ohm"),
        (BusHealth(sent=3), Grade.OK, ""),
    ],
)
def test_the_state_of_an_adapter_is_a_finding(health, grade, fix):
    (found,) = can_findings.of_health(health)
    assert found.grade is grade
    assert fix in found.fix


def test_answers_that_get_lost_point_to_the_wiring():
    on = bus_bench()
    on.twin.faults.add("drop", 0.2, seed=5)
    found = on.survey((1, 2, 3))
    assert found.nodes
    missed = sum(each.missed for each in found.nodes)
    told = words(mks.of_answers(found, BusHealth(error_frames=2)))
    assert f"problem {counted(missed, 'answer')} came only after a second question" in told
    late = Survey(nodes=(replace(found.nodes[0], missed=1),))
    told = words(mks.of_answers(late, BusHealth()))
    assert "note 1 answer came only after a second question, 0 frames were unreadable" in told
    assert "busy computer" in told
    assert "120" in told
    told = words(mks.of_answers(replace(late, garbled=1), BusHealth(error_frames=1)))
    assert "1 frame was unreadable, 1 error frame was seen" in told


def test_bus_load_is_reported_and_other_masters_are_named():
    on = bus_bench()
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


MANY = "9" * 5000


@every_row("text", ["0", "x", "1-", "1-3000", "", "3-1", f"1-{MANY}", "1-99999999999"])
def test_ids_are_read_or_refused(text):
    with pytest.raises(BadRequest):
        ids_of(text)
    assert ids_of("1-3, 20") == (1, 2, 3, 20)
