"""One simulated MKS drive: its settings, its set-point, its shaft, and what it says.

`requests` carries out its requests; `motion` carries its motions on.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TypeVar, cast

from armdrive.errors import StateFileError
from armdrive.sim.bus.drives import LimitSwitch, ShaftDrive, ShaftPoint, at_rate, dead
from armdrive.sim.mechanics.profiles import AxisProfile, ProfilePiece
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import MEND, Json, Saved
from firmware_protocol.errors import ProtocolError
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    SPEED_MAX_RPM,
    Asked,
    Bitrate,
    Code,
    Device,
    HomingState,
    Mode,
    MotorState,
    Outcome,
    ReplyMode,
    SetArrival,
    SetBitrate,
    SetCurrent,
    SetDirection,
    SetGroup,
    SetHoldingCurrent,
    SetHoming,
    SetId,
    SetMicrosteps,
    SetMode,
    SetPositionProtection,
    SetReplies,
    SetStallProtection,
    Setting,
    SettingRead,
    SilenceWatchdog,
    Version,
    as_setting,
    ramp_rpm_s,
    true_rpm,
)

# --- The settings that outlast the power, as shipped or as an arm needs them ---------------------

S = TypeVar("S", bound=Setting)

FACTORY: tuple[Setting, ...] = (
    SetMode(Mode.PULSE_FOC),
    SetCurrent(1600),
    SetHoldingCurrent(50),
    SetMicrosteps(16),
    SetDirection(False),
    SetStallProtection(False),
    SetPositionProtection(False, 66, 14_000),
    SetHoming(active_high=False, counter_clockwise=False, speed_rpm=60, limits=False, method=0),
    SetArrival(True),
    SilenceWatchdog(0),
    SetBitrate(Bitrate.K500),
    SetId(1),
    SetReplies(ReplyMode.FULL),
)
"""As a drive is shipped; it belongs to no group. Numbers that are not in the manual are usual."""


class Flash:
    """The settings of one drive."""

    def __init__(self, changed: Iterable[Setting] = ()) -> None:
        self._settings: dict[Code, Setting] = {each.code: each for each in (*FACTORY, *changed)}

    def of(self, kind: type[S]) -> S:
        """Return a setting by its kind; a group's id may be none, and is not asked for so."""
        return cast(S, self._settings[kind.code])

    def get(self, code: Code) -> Setting | None:
        """Return a setting by its code; None for a group's id where there is none."""
        return self._settings.get(code)

    def put(self, setting: Setting) -> None:
        """Keep a setting."""
        self._settings[setting.code] = setting

    def device(self, firmware: Version, *, new_id_answers: bool) -> Device:
        """Make an end of the bus that is as it is set up."""
        group = self._settings.get(Code.GROUP)
        return Device(
            self.of(SetId).node,
            firmware,
            group=group.node if isinstance(group, SetGroup) else None,
            replies=self.of(SetReplies).mode,
            bitrate=self.of(SetBitrate).bitrate,
            new_id_answers=new_id_answers,
        )

    def to_json(self) -> dict[str, Json]:
        """Return the settings as they are on the bus, by the name of their code."""
        return {code.name.lower(): each.payload.hex() for code, each in self._settings.items()}

    @classmethod
    def from_json(cls, saved: Saved) -> Flash:
        """Know again what `to_json` wrote. Raises `StateFileError`."""
        codes = [each.code for each in FACTORY]
        codes += [Code.GROUP] if saved.has(Code.GROUP.name.lower()) else []
        found = cls(_read(code, saved.text(code.name.lower())) for code in codes)
        saved.end()
        return found


def _read(code: Code, text: str) -> Setting:
    try:
        setting = as_setting(SettingRead(code, bytes.fromhex(text)))
    except (ProtocolError, ValueError):
        setting = None
    if setting is None:
        raise StateFileError(f"a saved drive's {code.name.lower()} cannot be {text!r:.60}; {MEND}")
    return setting


# --- The set-point in the drive's own measures: rpm, and steps of acceleration -------------------
#
# Encoder counts are the shaft's own, whatever zero was set. Times are in seconds.

_RPM = COUNTS_PER_TURN / 60.0
"""Counts a second of one rpm."""


