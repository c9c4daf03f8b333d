"""Show what passes on a CAN bus of MKS drives, in words. Listens only: nothing is ever sent.

Each line has the time in seconds, the frame as candump writes it, > for a request, < for an answer
and ? for what is none of this dialect; a check byte that is wrong is said. Frames of other devices
are shown as they are.

On socketcan any number of programs listen beside the one that drives. An slcan adapter is a
serial port, which one program alone can have: put a second adapter on the bus, or listen while
nobody drives. `armdrive record --arm NAME` writes down what an arm's own program has exchanged.

  armdrive can monitor can:socketcan:can0 --id 3
  armdrive can monitor --arm bench --seconds 10 --json

"""

from __future__ import annotations

import argparse
import contextlib
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from armdrive.cli.choosing import add_json_option
from armdrive.cli.numbers import count, number
from armdrive.cli.output import emit, say
from armdrive.errors import BadRequest

if TYPE_CHECKING:
    from armdrive.commissioning.frame_words import Said
    from armdrive.transports.can_address import CanAddress
    from armdrive.transports.link import Link

ONE_PROGRAM = (
    "A serial adapter is one program's alone: listen by a second adapter on the bus, or have "
    "`armdrive record` write down what the other program exchanges"
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("port", nargs="?", metavar="PORT", help="can:INTERFACE:CHANNEL?...")
    parser.add_argument("--arm", metavar="NAME", help="instead: the adapter of an arm file")
    parser.add_argument(
        "--id", action="append", type=_node, default=[], metavar="ID", help="these ids alone"
    )
    parser.add_argument("--seconds", type=number, metavar="S", help="end after so long")
    parser.add_argument("--count", type=count, metavar="N", help="end after so many frames")
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """Listen until it is enough, or Ctrl-C."""
    from armdrive.transports.refusals import PortInUse
    from armdrive.transports.url import open_link

    try:
        link = open_link(str(_address(options)), 0)
    except PortInUse as error:
        raise PortInUse(f"{error}. {ONE_PROGRAM}") from None
    heard = 0
    try:
        with contextlib.suppress(KeyboardInterrupt):
            for time_s, said in _heard(link, options.seconds, frozenset(options.id)):
                emit(said.view(time_s)) if options.json else say(said.line(time_s))
                heard += 1
                if heard == options.count:
                    break
    finally:
        link.close()
    if not heard and not options.json:
        say(
            "nothing passed. An idle bus of drives is silent: they speak when they are asked. Nor "
            "is anything heard at another bit rate: `armdrive doctor --can` looks into that"
        )
    return 0


def _node(word: str) -> int:
    try:
        found = int(word, 0)
    except ValueError:
        found = -1
    if found < 0:
        raise argparse.ArgumentTypeError(f"an id is a number, 3 or 0x1F say, not {word!r}")
    return found


def _address(options: argparse.Namespace) -> CanAddress:
    from armdrive.connecting import find, simulation_forced
    from armdrive.transports.can_address import CanAddress, is_can
    from armdrive.wiring import Wiring

    if simulation_forced():
        raise BadRequest("ARMDRIVE_FORCE_SIM is set, so no bus is opened: clear that variable")
    if bool(options.port) == bool(options.arm):
        raise BadRequest("name one bus, or an arm file with --arm; `armdrive ports` lists them")
    port = str(options.port or Wiring(find(options.arm).config).find())
    if not is_can(port):
        raise BadRequest(
            f"{port} is no CAN bus: write can:INTERFACE:CHANNEL, `armdrive ports` lists them"
        )
    return replace(CanAddress.parse(port), ids=frozenset()).listening()


def _heard(link: Link, seconds: float | None, ids: frozenset[int]) -> Iterator[tuple[float, Said]]:
    """Give the frames as they come, with the time since the bus was opened."""
    from armdrive.commissioning.frame_words import Ear
    from armdrive.doctor.carrying import RealClock
    from firmware_protocol.frames import Unpacker

    clock, ear, unpacker = RealClock(), Ear(), Unpacker()
    began_s = clock.now_s()
    end_s = math.inf if seconds is None else began_s + seconds
    while (now_s := clock.now_s()) < end_s:
        for frame in unpacker.feed(link.read(now_s)):
            said = ear.hear(frame)
            if not ids or frame.can_id in ids:
                yield now_s - began_s, said
        clock.sleep(link, min(end_s, now_s + 1.0))
