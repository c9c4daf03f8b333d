"""SDO machines of both sides."""

import contextlib
from collections import deque

import pytest
from amounts import every_row
from chunks import events
from hypothesis import given, settings
from hypothesis import strategies as st

from firmware_protocol import canopen
from firmware_protocol.canopen.sdo import (
    SIZE_MAX,
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
from firmware_protocol.errors import BadField, LocalProtocolError, RemoteProtocolError
from firmware_protocol.frames import Frame

NODE = 5
ENDINGS = (canopen.Uploaded, canopen.Downloaded, canopen.Aborted)


class SdoBus:
    """Both ends, and an owner who keeps objects.

    Of each frame is asked how often it comes (`copies`), and whether it overtakes all that wait.
    """

    def __init__(self, objects=None, copies=lambda: 1, overtakes=lambda: False) -> None:
        self.client, self.server = canopen.SdoClient(NODE), canopen.SdoServer(NODE)
        self.objects = dict(objects or {})
        self.wire = deque()
        self.heard = []
        self._copies, self._overtakes = copies, overtakes

    def put(self, to, frame) -> None:
        if frame is None:
            return
        for _ in range(self._copies()):
            (self.wire.append if self._overtakes() else self.wire.appendleft)((to, frame))

    def say(self, frame) -> None:
        self.put(self.server, frame)

    def run(self, most=2000) -> None:
        """Carry frames until the bus is silent. Both ends' events are fetched as they come."""
        while self.wire and most:
            most -= 1
            to, frame = self.wire.pop()
            other = self.client if to is self.server else self.server
            self.put(other, to.receive_frame(frame))
            self.heard += events(self.client)
            for asked in events(self.server):
                self._answer(asked)
        assert most, "they do not end talking"

    def ended(self) -> list[object]:
        return [event for event in self.heard if isinstance(event, ENDINGS)]

    def upload(self, place):
        self.heard.clear()
        self.say(self.client.upload(place))
        self.run()
        return self.ended()

    def download(self, place, data):
        self.heard.clear()
        self.say(self.client.download(place, data))
        self.run()
        return self.ended()

    def _answer(self, asked) -> None:
        match asked:
            case canopen.ReadAsked(place) if place in self.objects:
                self.put(self.client, self.server.supply(asked, self.objects[place]))
            case canopen.WriteAsked(place, data):
                self.objects[place] = data
                self.put(self.client, self.server.accept(asked))
            case canopen.ReadAsked():
                self.put(self.client, self.server.refuse(asked, canopen.AbortCode.NO_OBJECT))


NAME, WORD = canopen.Place(0x1008), canopen.Place(0x6040)


def told(machine, *texts) -> list[str]:
    """Feed frames, and return what the machine says to each."""
    answers = [machine.receive_frame(Frame.parse(text)) for text in texts]
    return ["" if answer is None else str(answer) for answer in answers]


def test_a_client_reads_in_segments():
    client = canopen.SdoClient(NODE)
    assert str(client.upload(NAME)) == "605#4008100000000000"
    answers = told(client, "585#4108100009000000", "585#0061726D64726976", "585#1B65210000000000")
    assert answers == ["605#6000000000000000", "605#7000000000000000", ""]
    assert events(client) == [canopen.Uploaded(NAME, b"armdrive!")]


def test_a_client_writes_a_number_in_one_frame():
    client = canopen.SdoClient(NODE)
    assert str(client.download(WORD, b"\x0f\0")) == "605#2B4060000F000000"
    assert told(client, "585#6040600000000000") == [""]
    assert events(client) == [canopen.Downloaded(WORD)]
    for too_long in (b"", b"12345"):
        with pytest.raises(BadField):
            client.download(NAME, too_long)
        client.abandon()


def test_a_length_that_is_not_told_is_said_to_be_none():
    client = canopen.SdoClient(NODE)
    client.upload(WORD)
    told(client, "585#424060000F000000")
    assert events(client) == [canopen.Uploaded(WORD, b"\x0f\0\0\0", exact=False)]


@pytest.mark.parametrize(
    ("texts", "code"),
    [
        (["585#4108100000100100"], canopen.AbortCode.OUT_OF_MEMORY),  # 65 kB
        (["585#4108100009000000", "585#0161726D64726976"], canopen.AbortCode.TOO_SHORT),
        (["585#4108100005000000", "585#0061726D64726976"], canopen.AbortCode.TOO_LONG),
    ],
)
def test_a_client_gives_up_what_cannot_be_right(texts, code):
    client = canopen.SdoClient(NODE)
    client.upload(NAME)
    assert told(client, *texts)[-1] == "605#80081000" + code.to_bytes(4, "little").hex().upper()
    assert events(client) == [canopen.Aborted(NAME, code)]
    assert client.busy is None


def test_a_server_that_never_ends_fills_no_memory():
    client = canopen.SdoClient(NODE)
    client.upload(NAME)
    told(client, "585#4008100000000000")
    for _ in range(SIZE_MAX // 14):
        told(client, "585#0061726D64726976", "585#1061726D64726976")
    assert told(client, "585#0061726D64726976") == ["605#8008100005000405"]  # no room for these
    assert events(client) == [canopen.Aborted(NAME, canopen.AbortCode.OUT_OF_MEMORY)]


def test_a_client_leaves_aside_what_is_repeated_late_or_foreign():
    client = canopen.SdoClient(NODE)
    client.upload(NAME)
    told(client, "585#4108100009000000")
    strays = ["585#6008100000000000", "585#3000000000000000", "585#8040600000000206"]
    foreign = ["586#2000000000000000", "605#2000000000000000", "185#00", "00000585#20"]
    assert told(client, *strays, *foreign) == [""] * 7
    assert events(client) == [
        canopen.StrayResponse(DownloadStarted(NAME)),
        canopen.StrayResponse(SegmentTaken(True)),
        canopen.StrayResponse(canopen.Abort(WORD, canopen.AbortCode.NO_OBJECT)),
    ]
    assert told(client, "585#20", "585#0061726D64726976") == ["", "605#7000000000000000"]
    (garbled,) = events(client)
    assert garbled == canopen.UnreadableFrame(
        Frame.parse("585#20"), "length 1 where an SDO frame has 8"
    )


def test_a_segment_that_comes_twice_is_taken_once_though_no_length_was_told():
    client = canopen.SdoClient(NODE)
    client.upload(NAME)
    told(client, "585#4008100000000000")
    answers = told(client, "585#0061726D64726976", "585#0061726D64726976", "585#1B65210000000000")
    assert answers == ["605#7000000000000000", "", ""]
    assert [type(event) for event in events(client)] == [canopen.StrayResponse, canopen.Uploaded]


def test_an_abort_that_names_no_object_is_believed_in_segments_alone():
    client = canopen.SdoClient(NODE)
    client.upload(NAME)
    told(client, "585#8000000001000405")
    assert client.busy == NAME
    told(client, "585#4108100009000000", "585#8000000001000405")
    assert events(client)[-1] == canopen.Aborted(NAME, canopen.AbortCode.COMMAND)


def test_a_client_does_one_thing_at_a_time_until_its_owner_gives_up():
    client = canopen.SdoClient(NODE)
    client.upload(WORD)
    with pytest.raises(LocalProtocolError, match="the transfer of 6040:00 is under way"):
        client.download(WORD, b"\1")
    assert str(client.abandon()) == "605#8040600000000405"
    assert client.abandon() is None
    assert told(client, "585#4B40600000000000") == [""]
    assert isinstance(events(client)[0], canopen.StrayResponse)
    with pytest.raises(BadField):
        client.download(WORD, bytes(5000))
    assert client.busy is None


def test_a_server_tells_in_segments():
    server = canopen.SdoServer(NODE)
    assert told(server, "605#4008100000000000") == [""]
    assert events(server) == [canopen.ReadAsked(NAME)]
    assert str(server.supply(canopen.ReadAsked(NAME), b"armdrive!")) == "585#4108100009000000"
    answers = told(server, "605#6000000000000000", "605#7000000000000000", "605#60")
    assert answers == ["585#0061726D64726976", "585#1B65210000000000", ""]
    assert told(server, "605#6000000000000000") == ["585#8000000001000405"]


def test_a_segment_is_not_told_twice_since_the_client_would_miss_the_one_before():
    server = canopen.SdoServer(NODE)
    told(server, "605#4008100000000000")
    server.supply(canopen.ReadAsked(NAME), b"armdrive!")
    answers = told(server, "605#6000000000000000", "605#6000000000000000")
    assert answers == ["585#0061726D64726976", "585#8008100000000305"]


def test_a_server_takes_a_number_and_says_so_when_its_owner_has():
    server = canopen.SdoServer(NODE)
    assert told(server, "605#2B4060000F000000") == [""]
    asked = canopen.WriteAsked(WORD, b"\x0f\0")
    assert (events(server), server.asked) == ([asked], asked)
    assert str(server.accept(asked)) == "585#6040600000000000"
    assert server.accept(asked) is None


@every_row(
    "texts, code",
    [
        (["605#2108100009000000"], canopen.AbortCode.TOO_LONG),
        (["605#2008100000000000"], canopen.AbortCode.TOO_LONG),
        (["605#A008100000000000"], canopen.AbortCode.COMMAND),
        (["605#C008100000000000"], canopen.AbortCode.COMMAND),
    ],
)
def test_a_server_aborts_what_cannot_be_right(texts, code):
    server = canopen.SdoServer(NODE)
    assert told(server, *texts)[-1] == "585#80081000" + code.to_bytes(4, "little").hex().upper()
    assert server.asked is None


def test_a_newer_request_takes_the_place_of_an_older_one():
    server = canopen.SdoServer(NODE)
    told(server, "605#2B4060000F000000", "605#4008100000000000")
    older, newer = events(server)
    assert older == canopen.WriteAsked(WORD, b"\x0f\0")
    assert server.accept(older) is None
    assert str(server.refuse(newer, canopen.AbortCode.NO_OBJECT)) == "585#8008100000000206"
    assert server.refuse(newer, canopen.AbortCode.NO_OBJECT) is None
    assert server.supply(newer, b"") is None


def test_a_read_cannot_be_accepted_nor_can_what_the_client_gave_up():
    server = canopen.SdoServer(NODE)
    told(server, "605#224060000F000000")
    (asked,) = events(server)
    assert asked == canopen.WriteAsked(WORD, b"\x0f\0\0\0", exact=False)
    assert told(server, "605#8040600000000405") == [""]
    assert server.accept(asked) is None
    told(server, "605#4008100000000000", "605#8040600000000405")  # of another object
    assert server.asked == canopen.ReadAsked(NAME)


def test_frames_that_are_no_request_are_reported():
    server = canopen.SdoServer(NODE)
    assert told(server, "605#40", "606#4008100000000000", "605#R") == ["", "", ""]
    (ignored,) = events(server)
    assert ignored == canopen.UnreadableFrame(
        Frame.parse("605#40"), "length 1 where an SDO frame has 8"
    )


# -- back to back ---------------------------------------------------------------------------------

PLACE, OTHER = canopen.Place(0x1008), canopen.Place(0x1009, 3)
DATA, NUMBER = st.binary(max_size=60), st.binary(min_size=1, max_size=4)
COPIES = st.sampled_from((1, 1, 1, 1, 0, 2, 3))


def transfer(bus, data, reads):
    if reads:
        bus.objects[PLACE] = data
        return bus.upload(PLACE)
    return bus.download(PLACE, data)


TRANSFERS = st.tuples(DATA, st.just(True)) | st.tuples(NUMBER, st.just(False))


@settings(max_examples=60)
@given(TRANSFERS, st.data())
def test_a_bus_that_loses_and_repeats_never_makes_a_transfer_end_well_with_wrong_data(
    given, chance
):
    data, reads = given
    bus = SdoBus(copies=lambda: chance.draw(COPIES))
    ended = transfer(bus, data, reads)
    if bus.client.busy:
        assert ended == []
    elif not isinstance(ended[0], canopen.Aborted):
        assert ended == [canopen.Uploaded(PLACE, data) if reads else canopen.Downloaded(PLACE)]
        assert bus.objects[PLACE] == data


@settings(max_examples=60)
@given(TRANSFERS, NUMBER, st.data())
def test_after_any_mess_the_next_transfer_goes_well(given, number, chance):
    data, reads = given
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
    assert bus.download(OTHER, number) == [canopen.Downloaded(OTHER)]
    assert bus.upload(OTHER) == [canopen.Uploaded(OTHER, number)]
    assert bus.upload(canopen.Place(0x2000)) == [
        canopen.Aborted(canopen.Place(0x2000), canopen.AbortCode.NO_OBJECT)
    ]


# -- frames ---------------------------------------------------------------------------------------

REQUESTS = [
    (StartUpload(canopen.Place(0x1018, 1)), "40 18 10 01 00 00 00 00"),
    (StartDownload(canopen.Place(0x6060), Content(b"\1", 1)), "2F 60 60 00 01 00 00 00"),
    (StartDownload(WORD, Content(b"\x0f\0", 2)), "2B 40 60 00 0F 00 00 00"),
    (StartDownload(WORD, Content(b"\1\2\3", 3)), "27 40 60 00 01 02 03 00"),
    (
        StartDownload(canopen.Place(0x607A), Content(b"\x60\x79\xfe\xff", 4)),
        "23 7A 60 00 60 79 FE FF",
    ),
    (StartDownload(WORD, Content(b"\x0f\0\0\0", None)), "22 40 60 00 0F 00 00 00"),
    (StartDownload(NAME, Content(None, 9)), "21 08 10 00 09 00 00 00"),
    (StartDownload(NAME, Content(None, None)), "20 08 10 00 00 00 00 00"),
    (NextSegment(False), "60 00 00 00 00 00 00 00"),
    (NextSegment(True), "70 00 00 00 00 00 00 00"),
    (Segment(False, b"armdriv", False), "00 61 72 6D 64 72 69 76"),
    (Segment(True, b"e!", True), "1B 65 21 00 00 00 00 00"),
    (Segment(False, b"", True), "0F 00 00 00 00 00 00 00"),
    (canopen.Abort(NAME, canopen.AbortCode.TIMED_OUT), "80 08 10 00 00 00 04 05"),
]
RESPONSES = [
    (Upload(canopen.Place(0x6041), Content(b"\x37\2", 2)), "4B 41 60 00 37 02 00 00"),
    (Upload(canopen.Place(0x6041), Content(b"\x37\2\0\0", None)), "42 41 60 00 37 02 00 00"),
    (Upload(NAME, Content(None, 9)), "41 08 10 00 09 00 00 00"),
    (Upload(NAME, Content(None, None)), "40 08 10 00 00 00 00 00"),
    (DownloadStarted(WORD), "60 40 60 00 00 00 00 00"),
    (Segment(True, b"e!", True), "1B 65 21 00 00 00 00 00"),
    (SegmentTaken(False), "20 00 00 00 00 00 00 00"),
    (SegmentTaken(True), "30 00 00 00 00 00 00 00"),
    (canopen.Abort(WORD, canopen.AbortCode.NO_OBJECT), "80 40 60 00 00 00 02 06"),
]
WAYS = [(decode_request, *row) for row in REQUESTS] + [(decode_response, *row) for row in RESPONSES]


@every_row("decode, message, text", WAYS)
def test_a_message_is_these_bytes(decode, message, text):
    assert encode(message) == bytes.fromhex(text)
    assert decode(bytes.fromhex(text)) == message


@given(st.sampled_from((decode_request, decode_response)), st.binary(max_size=9))
def test_any_bytes_have_a_meaning_that_is_kept_or_a_reason(decode, data):
    with contextlib.suppress(RemoteProtocolError):
        message = decode(data)
        assert decode(encode(message)) == message


@every_row(
    "decode, text, reason",
    [
        (decode_request, "40 18 10 01", "length 4 where an SDO frame has 8"),
        (decode_request, "A0 08 10 00 00 00 00 00", "no SDO request begins with a0"),
        (decode_request, "C0 08 10 00 00 00 00 00", "no SDO request begins with c0"),
        (decode_response, "A0 08 10 00 00 00 00 00", "no SDO response begins with a0"),
        (decode_response, "", "length 0 where an SDO frame has 8"),
    ],
)
def test_unsupported_services_are_named(decode, text, reason):
    with pytest.raises(RemoteProtocolError, match=reason):
        decode(bytes.fromhex(text))


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
