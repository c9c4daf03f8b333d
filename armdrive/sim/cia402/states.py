"""The states of a simulated CiA 402 drive: what changes them, its errors, and its lost master."""

from __future__ import annotations

import math
from collections.abc import Iterable

from armdrive.sim.cia402 import motion as homing
from armdrive.sim.cia402.motion import (
    aim,
    arrived,
    brake,
    forget_targets,
    go,
    of_profile,
    quickly,
    slope,
    slow_down,
)
from armdrive.sim.cia402.node import Cia402Node
from armdrive.sim.cia402.objects import ERROR_COUNT, LAST_ERROR
from firmware_protocol.canopen import (
    CONTROLWORD,
    ERROR_CODE,
    ERROR_REGISTER,
    FAULT_REACTION_OPTION,
    HEARTBEAT_REACTION,
    PROFILE_DECELERATION,
    QUICK_STOP_DECELERATION,
    TARGET_POSITION,
    Command,
    ControlBit,
    Controlword,
    DriveState,
    Emergency,
    ErrorRegister,
    Happening,
    OperationMode,
    QuickStopOption,
    SetPoint,
    Transition,
)

# --- Errors: EMCY, error register, error code, history -------------------------------------------

HEARTBEAT_MISSING = 0x8130
PDO_TOO_SHORT = 0x8210
TOO_FAR_BEHIND = 0x8611
LIMIT_REACHED = 0x8612

_KINDS = {
    0x2: ErrorRegister.CURRENT,
    0x3: ErrorRegister.VOLTAGE,
    0x4: ErrorRegister.TEMPERATURE,
}
_OF_TALK = range(0x8100, 0x8300)


def report(node: Cia402Node, code: int) -> None:
    """Say that something is wrong, and keep it."""
    register = ErrorRegister.GENERIC | _kind(code) | node.number_of(ERROR_REGISTER, 0)
    node.keep(ERROR_REGISTER, register)
    node.keep(ERROR_CODE, code)
    node.keep(LAST_ERROR, code)
    node.keep(ERROR_COUNT, 1)
    say(node, code)


def over(node: Cia402Node) -> None:
    """Say that nothing is wrong any more, if something was."""
    if node.number_of(ERROR_REGISTER, 0):
        node.keep(ERROR_REGISTER, 0)
        node.keep(ERROR_CODE, 0)
        say(node, 0)


def say(node: Cia402Node, code: int) -> None:
    """Say an EMCY, whatever it is that has caused it."""
    if node.nmt.takes("emcy"):
        node.say((Emergency(node.number, code, node.number_of(ERROR_REGISTER, 0)).frame,))


def _kind(code: int) -> int:
    if code in _OF_TALK:
        return ErrorRegister.COMMUNICATION
    return _KINDS.get(code >> 12, ErrorRegister.DEVICE_PROFILE)


_FAULT_RESET = 15
_ON_RAMP = (QuickStopOption.RAMP, QuickStopOption.RAMP_AND_STAY)
_ON_QUICK_RAMP = (QuickStopOption.QUICK_RAMP, QuickStopOption.QUICK_RAMP_AND_STAY)
_FREE_AT_ONCE, _BY_QUICK_RAMP = 0, 2
_RAMPS = {1: PROFILE_DECELERATION}
"""By what ramp 605E has it brake, where that is not the quick stop's."""


def control(node: Cia402Node, now_s: float) -> None:
    """Obey the controlword, as it stands in its object."""
    word = Controlword(node.number_of(CONTROLWORD, 0))
    halted = node.machine.points.halted
    taken, point = node.machine.control(word, node.number_of(TARGET_POSITION, 0))
    take(node, taken, now_s)
    if not node.enabled:
        return
    if node.mode == OperationMode.HOMING:
        _control_homing(node, word, point, now_s)
    elif of_profile(node):
        _control_profile(node, point, now_s, halted=halted)
    else:
        forget_targets(node)
        if node.machine.points.halted and not halted and node.point.moving(now_s):
            slow_down(node, now_s)


def take(node: Cia402Node, taken: Iterable[Transition], now_s: float) -> None:
    """Do what changes of the state mean for the motor."""
    for row in taken:
        if row.number == _FAULT_RESET:
            node.astray = False
            over(node)
        if row.end is DriveState.QUICK_STOP:
            homing.give_up(node, now_s)
            brake(node, _stopping_slope(node), now_s)
        if row.end is DriveState.ENABLED:
            if not node.holding:
                node.drive.hold(node.index, now_s)
            node.goal = node.point.end - node.zero
        if not row.end.holds:
            let_go(node, now_s)


