"""What an arm file says in `[grbl]`: how a GRBL board is wired to the arm and set up."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from datetime import date

from armdrive.errors import ArmFileError
from armdrive.sections import within
from firmware_protocol.grbl import AXIS_LETTERS

UNITS = ("steps", "degrees")
SERVOS = re.compile(r"M3|M6[78]E[0-9]{1,2}")
OUTPUTS = re.compile(r"flood|mist|P[0-9]{1,2}")
PINS = "PDHSRXYZABC"
"""The letters of a report's pins, as input bits: probe, door, hold, start, reset, limits."""


@dataclass(frozen=True, slots=True)
class GrblSettings:
    """A GRBL board as it is wired and set up.

    `axes` gives the letter of each motor, in the arm's order; `unit` says what the board's "mm"
    is: one motor step ($100=1), or one degree of what the motor's row calls a turn (one mm for a
    gripper's motor). `rates` and `accelerations` are expected of the motors, in steps a second and
    steps a second squared; left out, the joints' full speed within `ramp_s`. `travel` is in the
    board's units. `junction_steps` is $11 in motor steps. `soft_limits`, `hard_limits` and
    `homing` are what $20, $21 and $22 should be. `hard_limits_checked` is the day on which every
    limit switch was seen to raise an alarm, 2026-11-23 say: `armdrive config limits` writes it.
    `idle_key` is the setting that keeps the motors
    on, `1` of GRBL where it is left out.

    `outputs` names what each output bit switches: flood, mist, or P0, P1 ... The gripper's servo
    is told `servo` with a number between `servo_closed` and `servo_open`; a gripper on an output
    has it on bit `gripper_output`, which closes it when on, or opens it.

    Times: a report is asked for every `poll_s` in motion, and a board that gives none for `mute_s`
    is mute; an answer is waited for `answer_s`, a board that was reset by opening its port
    `boot_s`, homing `homing_s`. `segments` is how many segments of motion
    the board computes ahead; left out, as its firmware does (`grbl_segments`). A motor may be
    `corridor_steps` off the path sent.
    """

    axes: str = "XYZABC"
    unit: str = "steps"
    ramp_s: float = 0.1
    rates: tuple[float, ...] = ()
    accelerations: tuple[float, ...] = ()
    travel: tuple[float, ...] = ()
    junction_steps: float = 1.0
    soft_limits: bool = False
    hard_limits: bool = False
    hard_limits_checked: str = ""
    homing: bool = False
    idle_key: str = ""
    outputs: tuple[str, ...] = ("flood",)
    servo: str = "M3"
    servo_closed: float = 0.0
    servo_open: float = 1000.0
    gripper_output: int = 0
    gripper_closes: bool = True
    corridor_steps: float = 2.0
    max_segments: int = 15
    poll_s: float = 0.05
    mute_s: float = 1.0
    answer_s: float = 1.0
    boot_s: float = 4.0
    homing_s: float = 120.0
    segments: int | None = None

    def __post_init__(self) -> None:
        letters = self.axes
        if not letters or set(letters) - set(AXIS_LETTERS) or len(set(letters)) != len(letters):
            raise ArmFileError(
                f"grbl.axes gives each motor a letter of its own out of {AXIS_LETTERS}, not "
                f"{letters!r}"
            )
        if self.unit not in UNITS:
            raise ArmFileError(f"grbl.unit is one of {', '.join(UNITS)}, not {self.unit!r}")
        if not SERVOS.fullmatch(self.servo):
            raise ArmFileError(f"grbl.servo is M3, or M67E0 and the like, not {self.servo!r}")
        for word in self.outputs:
            if not OUTPUTS.fullmatch(word):
                raise ArmFileError(f"grbl.outputs names flood, mist, P0, P1 ..., not {word!r}")
        if self.hard_limits_checked and not _is_day(self.hard_limits_checked):
            raise ArmFileError(
                "grbl.hard_limits_checked is a day, written 2026-11-23, not "
                f"{self.hard_limits_checked!r}"
            )
        for each in fields(self):
            if each.name in _BOUNDS and getattr(self, each.name) is not None:
                within(f"grbl.{each.name}", getattr(self, each.name), *_BOUNDS[each.name])
            elif each.name in _LISTS:
                for value in getattr(self, each.name):
                    within(f"grbl.{each.name}", value, *_LISTS[each.name])

    @property
    def limit_inputs(self) -> Mapping[str, int]:
        """The input bit of each axis's limit switch, in the order of the motors."""
        return {letter: PINS.index(letter) for letter in self.axes}


def _is_day(word: str) -> bool:
    try:
        return date.fromisoformat(word).isoformat() == word
    except ValueError:
        return False


_LISTS = {"rates": (0.1, 1e6), "accelerations": (0.1, 1e8), "travel": (0.1, 1e6)}
_BOUNDS = {
    "ramp_s": (0.005, 10.0),
    "junction_steps": (0.001, 1000.0),
    "servo_closed": (0.0, 100_000.0),
    "servo_open": (0.0, 100_000.0),
    "gripper_output": (0, 7),
    "corridor_steps": (1.0, 1000.0),
    "max_segments": (1, 1000),
    "poll_s": (0.01, 0.2),
    "mute_s": (0.5, 10.0),
    "answer_s": (0.2, 30.0),
    "boot_s": (0.5, 30.0),
    "homing_s": (1.0, 290.0),
    "segments": (1, 100),
}
