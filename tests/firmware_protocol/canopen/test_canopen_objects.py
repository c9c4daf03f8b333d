"""Object dictionaries: the standard one, EDS files both ways, and values kept by their rules."""

import contextlib

import pytest
from canopen_bus import NODE
from eds_writer import write_eds
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol.canopen import (
    CONTROLWORD,
    MODE,
    STANDARD,
    STATUSWORD,
    TARGET_POSITION,
    AbortCode,
    Access,
    DataType,
    Dictionary,
    ObjectEntry,
    ObjectStore,
    Place,
    SdoClient,
    SdoServer,
    Uploaded,
    read_eds,
)
from firmware_protocol.errors import BadField, RemoteProtocolError

EDS = """\ufeff; a maker's file
[FileInfo]
FileName=drive.eds
[OptionalObjects]
SupportedObjects=2
1=0x1400
[1400]
ParameterName=RPDO 1	communication
ObjectType=0x9
SubNumber=2
[1400sub1]
ParameterName=COB-ID   ; the id
DataType=0x0007
AccessType=RW
DefaultValue=$NODEID+0x200
[6060]
parametername=Modes of operation
ObjectType=7
DataType=2
AccessType=rww
DefaultValue=0xFF
PDOMapping=1
[2000]
ParameterName=Curve
ObjectType=8
DataType=0x6
AccessType=rw
CompactSubObj=3
DefaultValue=010
Unit=%
[2001]
ParameterName=Own type
DataType=0x0040
AccessType=ro
"""


def test_a_makers_file_is_read():
    found = read_eds(EDS)
    assert [str(entry.place) for entry in found] == (
        ["1400:01", "2000:00", "2000:01", "2000:02", "2000:03", "2001:00", "6060:00"]
    )
    cob = found.find(Place(0x1400, 1))
    assert (cob.name, cob.initial(5), cob.access) == ("COB-ID", 0x205, Access.RW)
    assert found.find(MODE) == ObjectEntry(
        MODE, "Modes of operation", DataType.I8, Access.RWW, "", -1, mappable=True
    )
    assert found.find(Place(0x2000, 3)) == ObjectEntry(
        Place(0x2000, 3), "Curve 3", DataType.U16, Access.RW, "%", 10
    )
    assert found.find(Place(0x2001)).type is DataType.DOMAIN
    assert found.records == {0x1400: "RPDO 1 communication", 0x2000: "Curve"}


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("ParameterName=1", "this is no EDS file"),
        ("[6040]\nParameterName\n continued", "this is no EDS file"),
        ("[6040]\nObjectType=7", r"section \[6040\]: ParameterName is missing"),
        ("[6040]\nParameterName=a\nDataType=x", "DataType x is no whole number"),
        ("[6040]\nParameterName=a\nAccessType=maybe", "AccessType maybe is none"),
        ("[6040]\nParameterName=a\nDataType=5\nDefaultValue=256", "U8 must be a whole number"),
        ("[6040sub1]\nParameterName=a\nDataType=5\nDefaultValue=$NODEID+x", "DefaultValue x is"),
        ("[2000]\nParameterName=a\nDataType=5\nObjectType=8\nCompactSubObj=300", "U8 must be"),
    ],
)
def test_what_is_wrong_with_a_file_is_named(text, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        read_eds(text)


WORDS = st.text(st.characters(max_codepoint=0x17F), min_size=1, max_size=12).map(
    lambda text: "x" + "".join(c if c.isprintable() and c != ";" else "-" for c in text) + "."
)


@st.composite
def entries(draw):
    place = Place(
        draw(st.integers(0x1000, 0x1003) | st.integers(0, 0xFFFF)), draw(st.integers(0, 9))
    )
    kind = draw(st.sampled_from(DataType))
    values = {
        DataType.BOOLEAN: st.booleans(),
        DataType.REAL32: st.floats(width=32, allow_nan=False),
        DataType.REAL64: st.floats(allow_nan=False),
        DataType.VISIBLE_STRING: WORDS.filter(str.isascii),
    }
    value = values.get(kind, st.binary(min_size=1, max_size=9))
    if kind.limits:
        value = st.integers(*kind.limits)
    default = draw(st.none() | value)
    adds = kind.limits is not None and default is not None and 0 <= default <= 0xFFFF_FFFF
    return ObjectEntry(
        place,
        draw(WORDS),
        kind,
        draw(st.sampled_from(Access)),
        draw(st.just("") | WORDS),
        default,
        draw(st.booleans()),
        adds and draw(st.booleans()),
    )


@given(st.lists(entries(), max_size=8, unique_by=lambda entry: entry.place), WORDS)
def test_what_is_written_is_read(found, name):
    dictionary = Dictionary(found, {0x1000: name})
    assert read_eds(write_eds(dictionary, product=name)) == dictionary


def test_blanks_within_a_name_are_kept():
    dictionary = Dictionary([ObjectEntry(MODE, "two  blanks", DataType.U8, Access.RO)])
    assert read_eds(write_eds(dictionary)) == dictionary


def test_what_has_sub_indices_has_a_section_of_its_own_though_nobody_named_it():
    watch = STANDARD.find(Place(0x1016, 1))
    assert f"[1016]\nParameterName={watch.name}\n" in write_eds(Dictionary([watch]))


def test_the_standard_objects_are_written_and_read():
    assert read_eds(write_eds(STANDARD)) == STANDARD
    assert STANDARD.find(CONTROLWORD).name == "Controlword"


@given(st.text(max_size=200) | st.lists(st.sampled_from(EDS.splitlines())).map("\n".join))
def test_any_text_is_a_dictionary_or_says_why_not(text):
    with contextlib.suppress(RemoteProtocolError):
        dictionary = read_eds(text)
        assert read_eds(write_eds(dictionary)) == dictionary


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"name": ""}, "name"),
        ({"name": "two\nlines"}, "name"),
        ({"name": "a ;b"}, "name"),
        ({"unit": " mm"}, "unit"),
        ({"default": 256}, "U8"),
        ({"default": b""}, "default"),
        ({"adds_node": True}, "default"),
    ],
)
def test_an_entry_is_checked_when_it_is_made(change, field):
    values = {"place": MODE, "name": "a", "type": DataType.U8, "access": Access.RO} | change
    with pytest.raises(BadField) as caught:
        ObjectEntry(**values)
    assert caught.value.field == field


