"""CANopen messages, data types and objects."""

import contextlib

import pytest
from amounts import every_row
from eds_writer import write_eds
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.canopen import (
    CONTROLWORD,
    MODE,
    STANDARD,
    STATUSWORD,
    AbortCode,
    Access,
    DataType,
    Dictionary,
    Emergency,
    Heartbeat,
    HeartbeatWatch,
    Nmt,
    NmtCommand,
    NmtNode,
    NodeState,
    ObjectEntry,
    ObjectStore,
    Place,
    Service,
    Sync,
    cob_id,
    error_words,
    read_eds,
    service_of,
)
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.frames import Frame

VECTORS = [
    (Nmt(NmtCommand.START, 5), "000#0105"),
    (Nmt(NmtCommand.STOP), "000#0200"),
    (Nmt(NmtCommand.PRE_OPERATIONAL, 127), "000#807F"),
    (Nmt(NmtCommand.RESET_NODE, 1), "000#8101"),
    (Heartbeat(5, NodeState.BOOTING), "705#00"),
    (Heartbeat(127, NodeState.PRE_OPERATIONAL), "77F#7F"),
    (Sync(), "080#"),
    (Emergency(5, 0x8611, 0x21, b"\1\2\3\4\5"), "085#1186210102030405"),
    (Emergency(127, 0), "0FF#0000000000000000"),
]


@every_row("message, text", VECTORS)
def test_a_message_is_these_bytes(message, text):
    assert message.frame == Frame.parse(text)
    assert type(message).read(Frame.parse(text)) == message


@given(st.integers(0, 0x7FF), st.binary(max_size=8), st.booleans())
def test_any_frame_is_a_message_or_says_why_not(can_id, data, extended):
    for kind in (Nmt, Heartbeat, Sync, Emergency):
        with contextlib.suppress(RemoteProtocolError):
            message = kind.read(Frame(can_id, data, extended))
            assert (kind.read(message.frame), extended) == (message, False)


def test_an_id_belongs_to_one_service_and_node():
    whose = {cob_id(service): (service, 0) for service in Service if service.common}
    of_nodes = [service for service in Service if not service.common]
    whose |= {
        cob_id(service, node): (service, node) for service in of_nodes for node in range(1, 128)
    }
    assert len(whose) == 3 + 12 * 127
    assert {can_id: service_of(can_id) for can_id in range(0x800)} == {
        can_id: whose.get(can_id) for can_id in range(0x800)
    }


@every_row(
    "make, field",
    [
        (lambda: cob_id(Service.NMT, 1), "node"),
        (lambda: cob_id(Service.TPDO1), "node"),
        (lambda: cob_id(Service.TPDO1, 128), "node"),
        (lambda: cob_id("sdo", 1), "service"),
        (lambda: Nmt(NmtCommand.START, 128), "node"),
        (lambda: Nmt(1, 1), "command"),
        (lambda: Heartbeat(0, NodeState.STOPPED), "node"),
        (lambda: Heartbeat(1, 5), "state"),
        (lambda: Emergency(1, 0x10000), "code"),
        (lambda: Emergency(1, 0, 0, b"1234"), "detail"),
        (lambda: HeartbeatWatch(1, 0x10000), "silence_ms"),
    ],
)
def test_nonsense_of_ours_names_its_field(make, field):
    with pytest.raises(BadField) as caught:
        make()
    assert caught.value.field == field


