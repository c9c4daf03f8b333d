"""The SUPER protocol's two ends for the long fuzz run."""

from fuzzing import FuzzCase
from robko01_strategies import ANSWERS, REQUESTS

from firmware_protocol import robko01
from firmware_protocol.robko01.messages import encode_answer, encode_request


def _host_saw_one(host: robko01.Host) -> bool:
    seen = False
    while (event := host.next_event()) is not None:
        seen |= isinstance(event, robko01.Answered | robko01.Stray)
    if host.outstanding is None:
        host.send(robko01.Position())
    return seen


def _device_saw_one(device: robko01.Device) -> bool:
    seen = False
    while (event := device.next_event()) is not None:
        if not isinstance(event, robko01.Unreadable | robko01.Overrun):
            seen = True
            device.send(robko01.Acknowledged(event.op, robko01.Status.ERROR))
    return seen


HOST = FuzzCase("robko01 host", robko01.Host, ANSWERS.map(encode_answer), _host_saw_one)
DEVICE = FuzzCase("robko01 device", robko01.Device, REQUESTS.map(encode_request), _device_saw_one)
