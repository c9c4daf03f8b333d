"""SDO frames both ways: the bytes of each, and that all can be read back."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.canopen import (
    Abort,
    AbortCode,
    Place,
    abort_words,
)
from firmware_protocol.canopen.sdo import (
    Content,
    DownloadStarted,
    NextSegment,
    Segment,
    SegmentTaken,
    StartDownload,
    StartUpload,
    Upload,
    decode_request,
    decode_response,
    encode,
)
from firmware_protocol.errors import BadField, RemoteProtocolError

WORD, NAME = Place(0x6040), Place(0x1008)
REQUESTS = [
    (StartUpload(Place(0x1018, 1)), "40 18 10 01 00 00 00 00"),
    (StartDownload(Place(0x6060), Content(b"\1", 1)), "2F 60 60 00 01 00 00 00"),
    (StartDownload(WORD, Content(b"\x0f\0", 2)), "2B 40 60 00 0F 00 00 00"),
    (StartDownload(WORD, Content(b"\1\2\3", 3)), "27 40 60 00 01 02 03 00"),
    (StartDownload(Place(0x607A), Content(b"\x60\x79\xfe\xff", 4)), "23 7A 60 00 60 79 FE FF"),
    (StartDownload(WORD, Content(b"\x0f\0\0\0", None)), "22 40 60 00 0F 00 00 00"),
    (StartDownload(NAME, Content(None, 9)), "21 08 10 00 09 00 00 00"),
    (StartDownload(NAME, Content(None, None)), "20 08 10 00 00 00 00 00"),
    (NextSegment(False), "60 00 00 00 00 00 00 00"),
    (NextSegment(True), "70 00 00 00 00 00 00 00"),
    (Segment(False, b"armdriv", False), "00 61 72 6D 64 72 69 76"),
    (Segment(True, b"e!", True), "1B 65 21 00 00 00 00 00"),
    (Segment(False, b"", True), "0F 00 00 00 00 00 00 00"),
    (Abort(NAME, AbortCode.TIMED_OUT), "80 08 10 00 00 00 04 05"),
]
RESPONSES = [
    (Upload(Place(0x6041), Content(b"\x37\2", 2)), "4B 41 60 00 37 02 00 00"),
    (Upload(Place(0x6041), Content(b"\x37\2\0\0", None)), "42 41 60 00 37 02 00 00"),
    (Upload(NAME, Content(None, 9)), "41 08 10 00 09 00 00 00"),
    (Upload(NAME, Content(None, None)), "40 08 10 00 00 00 00 00"),
    (DownloadStarted(WORD), "60 40 60 00 00 00 00 00"),
    (Segment(True, b"e!", True), "1B 65 21 00 00 00 00 00"),
    (SegmentTaken(False), "20 00 00 00 00 00 00 00"),
    (SegmentTaken(True), "30 00 00 00 00 00 00 00"),
    (Abort(WORD, AbortCode.NO_OBJECT), "80 40 60 00 00 00 02 06"),
]
WAYS = [(decode_request, *row) for row in REQUESTS] + [(decode_response, *row) for row in RESPONSES]


@pytest.mark.parametrize(("decode", "message", "text"), WAYS)
def test_a_message_is_these_bytes(decode, message, text):
    assert encode(message) == bytes.fromhex(text)
    assert decode(bytes.fromhex(text)) == message


@given(st.sampled_from((decode_request, decode_response)), st.binary(max_size=9))
def test_any_bytes_have_a_meaning_that_is_kept_or_a_reason(decode, data):
    with contextlib.suppress(RemoteProtocolError):
        message = decode(data)
        assert decode(encode(message)) == message


@pytest.mark.parametrize(
    ("decode", "text", "reason"),
    [
        (decode_request, "40 18 10 01", "4 bytes where an SDO frame has 8"),
        (decode_request, "A0 08 10 00 00 00 00 00", "no SDO request begins with a0"),
        (decode_request, "C0 08 10 00 00 00 00 00", "no SDO request begins with c0"),
        (decode_response, "A0 08 10 00 00 00 00 00", "no SDO response begins with a0"),
        (decode_response, "", "0 bytes where an SDO frame has 8"),
    ],
)
def test_what_is_not_spoken_is_named(decode, text, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        decode(bytes.fromhex(text))


@pytest.mark.parametrize(
    "make",
    [
        lambda: Place(0x10000),
        lambda: Place(0, 256),
        lambda: Content(b"", 0),
        lambda: Content(b"12345", 5),
        lambda: Content(b"12", None),
        lambda: Content(b"12", 3),
        lambda: Content(None, -1),
        lambda: Segment(False, b"12345678", True),
        lambda: Abort(Place(0), -1),
    ],
)
def test_nonsense_of_ours_is_refused(make):
    with pytest.raises(BadField):
        make()


def test_every_abort_code_has_words_and_others_are_told_as_numbers():
    words = [code.words for code in AbortCode]
    assert all(words)
    assert len(set(words)) == len(AbortCode) == 31
    assert Abort(WORD, 0x06020000).words == "there is no such object"
    assert abort_words(0x12) == "abort code 00000012, which CiA 301 does not have"
    assert str(Place(0x1018, 1)) == "1018:01"
