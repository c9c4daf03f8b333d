"""Any frame, in any order, to every CANopen machine: no exception, and no memory that grows."""

import random

import pytest
from amounts import amount
from canopen_bus import NODE
from chunks import events

from firmware_protocol import canopen
from firmware_protocol.canopen.sdo import EVENTS_MAX, SIZE_MAX
from firmware_protocol.events import Overrun
from firmware_protocol.frames import Frame

COMMANDS = (0x00, 0x10, 0x20, 0x21, 0x23, 0x2F, 0x30, 0x40, 0x41, 0x4B, 0x60, 0x70, 0x80, 0xA0)
PLACE = canopen.Place(0x1008)


def frame(rng: random.Random, can_id: int) -> Frame:
    """Return a frame that is often almost right."""
    if rng.random() < 0.1:
        can_id = rng.randrange(0x800)
    if rng.random() < 0.3:
        return Frame(can_id, rng.randbytes(rng.randrange(9)))
    size = rng.choice((0, 1, 9, 40)).to_bytes(4, "little")
    return Frame(can_id, bytes((rng.choice(COMMANDS),)) + PLACE.packed + size)


@pytest.mark.parametrize("fetches", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_a_client_bears_anything(seed, fetches):
    rng, client = random.Random(seed), canopen.SdoClient(NODE)
    for _ in range(amount(1500, 100_000)):
        if client.busy is None:
            size = rng.choice((0, 2, 40))
            client.download(PLACE, bytes(size)) if size else client.upload(PLACE)
        answer = client.receive_frame(frame(rng, 0x580 + NODE))
        assert answer is None or (answer.can_id, len(answer.data)) == (0x600 + NODE, 8)
        if fetches:
            events(client)
        elif rng.random() < 0.01:
            client.abandon()
    waiting = events(client)
    assert len(waiting) <= EVENTS_MAX + 1
    assert fetches or isinstance(waiting[0], Overrun)


@pytest.mark.parametrize("answers", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_a_server_bears_anything(seed, answers):
    rng, server = random.Random(seed), canopen.SdoServer(NODE)
    asked = 0
    for _ in range(amount(1500, 100_000)):
        answer = server.receive_frame(frame(rng, 0x600 + NODE))
        assert answer is None or (answer.can_id, len(answer.data)) == (0x580 + NODE, 8)
        for event in events(server) if answers else ():
            asked += isinstance(event, canopen.ReadAsked | canopen.WriteAsked)
            if isinstance(event, canopen.ReadAsked):
                server.supply(event, bytes(rng.choice((0, 4, 20))))
            elif isinstance(event, canopen.WriteAsked):
                assert len(event.data) <= SIZE_MAX
                server.accept(event)
    assert len(events(server)) <= EVENTS_MAX + 1
    assert bool(asked) == answers


def test_a_node_bears_anything():
    rng, node = random.Random(1), canopen.NmtNode(NODE)
    for _ in range(500):
        node.booted()
        node.receive_frame(Frame(rng.choice((0, 0x705)), rng.randbytes(rng.randrange(4))))
        assert node.heartbeat.frame.can_id == 0x705
