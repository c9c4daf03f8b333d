"""The arm file's section `[cia402]`: which drives are on the bus, and how they are driven."""

from __future__ import annotations

import math
from dataclasses import dataclass

from armdrive.dialects.bus.drives import BusMotors, check_feeding, check_ids
from armdrive.errors import ArmFileError
from armdrive.text.toml import check_settings, setting
from armdrive.transports.can_health import BUSY_LOAD, frame_bits
from firmware_protocol.canopen import NODE_MAX, Service, Sync, cob_id
from firmware_protocol.frames import Frame
from kinematics.paths.profiles import trapezoid

CYCLIC, PROFILE = "cyclic", "profile"


@dataclass(frozen=True, slots=True)
class Cia402Settings:
    """The drives of an arm, in the order of its motors, and how they are driven.

    With `strategy` "cyclic" every drive gets a target each `period_ms` (or more, if the bus is too
    slow for that). With "profile" the drives get bursts and use ramps of their own; so do drives
    without cyclic position mode. A drive faults by itself if its following error is greater than
    `following_window` for longer than `following_ms`.
    """

    ids: tuple[int, ...] = setting(
        (1, 2, 3, 4, 5, 6), "node numbers, in the order of the motors", low=1, high=NODE_MAX
    )
    master_id: int = setting(
        NODE_MAX, "this program's node number, in its heartbeat", low=1, high=NODE_MAX
    )
    strategy: str = setting(
        CYCLIC, "cyclic: a target each period; profile: bursts", words=(CYCLIC, PROFILE)
    )
    period_ms: int = setting(10, "period of SYNC and of targets", low=4, high=50)
    smoothing_ms: int = setting(30, "targets are averaged over this time", low=0, high=200)
    heartbeat_timeout_ms: int = setting(
        200, "drives stop and hold without this program's heartbeat", low=50, high=2000
    )
    heartbeat_period_ms: int = setting(50, "period of this program's heartbeat", low=10, high=500)
    drive_heartbeat_ms: int = setting(100, "period of the drives' heartbeats", low=20, high=2000)
    ramp_s: float = setting(
        0.15, "ramps of bursts, from rest to the arm's full speed", low=0.01, high=5.0
    )
    quick_stop_s: float = setting(0.1, "a quick stop from full speed", low=0.01, high=1.0)
    following_window: int = setting(
        2000, "following error at which drives fault", low=50, high=10_000_000
    )
    following_ms: int = setting(50, "for how long it may be greater", low=0, high=1000)
    position_window: int = setting(
        8, "a drive that holds is this close to its target", low=1, high=1000
    )
    encoder_increments: int = setting(
        0, "per turn, compared with the drives'; 0 does not compare", low=0, high=100_000_000
    )
    speed_units: tuple[float, ...] = setting(
        (),
        "increments/s of one unit of each drive's speeds; 0 is what it reports (60A9)",
        low=0.0,
        high=1e9,
    )
    ramp_units: tuple[float, ...] = setting(
        (),
        "increments/s² of one unit of its ramps; 0 is its unit of speed, a second",
        low=0.0,
        high=1e9,
    )
    answer_s: float = setting(0.05, "timeout of an object transfer", low=0.01, high=2.0)
    homing_methods: tuple[int, ...] = setting(
        (), "object 6098 for each motor; empty leaves them as they are", low=-128, high=37
    )
    homing_speeds: tuple[int, int] = setting(
        (0, 0),
        "increments/s towards the switch and away; 0 leaves them as they are",
        low=0,
        high=10_000_000,
    )
    homing_s: float = setting(
        60.0, "longest homing of a drive that does not report its speeds", low=1.0, high=3600.0
    )

    def __post_init__(self) -> None:
        check_settings(self, "cia402")
        check_ids("cia402", self.ids, "a node number")
        if self.master_id in self.ids:
            raise ArmFileError(
                "cia402.master_id must be this program's own number, but "
                f"{self.master_id} is a drive's"
            )
        check_feeding(
            "cia402.heartbeat_timeout_ms",
            self.heartbeat_timeout_ms,
            "cia402.heartbeat_period_ms",
            self.heartbeat_period_ms,
        )
        for name in ("homing_methods", "speed_units", "ramp_units"):
            values = getattr(self, name)
            if values and len(values) != len(self.ids):
                raise ArmFileError(
                    f"cia402.{name} must have one for each of the {len(self.ids)} drives, or none, "
                    f"not {len(values)}"
                )

    @property
    def heartbeat_wait_s(self) -> float:
        """How long drives surely wait for the next heartbeat; half a period is the margin."""
        return (self.heartbeat_timeout_ms - self.heartbeat_period_ms / 2.0) / 1000.0

    @property
    def report_age_s(self) -> float:
        """How old the last report of a drive may be that surely still waits for a heartbeat.

        It may have heard the last one a period before that report.
        """
        return self.heartbeat_wait_s - self.heartbeat_period_ms / 1000.0

    @property
    def frame_ids(self) -> tuple[int, ...]:
        """The ids of received frames: those from the drives, and another master's heartbeat."""
        services = (Service.EMCY, Service.TPDO1, Service.SDO_RESPONSE, Service.HEARTBEAT)
        own = tuple(cob_id(service, node) for service in services for node in self.ids)
        return (*own, cob_id(Service.HEARTBEAT, self.master_id))


# What follows for an arm: the speeds of its drives and the period of their targets.

# As much data as the commands and the reports of a drive have.
LONGEST_PDO = bytes(7)
# The greatest speed that is commanded, in increments a second.
TOP_HZ = 10_000_000.0


def period_ms(settings: Cia402Settings, drives: int, bit_rate: int) -> int:
    """Return the period of SYNC: that of the arm file, or the shortest that the bus can carry."""
    bits = 2 * drives * frame_bits(Frame(1, LONGEST_PDO)) + frame_bits(Sync().frame)
    return max(settings.period_ms, math.ceil(1000.0 * bits / bit_rate / BUSY_LOAD))


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
        """Return the limits of an arm on a bus with this bit rate.

        Raises `ArmFileError` if drives would report too rarely to show that they heard a heartbeat.
        """
        cycle_ms = period_ms(settings, motors.count, bit_rate)
        missing_ms = cycle_ms - round(1000.0 * settings.report_age_s)
        if missing_ms > 0:
            raise ArmFileError(
                "cia402.heartbeat_timeout_ms must be at least "
                f"{settings.heartbeat_timeout_ms + missing_ms}: the drives report every {cycle_ms} "
                "ms, and their reports show whether they missed a heartbeat"
            )
        return cls(
            cycle_ms / 1000.0,
            motors.fastest_hz,
            motors.ranges,
            motors.fastest_hz / settings.ramp_s,
            motors.fastest_hz / settings.quick_stop_s,
        )

    def ramp_s(self, rate_hz: float) -> float:
        """Return how long a ramp to this rate takes, or from it."""
        return min(rate_hz, self.fastest_hz) / self.ramp_hz_s

    def quick_stop_s(self, rate_hz: float) -> float:
        """Return how long a quick stop from this rate takes."""
        return min(rate_hz, self.fastest_hz) / self.quick_hz_s

    def ramp_end_s(self, steps: float) -> float:
        """Return how long the last steps of a quick stop take."""
        return math.sqrt(2.0 * steps / self.quick_hz_s)

    def lasts_s(self, steps: float, rate_hz: float) -> float:
        """Return how long a burst takes from rest to rest."""
        return trapezoid(steps, min(rate_hz, TOP_HZ), self.ramp_hz_s).duration_s
