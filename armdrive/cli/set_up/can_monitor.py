"""Show what passes on a CAN bus of drives, in words. Listens only: nothing is ever sent."""

from __future__ import annotations

import argparse
import contextlib
import math
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

from armdrive.cli.presenter import Result, put_error, show, tell
from armdrive.config.arm import ArmConfig
from armdrive.connect.port import PortOpening
from armdrive.connect.target import find, simulation_forced
from armdrive.dialects.dialect import Language
from armdrive.errors import ArmError, BadRequest, PortInUse
from armdrive.registry import LANGUAGES, USUAL, language_of
from armdrive.setup.dialog_runner import RealClock
from armdrive.storage.lock_client import holder_words, notice_of, overhear_holder
from armdrive.transports import opening
from armdrive.transports.address import is_can
from armdrive.transports.can_address import CanAddress
from armdrive.transports.link import Link
from firmware_protocol.frames import Frame, Unpacker

ONE_PROGRAM = (
    "A serial adapter is one program's alone: listen by a second adapter on the bus. What an "
    "armdrive of yours exchanges, `armdrive can monitor --arm NAME` shows while it holds that arm"
)


def monitor(options: argparse.Namespace) -> int:
    """Listen until it is enough, or Ctrl-C."""
    config = _config(options)
    language = _language(options, config)
    address = _address(options, config)
    try:
        link = opening.open_link(str(address), 0)
    except PortInUse as error:
        name = holder_of("" if config is None else config.name, options.port or "")
        if not name:
            raise PortInUse(f"{error}. {ONE_PROGRAM}") from None
        frames = held_frames(name, options.seconds, _passed_over)
        tell(options, f"{holder_words(name)} holds {name}: this is what it sends and hears")
        shown, foreign = _shown(options, language, frames)
    else:
        try:
            shown, foreign = _shown(options, language, _heard(link, options.seconds))
        finally:
            link.close()
    if said := _explanation(language, shown, foreign):
        tell(options, said)
    return 0


def _shown(
    options: argparse.Namespace, language: Language, frames: Iterator[tuple[float, Frame]]
) -> tuple[int, int]:
    """Print frames as they come; return how many, and how many of those were not readable."""
    shown = foreign = 0
    ear, ids = language.ear(), frozenset(options.id)
    with contextlib.suppress(KeyboardInterrupt):
        for time_s, frame in frames:
            said = ear.hear(frame)
            if ids and said.node not in ids:
                continue
            show(Result(said.view(time_s), said.line(time_s)), options)
            shown, foreign = shown + 1, foreign + said.foreign
            if shown == options.count:
                break
    return shown, foreign


def _passed_over(count: int) -> None:
    put_error(f"{count} exchanges were passed over: they came faster than they were shown\n")


def _explanation(language: Language, shown: int, foreign: int) -> str:
    """Say what it may mean that nothing, or nothing readable, was heard; else nothing."""
    if not shown:
        return (
            f"nothing passed. {language.silence}. Nor is anything heard at another bit rate: "
            "`armdrive doctor --can` looks into that"
        )
    if 2 * foreign > shown:
        others = " or ".join(f"--protocol {name}" for name in LANGUAGES if name != language.name)
        return f"{foreign} of {shown} frames are none of {language.title}: try {others}"
    return ""


def _language(options: argparse.Namespace, config: ArmConfig | None) -> Language:
    if options.protocol:
        return LANGUAGES[options.protocol]
    return USUAL if config is None else language_of(config.connection.dialect)


def _config(options: argparse.Namespace) -> ArmConfig | None:
    """Return the arm whose bus is meant, where one is named. Raises `BadRequest`."""
    if simulation_forced():
        raise BadRequest("ARMDRIVE_FORCE_SIM is set, so no bus is opened: clear that variable")
    if bool(options.port) == bool(options.arm):
        raise BadRequest("name one bus, or an arm file with --arm; `armdrive ports` lists them")
    return find(options.arm).config if options.arm else None


def _address(options: argparse.Namespace, config: ArmConfig | None) -> CanAddress:
    port = str(options.port if config is None else PortOpening(config).find())
    if not is_can(port):
        raise BadRequest(
            f"{port} is no CAN bus: write can:INTERFACE:CHANNEL, `armdrive ports` lists them"
        )
    return replace(CanAddress.parse(port), ids=frozenset()).listening()


def _heard(link: Link, seconds: float | None) -> Iterator[tuple[float, Frame]]:
    """Give the frames as they come, with the time since the bus was opened."""
    clock, unpacker = RealClock(), Unpacker()
    began_s = clock.now_s()
    end_s = math.inf if seconds is None else began_s + seconds
    while (now_s := clock.now_s()) < end_s:
        for frame in unpacker.feed(link.read(now_s)):
            yield now_s - began_s, frame
        clock.sleep(link, min(end_s, now_s + 1.0))


# The frames of a bus whose adapter another program of the same user has, as that program tells.

EVERY_S = 0.05
"""The holder looks so often at what has passed."""


def holder_of(arm: str, port: str) -> str:
    """Return the name under which a program holds an arm, or the port; empty where none does.

    A port is known to its holder as the arm file writes it.
    """
    return next((name for name in (arm, port) if name and notice_of(name) is not None), "")


def held_frames(
    name: str, seconds: float | None, missed: Callable[[int], None]
) -> Iterator[tuple[float, Frame]]:
    """Yield what the holder of an arm says and hears, with the time since this began.

    Ends with the time, or when the arm is given back. `missed` is told how many exchanges were
    passed over, as a reader that is too slow has to. Raises `ArmError` where nobody tells.
    """
    sides = {"sent": Unpacker(), "heard": Unpacker()}
    end_s = time.monotonic() + (math.inf if seconds is None else seconds)
    began_s: float | None = None
    for told in overhear_holder(name, EVERY_S):
        if "error" in told:
            raise ArmError(str(told["error"]))
        if told.get("missed"):
            missed(int(told["missed"]))
            sides = {side: Unpacker() for side in sides}  # the other half of a frame may have gone
        for time_s, side, data in told.get("wire", ()):
            began_s = time_s if began_s is None else began_s
            for frame in sides[side].feed(bytes.fromhex(data)):
                yield time_s - began_s, frame
        if time.monotonic() >= end_s:
            return
