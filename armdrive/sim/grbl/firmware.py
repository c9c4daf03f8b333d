"""The boards of the GRBL family as data: a row for each firmware, and its settings.

All other code of the simulator asks for a property, and never for the name of a firmware.
Unknown figures are guesses on the harsher side. Times are in seconds. Those of the 8-bit boards
were measured on the real firmware in a processor simulator. "Observed" without more means there;
where another board was observed, the docstring says so: FluidNC 4.0.5 and grblHAL's Simulator ran
as programs.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import Enum, IntEnum
from types import MappingProxyType

from armdrive.sim.mechanics.planner import PathLimits, Stepping
from firmware_protocol.grbl import FLUIDNC, GRBL, GRBLHAL, Banner, Dialect, State, Variant, keys

# How far homing seeks a switch, in travels, and how far it approaches it again, in pull-offs.
SEARCH, LOCATE = 1.5, 5.0
_ANY_BIT = 255


class RefusalNumber(IntEnum):
    """The numbers of `error:N`, but for most of the g-code parser's.

    Source: gnea/grbl grbl/report.h.
    """

    UNKNOWN = 3
    NEGATIVE = 4
    NO_HOMING = 5
    SHORT_PULSE = 6
    NOT_IDLE = 8
    LOCKED = 9
    TOO_LONG = 11


class AlarmNumber(IntEnum):
    """The numbers of `ALARM:N`.

    Source: gnea/grbl grbl/system.h. Those that only FluidNC has were observed.
    """

    HARD_LIMIT = 1
    RESET_IN_MOTION = 3
    RESET_IN_HOMING = 6
    STILL_PRESSED = 8
    """A switch is pressed after homing has backed off."""
    NOT_FOUND = 9
    """Homing has come to no switch."""
    UNHOMED = 14
    """FluidNC's: an axis has yet to be homed."""


class Killed(Enum):
    """What a reset during a motion does to the motor current, even if $1 is 255.

    Sources: st_go_idle and mc_reset of gnea/grbl grbl/stepper.c and motion_control.c, and of
    grblHAL/core. Observed on FluidNC: after 0x18 at 400 steps/s, 44 steps in 0.11 s, at 50 steps/s
    17 in 0.32 s, and the position is exact.
    """

    LATE = "it is held for $1 with the interrupts off, then free until the board has restarted"
    NEVER = "the board restarts before $1 is over, and keeps the current on"
    RUNS_ON = "the computed segments are driven to their end, and the current stays on"


@dataclass(frozen=True, slots=True)
class SettingPaths:
    """The settings of a firmware that has a configuration file: `$/stepping/idle_ms`, and `=255`.

    Such a change lasts until the power is cut, because the file is not changed. The simulated board
    keeps each setting under GRBL's number. All observed on FluidNC.
    """

    numbers: Mapping[str, int]
    """The number of the setting at each path, or of the first axis's at `axes/{}/` and a word."""
    fixed: Mapping[str, float]
    """What cannot be changed here, by the same paths."""
    listed: tuple[int, ...]
    """The numbers below those of the axes that `$$` lists."""
    changeable: tuple[int, ...]
    """The numbers of settings that can be changed as on GRBL (`$10=3`)."""

    def find(self, path: str, axes: str) -> tuple[int | None, float | None]:
        """Return the number of the setting at a path, or else what is fixed there."""
        found, axis = _AXIS_PATH.fullmatch(path), 0
        if found is not None and found[1].upper() in axes:
            path, axis = f"axes/{{}}/{found[2]}", axes.index(found[1].upper())
        number = self.numbers.get(path)
        if number is not None and number >= keys.STEPS_PER_UNIT:
            number += axis
        return number, self.fixed.get(path)


_AXIS_PATH = re.compile(r"axes/([a-z])/([\w/]+)")
# No slower than a 16-bit timer of a processor at 16 MHz, its clock divided by 8, can count.
_AVR_STEPPING = Stepping(5, 1e-3, 16e6 / (8 * 65535))


