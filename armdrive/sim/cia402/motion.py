"""How a simulated CiA 402 drive moves: on ramps, from SYNC to SYNC, to a stop, home.

Positions are the shaft's own increments, whatever zero was set. Times are in seconds, speeds in
increments/s.
"""

from __future__ import annotations

import math
from enum import Enum
from types import MappingProxyType

from armdrive.sim.bus.node import NodeMotor
from armdrive.sim.cia402.objects import DriveObjects
from armdrive.sim.cia402.quirks import Cia402Quirks
from firmware_protocol import canopen
from firmware_protocol.canopen import Place

TO_SWITCH = MappingProxyType({17: -1, 18: 1})
IN_PLACE = (35, 37)
# Homing methods (6098): 17 goes down to the negative limit switch, 18 up to the positive one, and
# slowly back until it opens; 35 and 37 take the present position as home. The position at home then
# is the offset in 607C. A motor has one limit switch: a search for the other one finds nothing.
METHODS = frozenset((0, *TO_SWITCH, *IN_PLACE))
_USUAL_SLOPE, _USUAL_SPEED, _USUAL_WINDOW = 100_000, 1000, 10
_MS_POWER = -3
_SHORTEST_S = 1e-4


class Homing(Enum):
    """The progress of homing."""

    NONE = "not begun, or broken off"
    SEEKING = "on its way to its switch"
    LEAVING = "on its way off its switch"
    DONE = "home"
    FAILED = "failed"

    @property
    def searches(self) -> bool:
        """Whether the drive is searching."""
        return self in (Homing.SEEKING, Homing.LEAVING)


