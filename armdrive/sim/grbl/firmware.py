"""The boards of the GRBL family as data: firmware quirks and settings.

Unknown figures are guessed on the harsher side. Times are in seconds. Those of the 8-bit boards
were measured on the real firmware in a processor simulator. Where another board was observed, the
docstring says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from types import MappingProxyType

from armdrive.sim.mechanics.planner import PathLimits, Stepping
from firmware_protocol.grbl import (
    AxesInfo,
    Banner,
    Bracketed,
    BuildInfo,
    Dialect,
    Info,
    Variant,
    Version,
)


class Killed(Enum):
    """What a reset during a motion does to the motor current, even if $1 is 255.

    Sources: st_go_idle and mc_reset of gnea/grbl grbl/stepper.c and motion_control.c, and of
    grblHAL/core. Observed on FluidNC 4.0.5: after 0x18 at 400 steps/s, 44 steps in 0.11 s, at 50
    steps/s 17 in 0.32 s, and the position is exact.
    """

    LATE = "it is held for $1 with the interrupts off, then free until the board has restarted"
    AT_ONCE = "it is free until the board has restarted"
    NEVER = "the board restarts before $1 is over, and keeps the current on"
    RUNS_ON = "the computed segments are driven to their end, and the current stays on"


# The numbers of settings.
IDLE_MS, REPORT, JUNCTION = 1, 10, 11
HOMING_CYCLES = range(44, 50)
"""The axes that each cycle of grblHAL's `$H` homes."""
SLEEP_ENABLE = 62
"""grblHAL refuses `$SLP` while this is 0, as it is at the factory."""
EVERYTHING = 511
"""The factory's mask of grblHAL's reports; GRBL's has two bits only."""
SOFT_LIMITS, HARD_LIMITS, HOMING, HOMING_DIRECTIONS = 20, 21, 22, 23
HOMING_FEED, HOMING_SEEK, DEBOUNCE_MS, PULL_OFF = 24, 25, 26, 27
INCHES = 13
MOST_SPEED, LEAST_SPEED = 30, 31
STEPS, RATE, ACCELERATION, TRAVEL = 100, 110, 120, 130
ALWAYS_ON_MS = 255
"""The step idle delay that leaves the motors on."""
HOMING_BY_AXIS = 3
"""grblHAL's $22 with homing, and with `$HX` for single axes."""

_AVR_STEPPING = Stepping(5, 1e-3, 16e6 / (8 * 65535))
"""No slower than a 16-bit timer of a processor at 16 MHz, its clock divided by 8, can count."""


