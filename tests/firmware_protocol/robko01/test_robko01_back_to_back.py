"""Host and device wired to each other, and what the wire may do to their bytes."""

from chunks import carried, events
from hypothesis import given
from hypothesis import strategies as st
from robko01_strategies import ANSWERS, EXCHANGES, REQUESTS

from firmware_protocol import robko01
from firmware_protocol.robko01.frames import Frame, FrameSplitter
from firmware_protocol.robko01.messages import encode_answer, encode_request

FRAMES = st.one_of(REQUESTS.map(encode_request), ANSWERS.map(encode_answer))
PIECES = st.lists(
    st.one_of(
        FRAMES,
        st.binary(max_size=40),
        st.tuples(FRAMES, st.integers(0, 33)).map(lambda cut: cut[0][: cut[1]]),
        st.sampled_from([b"\xaa", b"\xaa\x01", b"\xaa\x02\x1c", b"\xaa\x01\x1b\x06"]),
    ),
    max_size=8,
)


def split(chunks: list[bytes]) -> tuple[list[Frame | robko01.Unreadable], FrameSplitter]:
    splitter = FrameSplitter()
    found = []
    for chunk in chunks:
        splitter.feed(chunk)
        while (entry := splitter.next_frame()) is not None:
            found.append(entry)
    return found, splitter


@given(st.lists(EXCHANGES, max_size=5), st.booleans(), st.data())
def test_every_script_arrives_whole_at_both_ends(script, counts_check, data):
    host, device = (
        robko01.Host(counts_check=counts_check),
        robko01.Device(counts_check=counts_check),
    )
    for request, answer in script:
        assert carried(data.draw, host.send(request), device) == [request]
        assert carried(data.draw, device.send(answer), host) == [robko01.Answered(request, answer)]
        assert (host.outstanding, device.unanswered) == (None, None)
        assert (host.buffered, device.buffered) == (0, 0)


@given(PIECES)
def test_every_byte_is_told_once_and_in_order(pieces):
    stream = b"".join(pieces)
    found, splitter = split([stream])
    splitter.silence()
    found += iter(splitter.next_frame, None)
    raw = [entry.raw if isinstance(entry, Frame) else entry.data for entry in found]
    assert b"".join(raw) == stream
    assert splitter.buffered == 0
    at = 0
    for entry, data in zip(found, raw, strict=True):
        assert not isinstance(entry, Frame) or entry.start == at
        at += len(data)


@given(st.binary(max_size=200), EXCHANGES, st.data())
def test_after_noise_a_good_frame_is_heard_once_a_silence_follows(noise, exchange, data):
    request, answer = exchange
    device, host = robko01.Device(), robko01.Host()
    for event in carried(data.draw, noise, device):
        assert isinstance(event, robko01.Unreadable)
    sent = host.send(request)
    host.receive_data(noise)
    device.receive_data(sent)
    device.silence()
    assert events(device)[-1] == request
    host.receive_data(device.send(answer))
    host.silence()
    *before, last = events(host)
    assert last == robko01.Answered(request, answer)
    assert all(isinstance(event, robko01.Unreadable) for event in before)


@given(st.binary(max_size=80), REQUESTS.map(encode_request))
def test_after_noise_a_good_frame_is_heard_once_a_longest_frame_has_followed(noise, frame):
    found, _ = split([noise + frame + bytes(robko01.FRAME_MAX)])
    assert [entry.raw for entry in found if isinstance(entry, Frame)] == [frame]


@given(EXCHANGES, st.data())
def test_a_frame_inside_a_payload_is_only_a_payload(exchange, data):
    inner = encode_answer(exchange[1])[:26]
    host, device = robko01.Host(), robko01.Device()
    assert carried(data.draw, host.send(robko01.Ping(inner)), device) == [robko01.Ping(inner)]
    found = carried(data.draw, device.send(robko01.Pong(inner)), host)
    assert found == [robko01.Answered(robko01.Ping(inner), robko01.Pong(inner))]


def test_a_flood_that_nobody_fetches_is_bounded_and_ends_with_the_newest():
    host = robko01.Host()
    answer = encode_answer(robko01.Pong(bytes(26)))
    for number in range(1000):
        host.receive_data(answer + bytes([number % 256]) * 40)
        assert host.buffered <= 256 * 64 + 64 + robko01.FRAME_MAX
    first, *others = events(host)
    assert first == robko01.Overrun(1743)
    assert len(others) == 256
    assert isinstance(others[-1], robko01.Stray)


def test_an_endless_noise_is_told_in_runs():
    device = robko01.Device()
    for _ in range(64):
        device.receive_data(b"\xaa\x01")
    runs = events(device)
    assert [len(run.data) for run in runs] == [64]
    assert device.buffered == 64
    device.receive_data(encode_request(robko01.Stop()))
    assert events(device)[-1] == robko01.Stop()
