"""What the codecs of drives on a bus cost: frames by them, beside the same bytes by hand."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

from measuring import Row, Section, interleaved, timing

from firmware_protocol.canopen import (
    POSITION,
    Command,
    Controlword,
    DriveReport,
    OperationMode,
    Service,
    Uploaded,
    cob_id,
)
from firmware_protocol.canopen import Host as CanopenHost
from firmware_protocol.canopen import SdoAnswered as Transferred
from firmware_protocol.frames import Frame, pack
from firmware_protocol.mks import Answered, Host, MoveAbsoluteAxis, ReadEncoder
from firmware_protocol.mks.answers import encode

ROUNDS = 2_000
NODE = 1
DRIVES = range(1, 7)
COUNTS = 123_456


@dataclass(frozen=True, slots=True)
class Exchange:
    """A question to the drive of number 1 where it is, and its answer."""

    asked: Frame
    answered: Frame


def row(what: str, taken: list[float], **floors: list[float]) -> Row:
    """Return a row in microseconds, with its ratios to floors."""
    beside = {name.replace("_", " "): floor for name, floor in floors.items()}
    return timing(what, taken, "us", beside=beside)


# -- MKS ------------------------------------------------------------------------------------------

ORDER = MoveAbsoluteAxis(0x4000, 600, 252)


def mks_answer() -> Frame:
    """Return a drive's answer to the question where it is."""
    data = b"\x31" + COUNTS.to_bytes(6, "big")
    return Frame(NODE, data + bytes(((NODE + sum(data)) & 0xFF,)))


def order_by_hand() -> bytes:
    """Write the order as a program does that writes nothing else: no record, no check of fields."""
    data = struct.pack(">BHB", 0xF5, 600, 252) + (0x4000).to_bytes(3, "big")
    return data + bytes(((NODE + sum(data)) & 0xFF,))


def mks(rounds: int = ROUNDS) -> Section:
    """Measure writing an order, and reading an answer to a question that was asked."""
    host, heard = Host((NODE,)), mks_answer()
    record = pack(heard)

    def ordered() -> None:
        host.send(NODE, ORDER)
        host.forget(NODE)

    def asked_and_read() -> None:
        host.send(NODE, ReadEncoder())
        host.receive_data(record)
        assert isinstance(host.next_event(), Answered)

    def by_hand() -> None:
        data = bytes((0x31, (NODE + 0x31) & 0xFF))
        assert data
        got = heard.data
        assert got[-1] == (NODE + sum(got[:-1])) & 0xFF
        int.from_bytes(got[1:7], "big", signed=True)

    cases = {
        "order": ordered, "order by hand": order_by_hand,
        "asked": asked_and_read, "asked by hand": by_hand,
    }  # fmt: skip
    taken = interleaved(cases, rounds)
    assert encode(NODE, ORDER).data == order_by_hand()
    rows = (
        row("an order (F5), written by hand", taken["order by hand"]),
        row("an order by the codec", taken["order"], by_hand=taken["order by hand"]),
        row("a question and its answer (31), by hand", taken["asked by hand"]),
        row(
            "a question and its answer by the codec", taken["asked"], by_hand=taken["asked by hand"]
        ),
    )
    return Section("The MKS codec", rows, f"{rounds} each; checked, matched and packed as records")


# -- CANopen --------------------------------------------------------------------------------------

WORD = Controlword.of(Command.ENABLE_OPERATION)
MODE = OperationMode.CYCLIC_POSITION
STATUS = 0x1237
_PDO = struct.Struct("<Hbi")
_SDO = struct.Struct("<BHBi")


def told(node: int, position: int = COUNTS) -> Frame:
    """Return what a drive says at SYNC."""
    return Frame(cob_id(Service.TPDO1, node), _PDO.pack(STATUS, MODE, position))


def sdo() -> Exchange:
    """Return the transfer of a drive's position."""
    asked = Frame(cob_id(Service.SDO_REQUEST, NODE), POSITION.packed.rjust(4, b"\x40") + bytes(4))
    data = _SDO.pack(0x43, POSITION.index, POSITION.sub, COUNTS)
    return Exchange(asked, Frame(cob_id(Service.SDO_RESPONSE, NODE), data))


def canopen(rounds: int = ROUNDS) -> Section:
    """Measure a target written, a position read, a transfer, and a round of six drives."""
    bus, exchange = CanopenHost(DRIVES), sdo()
    heard, answered = pack(told(NODE)), pack(exchange.answered)
    all_told = b"".join(pack(told(node)) for node in DRIVES)

    def targeted() -> bytes:
        return bus.command(NODE, WORD, MODE, COUNTS)

    def read() -> None:
        bus.receive_data(heard)
        assert isinstance(bus.next_event(), DriveReport)

    def read_by_hand() -> object:
        assert len(data_told) == _PDO.size
        _, _, position = _PDO.unpack(data_told)
        return position

    def transferred() -> None:
        bus.upload(NODE, POSITION)
        bus.receive_data(answered)
        event = bus.next_event()
        assert isinstance(event, Transferred)
        assert isinstance(event.event, Uploaded)

    def transferred_by_hand() -> object:
        assert _SDO.pack(0x40, 0x6064, 0, 0)
        command, index, sub, value = _SDO.unpack(exchange.answered.data)
        assert (command, index, sub) == (0x43, 0x6064, 0)
        return value

    def turned() -> None:
        said = [bus.command(node, WORD, MODE, COUNTS) for node in DRIVES]
        assert b"".join((*said, bus.sync()))
        bus.receive_data(all_told)
        for _ in DRIVES:
            bus.next_event()

    def turned_by_hand() -> None:
        for _ in DRIVES:
            _PDO.pack(WORD.value, MODE, COUNTS)
            _PDO.unpack(data_told)

    data_told = told(NODE).data
    by_hand: dict[str, Callable[[], object]] = {
        "target": lambda: _PDO.pack(WORD.value, MODE, COUNTS), "read": read_by_hand,
        "transfer": transferred_by_hand, "turn": turned_by_hand,
    }  # fmt: skip
    ours = {"target": targeted, "read": read, "transfer": transferred, "turn": turned}
    cases = {f"{name} by hand": case for name, case in by_hand.items()} | ours
    taken = interleaved(cases, rounds)
    assert _PDO.pack(WORD.value, MODE, COUNTS) in targeted()
    whats = {
        "target": "a target (an RPDO)",
        "read": "a position (a TPDO)",
        "transfer": "an object read (SDO)",
        "turn": "a turn of six drives, all of these PDOs",
    }
    rows = tuple(
        each
        for name, what in whats.items()
        for each in (
            row(f"{what}, by hand", taken[f"{name} by hand"]),
            row("  the same by the codec", taken[name], by_hand=taken[f"{name} by hand"]),
        )
    )
    return Section("The CANopen codec", rows, f"{rounds} each; checked and packed as records")
