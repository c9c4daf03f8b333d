"""The motors of an arm on a CAN bus, one drive each; what their settings and absence share."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from armdrive.config.arm import ArmConfig
from armdrive.errors import ArmFileError, Refused
from armdrive.tasks import (
    ClearFault,
    DropCurrent,
    FixSetting,
    HomeDevice,
    MoveAlong,
    MoveBy,
    ReadPosition,
    ReadSettings,
    RequestRejected,
    SwitchOn,
    Timeout,
)
from armdrive.transports.address import is_can
from kinematics.text import counted

# The requests that drives on a bus carry out.
BUS_REQUESTS = (
    MoveBy,
    MoveAlong,
    HomeDevice,
    ReadPosition,
    ReadSettings,
    FixSetting,
    SwitchOn,
    DropCurrent,
    ClearFault,
)
# What to check if no drive on the bus answers.
ALL_SILENT = (
    "Check that the drives have power, that the bus cable is plugged in and has a resistor of 120 "
    "ohm at each of its two ends, and that ids and bit rate match the arm file"
)
# That drives did not answer for a while, and answer again, and what to check.
NONE_HEARD = "no drive answered for a while. Check the bus's wiring, its load and its adapter"


def off_target_words(drive: object, count: int, target: int, unit: str) -> str:
    """Return that a drive is not at its target, and the likely causes."""
    return (
        f"{drive} is at {count}, not at {target} {unit}: it is blocked, overloaded, was turned by "
        "force, or was reset"
    )


# Timeout of an answer: a drive needs some milliseconds, a busy computer more.
ANSWER_S = 0.12

# How much longer the last reply is waited for: a frame may wait that long in the computer or the
# adapter (see `transports/can_link.py`).
LAST_TRY_S = 0.25

# A second drive with the same id answers within this time of the first.
LINGER_S = 0.03

# An answer that is later than this will never come, even on a busy computer.
LAST_REPLY_S = 0.2

# This many more replies than questions come from two drives. One more may be a repeated frame.
SURPLUS_LIMIT = 2


def absent_words(drives: Sequence[object], number: str) -> str:
    """Return which drives do not answer and what to check; `number` is what identifies them."""
    named, verb = ", ".join(map(str, drives)), "does" if len(drives) == 1 else "do"
    return (
        f"{named} {verb} not answer, while others on the bus do: check the power supply, the CAN "
        f"plug, and that {number} and bit rate match the arm file (`armdrive doctor --can`)"
    )


def unstopped_words(drive: object) -> str:
    """Return that a drive still turns although it was stopped."""
    return f"{drive} did not come to rest after a stop"


def shared_words(ids: Iterable[int], number: str, remedy: str) -> str:
    """Return which ids more than one drive answers to, and what to do; empty if there are none."""
    named = ", ".join(map(str, sorted(ids)))
    return f"more than one drive answers to the {number} {named}: {remedy}" if named else ""


def absence(
    missing: Sequence[object],
    drives: Sequence[object],
    number: str,
    silence: Timeout,
) -> Timeout | RequestRejected:
    """Return the reply that names missing drives; `silence` if all of them are missing.

    It is for a request that has moved nothing yet; else see `midway`.
    """
    if len(missing) == len(drives):
        return silence
    return RequestRejected(absent_words(missing, number), moved=False)


def midway(reply: Timeout | RequestRejected) -> Timeout | RequestRejected:
    """Return such a reply about drives that fell silent in the middle of a motion."""
    return replace(reply, moved=True, silent=True) if isinstance(reply, RequestRejected) else reply


# A drive's watchdog must outlast this many messages that feed it: one may be lost.
FEEDS_OUTLASTED = 2


def check_ids(section: str, ids: Sequence[int], number: str) -> None:
    """Raise `ArmFileError` unless each drive has an id of its own."""
    if not ids or len(set(ids)) != len(ids):
        raise ArmFileError(
            f"{section}.ids must give each motor {number} of its own, not {list(ids)}"
        )


def check_feeding(watchdog: str, most: float, feed: str, period: float) -> None:
    """Raise `ArmFileError` unless the drives' watchdog outlasts the messages that feed it.

    `watchdog` and `feed` are the names of the two settings.
    """
    if most < FEEDS_OUTLASTED * period - 1e-9:
        raise ArmFileError(
            f"{watchdog} must be at least {FEEDS_OUTLASTED} times {feed}, which feeds it: with "
            f"{most:g} and {period:g} the drives would stop in mid-motion"
        )


@dataclass(frozen=True, slots=True)
class BusMotors:
    """The motors of an arm, in order, with their `ranges` in steps between their joints' limits.

    `fastest_hz` is the greatest speed of the fastest, in steps a second.
    """

    names: tuple[str, ...]
    fastest_hz: float
    ranges: tuple[float, ...]

    @property
    def count(self) -> int:
        """Their number."""
        return len(self.names)


def bus_motors(config: ArmConfig, section: str, ids: Sequence[int]) -> BusMotors:
    """Return the motors of an arm whose arm file names one drive for each.

    Raises `Refused` if its port is no CAN adapter or no drive can move its gripper, and
    `ArmFileError` if drives or the transmission are missing.
    """
    port, transmission = config.connection.port, config.model.transmission
    if port and not is_can(port):
        raise Refused(
            f"{port} is not a CAN adapter, but these drives are on a CAN bus: write the port as "
            "can:slcan:/dev/ttyACM0?bitrate=500000, or see `armdrive ports`"
        )
    if config.gripper.commanded:
        raise Refused(
            f'gripper.kind is "{config.gripper.kind}", but these drives have no such output: use '
            '"stepper" if a drive moves the fingers, or "none"'
        )
    if transmission is None:
        raise ArmFileError("the arm's motor steps are unknown: give steps_per_turn")
    names = tuple(motor.name for motor in transmission.motors)
    if len(ids) < len(names):
        raise ArmFileError(
            f"{section}.ids names {counted(len(ids), 'drive')}, but the arm has "
            f"{counted(len(names), 'motor')}"
        )
    speeds = (*config.model.joint_speeds_rad_s, config.model.gripper_speed_mm_s)
    return BusMotors(names, max(transmission.most_steps(speeds)), config.motor_ranges)
