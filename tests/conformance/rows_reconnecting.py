"""Behaviours of a wire that is lost and comes back: nothing moves, and little is believed."""

from __future__ import annotations

from armdrive.arm import Arm
from armdrive.errors import LinkLost, NotReferenced, PortUnavailable, WrongState
from armdrive.status import State, Trust

from .behaviour import IN_SIMULATION, Behaviour
from .bench import Bench
from .going import begin_sweep, jog_first, joints_from, planned, refused
from .rows_moving import arrived
from .rows_stopping import under_way
from .seen import check

SEEN_S = 3.0
"""A pulled cable is known of by then."""
BACK_S = 15.0
"""Longer than any pause between two tries that are made so soon, and taking up the arm."""


def unplugged(bench: Bench, arm: Arm) -> None:
    """Pull the cable, and wait until that is known."""
    bench.fault("unplug")
    for _ in bench.watch(lambda: arm.status.state is State.DISCONNECTED, SEEN_S):
        pass


def back(bench: Bench, arm: Arm) -> None:
    """Put the cable back, and wait until the driver has found the arm: it latches error-stop."""
    bench.heal()
    for _ in bench.watch(lambda: arm.status.state is not State.DISCONNECTED, BACK_S):
        pass
    for _ in bench.watch(lambda: arm.status.error_code == "E409", BACK_S):
        pass
    check(
        arm.status.state is State.ERROR_STOP, f"the wire is back, and it is in {arm.status.state}"
    )


def works_again(bench: Bench, arm: Arm) -> None:
    """Reset, reference and move; the reset alone moves nothing."""
    before = bench.look()
    refused(lambda: jog_first(arm), WrongState, "a jog in error-stop")
    arm.reset()
    bench.switch_on(arm)
    bench.sleep(1.0)
    check(bench.look().motors == before.motors, "leaving error-stop moved it")
    refused(planned(arm)["move_j"], NotReferenced, "a motion of which nobody confirmed the start")
    bench.refer(arm)
    arm.move_j(**joints_from(arm, -6.0, 3.0))
    arrived(bench, arm)


def a_wire_that_is_back_moves_nothing(bench: Bench) -> None:
    arm = bench.ready(reconnect=True)
    arm.move_j(**joints_from(arm))
    with bench.unmoved("looking for a lost wire"):
        unplugged(bench, arm)
        bench.sleep(1.0)
        back(bench, arm)
    allowed = {Trust.RESTORED, *([Trust.SUSPECT] if bench.abilities.resets_on_open else [])}
    check(arm.status.trust in allowed, f"the wire is back, and the position {arm.status.trust}")
    works_again(bench, arm)


def a_motion_does_not_outlive_its_wire(bench: Bench) -> None:
    arm = bench.ready(reconnect=True)
    handle = begin_sweep(arm)
    under_way(bench)
    silent_s, seen = arm.status.silent_time_s, bench.look()
    unplugged(bench, arm)
    refused(handle.wait, LinkLost, "waiting for a motion whose wire was lost")
    rest = bench.rest(seen)
    time_s = silent_s + bench.noise_s
    check(
        rest.after_s <= time_s, f"unplugged, it went on for {rest.after_s:.3f} s, not {time_s:.3f}"
    )
    back(bench, arm)
    check(bench.look().motors == rest.end.motors, "it moved once its wire was back")
    check(arm.status.trust is Trust.SUSPECT, f"its wire was lost in motion: {arm.status.trust}")
    works_again(bench, arm)


def by_hand_a_wire_is_looked_for_once(bench: Bench) -> None:
    arm = bench.ready()
    with bench.unmoved("reconnecting"):
        unplugged(bench, arm)
        refused(arm.reconnect, PortUnavailable, "reconnecting without a cable")
        bench.heal()
        bench.sleep(1.0)
        check(arm.status.state is State.DISCONNECTED, "it connected again without being asked to")
        arm.reconnect()
        check(arm.status.state is State.ERROR_STOP, f"reconnected, and in {arm.status.state}")
    works_again(bench, arm)


ROWS = (
    Behaviour("a wire that is back moves nothing", "reconnect",
              a_wire_that_is_back_moves_nothing, transports=IN_SIMULATION),
    Behaviour("a motion does not outlive its wire", "reconnect",
              a_motion_does_not_outlive_its_wire, transports=IN_SIMULATION),
    Behaviour("by hand a lost wire is looked for once", "reconnect",
              by_hand_a_wire_is_looked_for_once, transports=IN_SIMULATION),
)  # fmt: skip
