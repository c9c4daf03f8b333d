"""SDO: what passes on the bus, a client, a server, and both on a bus that loses frames."""

import contextlib
import random
from collections import deque

import pytest
from amounts import amount, every_row
from chunks import events
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol import canopen
from firmware_protocol.canopen import AbortCode, Aborted, Place, Uploaded
from firmware_protocol.canopen.sdo import (
    SIZE_MAX,
    Content,
    DownloadStarted,
    Segment,
    SegmentTaken,
    StartDownload,
    decode_request,
    decode_response,
    encode,
)
from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError
from firmware_protocol.frames import Frame

NODE = 5
NAME, WORD = Place(0x1008), Place(0x6040)


class Objects:
    """Objects by their places; those that are not there are refused."""

    def __init__(self, values=None) -> None:
        self.values = dict(values or {})
        self.exact = []

    def read(self, place):
        return self.values.get(place, AbortCode.NO_OBJECT)

    def write(self, place, data, exact):
        self.values[place] = data
        self.exact.append(exact)
        return AbortCode.VALUE if data == b"\xee" else None

    def server(self):
        return canopen.SdoServer(NODE, self.read, self.write)


def told(machine, *texts) -> list[str]:
    """Feed frames, and return what the machine says to each."""
    answers = [machine.receive_frame(Frame.parse(text)) for text in texts]
    return ["" if answer is None else str(answer) for answer in answers]


def reading(place=NAME) -> canopen.SdoClient:
    client = canopen.SdoClient(NODE)
    client.upload(place)
    return client


# -- the client -----------------------------------------------------------------------------------


def test_a_client_reads_in_segments_and_takes_a_repeated_one_once():
    client = canopen.SdoClient(NODE)
    assert str(client.upload(NAME)) == "605#4008100000000000"
    answers = told(client, "585#4108100009000000", "585#0061726D64726976", "585#0061726D64726976",
                   "585#1B65210000000000")  # fmt: skip
    assert answers == ["605#6000000000000000", "605#7000000000000000", "", ""]
    assert [type(each) for each in events(client)] == [canopen.StrayResponse, Uploaded]


def test_a_client_writes_a_number_in_one_frame_and_one_thing_at_a_time():
    client = canopen.SdoClient(NODE)
    assert str(client.download(WORD, b"\x0f\0")) == "605#2B4060000F000000"
    with pytest.raises(LocalProtocolError, match="the transfer of 6040:00 is under way"):
        client.upload(WORD)
    assert told(client, "585#6040600000000000") == [""]
    assert events(client) == [canopen.Downloaded(WORD)]
    for size in (0, 5, 5000):
        with pytest.raises(BadField):
            client.download(NAME, bytes(size))
    client.upload(WORD)
    assert str(client.abandon()) == "605#8040600000000405"
    assert client.abandon() is None
    assert told(client, "585#4B40600000000000") == [""]
    assert isinstance(events(client)[0], canopen.StrayResponse)


def test_a_length_that_is_not_told_is_said_to_be_none():
    client = reading(WORD)
    told(client, "585#424060000F000000")
    assert events(client) == [Uploaded(WORD, b"\x0f\0\0\0", exact=False)]


