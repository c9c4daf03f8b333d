"""The collaborators of a GRBL controller, each tested alone against a scripted board."""

import math

import pytest
from grbl_arm import PIECES, config

from armdrive.dialects.controller import ScriptRunner, StopPart
from armdrive.dialects.grbl.board import BoardState
from armdrive.dialects.grbl.exchange import SPOILER, GrblExchange
from armdrive.dialects.grbl.planner import Limits, MotionBounds, SegmentBuffer
from armdrive.dialects.grbl.settings import BoardAxes
from armdrive.dialects.grbl.stops import GrblOutputs, GrblStops
from armdrive.errors import Refused
from armdrive.tasks import Alert, AlertKind, Done, ProtocolWarning, Registers, RequestRejected
from firmware_protocol.grbl import Dialect, Host, Line, State, Variant
from kinematics import Motors

BANNER = "Grbl 1.1f ['$' for help]"
IDLE = "<Idle|MPos:1.000,2.000,3.000,4.000,5.000,6.000|Bf:15,128>"
HERE = Motors((1, 2, 3, 4, 5, 6))
LIMITS = Limits((1.0,) * 6, (400.0,) * 6, (4000.0,) * 6, 1.0)


class Parts(ScriptRunner):
    """The collaborators, and a controller that runs their scripts: a request is a script."""

    def __init__(self, gripper="stepper", **device):
        made = config(device=device)
        self.settings, axes = made.device, BoardAxes.of(made)
        host = Host(
            Dialect(axes=axes.board(), ring_bytes=None, outputs=True, single_axis_homing=True)
        )
        super().__init__(None, host)
        self.board = BoardState(host, self.settings, axes)
        self.exchange = GrblExchange(self.io, host, self.board, self.settings, 1e-4)
        self.outputs = GrblOutputs(self.exchange, self.settings, gripper)
        self.stops = GrblStops(self.io, self.exchange, self.board, self.outputs, self.settings)
        self.sent = []

    def script(self, request):
        return request

    def unsolicited(self, heard):
        self.exchange.take(heard)

    usable_rate_hz = duration_s = stopping = None  # not called: no test requests a motion

    def hear_line(self, *lines, at_s=0.0):
        """Receive lines that no script waits for; return the events for the engine."""
        for line in lines:
            self.receive(line.encode() + b"\r\n", at_s)
        return [*iter(self.next_event, None)]

    def run(self, script, plays):
        """Run a script to its end; `plays` gives the board's answers to each piece."""
        now_s = self.io.now_s
        self.begin(script, now_s)
        while self.busy:
            for piece in PIECES.findall(self.advance(now_s)):
                self.sent.append(piece)
                for line in plays(piece):
                    self.receive(line.encode() + b"\r\n", now_s)
            assert now_s < 100.0
            now_s = max(now_s, min(self.next_s(), now_s + 0.01))
        return [*iter(self.next_event, None)][-1]


def standing(piece):
    """Play a board at rest that executes every line except the one it must refuse."""
    if piece == b"?":
        return [IDLE]
    if piece == b"\x18":
        return [BANNER]
    if piece.endswith(b"\n"):
        return ["error:1" if piece == SPOILER.encode() + b"\n" else "ok"]
    return []


# The known state of a board.


def test_a_report_tells_state_position_and_inputs():
    parts = Parts(axes="CBAZYX")
    assert parts.hear_line(IDLE.replace(">", "|Pn:PX>")) == []
    assert parts.board.state is State.IDLE
    assert parts.board.registers() == Registers(Motors((6, 5, 4, 3, 2, 1)), 0b100001)
    assert parts.board.located


def test_a_board_stands_when_it_is_idle_and_its_planner_is_as_empty_as_it_ever_was():
    parts = Parts()
    parts.hear_line(IDLE, IDLE)
    assert parts.board.standing
    parts.hear_line(IDLE.replace("Bf:15", "Bf:13"))
    assert parts.board.planner_holds() == 2
    assert not parts.board.standing
    parts.hear_line(IDLE.replace("Bf:15", "Bf:77"), IDLE)  # reported once, so not believed
    assert parts.board.standing


def test_an_alarm_is_told_once_contact_is_made_and_says_whether_the_position_is_kept():
    parts = Parts()
    assert parts.hear_line("ALARM:1") == []
    assert parts.board.state is State.ALARM
    parts.board.contacted = True
    (lost,) = parts.hear_line("ALARM:1")
    (kept,) = parts.hear_line("ALARM:2")
    assert (lost.kind, kept.kind) == (AlertKind.ALARM_LOST, AlertKind.ALARM)
    assert "alarm 2" in kept.text
    parts.hear_line(IDLE)
    assert parts.board.alarm is None


def test_a_greeting_that_was_not_awaited_is_a_restart_that_forgets_modes_and_line():
    parts = Parts()
    board = parts.board
    board.contacted = board.modes_set = board.polls.stray = True
    (alert,) = parts.hear_line(BANNER)
    assert isinstance(alert, Alert)
    assert alert.kind is AlertKind.RESTARTED
    assert board.aborted
    assert not board.modes_set
    assert not board.polls.stray


@pytest.mark.parametrize(("after_s", "own"), [(0.05, True), (0.39, True), (0.41, False)])
def test_a_greeting_that_comes_late_is_not_that_of_our_own_reset(after_s, own):
    parts = Parts()
    parts.board.contacted = True
    parts.board.greeting.await_soon(1.0, math.inf)
    assert bool(parts.hear_line(BANNER, at_s=1.0 + after_s)) is not own
    assert parts.board.aborted is not own


