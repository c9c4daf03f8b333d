"""The boards of the GRBL family as data: how large, how quick, and what each does its own way.

Where a figure is not known it is a guess to the harder side. Times are seconds. Those of the 8-bit
boards were measured on the real firmware in a processor simulator, those of the others are not.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import Enum
from types import MappingProxyType

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
    """What a reset that ends a motion does to the motors' current, even where $1 is 255.

    Sources: st_go_idle and mc_reset of gnea/grbl grbl/stepper.c and motion_control.c, and of
    grblHAL/core; protocol_disable_steppers of bdring/FluidNC Protocol.cpp.
    """

    LATE = "it is held for $1 with the interrupts off, and is without until it has started anew"
    AT_ONCE = "it is without at once, until it has started anew"
    NEVER = "it has started anew before $1 is over, and keeps it"


@dataclass(frozen=True, slots=True)
class Firmware:
    """One firmware on its usual board.

    `ring_bytes` is what the receive ring holds, `blocks` how many lines the planner queues.
    Of the motion `ahead_s` is worked out already and no longer changed: a hold begins to brake so
    much later, and a line leaves the planner so much before its end (gnea/grbl grbl/stepper.h: six
    segments of 10 ms; grblHAL ten, FluidNC twelve).

    A line takes `parse_s`, and `plan_s` more where it is a motion. A change of settings takes
    `eeprom_s`, in which bytes that arrive are lost where it is `deaf_in_eeprom`. An alarm is
    followed by `alarm_s` in which its words are sent, before the board starts anew, which takes
    `start_s`; what becomes of the motors meanwhile says `killed`. From a reset of the board itself
    it takes `boot_s`, without current.
    `mute_in_critical`: after a limit alarm `?` is not answered until the reset.
    `hard_limits`: with $21=1 a switch that closes is an alarm. The default RAMPS build accepts
    $21=1, which does nothing: seen on grbl-Mega-5X, default RAMPS build, in an AVR simulator
    (grbl/cpu_map.h: DISABLE_HW_LIMITS_INTERRUPT). Reports show the pin all the same.
    `silent_in_homing`: nor during homing. `cancel_clears_ring`: a jog cancel does. `tells_axes`:
    `$I` names the axes (fra589/grbl-Mega-5X grbl/report.c; grblHAL).
    """

    name: str
    variant: Variant
    ring_bytes: int
    blocks: int
    max_line: int
    outputs: bool
    letters_to_home: int
    crlf_answers_twice: bool
    ahead_s: float
    parse_s: float
    plan_s: float
    eeprom_s: float
    deaf_in_eeprom: bool
    killed: Killed
    alarm_s: float
    start_s: float
    boot_s: float
    mute_in_critical: bool
    hard_limits: bool
    silent_in_homing: bool
    cancel_clears_ring: bool
    tells_axes: bool
    version: str
    build: str

    def dialect(self, axes: str) -> Dialect:
        """Return what lines a build with these axes reads."""
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
    def has_paths(self) -> bool:
        """Whether its settings have names, as FluidNC's, and `$$` lists some of them only."""
        return self.variant is Variant.FLUIDNC

    @property
    def banner(self) -> Banner:
        """What it says when it starts."""
        if self.variant is Variant.FLUIDNC:
            return Banner(self.version, self.variant, self.build)
        return Banner(self.version, self.variant)

    def info(self, axes: str, note: str) -> tuple[Info, ...]:
        """Return what `$I` answers; FluidNC says nothing of its ring."""
        if self.variant is Variant.FLUIDNC:
            return Version(f"{self.version} FluidNC {self.build}", note), BuildInfo("PHS")
        head = (
            Version(f"{self.version}.{self.build}", note),
            BuildInfo("VNM" if self.outputs else "V", self.blocks, self.ring_bytes),
        )
        told = AxesInfo(len(axes), axes)
        if self.grblhal:
            return (*head, told, Bracketed("FIRMWARE:grblHAL"))
        return (head[0], told, head[1]) if self.tells_axes else head


_GRBL = Firmware(
    name="grbl",
    variant=Variant.GRBL,
    ring_bytes=128,
    blocks=15,
    max_line=79,
    outputs=False,
    letters_to_home=0,
    crlf_answers_twice=True,
    ahead_s=0.05,
    parse_s=0.35e-3,
    plan_s=3.75e-3,
    eeprom_s=17e-3,
    deaf_in_eeprom=True,
    killed=Killed.LATE,
    alarm_s=0.5,
    start_s=5e-3,
    boot_s=1.5,
    mute_in_critical=True,
    hard_limits=True,
    silent_in_homing=True,
    cancel_clears_ring=False,
    tells_axes=False,
    version="1.1h",
    build="20190825",
)

_MEGA_5X = replace(
    _GRBL,
    name="mega5x",
    hard_limits=False,
    ring_bytes=255,
    blocks=35,
    outputs=True,
    letters_to_home=1,
    tells_axes=True,
    version="1.1m",
    build="20210506",
)

_GRBLHAL = Firmware(
    name="grblhal",
    variant=Variant.GRBLHAL,
    ring_bytes=1024,
    blocks=35,
    max_line=256,
    outputs=True,
    letters_to_home=9,
    crlf_answers_twice=False,
    ahead_s=0.09,
    parse_s=0.05e-3,
    plan_s=0.1e-3,
    eeprom_s=5e-3,
    deaf_in_eeprom=False,
    killed=Killed.NEVER,
    alarm_s=0.1,
    start_s=5e-3,
    boot_s=0.5,
    mute_in_critical=False,
    hard_limits=True,
    silent_in_homing=False,
    cancel_clears_ring=True,
    tells_axes=True,
    version="1.1f",
    build="20240527",
)

_FLUIDNC = Firmware(
    name="fluidnc",
    variant=Variant.FLUIDNC,
    ring_bytes=256,
    blocks=15,
    max_line=255,
    outputs=True,
    letters_to_home=1,
    crlf_answers_twice=False,
    ahead_s=0.11,
    parse_s=0.1e-3,
    plan_s=0.2e-3,
    eeprom_s=5e-3,
    deaf_in_eeprom=False,
    killed=Killed.AT_ONCE,
    alarm_s=0.5,
    start_s=5e-3,
    boot_s=1.0,
    mute_in_critical=False,
    hard_limits=True,
    silent_in_homing=False,
    cancel_clears_ring=False,
    tells_axes=False,
    version="3.7",
    build="v3.7.8",
)

FIRMWARES: Mapping[str, Firmware] = MappingProxyType(
    {one.name: one for one in (_GRBL, _MEGA_5X, _GRBLHAL, _FLUIDNC)}
)
"""Every firmware by the name that the option takes."""