@dataclass(frozen=True, slots=True)
class Firmware:
    """One firmware on its usual board; the defaults are those of gnea/grbl on an ATmega328p.

    Units: bytes, steps per second, seconds.

    Sources: gnea/grbl, fra589/grbl-Mega-5X, grblHAL/core, bdring/FluidNC. "Observed" means on the
    Mega and an ATmega328P, running the unchanged firmware in an AVR simulator.
    """

    name: str
    variant: Variant = Variant.GRBL

    # capacities
    ring_bytes: int = 128
    """The size of the receive ring."""
    blocks: int = 15
    """How many lines the planner queues."""
    max_line: int = 79
    """The longest line in characters. Observed: the Mega takes more than 200, FluidNC 127."""
    stepping: Stepping = _AVR_STEPPING
    """How the board steps. A hold begins to brake after the segments already computed, and a line
    leaves the planner with its last segment. Observed, from a hold to the last step: 0.43 s (Mega)
    and 0.24 s (328p) at 31 steps/s, 0.27 s and 0.15 s at 50; 40 steps at 5, 10, 20 and 30 steps/s
    in 1.278 s each. Observed on grblHAL, from a hold to the last step: 0.43 to 0.46 s at 31
    steps/s, 0.27 s at 50, 0.19 s at 100; 5, 10 and 20 steps/s are what they say. Observed on
    FluidNC with the 20 MHz of an ESP32: 0.45 s at 39 steps/s, 0.33 s at 50, 0.23 s at 100; 40 steps
    at 5 to 30 steps/s in 1.022 s each.
    """
    # commands that it knows
    keeps_line: bool = False
    """Whether a reset out of a hold leaves the line that has been fetched meanwhile: it is carried
    out after the banner. Observed on FluidNC (Protocol.cpp, activeLine): it moved the arm.
    """
    reads_every_s: float = 0.0
    """How late real-time commands may be read while a line is executed, homing included. FluidNC
    then looks at its input every 51st time that its task runs (Serial.cpp, pollChannels). Observed:
    0.04 to 0.06 s from 0x18 in homing to `ALARM:6`.
    """
    edits_lines: bool = False
    """Whether a control character makes the board echo what it hears, until 0x0C. Observed on
    FluidNC (lineedit.cpp).
    """
    outputs: bool = False
    """Whether it knows M62 to M68. Observed: the Mega and the 328p refuse them with error 20."""
    keeps_speed: bool = False
    """Whether reports tell the last speed of a spindle that stands (M5). Observed on FluidNC."""
    unknown: frozenset[str] = frozenset()
    """Words that its build refuses with error 20. Observed: M7 on the 328p."""
    letters_to_home: int = 0
    """How many axes `$H` may name."""
    crlf_answers_twice: bool = True

    # durations
    parse_s: float = 0.35e-3
    """Parsing a line. Observed: 0.35 ms for an empty one."""
    plan_s: float = 0.85e-3
    """Planning a motion, in addition. Observed: the Mega takes 30 lines in 0.05 s, as fast as they
    arrive.
    """
    eeprom_s: float = 17e-3
    """Changing a setting."""
    deaf_in_eeprom: bool = True
    """Whether bytes that arrive meanwhile are lost."""
    alarm_s: float = 0.5
    """After an alarm its messages are sent before the board restarts, or FluidNC goes on ..."""
    start_s: float = 5e-3
    """... and this is how long the restart takes."""
    boot_s: float = 1.5
    """From a reset of the board to its banner; the motors have no current."""
    # alarms, resets and jogs
    killed: Killed = Killed.LATE
    """What becomes of the motors at a reset in motion."""
    mute_in_critical: bool = True
    """Whether `?` is unanswered after a limit alarm until the reset."""
    hard_limits: bool = True
    """Whether, with $21=1, a switch that closes raises an alarm. Observed: the default RAMPS build
    of the Mega accepts $21=1 and does nothing (grbl/cpu_map.h: DISABLE_HW_LIMITS_INTERRUPT).
    Reports show the pin.
    """
    silent_in_homing: bool = True
    cancel_clears_ring: bool = False
    """Whether a jog cancel clears the ring. Observed on the Mega: five of eight lines were
    answered.
    """
    cancel_keeps: int | None = None
    """How many of the computed segments a jog cancel lets run; all if None. Observed on grblHAL:
    at 31 steps/s the last step comes 0.07 to 0.14 s after 0x85, and 0.43 to 0.46 s after `!`.
    """
    cancel_hangs_s: float = 0.23e-3
    """A cancel that comes so shortly before the end of a jog leaves the board in Idle without
    reading lines. Observed: repeated every 20 ms, it hung 3 of 259 jogs of a Mega and 2 of 264 of a
    328p. A single one in the last 40 ms hung 3 of 120 jogs of grblHAL, which only a reset frees,
    with ALARM:3; its Simulator is slow to notice, so how short the time is on a board is a guess.
    """
    holds_jogs: bool = True
    """Whether a feed hold ends a jog. Observed: grblHAL ignores it (state_machine.c, state_set)."""
    refuses_on: bool = False
    """Whether g-code after a refused line is refused with the same error, until an empty line, a
    line that begins with `$` and is carried out, a jog cancel or a reset. Observed on grblHAL
    (protocol.c, protocol_main_loop).
    """
    # messages
    tells_axes: bool = False
    """Whether `$I` names the axes."""
    version: str = "1.1h"
    build: str = "20190830"
    letters: str = "V"
    """The options listed in `$I`. Observed: VNMGH on the Mega, V on the 328p."""
    tells_flags: bool = False
    """Whether `$I` ends in a number of flags. Observed on the Mega."""
    factory: Mapping[int, float] = field(default_factory=dict)
    """Factory settings that differ from those of gnea/grbl."""

    def dialect(self, axes: str) -> Dialect:
        """Return which lines a build with these axes reads."""
        return Dialect(
            self.variant,
            axes,
            self.max_line,
            self.ring_bytes,
            self.outputs,
            self.letters_to_home > 0,
            self.crlf_answers_twice,
        )

    @property
    def grblhal(self) -> bool:
        """Whether it has grblHAL's additional real-time commands."""
        return self.variant is Variant.GRBLHAL

    @property
    def fluidnc(self) -> bool:
        """Whether it is FluidNC: settings have names, refusals have words, events queue up."""
        return self.variant is Variant.FLUIDNC

    @property
    def banner(self) -> Banner:
        """The message sent at the start."""
        if self.variant is Variant.FLUIDNC:
            return Banner(self.version, self.variant, self.build)
        return Banner(self.version, self.variant)

    def info(self, axes: str) -> tuple[Info, ...]:
        """Return the reply to `$I`; FluidNC's does not mention its ring."""
        if self.variant is Variant.FLUIDNC:
            version = Version(f"{self.version} FluidNC {self.build} ")
            return version, BuildInfo(self.letters), Bracketed("MSG:Machine: arm")
        head = (
            Version(f"{self.version}.{self.build}"),
            BuildInfo(self.letters, self.blocks, self.ring_bytes, self._more(axes)),
        )
        info = AxesInfo(len(axes), axes)
        if self.grblhal:
            return (*head, info, *map(Bracketed, _GRBLHAL_INFO))
        return (head[0], info, head[1]) if self.tells_axes else head

    def _more(self, axes: str) -> tuple[str, ...]:
        if self.grblhal:
            return str(len(axes)), "0"
        return ("0",) * self.tells_flags

    def adapted(self, values: Mapping[int, float]) -> dict[int, float]:
        """Return an arm's settings as they have to be on this firmware."""
        if not self.grblhal:
            return dict(values)
        homing = float(HOMING_BY_AXIS) if values[HOMING] else 0.0
        return {**values, REPORT: EVERYTHING, SLEEP_ENABLE: 1.0, HOMING: homing}


