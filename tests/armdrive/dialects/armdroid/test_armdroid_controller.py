"""Driving an Armdroid: what is said to the board, and what becomes of whatever goes wrong."""

import math

import pytest
from amounts import amount
from faults import arm_config, driven, honest

from armdrive import Arm, DeviceFault, Refused
from armdrive.abilities import Switching
from armdrive.connect.parts import connect_simulated
from armdrive.connect.target import simulated_config
from armdrive.dialects.armdroid.controller import NEW_SESSION, ArmdroidController
from armdrive.dialects.exchange import TRIES
from armdrive.registry import dialect, simulate
from armdrive.status import State, Trust
from armdrive.storage.record import RecordFile
from armdrive.tasks import (
    Alert,
    AlertKind,
    ClearFault,
    DeviceSettings,
    Done,
    DropCurrent,
    Halted,
    MoveBy,
    ProtocolWarning,
    ReadPosition,
    ReadSettings,
    Registers,
    RequestRejected,
    SwitchOn,
    Timeout,
)
from kinematics import Motors

CONFIG = simulated_config("armdroid")
VERSION = "firmware version = 2.0/protocol = 1.0a"
STEPS = Motors((12, -3, 0, 0, 0, 7))
NUMBERS = "7,0,0,0,3-,12"
ECHO = "debug = 7 0 0 0 -3 12"
DRIVEN = "offsets = 7,0,0,0,-3,12"
ZERO = "offsets = 0,0,0,0,0,0"


class Talked:
    """A controller whose board is played by the test, a line at a time."""

    def __init__(self, **settings):
        config = arm_config("armdroid", device=settings)
        self.controller = ArmdroidController(dialect("armdroid").abilities, config)
        self.now_s = 0.0

    def begin(self, request):
        self.controller.begin(request, self.now_s)
        return self.said()

    def said(self):
        return self.controller.advance(self.now_s).decode("ascii")

    def answer(self, line, after_s=0.1):
        self.now_s += after_s
        self.controller.receive(line.encode("ascii") + b"\r\n", self.now_s)
        return self.said()

    def silence(self, seconds=10.0):
        said = ""
        for _ in range(int(seconds / 0.1)):
            self.now_s += 0.1
            said += self.said()
        return said

    @property
    def event(self):
        return self.controller.next_event()

    def met(self):
        """Get to know the board, as connecting does."""
        assert self.begin(ReadPosition()) == "v"
        assert self.answer(VERSION) == "25s"
        assert self.answer("speed = 25") == "d"
        assert self.answer(ZERO) == ""
        assert isinstance(self.event, Registers)
        return self

    def loaded(self):
        """Get to where the board has repeated the numbers of a motion."""
        assert self.begin(MoveBy(STEPS, 100.0)) == "125s"
        assert self.answer("speed = 125") == NUMBERS + "g"
        assert self.answer(ECHO) == "D"
        return self


