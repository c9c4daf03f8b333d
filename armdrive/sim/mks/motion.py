"""How a simulated MKS drive moves: its settings, its set-point, and how a motion begins and ends.

Encoder counts are the shaft's own, whatever zero was set. Times are in seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Any, TypeVar, cast

from armdrive.errors import StateFileError
from armdrive.sim.bus.node import NodeMotor
from armdrive.sim.device import Options
from armdrive.sim.mechanics.shafts import ShaftPoint
from armdrive.sim.world.saved import MEND, Json, Saved
from firmware_protocol import mks
from firmware_protocol.errors import ProtocolError
from firmware_protocol.mks import COUNTS_PER_TURN, COUNTS_S_PER_RPM, Code, Outcome, slope_of

# --- The settings that outlast the power, as shipped or as an arm needs them ---------------------

S = TypeVar("S", bound=mks.Setting)

FACTORY: tuple[mks.Setting, ...] = (
    mks.SetMode(mks.Mode.PULSE_FOC),
    mks.SetCurrent(1600),
    mks.SetHoldingCurrent(50),
    mks.SetMicrosteps(16),
    mks.SetDirection(False),
    mks.SetStallProtection(False),
    mks.SetPositionProtection(False, 66, 14_000),
    mks.SetHoming(active_high=False, counter_clockwise=False, speed_rpm=60, limits=False, method=0),
    mks.SetArrival(True),
    mks.SilenceWatchdog(0),
    mks.SetBitrate(mks.Bitrate.K500),
    mks.SetId(1),
    mks.SetReplies(mks.ReplyMode.FULL),
)
"""As a drive is shipped; it belongs to no group. Numbers that are not in the manual are usual."""
FULL_STEPS = 200
"""Of a motor's turn."""


class Flash:
    """The settings of one drive."""

    def __init__(self, changed: Iterable[mks.Setting] = ()) -> None:
        self._settings = {each.code: each for each in (*FACTORY, *changed)}

    def of(self, kind: type[S]) -> S:
        """Return a setting by its kind; a group's id may be none, and is not asked for so."""
        return cast(S, self._settings[kind.code])

    def get(self, code: Code) -> mks.Setting | None:
        """Return a setting by its code; None for a group's id where there is none."""
        return self._settings.get(code)

    def put(self, setting: mks.Setting) -> None:
        """Keep a setting."""
        self._settings[setting.code] = setting

    @property
    def homing(self) -> mks.SetHoming:
        """How the drive homes."""
        return self.of(mks.SetHoming)

    @property
    def mode(self) -> mks.Mode:
        """Who commands the drive."""
        return self.of(mks.SetMode).mode

    @property
    def timeout_s(self) -> float:
        """How long the bus may be silent while the drive moves; infinity without a watchdog."""
        timeout_ms = self.of(mks.SilenceWatchdog).timeout_ms
        return timeout_ms / 1000 if timeout_ms else math.inf

    @property
    def counts_per_pulse(self) -> float:
        """How far a pulse turns the shaft."""
        return COUNTS_PER_TURN / (FULL_STEPS * self.of(mks.SetMicrosteps).microsteps)

    def rpm_of(self, speed_rpm: int) -> float:
        """Return how fast a speed really is."""
        top = self.mode.top_rpm
        return min(max(mks.true_rpm(speed_rpm, self.of(mks.SetMicrosteps).microsteps), -top), top)

    def to_json(self) -> dict[str, Json]:
        """Return the settings as they are on the bus, by the name of their code."""
        return {code.name.lower(): each.payload.hex() for code, each in self._settings.items()}

    def recall(self, saved: Saved) -> None:
        """Know again what `to_json` wrote. Raises `StateFileError`."""
        codes = [each.code for each in FACTORY]
        codes += [Code.GROUP] if saved.has(Code.GROUP.name.lower()) else []
        self._settings = {code: _read(code, saved.text(code.name.lower())) for code in codes}
        saved.end()