_GRBLHAL_INFO = (
    "NEWOPT:ENUMS,RT+,TC,SED",
    "FIRMWARE:grblHAL",
    "SIGNALS:D",
    "NVS STORAGE:*EEPROM",
    "DRIVER:Simulator",
    "DRIVER VERSION:260324",
)
"""Observed on grblHAL's Simulator."""


_FIRMWARES = (
    Firmware(name="grbl", unknown=frozenset(("M7",))),
    Firmware(
        name="mega5x",
        hard_limits=False,
        ring_bytes=255,
        blocks=35,
        max_line=255,
        stepping=replace(_AVR_STEPPING, segments=9),
        letters_to_home=1,
        cancel_clears_ring=True,
        tells_axes=True,
        version="1.1q",
        build="20210103",
        letters="VNMGH",
        tells_flags=True,
        factory=MappingProxyType({30: 12000.0, 31: 550.0}),
    ),
    Firmware(
        name="grblhal",
        variant=Variant.GRBLHAL,
        ring_bytes=1024,
        blocks=100,
        max_line=256,
        outputs=True,
        letters_to_home=1,
        crlf_answers_twice=False,
        stepping=Stepping(9),
        parse_s=0.05e-3,
        plan_s=0.1e-3,
        eeprom_s=5e-3,
        deaf_in_eeprom=False,
        killed=Killed.NEVER,
        alarm_s=0.1,
        boot_s=0.5,
        mute_in_critical=False,
        silent_in_homing=False,
        cancel_clears_ring=True,
        cancel_keeps=2,
        cancel_hangs_s=0.15e-3,
        holds_jogs=False,
        refuses_on=True,
        tells_axes=True,
        version="1.1f",
        build="20260817",
        letters="VNML+",
        factory=MappingProxyType(
            {REPORT: EVERYTHING, SLEEP_ENABLE: 0.0}
            | dict(zip(HOMING_CYCLES, (4.0, 3.0, 0.0, 0.0, 0.0, 0.0), strict=True))
        ),
    ),
    Firmware(
        name="fluidnc",
        variant=Variant.FLUIDNC,
        ring_bytes=256,
        max_line=127,
        outputs=True,
        letters_to_home=1,
        keeps_line=True,
        keeps_speed=True,
        edits_lines=True,
        reads_every_s=0.051,
        stepping=Stepping(11, 1e-3, 20e6 / (8 * 65535)),
        parse_s=1e-3,
        plan_s=0.2e-3,
        eeprom_s=5e-3,
        deaf_in_eeprom=False,
        killed=Killed.RUNS_ON,
        boot_s=1.0,
        mute_in_critical=False,
        silent_in_homing=False,
        cancel_hangs_s=0.0,
        version="4.0",
        build="v4.0.5-pre2 (esp32-wifi)",
        letters="MPHS",
    ),
)
FIRMWARES: Mapping[str, Firmware] = MappingProxyType({one.name: one for one in _FIRMWARES})
"""Every firmware by the name that the option takes."""


