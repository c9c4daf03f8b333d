"""An SDO client and a server wired back to back, on good buses and bad ones."""

from canopen_bus import SdoBus
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol.canopen import (
    AbortCode,
    Aborted,
    Downloaded,
    Place,
    Uploaded,
)

PLACE, OTHER = Place(0x1008), Place(0x1009, 3)
DATA = st.binary(max_size=60)
COPIES = st.sampled_from((1, 1, 1, 1, 0, 2, 3))


@given(DATA, DATA)
def test_what_is_written_is_read(data, other):
    bus = SdoBus({OTHER: other})
    assert bus.download(PLACE, data) == [Downloaded(PLACE)]
    assert bus.upload(PLACE) == [Uploaded(PLACE, data)]
    assert bus.upload(OTHER) == [Uploaded(OTHER, other)]
    assert bus.client.busy is None


def test_what_is_not_there_is_refused_in_words():
    (event,) = SdoBus().upload(PLACE)
    assert event == Aborted(PLACE, AbortCode.NO_OBJECT, by_server=True)
    assert event.words == "there is no such object"


def transfer(bus, data, reads):
    if reads:
        bus.objects[PLACE] = data
        return bus.upload(PLACE)
    return bus.download(PLACE, data)


@settings(max_examples=60)
@given(DATA, st.booleans(), st.data())
def test_a_bus_that_loses_and_repeats_never_makes_a_transfer_end_well_with_wrong_data(
    data, reads, chance
):
    bus = SdoBus(copies=lambda: chance.draw(COPIES))
    ended = transfer(bus, data, reads)
    if bus.client.busy:
        assert ended == []
    elif not isinstance(ended[0], Aborted):
        assert ended == [Uploaded(PLACE, data) if reads else Downloaded(PLACE)]
        assert bus.objects[PLACE] == data


@settings(max_examples=60)
@given(DATA, st.booleans(), st.data())
def test_after_any_mess_the_next_transfer_goes_well(data, reads, chance):
    faulty = [True]
    bus = SdoBus(
        copies=lambda: chance.draw(COPIES) if faulty[0] else 1,
        overtakes=lambda: faulty[0] and chance.draw(st.booleans()),
    )
    ended = transfer(bus, data, reads)
    assert len(ended) == (bus.client.busy is None)
    bus.say(bus.client.abandon())
    bus.run()
    faulty[0] = False
    assert bus.client.busy is None
    assert bus.client.abandon() is None
    assert bus.download(OTHER, data) == [Downloaded(OTHER)]
    assert bus.upload(OTHER) == [Uploaded(OTHER, data)]
