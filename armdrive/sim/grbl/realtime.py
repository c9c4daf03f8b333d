"""Real-time commands of a simulated GRBL board, its alarms, and how it starts anew.

Source: gnea/grbl grbl/protocol.c (protocol_exec_rt_system), motion_control.c (mc_reset), main.c.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

from armdrive.sim.grbl.board import Boot, GrblBoard
from armdrive.sim.grbl.firmware import HOMING, IDLE_MS, Killed
from armdrive.sim.grbl.lines import run_startup
from firmware_protocol.grbl import Alarm, Feedback, Realtime, State

_OVERRIDE_BOUNDS = (10, 200)
_ABORTED, _HOMING_ABORTED = 3, 6
_FLOOD_STATES = (State.IDLE, State.RUN, State.HOLD, State.JOG)


def obey(board: GrblBoard, command: Realtime) -> None:
    """Do at once what a real-time command says; in a limit alarm only a reset is heard."""
    if board.critical and command not in (Realtime.SOFT_RESET, *_STATUS):
        return
    order = _ORDERS.get(command)
    if order is not None:
        order(board)
        return
    if command in _STEPS:
        _override(board, *_STEPS[command])


def hold(board: GrblBoard) -> None:
    """Slow down and stand: of a jog it is the end, of a motion a pause; in Idle a pause too."""
    if board.state is State.JOG:
        _cancel(board)
    elif board.state is State.RUN:
        board.drive.brake(board.now_s)
        board.state, board.stands = State.HOLD, False
    elif board.state is State.IDLE:
        board.state, board.stands = State.HOLD, True


def resume(board: GrblBoard) -> None:
    """Go on from a pause that is complete, not before; a board that hangs reads lines again."""
    board.hung = False
    if board.state in (State.HOLD, State.DOOR) and board.stands:
        board.stands = False
        board.state = State.IDLE
        if board.drive.rack.waiting:
            board.set_going(State.RUN)


def soft_reset(board: GrblBoard) -> None:
    """Start anew; in motion the motors stop dead, and steps may be lost."""
    if board.boot.active:
        return
    _outputs_off(board)
    code = 0
    if board.state is State.HOME:
        code = _HOMING_ABORTED
    elif board.drive.moving:
        code = _ABORTED
        _lose_current(board, anew=True)
    board.kill()
    board.boot.begin(_started_anew(board, code), board.now_s)


def raise_critical(board: GrblBoard, code: int) -> None:
    """Lock the board by a limit alarm: a motion under way stops dead, and the motors go off."""
    _outputs_off(board)
    if board.drive.moving:
        board.kill()
        _lose_current(board, anew=False)
    board.state, board.critical = State.ALARM, True
    board.say(Alarm(code))
    board.say(Feedback("Reset to continue"))


def fail(board: GrblBoard, code: int) -> None:
    """Raise an alarm of homing, after which the board starts anew; the motors stay on."""
    board.kill()
    board.boot.begin(_started_anew(board, code), board.now_s)


def switched_on(board: GrblBoard, wait_s: float) -> Boot:
    """Start from nothing: the counts are at zero, whatever the truth; with homing it is locked."""
    yield board.now_s + wait_s
    board.state = State.ALARM if board.settings.on(HOMING) else State.IDLE
    board.drive.set_axes((0,) * len(board.axes), board.now_s)
    _start(board)


def _started_anew(board: GrblBoard, code: int) -> Boot:
    if board.state is State.SLEEP and board.firmware.killed is Killed.LATE:
        yield board.now_s + board.settings[IDLE_MS] / 1000  # seen: 0.26 s at $1=255
    if code:
        if code == _ABORTED and board.firmware.killed is Killed.LATE:
            yield board.now_s + board.settings[IDLE_MS] / 1000
        board.state = State.ALARM
        board.say(Alarm(code))
        yield board.now_s + board.firmware.alarm_s
    board.drop_line()
    yield board.now_s + board.firmware.start_s
    _start(board)


def _lose_current(board: GrblBoard, *, anew: bool) -> None:
    """Let go of motors that were killed; `anew` where the board starts anew by itself."""
    if board.firmware.killed is Killed.AT_ONCE:
        board.idle_off_s = board.now_s
    elif not anew or board.firmware.killed is Killed.LATE:
        board.let_motors_go()


def _outputs_off(board: GrblBoard) -> None:
    board.outputs.off()
    board.outputs_changed()


def _start(board: GrblBoard) -> None:
    locked = board.state in (State.ALARM, State.SLEEP)
    board.state = State.ALARM if locked else State.IDLE
    board.critical = board.stands = board.cancelling = board.leaving = False
    board.hangs = board.hung = False
    board.overrides[:] = 100, 100, 100
    board.ring.clear()
    board.codec.discard()
    board.drive.stop(board.now_s)
    board.drive.rack.override(1.0, 1.0, board.now_s)
    board.drive.rack.limits = board.settings.limits()
    board.parser.restart(board.drive.units_of(board.drive.rack.goal))
    board.reporter.restart()
    if board.settings.motors_stay_on:
        board.drive.energise()
        board.idle_off_s = math.inf
    else:
        board.let_motors_go()
    board.limits.forget(board)
    board.say(board.firmware.banner)
    if locked:
        board.say(Feedback("'$H'|'$X' to unlock"))
    else:
        run_startup(board)


def _cancel(board: GrblBoard) -> None:
    """Slow down and give up what the planner holds; what is not read yet runs on."""
    if not board.cancelling:
        board.cancelling = True
        board.cancels += 1
        board.drive.brake(board.now_s)


def _jog_cancel(board: GrblBoard) -> None:
    if board.state is not State.JOG:
        return
    if board.firmware.cancel_clears_ring:
        board.ring.clear()
    if board.drive.done_s - board.now_s < board.firmware.cancel_hangs_s:
        board.hangs = True
    else:
        _cancel(board)


def _stop(board: GrblBoard) -> None:
    """Give up everything without an alarm (grblHAL)."""
    board.ring.clear()
    if board.state in (State.RUN, State.JOG):
        _cancel(board)


def _door(board: GrblBoard) -> None:
    board.say(Feedback("Check Door"))
    board.reporter.overrides_changed()
    hold(board)
    if board.state is State.HOLD:
        board.state = State.DOOR


def _ask(board: GrblBoard) -> None:
    board.reporter.asked = True


def _flood(board: GrblBoard) -> None:
    if board.state in _FLOOD_STATES:
        board.outputs.flood = not board.outputs.flood
        board.outputs_changed()


def _override(board: GrblBoard, which: int, value: int, relative: bool) -> None:
    low, high = _OVERRIDE_BOUNDS
    before = board.overrides[which]
    board.overrides[which] = min(max(before + value, low), high) if relative else value
    if board.overrides[which] != before:
        feed, rapid, _ = board.overrides
        board.drive.follow(board.now_s)
        board.drive.rack.override(feed / 100, rapid / 100, board.now_s)
        board.reporter.overrides_changed()


_STATUS = (Realtime.STATUS, Realtime.STATUS_ALIAS, Realtime.FULL_STATUS)

_ORDERS: Mapping[Realtime, Callable[[GrblBoard], None]] = MappingProxyType(
    {
        **dict.fromkeys(_STATUS, _ask),
        Realtime.SOFT_RESET: soft_reset,
        Realtime.STOP: _stop,
        Realtime.FEED_HOLD: hold,
        Realtime.FEED_HOLD_ALIAS: hold,
        Realtime.RESUME: resume,
        Realtime.RESUME_ALIAS: resume,
        Realtime.SAFETY_DOOR: _door,
        Realtime.JOG_CANCEL: _jog_cancel,
        Realtime.FLOOD_TOGGLE: _flood,
    }
)

_FEED, _RAPID, _SPINDLE = 0, 1, 2
_STEPS: Mapping[Realtime, tuple[int, int, bool]] = MappingProxyType(
    {
        Realtime.FEED_100: (_FEED, 100, False),
        Realtime.FEED_PLUS_10: (_FEED, 10, True),
        Realtime.FEED_MINUS_10: (_FEED, -10, True),
        Realtime.FEED_PLUS_1: (_FEED, 1, True),
        Realtime.FEED_MINUS_1: (_FEED, -1, True),
        Realtime.RAPID_100: (_RAPID, 100, False),
        Realtime.RAPID_50: (_RAPID, 50, False),
        Realtime.RAPID_25: (_RAPID, 25, False),
        Realtime.SPINDLE_100: (_SPINDLE, 100, False),
        Realtime.SPINDLE_PLUS_10: (_SPINDLE, 10, True),
        Realtime.SPINDLE_MINUS_10: (_SPINDLE, -10, True),
        Realtime.SPINDLE_PLUS_1: (_SPINDLE, 1, True),
        Realtime.SPINDLE_MINUS_1: (_SPINDLE, -1, True),
    }
)
"""Which override, by how much, and whether that is added to what it was."""