@dataclass(frozen=True, slots=True)
class Firmware:
    """One firmware on its usual board; the defaults are those of gnea/grbl on an ATmega328p.

    Units: bytes, steps per second, seconds.

    Sources: gnea/grbl, fra589/grbl-Mega-5X, grblHAL/core, bdring/FluidNC. "Observed" means on the
    Mega and an ATmega328P, running the unchanged firmware in an AVR simulator.
    """

    name: str
    banner: Banner
    info: tuple[str, ...]
    """The answer to `$I`, with the letters of the `{axes}` and their number, `{many}`. Observed:
    VNMGH on the Mega, V on the 328p; FluidNC does not report its ring.
    """

    # capacities, and what it reads
    dialect: Dialect = GRBL
    """Which lines it reads; the axes and the ring are those of the build. Observed: the Mega takes
    lines of more than 200 characters, FluidNC of 127. The Mega and the 328p refuse M62 to M68 with
    error 20.
    """
    blocks: int = 15
    """How many lines the planner queues."""
    ring_bytes: int = 128
    """How many bytes the receive ring holds. grblHAL's holds one less than `$I` says."""
    stepping: Stepping = _AVR_STEPPING
    """How the board steps. A hold begins to brake after the segments already computed, and a line
    leaves the planner with its last segment. Observed, from a hold to the last step: 0.43 s (Mega)
    and 0.24 s (328p) at 31 steps/s, 0.27 s and 0.15 s at 50; 40 steps at 5, 10, 20 and 30 steps/s
    in 1.278 s each. Observed on grblHAL, from a hold to the last step: 0.43 to 0.46 s at 31
    steps/s, 0.27 s at 50, 0.19 s at 100; it really turns at 5, 10 and 20 steps/s. Observed on
    FluidNC with the 20 MHz of an ESP32: 0.45 s at 39 steps/s, 0.33 s at 50, 0.23 s at 100; 40 steps
    at 5 to 30 steps/s in 1.022 s each.
    """
    reads_every_s: float = 0.0
    """How late real-time commands may be read while a line is executed, homing included, by a board
    that polls its input; 0 if an interrupt does. FluidNC looks every 51st time that its task runs
    (Serial.cpp, pollChannels), and while it waits at a switch in homing not at all. Observed: 0.04
    to 0.06 s from 0x18 in homing to `ALARM:6`.
    """
    edits_lines: bool = False
    """Whether a control character makes the board echo what it hears, until 0x0C. Observed on
    FluidNC (lineedit.cpp).
    """
    refuses_on: bool = False
    """Whether g-code after a refused line is refused with the same error, until an empty line, a
    line that begins with `$` and is carried out, a jog cancel or a reset. Observed on grblHAL
    (protocol.c, protocol_main_loop).
    """

    # durations
    eeprom_s: float = 17e-3
    """Changing a setting."""
    deaf_in_eeprom: bool = True
    """Whether bytes that arrive meanwhile are lost."""
    alarm_s: float = 0.5
    """From the alarm to the restart of the board, or until FluidNC goes on."""
    boot_s: float = 1.5
    """From a reset of the board to its banner; the motors have no current."""

    # resets
    killed: Killed = Killed.LATE
    """What becomes of the motors at a reset in motion."""
    resets_kept: int = 0
    """How many resets that arrive during a restart are obeyed after it. Observed: one on grblHAL.
    FluidNC queues up to 50 events (Protocol.cpp, protocol_init).
    """
    keeps_line: bool = False
    """Whether a reset out of a hold leaves the line that has been fetched meanwhile: it is carried
    out after the banner. Observed on FluidNC (Protocol.cpp, activeLine): it moved the arm.
    """
    answers_dropped: bool = True
    """Whether a reset answers the line being executed with ok. Observed: not on FluidNC, and not on
    grblHAL if homing fails or is reset.
    """
    wakes_with_alarm: bool = False
    """Whether a reset out of sleep raises ALARM:3. Observed on FluidNC."""

    # alarms and homing
    hard_limits: bool = True
    """Whether, with $21=1, a switch that closes raises an alarm. Observed: the default RAMPS build
    of the Mega accepts $21=1 and does nothing (grbl/cpu_map.h: DISABLE_HW_LIMITS_INTERRUPT).
    Reports show the pin.
    """
    checks_limits: bool = True
    """Whether, with $21=1, a board that starts with a switch pressed is locked. Observed on the
    Mega. grblHAL does so only with bit 1 of $21, FluidNC never.
    """
    limit_locks: bool = True
    """Whether the board is locked after a limit alarm and the reset. Observed: not on FluidNC,
    which takes up the motion that the alarm ended, and makes no step of it.
    """
    backs_off_at_feed: bool = False
    """Whether homing backs off a switch as slowly as it approaches it again. Observed on FluidNC
    (Cartesian.cpp, axesVector); the others back off as fast as they seek.
    """
    homes_at: float | None = None
    """Where a homed axis stands; if None, a pull-off inside its travel, which is all negative.
    FluidNC: `mpos_mm`, as if it were not changed.
    """
    homing_value: float = 1.0
    """$22 with homing, as an arm needs it. On grblHAL it has bits: homing, and single axes (`$HX`).
    """
    single_axis_bits: int = _ANY_BIT
    """The bits of $22 that permit `$HX`."""
    homing_locks: bool = True
    """Whether a board with homing starts locked. Observed: not grblHAL. With bit 2 of $22 it raises
    ALARM:11 and refuses `$X` with error 46, which is not built in here.
    """
    homing_counts: bool = True
    """Whether each motion of homing counts from zero. Observed on the Mega, and so in grblHAL."""
    sticks_in_homing: bool = True
    """Whether `$H` with an axis that the build refuses (error 3) leaves the board in Home until a
    reset. Observed on the Mega with two axes, and on the 328p, which refuses every single axis.
    """
    locks_until_homed: bool = False
    """Whether, with homing, the board stays locked until each axis has been homed. Observed on
    FluidNC; the alarm after a reset is then 14.
    """
    failed_homing_restarts: bool = True
    """Whether the board restarts after homing that failed. Observed: FluidNC goes on, and answers
    the line with ok. By its source (Homing.cpp, fail) it does not learn where its axes stand then:
    the next line begins where the search was to end, until the board is reset.
    """

    # jogs
    holds_jogs: bool = True
    """Whether a feed hold ends a jog. Observed: grblHAL ignores it (state_machine.c, state_set)."""
    cancel_clears_in: tuple[State, ...] = ()
    """The states in which a jog cancel clears the ring. Observed on the Mega: five of eight lines
    were answered.
    """
    cancel_keeps: int | None = None
    """How many of the computed segments a jog cancel lets run; all if None. Observed on grblHAL:
    at 31 steps/s the last step comes 0.07 to 0.14 s after 0x85, and 0.43 to 0.46 s after `!`.
    """
    cancel_hangs_s: float = 0.23e-3
    """A cancel that comes so shortly before the end of a jog leaves the board in Idle without
    reading lines. Observed: repeated every 20 ms, it hung 3 of 259 jogs of a Mega and 2 of 264 of a
    328p. A single one in the last 40 ms hung 3 of 120 jogs of grblHAL; its Simulator is slow to
    notice, so how short the time is on a board is a guess.
    """
    resume_unhangs: bool = True
    """Whether a resume frees a board that hangs. Observed: grblHAL and FluidNC need a reset, which
    raises ALARM:3, because they still believe that they move.
    """

    # messages
    report_bits: int = 3
    """The parts of a report that $10 can leave out (`$ES`, setting 10): position and buffers."""
    mute_in_critical: bool = True
    """Whether `?` is unanswered after a limit alarm until the reset. Observed: not on the Mega, in
    the version of 4 January 2021 and later.
    """
    silent_in_homing: bool = True
    """Whether `?` is unanswered while homing is under way. Observed on grblHAL, which sends one
    report as homing begins. Bit 12 of its $10 enables more; neither is built in here.
    """

    # settings
    paths: SettingPaths | None = None
    """How settings are changed; None if all are by number."""
    factory: Mapping[int, float] = field(default_factory=dict)
    """Factory settings that differ from those of gnea/grbl."""
    needs: Mapping[int, float] = field(default_factory=dict)
    """Settings that an arm needs on this firmware alone."""

    def adapted(self, values: Mapping[int, float]) -> dict[int, float]:
        """Return an arm's settings as they have to be on this firmware."""
        homing = self.homing_value if values[keys.HOMING] else 0.0
        return {**values, **self.needs, keys.HOMING: homing}