MOVE = MoveBy(STEPS, 100.0)
SETTLED = [(VERSION, "25s"), ("speed = 25", "d")]
LOADED = [("speed = 125", NUMBERS + "g"), (ECHO, "D")]
CONVERSATIONS = {
    "numbers are repeated before the letter, and the speed is set only once": (
        {}, [(MOVE, "125s"), *LOADED, (DRIVEN, "", 0.2), Done(), (MOVE, NUMBERS + "g")]
    ),
    "numbers that were misunderstood are taken back and said again": (
        {}, [(MOVE, "125s"), ("speed = 125", NUMBERS + "g"), ("debug = 7 0 0 0 -312 0", "v"),
             *SETTLED, (ZERO, "125s"), *LOADED]
    ),
    "other offsets than asked are no end of a motion": (
        {}, [(MOVE, "125s"), *LOADED, (ZERO, ""), None, (DRIVEN, ""), Done()]
    ),
    "a speed that was misunderstood is set again": (
        {}, [(MOVE, "125s"), ("speed = 7125", "v")]
    ),
    "a doubled letter that set the speed to 0 is noticed before the motion begins": (
        {}, [(MOVE, "125s"), ("speed = 125", NUMBERS + "g"), ("speed = 0", ""),
             ProtocolWarning("stray: answer speed reported: rpm 0"), (ECHO, "v")]
    ),
    "an answer far too early is not timely": (
        {}, [(MoveBy(Motors((200, 0, 0, 0, 0, 0)), 100.0), "125s"),
             ("speed = 125", "0,0,0,0,0,200g"), ("debug = 0 0 0 0 0 200", "D"),
             ("offsets = 0,0,0,0,0,200", ""), Done(timely=False)]
    ),
    "the second look leaves nothing to repeat, and the third only asks": (
        {}, [(ReadPosition(), ",,,,,d"), ("offsets = 1,2,3,4,5,6", ""),
             Registers(Motors((6, 5, 4, 3, 2, 1))), (ReadPosition(), "o")]
    ),
    "the current is switched both ways and sure of it": (
        {}, [(SwitchOn(), "1t"), ("torque = enabled", ",,,,,d"), (ZERO, ""), Done(),
             (DropCurrent(), "0t"), ("torque = enabled", "v")]
    ),
    "older firmware switches no current": (
        {"switches_torque": False}, [(SwitchOn(), ""), Done()]
    ),
    "a greeting means that speed and offsets are lost": (
        {}, [(ReadPosition(), ",,,,,d"), (ZERO, ""), Registers(Motors((0,) * 6)),
             ("Welcome, Armdroid!", ""), Alert(AlertKind.RESTARTED, NEW_SESSION), (MOVE, ",,,,,d")]
    ),
    "it tells its version as its settings": (
        {}, [(ReadSettings(), ""), DeviceSettings(firmware="2.0")]
    ),
}  # fmt: skip
"""What is asked of the controller or said by the board, and what is sent then; and the events."""


