"""Whether a line fits the board that it is for: its length, its axes, its options."""

from __future__ import annotations

from firmware_protocol.errors import BadField, LocalProtocolError
from firmware_protocol.grbl.commands import Command
from firmware_protocol.grbl.dialect import Dialect, Variant
from firmware_protocol.grbl.moves import AnalogOutput, DigitalOutput, Jog, Move
from firmware_protocol.grbl.system import Home


def check_command(command: Command, dialect: Dialect) -> None:
    """Raise `LocalProtocolError` where this board could not read the line, or would refuse it."""
    if isinstance(command, Move | Jog | Home):
        strangers = set(command.axes) - set(dialect.axes)
        if strangers:
            raise BadField("axes", "".join(sorted(strangers)), f"axes out of {dialect.axes}")
    if isinstance(command, DigitalOutput | AnalogOutput) and not dialect.outputs:
        raise LocalProtocolError(f"this board has no outputs for '{command.text}'")
    if isinstance(command, Home) and command.axes:
        several = len(command.axes) > 1 and dialect.variant is not Variant.GRBLHAL
        if several or not dialect.single_axis_homing:
            raise LocalProtocolError(f"this board cannot home by '{command.text}'")
    if len(command.text) > dialect.max_line:
        raise LocalProtocolError(
            f"'{command.text}' has {len(command.text)} characters, the board takes "
            f"{dialect.max_line}: name fewer axes, or digits"
        )
