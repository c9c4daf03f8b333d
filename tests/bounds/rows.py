"""The worst of each dialect: how it moves, what its wire does, and when the motion is ended.

A row says which motion is ended by what, at which moments, and what the wire does from then on. Of
all its moments, the worst must reach half of what was announced, unless a reason of `REASONS` says
why the simulated device cannot.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from types import MappingProxyType

from armdrive import Jog
from armdrive.config.arm import ArmConfig
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError
from armdrive.sim.device import Value
from armdrive.sim.faults.request import parse_words
from kinematics import Joints, Motors

from .stand import Overrun, Stand

HOST_S = 0.03
"""What every bound allows for a message that this computer or an adapter holds back."""
RESTS_S = 2.0
"""By then every arm stands; no bound that is measured here is longer."""
ASLEEP_S = 4.0
LONGEST_S = 3.0
"""Every motion is under way by then."""
WARM_UP_DEG = 6.0

# -- the motions --------------------------------------------------------------------------------

START_DEG = (0.0, 30.0, -14.0, -80.0, 0.0)
"""From here all joints turn upwards at full speed, and the arm is straight a second later."""
PLANNED_S = 1.05
EVEN_STEPS: Mapping[str, tuple[int, ...]] = MappingProxyType(
    {"robko01": (1, -1, 1, -1, -1, 0), "armdroid": (1, -1, -1, -1, -1, 0)}
)
"""Where motors are not coordinated, a burst is shorter the more their ways differ: here all make
the same steps, in the directions that raise every part of the arm."""
EVEN_START_DEG = (0.0, 30.0, -8.0, -25.0, 0.0)
EVEN_COUNTS: Mapping[str, int] = MappingProxyType({"robko01": 104, "armdroid": 160})
"""So many steps are cut into equal bursts that each last nearly as long as they may."""


def start_of(dialect: str) -> Joints:
    """Return where the motions of a dialect begin."""
    return Joints.of(*(EVEN_START_DEG if dialect in EVEN_STEPS else START_DEG))


def full_speeds(config: ArmConfig) -> tuple[float, ...]:
    """Return the joints' speeds, in rad/s, of the motion in which all of them are fastest."""
    limits, dialect = config.model.joint_speeds_rad_s, config.connection.dialect
    if dialect not in EVEN_STEPS:
        return (*limits[:-1], 0.0)
    transmission = config.model.transmission
    assert transmission is not None
    turned, _ = transmission.to_joints(Motors(EVEN_STEPS[dialect]))
    share = min(limit / abs(turn) for limit, turn in zip(limits, turned, strict=True) if turn)
    return tuple(share * turn for turn in turned)


class Begin(Enum):
    """How a motion begins."""

    PLANNED = "a planned motion of all joints at full speed"
    UPWARDS = "the same without the base, whose way is at right angles to that of the others"
    JOG = "a held jog of all joints at full speed"
    SLOW_JOG = "a held jog of the base, as slow as the board turns a motor"


def begin(stand: Stand, how: Begin, for_s: float, speed: float) -> None:
    """Have the arm begin to move."""
    arm = stand.arm
    speeds = full_speeds(arm.config)
    if how is Begin.UPWARDS:
        speeds = (0.0, *speeds[1:])
    if how in (Begin.PLANNED, Begin.UPWARDS):
        lasts_s = PLANNED_S
        if arm.config.connection.dialect in EVEN_STEPS:
            steps = EVEN_STEPS[arm.config.connection.dialect]
            turned, _ = arm.core.transmission.to_joints(Motors(steps))
            lasts_s = EVEN_COUNTS[arm.config.connection.dialect] * abs(turned[0]) / abs(speeds[0])
        goal = {
            f"{name}_deg": math.degrees(here + speed * lasts_s)
            for name, here, speed in zip(arm.joints.names, arm.joints, speeds, strict=True)
            if speed
        }
        arm.move_j(wait=False, **goal)
        return
    limits = arm.config.model.joint_speeds_rad_s
    axes = {
        name: speed / limit
        for name, speed, limit in zip(arm.joints.names, speeds, limits, strict=True)
        if speed
    }
    if how is Begin.SLOW_JOG:
        arm.hold(Jog.joint(base=1.0), speed=speed, for_s=for_s)
    else:
        arm.hold(Jog.joint(**axes), speed=speed, for_s=for_s)


