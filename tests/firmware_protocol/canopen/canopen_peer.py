"""The package `canopen`, an independent CANopen, on the other end of a virtual bus."""

import io
import uuid
from contextlib import contextmanager
from types import SimpleNamespace

import can
import canopen
from canopen.objectdictionary.eds import import_eds
from eds_writer import write_eds

from firmware_protocol.canopen import (
    STANDARD,
    Access,
    DataType,
    Dictionary,
    ObjectEntry,
    Place,
)
from firmware_protocol.frames import Frame

NODE, PATIENCE_S, CYCLE_S = 5, 5.0, 0.02
NAME = Place(0x1008)


def parameters(base, kinds):
    return [
        ObjectEntry(Place(base, sub), f"{base:04X} {sub}", kind, Access.RW, default=0)
        for sub, kind in kinds
    ]


COMMUNICATION = [(0, DataType.U8), (1, DataType.U32), (2, DataType.U8)]
ENTRIES = [(0, DataType.U8), *((sub, DataType.U32) for sub in range(1, 5))]
DICTIONARY = Dictionary(
    (
        *STANDARD,
        ObjectEntry(NAME, "Device name", DataType.VISIBLE_STRING, Access.RW),
        *parameters(0x1400, COMMUNICATION),
        *parameters(0x1600, ENTRIES),
        *parameters(0x1800, COMMUNICATION),
        *parameters(0x1A00, ENTRIES),
    )
)


def their_dictionary():
    return import_eds(io.StringIO(write_eds(DICTIONARY)), NODE)


@contextmanager
def virtual_bus():
    """Give their network and our end of the same bus."""
    channel = str(uuid.uuid4())
    network = canopen.Network()
    network.NOTIFIER_CYCLE = CYCLE_S
    with can.Bus(channel, interface="virtual") as ours:
        network.connect(channel=channel, interface="virtual")
        try:
            yield SimpleNamespace(network=network, ours=ours)
        finally:
            network.disconnect()


def send(bus, frame) -> None:
    if frame is not None:
        bus.ours.send(
            can.Message(arbitration_id=frame.can_id, data=frame.data, is_extended_id=False)
        )


def receive(bus) -> Frame:
    message = bus.ours.recv(PATIENCE_S)
    assert message is not None, "they say nothing"
    return Frame(message.arbitration_id, bytes(message.data))