def let_go(node: Cia402Node, now_s: float) -> None:
    """Take the motor's current: what it holds comes down."""
    node.homing = node.homing.given_up
    node.ends, node.astray_s, node.switch_s = False, math.inf, math.inf
    if node.holding:
        node.drive.release((node.index,), now_s)


def command(node: Cia402Node, what: Command, now_s: float) -> None:
    """Have the drive do by itself what a controlword would."""
    take(node, node.machine.control(Controlword.of(what))[0], now_s)


def fault(node: Cia402Node, code: int, now_s: float) -> None:
    """Fail, and say why: by 605E it brakes, and then its motor is free."""
    report(node, code)
    changed = node.machine.happen(Happening.FAULT)
    if not node.ailing:
        node.machine.mend()  # what it was is over; a reset leads out once it has reacted
    if changed is None:
        return
    homing.give_up(node, now_s)
    reaction = node.number_of(FAULT_REACTION_OPTION, _BY_QUICK_RAMP)
    if not node.holding or reaction == _FREE_AT_ONCE:
        brake(node, math.inf, now_s)
    else:
        brake(node, slope(node, _RAMPS.get(reaction, QUICK_STOP_DECELERATION)), now_s)


def watch_end(node: Cia402Node, now_s: float) -> None:
    """Do what is due when a motion has ended."""
    if not node.ends or node.point.moving(now_s):
        return
    if node.state is DriveState.FAULT_REACTION:
        node.ends = False
        take(node, _happened(node, Happening.REACTED), now_s)
    elif node.state is DriveState.QUICK_STOP:
        node.ends = False
        take(node, _happened(node, Happening.QUICK_STOPPED), now_s)
    elif node.enabled:
        _watch_arrival(node, now_s)
    else:
        node.ends = False


def _watch_arrival(node: Cia402Node, now_s: float) -> None:
    node.waits = not arrived(node)
    if node.waits:
        return
    node.ends, points = False, node.machine.points
    if points.halted:
        points.stood()
    elif of_profile(node) and points.active is not None and (after := points.arrived()) is not None:
        aim(node, after)
        go(node, now_s)


def _control_profile(
    node: Cia402Node, point: SetPoint | None, now_s: float, *, halted: bool
) -> None:
    points = node.machine.points
    if point is not None:
        aim(node, point)
    if points.halted:
        if not halted:
            slow_down(node, now_s)
    elif point is not None or (halted and points.active is not None):
        go(node, now_s)


def _control_homing(
    node: Cia402Node, word: Controlword, point: SetPoint | None, now_s: float
) -> None:
    if not word.has(ControlBit.NEW_SET_POINT) or node.machine.points.halted:
        homing.give_up(node, now_s)
    elif point is not None:
        homing.begin(node, now_s)


def _stopping_slope(node: Cia402Node) -> float:
    option = node.machine.quick_stop
    if option in _ON_RAMP:
        return slope(node, PROFILE_DECELERATION)
    return quickly(node) if option in _ON_QUICK_RAMP else math.inf


def _happened(node: Cia402Node, happening: Happening) -> Iterable[Transition]:
    row = node.machine.happen(happening)
    return () if row is None else (row,)


# --- A lost master: object 6007 ------------------------------------------------------------------

_FAULT = 1
_COMMANDS = {2: Command.DISABLE_VOLTAGE, 3: Command.QUICK_STOP}


def forsake(node: Cia402Node, now_s: float) -> None:
    """Miss its master's heartbeat: say so, and react."""
    node.forsaken = True
    node.watch_stops += 1
    if node.number_of(HEARTBEAT_REACTION, _FAULT) != _FAULT:
        report(node, HEARTBEAT_MISSING)
    react(node, now_s, HEARTBEAT_MISSING)


def react(node: Cia402Node, now_s: float, code: int = HEARTBEAT_MISSING) -> None:
    """Do what 6007 says: nothing, a fault, let the motor go, or a quick stop."""
    reaction = node.number_of(HEARTBEAT_REACTION, _FAULT)
    if reaction == _FAULT:
        fault(node, code, now_s)
    elif reaction in _COMMANDS and node.state is DriveState.ENABLED:
        command(node, _COMMANDS[reaction], now_s)
