"""The row of the simulated arm on MKS drives: how it is made for an arm, and its settings."""

from __future__ import annotations

import re

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.bus.drives import switches
from armdrive.sim.device import Option, Options
from armdrive.sim.mks.device import SimMks, drive_settings
from armdrive.sim.mks.node import ClosedLoopDrive, Flash, MksNode, MksQuirks
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world.arm import World
from firmware_protocol.errors import BadField
from firmware_protocol.mks import COUNTS_PER_TURN, LATEST, Bitrate, Version, abilities_of

AS_THE_ARM_FILE = "file"
_FIRMWARE = re.compile(r"\d{1,3}\.\d{1,3}\.\d{1,3}")
_ANSWER_MS = (0.0, 1000.0)


def _make(config: ArmConfig, world: World, options: Options) -> SimMks:
    count = len(world.motors)
    bitrates = {each.bits_s: each for each in Bitrate}
    bits_s = options.whole("bitrate")
    if bits_s not in bitrates:
        raise BadRequest(f"bitrate is one of {', '.join(map(str, bitrates))}, not {bits_s}")
    versions = _versions(options.text("firmware"), config, count)
    drive, quirks = ClosedLoopDrive(world), _quirks(options)
    settings = drive_settings(
        config,
        count,
        bitrates[bits_s],
        factory=options.flag("factory"),
        limits=options.flag("limits"),
        stall_protection=options.flag("stall_protection"),
    )
    wired = switches(config, drive)
    nodes = [
        MksNode(index, versions[index], Flash(settings[index]), drive, wired[index], quirks)
        for index in range(count)
    ]
    return SimMks(world, drive, nodes, bits_s)


def _versions(text: str, config: ArmConfig, count: int) -> tuple[Version, ...]:
    """Return the firmware of each drive, from one for all of them or one for each."""
    if text == AS_THE_ARM_FILE:
        text = getattr(config.device, "firmware", "") or ".".join(map(str, LATEST))
    words = [word.strip() for word in text.split("+")]
    words = words * count if len(words) == 1 else words
    if len(words) != count or not all(map(_FIRMWARE.fullmatch, words)):
        raise BadRequest(
            f'firmware is written "1.0.9", or as {count} of them joined by +, not {text!r}'
        )
    return tuple(map(_version, words))


def _version(word: str) -> Version:
    first, second, third = map(int, word.split("."))
    try:
        abilities_of((first, second, third))
    except BadField as error:
        raise BadRequest(str(error)) from None
    return first, second, third


def _quirks(options: Options) -> MksQuirks:
    answer_ms, stall_turns = options.number("answer_ms"), options.number("stall_turns")
    if not _ANSWER_MS[0] <= answer_ms <= _ANSWER_MS[1]:
        raise BadRequest(f"answer_ms is from 0 to {_ANSWER_MS[1]:g}, not {answer_ms:g}")
    if not 0.0 < stall_turns <= 1.0:
        raise BadRequest(f"stall_turns is above 0 and at most 1, not {stall_turns:g}")
    return MksQuirks(
        says_done=options.flag("says_done"),
        says_refused=options.flag("says_refused"),
        superseded=options.text("superseded"),
        keeps_angle=options.flag("keeps_angle"),
        enabled_on=options.flag("enabled_on"),
        watchdog_hears_all=options.flag("watchdog_hears_all"),
        stays_armed=options.flag("stays_armed"),
        new_id_answers=options.flag("new_id_answers"),
        version_bytes=2 if options.flag("short_version") else 3,
        answer_s=answer_ms / 1000,
        stall_counts=round(stall_turns * COUNTS_PER_TURN),
    )


KIND = SimDeviceKind(
    title="arm on MKS drives",
    device=SimMks,
    make=_make,
    options=(
        Option("firmware", AS_THE_ARM_FILE, "1.0.6 say, or one a drive joined by +; file: its own"),
        Option("factory", False, "every drive as it is shipped: id 1, waiting for pulses"),
        Option("bitrate", 500_000, "bits a second of the drives and their bus"),
        Option("limits", False, "a pressed limit switch ends motions that lead into it"),
        Option("stall_protection", True, "a drive that stalls lets its shaft go, and says so"),
        Option("stall_turns", 0.1, "turns behind its set-point that are a stall"),
        Option("enabled_on", True, "drives hold their shafts as soon as they have power"),
        Option("keeps_angle", False, "after power-on a position is the angle within a turn, not 0"),
        Option("says_done", True, "drives say that a motion is done"),
        Option("says_refused", True, "drives say that they do not do a thing now"),
        Option(
            "superseded",
            "first",
            "when a replaced motion is said to have failed: before or after the new one has begun",
            ("first", "last", "never"),
        ),
        Option("stays_armed", False, "a synchronous start does not end the storing of motions"),
        Option("watchdog_hears_all", False, "frames to other drives feed a drive's watchdog too"),
        Option("new_id_answers", True, "a drive that is given an id answers by the new one"),
        Option("short_version", False, "drives tell two bytes of their version, not three"),
        Option("answer_ms", 0.2, "milliseconds until a drive has its answer ready"),
    ),
)
