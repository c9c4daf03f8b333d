"""Measurements on a bench: how long motions take, and how soon the arm stands after a stop."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from armdrive.arm import Arm
from armdrive.arm.connected import Handle
from armdrive.errors import ArmError
from armdrive.motion.execute import Moved
from armdrive.moves import Jog
from armdrive.status import State, Trust
from kinematics import LinePart
from tests.conformance.bench import Bench
from tests.conformance.motions import shifted
from tests.conformance.observation import Broken, check
from tests.conformance.rows_moving import check_arrived

from .steps import Watcher

SPEEDS = (1.0, 0.5, 0.3, 0.1)
SHORT_DEG, LONG_DEG = 3.0, 30.0
LINE_MM, BLEND_MM = 60.0, 15.0
LONGEST_S = 300.0

RATES_HZ = (25.0, 50.0, 100.0, 400.0)
TRIES = 3
STEADY_S = 1.0
"""How long a motion runs before it is stopped, so that every buffer is full."""
UNEVEN_S = 0.037
"""Each try is stopped this much later, to vary the state of the buffers."""
HOLD_S, RENEWALS = 0.8, 5
STANDS_S = 10.0


# -- durations ---------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Measured:
    """One motion at one speed; `wrong` says what failed.

    `physical_s` is the time from the first step to the last, 0 if the bench cannot see steps.
    """

    motion: str
    speed: float
    physical_s: float
    call_s: float
    underruns: int
    wrong: str = ""


def joint_move(angle_deg: float) -> Callable[[Arm, float], Handle[Moved]]:
    """Return a function that begins a motion of the first joint."""

    def begin(arm: Arm, speed: float) -> Handle[Moved]:
        first = arm.model.arm.joint_names[0]
        goal = {f"{first}_deg": arm.joints.deg[first] + angle_deg}
        return arm.move_j(wait=False, speed=speed, **goal)

    return begin


def line(arm: Arm, speed: float) -> Handle[Moved]:
    """Begin a straight sideways line."""
    return arm.move_l(shifted(arm.pose, y_mm=LINE_MM), wait=False, speed=speed)


def blended_path(arm: Arm, speed: float) -> Handle[Moved]:
    """Begin two lines with a blend between them."""
    corner = shifted(arm.pose, y_mm=LINE_MM)
    end = shifted(corner, z_mm=-LINE_MM)
    return arm.move_path([LinePart(corner, BLEND_MM), LinePart(end)], wait=False, speed=speed)


MOTIONS = {
    f"joint {SHORT_DEG:g} degrees": joint_move(SHORT_DEG),
    f"joint {LONG_DEG:g} degrees": joint_move(LONG_DEG),
    f"line {LINE_MM:g} mm": line,
    f"blended path {2 * LINE_MM:g} mm": blended_path,
}


def durations(bench: Bench, speeds: tuple[float, ...] = SPEEDS) -> Iterator[Measured]:
    """Measure every motion at every speed, each from the same posture."""
    arm = bench.ready()
    home = {f"{name}_deg": angle for name, angle in arm.joints.deg.items()}
    for name, begin in MOTIONS.items():
        for speed in speeds:
            yield _duration(bench, arm, name, begin, speed)
            arm = _back(bench, arm, home)


def _duration(
    bench: Bench, arm: Arm, name: str, begin: Callable[[Arm, float], Handle[Moved]], speed: float
) -> Measured:
    underruns, wrong, call_s = arm.status.underruns, "", 0.0
    watcher = Watcher(bench)
    try:
        handle = begin(arm, speed)
        motion = watcher.until(lambda: handle.done, LONGEST_S)
        call_s = handle.wait().duration_s
        check_arrived(bench, arm)
    except (ArmError, Broken) as error:
        motion = watcher.until(lambda: True, LONGEST_S)
        wrong = _words(error)
    physical_s = motion.physical_s if bench.sees_motion else 0.0
    return Measured(name, speed, physical_s, call_s, arm.status.underruns - underruns, wrong)


def _back(bench: Bench, arm: Arm, home: dict[str, float]) -> Arm:
    """Recover from the last motion if necessary, and return to the start posture."""
    if arm.status.state is State.ERROR_STOP:
        arm.reset()
    if arm.status.state is State.DISCONNECTED:
        arm = bench.connect()
    if arm.status.trust is not Trust.REFERENCED:
        bench.reference(arm)
    arm.move_j(**home)
    return arm


# -- stops -------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Stopped:
    """One stop: the announced bounds and the result.

    `rate_hz` is the rate that was asked for, and `actual_hz` the rate before the stop. `pulses`
    counts the steps of the quickest motor after it.
    """

    how: str
    rate_hz: float
    actual_hz: float
    announced_s: float
    took_s: float
    announced_mm: float
    way_mm: float
    pulses: int
    wrong: str = ""

    @property
    def within(self) -> bool:
        """Whether the arm stood within the announced bounds."""
        return self.took_s <= self.announced_s and self.way_mm <= self.announced_mm

    @property
    def kept(self) -> bool:
        """Whether the arm also knows its position."""
        return not self.wrong and self.within


def stops(bench: Bench, rates_hz: tuple[float, ...] = RATES_HZ) -> Iterator[Stopped]:
    """Stop a motion and release a jog at every rate that the arm's first joint reaches."""
    arm = bench.ready()
    home = {f"{name}_deg": angle for name, angle in arm.joints.deg.items()}
    for how in ("stop", "release"):
        for rate_hz in (each for each in rates_hz if each <= full_rate_hz(bench)):
            for number in range(TRIES if bench.real_time else 1):
                try:
                    yield _stopped(bench, arm, how, rate_hz, STEADY_S + number * UNEVEN_S)
                except (ArmError, Broken) as error:
                    bench.rest()
                    yield Stopped(how, rate_hz, 0.0, 0.0, 0.0, 0.0, 0.0, 0, _words(error))
                arm = _back(bench, arm, home)


