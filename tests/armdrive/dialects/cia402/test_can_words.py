"""Frames of CANopen drives are told in words, on a bus and in a recording."""

import pytest
from amounts import every_row
from hypothesis import given
from hypothesis import strategies as st

from armdrive.dialects.bus.words import FrameKind, PackedFrames
from armdrive.dialects.cia402 import words as messages_canopen
from armdrive.dialects.cia402.objects import held_words
from armdrive.dialects.cia402.words import CanopenFrameDescriber
from armdrive.dialects.words import Weight
from armdrive.registry import DIALECTS, LANGUAGES, language_of, likely
from firmware_protocol.canopen import (
    ALL_NODES,
    CONSUMER_HEARTBEAT,
    CONTROLWORD,
    DEVICE_TYPE,
    MODE,
    POSITION,
    SPEED_UNIT,
    STATUSWORD,
    SUPPORTED_MODES,
    TARGET_POSITION,
    AbortCode,
    Emergency,
    Heartbeat,
    Nmt,
    NmtCommand,
    NodeState,
    Place,
    SdoClient,
    SdoServer,
    Service,
    Sync,
    cob_id,
)
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import ReadEncoder, encode

REQUEST, ANSWER, UNKNOWN = FrameKind.REQUEST, FrameKind.ANSWER, FrameKind.UNKNOWN
NAME = Place(0x1008)


def write(node, place, data):
    return SdoClient(node).download(place, data)


def answer(node, place, data):
    """Return the answer to a question for an object: its data, in one frame or the first of some.

    `data` may be the reason why it is refused.
    """
    server = SdoServer(node, lambda _place: data, lambda *_: None)
    return server.receive_frame(SdoClient(node).upload(place))


def pdo(service, node, text):
    return Frame(cob_id(service, node), bytes.fromhex(text))


CONVERSATION = (
    (Nmt(NmtCommand.START, ALL_NODES).frame, REQUEST, "all: start: become operational"),
    (Nmt(NmtCommand.RESET_NODE, 3).frame, REQUEST, "node 3: restart"),
    (Heartbeat(3, NodeState.BOOTING).frame, ANSWER, "node 3: boot-up: it has restarted"),
    (Heartbeat(127, NodeState.OPERATIONAL).frame, ANSWER, "node 127: heartbeat: operational"),
    (Sync().frame, REQUEST, "SYNC"),
    (Frame(0x80, b"\7"), REQUEST, "SYNC"),
    (Emergency(2, 0x8611, 0x21).frame, ANSWER,
     "node 2: EMCY 8611, following error (generic, device profile)"),
    (Emergency(2, 0x8130, 0x11, b"\x01" * 5).frame, ANSWER,
     "EMCY 8130, a heartbeat or life guard is missing (generic, communication), the maker's 01"),
    (Emergency(2, 0).frame, ANSWER, "node 2: EMCY 0000, no error any more"),
    (SdoClient(1).upload(STATUSWORD), REQUEST, "node 1: read 6041:00 Statusword"),
    (answer(1, STATUSWORD, b"\x37\x06"), ANSWER,
     "node 1: 6041:00 Statusword: 0637 enabled, target reached"),
    (write(1, MODE, b"\x08"), REQUEST,
     "node 1: write 6060:00 Modes of operation: 8, cyclic position"),
    (write(1, CONSUMER_HEARTBEAT, (127 << 16 | 200).to_bytes(4, "little")), REQUEST,
     "node 1: write 1016:01 Consumer heartbeat time: node 127 within 200 ms"),
    (write(1, Place(0x1600, 2), bytes.fromhex("08006060")), REQUEST,
     "node 1: write 1600:02 RPDO1 object 2: 6060:00 Modes of operation, 8 bits"),
    (write(1, Place(0x1801, 1), bytes.fromhex("81020080")), REQUEST,
     "node 1: write 1801:01 TPDO2 COB-ID: 281, switched off"),
    (answer(1, Place(0x60C2, 1), AbortCode.NO_OBJECT), ANSWER,
     "node 1: 60C2:01 Interpolation time period value aborted: there is no such object"),
    (answer(1, Place(0x2031, 4), b"\x01\x02"), ANSWER, "node 1: 2031:04: 01 02"),
    (pdo(Service.RPDO1, 4, "0F 00 08 10 27 00 00"), REQUEST,
     "node 4: 000F enable operation; mode 8, cyclic position; target 10000"),
    (pdo(Service.TPDO1, 4, "37 12 08 F0 D8 FF FF"), ANSWER,
     "node 4: 1237 enabled, acknowledged; mode 8, cyclic position; at -10000"),
    (pdo(Service.RPDO1, 4, "3F 00 06 00 00 00 00"), REQUEST,
     "node 4: 003F enable operation, new set-point or go home, at once; mode 6, homing; target 0"),
    (pdo(Service.TPDO1, 4, "37 22 06 00 00 00 00"), ANSWER,
     "node 4: 2237 enabled, following or homing error; mode 6, homing; at 0"),
    (pdo(Service.TPDO1, 4, "08 02"), ANSWER, "node 4: 0208 fault"),
    # what bits of motion were left at means nothing while a drive has no current
    (pdo(Service.TPDO1, 4, "50 16"), ANSWER, "node 4: 1650 disabled"),
    (pdo(Service.TPDO1, 4, "37 06 08 00 00 00 00"), ANSWER,
     "node 4: 0637 enabled, target reached; mode 8, cyclic position; at 0"),
    (pdo(Service.TPDO2, 4, "40 00 00"), ANSWER, "0040 disabled, not remote: it does not"),
    (pdo(Service.TPDO4, 4, "01 02"), ANSWER, "node 4: TPDO4 01 02"),
    (Frame(0x183, b"\x01\x02\x03"), ANSWER, "node 3: TPDO1 01 02 03"),
    (Frame(0x7E5, bytes(8)), UNKNOWN, "not of CANopen's predefined ids (its id)"),
    (Frame(0x583, b"\x01"), UNKNOWN, "perhaps sdo response: length 1 where an SDO frame has 8"),
    (Frame(0x701, b"\x33"), UNKNOWN, "perhaps heartbeat: node 1 has no state 33"),
    (Frame(0x123, b"", extended=True), UNKNOWN, "(extended)"),
    (Frame(5, b"", remote=True), UNKNOWN, "(remote)"),
)  # fmt: skip


