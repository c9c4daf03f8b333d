"""NMT, heartbeat, SYNC and EMCY: the frames of each, both ways, and what they mean."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.canopen import (
    Emergency,
    Heartbeat,
    HeartbeatWatch,
    Nmt,
    NmtCommand,
    NmtNode,
    NodeState,
    Service,
    Sync,
    cob_id,
    error_words,
    service_of,
)
from firmware_protocol.errors import BadField, RemoteProtocolError
from firmware_protocol.frames import Frame

NODES = st.integers(1, 127)
VECTORS = [
    (Nmt(NmtCommand.START, 5), "000#0105"),
    (Nmt(NmtCommand.STOP), "000#0200"),
    (Nmt(NmtCommand.PRE_OPERATIONAL, 127), "000#807F"),
    (Nmt(NmtCommand.RESET_NODE, 1), "000#8101"),
    (Nmt(NmtCommand.RESET_COMMUNICATION, 1), "000#8201"),
    (Heartbeat(5, NodeState.BOOTING), "705#00"),
    (Heartbeat(127, NodeState.STOPPED), "77F#04"),
    (Heartbeat(1, NodeState.OPERATIONAL), "701#05"),
    (Heartbeat(1, NodeState.PRE_OPERATIONAL), "701#7F"),
    (Sync(), "080#"),
    (Sync(240), "080#F0"),
    (Emergency(5, 0x8611, 0x21, b"\1\2\3\4\5"), "085#1186210102030405"),
    (Emergency(127, 0), "0FF#0000000000000000"),
]


@pytest.mark.parametrize(("message", "text"), VECTORS)
def test_a_message_is_these_bytes(message, text):
    assert message.frame == Frame.parse(text)
    assert type(message).read(Frame.parse(text)) == message


@given(
    st.one_of(
        st.builds(Nmt, st.sampled_from(NmtCommand), st.integers(0, 127)),
        st.builds(Heartbeat, NODES, st.sampled_from(NodeState)),
        st.builds(Sync, st.none() | st.integers(1, 240)),
        st.builds(
            Emergency,
            NODES,
            st.integers(0, 0xFFFF),
            st.integers(0, 255),
            st.binary(min_size=5, max_size=5),
        ),
    )
)
def test_every_message_can_be_read(message):
    assert type(message).read(message.frame) == message


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


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: cob_id(Service.NMT, 1), "node"),
        (lambda: cob_id(Service.TPDO1), "node"),
        (lambda: cob_id(Service.TPDO1, 128), "node"),
        (lambda: cob_id("sdo", 1), "service"),
        (lambda: Nmt(NmtCommand.START, 128), "node"),
        (lambda: Nmt(1, 1), "command"),
        (lambda: Heartbeat(0, NodeState.STOPPED), "node"),
        (lambda: Heartbeat(1, 5), "state"),
        (lambda: Sync(0), "counter"),
        (lambda: Emergency(1, 0x10000), "code"),
        (lambda: Emergency(1, 0, 0, b"1234"), "detail"),
        (lambda: HeartbeatWatch(1, 0x10000), "silence_ms"),
    ],
)
def test_nonsense_of_ours_names_its_field(make, field):
    with pytest.raises(BadField) as caught:
        make()
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("kind", "text", "reason"),
    [
        (Nmt, "000#0301", "no NMT order: 03 to 1"),
        (Nmt, "000#0180", "no NMT order: 01 to 128"),
        (Nmt, "000#01", "length 1 where 2 belong"),
        (Nmt, "00000000#0101", "no frame of nmt"),
        (Heartbeat, "701#06", "node 1 has no state 06"),
        (Heartbeat, "700#05", "no frame of heartbeat"),
        (Heartbeat, "701#R", "no frame of heartbeat"),
        (Sync, "080#00", "counter must be"),
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


@pytest.mark.parametrize(
    ("code", "words"),
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


def test_an_emergency_says_what_it_is_about_and_when_it_is_over():
    broken = Emergency(1, 0x8130, 0x51)
    assert [broken.over, Emergency(1, 0x0001).over] == [False, True]


def test_a_node_obeys_what_is_for_it_or_for_all():
    node = NmtNode(5)
    assert node.receive_frame(Nmt(NmtCommand.START).frame) is None  # it boots
    assert node.booted() == Frame.parse("705#00")
    assert node.state is NodeState.PRE_OPERATIONAL
    assert node.receive_frame(Nmt(NmtCommand.START, 6).frame) is None
    assert (node.takes("sdo"), node.takes("pdo")) == (True, False)
    assert node.receive_frame(Nmt(NmtCommand.START, 5).frame) is NmtCommand.START
    assert node.heartbeat == Heartbeat(5, NodeState.OPERATIONAL)
    assert node.takes("pdo")
    assert node.receive_frame(Nmt(NmtCommand.STOP).frame) is NmtCommand.STOP
    assert not node.takes("sdo")
    assert node.receive_frame(Frame.parse("000#0505")) is None
    assert node.receive_frame(Nmt(NmtCommand.RESET_NODE).frame) is NmtCommand.RESET_NODE
    assert node.heartbeat.booted