# The factory's mask of grblHAL's reports; GRBL's has two bits only.
_EVERYTHING = 511


_FIRMWARES = (
    Firmware(
        "grbl",
        Banner("1.1h"),
        ("VER:1.1h.20190830:", "OPT:V,15,128"),
    ),
    Firmware(
        "mega5x",
        Banner("1.1q"),
        ("VER:1.1q.20210103:", "AXS:{many}:{axes}", "OPT:VNMGH,35,255,0"),
        dialect=Dialect(max_line=255, single_axis_homing=True),
        hard_limits=False,
        blocks=35,
        ring_bytes=255,
        stepping=replace(_AVR_STEPPING, segments=9),
        cancel_clears_in=(State.JOG,),
        mute_in_critical=False,
    ),
    Firmware(
        "grblhal",
        Banner("1.1f", Variant.GRBLHAL),
        (
            "VER:1.1f.20260817:",
            "OPT:VNML+,100,1024,{many},0",
            "AXS:{many}:{axes}",
            "FIRMWARE:grblHAL",
        ),
        dialect=GRBLHAL,
        blocks=100,
        ring_bytes=1023,
        stepping=Stepping(9),
        refuses_on=True,
        eeprom_s=5e-3,
        deaf_in_eeprom=False,
        alarm_s=0.1,
        boot_s=0.5,
        killed=Killed.NEVER,
        resets_kept=1,
        answers_dropped=False,
        homing_value=3.0,
        single_axis_bits=2,
        checks_limits=False,
        sticks_in_homing=False,
        homing_locks=False,
        holds_jogs=False,
        cancel_clears_in=tuple(State),
        cancel_keeps=2,
        cancel_hangs_s=0.15e-3,
        resume_unhangs=False,
        report_bits=_EVERYTHING,
        mute_in_critical=False,
        factory=MappingProxyType({keys.REPORT: _EVERYTHING, keys.SLEEP_ENABLE: 0.0}),
        needs=MappingProxyType({keys.REPORT: _EVERYTHING, keys.SLEEP_ENABLE: 1.0}),
    ),
    Firmware(
        "fluidnc",
        Banner("4.0", Variant.FLUIDNC, "v4.0.5-pre2 (esp32-wifi)"),
        ("VER:4.0 FluidNC v4.0.5-pre2 (esp32-wifi) :", "OPT:MPHS", "MSG:Machine: arm"),
        dialect=FLUIDNC,
        ring_bytes=256,
        stepping=Stepping(11, 1e-3, 20e6 / (8 * 65535)),
        reads_every_s=0.051,
        edits_lines=True,
        eeprom_s=5e-3,
        deaf_in_eeprom=False,
        boot_s=1.0,
        killed=Killed.RUNS_ON,
        resets_kept=50,
        keeps_line=True,
        answers_dropped=False,
        wakes_with_alarm=True,
        checks_limits=False,
        limit_locks=False,
        homing_counts=False,
        sticks_in_homing=False,
        backs_off_at_feed=True,
        homes_at=0.0,
        locks_until_homed=True,
        failed_homing_restarts=False,
        cancel_hangs_s=0.0,
        resume_unhangs=False,
        mute_in_critical=False,
        silent_in_homing=False,
        paths=SettingPaths(
            numbers=MappingProxyType(
                {
                    "stepping/idle_ms": keys.IDLE_MS,
                    "junction_deviation_mm": keys.JUNCTION,
                    "axes/{}/steps_per_mm": keys.STEPS_PER_UNIT,
                    "axes/{}/max_rate_mm_per_min": keys.RATE,
                    "axes/{}/acceleration_mm_per_sec2": keys.ACCELERATION,
                    "axes/{}/max_travel_mm": keys.TRAVEL,
                    "axes/{}/homing/seek_mm_per_min": keys.HOMING_SEEK,
                    "axes/{}/homing/feed_mm_per_min": keys.HOMING_FEED,
                    "axes/{}/homing/settle_ms": keys.DEBOUNCE_MS,
                    "axes/{}/motor0/pulloff_mm": keys.PULL_OFF,
                }
            ),
            fixed=MappingProxyType(
                {
                    "axes/homing_runs": 2.0,
                    "axes/{}/homing/seek_scaler": SEARCH,
                    "axes/{}/homing/feed_scaler": LOCATE,
                }
            ),
            listed=(
                keys.REPORT,
                keys.INCHES,
                keys.SOFT_LIMITS,
                keys.HARD_LIMITS,
                keys.HOMING,
                keys.HOMING_DIRECTIONS,
            ),
            changeable=(keys.REPORT, keys.INCHES),
        ),
    ),
)
# Every firmware by the name that the option takes.
FIRMWARES: Mapping[str, Firmware] = MappingProxyType({one.name: one for one in _FIRMWARES})