@every_row(
    "texts, code",
    [
        (["585#4108100000100100"], AbortCode.OUT_OF_MEMORY),  # 65 kB
        (["585#4108100009000000", "585#0161726D64726976"], AbortCode.TOO_SHORT),
        (["585#4108100005000000", "585#0061726D64726976"], AbortCode.TOO_LONG),
        (["585#4008100000000000",
          *("585#0061726D64726976", "585#1061726D64726976") * (SIZE_MAX // 14),
          "585#0061726D64726976"], AbortCode.OUT_OF_MEMORY),  # it never ends
    ],
)  # fmt: skip
def test_a_client_gives_up_what_cannot_be_right(texts, code):
    client = reading()
    assert told(client, *texts)[-1] == "605#80081000" + code.to_bytes(4, "little").hex().upper()
    assert events(client) == [Aborted(NAME, code)]
    assert client.busy is None


def test_a_client_leaves_aside_what_is_late_or_foreign():
    client = reading()
    told(client, "585#4108100009000000")
    strays = ["585#6008100000000000", "585#3000000000000000", "585#8040600000000206"]
    foreign = ["586#2000000000000000", "605#2000000000000000", "185#00", "00000585#20"]
    assert told(client, *strays, *foreign) == [""] * 7
    assert [each.response for each in events(client)] == [
        DownloadStarted(NAME), SegmentTaken(True), canopen.Abort(WORD, AbortCode.NO_OBJECT)
    ]  # fmt: skip
    assert told(client, "585#20", "585#0061726D64726976") == ["", "605#7000000000000000"]
    (garbled,) = events(client)
    assert garbled.reason == "length 1 where an SDO frame has 8"


def test_an_abort_that_names_no_object_is_believed_in_segments_alone():
    client = reading()
    told(client, "585#8000000001000405")
    assert client.busy == NAME
    told(client, "585#4108100009000000", "585#8000000001000405")
    assert events(client)[-1] == Aborted(NAME, AbortCode.COMMAND)


# -- the server -----------------------------------------------------------------------------------


@every_row(
    "texts, answers",
    [
        # in segments, none twice, since the client would miss the one before
        (["605#4008100000000000", "605#6000000000000000", "605#7000000000000000",
          "605#6000000000000000"],
         ["585#4108100009000000", "585#0061726D64726976", "585#1B65210000000000",
          "585#8000000001000405"]),
        (["605#4008100000000000", "605#6000000000000000", "605#6000000000000000"],
         ["585#4108100009000000", "585#0061726D64726976", "585#8008100000000305"]),
        (["605#4008100000000000", "605#8008100000000405", "605#6000000000000000"],
         ["585#4108100009000000", "", "585#8000000001000405"]),
        (["605#4000700000000000"], ["585#8000700000000206"]),  # no such object
        (["605#2B4060000F000000", "605#4040600000000000"],
         ["585#6040600000000000", "585#4B4060000F000000"]),
        (["605#224060000F000000"], ["585#6040600000000000"]),  # a length that is not told
        (["605#2F406000EE000000"], ["585#8040600030000906"]),  # refused
        (["605#2108100009000000"], ["585#8008100012000706"]),  # more than a number
        (["605#A008100000000000"], ["585#8008100001000405"]),  # block transfers
        (["605#C008100000000000"], ["585#8008100001000405"]),
        (["605#40", "606#4008100000000000", "605#R"], ["", "", ""]),
    ],
)  # fmt: skip
def test_a_server_answers(texts, answers):
    assert told(Objects({NAME: b"armdrive!"}).server(), *texts) == answers


def test_a_server_says_whether_a_length_was_told():
    objects = Objects()
    told(objects.server(), "605#2B4060000F000000", "605#224060000F000000")
    assert objects.exact == [True, False]
    assert objects.values == {WORD: b"\x0f\0\0\0"}


# -- back to back ---------------------------------------------------------------------------------

PLACE, OTHER = Place(0x1008), Place(0x1009, 3)
NUMBER = st.binary(min_size=1, max_size=4)
COPIES = st.sampled_from((1, 1, 1, 1, 0, 2, 3))
TRANSFERS = st.tuples(st.binary(max_size=60), st.just(True)) | st.tuples(NUMBER, st.just(False))
"""Data, and whether it is read."""


class SdoBus:
    """Both ends. Of each frame is asked how often it comes, and whether it overtakes all others."""

    def __init__(self, copies=lambda: 1, overtakes=lambda: False) -> None:
        self.objects = Objects()
        self.client, self.server = canopen.SdoClient(NODE), self.objects.server()
        self._wire = deque()
        self._copies, self._overtakes = copies, overtakes

    def say(self, frame, most=2000) -> list[object]:
        """Carry a frame, and all that follow, until the bus is silent; return how it ended."""
        heard = []
        self._put(self.server, frame)
        while self._wire:
            most -= 1
            assert most, "they do not end talking"
            to, each = self._wire.pop()
            self._put(self.client if to is self.server else self.server, to.receive_frame(each))
            heard += events(self.client)
        return [event for event in heard if not isinstance(event, canopen.StrayResponse)]

    def _put(self, to, frame) -> None:
        for _ in range(self._copies() if frame is not None else 0):
            (self._wire.append if self._overtakes() else self._wire.appendleft)((to, frame))

    def transfer(self, data, reads):
        if reads:
            self.objects.values[PLACE] = data
            return self.say(self.client.upload(PLACE))
        return self.say(self.client.download(PLACE, data))


@settings(max_examples=60)
@given(TRANSFERS, st.data())
def test_a_bus_that_loses_and_repeats_never_makes_a_transfer_end_well_with_wrong_data(
    given, chance
):
    data, reads = given
    bus = SdoBus(copies=lambda: chance.draw(COPIES))
    ended = bus.transfer(data, reads)
    if bus.client.busy:
        assert ended == []
    elif not isinstance(ended[0], Aborted):
        assert ended == [Uploaded(PLACE, data) if reads else canopen.Downloaded(PLACE)]
        assert bus.objects.values[PLACE] == data


@settings(max_examples=60)
@given(TRANSFERS, NUMBER.filter(lambda data: data != b"\xee"), st.data())
def test_after_any_mess_the_next_transfer_goes_well(given, number, chance):
    faulty = [True]
    bus = SdoBus(
        copies=lambda: chance.draw(COPIES) if faulty[0] else 1,
        overtakes=lambda: faulty[0] and chance.draw(st.booleans()),
    )
    assert len(bus.transfer(*given)) == (bus.client.busy is None)
    bus.say(bus.client.abandon())
    faulty[0] = False
    assert bus.say(bus.client.download(OTHER, number)) == [canopen.Downloaded(OTHER)]
    assert bus.say(bus.client.upload(OTHER)) == [Uploaded(OTHER, number)]


COMMANDS = (0x00, 0x10, 0x20, 0x21, 0x23, 0x2F, 0x30, 0x40, 0x41, 0x4B, 0x60, 0x70, 0x80, 0xA0)


def almost_right(rng: random.Random, can_id: int) -> Frame:
    """Return a frame that is often almost right."""
    if rng.random() < 0.1:
        can_id = rng.randrange(0x800)
    if rng.random() < 0.3:
        return Frame(can_id, rng.randbytes(rng.randrange(9)))
    size = rng.choice((0, 1, 9, 40)).to_bytes(4, "little")
    return Frame(can_id, bytes((rng.choice(COMMANDS),)) + PLACE.packed + size)


def test_both_ends_bear_anything():
    rng, client = random.Random(1), canopen.SdoClient(NODE)
    server = Objects({PLACE: bytes(20)}).server()
    for _ in range(amount(1500, 100_000)):
        if client.busy is None:
            size = rng.choice((0, 2, 4))
            client.download(PLACE, bytes(size)) if size else client.upload(PLACE)
        request = client.receive_frame(almost_right(rng, 0x580 + NODE))
        assert request is None or (request.can_id, len(request.data)) == (0x600 + NODE, 8)
        answer = server.receive_frame(almost_right(rng, 0x600 + NODE))
        assert answer is None or (answer.can_id, len(answer.data)) == (0x580 + NODE, 8)
        events(client)
        if rng.random() < 0.01:
            client.abandon()


# -- frames ---------------------------------------------------------------------------------------

# those that no scene above shows
MESSAGES = [
    (StartDownload(canopen.Place(0x6060), Content(b"\1", 1)), "2F 60 60 00 01 00 00 00"),
    (StartDownload(WORD, Content(b"\1\2\3", 3)), "27 40 60 00 01 02 03 00"),
    (StartDownload(WORD, Content(b"\x60\x79\xfe\xff", 4)), "23 40 60 00 60 79 FE FF"),
    (StartDownload(NAME, Content(None, None)), "20 08 10 00 00 00 00 00"),
    (Segment(False, b"", True), "0F 00 00 00 00 00 00 00"),
]


@every_row("message, text", MESSAGES)
def test_a_message_is_these_bytes(message, text):
    assert encode(message) == bytes.fromhex(text)
    assert decode_request(bytes.fromhex(text)) == message


@given(st.sampled_from((decode_request, decode_response)), st.binary(max_size=9))
def test_any_bytes_have_a_meaning_that_is_kept_or_a_reason(decode, data):
    with contextlib.suppress(RemoteProtocolError):
        message = decode(data)
        assert decode(encode(message)) == message


@every_row(
    "make",
    [
        lambda: canopen.Place(0x10000),
        lambda: canopen.Place(0, 256),
        lambda: Content(b"", 0),
        lambda: Content(b"12345", 5),
        lambda: Content(b"12", None),
        lambda: Content(b"12", 3),
        lambda: Content(None, -1),
        lambda: Segment(False, b"12345678", True),
        lambda: canopen.Abort(canopen.Place(0), -1),
    ],
)
def test_nonsense_of_ours_is_refused(make):
    with pytest.raises(BadField):
        make()


def test_every_abort_code_has_words_and_others_are_told_as_numbers():
    words = [code.words for code in canopen.AbortCode]
    assert all(words)
    assert len(set(words)) == len(canopen.AbortCode) == 31
    assert canopen.Abort(WORD, 0x06020000).words == "there is no such object"
    assert canopen.abort_words(0x12) == "abort code 00000012, which CiA 301 does not have"
    assert str(canopen.Place(0x1018, 1)) == "1018:01"
