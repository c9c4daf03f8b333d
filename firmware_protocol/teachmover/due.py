"""What a command is answered with: a status line, and after DONE, of some, something more."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum, auto
from types import MappingProxyType

from firmware_protocol.teachmover.messages import Command, QDump, Read, Registers, Reply, Status
from firmware_protocol.teachmover.program import ProgramRow


class Due(Enum):
    """What the device owes, and the host waits for."""

    NOTHING = auto()
    STATUS = auto()
    REGISTERS = auto()
    ROWS = auto()


AFTER_DONE: Mapping[type[Command], Due] = MappingProxyType({Read: Due.REGISTERS, QDump: Due.ROWS})
"""What follows the status line DONE, for the commands where something does."""

FORMS: Mapping[Due, tuple[type[Reply], str]] = MappingProxyType(
    {
        Due.STATUS: (Status, "a status line"),
        Due.REGISTERS: (Registers, "a register line"),
        Due.ROWS: (ProgramRow, "a program row"),
    }
)
"""The form of what is due, and what it is called."""