@pytest.mark.parametrize(
    ("told", "blocks", "ring"), [("V,35,254", 15, 254), ("V,9,128", 9, 128), ("V,15,12", 15, None)]
)
def test_a_build_tells_how_many_lines_and_bytes_are_taken(told, blocks, ring):
    parts = Parts()
    parts.hear_line(f"[OPT:{told}]")
    assert parts.board.blocks == blocks
    assert parts.exchange.host.ring_bytes == ring


def test_axes_are_counted_in_a_report_until_contact_is_made():
    parts = Parts()
    (warning,) = parts.hear_line("<Idle|MPos:0.000,0.000,0.000|Bf:15,128>")
    assert isinstance(warning, ProtocolWarning)
    assert parts.board.letters == "XYZ"
    assert parts.board.lacking == "ABC"
    parts.hear_line("[AXS:6:XYZABC]")
    assert not parts.board.lacking
    parts.board.contacted = True
    parts.hear_line("<Idle|MPos:0.000,0.000,0.000|Bf:15,128>")
    assert not parts.board.lacking


def test_a_poll_before_which_one_was_unanswered_may_have_left_a_character():
    parts = Parts()
    parts.board.polls.ask(1.0)
    assert not parts.board.polls.stray
    parts.board.polls.ask(1.2)
    assert parts.board.polls.stray
    assert parts.board.polls.since_s == 1.0
    parts.hear_line(IDLE, at_s=1.3)
    assert parts.board.polls.since_s == math.inf
    assert parts.board.polls.stray  # it may still be in the board's input line


def test_the_segment_buffer_is_the_largest_until_the_firmware_is_known():
    board = Parts().board
    assert board.segment_buffer == SegmentBuffer(12)
    board.recognised = True
    assert board.variant is Variant.GRBL
    assert board.segment_buffer == SegmentBuffer(9)


# Queries and answers.


def test_a_line_is_carried_out_refused_or_answered_by_nothing():
    parts = Parts()
    assert parts.run(parts.exchange.carry_out(Line("M8"), 1.0), standing) == Done()
    refused = parts.run(parts.exchange.carry_out(Line("M8"), 1.0), lambda _: ["error:9"])
    assert isinstance(refused, RequestRejected)
    assert "error 9" in refused.reason
    silent = parts.run(parts.exchange.carry_out(Line("M8"), 1.0), lambda _: [])
    assert "did not answer" in silent.reason


def test_the_line_after_a_silence_is_said_behind_one_that_has_to_be_refused():
    parts = Parts()
    parts.run(parts.exchange.carry_out(Line("M8"), 1.0), lambda _: [])
    parts.sent.clear()
    parts.run(parts.exchange.carry_out(Line("M9"), 1.0), standing)
    assert parts.sent == [b"))GG\n", b"M9\n"]
    assert not parts.board.polls.stray


# Stops, and the outputs that a reset switches off.


@pytest.mark.parametrize(("closes", "said"), [(True, b"M8\n"), (False, b"M9\n")])
def test_a_gripper_on_an_output_closes_as_it_is_wired(closes, said):
    parts = Parts(gripper="output", gripper_closes=closes)
    parts.run(parts.outputs.set_gripper(0.0), standing)
    assert parts.sent[-1] == said


def test_what_no_output_or_gripper_can_do_is_refused_before_anything_is_sent():
    outputs = Parts().outputs
    outputs.check(1)
    with pytest.raises(Refused, match="1 output, 2 needs more"):
        outputs.check(2)
    with pytest.raises(Refused, match="driven by a motor"):
        outputs.check_gripper()
    Parts(gripper="servo").outputs.check_gripper()


# How long motion continues.


def bounds(segments=9, most_hz=(300.0,) * 6):
    return MotionBounds(LIMITS, most_hz, SegmentBuffer(segments), 1e-4)


def test_a_motor_brakes_from_what_its_arm_its_board_and_its_motion_ask_of_it_at_most():
    assert bounds().ramp_s() == pytest.approx(300.0 / 4000.0)
    assert bounds(most_hz=(500.0,) * 6).ramp_s() == pytest.approx(400.0 / 4000.0)
    assert bounds().ramp_s([StopPart(1.0, 100.0)]) == pytest.approx(100.0 / 4000.0)


def test_a_stop_waits_for_what_the_segment_buffer_holds():
    small, large = (bounds(segments).stopping(0.4) for segments in (5, 12))
    assert large.asked_s - small.asked_s == pytest.approx(
        SegmentBuffer(12).longest_s - SegmentBuffer(5).longest_s
    )
    quick = bounds().stopping(0.4, [StopPart(1.0, 300.0)])
    slow = bounds().stopping(0.4, [StopPart(1.0, 40.0)])
    assert quick.asked_s < slow.asked_s <= bounds().stopping(0.4).asked_s


def test_a_rate_is_neither_faster_nor_slower_than_the_board_can():
    assert bounds().usable_rate_hz(math.inf) == 400.0
    assert bounds().usable_rate_hz(0.0) == pytest.approx(30.5, abs=0.1)
    assert bounds().usable_rate_hz(100.0) == 100.0
    assert bounds().duration_s(200.0, 200.0) == pytest.approx(1.0 + 200.0 / 4000.0)