# -- what ends them -----------------------------------------------------------------------------


class Cause(Enum):
    """What ends a motion."""

    STOP = "stop"
    EMERGENCY = "emergency stop"
    RELEASE = "release of a held jog"
    EXPIRY = "expiry of a held jog"
    PAUSE = "pause"
    KILLED = "killed host"
    PULLED = "pulled cable"
    SUSPENDED = "suspended host"


SILENT = (Cause.PAUSE, Cause.KILLED, Cause.PULLED, Cause.SUSPENDED)
"""These are held to the bound of a host that says nothing any more."""


def end(stand: Stand, cause: Cause) -> None:
    """End the motion, and let time pass until the arm stands."""
    arm = stand.arm
    match cause:
        case Cause.STOP:
            arm.request_stop()
        case Cause.EMERGENCY:
            arm.request_stop(hard=True)
        case Cause.RELEASE:
            arm.release()
        case Cause.EXPIRY:
            pass  # nobody renews it
        case Cause.PAUSE:
            arm.pause()
        case Cause.PULLED:
            arm.twin.faults.ask(parse_words(["unplug"]))
            stand.abandon(RESTS_S)
            return
        case Cause.KILLED:
            stand.abandon(RESTS_S)
            return
        case Cause.SUSPENDED:
            stand.abandon(ASLEEP_S)
            arm.pace.clock.now_s += ASLEEP_S
            arm.engine.suspended(ASLEEP_S)
    try:
        arm.sleep(RESTS_S)
    except ArmError:
        assert cause is Cause.SUSPENDED  # a program that slept is told so


# -- rows ---------------------------------------------------------------------------------------

Loses = Callable[[bytes], bool]


def nothing() -> Loses:
    """Lose nothing."""
    return lambda data: False


def first(*marks: bytes) -> Callable[[], Loses]:
    """Lose the first message that has one of these marks in it."""

    def make() -> Loses:
        lost: list[bytes] = []

        def loses(data: bytes) -> bool:
            if lost or not any(mark in data for mark in marks):
                return False
            lost.append(data)
            return True

        return loses

    return make


def everything_first() -> Loses:
    """Lose the first message whatever it is: where only stops are said, that is the stop."""
    lost: list[bytes] = []

    def loses(data: bytes) -> bool:
        lost.append(data)
        return len(lost) == 1

    return loses


@dataclass(frozen=True, slots=True)
class Row:
    """One way to end a motion of a dialect, at its worst.

    The motion is ended `after_s` behind its beginning, each time anew; or, of a device that is sent
    bursts, `after_s` behind the message of the burst with number `burst`. From then on the wire is
    `late_s` late, and loses what `loses` picks. Before that, everything is lost for `cut[0]`, and
    nothing for the last `cut[1]` of it. `time` and `way` are names of `REASONS` where less
    than half is reached.
    """

    dialect: str
    begin: Begin
    cause: Cause
    after_s: tuple[float, ...]
    burst: int = 0
    speed: float = 1.0
    late_s: float = HOST_S
    cut: tuple[float, float] = (0.0, 0.0)
    loses: Callable[[], Loses] = nothing
    options: Mapping[str, Value] = field(default_factory=dict)
    time: str = ""
    way: str = ""

    def __str__(self) -> str:
        return f"{self.dialect}, {self.cause.value}, {self.begin.name.lower()}"


MOVE_BYTES = 30
BURSTS: Mapping[str, Callable[[bytes], bool]] = MappingProxyType(
    {
        "teachmover": lambda data: data.startswith(b"@STEP"),
        "robko01": lambda data: len(data) == MOVE_BYTES and any(data[6:-2:4]),
        "armdroid": lambda data: data == b"D",
    }
)
"""How the message is known that sets a burst going."""


