"""The worst cases of each dialect: the motion, what ends it and when, and what the wire does.

A row names a motion, the cause that ends it, the moments, and the behaviour of the wire from then
on. The worst moment must reach half of the announced bound, unless a reason of `REASONS` says why
the simulated device cannot.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import Enum
from types import MappingProxyType

from armdrive import Jog
from armdrive.config.arm import ArmConfig
from armdrive.config.sections import HomingSettings
from armdrive.connect.target import simulated_config
from armdrive.errors import ArmError
from armdrive.motion.reference import home_device
from armdrive.runtime.stop_bounds import StopBound
from armdrive.sim.device import Value
from kinematics import Joints, Motors
from tests.scenarios.actions import arm_of
from tests.scenarios.stage import Stage

OPENING_MM = 20.0

HOST_S = 0.03
"""How long this computer or an adapter may hold back a message; every bound allows for it."""
RESTS_S = 2.0
"""Every arm stands within this time, and at the latest this long after its bound."""
SUSPENDED_S = 4.0
LONGEST_S = 3.0
"""Every motion is under way within this time."""
WARM_UP_DEG = 6.0

# -- the motions --------------------------------------------------------------------------------

START_DEG = (0.0, 30.0, -14.0, -80.0, 0.0)
"""All joints turn upwards from here at full speed; the arm is straight after a second."""
PLANNED_S = 1.05
EVEN_STEPS: Mapping[str, tuple[int, ...]] = MappingProxyType(
    {"robko01": (1, -1, 1, -1, -1, 0), "armdroid": (1, -1, -1, -1, -1, 0)}
)
"""If motors are not coordinated, a burst is shorter the more their distances differ. Here all make
equal steps, in the directions that raise every part of the arm."""
EVEN_START_DEG = (0.0, 30.0, -8.0, -25.0, 0.0)
EVEN_COUNTS: Mapping[str, int] = MappingProxyType({"robko01": 104, "armdroid": 160})
"""These many steps are divided into equal bursts that each last nearly as long as is allowed."""


def start_of(dialect: str) -> Joints:
    """Return the posture in which the motions of a dialect begin."""
    return Joints.of(*(EVEN_START_DEG if dialect in EVEN_STEPS else START_DEG))


def full_speeds(config: ArmConfig) -> tuple[float, ...]:
    """Return the joint speeds, in rad/s, of the motion in which all joints are fastest."""
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
    UPWARDS = "the same without the base, which moves the tip at right angles to the other joints"
    JOG = "a held jog of all joints at full speed"
    SLOW_JOG = "a held jog of the base, as slowly as the board turns a motor"
    HOMING = "the controller's own homing of the base, from the other end of its range"


STRETCHED_DEG = (0.0, 0.0, 0.0, 0.0, 0.0)
HOMES: Mapping[str, Mapping[str, object]] = MappingProxyType(
    {"grbl": {"homing": True}, "mks": {}, "cia402": {"homing_methods": (18,) * 6}}
)
"""What the arm file says of a controller that homes by itself, by dialect."""


def stage_of(dialect: str, how: Begin, **options: Value) -> Stage:
    """Return an arm where a motion begins; before homing, the base is at its range's other end."""
    config, start = simulated_config(dialect), start_of(dialect)
    if how is Begin.HOMING:
        base = config.model.arm.limits[0]
        switch, start = (
            Joints.of(*STRETCHED_DEG).replace(base=each) for each in (base.high_rad, base.low_rad)
        )
        homing = HomingSettings(switch, OPENING_MM, groups=((1,),))
        config = replace(config, homing=homing, device=replace(config.device, **HOMES[dialect]))
    stage = Stage(config, options)
    stage.place_by_hand(start, OPENING_MM)
    stage.ready()
    return stage


def begin(stage: Stage, how: Begin, for_s: float, speed: float) -> None:
    """Begin a motion of the arm."""
    arm = arm_of(stage)
    speeds = full_speeds(arm.config)
    if how is Begin.UPWARDS:
        speeds = (0.0, *speeds[1:])
    if how in (Begin.PLANNED, Begin.UPWARDS):
        lasts_s = PLANNED_S
        if arm.config.connection.dialect in EVEN_STEPS:
            steps = EVEN_STEPS[arm.config.connection.dialect]
            turned, _ = arm.parts.core.transmission.to_joints(Motors(steps))
            lasts_s = EVEN_COUNTS[arm.config.connection.dialect] * abs(turned[0]) / abs(speeds[0])
        goal = {
            f"{name}_deg": math.degrees(here + speed * lasts_s)
            for name, here, speed in zip(arm.joints.names, arm.joints, speeds, strict=True)
            if speed
        }
        arm.move_j(wait=False, **goal)
        return
    if how is Begin.HOMING:
        assert arm.config.homing is not None
        arm.parts.runner.submit(home_device(arm.parts.context, arm.config.homing), alone=True)
        return
    if how is Begin.SLOW_JOG:
        axes = {"base": 1.0}
    else:
        limits = arm.config.model.joint_speeds_rad_s
        axes = {
            name: speed / limit
            for name, speed, limit in zip(arm.joints.names, speeds, limits, strict=True)
            if speed
        }
    arm.jogging.hold(Jog.joint(**axes), speed=speed, for_s=for_s)


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
"""The causes for which the bound of a silent host holds."""


