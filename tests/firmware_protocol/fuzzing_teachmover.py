"""The TeachMover codec's two ends for the long fuzz run."""

from fuzzing import FuzzCase
from teachmover_strategies import COMMANDS, REPLIES

from firmware_protocol import teachmover
from firmware_protocol.teachmover.messages import encode_command, encode_reply


def _host_saw_one(host: teachmover.Host) -> bool:
    """Ask for nothing, so that every readable line is an event of its own."""
    seen = False
    while (event := host.next_event()) is not None:
        seen |= isinstance(event, teachmover.Completed | teachmover.Stray)
    return seen


def _device_saw_one(device: teachmover.Device) -> bool:
    """Answer that it failed, so that the attention character stays as it is."""
    seen = False
    while (event := device.next_event()) is not None:
        if isinstance(event, teachmover.Ignored):
            continue
        seen |= not isinstance(event, teachmover.Unreadable)
        device.send(teachmover.Status.FAILED)
    return seen


LINES = COMMANDS.map(lambda command: encode_command(command, teachmover.ATTENTION))
MOST_HELD = 256 * 256 + 256
HOST = FuzzCase(
    "teachmover host", teachmover.Host, REPLIES.map(encode_reply), _host_saw_one, MOST_HELD
)
DEVICE = FuzzCase("teachmover device", teachmover.Device, LINES, _device_saw_one, MOST_HELD)
