"""Behaviours of homing by switches, on an arm whose file says where homing ends.

Each switch is a little beyond the place where its motor begins.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from armdrive.arm import Arm
from armdrive.dialects.controller import OVERTRAVEL
from armdrive.errors import DeviceFault, LinkLost, Stopped
from armdrive.status import State, Status, Trust
from kinematics import Motors

from .behaviour import IN_SIMULATION, limit_switches, own_homing, row, rows_of
from .bench import Bench
from .motions import check_refused
from .observation import ON_THE_STEP, Observation, check
from .rows_moving import check_moves
from .rows_stopping import check_within_bound

SWITCHES: dict[str, Any] = {
    "needs": (own_homing, limit_switches),
    "transports": IN_SIMULATION,
}
TRAVEL, TURN, CIA402_TURN = 400, 16384, 10_000
"""Drives reach their switches in one second, at one turn a second."""


@dataclass(frozen=True, slots=True)
class Search:
    """How a controller seeks a switch, in motor steps.

    `lines` are for the arm file. `ahead` is the distance of each motor from its switch. `tolerance`
    is how far a motor may be seen beyond the end of its search for a switch that never closes: the
    end of its range, or `most`.
    """

    lines: str
    ahead: int
    tolerance: int
    most: float = math.inf


SEARCHES: Mapping[str, Search] = MappingProxyType(
    {
        # GRBL seeks one and a half times the travel, in steps, and backs off by two steps
        "grbl": Search(f"homing = true\ntravel = {[TRAVEL] * 6}", 80, 4, 1.5 * TRAVEL),
        "mks": Search("", TURN, TURN),
        # off a switch half as fast as towards it; a switch that sticks is left for the whole range
        "cia402": Search(
            f"homing_methods = {[18] * 6}\nhoming_speeds = {[CIA402_TURN, CIA402_TURN // 2]}",
            CIA402_TURN,
            CIA402_TURN,
        ),
    }
)
"""The search of each dialect, which is also the name of its section in the arm file."""
ORDER = ((3,), (2,), (1,), (4, 5))
STUCK = 2
STUCK_LIMITS = "shoulder = [45.0, 95.0]"
"""The limits of the joint whose switch is stuck: a search of its whole range is short."""
STOPPED_AFTER_S = 0.25
RESTS_S = 5.0


def arm_with_switches(
    bench: Bench, order: tuple[tuple[int, ...], ...] = ORDER
) -> tuple[Arm, Motors]:
    """Return an arm with switches, and where its motors stand after homing."""
    start = bench.look().motors
    homes = [motor - 1 for group in order for motor in group]
    search = SEARCHES[bench.row.name]
    goal = Motors(at + search.ahead * (index in homes) for index, at in enumerate(start))
    joints, opening_mm = bench.posture(goal)
    angles = "\n".join(f"{name} = {angle!r}" for name, angle in joints.deg.items())
    bench.use_arm_file(
        f"[{bench.row.name}]\n{search.lines}\n"
        f"[limits_deg]\n{STUCK_LIMITS}\n"
        f"[homing]\ngroups = {[list(group) for group in order]}\nopening_mm = {opening_mm!r}\n"
        f"[homing.joints_deg]\n{angles}"
    )
    arm = bench.connect()
    if arm.status.state is State.DISABLED:
        arm.enable()
    return arm, goal


def check_homing(bench: Bench, arm: Arm, goal: Motors) -> None:
    """Home, and check that the arm stands where its file says, and moves."""
    arm.home()
    status = arm.status
    check(status.trust is Trust.REFERENCED, f"homed, and {status.trust}: {status.trust_reason}")
    check(status.state is State.STANDBY, f"homed, and in {status.state}")
    off = bench.look().off_steps(goal)
    check(off <= ON_THE_STEP, f"homed, and {off} steps from where the arm file says")
    bench.check_trust(arm)
    check_moves(bench, arm)


@row("homing seeks the switches in the arm file's order", "homing by switches", **SWITCHES)
def homing_seeks_the_switches_in_order(bench: Bench) -> None:
    start = bench.look().motors
    arm, goal = arm_with_switches(bench)
    reports: list[tuple[tuple[str, ...], Observation]] = []
    check(bench.look().motors == start, "connecting moved an arm that homes")
    arm.home(report=lambda group: reports.append((group, bench.look())))
    names, expected = [group for group, _ in reports], arm.reference.homing_groups
    check(
        names == list(expected),
        f"it homed {names}, and was to home {expected}",
    )
    for count, (_, seen) in enumerate(reports, 1):
        done = [motor - 1 for group in ORDER[:count] for motor in group]
        for index, here in enumerate(seen.motors):
            wanted = (goal if index in done else start)[index]
            check(
                abs(here - wanted) <= ON_THE_STEP, f"motor {index + 1} is at {here}, not {wanted}"
            )
    check_homing(bench, arm, goal)


def _make_homing_fail(bench: Bench, fault: str) -> tuple[Arm, Motors, Observation, Observation]:
    """Make homing fail at a switch; return the arm, its goal, and how it stood before and after."""
    arm, goal = arm_with_switches(bench)
    start = bench.look()
    bench.fault(f"switch {STUCK} {fault}")
    error = check_refused(arm.home, DeviceFault, f"homing with a switch that is stuck {fault}")
    check("homing failed" in str(error), f"the error does not say what failed: {error}")
    status, after = arm.status, bench.check_stands(0.5, "homing has failed")
    check(status.state is State.ERROR_STOP, f"homing failed, and it is in {status.state}")
    check(status.trust is not Trust.REFERENCED, "homing failed, and the position is referenced")
    last = ORDER[-1][0] - 1
    check(after.motors[last] == start.motors[last], "homing had failed, and the next motor moved")
    return arm, goal, start, after


def _check_recovery(bench: Bench, arm: Arm, goal: Motors, start: Observation) -> None:
    """End the fault, move back a motor that ran to the end of its range, and home.

    A drive that ran into a stop has switched its motor off.
    """
    before = bench.look()
    bench.heal()
    arm.reset()
    bench.sleep(0.5)
    check(bench.look().motors == before.motors, "the reset moved the arm")
    bench.switch_on(arm)
    back = start.motors - before.motors
    if back.largest > SEARCHES[bench.row.name].ahead:
        arm.move_motors(*back)
    check_homing(bench, arm, goal)


@row("a switch that sticks closed ends homing", "homing by switches", **SWITCHES)
def a_switch_that_sticks_ends_homing(bench: Bench) -> None:
    arm, goal, start, _ = _make_homing_fail(bench, "closed")
    _check_recovery(bench, arm, goal, start)


@row("a switch that never closes ends homing", "homing by switches", **SWITCHES)
def a_switch_that_never_closes_ends_homing(bench: Bench) -> None:
    arm, _, start, after = _make_homing_fail(bench, "open")
    made = abs(after.motors[STUCK - 1] - start.motors[STUCK - 1])
    search = SEARCHES[bench.row.name]
    range_steps = OVERTRAVEL * arm.config.motor_ranges[STUCK - 1]
    most = min(search.most, range_steps) + search.tolerance
    check(made <= most, f"it sought a switch for {made} steps, not {most:.0f}")
    bench.heal()
    arm.reset()
    bench.check_stands(0.5, "reset")


@row("a stop ends homing, and nothing is referenced", "homing by switches", **SWITCHES)
def a_stop_ends_homing(bench: Bench) -> None:
    """A stop comes from outside, and the arm is observed when it should have come to rest."""
    arm, goal = arm_with_switches(bench)
    seen: list[Observation] = []

    def stop() -> None:
        seen.append(bench.look())
        bench.call_later(arm.status.stop_time_s + bench.noise_s, lambda: seen.append(bench.look()))
        arm.request_stop()

    start = bench.look()
    bench.call_later(STOPPED_AFTER_S, stop)
    check_refused(arm.home, Stopped, "homing that was stopped")
    bench.sleep(arm.status.stop_time_s + 2.0 * bench.noise_s)
    check(seen[0].motors not in (start.motors, goal), "it was not stopped on its way")
    off = bench.check_stands(0.5, "homing was stopped").off_steps(seen[1].motors)
    check(off <= ON_THE_STEP, f"homing was stopped, and moved {off} steps after its bound")
    status = arm.status
    check(status.state is State.STANDBY, f"homing was stopped, and it is in {status.state}")
    check(status.trust is not Trust.REFERENCED, "homing was stopped, and it is referenced")
    check_homing(bench, arm, goal)


@row("a lost wire while homing keeps its bound", "homing by switches", **SWITCHES)
def a_lost_wire_while_homing_keeps_its_bound(bench: Bench) -> None:
    """The driver is gone as if its program had died: the controller decides how far it goes on."""
    arm, goal = arm_with_switches(bench)
    at_rest_s = arm.status.silent_time_s
    seen: list[tuple[Status, Observation]] = []

    def pull() -> None:
        now = bench.look()
        if now.motors == start.motors:  # a real board on a busy computer begins late
            bench.call_later(STOPPED_AFTER_S, pull)
            return
        seen.append((arm.status, now))
        bench.fault("unplug")

    start = bench.look()
    bench.call_later(STOPPED_AFTER_S, pull)
    check_refused(arm.home, LinkLost, "homing whose wire was lost")
    (status, before), lost = seen[0], arm.status
    check(before.motors not in (start.motors, goal), "the wire was not lost on its way")
    rest = bench.rest(before, status.silent_time_s + RESTS_S)
    check_within_bound(bench, status, rest, "unplugged while homing", silent=True)
    for announced in ("silent_time_s", "silent_distance_mm"):
        check(
            getattr(lost, announced) >= getattr(status, announced),
            f"less {announced} is announced once the wire is lost",
        )
    bench.heal()
    arm.reconnect()
    check(arm.status.trust is not Trust.REFERENCED, "its wire was lost in homing: referenced")
    arm.reset()
    bench.switch_on(arm)
    found = arm.status.silent_time_s
    check(found == at_rest_s, f"found again, it would go on for {found} s, not {at_rest_s}")
    check_homing(bench, arm, goal)


ROWS = rows_of(globals())
