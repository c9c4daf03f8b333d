"""What can be chosen of simulated MKS drives.

A setting with a `source` is a quirk: a peculiarity of real drives, or a point on which no source
says what they do. A guess was never measured; its default is the behaviour that is harder for a
driver, if there is one.
"""

from __future__ import annotations

from dataclasses import dataclass

from armdrive.text.toml import setting
from firmware_protocol.mks import Bitrate

AS_THE_ARM_FILE = "file"
BITRATES = {each.bits_s: each for each in Bitrate}
_MANUALS = "CAN manuals 1.0.6 and 1.0.9"


# fmt: off
@dataclass(frozen=True, slots=True)
class MksQuirks:
    """The settings of simulated drives."""

    firmware: str = setting(AS_THE_ARM_FILE,
        "for example 1.0.6, or one for each drive, joined by +; file: the arm file's")
    factory: bool = setting(False, "every drive as it is shipped: id 1, waiting for pulses")
    bitrate: int = setting(500_000, "bits a second of the drives and their bus", words=(*BITRATES,))
    limits: bool = setting(False, "a pressed limit switch ends motions that lead into it")
    stall_protection: bool = setting(True,
        "a drive that stalls lets its shaft go, and says so")

    enabled_on: bool = setting(True, "drives hold their shafts as soon as they are powered",
        source="guess: not published; a drive that holds again counts from a new zero")
    keeps_angle: bool = setting(False,
        "after power-on a position is the angle within a turn, not 0",
        source="the manual 1.0.9: the power-on position is the zero (11.4.4); first readings of "
        "owners were 3 (TRazDev/servo42es-esp32-can-controller) and -5 "
        "(riccardi-samuele/mks-servo)")
    says_done: bool = setting(True, "drives report the end of a motion",
        source=f"{_MANUALS}: reply 2, seen on CAN (TRazDev/servo42es-esp32-can-controller); not "
        "always from firmware 1.0.5 with RS485 (makerbase-motor/MKS-SERVO42D-57D, issue 20)")
    says_refused: bool = setting(True, "drives report that they refuse an order",
        source=f"{_MANUALS}: reply 0, failed; in a pulse mode 3dberg/arctos-pi saw orders dropped")
    brakes_on: bool = setting(False,
        "after a motion, drives report braking until the next one begins",
        source="observed on a SERVO42D with firmware 1.0.6 and RS485 (riccardi-samuele/mks-servo, "
        "FAQ, F1 stays at 3); not reported from a CAN bus")
    keeps_count: bool = setting(False,
        "a new zero, also by homing, moves the targets but no reading (31)",
        source="observed on a SERVO42D with RS485 (riccardi-samuele/mks-servo-cpp, CHANGELOG "
        "0.3.0, set_origin); not known from CAN, where 3dberg/arctos-pi expects 0 and warns "
        "otherwise")
    homes_reversed: bool = setting(False,
        "drives home in the other direction than is set (90)",
        source="observed on a SERVO57D on CAN (kkhyunhho/MKSServo57DCANController); a drive whose "
        "direction was set wrong does the same")
    flash_ms: float = setting(0.0,
        "milliseconds for which a drive is deaf after a setting was written", low=0.0, high=1000.0,
        source="about 200 observed with RS485 (riccardi-samuele/mks-servo-cpp, design notes, 5); "
        "not reported from a CAN bus")
    e_series: bool = setting(False,
        "drives report that they are of the E series; else they stay the same",
        source="a SERVO42ES answered `40 92 01 00 01` (TRazDev/servo42es-esp32-can-controller, "
        "protocol notes)")
    deaf_after_limit: bool = setting(False, "a drive ignores its first motion after a limit stop",
        source="guess: observed on a SERVO57D on CAN (kkhyunhho/MKSServo57DCANController); that "
        "it answers as if it had begun is a guess")
    retarget_creeps: bool = setting(False,
        "a new target (F5) that comes before a drive brakes for the old one makes it creep",
        source="guess: observed on a SERVO42D with firmware 1.0.6 and RS485: 2.7 s for what takes "
        "1.06 s otherwise (riccardi-samuele/mks-servo-cpp, examples/hil_chained_moves.cpp); how "
        "slow it is, is a guess")
    superseded: str = setting("first",
        "when a replaced motion is reported as failed: before or after the new one has begun",
        words=("first", "last", "never"),
        source="guess: a public transcription of the manual does not say when; reported first, it "
        "looks like a refusal of the new one")
# fmt: on