def _read(code: Code, text: str) -> mks.Setting:
    try:
        setting = mks.as_setting(mks.SettingRead(code, bytes.fromhex(text)))
    except (ProtocolError, ValueError):
        setting = None
    if setting is None:
        raise StateFileError(f"a saved drive's {code.name.lower()} cannot be {text!r:.60}; {MEND}")
    return setting


# --- The drive's own measures: rpm, and steps of acceleration ------------------------------------

MAKES_UP = mks.SPEED_MAX_RPM * COUNTS_S_PER_RPM
"""Counts a second: no drive makes up for what it has lost faster than it turns."""


def state_of(point: ShaftPoint, now_s: float) -> mks.MotorState:
    """Return what a drive says of its motor that follows a set-point."""
    if not point.moving(now_s):
        return mks.MotorState.STOPPED
    if not (gain := point.gain(now_s)):
        return mks.MotorState.FULL_SPEED
    return mks.MotorState.ACCELERATING if gain > 0.0 else mks.MotorState.DECELERATING


# --- A motion ------------------------------------------------------------------------------------

HOMING_ACC = 236
"""A ramp of 1000 rpm a second, where no request says one."""
CALIBRATION_RPM = 30
STALL_S = 0.05
"""How long a shaft is too far from its set-point before protection lets it go."""
WINDOW_S = 0.015
"""What the window of position protection counts."""
ERROR_PER_TURN = 28_000
"""What its error counts."""
ARRIVAL_PER_TURN = 65_536
AGAINST_A_STOP = 1
"""The way of homing that feels for the end; 0 looks for the switch."""

_GOALS: Mapping[type, Callable[[NodeMotor, Any, float], int]] = MappingProxyType(
    {
        mks.MoveAbsoluteAxis: lambda motor, order, _: motor.zero + order.counts,
        mks.MoveRelativeAxis: lambda motor, order, _: motor.point.end + order.counts,
        mks.MoveAbsolutePulses: lambda motor, order, pulse: (
            motor.zero + round(order.pulses * pulse)
        ),
        mks.MoveRelativePulses: lambda motor, order, pulse: (
            motor.point.end + round(order.pulses * pulse)
        ),
    }
)
"""Where each kind of move leads; `pulse` is what a pulse is in counts."""


def stall_counts(quirks: Options) -> int:
    """Return how far behind its set-point a shaft is that stalls."""
    return round(quirks.number("stall_turns") * COUNTS_PER_TURN)


