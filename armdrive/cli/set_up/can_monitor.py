"""Shows the frames on a CAN bus in words. It only listens, and sends nothing."""

from __future__ import annotations

import argparse
import contextlib
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

from armdrive.cli.presenter import Result, put_error, show, tell
from armdrive.config.arm import ArmConfig
from armdrive.connect.port import PortOpening, lock_names
from armdrive.connect.target import find, require_real_ports
from armdrive.dialects import Language
from armdrive.errors import BadRequest, HolderError, PortInUse
from armdrive.registry import LANGUAGES, USUAL, language_of
from armdrive.setup.dialog_runner import RealClock
from armdrive.storage.lock_client import holder_words, is_held, name_held, tap_holder
from armdrive.transports import opening
from armdrive.transports.address import CanAddress, is_can
from armdrive.transports.link import Link
from firmware_protocol.frames import Frame, Unpacker
from kinematics.text import counted

ONE_PROGRAM = (
    "Only one program can open a serial adapter: listen with a second adapter on the bus. If an "
    "armdrive of yours holds the arm, `armdrive can monitor --arm NAME` shows its frames"
)


def monitor(options: argparse.Namespace) -> int:
    """Listen until the time or the count is reached, or Ctrl-C."""
    require_real_ports()
    if bool(options.port) == bool(options.arm):
        raise BadRequest("name one bus, or an arm file with --arm; `armdrive ports` lists them")
    config = find(options.arm).config if options.arm else None
    language = USUAL if config is None else language_of(config.connection.dialect)
    language = LANGUAGES.get(options.protocol, language)
    address = _address(options, config)
    try:
        link = opening.open_link(str(address), 0)
    except PortInUse as error:
        name = name_held(*((options.port,) if config is None else lock_names(config)))
        if not is_held(name):
            raise PortInUse(f"{error}. {ONE_PROGRAM}") from None
        frames = held_frames(name, options.seconds, _passed_over)
        tell(options, f"{holder_words(name)} holds {name}: these are its frames")
        shown, foreign = _shown(options, language, frames)
    else:
        try:
            shown, foreign = _shown(options, language, _heard(link, options.seconds))
        finally:
            link.close()
    if explanation := _explanation(language, shown, foreign):
        tell(options, explanation)
    return 0


def _shown(
    options: argparse.Namespace, language: Language, frames: Iterator[tuple[float, Frame]]
) -> tuple[int, int]:
    """Print frames as they come; return how many, and how many of them were unreadable."""
    shown = foreign = 0
    describer, ids = language.describer(), frozenset(options.id)
    with contextlib.suppress(KeyboardInterrupt):
        for time_s, frame in frames:
            message = describer.describe(frame)
            if ids and message.node not in ids:
                continue
            show(Result(message.view(time_s), message.line(time_s)), options)
            shown, foreign = shown + 1, foreign + message.foreign
            if shown == options.count:
                break
    return shown, foreign


def _passed_over(count: int) -> None:
    missing = counted(count, "exchange is missing: it", "exchanges are missing: they")
    put_error(f"{missing} came faster than could be shown\n")


def _explanation(language: Language, shown: int, foreign: int) -> str:
    """Return what it may mean if no frame, or no readable one, came; else an empty text."""
    if not shown:
        return (
            f"no frame came. {language.silence}. A wrong bit rate looks the same: `armdrive doctor "
            "--can` tells them apart"
        )
    if 2 * foreign > shown:
        others = " or ".join(f"--protocol {name}" for name in LANGUAGES if name != language.name)
        return (
            f"{foreign} of {counted(shown, 'frame is', 'frames are')} not from "
            f"{language.title}: try {others}"
        )
    return ""


def _address(options: argparse.Namespace, config: ArmConfig | None) -> CanAddress:
    port = str(options.port if config is None else PortOpening(config).find())
    if not is_can(port):
        raise BadRequest(
            f"{port} is no CAN bus: write can:INTERFACE:CHANNEL, `armdrive ports` lists them"
        )
    return replace(CanAddress.parse(port), ids=frozenset()).listening()


def _heard(link: Link, seconds: float | None) -> Iterator[tuple[float, Frame]]:
    """Yield the frames as they come, with the time since the bus was opened."""
    clock, unpacker = RealClock(), Unpacker()
    began_s = clock.now_s()
    end_s = math.inf if seconds is None else began_s + seconds
    while (now_s := clock.now_s()) < end_s:
        for frame in unpacker.feed(link.read(now_s)):
            yield now_s - began_s, frame
        clock.sleep(link, min(end_s, now_s + 1.0))


# The frames of an adapter that another program of the same user has open, sent by that program.

# How often the other program sends its frames.
EVERY_S = 0.05


def held_frames(
    name: str, seconds: float | None, missed: Callable[[int], None]
) -> Iterator[tuple[float, Frame]]:
    """Yield the frames of the program that holds an arm, with the time since the first one.

    Ends after `seconds`, or when that program closes the arm. `missed` is called with the number of
    exchanges that came too fast. Raises `HolderError` if the program does not answer.
    """
    sides = {"sent": Unpacker(), "received": Unpacker()}
    end_s = time.monotonic() + (math.inf if seconds is None else seconds)
    began_s: float | None = None
    for message in tap_holder(name, EVERY_S):
        if "error" in message:
            raise HolderError(str(message["error"]))
        if message.get("missed"):
            missed(int(message["missed"]))
            sides = {side: Unpacker() for side in sides}  # half of a frame may be missing
        for time_s, side, data in message.get("wire", ()):
            began_s = time_s if began_s is None else began_s
            for frame in sides[side].feed(bytes.fromhex(data)):
                yield time_s - began_s, frame
        if time.monotonic() >= end_s:
            return
