"""Behaviours of a wire that is lost and comes back: nothing moves, and trust is lost."""

from armdrive.arm import Arm
from armdrive.errors import LinkLost, NotReferenced, PortUnavailable, WrongState
from armdrive.status import State, Trust

from .behaviour import IN_SIMULATION, Behaviour
from .bench import Bench
from .motions import check_refused, jog_first_joint, planned_motions
from .observation import check
from .rows_moving import check_moves
from .rows_stopping import check_within_bound, sweeping

SEEN_S = 3.0
"""The driver notices a pulled cable within this time."""
BACK_S = 15.0
"""The driver finds the arm within this time after the cable is back."""


def unplug(bench: Bench, arm: Arm) -> None:
    """Pull the cable, and wait until the driver notices."""
    bench.fault("unplug")
    bench.wait_until(lambda: arm.status.state is State.DISCONNECTED, SEEN_S)


def plug_in(bench: Bench, arm: Arm) -> None:
    """Put the cable back, and wait until the driver has found the arm and latched error-stop."""
    bench.heal()
    bench.wait_until(lambda: arm.status.state is not State.DISCONNECTED, BACK_S)
    bench.wait_until(lambda: arm.status.error_code == "E409", BACK_S)
    check(
        arm.status.state is State.ERROR_STOP, f"the wire is back, and it is in {arm.status.state}"
    )


def check_works_again(bench: Bench, arm: Arm) -> None:
    """Reset, reference and move; the reset alone moves nothing."""
    before = bench.look()
    check_refused(lambda: jog_first_joint(arm), WrongState, "a jog in error-stop")
    arm.reset()
    bench.switch_on(arm)
    bench.sleep(1.0)
    check(bench.look().motors == before.motors, "leaving error-stop moved it")
    check_refused(
        planned_motions(arm)["move_j"],
        NotReferenced,
        "a motion from an unconfirmed position",
    )
    bench.reference(arm)
    check_moves(bench, arm)


def a_wire_that_comes_back_moves_nothing(bench: Bench) -> None:
    arm = bench.ready(reconnect=True)
    check_moves(bench, arm)
    with bench.check_unmoved("trying to reconnect"):
        unplug(bench, arm)
        bench.sleep(1.0)
        plug_in(bench, arm)
    allowed = {Trust.RESTORED, *([Trust.SUSPECT] if bench.abilities.resets_on_open else [])}
    check(arm.status.trust in allowed, f"the wire is back, and the position {arm.status.trust}")
    check_works_again(bench, arm)


def a_motion_does_not_outlive_its_wire(bench: Bench) -> None:
    arm, handle = sweeping(bench, reconnect=True)
    status, seen = arm.status, bench.look()
    unplug(bench, arm)
    check_refused(handle.wait, LinkLost, "waiting for a motion whose wire was lost")
    rest = bench.rest(seen)
    check_within_bound(bench, status, rest, "unplugged", silent=True)
    plug_in(bench, arm)
    check(bench.look().motors == rest.end.motors, "it moved once its wire was back")
    check(arm.status.trust is Trust.SUSPECT, f"its wire was lost in motion: {arm.status.trust}")
    check_works_again(bench, arm)


def a_manual_reconnect_tries_once(bench: Bench) -> None:
    arm = bench.ready()
    with bench.check_unmoved("reconnecting"):
        unplug(bench, arm)
        check_refused(arm.reconnect, PortUnavailable, "reconnecting without a cable")
        bench.heal()
        bench.sleep(1.0)
        check(arm.status.state is State.DISCONNECTED, "it connected again without a request")
        arm.reconnect()
        check(arm.status.state is State.ERROR_STOP, f"reconnected, and in {arm.status.state}")
    check_works_again(bench, arm)


ROWS = (
    Behaviour("a wire that comes back moves nothing", "reconnect",
              a_wire_that_comes_back_moves_nothing, transports=IN_SIMULATION),
    Behaviour("a motion does not outlive its wire", "reconnect",
              a_motion_does_not_outlive_its_wire, transports=IN_SIMULATION),
    Behaviour("a manual reconnect tries once", "reconnect",
              a_manual_reconnect_tries_once, transports=IN_SIMULATION),
)  # fmt: skip