@every_row(
    "kind, text, reason",
    [
        (Nmt, "000#0301", "no NMT order: 03 to 1"),
        (Nmt, "000#0180", "no NMT order: 01 to 128"),
        (Nmt, "000#01", "length 1 where 2 belong"),
        (Nmt, "00000000#0101", "no frame of nmt"),
        (Heartbeat, "701#06", "node 1 has no state 06"),
        (Heartbeat, "700#05", "no frame of heartbeat"),
        (Heartbeat, "701#R", "no frame of heartbeat"),
        (Sync, "080#0102", "length 2 where 0 to 1 belong"),
        (Emergency, "080#0000000000000000", "no frame of emcy"),
        (Emergency, "081#00", "length 1 where 8 belong"),
    ],
)
def test_nonsense_of_others_says_what_it_is(kind, text, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        kind.read(Frame.parse(text))


def test_the_toggle_bit_of_node_guarding_is_no_state():
    assert Heartbeat.read(Frame.parse("701#85")) == Heartbeat(1, NodeState.OPERATIONAL)


def test_a_device_is_told_whose_silence_it_is_to_mind():
    assert HeartbeatWatch(0x7F, 250).value == 0x007F_00FA
    assert HeartbeatWatch.of(0x007F_00FA) == HeartbeatWatch(0x7F, 250)
    assert HeartbeatWatch.of(0x007F_0000) is HeartbeatWatch.of(0x0000_00FA) is None
    assert HeartbeatWatch.of(0x0080_00FA) is None


@every_row(
    "code, words",
    [
        (0x8611, "following error"),
        (0x8612, "a reference limit was reached"),
        (0x8613, "positioning control"),
        (0x3211, "DC link voltage too high"),
        (0x32F0, "voltage inside the device"),
        (0x3A00, "voltage"),
        (0x0000, "no error any more"),
        (0x0042, "no error any more"),
        (0x0100, "an error code that CiA 301 and 402 do not have"),
        (0xA000, "an error code that CiA 301 and 402 do not have"),
    ],
)
def test_an_error_code_is_worded_as_closely_as_the_table_has_it(code, words):
    assert error_words(code) == Emergency(1, code).words == words
    assert Emergency(1, code).over is (words == "no error any more")


def test_a_node_obeys_what_is_for_it_or_for_all():
    node = NmtNode(5)
    assert node.receive_frame(Nmt(NmtCommand.START).frame) is None  # it boots
    assert not node.communicates
    assert node.booted() == Frame.parse("705#00")
    assert node.state is NodeState.PRE_OPERATIONAL
    assert node.receive_frame(Nmt(NmtCommand.START, 6).frame) is None
    assert node.communicates
    assert node.receive_frame(Nmt(NmtCommand.START, 5).frame) is NmtCommand.START
    assert node.heartbeat == Heartbeat(5, NodeState.OPERATIONAL)
    assert node.communicates
    assert node.receive_frame(Nmt(NmtCommand.STOP).frame) is NmtCommand.STOP
    assert not node.communicates
    assert node.receive_frame(Frame.parse("000#0505")) is None
    assert node.receive_frame(Nmt(NmtCommand.RESET_NODE).frame) is NmtCommand.RESET_NODE
    assert node.heartbeat.booted


# -- Data types ------------------------------------------------------------------------------------

WHOLE = [kind for kind in DataType if kind.limits]


@every_row(
    "kind, value, text",
    [
        (DataType.I8, -1, "FF"),
        (DataType.I16, -2, "FE FF"),
        (DataType.I32, -100_000, "60 79 FE FF"),
        (DataType.U8, 255, "FF"),
        (DataType.U16, 0x6040, "40 60"),
        (DataType.U32, 0x60400010, "10 00 40 60"),
        (DataType.VISIBLE_STRING, "arm", "61 72 6D"),
    ],
)
def test_a_value_is_these_bytes(kind, value, text):
    assert kind.pack(value) == bytes.fromhex(text)
    assert kind.unpack(bytes.fromhex(text)) == value


@given(st.sampled_from(WHOLE), st.data())
def test_every_whole_number_within_the_limits_comes_back_and_no_other_goes(kind, data):
    low, high = kind.limits
    value = data.draw(st.integers(low, high))
    assert kind.unpack(kind.pack(value)) == value
    assert len(kind.pack(value)) == kind.size
    for outside in (low - 1, high + 1):
        with pytest.raises(BadField):
            kind.pack(outside)


@every_row(
    "kind, value",
    [
        (DataType.U8, True),
        (DataType.U8, 1.0),
        (DataType.VISIBLE_STRING, "Ärm"),
        (DataType.VISIBLE_STRING, b"arm"),
    ],
)
def test_a_value_of_another_type_is_ours_to_mend(kind, value):
    with pytest.raises(BadField):
        kind.pack(value)


def test_a_length_that_was_told_must_be_right_and_one_that_was_not_may_be_more():
    assert DataType.I16.unpack(b"\xfe\xff\0\0", exact=False) == -2
    with pytest.raises(RemoteProtocolError, match="length 4 where I16 has 2"):
        DataType.I16.unpack(b"\xfe\xff\0\0")
    with pytest.raises(RemoteProtocolError, match="length 1 where I16 has 2"):
        DataType.I16.unpack(b"\xfe", exact=False)


NODE = 5


# -- Objects ---------------------------------------------------------------------------------------

EDS = """[FileInfo]
FileName=drive.eds
[OptionalObjects]
SupportedObjects=2
1=0x1400
[1400]
ParameterName=RPDO 1 communication
ObjectType=0x9
SubNumber=3
[1400sub1]
ParameterName=COB-ID
ObjectType=0x7
DataType=0x0007
AccessType=rw
PDOMapping=0
DefaultValue=$NODEID+0x200
[1400sub2]
ParameterName=Transmission type
ObjectType=0x7
DataType=0x0005
AccessType=rw
PDOMapping=0
[6060]
ParameterName=Modes of operation
ObjectType=0x7
DataType=0x0002
AccessType=rww
PDOMapping=1
DefaultValue=-1
Unit=V
[2000]
ParameterName=Curve
ObjectType=0x7
DataType=0x0009
AccessType=ro
PDOMapping=0
DefaultValue=a curve
"""


def test_a_drives_file_is_read():
    found = read_eds(EDS)
    assert [str(entry.place) for entry in found] == ["1400:01", "1400:02", "2000:00", "6060:00"]
    cob = found.find(Place(0x1400, 1))
    assert (cob.name, cob.initial(5), cob.access) == ("COB-ID", 0x205, Access.RW)
    assert found.find(Place(0x1400, 2)).default is None
    assert found.find(MODE) == ObjectEntry(
        MODE, "Modes of operation", DataType.I8, Access.RWW, "V", -1, mappable=True
    )
    assert found.find(Place(0x2000)).default == "a curve"


def test_the_standard_objects_are_written_and_read():
    assert [*read_eds(write_eds(STANDARD))] == [*STANDARD]
    assert STANDARD.find(CONTROLWORD).name == "Controlword"


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"default": 256}, "U8"),
        ({"default": "a"}, "U8"),
        ({"default": "Ä", "type": DataType.VISIBLE_STRING}, "VISIBLE_STRING"),
    ],
)
def test_an_entry_is_checked_when_it_is_made(change, field):
    values = {"place": MODE, "name": "a", "type": DataType.U8, "access": Access.RO} | change
    with pytest.raises(BadField) as caught:
        ObjectEntry(**values)
    assert caught.value.field == field


