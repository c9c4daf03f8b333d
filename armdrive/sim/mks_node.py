"""One simulated MKS drive: what it is set up to be, what it knows, and what it says.

What a request does is in `mks_obey`; how a motion goes on by itself in `mks_course`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from armdrive.sim.limit_switch import LimitSwitch
from armdrive.sim.mks_drive import ClosedLoopDrive
from armdrive.sim.mks_flash import Flash
from armdrive.sim.mks_motor import SetPoint
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    Asked,
    Code,
    HomingState,
    Mode,
    Outcome,
    SetMicrosteps,
    SetMode,
    SilenceWatchdog,
    Version,
    true_rpm,
)

FULL_STEPS = 200
"""Of a motor's turn."""


@dataclass(frozen=True, slots=True)
class Habits:
    """What public sources leave open of these drives; `mks_twin.KIND` says what each means."""

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


class Node:
    """A drive on the motor of its index. Its owner calls `mks_course` whenever time has passed."""

    def __init__(
        self,
        index: int,
        firmware: Version,
        flash: Flash,
        drive: ClosedLoopDrive,
        switch: LimitSwitch,
        habits: Habits,
    ) -> None:
        self.index = index
        self.firmware = firmware
        self.drive = drive
        self.switch = switch
        self.habits = habits
        self.flash = flash
        self.device = flash.device(firmware, new_id_answers=habits.new_id_answers)
        self.powered = True
        self.mute = False
        self.plugged = True
        """Whether its CAN cable is in."""
        self.says_done = habits.says_done
        self.enabled = habits.enabled_on
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
    def point(self) -> SetPoint:
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
        if self.habits.says_refused:
            self.tell(asked, Outcome.FAILED)

    def say(self, data: bytes) -> None:
        """Have bytes brought to the bus."""
        if data and self.plugged and not self.mute and self.awake:
            self.said.append(data)

    @property
    def answer_s(self) -> float:
        """How long it takes to have an answer ready."""
        return self.habits.answer_s

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
        turned = self.shaft % COUNTS_PER_TURN if self.habits.keeps_angle else 0
        self.zero = self.power_on_zero = self.shaft - turned
        self.set_enabled(self.habits.enabled_on, now_s)

    def restart(self, now_s: float) -> None:
        """Begin anew, after a while in which nothing holds the shaft and nobody answers."""
        self.fall_silent(now_s)
        self.boots_s = now_s + self.habits.boot_s

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
        self.device = self.flash.device(self.firmware, new_id_answers=self.habits.new_id_answers)

    def recall_enabled(self, on: bool) -> None:
        """Be as a saved drive was; nothing comes down for it, as that has been saved too."""
        self.enabled = on
        self.drive.holding[self.index] = on and self.awake
        self.drive.world.energised = all(self.drive.holding)