def full_rate_hz(bench: Bench) -> float:
    """Return the step rate of the first joint's motor at full speed."""
    return abs(bench.transmission.matrix[0][0]) * bench.config.model.joint_speeds_rad_s[0]


def _stopped(bench: Bench, arm: Arm, how: str, rate_hz: float, after_s: float) -> Stopped:
    """Move the first joint at a rate, and end that after some time."""
    speed = rate_hz / full_rate_hz(bench)
    jog = Jog.joint(**{arm.model.arm.joint_names[0]: 1.0})

    def keep_moving() -> None:
        if how == "release":
            arm.hold(jog, speed=speed, for_s=HOLD_S)

    if how == "stop":
        joint_move(2.0 * LONG_DEG)(arm, speed)
    keep_moving()
    bench.wait_until_moving()
    before = bench.look()
    for _ in range(RENEWALS):
        keep_moving()
        bench.sleep(after_s / RENEWALS)
    seen = bench.look()
    actual_hz = seen.off_steps(before.motors) / (seen.time_s - before.time_s)
    status = arm.status
    told = f"in {status.state.value}, and was to be stopped in motion: {status.error}"
    check(status.state is State.MOVING, told)
    watcher = Watcher(bench)
    if how == "stop":
        arm.request_stop()
    else:
        arm.release()
    motion = watcher.until(lambda: arm.status.state is not State.MOVING, STANDS_S)
    return Stopped(
        how,
        rate_hz,
        actual_hz,
        status.stop_time_s,
        motion.last_s,
        status.stop_distance_mm,
        motion.way_mm,
        motion.pulses,
        _settled(bench, arm),
    )


def _settled(bench: Bench, arm: Arm) -> str:
    """Return what is wrong with a stopped arm; empty if it knows where it stands."""
    try:
        bench.wait_until(lambda: arm.status.state is State.STANDBY, STANDS_S)
        check_arrived(bench, arm)
    except Broken as error:
        return f"{error} ({arm.status.error})" if arm.status.error else str(error)
    return ""


def _words(error: Exception) -> str:
    code = getattr(error, "code", "")
    return f"{code} {error}".strip() if code else str(error)