class MksSetPoint(ShaftPoint):
    """It stands, or is under way on a ramped profile from whatever it did before."""

    def rpm(self, now_s: float) -> float:
        """Return how fast it goes; positive is counter-clockwise."""
        return self.rate(now_s) / _RPM

    def move_to(self, goal: int, rpm: float, acc: int, now_s: float) -> None:
        """Go to a count, from whatever is under way."""
        self.go_to(goal, rpm * _RPM, _slope(acc), now_s)

    def run(self, rpm: float, acc: int, now_s: float) -> None:
        """Run until told otherwise; a speed of 0 ends it."""
        self.go_at(rpm * _RPM, _slope(acc), now_s)

    def run_for(self, rpm: float, acc: int, time_s: float, now_s: float) -> None:
        """Run for a time, and then slow down."""
        self.run(rpm, acc, now_s)
        over_s = now_s + time_s
        pieces = [_cut(piece, over_s) for piece in self._profile.pieces if piece.start_s < over_s]
        last = pieces[-1]
        end = at_rate(last.at(over_s), last.speed_at(over_s), 0.0, _slope(acc), over_s)
        self._begin(AxisProfile((*pieces, *end.pieces), end.end), now_s)
        self._end_s = max(self._end_s, over_s)

    def there_and_back(self, counts: int, rpm: float, now_s: float) -> None:
        """Turn by so many counts and back again."""
        here = float(self.at(now_s))
        there = dead(here, here + counts, rpm * _RPM, now_s)
        back = dead(here + counts, here, rpm * _RPM, there.end_s)
        self._begin(AxisProfile((*there.pieces, *back.pieces), here), now_s)

    def state(self, now_s: float) -> MotorState:
        """Return what the drive says it does."""
        if not self.moving(now_s):
            return MotorState.STOPPED
        piece = next(each for each in self._profile.pieces if now_s < each.end_s)
        change = piece.acceleration * piece.speed_at(now_s)
        if not piece.acceleration:
            return MotorState.FULL_SPEED
        return MotorState.ACCELERATING if change >= 0.0 else MotorState.DECELERATING


def _slope(acc: int) -> float:
    """Return the counts a second squared of the drive's own measure; infinity without a ramp."""
    return ramp_rpm_s(acc) * _RPM


def _cut(piece: ProfilePiece, over_s: float) -> ProfilePiece:
    return replace(piece, duration_s=min(piece.duration_s, over_s - piece.start_s))


# --- The shafts ----------------------------------------------------------------------------------

MAKES_UP = SPEED_MAX_RPM / 60.0 * COUNTS_PER_TURN
"""Counts a second: no drive makes up for what it has lost faster than it turns."""


class ClosedLoopDrive(ShaftDrive[MksSetPoint]):
    """Six loops and one arm."""

    def __init__(self, world: World) -> None:
        super().__init__(world, [MksSetPoint(count) for count in world.motors], MAKES_UP)


FULL_STEPS = 200
"""Of a motor's turn."""


@dataclass(frozen=True, slots=True)
class MksQuirks:
    """What public sources leave open of these drives; `kind.KIND` says what each means."""

    says_done: bool = True
    says_refused: bool = True
    superseded: str = "first"
    keeps_angle: bool = False
    enabled_on: bool = True
    watchdog_hears_all: bool = False
    stays_armed: bool = False
    new_id_answers: bool = True
    version_bytes: int = 3
    answer_s: float = 0.0002
    boot_s: float = 0.5
    stall_counts: int = COUNTS_PER_TURN // 10


