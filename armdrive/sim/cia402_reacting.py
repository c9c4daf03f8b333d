"""What a simulated CiA 402 drive does when nobody commands it any more: object 6007."""

from __future__ import annotations

from armdrive.sim.cia402_errors import HEARTBEAT_MISSING, report
from armdrive.sim.cia402_node import Node
from armdrive.sim.cia402_states import command, fault
from firmware_protocol.canopen import HEARTBEAT_REACTION, Command, DriveState

_FAULT = 1
_COMMANDS = {2: Command.DISABLE_VOLTAGE, 3: Command.QUICK_STOP}


def forsake(node: Node, now_s: float) -> None:
    """Miss its master's heartbeat: say so, and react."""
    node.forsaken = True
    node.watch_stops += 1
    if node.number_of(HEARTBEAT_REACTION, _FAULT) != _FAULT:
        report(node, HEARTBEAT_MISSING)
    react(node, now_s, HEARTBEAT_MISSING)


def react(node: Node, now_s: float, code: int = HEARTBEAT_MISSING) -> None:
    """Do what 6007 says: nothing, a fault, let the motor go, or a quick stop."""
    reaction = node.number_of(HEARTBEAT_REACTION, _FAULT)
    if reaction == _FAULT:
        fault(node, code, now_s)
    elif reaction in _COMMANDS and node.state is DriveState.ENABLED:
        command(node, _COMMANDS[reaction], now_s)
