"""What an arm file says in `[cia402]`: which drives are on the bus, and how they are driven."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from armdrive.dialects.bus.motors import BusMotors, check_ids
from armdrive.dialects.bus.observer import Bounds
from armdrive.dialects.bus.way import trapezoid_s
from armdrive.errors import ArmFileError
from armdrive.text.toml import within
from firmware_protocol.canopen import NODE_MAX, Service, cob_id

CYCLIC, PROFILE = "cyclic", "profile"
STRATEGIES = (CYCLIC, PROFILE)
BEATS = 2
"""So many heartbeats at least fit into the time after which drives miss them: one may be lost."""
LATE_S = 0.1
"""By so much an order may be late, or a reading, that is nobody's fault: on a busy computer a SYNC
of every 10 ms was 58 to 69 ms late at worst, and orders of every 40 ms 81 to 160 ms."""
HOMING_METHODS = (-128, 37)


@dataclass(frozen=True, slots=True)
class Cia402Settings:
    """The drives of an arm, in the order of its motors, and how they are driven.

    `ids` are their node numbers and `master_id` is this program's. Drives stop, and hold, when they
    have not heard its heartbeat for `heartbeat_ms`; it is sent every `beat_ms` while motors are on.
    `drive_beat_ms` is the period of the drives' own heartbeats.

    `strategy` "cyclic" gives every drive a target each `period_ms` (longer where the bus is too
    slow for that), smoothed by a moving average over `smoothing_ms`; "profile" sends bursts that
    the drives drive by ramps of their own, as where a drive has no cyclic position mode. `ramp_s`
    is how long those take from rest to the arm's full speed, and `quick_stop_s` how long a quick
    stop takes from there.

    `following_window` is how many increments a drive may be behind its target, for longer than
    `following_ms`, before it faults; `rest_window` how far from it a drive stands that holds it.
    `encoder_increments` of a motor's turn are compared with the drives' (0: left as it is).

    A transfer of an object is waited for `answer_s`. Homing is by `homing_methods` (object 6098),
    one for each motor, as the drives are set up where it is empty; `homing_speeds` are increments a
    second towards the switch and away from it (0: as set up). It may take `homing_s`.
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
        check_ids("cia402", self.ids, NODE_MAX, "a node number")
        for name, (low, high) in _BOUNDS.items():
            within(f"cia402.{name}", getattr(self, name), low, high)
        if self.master_id in self.ids:
            raise ArmFileError(
                f"cia402.master_id is this program's own number, and {self.master_id} is a drive's"
            )
        if self.strategy not in STRATEGIES:
            raise ArmFileError(
                f'cia402.strategy is "{CYCLIC}" or "{PROFILE}", not {self.strategy!r}'
            )
        if self.heartbeat_ms < BEATS * self.beat_ms:
            raise ArmFileError(
                f"cia402.heartbeat_ms must be {BEATS} times cia402.beat_ms at least, which feeds "
                f"it: with {self.heartbeat_ms} and {self.beat_ms} the drives would stop in "
                "mid-motion"
            )
        self._check_homing()

    @property
    def bounds(self) -> Bounds:
        """How far from its orders a healthy drive may be: it faults by itself beyond that."""
        window, late_s = self.following_window, LATE_S + self.following_ms / 1000.0
        return Bounds(self.rest_window, window, window, late_s=late_s)

    @property
    def frame_ids(self) -> tuple[int, ...]:
        """The ids of the frames that are listened to: what the drives say, and a rival's beat."""
        said = (Service.EMCY, Service.TPDO1, Service.SDO_RESPONSE, Service.HEARTBEAT)
        own = tuple(cob_id(service, node) for service in said for node in self.ids)
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


# What follows from it for an arm: how fast its drives turn, and how often they are told where.

BUSY_AT_MOST = 0.7
"""How much of a bus's time the cyclic frames may take: the rest is for heartbeats and SDO."""
FRAME_BITS, SYNC_BITS = 123, 56
"""Of a PDO of seven bytes and of a SYNC, with stuffing and the space behind."""
TOP_HZ = 10_000_000.0
"""No drive is asked for more increments a second."""


def period_ms(settings: Cia402Settings, drives: int, bit_rate: int) -> int:
    """Return the period of SYNC: the arm file's, or a longer one that the bus can carry."""
    bits = 2 * drives * FRAME_BITS + SYNC_BITS
    return max(settings.period_ms, math.ceil(1000.0 * bits / bit_rate / BUSY_AT_MOST))


@dataclass(frozen=True, slots=True)
class DriveLimits:
    """What the motors of an arm can do, in increments and seconds.

    `cycle_s` is the period of SYNC, `fastest_hz` how fast the fastest motor turns at most and
    `ranges` how far each does between the limits of its joints. `ramp_hz_s` is the ramp of the
    busiest motor, `quick_hz_s` that of a quick stop.
    """

    cycle_s: float
    fastest_hz: float
    ranges: tuple[float, ...]
    ramp_hz_s: float
    quick_hz_s: float

    @classmethod
    def of(cls, settings: Cia402Settings, motors: BusMotors, bit_rate: int) -> DriveLimits:
        """Return those of an arm whose drives are on a bus of so many bits a second."""
        return cls(
            period_ms(settings, motors.count, bit_rate) / 1000.0,
            motors.fastest_hz,
            motors.ranges,
            motors.fastest_hz / settings.ramp_s,
            motors.fastest_hz / settings.quick_stop_s,
        )

    def lasts_s(self, steps: float, rate_hz: float) -> float:
        """Return how long a burst takes from rest to rest."""
        return trapezoid_s(steps, min(rate_hz, TOP_HZ), self.ramp_hz_s)
