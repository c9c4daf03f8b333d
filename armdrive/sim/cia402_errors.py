"""What a simulated CiA 402 drive says of its errors: EMCY, error register, error code, history."""

from __future__ import annotations

from armdrive.sim.cia402_node import Node
from armdrive.sim.cia402_places import ERROR_COUNT, LAST_ERROR
from firmware_protocol.canopen import ERROR_CODE, ERROR_REGISTER, Emergency, ErrorRegister

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


def report(node: Node, code: int) -> None:
    """Say that something is wrong, and keep it."""
    register = ErrorRegister.GENERIC | _kind(code) | node.number_of(ERROR_REGISTER, 0)
    node.keep(ERROR_REGISTER, register)
    node.keep(ERROR_CODE, code)
    node.keep(LAST_ERROR, code)
    node.keep(ERROR_COUNT, 1)
    say(node, code)


def over(node: Node) -> None:
    """Say that nothing is wrong any more, if something was."""
    if node.number_of(ERROR_REGISTER, 0):
        node.keep(ERROR_REGISTER, 0)
        node.keep(ERROR_CODE, 0)
        say(node, 0)


def say(node: Node, code: int) -> None:
    """Say an EMCY, whatever it is that has caused it."""
    if node.nmt.takes("emcy"):
        node.say((Emergency(node.number, code, node.number_of(ERROR_REGISTER, 0)).frame,))


def _kind(code: int) -> int:
    if code in _OF_TALK:
        return ErrorRegister.COMMUNICATION
    return _KINDS.get(code >> 12, ErrorRegister.DEVICE_PROFILE)