# --- The settings `$0` to `$132` and beyond, as the board's EEPROM holds them --------------------
# Source: gnea/grbl doc/markdown/settings.md. Lengths are in the machine's own unit, which the board
# takes for mm. Rates are stored per minute, accelerations per second squared.

_WHOLE: Mapping[int, float] = {
    0: 10, 1: 25, 2: 0, 3: 0, 4: 0, 5: 0, 6: 0, 10: 1, 13: 0, 20: 0, 21: 0, 22: 0, 23: 0, 26: 250,
    30: 1000, 31: 0, 32: 0,
}  # fmt: skip
_WHOLE_NUMBERS = {*_WHOLE, *HOMING_CYCLES, SLEEP_ENABLE}
_DECIMAL: Mapping[int, float] = {11: 0.01, 12: 0.002, 24: 25.0, 25: 500.0, 27: 1.0}
_PER_AXIS: Mapping[int, float] = {STEPS: 250.0, RATE: 500.0, ACCELERATION: 10.0, TRAVEL: 200.0}
_SHORTEST_PULSE = 3
MINUTE_S = 60.0


def factory_values(axes: int) -> dict[int, float]:
    """Return the factory settings of a board."""
    each = {group + axis: value for group, value in _PER_AXIS.items() for axis in range(axes)}
    return {**_WHOLE, **_DECIMAL, **each}


class BoardSettings:
    """Settings by number; `values` are those present at the start."""

    def __init__(
        self, axes: int, values: Mapping[int, float], factory: Mapping[int, float] | None = None
    ) -> None:
        self.axes = axes
        self.values = {**factory_values(axes), **(factory or {})}
        self.values.update({number: v for number, v in values.items() if number in self.values})

    def __getitem__(self, number: int) -> float:
        return self.values[number]

    def on(self, number: int) -> bool:
        """Return a yes-or-no setting."""
        return bool(self.values[number])

    def mask(self, number: int, axis: int) -> bool:
        """Return an axis's bit of a mask."""
        return bool(int(self.values[number]) >> axis & 1)

    def axis(self, group: int, axis: int) -> float:
        """Return a per-axis setting, such as `STEPS`."""
        return self.values[group + axis]

    def per_axis(self, group: int) -> tuple[float, ...]:
        """Return a per-axis setting for all axes."""
        return tuple(self.values[group + axis] for axis in range(self.axes))

    @property
    def motors_stay_on(self) -> bool:
        """Whether the motors keep their current at rest."""
        return self.values[IDLE_MS] == ALWAYS_ON_MS

    @property
    def idle_s(self) -> float:
        """How long after a motion the motors keep their current, unless they always keep it."""
        return self.values[IDLE_MS] / 1000

    def limits(self) -> PathLimits:
        """Return the limits that the planner observes."""
        return PathLimits(
            self.per_axis(STEPS),
            tuple(rate / MINUTE_S for rate in self.per_axis(RATE)),
            self.per_axis(ACCELERATION),
            self.values[JUNCTION],
        )

    def store(self, number: int, value: float) -> int:
        """Write a setting; return 0, or the number of the error if it is refused."""
        if value < 0:
            return 4
        if number not in self.values:
            return 3
        if number == 0 and value < _SHORTEST_PULSE:
            return 6
        if number == SOFT_LIMITS and value and not self.on(HOMING):
            return 10
        if number >= STEPS and not value:
            return 4  # a real board accepts it, and later divides by zero
        self.values[number] = float(int(value)) if number in _WHOLE_NUMBERS else value
        if number == HOMING and not value:
            self.values[SOFT_LIMITS] = 0.0
        return 0

    def written(self) -> list[tuple[int, str]]:
        """Return numbers and values as `$$` lists them."""
        return [
            (number, f"{value:.0f}" if number in _WHOLE_NUMBERS else f"{value:.3f}")
            for number, value in sorted(self.values.items())
        ]
