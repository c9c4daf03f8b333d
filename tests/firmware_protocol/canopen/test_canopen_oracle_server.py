"""Our SDO server and our drive, asked by the master of the package `canopen`."""

from types import SimpleNamespace

import pytest

canopen = pytest.importorskip("canopen")

import can  # noqa: E402
from canopen.profiles.p402 import BaseNode402  # noqa: E402
from canopen_peer import (  # noqa: E402
    CYCLE_S,
    DICTIONARY,
    NAME,
    NODE,
    PATIENCE_S,
    send,
    their_dictionary,
    virtual_bus,
)

from firmware_protocol.canopen import (  # noqa: E402
    CONTROLWORD,
    PROFILE_SPEED,
    STANDARD,
    STATUSWORD,
    TARGET_POSITION,
    AbortCode,
    Controlword,
    Direction,
    DriveDevice,
    DriveState,
    Happening,
    Mapping,
    NmtNode,
    NodeState,
    ObjectStore,
    PdoSetup,
    Place,
    ReadAsked,
    SdoServer,
    WriteAsked,
)
from firmware_protocol.frames import Frame  # noqa: E402


@pytest.fixture
def bus():
    with virtual_bus() as found:
        yield found


@pytest.fixture
def device(bus):
    """Have our end be a drive that answers whatever their master asks."""
    server, store, drive = SdoServer(NODE), ObjectStore(DICTIONARY, NODE), DriveDevice()
    drive.happen(Happening.INITIALISED)

    def take(message) -> None:
        frame = Frame(message.arbitration_id, bytes(message.data))
        send(bus, server.receive_frame(frame))
        for asked in iter(server.next_event, None):
            store.set(STATUSWORD, drive.statusword().value)
            if isinstance(asked, ReadAsked | WriteAsked):
                send(bus, store.answer(server, asked))
            if isinstance(asked, WriteAsked) and asked.place == CONTROLWORD:
                drive.control(Controlword(store.value(CONTROLWORD)))

    notifier = can.Notifier(bus.ours, [take], timeout=CYCLE_S)
    yield SimpleNamespace(store=store, drive=drive)
    notifier.stop()


@pytest.fixture
def master(bus, device):
    node = BaseNode402(NODE, their_dictionary())
    bus.network.add_node(node)
    node.sdo.RESPONSE_TIMEOUT = PATIENCE_S
    node.TIMEOUT_SWITCH_STATE_SINGLE = node.TIMEOUT_SWITCH_STATE_FINAL = PATIENCE_S
    return node


@pytest.mark.parametrize("size", [1, 4, 5, 7, 8, 14, 100])
def test_their_client_writes_to_and_reads_from_our_server(master, device, size):
    name = "armdrive!".ljust(size, "x")[:size]
    device.store.set(NAME, name)
    assert master.sdo["Device name"].raw == name
    master.sdo["Target position"].raw = -5000 - size
    assert device.store.value(TARGET_POSITION) == -5000 - size
    assert master.sdo["Target position"].raw == -5000 - size


# from Python 3.13 on, the stream that could not be opened complains when it is closed
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_their_client_understands_why_our_server_refuses(master):
    refused = {
        Place(0x7000): AbortCode.NO_OBJECT,
        Place(0x1018, 9): AbortCode.NO_SUB_INDEX,
        PROFILE_SPEED: AbortCode.NO_DATA,
    }
    for place, code in refused.items():
        with pytest.raises(canopen.SdoAbortedError) as caught:
            master.sdo.upload(place.index, place.sub)
        assert caught.value.code == code
    with pytest.raises(canopen.SdoAbortedError) as caught:
        master.sdo.download(STATUSWORD.index, 0, b"\0\0")
    assert caught.value.code == AbortCode.READ_ONLY
    with pytest.raises(canopen.SdoAbortedError) as caught:
        master.sdo["Device name"].raw = "armdrive!"
    assert caught.value.code == AbortCode.TOO_LONG
    with pytest.raises(canopen.SdoAbortedError) as caught:
        master.sdo["Device name"].open("wb", block_transfer=True, size=9)
    assert caught.value.code == AbortCode.COMMAND


def test_their_client_gets_a_pdo_set_up_as_ours_does(master, device):
    theirs = master.rpdo[1]
    theirs.cob_id, theirs.trans_type, theirs.enabled, theirs.rtr_allowed = 0x205, 1, True, True
    theirs.clear()
    theirs.add_variable("Controlword")
    theirs.add_variable("Target position")
    theirs.save()
    setup = PdoSetup(
        Direction.RECEIVED, 1, NODE, Mapping.of_objects(STANDARD, CONTROLWORD, TARGET_POSITION)
    )
    final = {write.place: write.value for write in setup.writes}
    assert {place: device.store.value(place) for place in final} == final


def test_their_profile_enables_our_drive_and_disables_it_again(master, device):
    assert master.state == "SWITCH ON DISABLED"
    master.state = "OPERATION ENABLED"
    assert device.drive.state is DriveState.ENABLED
    master.state = "SWITCH ON DISABLED"
    assert device.drive.state is DriveState.DISABLED


def test_our_node_obeys_their_master_and_they_hear_its_heartbeat(bus, master):
    ours, heard = NmtNode(NODE), []
    master.nmt.add_heartbeat_callback(heard.append)
    bus.network.notify(0x700 + NODE, bytearray(ours.booted().data), 0.0)
    with can.Bus(bus.ours.channel_id, interface="virtual") as watching:
        for order, state in (
            ("OPERATIONAL", NodeState.OPERATIONAL),
            ("STOPPED", NodeState.STOPPED),
            ("PRE-OPERATIONAL", NodeState.PRE_OPERATIONAL),
        ):
            master.nmt.state = order
            message = watching.recv(PATIENCE_S)
            ours.receive_frame(Frame(message.arbitration_id, bytes(message.data)))
            assert ours.state is state
            bus.network.notify(0x700 + NODE, bytearray(ours.heartbeat.frame.data), 0.0)
            assert master.nmt.state == order
    assert heard == [0x00, 0x05, 0x04, 0x7F]
