"""How a simulated MKS drive moves: its settings, its set-point, and how a motion begins and ends.

Encoder counts are the shaft's own, whatever zero was set. Times are in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import TypeVar, cast

from armdrive.sim.bus.node import NodeMotor
from armdrive.sim.mechanics.shafts import ShaftPoint
from armdrive.sim.mks.quirks import MksQuirks
from armdrive.sim.world.saved import require_names, unfit
from firmware_protocol import mks
from firmware_protocol.errors import ProtocolError
from firmware_protocol.mks import COUNTS_PER_TURN, COUNTS_S_PER_RPM, Code, Outcome, slope_of

# --- The settings, which a drive keeps without power --------------------------------------------

S = TypeVar("S", bound=mks.Setting)

# The settings of a new drive. Where the manual gives no number, it is a common one.
FACTORY: tuple[mks.Setting, ...] = (
    mks.SetMode(mks.Mode.PULSE_FOC),
    mks.SetCurrent(1600),
    mks.SetMicrosteps(16),
    mks.SetStallProtection(False),
    mks.SetHoming(active_high=False, counter_clockwise=False, speed_rpm=60, limits=False, method=0),
    mks.SilenceWatchdog(0),
    mks.SetBitrate(mks.Bitrate.K500),
    mks.SetId(1),
    mks.SetReplies(mks.ReplyMode.FULL),
)


class Flash:
    """The settings of one drive."""

    def __init__(self, changed: Iterable[mks.Setting] = ()) -> None:
        self._settings = {each.code: each for each in (*FACTORY, *changed)}

    def of(self, kind: type[S]) -> S:
        """Return a setting by its type."""
        return cast(S, self._settings[kind.code])

    def get(self, code: Code) -> mks.Setting:
        """Return a setting by its code."""
        return self._settings[code]

    def put(self, setting: mks.Setting) -> None:
        """Store a setting."""
        self._settings[setting.code] = setting

    @property
    def homing(self) -> mks.SetHoming:
        """The homing method and its speed."""
        return self.of(mks.SetHoming)

    @property
    def mode(self) -> mks.Mode:
        """The mode, which decides what commands the drive."""
        return self.of(mks.SetMode).mode

    @property
    def timeout_s(self) -> float:
        """How long the bus may be silent while the drive moves; infinity if the watchdog is off."""
        timeout_ms = self.of(mks.SilenceWatchdog).timeout_ms
        return timeout_ms / 1000 if timeout_ms else math.inf

    def rpm_of(self, speed_rpm: int) -> float:
        """Return the true speed for an ordered one, which depends on microsteps and mode."""
        microsteps = self.of(mks.SetMicrosteps).microsteps
        return min(mks.true_rpm(speed_rpm, microsteps), self.mode.top_rpm)

    def to_json(self) -> dict[str, str]:
        """Return the settings as bytes in hexadecimal, by the names of their codes."""
        return {_name(code): each.payload.hex() for code, each in self._settings.items()}

    def recall(self, saved: Mapping[str, str]) -> None:
        """Restore what `to_json` returned. Raises `StateFileError`."""
        codes = [each.code for each in FACTORY]
        require_names("settings of a drive", saved, map(_name, codes))
        self._settings = {code: _read(code, saved[_name(code)]) for code in codes}


def _name(code: Code) -> str:
    return code.name.lower()


def _read(code: Code, text: str) -> mks.Setting:
    try:
        setting = mks.as_setting(mks.SettingRead(code, bytes.fromhex(text)))
    except (ProtocolError, ValueError):
        setting = None
    if setting is None:
        raise unfit(f"a saved drive's {_name(code)} cannot be {text!r:.60}")
    return setting


# --- Speeds and states ---------------------------------------------------------------------------

# How many counts a second a shaft turns at most.
TOP_RATE = mks.SPEED_MAX_RPM * COUNTS_S_PER_RPM


def state_of(point: ShaftPoint, now_s: float) -> mks.MotorState:
    """Return the state that a drive reports while its motor follows a set-point."""
    if not point.moving(now_s):
        return mks.MotorState.STOPPED
    if not (gain := point.gain(now_s)):
        return mks.MotorState.FULL_SPEED
    return mks.MotorState.ACCELERATING if gain > 0.0 else mks.MotorState.DECELERATING


# --- A motion ------------------------------------------------------------------------------------

# A ramp of 1000 rpm a second, for requests that give none.
HOMING_ACC = 236
CALIBRATION_RPM = 30
# The speed after a new target with `retarget_creeps`: 600 degrees in 2.5 s were observed.
CREEP_RPM = 40
# The distance from its set-point at which a shaft stalls.
STALL_COUNTS = round(COUNTS_PER_TURN / 10)
# A shaft that is too far from its set-point for this long has stalled.
STALL_S = 0.05
# How near its target a motion must come to be done, with the factory's threshold.
ARRIVAL_COUNTS = 50
# The homing method that runs against a mechanical stop; 0 searches for the switch.
AGAINST_A_STOP = 1


class MksNodeMotion:
    """The motion of one drive. `says` reports the outcome of a request.

    `lets_go` is called when a protection switches the motor's current off.
    """

    def __init__(
        self,
        motor: NodeMotor,
        flash: Flash,
        quirks: MksQuirks,
        *,
        minds_arrival: bool,
        says: Callable[[mks.Asked, Outcome], None],
        lets_go: Callable[[float], None],
    ) -> None:
        self._motor, self._point, self._switch = motor, motor.point, motor.switch
        self._flash, self._quirks = flash, quirks
        self._minds_arrival = minds_arrival
        self._says, self._lets_go = says, lets_go
        self.forget(0.0)

    def forget(self, now_s: float) -> None:
        """Reset to the state after the firmware has started."""
        self.armed = False
        """Whether motions are stored for a synchronous start."""
        self.under_way: mks.Asked | None = None
        self.homing: mks.HomingState | None = None
        self.heard_s = now_s
        """When a frame has fed the watchdog last."""
        self.watchdog_stops = 0
        """How often the watchdog has stopped it."""
        self._expired = False
        self._has_moved = False  # since the firmware started
        self.ignores_next = False
        """Whether it will ignore the next motion."""
        self._acc = 0
        self._stall_s = math.inf  # since when the shaft is as far behind as in a stall
        self._waits = False  # the set-point has reached its end, and the shaft has not
        self._seeking = 0  # the direction of a search for the switch; 0 for none
        self._backing = False  # the search moves away from a switch that was pressed at first
        self._switch_s = math.inf  # when the set-point reaches the switch, if that matters

    @property
    def searching(self) -> bool:
        """Whether it is homing or calibrating."""
        code = None if self.under_way is None else self.under_way.request.code
        return code in (Code.HOME, Code.CALIBRATE)

    def moving(self, now_s: float) -> bool:
        """Return whether the set-point is moving."""
        return self._point.moving(now_s)

    def state(self, now_s: float) -> mks.MotorState:
        """Return the motor state that the drive reports."""
        if not self.searching or self.under_way is None:
            state = state_of(self._point, now_s)
            stays = state is mks.MotorState.STOPPED and self._has_moved
            brakes = stays and self._quirks.brakes_on
            return mks.MotorState.DECELERATING if brakes else state
        calibrates = self.under_way.request.code is Code.CALIBRATE
        return mks.MotorState.CALIBRATING if calibrates else mks.MotorState.HOMING

    def feed_watchdog(self, now_s: float) -> None:
        """Feed the watchdog."""
        self.heard_s, self._expired = now_s, False

    # Requests that begin and end motions.

    def begin(self, asked: mks.Asked, now_s: float) -> None:
        """Begin a motion; it replaces any other."""
        request = asked.request
        self.under_way, self._waits = asked, False
        self._has_moved = True
        self._acc = getattr(request, "acc", HOMING_ACC)
        match request:
            case mks.Stop():
                self._run(0.0, now_s)
            case mks.Calibrate():
                self._point.there_and_back(
                    COUNTS_PER_TURN, CALIBRATION_RPM * COUNTS_S_PER_RPM, now_s
                )
            case mks.Home():
                self._seek(now_s)
            case mks.MoveAbsoluteAxis(counts, speed_rpm):
                self._go(self._motor.zero + counts, speed_rpm, now_s)
        self._switch_s = self._passes_switch_s(now_s)

    def arm(self, on: bool) -> None:
        """Store motions from now on, or begin them at once again."""
        self.armed = on

    def give_up(self, now_s: float) -> None:
        """Forget the present motion; the set-point continues."""
        if self._seeking:
            self.homing = mks.HomingState.FAILED
        self.drop()
        self._switch_s = math.inf
        if not self._point.moving(now_s):
            self._point.hold(self._point.end)

    def drop(self) -> None:
        """Forget the present motion, as without current."""
        self.under_way, self._seeking = None, 0

    def halt(self, now_s: float) -> None:
        """Give up, and stand at once."""
        self.give_up(now_s)
        self._point.hold(self._point.at(now_s))

    # What happens without a request.

    def due_s(self) -> float:
        """Return when it next acts by itself, apart from controlling its shaft."""
        if self.under_way is None:
            return math.inf
        due = math.inf if self._waits else self._point.end_s
        silent_s = self.heard_s + self._flash.timeout_s
        if not self._expired and silent_s < self._point.end_s:  # it stops only moving drives
            due = min(due, silent_s)
        return min(due, self._switch_s)

    def live(self, now_s: float) -> None:
        """Do what is due by now."""
        self._watch_silence(now_s)
        self._watch_shaft(now_s)
        self._watch_switch(now_s)
        self._watch_end(now_s)

    def _go(self, goal: int, speed_rpm: int, now_s: float) -> None:
        brakes = self.state(now_s) is mks.MotorState.DECELERATING
        if self._quirks.retarget_creeps and self.moving(now_s) and not brakes:
            speed_rpm = min(speed_rpm, CREEP_RPM)
        self._point.go_to(goal, self._rate_of(speed_rpm), slope_of(self._acc), now_s)

    def _run(self, rate: float, now_s: float) -> None:
        self._point.go_at(rate, slope_of(self._acc), now_s)

    def _rate_of(self, speed_rpm: int) -> float:
        return self._flash.rpm_of(speed_rpm) * COUNTS_S_PER_RPM

    def _seek(self, now_s: float) -> None:
        """Begin homing: first away from the switch, if it is pressed."""
        setting = self._flash.homing
        up = setting.counter_clockwise is not self._quirks.homes_reversed
        self._seeking = 1 if up else -1
        self.homing = mks.HomingState.UNDER_WAY
        self._backing = setting.method != AGAINST_A_STOP and self._switch.pressed
        self._search_towards(-self._seeking if self._backing else self._seeking, now_s)

    def _search_towards(self, way: int, now_s: float) -> None:
        self._run(way * self._rate_of(max(self._flash.homing.speed_rpm, 1)), now_s)

    def _passes_switch_s(self, now_s: float) -> float:
        """Return when the set-point reaches the place where the switch changes, if that matters."""
        switch = self._switch
        if not self._seeking and not self._flash.homing.limits:
            return math.inf
        if self._seeking and self._backing:
            return self._point.passes_s(switch.opens_at, -switch.way, now_s)
        if switch.pressed:
            return now_s
        return self._point.passes_s(switch.at, switch.way, now_s)

    def _watch_silence(self, now_s: float) -> None:
        """Stop if the bus has been silent for too long; the drive does not report that."""
        moves = self.under_way is not None and self._point.moving(now_s)
        if moves and not self._expired and now_s >= self.heard_s + self._flash.timeout_s:
            self.give_up(now_s)
            self._run(0.0, now_s)
            self._expired = True
            self.watchdog_stops += 1

    def _watch_shaft(self, now_s: float) -> None:
        """Release a shaft that does not follow, if a protection is on."""
        error = abs(self._point.at(now_s) - self._motor.shaft)
        if not error or not self._motor.holding:
            self._stall_s = math.inf
            return
        stalls = error >= STALL_COUNTS
        self._stall_s = min(self._stall_s, now_s) if stalls else math.inf
        if self._seeking and self._flash.homing.method == AGAINST_A_STOP:
            if stalls:
                self._found(self._motor.shaft)
            return
        guarded = self._flash.of(mks.SetStallProtection).on
        if guarded and now_s >= self._stall_s + STALL_S:
            asked = self.under_way
            self.give_up(now_s)
            self._lets_go(now_s)
            if asked is not None:
                self._says(asked, Outcome.FAILED)

    def _watch_switch(self, now_s: float) -> None:
        if self._switch_s <= now_s:
            self._switch_s = math.inf
        if self._seeking:
            self._search(now_s)
        elif self.under_way is not None and self._flash.homing.limits and self._switch.pressed:
            self._limit(self.under_way, now_s)

    def _search(self, now_s: float) -> None:
        against = self._flash.homing.method == AGAINST_A_STOP
        if against or self._switch.pressed is self._backing:
            return
        if self._backing:
            self._backing = False
            self._search_towards(self._seeking, now_s)
            self._switch_s = self._passes_switch_s(now_s)
        else:
            self._found(self._point.at(now_s))

    def _found(self, at: int) -> None:
        """Stand, count from zero here, and report it."""
        self._point.hold(at)
        self._motor.zero = at
        self.homing = mks.HomingState.DONE
        asked, self._seeking = self.under_way, 0
        if asked is not None:
            self._says(asked, Outcome.DONE)
        self.under_way = None

    def _limit(self, asked: mks.Asked, now_s: float) -> None:
        """End a motion into the switch; one away from it continues."""
        rate = self._point.rate(now_s) or self._point.rate(now_s + 1e-6)
        if rate * self._switch.way > 0.0:
            self._point.hold(self._point.at(now_s))
            searches, self.under_way = self.searching, None
            self.ignores_next = self._quirks.deaf_after_limit
            if not searches:
                self._says(asked, Outcome.LIMIT_STOP)

    def _watch_end(self, now_s: float) -> None:
        asked = self.under_way
        if asked is None or self._seeking or self._point.moving(now_s):
            return
        error = abs(self._point.end - self._motor.shaft)
        self._waits = self._minds_arrival and error > ARRIVAL_COUNTS
        if not self._waits:
            self._says(asked, Outcome.DONE)
            self.under_way = None