def measure(row: Row, after_s: float) -> Overrun:
    """Move, end it, and return what became of it."""
    config = simulated_config(row.dialect)
    stand = Stand(config, start_of(row.dialect), **row.options)
    arm = stand.arm
    if row.burst:  # what the arm's motors are like is learnt first
        for angle in (WARM_UP_DEG, 0.0):
            arm.move_j(base_deg=angle, shoulder_deg=START_DEG[1] + angle)
    seen: list[float] = []
    is_burst = BURSTS.get(row.dialect, lambda data: False)

    def sees(data: bytes) -> None:
        if is_burst(data):
            seen.append(stand.now_s)

    stand.link.sees = sees
    expires = row.cause is Cause.EXPIRY
    began_s = stand.now_s
    begin(stand, row.begin, after_s if expires and not row.burst else 1.0, row.speed)
    if row.burst:
        while len(seen) < row.burst and stand.now_s < began_s + LONGEST_S:
            arm.sleep(0.001)
        assert len(seen) == row.burst, "the burst that should be stopped never came"
        if expires:
            hold = arm.core.hold
            assert hold is not None
            arm.hold(hold.jog, speed=hold.speed, for_s=max(after_s, 1e-6))
    lost_s, heard_s = row.cut
    if not row.burst or after_s > 0.0:
        arm.sleep(after_s - lost_s - heard_s)
    if lost_s:
        stand.link.loses = lambda data: True
        arm.sleep(lost_s)
        stand.link.loses = nothing()
        arm.sleep(heard_s)
    stand.link.late_s, stand.link.loses = row.late_s, row.loses()
    bound = stand.mark()
    end(stand, row.cause)
    found = stand.overrun(bound)
    return found.silent if row.cause in SILENT else found


# -- what cannot reach half ---------------------------------------------------------------------