class Cia402Motion:
    """The motion of one drive, as its objects define it."""

    def __init__(
        self,
        motor: NodeMotor,
        objects: DriveObjects,
        quirks: Cia402Quirks,
    ) -> None:
        self._motor, self._point, self._switch = motor, motor.point, motor.switch
        self._objects, self._quirks = objects, quirks
        self.forget()

    def forget(self) -> None:
        """Reset to the state after power-on."""
        self.homing = Homing.NONE
        self._way = 0  # the direction of the switch that homing searches for
        self.ends = False
        """Whether the end of the motion causes something."""
        self.waits = False
        """Whether the set-point has reached its end, but the shaft has not."""
        self.switch_s = math.inf
        """When a search reaches the switch, or leaves it."""

    @property
    def due_s(self) -> float:
        """When the motion ends or reaches the switch, if that causes something."""
        end_s = self._point.end_s if self.ends and not self.waits else math.inf
        return min(end_s, self.switch_s)

    @property
    def arrived(self) -> bool:
        """Whether the shaft is within the position window of the set-point's end."""
        window = self._objects.number_of(canopen.POSITION_WINDOW, _USUAL_WINDOW)
        return abs(self._point.end - self._motor.shaft) <= window

    def moving(self, now_s: float) -> bool:
        """Return whether the set-point is moving."""
        return self._point.moving(now_s)

    def behind(self, now_s: float) -> int:
        """Return the following error of the shaft; 0 without current."""
        return self._point.at(now_s) - self._motor.shaft if self._motor.holding else 0

    # Targets.

    @property
    def _target(self) -> int:
        return self._motor.zero + self._objects.number_of(canopen.TARGET_POSITION, 0)

    def go(self, now_s: float) -> None:
        """Move to the target with the profile's speed and ramps."""
        speed = self._objects.number_of(canopen.PROFILE_SPEED, 0) * self._speed_unit_hz
        self._point.go_to(
            self._target,
            max(min(speed, self._top_rate), 1.0),
            self.slope(canopen.PROFILE_ACCELERATION),
            now_s,
            braking=self._braking,
        )
        self.ends, self.waits = True, False

    def follow(self, now_s: float) -> None:
        """Move straight to the present target, within the interpolation period."""
        power = self._objects.number_of(canopen.PERIOD_POWER, _MS_POWER)
        period_s = max(self._objects.number_of(canopen.PERIOD, 1) * 10.0**power, _SHORTEST_S)
        on = self._quirks.hold_after_loss == "extrapolate"
        self._point.glide_to(self._target, period_s, now_s, on=on)
        self.ends = False

    def brake(self, steep: float, now_s: float) -> None:
        """Brake to a standstill, and hold there."""
        self._point.go_at(0.0, steep, now_s)
        self.ends, self.waits = True, False

    def slow_down(self, now_s: float) -> None:
        """Brake on the profile's ramp."""
        self.brake(self._braking, now_s)

    def let_go(self, now_s: float) -> None:
        """Switch the motor's current off: its load sags, and no motion is supervised any more."""
        self.end_search()
        self.ends, self.switch_s = False, math.inf
        if self._motor.holding:
            self._motor.release(now_s)

    def slope(self, place: Place) -> float:
        """Return an acceleration from an object."""
        unit_hz_s = self._quirks.ramp_unit or self._speed_unit_hz
        return max(self._objects.number_of(place, _USUAL_SLOPE), 1) * unit_hz_s

    @property
    def _speed_unit_hz(self) -> float:
        """The unit of speeds: that of the settings, or the one in 60A9, or one increment/s."""
        if unit_hz := self._quirks.speed_unit:
            return unit_hz
        usual = canopen.RPM if self._quirks.factory else canopen.INCREMENTS_A_SECOND
        word = self._objects.number_of(canopen.SPEED_UNIT, usual)
        per_turn = self._objects.number_of(canopen.ENCODER_INCREMENTS, 10_000)
        return canopen.speed_unit_hz(word, per_turn) or 1.0

    @property
    def _braking(self) -> float:
        """The profile's deceleration; a drive without one uses the acceleration (CiA 402-2)."""
        own = self._objects.dictionary.find(canopen.PROFILE_DECELERATION)
        return self.slope(
            canopen.PROFILE_DECELERATION if own is not None else canopen.PROFILE_ACCELERATION
        )

    @property
    def _top_rate(self) -> float:
        """The motor's top speed, in increments/s."""
        rpm = self._objects.number_of(canopen.MOST_MOTOR_SPEED, 3000)
        return rpm * self._objects.number_of(canopen.ENCODER_INCREMENTS, 10_000) / 60

    # Homing, and the switch.

    def home(self, now_s: float) -> None:
        """Start homing with the configured method."""
        method = self._objects.number_of(canopen.HOMING_METHOD, 0)
        if method in IN_PLACE:
            self._found(self._motor.shaft)
        elif method not in TO_SWITCH:
            self.homing = Homing.FAILED
        else:
            self._way, self.homing = TO_SWITCH[method], Homing.SEEKING
            self._search(self._way, canopen.HOMING_SPEED, now_s)

    def end_search(self) -> None:
        """Forget a search, or that it failed; a drive that is home stays home."""
        self.homing = Homing.DONE if self.homing is Homing.DONE else Homing.NONE

    def break_off_homing(self, now_s: float) -> None:
        """Abort a search, braking."""
        if self.homing.searches:
            self.homing, self.switch_s = Homing.NONE, math.inf
            self.brake(self.slope(canopen.HOMING_ACCELERATION), now_s)

    def watch_switch(self, now_s: float) -> None:
        """Do what is due at the switch of a search."""
        if self.switch_s <= now_s:
            self.switch_s = math.inf
        if self.homing is Homing.SEEKING and self._at_switch:
            self._leave_switch(now_s)
        elif self.homing is Homing.LEAVING and not self._at_switch:
            self._found(self._point.at(now_s))

    def _leave_switch(self, now_s: float) -> None:
        self.homing = Homing.LEAVING
        self._search(-self._way, canopen.HOMING_CREEP, now_s)

    @property
    def _at_switch(self) -> bool:
        """Whether the limit switch in the direction of the search is pressed."""
        return self._switch.way == self._way and self._switch.pressed

    def _search(self, way: int, speed: Place, now_s: float) -> None:
        """Move until the switch changes, if that is in this direction."""
        rate = max(self._objects.number_of(speed, _USUAL_SPEED), 1) * self._speed_unit_hz
        self._point.go_at(way * rate, self.slope(canopen.HOMING_ACCELERATION), now_s)
        self.ends = False
        switch = self._switch
        at = switch.at if way == switch.way else switch.opens_at
        self.switch_s = self._point.passes_s(at, way, now_s)

    def _found(self, at: int) -> None:
        self._point.hold(at)
        self._motor.zero = at - self._objects.number_of(canopen.HOME_OFFSET, 0)
        self.homing, self.switch_s, self.ends = Homing.DONE, math.inf, False