class TestConversation:
    @pytest.mark.parametrize(("settings", "told"), CONVERSATIONS.values(), ids=CONVERSATIONS)
    def test_a_conversation(self, settings, told):
        talked = Talked(**settings).met()
        for each in told:
            match each:
                case (str() as line, sent, *after_s):
                    assert talked.answer(line, *after_s) == sent
                case (request, sent):
                    assert talked.begin(request) == sent
                case event:
                    assert talked.event == event

    @pytest.mark.parametrize("unanswered", ["", "v", "25s"])
    def test_a_board_that_never_understands_is_refused_and_has_moved_nothing(self, unanswered):
        talked = Talked().met()
        talked.begin(MOVE)
        said, heard = talked.answer("speed = 125"), ""
        answers = {"g": "debug = 0 0 0 0 0 1", "v": VERSION, "d": ZERO}
        while said not in ("", unanswered):
            heard += said
            said = talked.answer(answers.get(said[-1], f"speed = {said[:-1]}"))
        assert set(talked.silence()) <= {"v"}
        assert "D" not in heard
        assert heard.count("g") == (1 if unanswered else TRIES)
        reply = talked.event
        assert isinstance(reply, RequestRejected)
        assert not reply.moved

    def test_a_stop_before_the_letter_lets_nothing_begin(self):
        talked = Talked().met()
        talked.begin(MoveBy(STEPS, 100.0))
        assert talked.answer("speed = 125") == NUMBERS + "g"
        talked.controller.stop(hard=False)
        assert talked.answer(ECHO) == ""
        assert talked.event == Halted()
        assert talked.begin(ReadPosition()) == "v"

    def test_a_jog_that_was_let_go_before_the_letter_does_not_begin(self):
        talked = Talked().met()
        held = [True]
        talked.begin(MoveBy(STEPS, 100.0, lambda: not held))
        assert talked.answer("speed = 125") == NUMBERS + "g"
        held.clear()
        assert talked.answer(ECHO) == ""
        assert talked.event == Halted()

    def test_lasting_wrong_offsets_are_reported(self):
        talked = Talked().met().loaded()
        talked.answer("offsets = 7,0,0,0,-3,112", 0.2)
        talked.silence()
        reply = talked.event
        assert isinstance(reply, RequestRejected)
        assert reply.moved
        assert "112" in reply.reason
        assert talked.begin(ClearFault()) == "v"

    def test_a_lost_end_is_a_silence_and_the_motion_is_never_sent_again(self):
        talked = Talked().met().loaded()
        assert talked.silence() == ""
        reply = talked.event
        assert isinstance(reply, Timeout)
        assert reply.to == NUMBERS + "D"
        assert talked.begin(MOVE) == "v"
        talked.silence()
        assert talked.event == RequestRejected("it does not answer as it should", moved=False)

    def test_an_abandoned_command_may_have_left_something_in_the_board(self):
        talked = Talked().met()
        assert talked.begin(ReadPosition()) == ",,,,,d"
        talked.controller.abandon()
        assert talked.begin(ReadPosition()) == "v"

    @pytest.mark.parametrize("deaf", [False, True])
    def test_a_board_that_misses_the_first_question_may_have_been_reset(self, deaf):
        talked = Talked()
        talked.begin(ReadPosition())
        assert not deaf or talked.silence(1.0) == "v"
        talked.answer(VERSION)
        assert talked.controller.opening_reset is deaf

    def test_a_board_that_took_the_word_on_for_off_has_let_the_arm_sag(self):
        talked = Talked().met()
        assert talked.begin(SwitchOn()) == "1t"
        assert talked.answer("torque = disabled") == "v"
        alert = talked.event
        assert isinstance(alert, Alert)
        assert alert.kind is AlertKind.SWITCHED_OFF

    def test_older_firmware_says_that_it_switches_no_current(self):
        talked = Talked(switches_torque=False).met()
        assert talked.controller.abilities.current is Switching.NONE
        with pytest.raises(Refused, match="DropCurrent"):
            talked.begin(DropCurrent())

    def test_a_welcome_at_first_is_no_restart(self):
        talked = Talked()
        talked.begin(ReadPosition())
        talked.answer("Welcome, Armdroid!")
        assert isinstance(talked.event, ProtocolWarning)
        talked.answer(VERSION)
        talked.answer("speed = 25")
        talked.answer(ZERO)
        assert isinstance(talked.event, Registers)

    def test_an_answer_after_a_suspension_of_this_program_says_nothing_of_the_motors(self):
        talked = Talked().met().loaded()
        assumed_s = talked.controller.duration_s(100, 100.0)
        talked.answer(DRIVEN, 60.0)
        assert talked.event == Done(timely=False)
        assert talked.controller.duration_s(100, 100.0) == assumed_s

    def test_speeds_are_those_of_whole_milliseconds(self):
        controller = Talked().controller
        assert controller.usable_rate_hz(math.inf) == 200.0
        assert controller.usable_rate_hz(99.0) == pytest.approx(1000 / 12)
        assert controller.usable_rate_hz(0.0) == 20.0
        assert controller.stopping(0.15).silent_s < 0.20


BYTES = [*(("host", byte) for byte in (*range(1, 40), 52, 63, 77, 90)),
         *(("device", byte) for byte in range(1, 60, 4))]  # fmt: skip


@pytest.mark.parametrize(
    ("fault", "side", "byte"),
    [
        (fault, *each)
        for first, fault in enumerate(["drop", "corrupt", "duplicate"])
        for each in BYTES[first % amount(3, 1) :: amount(3, 1)]
    ],
)
def test_no_byte_that_goes_wrong_makes_a_motion_of_another_size_or_a_deaf_board(fault, side, byte):
    arm = driven(CONFIG)
    start = arm.twin.world.motors
    arm.twin.faults.add(fault, f"#{byte}", side=side)
    try:
        arm.move_j(base_deg=4, wrist_pitch_deg=-42)
    except DeviceFault:
        assert arm.status.state is State.ERROR_STOP
        assert honest(arm)
        arm.reset()
        arm.reference.declare(arm.twin.world.joints, opening_mm=arm.twin.world.opening_mm)
    assert (arm.twin.world.motors - start).largest <= 80
    assert honest(arm)
    arm.move_j(base_deg=2)
    assert arm.twin.world.joints.deg["base"] == pytest.approx(2.0, abs=0.1)
    assert honest(arm)


def test_a_board_that_says_that_its_motors_are_off_is_believed():
    arm = driven(CONFIG)
    arm.twin.link.line.send(b"0t", arm.parts.pace.now_s())  # as a garbled line may read
    arm.sleep(0.5)
    assert not arm.twin.world.energised
    assert arm.status.trust is Trust.SUSPECT


