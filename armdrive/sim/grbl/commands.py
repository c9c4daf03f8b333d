"""The `$` commands of a simulated GRBL board, and its homing. Source: gnea/grbl grbl/system.c."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Generator, Mapping
from types import MappingProxyType
from typing import Any

from armdrive.sim.grbl.board import GrblBoard
from armdrive.sim.grbl.firmware import LOCATE, MINUTE_S, SEARCH, AlarmNumber, RefusalNumber
from firmware_protocol.grbl import (
    Feedback,
    Home,
    Remark,
    SetSetting,
    Setting,
    State,
    SystemCommand,
    keys,
)

# --- Homing: towards a switch, off it, slowly on again, and off ----------------------------------
# Several axes home one after the other; on a real board they turn together.
# Source: gnea/grbl grbl/limits.c (limits_go_home).

# A part of a script; it returns 0, or an error number.
Steps = Generator[float, None, int]
# A part of a script that only waits.
Waits = Generator[float, None, None]


def write_eeprom(board: GrblBoard) -> Waits:
    """Write the EEPROM with interrupts off on some boards: what arrives meanwhile is lost."""
    if board.firmware.deaf_in_eeprom:
        board.deaf_until_s = board.now_s + board.firmware.eeprom_s
    yield board.now_s + board.firmware.eeprom_s


def home(board: GrblBoard, axis: int) -> Steps:
    """Home an axis; return 0, or the number of the alarm if it fails."""
    settings, firmware = board.settings, board.firmware
    board.state = State.HOME
    board.current.keep_on()
    far = SEARCH * settings.axis(keys.TRAVEL, axis)
    back, seek = settings[keys.PULL_OFF], settings[keys.HOMING_SEEK] / MINUTE_S
    feed, pause_s = settings[keys.HOMING_FEED] / MINUTE_S, settings[keys.DEBOUNCE_MS] / 1000
    leave = feed if firmware.backs_off_at_feed else seek
    for search, rate in ((far, seek), (LOCATE * back, feed)):
        _count_from_zero(board, axis)
        while not board.switches.pressed(axis):
            if search <= 0.0:
                return AlarmNumber.NOT_FOUND
            steps = board.switches.steps_to(axis, _way(board, axis))
            per_unit = settings.axis(keys.STEPS_PER_UNIT, axis)
            way = search if steps is None else min(search, max(steps, 1) / per_unit)
            yield from _go(board, axis, way, rate)
            search -= way
        yield board.now_s + pause_s
        _count_from_zero(board, axis)
        yield from _go(board, axis, -back, leave)
        if board.switches.pressed(axis):
            return AlarmNumber.STILL_PRESSED
        yield board.now_s + pause_s
    place = list(board.drive.goal_units)
    place[axis] = _homed_at(board, axis)
    counts = board.drive.steps_of(place)
    board.drive.set_axes(counts, board.now_s)
    board.position = board.drive.units_of(counts)
    board.unhomed.discard(axis)
    board.state = State.ALARM if board.unhomed else State.IDLE
    board.current.release_at_rest(board.now_s)
    board.limits.forget(board)
    return 0


def _way(board: GrblBoard, axis: int) -> int:
    return -1 if board.settings.mask(keys.HOMING_DIRECTIONS, axis) else 1


def _go(board: GrblBoard, axis: int, units: float, rate: float) -> Waits:
    """Move an axis towards its switch (backwards if negative), and wait."""
    target = list(board.drive.goal_units)
    target[axis] += units * _way(board, axis)
    board.drive.queue_to(target, rate, board.now_s)
    while board.drive.rack.waiting:
        yield math.inf


def _count_from_zero(board: GrblBoard, axis: int) -> None:
    """Begin a motion of homing, for which most firmware counts from zero."""
    if board.firmware.homing_counts:
        counts = list(board.drive.counts)
        counts[axis] = 0
        board.drive.set_axes(counts, board.now_s)


def _homed_at(board: GrblBoard, axis: int) -> float:
    """Return where the firmware says that a homed axis stands."""
    settings = board.settings
    if board.firmware.homes_at is not None:
        return board.firmware.homes_at
    if settings.mask(keys.HOMING_DIRECTIONS, axis):
        return settings[keys.PULL_OFF] - settings.axis(keys.TRAVEL, axis)
    return -settings[keys.PULL_OFF]


# --- Settings with names: `$/stepping/idle_ms`, and `=255` to change one --------------------------

_LINE = re.compile(r"\$/([a-z0-9_/]+)(?:=(.*))?", re.IGNORECASE)


def run_path(board: GrblBoard, line: str) -> int | None:
    """Report or change the setting that a line names; return 0 or an error number.

    None if the line names none, or the firmware has no names.
    """
    found, paths = _LINE.fullmatch(line), board.firmware.paths
    if found is None or paths is None:
        return None
    path, value = found[1].lower(), found[2]
    number, fixed = paths.find(path, board.axes)
    if value is None and (number is not None or fixed is not None):
        shown = f"{fixed:.3f}" if number is None else board.settings.written()[number]
        board.say(Setting(f"/{path}", shown))
        return 0
    if number is None:
        return RefusalNumber.UNKNOWN
    if board.state not in _STILL:
        return RefusalNumber.NOT_IDLE
    try:
        given = float(value)
    except ValueError:
        given = math.nan
    if not math.isfinite(given):
        board.say(Feedback("ERR: Bad numeric value"))
        return 0
    code = board.settings.store(number, given)
    board.drive.rack.limits = board.settings.limits()
    return code


def run_system(board: GrblBoard, command: SystemCommand | Home | SetSetting) -> Steps:
    """Execute a command, or refuse it in this state; return 0 or an error number."""
    states, act = _COMMANDS[command if isinstance(command, SystemCommand) else type(command)]
    if states and board.state not in states:
        return RefusalNumber.NOT_IDLE
    outcome = act(board, command)
    return outcome if isinstance(outcome, int) else (yield from outcome)


def refused_command(board: GrblBoard, line: str, code: int) -> int:
    """Return the error of a line that the firmware does not know.

    GRBL 1.1 enters the state of homing before it looks at the letter of an axis.
    """
    homes = line.startswith("$H") and board.firmware.sticks_in_homing
    if not homes or board.state not in _STILL:
        return code
    if not board.settings[keys.HOMING]:
        return RefusalNumber.NO_HOMING
    board.state = State.HOME
    return code


def _settings(board: GrblBoard, _: SystemCommand) -> int:
    paths = board.firmware.paths
    for number, text in board.settings.written().items():
        if paths is None or number >= keys.STEPS_PER_UNIT or number in paths.listed:
            board.say(Setting(number, text))
    return 0


def _build(board: GrblBoard, _: SystemCommand) -> int:
    for text in board.firmware.info:
        board.say(Remark(f"[{text.format(axes=board.axes, many=len(board.axes))}]"))
    return 0


def _unlock(board: GrblBoard, _: SystemCommand) -> int:
    if board.state is State.ALARM:
        board.tell("Caution: Unlocked")
        board.state = State.IDLE
        board.unhomed.clear()
    return 0


def _sleep(board: GrblBoard, _: SystemCommand) -> int:
    """Fall asleep once the line is answered: observed on both 8-bit boards and on grblHAL."""
    if not board.settings.values.get(keys.SLEEP_ENABLE, 1.0):
        return RefusalNumber.UNKNOWN

    def fall_asleep() -> None:
        board.tell("Sleeping")
        board.outputs.off()
        board.fingers.follow_output(board.now_s)
        board.state, board.cycle.stands = State.SLEEP, True
        board.current.off_s = board.now_s + keys.ALWAYS_ON_MS / 1000

    board.main_loop.afterwards = fall_asleep
    return 0


def _home(board: GrblBoard, command: Home) -> Steps:
    homing = int(board.settings[keys.HOMING])
    if not homing or (command.axes and not homing & board.firmware.single_axis_bits):
        return RefusalNumber.NO_HOMING
    # without letters, some builds leave axes out
    for letter in command.axes or board.axes:
        code = yield from home(board, board.axes.index(letter))
        if code:
            yield from board.routines.fail(board, code)
            break
    return 0


def _set(board: GrblBoard, command: SetSetting) -> Steps:
    paths = board.firmware.paths
    if paths is not None and command.setting not in paths.changeable:
        return RefusalNumber.UNKNOWN
    code = board.settings.store(command.setting, command.value)
    if code:
        return code
    board.drive.rack.limits = board.settings.limits()
    yield from write_eeprom(board)
    return 0


_STILL = (State.IDLE, State.ALARM)
_NO_CYCLE = tuple(state for state in State if state not in (State.RUN, State.HOLD))
_Action = tuple[tuple[State, ...], Callable[[GrblBoard, Any], Steps | int]]
# The states in which a command is accepted (all if none is listed), and its action.
#
# The action runs at once, or in steps.
_COMMANDS: Mapping[SystemCommand | type, _Action] = MappingProxyType(
    {
        SystemCommand.QUERY_SETTINGS: (_NO_CYCLE, _settings),
        SystemCommand.UNLOCK: ((), _unlock),
        SystemCommand.QUERY_BUILD: (_STILL, _build),
        SystemCommand.SLEEP: (_STILL, _sleep),
        Home: (_STILL, _home),
        SetSetting: (_STILL, _set),
    }
)
