"""Lines at work on a simulated GRBL board: g-code and jogs, from the parser to the planner.

A script here yields until when it waits, and returns the line's answer.
"""

from __future__ import annotations

import math
from collections.abc import Generator

from armdrive.sim.grbl.board import GrblBoard, Script, until_room, until_still, write_eeprom
from armdrive.sim.grbl.commands import named_path, run_path, run_system
from armdrive.sim.grbl.firmware import LEAST_SPEED, MOST_SPEED, SOFT_LIMITS, TRAVEL
from armdrive.sim.grbl.parser import MotionMode, Work
from firmware_protocol.grbl import (
    Block,
    Empty,
    Error,
    Feedback,
    GcodeError,
    LineReceived,
    Ok,
    Rejected,
    StartupEcho,
    State,
    parse_line,
)

Steps = Generator[float, None, int]
"""Part of a script; it returns 0, or the number of an error."""
LOCKED, NOT_IDLE, TRAVEL_EXCEEDED = 9, 8, 15
_TOO_LONG = 11
_CANCELLED = -1
"""A line that was planned, and taken away by a jog cancel; it is answered with ok."""


def run_line(board: GrblBoard, line: LineReceived) -> Script:
    """Carry out a line."""
    yield board.now_s + board.firmware.parse_s
    code = yield from _run(board, line)
    return Error(code) if code else Ok()


def run_startup(board: GrblBoard) -> None:
    """Carry out the lines that every start begins with; of motions there the first alone fits."""
    for text in board.startup:
        if not text:
            continue
        content = parse_line(text, board.codec.dialect)
        code = content.code if isinstance(content, Rejected) else 0
        if isinstance(content, Block):
            for _ in (steps := _Code(_block(board, content))):
                pass
            code = steps.code
        board.say(StartupEcho(text, code or None))


class _Code:
    """Iterates over a script without waiting, and keeps what it returned."""

    def __init__(self, steps: Steps) -> None:
        self.code = 0
        self._steps = steps

    def __iter__(self) -> Generator[float, None, None]:
        self.code = yield from self._steps


def _run(board: GrblBoard, line: LineReceived) -> Steps:
    content = line.content
    if isinstance(content, Empty):
        return 0
    jogging = line.text.startswith("$")
    if not jogging and board.state in (State.ALARM, State.JOG):
        too_long = isinstance(content, Rejected) and content.code == _TOO_LONG
        return _TOO_LONG if too_long else LOCKED
    if isinstance(content, Rejected):
        named = named_path(line.text) if board.firmware.has_paths else None
        return run_path(board, *named) if named else content.code
    if isinstance(content, Block):
        return (yield from _block(board, content))
    return (yield from run_system(board, content))


def _block(board: GrblBoard, block: Block) -> Steps:
    if block.jog and board.state not in (State.IDLE, State.JOG):
        return NOT_IDLE
    try:
        work = board.parser.work(block)
    except GcodeError as error:
        return error.code
    checking = board.state is State.CHECK
    if not checking:
        yield from _serve(board, work)
    for way in work.ways:
        code = yield from _move(board, way, work)
        if code:
            return max(code, 0)
    moved = work.g92 is not None or work.stores or work.new_system
    board.parser.take(work)
    if moved:
        board.reporter.offset_changed()
    if not checking:
        yield from _end(board, work)
    return 0


def _serve(board: GrblBoard, work: Work) -> Generator[float, None, None]:
    """Do what stands before the motion: outputs, a wait, and what the EEPROM keeps."""
    if work.waits:
        yield from until_still(board)
    if work.spindle:
        least, most = board.settings[LEAST_SPEED], board.settings[MOST_SPEED]
        board.outputs.spin(work.after, least, most)
    if work.coolant:
        board.outputs.cool(work.after.coolant)
    if work.output:
        board.outputs.put(*work.output)
    if work.spindle or work.coolant:
        board.reporter.overrides_changed()
    if work.spindle or work.coolant or work.output:
        board.outputs_changed()
    if work.dwell_s is not None:
        yield board.now_s + work.dwell_s
    if work.writes_eeprom:
        yield from write_eeprom(board)


def _move(board: GrblBoard, way: MotionMode, work: Work) -> Steps:
    """Queue a line as soon as there is room.

    A jog cancel finds what is planned by then, or being planned, and takes it away. A line that was
    read and not yet planned is carried out afterwards, to its target as it was reckoned before.
    """
    if board.settings.on(SOFT_LIMITS) and _outside(board, way):
        if work.jog:
            return TRAVEL_EXCEEDED
        yield from _leave(board)
    if board.state is State.CHECK:
        return 0
    yield from until_room(board)
    cancels = board.cancels
    yield board.now_s + board.firmware.plan_s
    if board.cancels > cancels:
        return _CANCELLED
    rack = board.drive.rack
    if board.state is State.IDLE:
        rack.hold(board.now_s)  # until no more lines are coming
    rate = way.rate
    if way.inverse:
        here = board.drive.units_of(rack.goal)
        rate *= math.dist(way.target, here)
    if work.jog:
        rate *= 100 / board.overrides[0]  # which a jog does not follow
    board.drive.queue_to(way.target, rate, board.now_s, rapid=way.rapid)
    if work.jog and board.state is State.IDLE and rack.waiting:
        board.set_going(State.JOG)
    return 0


def _outside(board: GrblBoard, way: MotionMode) -> bool:
    """Tell whether a target lies outside the travel, which is all on the negative side."""
    travels = board.settings.per_axis(TRAVEL)
    return any(not -far <= at <= 0 for at, far in zip(way.target, travels, strict=True))


def _leave(board: GrblBoard) -> Generator[float, None, None]:
    """Come to a stand in a controlled way, and lock; the line is never carried out."""
    if board.state is State.RUN:
        board.leaving = True
        board.drive.brake(board.now_s)
        board.state = State.HOLD
    else:
        board.alarm(2)
    while True:
        yield math.inf


def _end(board: GrblBoard, work: Work) -> Generator[float, None, None]:
    """Do what ends a program, or pauses it."""
    if work.pause:
        board.state, board.stands = State.HOLD, True
        yield math.inf
    if work.end:
        board.outputs.off()
        board.outputs_changed()
        board.say(Feedback("Pgm End"))
