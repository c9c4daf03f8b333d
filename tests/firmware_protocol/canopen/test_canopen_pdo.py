"""PDOs: what they carry, and how a device is told to carry it."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from firmware_protocol import canopen
from firmware_protocol.errors import BadField, RemoteProtocolError

ORDER = canopen.Mapping.of_objects(canopen.STANDARD, canopen.CONTROLWORD, canopen.TARGET_POSITION)
STATE = canopen.Mapping.of_objects(canopen.STANDARD, canopen.STATUSWORD, canopen.POSITION)
FIXED = [kind for kind in canopen.DataType if kind.size in (1, 2, 4, 8) and kind.bits != 1]


def written(setup) -> list[str]:
    return [f"{each.place} {each.data[::-1].hex().upper()}" for each in setup.writes]


def test_a_target_and_its_controlword_are_these_bytes():
    assert [entry.word for entry in ORDER.entries] == [0x60400010, 0x607A0020]
    assert ORDER.pack((0x1F, -5000)) == bytes.fromhex("1F 00 78 EC FF FF")
    assert STATE.unpack(bytes.fromhex("37 12 78 EC FF FF")) == (0x1237, -5000)


def test_the_first_received_pdo_is_set_up_in_this_order():
    assert written(canopen.PdoSetup(canopen.Direction.RECEIVED, 1, 5, ORDER)) == [
        "1400:01 80000205",
        "1600:00 00",
        "1600:01 60400010",
        "1600:02 607A0020",
        "1600:00 02",
        "1400:02 01",
        "1400:01 00000205",
    ]


@pytest.mark.parametrize(
    ("direction", "ids"),
    [
        (canopen.Direction.TRANSMITTED, [0x185, 0x285, 0x385, 0x485]),
        (canopen.Direction.RECEIVED, [0x205, 0x305, 0x405, 0x505]),
    ],
)
def test_the_first_four_have_ids(direction, ids):
    assert [canopen.PdoSetup(direction, number, 5, STATE).frame_id for number in range(1, 5)] == ids


@given(st.lists(st.sampled_from(FIXED), min_size=1, max_size=8), st.data())
def test_what_is_packed_comes_out_and_what_is_behind_it_does_not_matter(kinds, data):
    entries = tuple(
        canopen.Mapped(canopen.Place(0x2000, sub), kind) for sub, kind in enumerate(kinds)
    )
    if sum(entry.size for entry in entries) > 8:
        with pytest.raises(BadField, match="objects of 1 to 8 bytes together"):
            canopen.Mapping(entries)
        return
    mapping = canopen.Mapping(entries)
    values = tuple(
        data.draw(st.integers(*kind.limits) if kind.limits else st.just(-0.5)) for kind in kinds
    )
    packed = mapping.pack(values)
    assert len(packed) == mapping.size
    assert mapping.unpack(packed + data.draw(st.binary(max_size=3))) == values
    with pytest.raises(RemoteProtocolError, match="where the PDO has"):
        mapping.unpack(packed[:-1])


def test_what_a_device_tells_of_its_mapping_is_read_by_the_dictionary():
    for entry in (*ORDER.entries, *STATE.entries):
        assert canopen.Mapped.of(entry.word, canopen.STANDARD) == entry
    with pytest.raises(RemoteProtocolError, match="2000:00 is mapped, and is no object"):
        canopen.Mapped.of(0x20000008, canopen.STANDARD)
    with pytest.raises(RemoteProtocolError, match="6040:00 is mapped with 8 bits; it is U16"):
        canopen.Mapped.of(0x60400008, canopen.STANDARD)


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: canopen.Mapped(canopen.CONTROLWORD, canopen.DataType.BOOLEAN), "type"),
        (lambda: canopen.Mapped(canopen.CONTROLWORD, canopen.DataType.U24), "type"),
        (lambda: canopen.Mapped(canopen.CONTROLWORD, canopen.DataType.DOMAIN), "type"),
        (lambda: canopen.Mapping(()), "entries"),
        (lambda: canopen.Mapping.of_objects(canopen.STANDARD, canopen.Place(0x6065)), "places"),
        (lambda: ORDER.pack((1,)), "values"),
        (lambda: ORDER.pack((0x10000, 0)), "U16"),
        (lambda: ORDER.pack((0, 0.5)), "I32"),
        (lambda: canopen.PdoSetup("RPDO", 1, 5, ORDER), "direction"),
        (lambda: canopen.PdoSetup(canopen.Direction.RECEIVED, 0, 5, ORDER), "number"),
        (lambda: canopen.PdoSetup(canopen.Direction.RECEIVED, 5, 5, ORDER), "number"),
        (lambda: canopen.PdoSetup(canopen.Direction.RECEIVED, 1, 0, ORDER), "node"),
        (lambda: canopen.PdoSetup(canopen.Direction.RECEIVED, 1, 5, ORDER, 241), "transmission"),
    ],
)
def test_nonsense_of_ours_names_its_field(make, field):
    with pytest.raises(BadField) as caught:
        make()
    assert caught.value.field == field