def test_a_doubled_letter_that_switches_the_motors_off_again_is_noticed_at_once():
    """Mission armdroid 745000362: the position was trusted although the arm sagged."""
    arm = Arm(connect_simulated(CONFIG))
    arm.twin.faults.add("duplicate", "#2", side="host")
    with pytest.raises(DeviceFault, match="motors off"):
        arm.enable()
    assert not arm.twin.world.energised
    assert arm.status.state is State.ERROR_STOP
    assert honest(arm)
    arm.reset()
    arm.enable()
    assert arm.twin.world.energised


def test_a_welcome_between_two_bursts_ends_a_motion():
    arm = driven(CONFIG)
    arm.move_j(base_deg=20, wait=False)
    arm.sleep(0.6)
    arm.twin.board.outgoing += b"Welcome, Armdroid!\r\n"
    arm.sleep(4.0)
    assert arm.status.state is State.ERROR_STOP
    assert "sent its greeting" in arm.status.error
    assert arm.twin.world.joints.deg["base"] < 15.0
    assert honest(arm)


def test_digits_that_another_program_left_are_no_part_of_a_motion():
    twin = simulate(CONFIG)
    twin.link.write(b"7,7,7,7,7,777", 0.0)
    twin.link.read(1.0)
    before = twin.world.motors
    arm = Arm(connect_simulated(CONFIG, twin=twin))
    arm.enable()
    assert twin.world.motors == before
    arm.move_motors(10, 0, 0, 0, 0, -3)
    assert tuple(twin.world.motors - before) == (10, 0, 0, 0, 0, -3)


# An arm that lets its motors go as it is switched on: a number was lost before the letter.

TURNED = (40, 30, -20, 5, 9, 12)


@pytest.fixture
def left(tmp_path):
    """A twin on which a program has ended well, and the record that it left."""
    twin = simulate(CONFIG)
    recorder = RecordFile(tmp_path / "record.json")
    twin.device.jog(TURNED)
    with Arm(connect_simulated(CONFIG, twin=twin, record_store=recorder)) as arm:
        arm.reference.declare(twin.world.joints, opening_mm=twin.world.opening_mm)
    twin.link.reopen()
    return twin, recorder


def test_motors_reported_off_while_connecting_make_the_record_untrusted(left):
    twin, recorder = left
    before = twin.world.motors
    twin.link.line.send(b"t", twin.device.now_s)  # the 1 before it was lost with a program
    arm = Arm(connect_simulated(CONFIG, twin=twin, record_store=recorder, allow_restored=True))
    assert twin.world.motors != before
    assert arm.status.trust is Trust.SUSPECT
    assert "motors off" in arm.status.trust_reason
    assert arm.status.state is State.DISABLED
    assert arm.status.error == ""
    arm.close()
    twin.link.reopen()
    again = Arm(connect_simulated(CONFIG, twin=twin, record_store=recorder))
    assert again.status.trust is Trust.SUSPECT


def test_motors_reported_off_before_the_first_request_make_the_record_untrusted(left, monkeypatch):
    twin, recorder = left
    parts, read = iter([b"torque = disabled\r\n"]), twin.link.read
    monkeypatch.setattr(twin.link, "read", lambda now_s: next(parts, b"") + read(now_s))
    arm = Arm(connect_simulated(CONFIG, twin=twin, record_store=recorder, allow_restored=True))
    assert arm.status.trust is Trust.SUSPECT
    assert "motors off" in arm.status.trust_reason


def test_an_arm_that_sagged_as_it_was_switched_on_is_not_believed(left):
    twin, recorder = left
    arm = Arm(connect_simulated(CONFIG, twin=twin, record_store=recorder, allow_restored=True))
    assert arm.status.trust is Trust.RESTORED
    before = twin.world.motors
    twin.faults.add("drop", "#1", side="host")
    with pytest.raises(DeviceFault, match="motors off"):
        arm.enable()
    assert twin.world.motors != before
    assert arm.status.trust is Trust.SUSPECT
    arm.reset()
    arm.enable()
    assert arm.status.state is State.STANDBY