class MksMotion:
    """The motion of one drive, by its settings. `says` reports the outcome of a request.

    `lets_go` is called where a protection takes the motor's current.
    """

    def __init__(
        self,
        motor: NodeMotor,
        flash: Flash,
        quirks: Options,
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
        """Know nothing of what was before the firmware began."""
        self.armed = False
        """Whether motions are stored for a synchronous start."""
        self.stored: mks.Asked | None = None
        self.under_way: mks.Asked | None = None
        self.homing: mks.HomingState | None = None
        self.heard_s = now_s
        """When the watchdog was fed."""
        self.watchdog_stops = 0
        """How often the watchdog has stopped it."""
        self._expired = False
        self._acc = 0
        self._stall_s = math.inf  # since when the shaft is as far behind as a stall brings it
        self._off_s = math.inf  # since when it is farther than position protection lets it be
        self._waits = False  # the set-point has come to its end, and the shaft has not
        self._seeking = 0  # which way a search for the switch goes; 0 for none
        self._backing = False  # the search goes away from a switch that was pressed at first
        self._switch_s = math.inf  # when the set-point comes to the switch, where that matters

    @property
    def searching(self) -> bool:
        """Whether a homing or a calibration is under way."""
        code = None if self.under_way is None else self.under_way.request.code
        return code in (Code.HOME, Code.CALIBRATE)

    def moving(self, now_s: float) -> bool:
        """Tell whether the set-point is under way."""
        return self._point.moving(now_s)

    def state(self, now_s: float) -> mks.MotorState:
        """Return what the drive says that its motor does."""
        if not self.searching or self.under_way is None:
            return state_of(self._point, now_s)
        calibrates = self.under_way.request.code is Code.CALIBRATE
        return mks.MotorState.CALIBRATING if calibrates else mks.MotorState.HOMING

    def hear(self, now_s: float) -> None:
        """Feed the watchdog."""
        self.heard_s, self._expired = now_s, False

    # How it begins, and how it is ended from outside.

    def begin(self, asked: mks.Asked, now_s: float) -> None:
        """Have the set-point do what was asked, whatever it did before."""
        request = asked.request
        self.under_way, self._waits = asked, False
        self._acc = getattr(request, "acc", HOMING_ACC)
        match request:
            case mks.RunAtSpeed():
                self._run(self._rate_of(request.speed_rpm), now_s)
            case mks.RunFor():
                rate, time_s = self._rate_of(request.speed_rpm), request.duration_ms / 1000
                self._point.go_for(rate, slope_of(self._acc), time_s, now_s)
            case mks.Stop():
                self._run(0.0, now_s)
            case mks.GoToZero():
                self._go(self._motor.zero, self._flash.homing.speed_rpm, now_s)
            case mks.Calibrate():
                self._point.there_and_back(
                    COUNTS_PER_TURN, CALIBRATION_RPM * COUNTS_S_PER_RPM, now_s
                )
            case mks.Home():
                self._seek(now_s)
            case order:
                goal = _GOALS[type(order)](self._motor, order, self._flash.counts_per_pulse)
                self._go(goal, getattr(order, "speed_rpm", 0), now_s)
        self._switch_s = self._passes_switch_s(now_s)

    def arm(self, on: bool) -> None:
        """Store motions from now on until they are started together, or no more."""
        self.armed, self.stored = on, None

    def start_stored(self, now_s: float, *, able: bool) -> None:
        """Begin what is stored, if the drive is able to, without reporting that."""
        asked, self.stored = self.stored, None
        self.armed = self.armed and self._quirks.flag("stays_armed")
        if asked is not None and able:
            self.begin(asked, now_s)

    def give_up(self, now_s: float) -> None:
        """Forget what is under way and what is stored; the set-point goes on as it does."""
        if self._seeking:
            self.homing = mks.HomingState.FAILED
        self.stored = None
        self.drop()
        self._switch_s = math.inf
        if not self._point.moving(now_s):
            self._point.hold(self._point.end)

    def drop(self) -> None:
        """Have nothing under way, as without current."""
        self.under_way, self._seeking = None, 0

    def halt(self, now_s: float) -> None:
        """Give up, and stand dead."""
        self.give_up(now_s)
        self._point.hold(self._point.at(now_s))

    # How it goes on by itself.

    def due_s(self) -> float:
        """Tell when it next does something by itself, apart from looking at its shaft."""
        if self.under_way is None:
            return math.inf
        due = math.inf if self._waits else self._point.end_s
        silent_s = self.heard_s + self._flash.timeout_s
        if not self._expired and silent_s < self._point.end_s:  # one that stands is not stopped
            due = min(due, silent_s)
        return min(due, self._switch_s)

    def live(self, now_s: float) -> None:
        """Do whatever is due by now."""
        self._watch_silence(now_s)
        self._watch_shaft(now_s)
        self._watch_switch(now_s)
        self._watch_end(now_s)

    def _go(self, goal: int, speed_rpm: int, now_s: float) -> None:
        self._point.go_to(goal, self._rate_of(max(speed_rpm, 1)), slope_of(self._acc), now_s)

    def _run(self, rate: float, now_s: float) -> None:
        self._point.go_at(rate, slope_of(self._acc), now_s)

    def _rate_of(self, speed_rpm: int) -> float:
        return self._flash.rpm_of(speed_rpm) * COUNTS_S_PER_RPM

    def _seek(self, now_s: float) -> None:
        """Begin to search for the zero: first away from the switch, where that is pressed."""
        setting = self._flash.homing
        self._seeking = 1 if setting.counter_clockwise else -1
        self.homing = mks.HomingState.UNDER_WAY
        self._backing = setting.method != AGAINST_A_STOP and self._switch.pressed
        self._search_towards(-self._seeking if self._backing else self._seeking, now_s)

    def _search_towards(self, way: int, now_s: float) -> None:
        self._run(way * self._rate_of(max(self._flash.homing.speed_rpm, 1)), now_s)

    def _passes_switch_s(self, now_s: float) -> float:
        """Return when the set-point comes to where the switch changes, if that matters."""
        switch = self._switch
        if not self._seeking and not self._flash.homing.limits:
            return math.inf
        if self._seeking and self._backing:
            return self._point.passes_s(switch.at - switch.way, -switch.way, now_s)
        if switch.pressed:
            return now_s
        return self._point.passes_s(switch.at, switch.way, now_s)

    def _watch_silence(self, now_s: float) -> None:
        """Stop where the bus has been silent for too long; the drive says nothing of it."""
        moves = self.under_way is not None and self._point.moving(now_s)
        if moves and not self._expired and now_s >= self.heard_s + self._flash.timeout_s:
            self.give_up(now_s)
            self._run(0.0, now_s)
            self._expired = True
            self.watchdog_stops += 1

    def _watch_shaft(self, now_s: float) -> None:
        """Let a shaft go that does not follow, where a protection is on."""
        error = abs(self._point.at(now_s) - self._motor.shaft)
        if not error or not self._motor.holding:
            self._stall_s = self._off_s = math.inf
            return
        stalls = error >= stall_counts(self._quirks)
        self._stall_s = min(self._stall_s, now_s) if stalls else math.inf
        if self._seeking and self._flash.homing.method == AGAINST_A_STOP:
            if stalls:
                self._found(self._motor.shaft)
            return
        guarded = self._flash.of(mks.SetStallProtection).on
        if (guarded and now_s >= self._stall_s + STALL_S) or self._is_off(error, now_s):
            asked = self.under_way
            self.give_up(now_s)
            self._lets_go(now_s)
            if asked is not None:
                self._says(asked, Outcome.FAILED)

    def _is_off(self, error: int, now_s: float) -> bool:
        guard = self._flash.of(mks.SetPositionProtection)
        if not guard.on:
            return False
        beyond = error * ERROR_PER_TURN >= guard.error * COUNTS_PER_TURN
        self._off_s = min(self._off_s, now_s) if beyond else math.inf
        return now_s >= self._off_s + guard.window * WINDOW_S

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
        """Stand, call it zero, and say so."""
        self._point.hold(at)
        self._motor.zero = at
        self.homing = mks.HomingState.DONE
        asked, self._seeking = self.under_way, 0
        if asked is not None:
            self._says(asked, Outcome.DONE)
        self.under_way = None

    def _limit(self, asked: mks.Asked, now_s: float) -> None:
        """End what leads into the switch; what leads away from it goes on."""
        rate = self._point.rate(now_s) or self._point.rate(now_s + 1e-6)
        if rate * self._switch.way > 0:
            self._point.hold(self._point.at(now_s))
            searches, self.under_way = self.searching, None
            if not searches:
                self._says(asked, Outcome.LIMIT_STOP)

    def _watch_end(self, now_s: float) -> None:
        asked = self.under_way
        if asked is None or self._seeking or self._point.moving(now_s):
            return
        self._waits = abs(self._point.end - self._motor.shaft) > self._threshold
        if not self._waits:
            self._says(asked, Outcome.DONE)
            self.under_way = None

    @property
    def _threshold(self) -> float:
        """How near a motion must come to be done: older firmware does not look at all."""
        setting = self._flash.of(mks.SetArrival)
        if not self._minds_arrival or not setting.on:
            return math.inf
        return setting.threshold * COUNTS_PER_TURN / ARRIVAL_PER_TURN
