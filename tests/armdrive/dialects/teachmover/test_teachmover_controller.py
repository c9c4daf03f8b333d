"""A TeachMover driven through its controller: what it learns of the arm's speed."""

from __future__ import annotations

import pytest
from driver_bench import SerialBench

from armdrive.registry import DIALECTS
from armdrive.registry.arm_files import parse_arm
from armdrive.sim.device import SimDevice
from armdrive.sim.teachmover import TeachMoverBoard, TeachMoverQuirks
from armdrive.tasks import (
    Done,
    Interrupted,
    MoveBy,
    ReadPosition,
    ReadProgram,
    Registers,
    RequestRejected,
)
from firmware_protocol.teachmover import Key
from kinematics import Motors

ROW = b"1,3841,14436,28716,43252,65280,65025,64769\r"
MOVE = MoveBy(Motors((200, 0, 0, 0, 0, 0)), 100.0)
SLOWER = 0.6


class TeachMoverBench(SerialBench):
    """A controller on the wire of an arm that is slower than its table says."""

    def __init__(self) -> None:
        table = {"model": "teachmover", "connection": {"dialect": "teachmover"}}
        controller = DIALECTS["teachmover"].controller(parse_arm(table, name="bench"))
        self.board = TeachMoverBoard(quirks=TeachMoverQuirks(speed_error=SLOWER))
        super().__init__(controller, SimDevice(self.board))

    @property
    def assumed_s(self) -> float:
        """How long the controller expects the motion to take at most."""
        return self.controller.duration_s(200, 100.0)


def test_a_motion_shows_how_slow_the_arm_is():
    bench = TeachMoverBench()
    unmeasured_s = bench.assumed_s
    assert bench.do(MOVE) == Done()
    assert bench.assumed_s == pytest.approx(unmeasured_s / 2.0 * (1.0 + SLOWER), rel=0.01)


def test_a_suspension_of_this_program_does_not_make_the_arm_seem_slow():
    bench = TeachMoverBench()
    unmeasured_s = bench.assumed_s
    bench.begin(MOVE)
    bench.run(0.2)
    bench.now_s += 60.0
    assert bench.finish() == Done(timely=False)
    assert bench.assumed_s == unmeasured_s


@pytest.mark.parametrize("after_s", [0.3, 1.0, 2.0])
def test_a_motion_that_the_pendant_ends_early_does_not_make_the_arm_seem_fast(after_s):
    bench = TeachMoverBench()
    unmeasured_s = bench.assumed_s
    bench.at_s[after_s] = lambda: bench.board.press(Key.STOP)
    assert bench.do(MOVE) == Interrupted()
    assert bench.assumed_s == unmeasured_s


@pytest.mark.parametrize(
    ("answer", "reply"),
    [
        pytest.param(b"1\r", Done(timely=False), id="the late answer to an earlier command"),
        pytest.param(b"0\r", RequestRejected(), id="a refusal"),
    ],
)
def test_an_answer_that_comes_far_too_soon_does_not_make_the_arm_seem_fast(answer, reply):
    bench = TeachMoverBench()
    unmeasured_s = bench.assumed_s
    bench.begin(MOVE)
    bench.run(0.2)
    bench.controller.receive(answer, bench.now_s)
    assert bench.reply() == reply
    assert bench.assumed_s == unmeasured_s


@pytest.mark.parametrize(
    ("request_", "said", "words"),
    [
        (ReadProgram(), b"0\r", "the arm does not send its program"),
        (ReadProgram(), b"1\r" + ROW + b"1,2!\r" + ROW, "the arm's program cannot be read"),
        (ReadProgram(), b"1\r" + ROW + ROW[:20], "the dump ended in the middle of a line"),
        (ReadProgram(), b"", "no answer to `@QDUMP`"),
        (MOVE, b"", "no answer to `@STEP"),
    ],
)
def test_a_failed_answer_is_told_and_the_next_request_is_carried_out(request_, said, words):
    bench = TeachMoverBench()
    bench.do(ReadPosition())
    bench.run(5.0)  # longer than any pause within a dump
    bench.device.power_off()
    bench.begin(request_)
    bench.controller.receive(said, bench.now_s + 0.1)
    assert words in str(bench.finish())
    bench.device.power_on()
    assert isinstance(bench.do(ReadPosition()), Registers)
