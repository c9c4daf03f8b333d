"""The arm file's section `[cia402]`: which drives are on the bus, and how they are driven."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.dialects.bus.drives import BusMotors, check_feeding, check_settings
from armdrive.dialects.bus.observer import MAX_DELAY_S, Bounds
from armdrive.dialects.bus.paths import Trapezoid
from armdrive.errors import ArmFileError
from armdrive.text.toml import within
from firmware_protocol.canopen import NODE_MAX, Service, cob_id

CYCLIC, PROFILE = "cyclic", "profile"
STRATEGIES = (CYCLIC, PROFILE)
HOMING_METHODS = (-128, 37)


@dataclass(frozen=True, slots=True)
class Cia402Settings:
    """The drives of an arm, in the order of its motors, and how they are driven.

    `ids` are their node numbers, `master_id` is this program's. Drives stop and hold if its
    heartbeat is missing for `heartbeat_ms`; it is sent every `beat_ms` while motors are on.
    `drive_beat_ms` is the period of the drives' own heartbeats.

    With `strategy` "cyclic" every drive gets a target each `period_ms` (or more, if the bus is too
    slow for that), smoothed by a moving average over `smoothing_ms`. With "profile" the drives get
    bursts and use ramps of their own; so do drives without cyclic position mode. `ramp_s` is how
    long those ramps take from rest to the arm's full speed, and `quick_stop_s` how long a quick
    stop takes from there.

    A drive faults if it is more than `following_window` increments behind its target for longer
    than `following_ms`. A drive that holds its target is within `rest_window` of it.
    `encoder_increments` of a motor's turn are compared with those of the drives (0: not compared).

    `answer_s` is the timeout of an object transfer. `homing_methods` has one method (object 6098)
    for each motor; if empty, the drives use their own. `homing_speeds` are increments a second
    towards the switch and away from it (0: the drive's own). Homing may take `homing_s`.
    """

    ids: tuple[int, ...] = (1, 2, 3, 4, 5, 6)
    master_id: int = NODE_MAX
    strategy: str = CYCLIC
    period_ms: int = 10
    smoothing_ms: int = 30
    heartbeat_ms: int = 200
    beat_ms: int = 50
    drive_beat_ms: int = 100
    ramp_s: float = 0.15
    quick_stop_s: float = 0.1
    following_window: int = 2000
    following_ms: int = 50
    rest_window: int = 8
    encoder_increments: int = 0
    answer_s: float = 0.05
    homing_methods: tuple[int, ...] = ()
    homing_speeds: tuple[int, int] = (0, 0)
    homing_s: float = 60.0

    def __post_init__(self) -> None:
        check_settings("cia402", self, NODE_MAX, "a node number", _BOUNDS)
        if self.master_id in self.ids:
            raise ArmFileError(
                f"cia402.master_id is this program's own number, and {self.master_id} is a drive's"
            )
        if self.strategy not in STRATEGIES:
            raise ArmFileError(
                f'cia402.strategy is "{CYCLIC}" or "{PROFILE}", not {self.strategy!r}'
            )
        check_feeding(self, "cia402.heartbeat_ms", "cia402.beat_ms")
        self._check_homing()

    @property
    def bounds(self) -> Bounds:
        """How far from its orders a healthy drive may be; beyond that it faults by itself."""
        window, late_s = self.following_window, MAX_DELAY_S + self.following_ms / 1000.0
        return Bounds(self.rest_window, window, window, late_s=late_s)

    @property
    def frame_ids(self) -> tuple[int, ...]:
        """The ids of received frames: those from the drives, and another master's heartbeat."""
        services = (Service.EMCY, Service.TPDO1, Service.SDO_RESPONSE, Service.HEARTBEAT)
        own = tuple(cob_id(service, node) for service in services for node in self.ids)
        return (*own, cob_id(Service.HEARTBEAT, self.master_id))

    def _check_homing(self) -> None:
        if self.homing_methods and len(self.homing_methods) != len(self.ids):
            raise ArmFileError(
                f"cia402.homing_methods has one for each of the {len(self.ids)} drives, or none, "
                f"not {len(self.homing_methods)}"
            )
        for index, method in enumerate(self.homing_methods):
            within(f"cia402.homing_methods[{index}]", method, *HOMING_METHODS)
        for index, speed in enumerate(self.homing_speeds):
            within(f"cia402.homing_speeds[{index}]", speed, 0, 10_000_000)


_BOUNDS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "master_id": (1, NODE_MAX),
        "period_ms": (4, 50),
        "smoothing_ms": (0, 200),
        "heartbeat_ms": (50, 2000),
        "beat_ms": (10, 500),
        "drive_beat_ms": (20, 2000),
        "ramp_s": (0.01, 5.0),
        "quick_stop_s": (0.01, 1.0),
        "following_window": (50, 10_000_000),
        "following_ms": (0, 1000),
        "rest_window": (1, 1000),
        "encoder_increments": (0, 100_000_000),
        "answer_s": (0.01, 2.0),
        "homing_s": (1.0, 290.0),
    }
)


# What follows for an arm: the speeds of its drives and the period of their targets.

BUSY_AT_MOST = 0.7
"""The share of the bus that cyclic frames may use; the rest is for heartbeats and SDO."""
FRAME_BITS, SYNC_BITS = 123, 56
"""Lengths of a PDO of seven bytes and of a SYNC, with stuff bits and interframe space."""
TOP_HZ = 10_000_000.0
"""The greatest speed that is commanded, in increments a second."""


def period_ms(settings: Cia402Settings, drives: int, bit_rate: int) -> int:
    """Return the period of SYNC: that of the arm file, or the shortest that the bus can carry."""
    bits = 2 * drives * FRAME_BITS + SYNC_BITS
    return max(settings.period_ms, math.ceil(1000.0 * bits / bit_rate / BUSY_AT_MOST))


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """The limits of an arm's motors, in increments and seconds.

    `cycle_s` is the period of SYNC, `fastest_hz` the speed limit of the fastest motor, and `ranges`
    each motor's travel between its joints' limits. `ramp_hz_s` is the acceleration of the busiest
    motor, `quick_hz_s` the deceleration of a quick stop.
    """

    cycle_s: float
    fastest_hz: float
    ranges: tuple[float, ...]
    ramp_hz_s: float
    quick_hz_s: float

    @classmethod
    def of(cls, settings: Cia402Settings, motors: BusMotors, bit_rate: int) -> DriveLimits:
        """Return the limits of an arm on a bus with this bit rate."""
        return cls(
            period_ms(settings, motors.count, bit_rate) / 1000.0,
            motors.fastest_hz,
            motors.ranges,
            motors.fastest_hz / settings.ramp_s,
            motors.fastest_hz / settings.quick_stop_s,
        )

    def lasts_s(self, steps: float, rate_hz: float) -> float:
        """Return how long a burst takes from rest to rest."""
        return Trapezoid.of(steps, min(rate_hz, TOP_HZ), self.ramp_hz_s).duration_s