def test_a_dictionary_has_one_object_a_place():
    entry = ObjectEntry(MODE, "a", DataType.U8, Access.RO)
    with pytest.raises(BadField, match="6060:00"):
        Dictionary([entry, entry])


@pytest.mark.parametrize(
    ("place", "data", "code"),
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
    text = ObjectEntry(Place(0x2001), "name", DataType.VISIBLE_STRING, Access.RW)
    cob = ObjectEntry(Place(0x2002), "id", DataType.U32, Access.RO, default=0x180, adds_node=True)
    store = ObjectStore(Dictionary([*STANDARD, write_only, text, cob]), NODE)
    assert store.read(write_only.place) is AbortCode.WRITE_ONLY
    assert store.read(Place(0x6081)) is AbortCode.NO_DATA
    assert store.value(Place(0x6081)) is None
    assert store.value(cob.place) == 0x180 + NODE
    assert store.write(CONTROLWORD, b"\x0f\0\7\7", exact=False) is None
    assert store.write(text.place, b"\xff") is AbortCode.VALUE
    store.set(STATUSWORD, 0x237)
    assert (store.read(STATUSWORD), store.read(CONTROLWORD)) == (b"\x37\2", b"\x0f\0")
    store.restore()
    assert store.value(STATUSWORD) == 0
    with pytest.raises(BadField, match="7000:00"):
        store.set(Place(0x7000), 1)


def test_a_store_answers_for_a_server():
    client, server, store = SdoClient(NODE), SdoServer(NODE), ObjectStore(STANDARD, NODE)
    data = DataType.I32.pack(-5000)
    for request in (
        lambda: client.download(TARGET_POSITION, data),
        lambda: client.upload(TARGET_POSITION),
    ):
        server.receive_frame(request())
        client.receive_frame(store.answer(server, server.next_event()))
    server.receive_frame(client.upload(Place(0x7000)))
    client.receive_frame(store.answer(server, server.next_event()))
    server.receive_frame(client.download(STATUSWORD, b"\0\0"))
    client.receive_frame(store.answer(server, server.next_event()))
    found = list(iter(client.next_event, None))[1:]
    assert found[0] == Uploaded(TARGET_POSITION, data)
    assert [event.code for event in found[1:]] == [AbortCode.NO_OBJECT, AbortCode.READ_ONLY]