@every_row("frame, kind, words", CONVERSATION)
def test_a_frame_is_described_in_words(frame, kind, words):
    said = CanopenFrameDescriber().describe(frame)
    assert said.kind is kind
    assert said.words == words or ("node" not in words and words in said.words)
    assert str(frame) in said.line(1.5)


def test_segments_are_described_with_their_object():
    client, describer = SdoClient(5), CanopenFrameDescriber()
    server = SdoServer(5, lambda _place: b"stepper 5", lambda *_: None)
    frame, said = client.upload(NAME), []
    for _ in range(6):
        said.append(describer.describe(frame))
        reply = server.receive_frame(frame)
        said.append(describer.describe(reply))
        frame = client.receive_frame(reply)
        if frame is None:
            break
    name = "1008:00 Manufacturer device name"
    assert [each.words for each in said] == [
        f"node 5: read {name}",
        f"node 5: {name}: begins, 9 bytes",
        f"node 5: the next segment, of {name}",
        f"node 5: segment 'stepper', of {name}",
        f"node 5: the next segment, of {name}",
        f"node 5: segment ' 5', the last, of {name}",
    ]


def test_plain_data_has_the_node_of_a_frame():
    view = CanopenFrameDescriber().describe(pdo(Service.TPDO1, 6, "4002")).view(0.25)
    assert view == {
        "time_s": 0.25,
        "id": 0x186,
        "node": 6,
        "frame": "186#4002",
        "kind": "answer",
        "command": "tpdo1",
        "words": "node 6: 0240 disabled",
    }


