"""The master's end of a bus with CiA 402 drives for the long fuzz run; a drive takes frames."""

import random

from chunks import events
from fuzzing import FuzzCase

from firmware_protocol import canopen
from firmware_protocol.frames import Frame, pack

NODES = range(1, 7)


def _report(rng: random.Random, node: int) -> Frame:
    data = rng.randbytes(canopen.REPORT_PDO.size)
    return Frame(canopen.cob_id(canopen.Service.TPDO1, node), data)


FRAMES = (
    _report,
    lambda rng, node: canopen.Heartbeat(node, rng.choice(list(canopen.NodeState))).frame,
    lambda rng, node: canopen.Emergency(node, rng.getrandbits(16), rng.randrange(256)).frame,
)


def _good(rng: random.Random) -> bytes:
    return pack(rng.choice(FRAMES)(rng, rng.choice(NODES)))


def _asking() -> canopen.Host:
    host = canopen.Host(NODES)
    for node in NODES:
        host.upload(node, canopen.Place(0x1000))
    return host


def _host_saw_one(host: canopen.Host) -> bool:
    good = canopen.DriveReport | canopen.Heartbeat | canopen.Emergency
    return any(isinstance(event, good) for event in events(host))


HOST = FuzzCase("canopen host", _asking, _good, _host_saw_one)
