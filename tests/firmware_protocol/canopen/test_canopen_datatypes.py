"""The types of CANopen objects: values to bytes and back."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.canopen import (
    DataType,
)
from firmware_protocol.errors import BadField, RemoteProtocolError

WHOLE = [kind for kind in DataType if kind.limits]


@pytest.mark.parametrize(
    ("kind", "value", "text"),
    [
        (DataType.BOOLEAN, True, "01"),
        (DataType.I8, -1, "FF"),
        (DataType.I16, -2, "FE FF"),
        (DataType.I32, -100_000, "60 79 FE FF"),
        (DataType.U8, 255, "FF"),
        (DataType.U16, 0x6040, "40 60"),
        (DataType.U32, 0x60400010, "10 00 40 60"),
        (DataType.U24, 0x010203, "03 02 01"),
        (DataType.I64, -1, "FF FF FF FF FF FF FF FF"),
        (DataType.REAL32, 1.5, "00 00 C0 3F"),
        (DataType.REAL64, -2.0, "00 00 00 00 00 00 00 C0"),
        (DataType.VISIBLE_STRING, "arm", "61 72 6D"),
        (DataType.DOMAIN, b"\1\2", "01 02"),
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
    assert len(kind.pack(value)) * 8 == kind.bits
    for outside in (low - 1, high + 1):
        with pytest.raises(BadField):
            kind.pack(outside)


@given(st.floats(allow_nan=False))
def test_reals_come_back(value):
    assert DataType.REAL64.unpack(DataType.REAL64.pack(value)) == value


@pytest.mark.parametrize(
    ("kind", "value"),
    [
        (DataType.BOOLEAN, 1),
        (DataType.U8, True),
        (DataType.U8, 1.0),
        (DataType.REAL32, "1"),
        (DataType.REAL32, True),
        (DataType.REAL32, 1e300),
        (DataType.REAL64, 10**400),
        (DataType.VISIBLE_STRING, "Ärm"),
        (DataType.VISIBLE_STRING, b"arm"),
        (DataType.DOMAIN, "arm"),
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


@given(st.sampled_from(DataType), st.binary(max_size=12), st.booleans())
def test_any_bytes_have_a_value_or_say_why_not(kind, data, exact):
    try:
        value = kind.unpack(data, exact=exact)
    except RemoteProtocolError:
        assert kind.size != len(data)
        return
    if not isinstance(value, float) or not math.isnan(value):
        assert value == kind.unpack(data, exact=exact)


def test_what_has_no_fixed_size_is_not_mapped():
    assert [kind for kind in DataType if kind.bits is None] == [
        kind for kind in DataType if kind.size is None
    ]
    assert DataType.BOOLEAN.bits == 1