HELD = (
    (SPEED_UNIT, 0x00B4_4700, "00B44700 (rpm)"),
    (DEVICE_TYPE, 0x0004_0192, "CiA 402, a drive (stepper)"),
    (DEVICE_TYPE, 0x0000_0191, "CiA 401, an I/O module"),
    (DEVICE_TYPE, 0x0000_0123, "CiA 291, a device of an unknown profile"),
    (SUPPORTED_MODES, 0xA1, "profile position, homing, cyclic position"),
    (Place(0x1001), 0, "no error"),
    (Place(0x603F), 0x3220, "3220, DC link voltage too low"),
    (Place(0x605A), 6, "6, quick ramp and stay"),
    (Place(0x6007), 3, "3, quick stop"),
    (MODE, -1, "-1, one of the maker's"),
    (POSITION, -5, "-5 inc"),
    (TARGET_POSITION, 7, "7 inc"),
    (CONTROLWORD, 0x80, "0080 fault reset"),
)


@every_row("place, value, words", HELD)
def test_the_content_of_an_object_is_described_in_words(place, value, words):
    data = value.to_bytes(4, "little", signed=value < 0)
    assert held_words(place, data) == words


frames = st.builds(
    Frame, st.integers(0, 0x7FF), st.binary(max_size=8), st.booleans(), st.just(False)
)


@given(st.lists(frames, max_size=20))
def test_nothing_on_a_bus_confuses_the_ear_for_good(noise):
    describer = CanopenFrameDescriber()
    for frame in noise:
        said = describer.describe(frame)
        assert said.frame == frame
        assert said.words
    assert (
        describer.describe(Heartbeat(9, NodeState.STOPPED).frame).words
        == "node 9: heartbeat: stopped"
    )


def test_every_dialect_of_a_bus_has_its_language():
    of_a_bus = {name for name, row in DIALECTS.items() if row.can}
    assert {DIALECTS[name].language.name for name in of_a_bus} == set(LANGUAGES)
    assert language_of("cia402").name == "canopen"
    assert language_of("mks").name == language_of("grbl").name == "mks"


def test_the_language_of_some_frames_is_the_one_that_reads_the_most():
    beat = Heartbeat(5, NodeState.OPERATIONAL).frame
    assert likely([beat, Sync().frame]).name == "canopen"
    assert likely([encode(2, ReadEncoder()), beat, encode(3, ReadEncoder())]).name == "mks"
    assert likely([]).name == "mks"


# -- in a recording ------------------------------------------------------------------------------


def test_equal_messages_to_several_nodes_are_grouped():
    data = b"".join(pack(pdo(Service.RPDO1, node, "0600")) for node in (1, 2, 3))
    words = messages_canopen.words(data + pack(Sync().frame))
    assert words == "1 2 3: 0006 shut down; SYNC"
    assert messages_canopen.words(pack(Nmt(NmtCommand.STOP).frame)).startswith("all: stop")
    with pytest.raises(RemoteProtocolError):
        messages_canopen.words(b"\x01")
    with pytest.raises(RemoteProtocolError):
        messages_canopen.words(pack(Frame(0x7E5)))


WEIGHTS = (
    (Heartbeat(1, NodeState.BOOTING).frame, Weight.BANNER),
    (Heartbeat(1, NodeState.OPERATIONAL).frame, Weight.PASSING),
    (pdo(Service.TPDO1, 1, "2702"), Weight.PASSING),
    (answer(1, POSITION, bytes(4)), Weight.PASSING),
    (answer(1, NAME, b"abc"), Weight.SELF),
    (answer(1, MODE, b"\x08"), Weight.MOMENT),
    (answer(1, MODE, AbortCode.NO_OBJECT), Weight.MOMENT),
    (Emergency(1, 0x8611).frame, Weight.MOMENT),
    (Frame(0x7E5), Weight.ANSWER),
)


@every_row("frame, weight", WEIGHTS)
def test_comparable_messages_have_a_weight(frame, weight):
    (message,) = PackedFrames(messages_canopen.weighed).feed(pack(frame))
    assert message.weight is weight
    assert message.data == pack(frame)


def test_messages_of_a_kind_are_distinguished_by_node_and_object():
    frames = (answer(1, MODE, b"\x08"), answer(2, MODE, b"\x08"), answer(1, CONTROLWORD, bytes(2)))
    kinds = {messages_canopen.weighed(frame).kind for frame in frames}
    assert len(kinds) == 3
    assert messages_canopen.weighed(answer(1, MODE, b"\x01")).kind in kinds
