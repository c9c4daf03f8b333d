"""The `$` commands of a simulated GRBL board. Source: gnea/grbl grbl/system.c."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping
from types import MappingProxyType
from typing import Any

from armdrive.sim.grbl_board import Board
from armdrive.sim.grbl_homing import home
from armdrive.sim.grbl_parser import STORED
from armdrive.sim.grbl_paths import FIRST_TOLD
from armdrive.sim.grbl_settings import ALWAYS_ON_MS, HOMING
from armdrive.sim.grbl_waits import write_eeprom
from firmware_protocol.grbl import (
    Block,
    Bracketed,
    CheckMode,
    Feedback,
    Help,
    Home,
    Parameter,
    QueryBuildInfo,
    QueryParameters,
    QueryParserState,
    QuerySettings,
    QueryStartupLines,
    Realtime,
    Rejected,
    Restore,
    SetSetting,
    Setting,
    Sleep,
    State,
    StoreBuildInfo,
    StoreStartupLine,
    SystemCommand,
    Unlock,
    parse_line,
)

Steps = Generator[float, None, int]
NOT_IDLE, NO_HOMING = 8, 5
_HELP = "$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x"


def run_system(board: Board, command: SystemCommand) -> Steps:
    """Carry out a command, or refuse it in this state; returns 0 or the number of an error."""
    states, steps = _COMMANDS[type(command)]
    if states and board.state not in states:
        return NOT_IDLE
    return (yield from steps(board, command))


def _help(board: Board, _: Help) -> Steps:
    board.say(Bracketed(f"HLP:{_HELP}"))
    yield from ()
    return 0


def _settings(board: Board, _: QuerySettings) -> Steps:
    for number, text in board.settings.written():
        if number >= FIRST_TOLD or not board.firmware.has_paths:
            board.say(Setting(number, text))
    yield from ()
    return 0


def _parser_state(board: Board, _: QueryParserState) -> Steps:
    board.say(board.parser.modal.report)
    yield from ()
    return 0


def _parameters(board: Board, _: QueryParameters) -> Steps:
    parser = board.parser
    for name in STORED:
        board.say(Parameter(name, parser.stored[name]))
    board.say(Parameter("G92", parser.g92))
    board.say(Parameter("TLO", (0.0,)))
    board.say(Parameter("PRB", parser.zero, success=False))
    yield from ()
    return 0


def _build(board: Board, _: QueryBuildInfo) -> Steps:
    for line in board.firmware.info(board.axes, board.note):
        board.say(line)
    yield from ()
    return 0


def _startup_lines(board: Board, _: QueryStartupLines) -> Steps:
    for number, text in enumerate(board.startup):
        board.say(Setting(f"N{number}", text))
    yield from ()
    return 0


def _unlock(board: Board, _: Unlock) -> Steps:
    if board.state is State.ALARM:
        board.say(Feedback("Caution: Unlocked"))
        board.state = State.IDLE
    yield from ()
    return 0


def _check(board: Board, _: CheckMode) -> Steps:
    if board.state is State.CHECK:
        board.say(Feedback("Disabled"))
        board.makers.order(board, Realtime.SOFT_RESET)
        yield math.inf
    elif board.state is not State.IDLE:
        return NOT_IDLE
    board.say(Feedback("Enabled"))
    board.state = State.CHECK
    return 0


def _sleep(board: Board, _: Sleep) -> Steps:
    """Fall asleep, once the line is answered: seen on both 8-bit boards."""

    def fall_asleep() -> None:
        board.say(Feedback("Sleeping"))
        board.outputs.off()
        board.outputs_changed()
        board.state, board.stands = State.SLEEP, True
        board.idle_off_s = board.now_s + ALWAYS_ON_MS / 1000

    board.afterwards = fall_asleep
    yield from ()
    return 0


def _home(board: Board, command: Home) -> Steps:
    if not board.settings.on(HOMING):
        return NO_HOMING
    letters = command.axes or board.axes
    code = yield from home(board, [board.axes.index(letter) for letter in letters])
    if code:
        board.makers.fail(board, code)
        yield math.inf
    return 0


def _set(board: Board, command: SetSetting) -> Steps:
    code = board.settings.store(command.setting, command.value)
    if code:
        return code
    board.drive.rack.limits = board.settings.limits()
    yield from write_eeprom(board)
    return 0


def _store_line(board: Board, command: StoreStartupLine) -> Steps:
    if board.state is not State.IDLE:
        return NOT_IDLE
    content = parse_line(command.line, board.codec.dialect)
    if isinstance(content, Rejected):
        return content.code
    if command.line and not isinstance(content, Block):
        return 3
    board.startup[command.which] = command.line
    yield from write_eeprom(board)
    return 0


def _store_note(board: Board, command: StoreBuildInfo) -> Steps:
    board.note = command.note
    yield from write_eeprom(board)
    return 0


def _restore(board: Board, command: Restore) -> Steps:
    if command.what in "$*":
        board.settings.values.update(board.settings.factory)
    if command.what in "#*":
        board.parser.stored = dict.fromkeys(STORED, board.parser.zero)
    if command.what == "*":
        board.startup[:] = "", ""
        board.note = ""
    yield from write_eeprom(board)
    board.say(Feedback("Restoring defaults"))
    board.makers.order(board, Realtime.SOFT_RESET)
    yield math.inf
    return 0


_STILL = (State.IDLE, State.ALARM)
_NO_CYCLE = tuple(state for state in State if state not in (State.RUN, State.HOLD))
_COMMANDS: Mapping[type, tuple[tuple[State, ...], Callable[[Board, Any], Steps]]] = (
    MappingProxyType(
        {
            Help: ((), _help),
            QuerySettings: (_NO_CYCLE, _settings),
            QueryParserState: ((), _parser_state),
            CheckMode: ((), _check),
            Unlock: ((), _unlock),
            QueryParameters: (_STILL, _parameters),
            QueryBuildInfo: (_STILL, _build),
            QueryStartupLines: (_STILL, _startup_lines),
            Sleep: (_STILL, _sleep),
            Home: (_STILL, _home),
            SetSetting: (_STILL, _set),
            StoreStartupLine: (_STILL, _store_line),
            StoreBuildInfo: (_STILL, _store_note),
            Restore: (_STILL, _restore),
        }
    )
)
"""The states in which a command is taken (all where none is named), and what it does."""
