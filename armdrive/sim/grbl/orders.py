"""How a simulated GRBL board handles lines and real-time commands, alarms and restarts.

The main loop (`board`) runs `run_line` for each line: g-code and jogs go to `_block`, `$` commands
to `commands`. A script here yields the time until which it waits, and returns the line's reply.
Real-time commands come to `obey`, which may interrupt a line at any such wait.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from types import MappingProxyType

from armdrive.sim.grbl.board import (
    Boot,
    FirmwareRoutines,
    GrblBoard,
    Script,
)
from armdrive.sim.grbl.commands import (
    Steps,
    Waits,
    refused_command,
    run_path,
    run_system,
)
from armdrive.sim.grbl.firmware import MINUTE_S, AlarmNumber, Killed, RefusalNumber
from armdrive.sim.mechanics.planner import SEGMENT_S
from firmware_protocol.grbl import (
    Alarm,
    Block,
    Empty,
    Error,
    GcodeError,
    Group,
    LineReceived,
    Modal,
    Ok,
    Realtime,
    Rejected,
    State,
    keys,
)

# Parsing a line, and planning a motion in addition. Observed: 0.35 ms for an empty line; the Mega
# takes 30 lines in 0.05 s, as fast as they arrive.
PARSE_S, PLAN_S = 0.35e-3, 0.85e-3
# How long a restart takes: from a soft reset, or the end of its alarm, to the banner.
RESTART_S = 5e-3
# A planned line that a jog cancel removed; it is answered with ok.
_CANCELLED = -1


def run_line(board: GrblBoard, line: LineReceived) -> Script:
    """Execute a line; one that follows a refused line may be refused without a look at it."""
    yield board.now_s + PARSE_S
    loop = board.main_loop
    gcode = line.text and not line.text.startswith("$")
    unlooked = gcode and board.firmware.refuses_on and board.state not in (State.ALARM, State.JOG)
    code = (loop.refused if unlooked else 0) or (yield from _run(board, line))
    loop.refused = code
    return Error(code) if code else Ok()


def _run(board: GrblBoard, line: LineReceived) -> Steps:
    content = line.content
    if isinstance(content, Empty):
        return 0
    jogging = line.text.startswith("$")
    if not jogging and board.state in (State.ALARM, State.JOG):
        # FluidNC looks at the length only after that: observed
        too_long = isinstance(content, Rejected) and content.code == RefusalNumber.TOO_LONG
        return RefusalNumber.TOO_LONG if too_long else RefusalNumber.LOCKED
    if isinstance(content, Rejected):
        named = run_path(board, line.text)
        return refused_command(board, line.text, content.code) if named is None else named
    if isinstance(content, Block):
        return (yield from _block(board, content))
    return (yield from run_system(board, content))


def _block(board: GrblBoard, block: Block) -> Steps:
    if block.jog and board.state not in (State.IDLE, State.JOG):
        return RefusalNumber.NOT_IDLE
    try:
        modes, after = board.modal.during(block), board.modal.after(block)
    except GcodeError as error:
        return error.code
    if not block.jog:
        yield from _serve(board, block, modes)
    if block.axes:
        target = _target(board, block, modes)
        code = yield from _move(board, target, modes, jog=block.jog)
        if code:
            return max(code, 0)
        board.position = target
    board.modal = after
    return 0


def _target(board: GrblBoard, block: Block, modes: Modal) -> tuple[float, ...]:
    """Return where a line leads, in units."""
    target = list(board.position)
    for letter, value in block.axes.items():
        axis = board.axes.index(letter)
        here = target[axis] if modes.distance == "G91" else 0.0
        target[axis] = here + value * modes.unit_mm
    return tuple(target)


def until_still(board: GrblBoard) -> Waits:
    """Wait until the queue is empty and the motors stand."""
    while board.drive.rack.waiting or board.state is State.RUN:
        board.cycle.autostart(board)
        yield math.inf


def until_room(board: GrblBoard) -> Waits:
    """Wait until the planner has room for a line; a line leaves it with its last segment."""
    while board.drive.full(board.now_s):
        board.cycle.autostart(board)
        yield board.now_s + SEGMENT_S


def _serve(board: GrblBoard, block: Block, modes: Modal) -> Waits:
    """Switch the outputs, once the motion before has ended."""
    turned = modes.spindle != "M5" and modes.speed != board.modal.speed
    spindle = modes.spindle != board.modal.spindle or turned
    output = block.commands.get(Group.OUTPUT)
    if not (spindle or output or Group.COOLANT in block.commands):
        return
    yield from until_still(board)
    if spindle:
        board.outputs.spin(modes)
    if Group.COOLANT in block.commands:
        board.outputs.cool(modes.coolant)
    if output:
        board.outputs.put(output, block.values)
    board.reporter.outputs_changed()
    board.fingers.follow_output(board.now_s)


def _move(board: GrblBoard, target: tuple[float, ...], modes: Modal, *, jog: bool) -> Steps:
    """Queue a line as soon as there is room.

    A jog cancel removes lines that are planned or being planned. A line that was read but not yet
    planned runs afterwards, to the target computed before the cancel.
    """
    yield from until_room(board)
    cancels = board.cycle.cancels
    yield board.now_s + PLAN_S
    if board.cycle.cancels > cancels:
        return _CANCELLED
    rack = board.drive.rack
    if board.state is State.IDLE:
        rack.hold(board.now_s)  # until no more lines arrive
    rate = math.inf if modes.motion == "G0" else modes.feed / MINUTE_S
    board.drive.queue_to(target, rate, board.now_s)
    if jog and board.state is State.IDLE and rack.waiting:
        board.cycle.start(board, State.JOG)
    return 0


# --- Real-time commands, alarms, and how the board restarts ---------------------------------------
#
# Source: gnea/grbl grbl/protocol.c (protocol_exec_rt_system), motion_control.c (mc_reset), main.c.


def obey(board: GrblBoard, command: Realtime) -> None:
    """Execute a real-time command at once; during a limit alarm only a reset is obeyed.

    During a restart none is, but a board that keeps a line holds afterwards if it is told to.
    """
    if board.booting.active and command is not Realtime.SOFT_RESET:
        board.holds_next |= board.firmware.keeps_line and command is Realtime.FEED_HOLD
        return
    if board.critical and command not in (Realtime.SOFT_RESET, Realtime.STATUS):
        return
    order = _ORDERS.get(command)
    if order is not None:
        order(board)


def hold(board: GrblBoard) -> None:
    """Slow down and stand: this ends a jog and pauses a motion, even in Idle.

    A board that hangs until a reset ignores it: grblHAL (state_machine.c, by its source).
    """
    if board.state is State.JOG and board.firmware.holds_jogs:
        board.cycle.cancel(board)
    elif board.state is State.RUN:
        board.drive.brake(board.now_s)
        board.state, board.cycle.stands = State.HOLD, False
    elif board.state is State.IDLE and not _hangs_until_reset(board):
        board.state, board.cycle.stands = State.HOLD, True


def resume(board: GrblBoard) -> None:
    """Resume from a completed hold, or read lines again after having hung."""
    board.main_loop.hung = board.main_loop.hung and not board.firmware.resume_unhangs
    if board.state is State.HOLD and board.cycle.stands:
        board.cycle.stands = False
        board.state = State.IDLE
        if board.drive.rack.waiting:
            board.cycle.start(board, State.RUN)


def soft_reset(board: GrblBoard) -> None:
    """Restart; in motion the motors stop dead and may lose steps, or drive what is computed.

    Of the resets during a restart some firmware keeps some, and starts once more for each. If it
    had not yet noticed the first one, homing is ended twice: observed on FluidNC.
    """
    if board.booting.active:
        if len(board.again) < board.firmware.resets_kept:
            board.again.append(AlarmNumber.RESET_IN_HOMING if board.state is State.HOME else 0)
        return
    _outputs_off(board)
    code = 0
    if board.state is State.HOME:
        backing_off = board.drive.moving and board.switches.mask()
        # as if backing off had failed: observed on the Mega (limits.c), and so in grblHAL
        code = AlarmNumber.STILL_PRESSED if backing_off else AlarmNumber.RESET_IN_HOMING
    elif board.drive.moving:
        code = AlarmNumber.RESET_IN_MOTION
        _lose_current(board, restarts=True)
    elif board.state is State.SLEEP and board.firmware.wakes_with_alarm:
        code = AlarmNumber.RESET_IN_MOTION
    elif board.critical and board.unhomed:
        code = AlarmNumber.UNHOMED
    elif _hangs_until_reset(board):
        code = AlarmNumber.RESET_IN_MOTION
    # observed on FluidNC: it starts a motion of homing that is about to start after the reset
    runs_on = board.state is State.HOME and board.unread.waited
    runs_on |= code == AlarmNumber.RESET_IN_MOTION and board.firmware.killed is Killed.RUNS_ON
    if not runs_on:
        board.cycle.kill(board)
    board.booting.begin(_restarted(board, code, runs_on=runs_on), board.now_s)


def raise_critical(board: GrblBoard, code: int) -> None:
    """Lock the board after a limit alarm: motion stops dead, and the motors go off."""
    _outputs_off(board)
    board.stalls = board.drive.moving and not board.firmware.limit_locks
    if board.drive.moving:
        board.cycle.kill(board)
        _lose_current(board, restarts=False)
    board.state, board.critical = State.ALARM, True
    if code == AlarmNumber.HARD_LIMIT:
        board.unhome()
    board.say(Alarm(code))
    board.tell("Reset to continue")


def fail(board: GrblBoard, code: int) -> Waits:
    """Raise a homing alarm, after which most boards restart; the motors stay on."""
    board.cycle.kill(board)
    if board.firmware.failed_homing_restarts:
        board.booting.begin(_restarted(board, code), board.now_s)
        yield math.inf
    board.state = State.ALARM
    board.say(Alarm(code))
    yield board.now_s + board.firmware.alarm_s


def switched_on(board: GrblBoard, wait_s: float) -> Boot:
    """Start after power-on, with all counts at zero; most boards with homing are locked."""
    yield board.now_s + wait_s
    locked = board.firmware.homing_locks and board.settings.on(keys.HOMING)
    board.state = State.ALARM if locked else State.IDLE
    board.holds_next = False
    board.unhome()
    board.drive.set_axes((0,) * len(board.axes), board.now_s)
    _start(board)


def _restarted(board: GrblBoard, code: int, *, runs_on: bool = False) -> Boot:
    if board.state is State.SLEEP and board.firmware.killed is Killed.LATE:
        yield board.now_s + board.settings[keys.IDLE_MS] / 1000  # observed: 0.26 s at $1=255
    if code:
        if code == AlarmNumber.RESET_IN_MOTION and board.firmware.killed is Killed.LATE:
            yield board.now_s + board.settings[keys.IDLE_MS] / 1000
        board.state = State.ALARM
        board.say(Alarm(code))
        said_s = board.now_s
        if runs_on:
            board.cycle.forget()
            yield board.drive.rack.computed_s(board.now_s)
            board.cycle.kill(board)
        yield said_s + board.firmware.alarm_s
    elif board.critical and not board.firmware.limit_locks:
        board.state = State.IDLE
    # a board that executes a line has not fetched another one
    kept = board.ring.take_line() if _keeps_a_line(board) else b""
    board.main_loop.drop_line(board)
    yield board.now_s + RESTART_S
    _start(board)
    if board.stalls:
        board.stalls, stalled = False, board.state is State.IDLE
        board.state, board.main_loop.hung = State.RUN if stalled else board.state, stalled
    while board.again:
        code = board.again.pop(0)
        if code:
            board.say(Alarm(code))
            yield board.now_s + board.firmware.alarm_s
        yield board.now_s + RESTART_S
        _start(board)
    if kept and board.state is State.HOLD:  # it is planned, but not started
        board.codec.receive_data(kept)
        board.codec.next_event()
        board.say(Ok())
    elif kept:
        board.ring.put(kept)


def _hangs_until_reset(board: GrblBoard) -> bool:
    return board.main_loop.hung and not board.firmware.resume_unhangs


def _keeps_a_line(board: GrblBoard) -> bool:
    return board.firmware.keeps_line and not board.main_loop.executing


def _lose_current(board: GrblBoard, *, restarts: bool) -> None:
    """Release motors that were stopped dead; `restarts` if the board restarts by itself."""
    if board.firmware.killed is Killed.RUNS_ON:
        return
    if not restarts or board.firmware.killed is Killed.LATE:
        board.current.release(board.now_s)


def _outputs_off(board: GrblBoard) -> None:
    board.outputs.off()
    board.fingers.follow_output(board.now_s)


def _start(board: GrblBoard) -> None:
    pressed = board.settings.on(keys.HARD_LIMITS) and board.switches.mask()
    checked = bool(pressed) and board.firmware.checks_limits
    locked = checked or board.state in (State.ALARM, State.SLEEP)
    held, board.holds_next = board.holds_next and not locked, False
    board.state = State.ALARM if locked else State.HOLD if held else State.IDLE
    board.critical = board.main_loop.hung = False
    board.main_loop.refused = 0
    board.cycle.forget()
    board.cycle.stands = held
    board.ring.clear()
    board.codec.discard()
    board.drive.stop(board.now_s)
    board.drive.rack.limits = board.settings.limits()
    board.modal, board.position = Modal(), board.drive.goal_units
    board.reporter.restart()
    if board.settings.motors_stay_on:
        board.current.keep_on()
    else:
        board.current.release(board.now_s)
    board.limits.forget(board)
    board.say(board.firmware.banner)
    if checked:
        board.tell("Check Limits")
    if locked:
        board.tell("'$H'|'$X' to unlock")


def _jog_cancel(board: GrblBoard) -> None:
    if board.state in board.firmware.cancel_clears_in:
        board.ring.clear()
        board.main_loop.refused = 0
    if board.state is not State.JOG:
        return
    if board.drive.done_s - board.now_s < board.firmware.cancel_hangs_s:
        board.cycle.hangs = True
    else:
        board.cycle.cancel(board)


def _ask(board: GrblBoard) -> None:
    board.reporter.asked = True


_ORDERS: Mapping[Realtime, Callable[[GrblBoard], None]] = MappingProxyType(
    {
        Realtime.STATUS: _ask,
        Realtime.SOFT_RESET: soft_reset,
        Realtime.FEED_HOLD: hold,
        Realtime.RESUME: resume,
        Realtime.JOG_CANCEL: _jog_cancel,
    }
)

ROUTINES = FirmwareRoutines(run_line, obey, raise_critical, fail, switched_on)