class MksNode:
    """A drive on the motor of its index. Its owner calls `motion.happen` once time has passed."""

    def __init__(
        self,
        index: int,
        firmware: Version,
        flash: Flash,
        drive: ClosedLoopDrive,
        switch: LimitSwitch,
        quirks: MksQuirks,
    ) -> None:
        self.index = index
        self.firmware = firmware
        self.drive = drive
        self.switch = switch
        self.quirks = quirks
        self.flash = flash
        self.device = flash.device(firmware, new_id_answers=quirks.new_id_answers)
        self.powered = True
        self.mute = False
        self.plugged = True
        """Whether its CAN cable is in."""
        self.says_done = quirks.says_done
        self.enabled = quirks.enabled_on
        self.calibrated = True
        self.zero = self.power_on_zero = 0
        self.said: list[bytes] = []
        """What its owner has to bring to the bus."""
        self._forget(0.0)

    def _forget(self, now_s: float) -> None:
        """Know nothing of what was before the firmware began."""
        self.stalled = False
        self.astray_s = math.inf
        """Since when the shaft has been as far from its set-point as a stall brings it."""
        self.off_s = math.inf
        """Since when it has been farther than position protection lets it be."""
        self.armed = False
        self.stored: Asked | None = None
        self.under_way: Asked | None = None
        self.acc = 0
        self.waits = False
        """Whether the set-point has come to its end, and the shaft has not."""
        self.seeking = 0
        """Which way a search for the switch goes; 0 for none."""
        self.backing = False
        """Whether the search goes away from a switch that was pressed when it began."""
        self.switch_s = math.inf
        """When the set-point comes to the switch, as far as that is to be noticed."""
        self.homing: HomingState | None = None
        self.heard_s = now_s
        self.expired = False
        """Whether the watchdog has stopped it, and nothing was heard since."""
        self.watchdog_stops = 0
        """How often the watchdog has stopped it."""
        self.boots_s = -math.inf
        self.reports: dict[Code, tuple[float, float]] = {}
        """What it says by itself: the period and when it is due next."""

    # What it is.

    @property
    def point(self) -> MksSetPoint:
        """Its set-point."""
        return self.drive.rack.each[self.index]

    @property
    def shaft(self) -> int:
        """Where its shaft is."""
        return self.drive.shafts[self.index]

    @property
    def counts(self) -> int:
        """Where it says that its shaft is."""
        return self.shaft - self.zero

    @property
    def awake(self) -> bool:
        """Whether it has power, and has begun."""
        return self.powered and not self.booting

    @property
    def booting(self) -> bool:
        """Whether its firmware has not begun yet."""
        return self.boots_s > -math.inf

    @property
    def mode(self) -> Mode:
        """Who commands it."""
        return self.flash.of(SetMode).mode

    @property
    def microsteps(self) -> int:
        """The pulses of a full step."""
        return self.flash.of(SetMicrosteps).microsteps

    @property
    def counts_per_pulse(self) -> float:
        """How far a pulse turns the shaft."""
        return COUNTS_PER_TURN / (FULL_STEPS * self.microsteps)

    @property
    def can_move(self) -> bool:
        """Whether it takes motions: enabled, not stalled, in the bus's FOC mode, not homing."""
        free = self.enabled and not self.stalled and self.mode is Mode.BUS_FOC
        return free and not self.searching

    @property
    def searching(self) -> bool:
        """Whether a homing or a calibration is under way."""
        code = None if self.under_way is None else self.under_way.request.code
        return code in (Code.HOME, Code.CALIBRATE)

    @property
    def timeout_s(self) -> float:
        """How long it may hear nothing while it moves; infinity without a watchdog."""
        timeout_ms = self.flash.of(SilenceWatchdog).timeout_ms
        return timeout_ms / 1000 if timeout_ms else math.inf

    def rpm_of(self, speed_rpm: int) -> float:
        """Return how fast a speed really is."""
        top = self.mode.top_rpm
        return min(max(true_rpm(speed_rpm, self.microsteps), -top), top)

    def listens_to(self, can_id: int) -> bool:
        """Tell whether a frame with an id is for it."""
        return can_id in (0, self.device.node, self.device.group)

    # What it says.

    def tell(self, asked: Asked, outcome: Outcome) -> None:
        """Say how it goes with what it was asked; that a motion is done, only if it does so."""
        quiet = outcome is Outcome.DONE and asked is self.under_way and not self.says_done
        self.say(b"" if quiet else self.device.tell(asked, outcome))

    def refuse(self, asked: Asked) -> None:
        """Say, or do not even say, that it does no such thing now."""
        if self.quirks.says_refused:
            self.tell(asked, Outcome.FAILED)

    def say(self, data: bytes) -> None:
        """Have bytes brought to the bus."""
        if data and self.plugged and not self.mute and self.awake:
            self.said.append(data)

    @property
    def answer_s(self) -> float:
        """How long it takes to have an answer ready."""
        return self.quirks.answer_s

    # Power.

    def fall_silent(self, now_s: float) -> None:
        """Lose power or be reset: the shaft is free, and all that was under way is forgotten."""
        self.drive.release((self.index,), now_s)
        self._forget(now_s)
        self.device.discard()
        self.said.clear()

    def begin(self, now_s: float) -> None:
        """Begin the firmware: settings are kept, the position is not."""
        self._forget(now_s)
        self.remake()
        turned = self.shaft % COUNTS_PER_TURN if self.quirks.keeps_angle else 0
        self.zero = self.power_on_zero = self.shaft - turned
        self.set_enabled(self.quirks.enabled_on, now_s)

    def restart(self, now_s: float) -> None:
        """Begin anew, after a while in which nothing holds the shaft and nobody answers."""
        self.fall_silent(now_s)
        self.boots_s = now_s + self.quirks.boot_s

    def set_enabled(self, on: bool, now_s: float) -> None:
        """Switch the motor's current; what holds the shaft already goes on doing what it does."""
        self.enabled = on
        if not on:
            self.under_way, self.seeking = None, 0
            self.drive.release((self.index,), now_s)
        elif not self.drive.holding[self.index]:
            self.drive.hold(self.index, now_s)

    def remake(self) -> None:
        """Make its end of the bus anew, as its settings are."""
        self.device = self.flash.device(self.firmware, new_id_answers=self.quirks.new_id_answers)

    def recall_enabled(self, on: bool) -> None:
        """Be as a saved drive was; nothing comes down for it, as that has been saved too."""
        self.enabled = on
        self.drive.holding[self.index] = on and self.awake
        self.drive.world.energised = all(self.drive.holding)