def end(stage: Stage, cause: Cause, rests_s: float = RESTS_S) -> None:
    """End the motion, and wait until the arm stands."""
    arm = arm_of(stage)
    match cause:
        case Cause.STOP:
            arm.request_stop()
        case Cause.EMERGENCY:
            arm.request_stop(hard=True)
        case Cause.RELEASE:
            arm.jogging.release()
        case Cause.EXPIRY:
            pass  # the hold is not renewed
        case Cause.PAUSE:
            arm.pause()
        case Cause.PULLED:
            stage.request("unplug")
            abandon(stage, rests_s)
            return
        case Cause.KILLED:
            abandon(stage, rests_s)
            return
        case Cause.SUSPENDED:
            abandon(stage, SUSPENDED_S)
            stage.pace.suspend(SUSPENDED_S)
    try:
        arm.sleep(RESTS_S)
    except ArmError:
        assert cause is Cause.SUSPENDED  # the driver reports that the program was suspended


def abandon(stage: Stage, for_s: float) -> None:
    """Let time pass for the arm alone, while its program is dead or suspended."""
    stage.link.line.advance(stage.now_s + for_s)


# -- rows ---------------------------------------------------------------------------------------

Loses = Callable[[bytes], bool]


def nothing() -> Loses:
    """Lose nothing."""
    return lambda data: False


def first(*marks: bytes) -> Callable[[], Loses]:
    """Lose the first message that contains one of these marks."""

    def make() -> Loses:
        lost: list[bytes] = []

        def loses(data: bytes) -> bool:
            if lost or not any(mark in data for mark in marks):
                return False
            lost.append(data)
            return True

        return loses

    return make


first_message = first(b"")
"""Loses the first message, whatever it is; after the cause of a stop that is the stop."""