HALF = 0.5


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a simulated device reaches less than half of a bound, and what it reaches at least."""

    least: float
    why: str


REASONS: Mapping[str, Reason] = MappingProxyType(
    {
        "half bursts": Reason(
            0.3,
            "A leg of a held jog is as long as a burst may be. By whole speed settings it takes a "
            "little longer, so that it is cut into two bursts of half the length. Increments and "
            "planned motions fill their bursts.",
        ),
        "any speed": Reason(
            0.25,
            "A jog may become another one at any moment, so its bound holds at every speed. A slow "
            "jog is stopped last, and a fast one goes furthest: each has a row of its own.",
        ),
        "slow is near": Reason(
            0.04,
            "As above: the row of the fast jog reaches the distance.",
        ),
        "dead stop": Reason(
            0.25,
            "The status has one bound for both stops, that of the gentler one: motors that are "
            "stopped dead do not brake on their ramp.",
        ),
        "as if dead": Reason(
            0.25,
            "The status has one bound for a pause and for the death of the program. Paused drives "
            "get no more targets, and need not miss a heartbeat for 0.25 s first.",
        ),
        "little to catch up": Reason(
            0.4,
            "Drives may catch up after lost orders, and the bound allows for that. A jog is held "
            "back as soon as no drive replies for 0.06 s, so a drive has little to catch up.",
        ),
    }
)

# -- the table ----------------------------------------------------------------------------------

_P, _U, _J, _S = Begin.PLANNED, Begin.UPWARDS, Begin.JOG, Begin.SLOW_JOG
_RUN_ON: Mapping[str, Value] = MappingProxyType({"hold_after_loss": "extrapolate"})
_328P: Mapping[str, Value] = MappingProxyType({"firmware": "grbl"})
_STOPS = (Cause.STOP, Cause.EMERGENCY)
_ENDS = (Cause.RELEASE, Cause.EXPIRY)
_DEATHS = (Cause.KILLED, Cause.SUSPENDED)


def _burst_rows() -> tuple[Row, ...]:
    """Return the rows of devices that drive each burst to its end, or whose stop is lost."""
    whole = (*_STOPS, Cause.PAUSE, *_DEATHS)
    lost = {"loses": everything_first}
    return (
        *(Row("teachmover", _P, cause, (0.0,), 2) for cause in whole),
        Row("teachmover", _P, Cause.PULLED, (0.05,), 2),
        *(
            Row("teachmover", _J, cause, (0.0,), 3, time="half bursts", way="half bursts")
            for cause in _ENDS
        ),
        *(Row("robko01", _P, cause, (0.0,), 2, **lost) for cause in whole[:3]),
        *(Row("robko01", _P, cause, (0.0,), 2) for cause in _DEATHS),
        Row("robko01", _P, Cause.PULLED, (0.008,), 2),
        *(Row("robko01", _J, cause, (0.0,), 2) for cause in _ENDS),
        *(Row("armdroid", _P, cause, (0.0,), 2) for cause in whole),
        Row("armdroid", _P, Cause.PULLED, (0.02,), 2),
        *(
            Row("armdroid", _J, cause, (0.0,), 2, time="half bursts", way="half bursts")
            for cause in _ENDS
        ),
    )


def _grbl_rows() -> tuple[Row, ...]:
    """Return the rows of both 8-bit builds: what their buffers hold, and a byte that is lost."""
    held, fast = first(b"!"), (0.5, 0.7)
    cancelled = first(b"\x85")
    return (
        Row("grbl", _P, Cause.STOP, fast, loses=held),
        Row("grbl", _P, Cause.STOP, fast, loses=held, options=_328P),
        Row("grbl", _P, Cause.EMERGENCY, fast, loses=first(b"\x18"), way="dead stop"),
        *(Row("grbl", _P, cause, (0.05, 0.5)) for cause in (Cause.PAUSE, *_DEATHS)),
        Row("grbl", _P, Cause.PULLED, (0.05, 0.5)),
        Row("grbl", _P, Cause.KILLED, (0.05, 0.5), options=_328P),
        *(
            Row("grbl", _J, cause, (0.5, 0.6), loses=cancelled, time="any speed", way="any speed")
            for cause in _ENDS
        ),
        *(
            Row("grbl", _S, cause, (0.6,), speed=0.12, loses=cancelled, way="slow is near")
            for cause in _ENDS
        ),
    )


def _bus_rows() -> tuple[Row, ...]:
    """Return the rows of drives on a bus, whose first stop is lost.

    MKS drives have lost the orders that would have made them faster, and catch up.
    """
    lost, late = {"loses": everything_first}, {"cut": (0.1, 0.15)}
    on = {"options": _RUN_ON}
    return (
        Row("mks", _U, Cause.STOP, (0.45,), **late, **lost),
        Row("mks", _P, Cause.EMERGENCY, (0.6,), **lost, time="dead stop", way="dead stop"),
        *(Row("mks", _U, each, (0.3,)) for each in (Cause.PAUSE, *_DEATHS)),
        Row("mks", _U, Cause.PULLED, (0.31, 0.33), late_s=0.0),
        *(
            Row("mks", _J, cause, (0.45,), cut=(0.05, 0.1), **lost, way="little to catch up")
            for cause in _ENDS
        ),
        *(Row("cia402", _P, cause, (0.603, 0.607), **on) for cause in _STOPS),
        Row("cia402", _P, Cause.PAUSE, (0.5,), late_s=0.0, way="as if dead"),
        *(Row("cia402", _P, cause, (0.34,), options=_RUN_ON) for cause in _DEATHS),
        Row("cia402", _P, Cause.PULLED, (0.34,), options=_RUN_ON),
        *(Row("cia402", _J, cause, (0.603, 0.607), **on) for cause in _ENDS),
    )


ROWS = (*_burst_rows(), *_grbl_rows(), *_bus_rows())
