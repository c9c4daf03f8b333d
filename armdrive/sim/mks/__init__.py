"""Simulated arms on MKS drives: how one is made, and its options.

`node` is one drive, `motion` how it moves.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.bus.node import Quirk, motors_of, node_ids, options_of
from armdrive.sim.device import Option, Options
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.mks.motion import MAKES_UP, Flash
from armdrive.sim.mks.node import MksNode, SavedMksDrive
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world import World
from firmware_protocol import mks
from firmware_protocol.errors import BadField

AS_THE_ARM_FILE = "file"
HOMING_RPM = 60
BITRATES = {each.bits_s: each for each in mks.Bitrate}
USUAL_MA, USUAL_MICROSTEPS = 1600, 16
_FIRMWARE = re.compile(r"\d{1,3}\.\d{1,3}\.\d{1,3}")


@dataclass(frozen=True, slots=True)
class SavedMksDrives:
    """What is saved of the drives."""

    drives: tuple[SavedMksDrive, ...]


class MksBoard(DrivesBoard[MksNode]):
    """The MKS drives of an arm."""

    saved_as = SavedMksDrives
    title = "arm on MKS drives"


def _make(config: ArmConfig, world: World, options: Options) -> MksBoard:
    count, bits_s = len(world.motors), options.whole("bitrate")
    versions = _versions(options.text("firmware"), config, count)
    settings = _settings(config, count, BITRATES[bits_s], options)
    shafts = ShaftDrive(world, MAKES_UP)
    nodes = [
        MksNode(motor, version, Flash(own), options, bits_s)
        for motor, version, own in zip(motors_of(config, shafts), versions, settings, strict=True)
    ]
    return MksBoard(world, shafts, nodes, bits_s)


def _settings(
    config: ArmConfig, count: int, bitrate: mks.Bitrate, options: Options
) -> list[list[mks.Setting]]:
    """Return the settings of each drive as set up for this arm; of new ones, the speed.

    The arm file's own section is read without the driver's class. The driver's figures stay its
    own, so that a difference shows.
    """
    device: Any = config.device
    ids = node_ids(getattr(device, "ids", ()), count)
    if options.flag("factory"):
        return [[mks.SetBitrate(bitrate)] for _ in ids]
    homing = mks.SetHoming(
        active_high=False,
        counter_clockwise=True,
        speed_rpm=HOMING_RPM,
        limits=options.flag("limits"),
        method=0,
    )
    try:
        return [
            [
                mks.SetBitrate(bitrate),
                mks.SetId(node),
                mks.SetMode(mks.Mode.BUS_FOC),
                mks.SetCurrent(getattr(device, "current_ma", 0) or USUAL_MA),
                mks.SetMicrosteps(getattr(device, "microsteps", 0) or USUAL_MICROSTEPS),
                mks.SetStallProtection(options.flag("stall_protection")),
                homing,
            ]
            for node in ids
        ]
    except BadField as error:
        raise BadRequest(str(error)) from None


def _versions(text: str, config: ArmConfig, count: int) -> tuple[mks.Version, ...]:
    """Return the firmware of each drive, from one for all of them or one for each."""
    if text == AS_THE_ARM_FILE:
        text = getattr(config.device, "firmware", "") or ".".join(map(str, mks.LATEST))
    words = [word.strip() for word in text.split("+")]
    words = words * count if len(words) == 1 else words
    if len(words) != count or not all(map(_FIRMWARE.fullmatch, words)):
        raise BadRequest(
            f'firmware is written "1.0.9", or as {count} of them joined by +, not {text!r}'
        )
    return tuple(map(_version, words))


def _version(word: str) -> mks.Version:
    first, second, third = map(int, word.split("."))
    try:
        mks.abilities_of((first, second, third))
    except BadField as error:
        raise BadRequest(str(error)) from None
    return first, second, third


# Peculiarities of real MKS drives, and points on which no source says what they do.

_MANUALS = "CAN manuals 1.0.6 and 1.0.9"
_NOTES = "version notes of makerbase-motor/MKS-SERVO42D-57D"
_UNKNOWN = "not published, and no real drive was measured"

# Each row: name, default, what it does, source. A quirk without a default is always on.
# fmt: off
QUIRKS: tuple[Quirk, ...] = (
    Quirk("stall_turns", 0.1, "following error, in turns, at which a drive reports a stall",
          _UNKNOWN, guess=True, least=0.001, most=1.0),
    Quirk("enabled_on", True, "drives hold their shafts as soon as they are powered",
          "not published; a drive that holds again counts from a new zero", guess=True),
    Quirk("keeps_angle", False, "after power-on a position is the angle within a turn, not 0",
          "the manual 1.0.9: the power-on position is the zero (11.4.4); first readings of owners "
          "were 3 (TRazDev/servo42es-esp32-can-controller) and -5 (riccardi-samuele/mks-servo)"),
    Quirk("says_done", True, "drives report the end of a motion",
          f"{_MANUALS}: reply 2, seen on CAN (TRazDev/servo42es-esp32-can-controller); not "
          "always from firmware 1.0.5 with RS485 (makerbase-motor/MKS-SERVO42D-57D, issue 20)"),
    Quirk("says_refused", True, "drives report that they refuse an order",
          f"{_MANUALS}: reply 0, failed; in a pulse mode 3dberg/arctos-pi saw orders dropped"),
    Quirk("brakes_on", False, "after a motion, drives report braking until the next one begins",
          "observed on a SERVO42D with firmware 1.0.6 and RS485 (riccardi-samuele/mks-servo, "
          "FAQ, F1 stays at 3); not reported from a CAN bus"),
    Quirk("keeps_count", False, "a new zero, also by homing, moves the targets but no reading (31)",
          "observed on a SERVO42D with RS485 (riccardi-samuele/mks-servo-cpp, CHANGELOG 0.3.0, "
          "set_origin); not known from CAN, where 3dberg/arctos-pi expects 0 and warns otherwise"),
    Quirk("flash_ms", 0.0, "milliseconds for which a drive is deaf after a setting was written",
          "about 200 observed with RS485 (riccardi-samuele/mks-servo-cpp, design notes, 5); "
          "not reported from a CAN bus"),
    Quirk("e_series", False, "drives report that they are of the E series; else they stay the same",
          "a SERVO42ES answered `40 92 01 00 01` (TRazDev/servo42es-esp32-can-controller, "
          "protocol notes)"),
    Quirk("deaf_after_limit", False, "a drive ignores its first motion after a limit stop",
          "observed on a SERVO57D on CAN (kkhyunhho/MKSServo57DCANController); that "
          "it answers as if it had begun is a guess", guess=True),
    Quirk("retarget_creeps", False,
          "a new target (F5) that comes before a drive brakes for the old one makes it creep",
          "observed on a SERVO42D with firmware 1.0.6 and RS485: 2.7 s for what takes 1.06 s "
          "otherwise (riccardi-samuele/mks-servo-cpp, examples/hil_chained_moves.cpp); how slow it "
          "is, is a guess", guess=True),
    Quirk("superseded", "first",
          "when a replaced motion is reported as failed: before or after the new one has begun",
          "a public transcription of the manual does not say when; reported first, it "
          "looks like a refusal of the new one", ("first", "last", "never"), guess=True),
    Quirk("stays_armed", False, "drives keep storing motions after a synchronous start",
          f"{_MANUALS} do not say (4A, 4B)", guess=True),
    Quirk("watchdog_hears_all", False, "frames to other drives also reset a drive's watchdog",
          "the manual 1.0.9 does not say (98); if not, each needs frames of its own", guess=True),
    Quirk("new_id_answers", True, "a drive answers a change of its id under the new id",
          "the authors of a public driver (zauberzeug/lizard); not in the manuals (8B)"),
    Quirk("short_version", False, "drives report two bytes of their version instead of three",
          "the manual 1.0.9 draws two and names three; a SERVO42ES sent three "
          "(TRazDev/servo42es-esp32-can-controller, protocol notes)"),
    Quirk("answer_ms", 1.0, "milliseconds until a drive has its answer ready",
          "not measured on CAN; with RS485 up to 700 in motion (riccardi-samuele/mks-servo, test "
          "report, 6.5); a late answer describes an older state", guess=True),
    Quirk("boot_ms", 150.0, "milliseconds from a restart until a drive holds and answers again",
          f"{_UNKNOWN}; a fast restart is harder to notice", guess=True),
    Quirk("silent_restart", None,
          "a drive restarts without a message, counts from a new zero, and obeys the next order",
          "no known manual or program has a boot message or heartbeat", guess=True),
    Quirk("silent_watchdog", None, "a drive stopped by its watchdog sends no message",
          "no known manual or program has a reply for it (98)", guess=True),
    Quirk("silent_group", None, "from 1.0.2 on, drives do not answer broadcasts and groups",
          f"{_NOTES}, V1.0.2"),
    Quirk("done_anyway", None,
          "before 1.0.8, a motion ends with its set-point, wherever the shaft is",
          f"the in-position threshold came with V1.0.8 ({_NOTES})", guess=True),
    Quirk("one_stop", None, "any stop command ends every motion and drops stored ones",
          "the manuals describe each stop only with its own kind of motion", guess=True),
    Quirk("pulls_on", None,
          "without protection, a blocked drive keeps pulling and jumps to its set-point when freed",
          "any closed loop does; no manual describes it", guess=True),
)
# fmt: on


KIND = SimDeviceKind(
    title=MksBoard.title,
    board=MksBoard,
    make=_make,
    options=(
        Option(
            "firmware",
            AS_THE_ARM_FILE,
            "for example 1.0.6, or one for each drive, joined by +; file: the arm file's",
        ),
        Option("factory", False, "every drive as it is shipped: id 1, waiting for pulses"),
        Option("bitrate", 500_000, "bits a second of the drives and their bus", (*BITRATES,)),
        Option("limits", False, "a pressed limit switch ends motions that lead into it"),
        Option("stall_protection", True, "a drive that stalls lets its shaft go, and says so"),
        *options_of(QUIRKS),
    ),
)
