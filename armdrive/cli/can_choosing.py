"""Which CAN adapter is meant: one that the system knows, or one that is written in full."""

from __future__ import annotations

from armdrive.cli.presenter import say
from armdrive.cli.questions import ask_value
from armdrive.dialog import Question, WrongAnswer


def chosen_port(adapters: str) -> str:
    """Have the person choose an adapter; `adapters` says which lines there are. Opens none."""
    from armdrive.transports.address import is_can
    from armdrive.transports.ports import list_can_ports, list_ports

    ports = list_ports()
    found = list_can_ports(ports)
    say(adapters)
    lines = tuple((each.port, each.todo or each.description) for each in found)

    def read(line: str) -> str:
        if line.isdecimal() and 1 <= int(line) <= len(lines):
            return lines[int(line) - 1][0]
        if not is_can(line):
            raise WrongAnswer("write the adapter's line, can:slcan:/dev/ttyACM0?bitrate=500000 say")
        return line

    default = lines[0][0] if len(lines) == 1 else None
    why = "With slcan firmware a CANable is a serial port, with candleLight it is none."
    return str(ask_value(Question("", "Which adapter?", why, read, default, lines)))