@dataclass(frozen=True, slots=True)
class Row:
    """One way to end a motion of a dialect, at its worst.

    The cause comes at each time of `after_s`, in a motion of its own: after the start of the
    motion, or after the message of burst number `burst`, for devices that get bursts. From then on
    the wire is `late_s` late, and loses the messages that `loses` picks. Before the cause, the wire
    loses all messages for `cut[0]` s, and then none for `cut[1]` s. `time` and `way` name the
    reasons in `REASONS` if less than half of the bound is reached.
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
"""Whether a message starts a burst, by dialect."""


@dataclass(frozen=True, slots=True)
class StopResult:
    """What the physical arm did after the cause struck, as a share of what was announced."""

    time_share: float
    way_share: float


def measure(row: Row, after_s: float) -> StopResult:
    """Begin a motion, end it, and return how the arm stopped."""
    stage = stage_of(row.dialect, row.begin, **row.options)
    arm = arm_of(stage)
    if row.burst:  # the driver first learns how fast the motors are
        for angle in (WARM_UP_DEG, 0.0):
            arm.move_j(base_deg=angle, shoulder_deg=START_DEG[1] + angle)
    bursts_s: list[float] = []
    is_burst = BURSTS.get(row.dialect, lambda data: False)

    def on_message(data: bytes) -> None:
        if is_burst(data):
            bursts_s.append(stage.now_s)

    stage.link.on_message = on_message
    expires = row.cause is Cause.EXPIRY
    began_s = stage.now_s
    begin(stage, row.begin, after_s if expires and not row.burst else 1.0, row.speed)
    if row.burst:
        while len(bursts_s) < row.burst and stage.now_s < began_s + LONGEST_S:
            arm.sleep(0.001)
        assert len(bursts_s) == row.burst, "the burst to be stopped never came"
        if expires:
            hold = arm.parts.core.hold
            assert hold is not None
            arm.jogging.hold(hold.jog, speed=hold.speed, for_s=max(after_s, 1e-6))
    lost_s, restored_s = row.cut
    if not row.burst or after_s > 0.0:
        arm.sleep(after_s - lost_s - restored_s)
    if lost_s:
        stage.link.loses = lambda data: True
        arm.sleep(lost_s)
        stage.link.loses = nothing()
        arm.sleep(restored_s)
    if row.late_s:
        stage.twin.faults.add("delay", row.late_s, side="host")
    stage.link.loses = row.loses()
    stage.look()
    world, marked_s, bound = stage.world, stage.now_s, arm.parts.core.stop_bound()
    world.mark, world.furthest_mm, world.moved_s = world.tip, 0.0, marked_s
    end(stage, row.cause, RESTS_S + bound.silent_time_s)
    return shares(bound, row.cause in SILENT, world.moved_s - marked_s, world.furthest_mm)


def shares(bound: StopBound, silent: bool, time_s: float, way_mm: float) -> StopResult:
    """Return a time and a distance as shares of the bound of a stop, or of a silent host."""
    if silent:
        return StopResult(time_s / bound.silent_time_s, way_mm / bound.silent_distance_mm)
    return StopResult(time_s / bound.time_s, way_mm / bound.distance_mm)


# -- reasons for less than half -----------------------------------------------------------------

HALF = 0.5


@dataclass(frozen=True, slots=True)
class Reason:
    """Why a simulated device reaches less than half of a bound, and the least share it reaches."""

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
            "A jog may change its speed at any moment, so its bound holds at every speed. A slow "
            "jog takes longest to stop, and a fast one goes furthest: each has a row of its own.",
        ),
        "slow is near": Reason(
            0.04,
            "As above: the row of the fast jog reaches the distance.",
        ),
        "dead stop": Reason(
            0.25,
            "The status has one bound for both stops, that of the gentler one. An emergency stop "
            "does not brake on the ramp.",
        ),
        "as if dead": Reason(
            0.1,
            "The status has one bound for a pause and for the death of the program. Paused drives "
            "brake at once, and need not miss a heartbeat for 0.25 s first.",
        ),
        "little to catch up": Reason(
            0.4,
            "Drives may catch up after lost orders, and the bound allows for that. A jog is held "
            "back as soon as no drive replies for 0.06 s, so a drive has little to catch up.",
        ),
        "homing ramp": Reason(
            0.35,
            "On which ramp a homing drive brakes is not known. The bound allows for the gentlest "
            "that it has; the simulated drive brakes thirteen times as hard.",
        ),
        "as declared": Reason(
            0.1,
            "This board does not tell how long it homes, so the bound is the longest homing that "
            "the arm file allows.",
        ),
    }
)

# -- the table ----------------------------------------------------------------------------------

_P, _U, _J, _S = Begin.PLANNED, Begin.UPWARDS, Begin.JOG, Begin.SLOW_JOG
_RUN_ON: Mapping[str, Value] = MappingProxyType({"hold_after_loss": "extrapolate"})
_328P: Mapping[str, Value] = MappingProxyType({"firmware": "grbl"})
_FLUIDNC: Mapping[str, Value] = MappingProxyType({"firmware": "fluidnc"})
_UNWATCHED: Mapping[str, Value] = MappingProxyType({"firmware": "1.0.6"})
_STOPS = (Cause.STOP, Cause.EMERGENCY)
_ENDS = (Cause.RELEASE, Cause.EXPIRY)
_DEATHS = (Cause.KILLED, Cause.SUSPENDED)
_LOST = (Cause.KILLED, Cause.PULLED)


def _burst_rows() -> tuple[Row, ...]:
    """Return the rows of devices that finish each burst, or whose stop is lost."""
    whole = (*_STOPS, Cause.PAUSE, *_DEATHS)
    lost = {"loses": first_message}
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
        *(Row("robko01", _J, cause, (0.0,), 2, way="half bursts") for cause in _ENDS),
        *(Row("armdroid", _P, cause, (0.0,), 2) for cause in whole),
        Row("armdroid", _P, Cause.PULLED, (0.02,), 2),
        *(
            Row("armdroid", _J, cause, (0.0,), 2, time="half bursts", way="half bursts")
            for cause in _ENDS
        ),
    )


def _grbl_rows() -> tuple[Row, ...]:
    """Return the rows of both 8-bit builds: their buffers go on, or a byte is lost."""
    held, fast = first(b"!"), (0.5, 0.7)
    cancelled = first(b"\x85")
    return (
        Row("grbl", _P, Cause.STOP, fast, loses=held),
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

    MKS drives have lost orders before, and catch up.
    """
    lost, late = {"loses": first_message}, {"cut": (0.1, 0.15)}
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
        Row("cia402", _P, Cause.PAUSE, (0.5,), late_s=0.0, time="as if dead", way="as if dead"),
        *(Row("cia402", _P, cause, (0.34,), options=_RUN_ON) for cause in _DEATHS),
        Row("cia402", _P, Cause.PULLED, (0.34,), options=_RUN_ON),
        *(Row("cia402", _J, cause, (0.603, 0.607), **on) for cause in _ENDS),
    )


def _homing_rows() -> tuple[Row, ...]:
    """Return the rows of controllers that home by themselves: they go on without a program."""
    return (
        *(Row("grbl", Begin.HOMING, cause, (0.1,)) for cause in _LOST),
        *(Row("cia402", Begin.HOMING, cause, (0.3,)) for cause in _LOST),
        *(
            Row("mks", Begin.HOMING, cause, (0.31,), time="homing ramp", way="homing ramp")
            for cause in _LOST
        ),
        Row("mks", Begin.HOMING, Cause.PULLED, (0.1,), options=_UNWATCHED),
        Row("grbl", Begin.HOMING, Cause.PULLED, (0.1,), options=_FLUIDNC, time="as declared"),
    )


ROWS = (*_burst_rows(), *_grbl_rows(), *_bus_rows(), *_homing_rows())