@every_row(
    "place, data, code",
    [
        (Place(0x7000), b"\0", AbortCode.NO_OBJECT),
        (Place(0x6040, 1), b"\0", AbortCode.NO_SUB_INDEX),
        (STATUSWORD, b"\0\0", AbortCode.READ_ONLY),
        (CONTROLWORD, b"\0", AbortCode.TOO_SHORT),
        (CONTROLWORD, b"\0\0\0", AbortCode.TOO_LONG),
        (CONTROLWORD, b"\x0f\0", None),
    ],
)
def test_a_store_refuses_by_the_dictionary(place, data, code):
    store = ObjectStore(STANDARD, NODE)
    assert store.write(place, data) is code
    assert store.value(CONTROLWORD) == (0 if code else 0x0F)


def test_a_store_tells_what_it_has_and_not_what_it_lacks():
    write_only = ObjectEntry(Place(0x2000), "key", DataType.U16, Access.WO)
    cob = ObjectEntry(Place(0x2002), "id", DataType.U32, Access.RO, default=0x180, adds_node=True)
    store = ObjectStore(Dictionary([*STANDARD, write_only, cob]), NODE)
    assert store.read(write_only.place) is AbortCode.WRITE_ONLY
    assert store.read(Place(0x6081)) is AbortCode.NO_DATA
    assert store.value(Place(0x6081)) is None
    assert store.value(cob.place) == 0x180 + NODE
    assert store.write(CONTROLWORD, b"\x0f\0\7\7", False) is None
    store.set(STATUSWORD, 0x237)
    assert (store.read(STATUSWORD), store.read(CONTROLWORD)) == (b"\x37\2", b"\x0f\0")
    with pytest.raises(BadField, match="7000:00"):
        store.set(Place(0x7000), 1)
