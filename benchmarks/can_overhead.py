"""Print what codec and link add to a CAN frame: `python benchmarks/can_overhead.py [--json]`.

Each stands beside a floor that was measured in turn with it: the bytes written by hand, python-can
alone on its virtual bus, python-can alone at the same serial adapter. Nothing passes or fails.
"""

from __future__ import annotations

import contextlib
import sys
import tempfile
import uuid
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import can
from can_codecs import NODE, ROUNDS, Exchange, canopen, mks, mks_answer, row, sdo
from measuring import Row, Section, interleaved, own_home, report

from armdrive.transports.address import CanAddress
from armdrive.transports.can_health import frame_bits
from armdrive.transports.can_link import CanLink
from armdrive.transports.can_slcan import Slcan
from armdrive.transports.opening import open_can_link
from firmware_protocol.frames import Frame, Unpacker, pack
from firmware_protocol.mks import ReadEncoder
from firmware_protocol.mks.answers import encode
from tests.conformance.real_time_bench import DeviceProcess

BATCH = 100
"""Frames that are written at once; they fit into the link's queue."""
BITS_S = 500_000
WAIT_S = 1.0


# -- the link -------------------------------------------------------------------------------------


@contextlib.contextmanager
def virtual_pair() -> Iterator[tuple[can.BusABC, can.BusABC]]:
    """Open two ends of python-can's virtual bus."""
    channel = uuid.uuid4().hex
    with (
        can.Bus(interface="virtual", channel=channel) as near,
        can.Bus(interface="virtual", channel=channel) as far,
    ):
        yield near, far


def message(frame: Frame) -> can.Message:
    """Return a frame as python-can has it."""
    return can.Message(arbitration_id=frame.can_id, data=frame.data, is_extended_id=False)


def there(far: can.BusABC, count: int = 1) -> None:
    """Take so many frames at the far end."""
    for _ in range(count):
        assert far.recv(WAIT_S) is not None


def heard_by(link: CanLink, unpacker: Unpacker, count: int = 1) -> None:
    """Take so many frames as the engine does."""
    while count > 0:
        got = unpacker.feed(link.read(0.0))
        count -= len(got)
        if not got:
            link.wait(WAIT_S)


@dataclass(slots=True)
class Threads:
    """python-can's own way with threads: a Notifier and a reader's buffer."""

    bus: can.BusABC
    reader: can.BufferedReader

    def exchange(self, far: can.BusABC, out: can.Message, back: can.Message) -> None:
        """Send, have it answered, and wait until the answer is in the buffer."""
        self.bus.send(out)
        there(far)
        far.send(back)
        assert self.reader.get_message(WAIT_S) is not None


def link(rounds: int = ROUNDS) -> Section:
    """Measure a frame out and one back, and a batch of frames out, on virtual buses."""
    out, back = encode(NODE, ReadEncoder()), mks_answer()
    record, unpacker = pack(out), Unpacker()
    batch = record * BATCH
    messages = message(out), message(back)
    with (
        virtual_pair() as (bare, bare_far),
        virtual_pair() as (noted, noted_far),
        virtual_pair() as (ours, ours_far),
    ):
        reader = can.BufferedReader()
        notifier = can.Notifier(noted, [reader])
        threads, owned = Threads(noted, reader), CanLink(ours, "virtual")

        def bare_exchange() -> None:
            bare.send(messages[0])
            there(bare_far)
            bare_far.send(messages[1])
            there(bare)

        def by_link() -> None:
            owned.write(record, 0.0)
            there(ours_far)
            ours_far.send(messages[1])
            heard_by(owned, unpacker)

        def bare_batch() -> None:
            for _ in range(BATCH):
                bare.send(messages[0])
            there(bare_far, BATCH)

        def link_batch() -> None:
            owned.write(batch, 0.0)
            there(ours_far, BATCH)

        taken = interleaved(
            {
                "bare": bare_exchange,
                "threads": lambda: threads.exchange(noted_far, *messages),
                "link": by_link,
            },
            rounds,
        )
        many = interleaved({"bare": bare_batch, "link": link_batch}, max(rounds // BATCH, 2))
        notifier.stop()
        owned.close()
    each = {name: [one / BATCH for one in times] for name, times in many.items()}
    rows = (
        row("out and back: python-can, one thread", taken["bare"]),
        row("  python-can with its Notifier", taken["threads"], bare=taken["bare"]),
        row(
            "  the link, with a thread each way",
            taken["link"],
            bare=taken["bare"],
            the_Notifier=taken["threads"],
        ),
        row(f"a frame of {BATCH} out: python-can, one thread", each["bare"]),
        row("  the link", each["link"], bare=each["bare"]),
    )
    return Section("The link", rows, f"virtual buses in this process, {rounds} exchanges each")


def slcan(rounds: int = ROUNDS // 4) -> Section:
    """Measure one question to an MKS drive in another process, and its answer, over a pty."""
    return over_slcan("mks", Exchange(encode(NODE, ReadEncoder()), mks_answer()), rounds)


def slcan_sdo(rounds: int = ROUNDS // 4) -> Section:
    """Measure the transfer of a CiA 402 drive's position."""
    return over_slcan("cia402", sdo(), rounds)


def over_slcan(dialect: str, exchange: Exchange, rounds: int) -> Section:
    """Measure one exchange with a drive in another process, over a pty."""
    out, unpacker = exchange.asked, Unpacker()
    record = pack(out)
    floor_s = (frame_bits(out) + frame_bits(exchange.answered)) / BITS_S
    with tempfile.TemporaryDirectory() as folder, own_home():
        home, program = Path(folder), ("armdrive", "sim", dialect)
        with (
            DeviceProcess(program, ("--slcan", str(home / "bare")), dialect) as one,
            DeviceProcess(program, ("--slcan", str(home / "ours")), dialect) as other,
            contextlib.closing(open_can_link(other.port)) as owned,
            Slcan(CanAddress.parse(one.port).channel, bitrate=BITS_S) as bare,
        ):

            def bare_exchange() -> None:
                bare.send(message(out))
                there(bare)

            def by_link() -> None:
                owned.write(record, 0.0)
                heard_by(owned, unpacker)

            taken = interleaved({"bare": bare_exchange, "link": by_link}, rounds)
    rows = (
        Row(f"floor: both frames at {BITS_S // 1000} kbit/s", floor_s * 1e6, "us"),
        row("python-can's slcan, one thread", taken["bare"], the_floor=[floor_s]),
        row("the link", taken["link"], the_floor=[floor_s], python_can=taken["bare"]),
    )
    note = f"one drive asked where it is, {rounds} times; the simulated bus takes its time for bits"
    return Section(f"A serial adapter on a pty, {dialect} drives in another process", rows, note)


SECTIONS: Mapping[str, Callable[[], Section]] = {
    "mks": mks,
    "canopen": canopen,
    "link": link,
    "slcan": slcan,
    "slcan-sdo": slcan_sdo,
}


def main(argv: list[str] | None = None) -> int:
    """Run the sections that are asked for, or all of them."""
    return report(argv, __doc__, SECTIONS)


if __name__ == "__main__":
    sys.exit(main())
