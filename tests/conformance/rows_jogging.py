"""Behaviours of jogging: increments, held jogs, and how each of them ends."""

import math

from armdrive.arm import Arm
from armdrive.moves import Jog
from armdrive.status import Trust

from .behaviour import ALSO_UDP, cartesian, finger_motor, row, rows_of
from .bench import Bench
from .motions import jog_first_joint, sweeping_jog
from .observation import check
from .rows_moving import check_arrived
from .rows_stopping import check_settled, check_within_bound

HOLD_S = 0.4


def hold_until_under_way(
    bench: Bench, arm: Arm, jog: Jog, speed: float, for_s: float = HOLD_S
) -> None:
    """Hold a jog, and renew it as a keyboard does until the physical arm moves.

    The expiry counts from the call; on a slow wire most of it may pass before the first burst.
    """
    bench.wait_until_moving(lambda: arm.jogging.hold(jog, speed=speed, for_s=for_s))


@row("a released jog stops within its bound", "jog")
def a_released_jog_stops_within_its_bound(bench: Bench) -> None:
    arm = bench.ready()
    for after_s in bench.stops_after_s[:2]:
        hold_until_under_way(bench, arm, sweeping_jog(arm), 1.0, for_s=1.0)
        bench.sleep(after_s)
        status, seen = arm.status, bench.look()
        arm.jogging.release()
        check_within_bound(bench, status, bench.rest(seen), "released")
        check_settled(bench, arm)
        arm.move_j(**{f"{name}_deg": 0.0 for name in arm.model.arm.joint_names[:1]})


@row("increments of a jog add up, and go straight where the arm is known", "jog", watched=True)
def increments_add_up(bench: Bench) -> None:
    arm = bench.ready()
    first = arm.model.arm.joint_names[0]
    before_deg = arm.joints.deg[first]
    for _ in range(3):
        jog_first_joint(arm)
    made_deg = bench.posture(bench.look().motors)[0].deg[first] - before_deg
    check(abs(made_deg - 3.0) <= 0.3, f"three jogs of 1 degree made {made_deg:.2f}")
    check_arrived(bench, arm)
    if cartesian(bench):
        return
    start = bench.look().tip
    arm.jog_l(z_mm=-12.0)
    check_arrived(bench, arm)
    end = bench.look()
    off = math.dist(end.tip, (start[0], start[1], start[2] - 12.0))
    allowed = 2.0 * bench.step_mm(end.motors)
    check(off <= allowed, f"12 mm down, and {off:.2f} mm off")


def _expires(bench: Bench, arm: Arm, jog: Jog) -> None:
    hold_until_under_way(bench, arm, jog, 0.5)
    status = arm.status
    rest = bench.rest()
    time_s = HOLD_S + status.stop_time_s + bench.noise_s
    check(rest.after_s <= time_s, f"held for {HOLD_S} s, it went on for {rest.after_s:.2f} s")


@row("a held jog expires by itself", "jog", watched=True, transports=ALSO_UDP)
def a_held_jog_expires_by_itself(bench: Bench) -> None:
    """Of the joints, and of the tip and the fingers on an arm that has them."""
    arm = bench.ready()
    jogs = [sweeping_jog(arm)]
    jogs += [] if cartesian(bench) else [Jog.cartesian(y=1.0, z=-0.5)]
    jogs += [] if finger_motor(bench) else [Jog.joint(gripper=1.0)]
    for jog in jogs:
        _expires(bench, arm, jog)
        check_settled(bench, arm)


@row("an unreferenced arm jogs slowly, and a held jog of it expires", "jog", watched=True)
def unreferenced_jogs_are_slow(bench: Bench) -> None:
    arm = bench.connect()
    bench.switch_on(arm)
    first = arm.model.arm.joint_names[0]
    limit_rad_s = arm.model.joint_speeds_rad_s[0] * bench.config.motion.unreferenced_speed
    before = bench.posture(bench.look().motors)[0].deg[first]
    arm.jog_j(**{first: 1.0}, speed=1.0, duration_s=HOLD_S)
    made_rad = math.radians(abs(bench.posture(bench.look().motors)[0].deg[first] - before))
    check(made_rad > 0.0, "an unreferenced arm could not be jogged")
    most_rad = limit_rad_s * (HOLD_S + bench.config.motion.jog_burst_s) * 1.1 + 0.01
    check(made_rad <= most_rad, "an unreferenced arm was jogged faster than announced")
    _expires(bench, arm, sweeping_jog(arm))
    check(arm.status.trust is not Trust.REFERENCED, "a jog gave the position a meaning")


ROWS = rows_of(globals())