# --- The settings `$0` to `$132` and beyond, as the board's EEPROM holds them --------------------
# Source: gnea/grbl doc/markdown/settings.md. Lengths are in the machine's own unit, which the board
# takes for mm. Rates are stored per minute, accelerations per second squared.

_WHOLE: Mapping[int, float] = {
    0: 10, 1: 25, 2: 0, 3: 0, 4: 0, 5: 0, 6: 0, 10: 1, 13: 0, 20: 0, 21: 0, 22: 0, 23: 0, 26: 250,
    30: 1000, 31: 0, 32: 0,
}  # fmt: skip
_WHOLE_NUMBERS = {*_WHOLE, keys.SLEEP_ENABLE}
_DECIMAL: Mapping[int, float] = {11: 0.01, 12: 0.002, 24: 25.0, 25: 500.0, 27: 1.0}
_PER_AXIS: Mapping[int, float] = {
    keys.STEPS_PER_UNIT: 250.0,
    keys.RATE: 500.0,
    keys.ACCELERATION: 10.0,
    keys.TRAVEL: 200.0,
}
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
        """Return a per-axis setting, such as `keys.STEPS_PER_UNIT`."""
        return self.values[group + axis]

    def per_axis(self, group: int) -> tuple[float, ...]:
        """Return a per-axis setting for all axes."""
        return tuple(self.values[group + axis] for axis in range(self.axes))

    @property
    def motors_stay_on(self) -> bool:
        """Whether the motors keep their current at rest."""
        return self.values[keys.IDLE_MS] == keys.ALWAYS_ON_MS

    @property
    def idle_s(self) -> float:
        """How long after a motion the motors keep their current, unless they always keep it."""
        return self.values[keys.IDLE_MS] / 1000

    def limits(self) -> PathLimits:
        """Return the limits that the planner observes."""
        return PathLimits(
            self.per_axis(keys.STEPS_PER_UNIT),
            tuple(rate / MINUTE_S for rate in self.per_axis(keys.RATE)),
            self.per_axis(keys.ACCELERATION),
            self.values[keys.JUNCTION],
        )

    def store(self, number: int, value: float) -> int:
        """Write a setting; return 0, or the number of the error if it is refused."""
        if value < 0:
            return RefusalNumber.NEGATIVE
        if number not in self.values:
            return RefusalNumber.UNKNOWN
        if number == 0 and value < _SHORTEST_PULSE:
            return RefusalNumber.SHORT_PULSE
        if number >= keys.STEPS_PER_UNIT and not value:
            return RefusalNumber.NEGATIVE  # a real board accepts it, and later divides by zero
        self.values[number] = float(int(value)) if number in _WHOLE_NUMBERS else value
        return 0

    def written(self) -> dict[int, str]:
        """Return the values by number, as `$$` lists them."""
        return {
            number: f"{value:.0f}" if number in _WHOLE_NUMBERS else f"{value:.3f}"
            for number, value in sorted(self.values.items())
        }
