"""Our SDO client and our tables, beside the node and the tables of the package `canopen`."""

import io
import uuid
from types import SimpleNamespace

import pytest

canopen = pytest.importorskip("canopen")

import can  # noqa: E402
from canopen.objectdictionary.eds import import_eds  # noqa: E402
from canopen.profiles.p402 import State402  # noqa: E402
from eds_writer import write_eds  # noqa: E402

from firmware_protocol.canopen import (  # noqa: E402
    CONTROLWORD,
    STANDARD,
    STATUSWORD,
    TRANSITIONS,
    AbortCode,
    Aborted,
    Access,
    Controlword,
    DataType,
    Dictionary,
    DriveState,
    Emergency,
    ObjectEntry,
    Place,
    SdoClient,
    Statusword,
    Uploaded,
)
from firmware_protocol.frames import Frame  # noqa: E402

NODE, PATIENCE_S, CYCLE_S = 5, 5.0, 0.02
NAME = Place(0x1008)
DICTIONARY = Dictionary(
    (*STANDARD, ObjectEntry(NAME, "Device name", DataType.VISIBLE_STRING, Access.RW))
)


@pytest.fixture
def bus():
    """Return their network and our end of the same virtual bus."""
    channel = str(uuid.uuid4())
    network = canopen.Network()
    network.NOTIFIER_CYCLE = CYCLE_S
    with can.Bus(channel, interface="virtual") as ours:
        network.connect(channel=channel, interface="virtual")
        yield SimpleNamespace(network=network, ours=ours)
        network.disconnect()


@pytest.fixture
def slave(bus):
    return bus.network.create_node(NODE, import_eds(io.StringIO(write_eds(DICTIONARY)), NODE))


def receive(bus) -> Frame:
    message = bus.ours.recv(PATIENCE_S)
    assert message is not None, "they say nothing"
    return Frame(message.arbitration_id, bytes(message.data))


def transfer(bus, client, request):
    """Carry a transfer of ours with their node to its end."""
    while request is not None:
        bus.ours.send(
            can.Message(arbitration_id=request.can_id, data=request.data, is_extended_id=False)
        )
        request = client.receive_frame(receive(bus))
    return client.next_event()


@pytest.mark.parametrize("size", [1, 4, 5, 7, 8, 14, 100])
def test_our_client_reads_from_their_server(bus, slave, size):
    client, name = SdoClient(NODE), b"armdrive!".ljust(size, b"x")[:size]
    slave.sdo["Device name"].raw = name.decode()
    assert transfer(bus, client, client.upload(NAME)) == Uploaded(NAME, name)


def test_our_client_understands_why_their_server_refuses(bus, slave):
    client = SdoClient(NODE)
    for request, code in (
        (lambda: client.upload(Place(0x7000)), AbortCode.NO_OBJECT),
        (lambda: client.upload(Place(0x1018, 9)), AbortCode.NO_SUB_INDEX),
        (lambda: client.download(STATUSWORD, b"\0\0"), AbortCode.READ_ONLY),
        (lambda: client.download(CONTROLWORD, b"\0"), AbortCode.LENGTH),
    ):
        event = transfer(bus, client, request())
        assert (type(event), event.code) == (Aborted, code)


def test_emergencies_are_understood_both_ways(bus, slave):
    slave.emcy.send(0x8611, 0x21, b"\1\2\3\4\5")
    assert Emergency.read(receive(bus)) == Emergency(NODE, 0x8611, 0x21, b"\1\2\3\4\5")
    consumer = canopen.emcy.EmcyConsumer()
    consumer.on_emcy(0x85, Emergency(NODE, 0x8611, 0x21, b"\1\2\3\4\5").frame.data, 0.0)
    (theirs,) = consumer.log
    assert (theirs.code, theirs.register, theirs.data) == (0x8611, 0x21, b"\1\2\3\4\5")


STATES = {
    "NOT READY TO SWITCH ON": DriveState.NOT_READY,
    "SWITCH ON DISABLED": DriveState.DISABLED,
    "READY TO SWITCH ON": DriveState.READY,
    "SWITCHED ON": DriveState.SWITCHED_ON,
    "OPERATION ENABLED": DriveState.ENABLED,
    "QUICK STOP ACTIVE": DriveState.QUICK_STOP,
    "FAULT REACTION ACTIVE": DriveState.FAULT_REACTION,
    "FAULT": DriveState.FAULT,
}


def test_their_tables_of_states_and_transitions_say_the_same():
    assert {STATES[name]: mask for name, mask in State402.SW_MASK.items()} == {
        state: (state.mask, state.wanted) for state in DriveState
    }
    theirs = {
        (STATES[begin], STATES[end], Controlword(code).command)
        for (begin, end), code in State402.TRANSITIONTABLE.items()
        if begin in STATES
        and STATES[begin] not in (DriveState.NOT_READY, DriveState.FAULT_REACTION)
    }
    ours = {(row.begin, row.end, row.cause) for row in TRANSITIONS}
    assert len(theirs) == 13
    assert theirs <= ours
    assert all(Statusword(wanted).state is STATES[n] for n, (_, wanted) in State402.SW_MASK.items())


def test_their_abort_codes_are_among_ours():
    assert set(canopen.SdoAbortedError.CODES) == {int(code) for code in AbortCode}
