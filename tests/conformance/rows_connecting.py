"""Behaviours of connecting, referencing and leaving, and of a wire that is lost and comes back."""

from armdrive.abilities import Switching
from armdrive.arm import Arm
from armdrive.errors import ArmInUse, LinkLost, NotReferenced, PortUnavailable, Refused, WrongState
from armdrive.status import State, Trust

from .behaviour import ALSO_UDP, IN_SIMULATION, row, rows_of
from .bench import Bench
from .motions import check_refused, jog_first_joint, planned_motions
from .observation import ON_THE_STEP, check
from .rows_moving import check_moves
from .rows_stopping import check_within_bound, sweeping


@row("connecting, idling and leaving move nothing", "connect", transports=ALSO_UDP)
def connect_moves_nothing(bench: Bench) -> None:
    with bench.check_unmoved("connecting or idling"):
        arm = bench.connect()
        wanted = State.DISABLED if bench.abilities.current is Switching.BOTH else State.STANDBY
        check(arm.status.state is wanted, f"connected to {arm.status.state}, not {wanted}")
        check(arm.status.trust is Trust.UNKNOWN, "an arm without a saved position is trusted")
        bench.sleep(1.5)
    with bench.check_unmoved("switching the motors on"):
        bench.switch_on(arm)
    with bench.check_unmoved("leaving"):
        bench.disconnect()


@row("the status names the arm and bounds its stop", "connect", watched=True)
def status_names_the_arm(bench: Bench) -> None:
    status = bench.connect().status
    check(status.dialect == bench.row.name, "the status names another dialect")
    check(status.stop_time_s > 0.0 and status.silent_time_s > 0.0, "no stopping time is announced")
    check(
        status.stop_distance_mm > 0.0 and status.silent_distance_mm > 0.0,
        "no stopping distance is announced",
    )
    check(status.which in str(status), "the status does not name its arm")


@row(
    "motion is refused while disabled, and planned motion while unreferenced",
    "connect",
    watched=True,
)
def motion_is_refused(bench: Bench) -> None:
    arm = bench.connect()
    still = [0] * len(bench.look().motors)
    with bench.check_unmoved("a refused motion"):
        if arm.status.state is State.DISABLED:
            check_refused(lambda: jog_first_joint(arm), WrongState, "a jog of a disabled arm")
            check_refused(
                lambda: arm.move_motors(1, *still[1:]), WrongState, "motors of a disabled arm"
            )
            bench.sleep(0.5)
    bench.switch_on(arm)
    with bench.check_unmoved("a refused motion"):
        for name, call in planned_motions(arm).items():
            check_refused(call, Refused, f"{name} without a reference")
        check_refused(planned_motions(arm)["move_j"], NotReferenced, "move_j without a reference")
        bench.sleep(0.5)


@row(
    "an operator references the arm, and an unconfirmed posture nothing", "reference", watched=True
)
def home_by_operator(bench: Bench) -> None:
    arm = bench.connect()
    bench.switch_on(arm)
    with bench.check_unmoved("a home that was not confirmed"):
        check_refused(
            lambda: arm.home(operator=lambda request: False), Refused, "an unconfirmed home"
        )
    check(arm.status.trust is Trust.UNKNOWN, "an unconfirmed posture was accepted")
    check(arm.status.state is State.STANDBY, f"left in {arm.status.state}")
    if not bench.simulated:  # a person confirms the posture of a real arm before the run
        return
    arm.home(operator=bench.operator())
    check(arm.status.trust is Trust.REFERENCED, f"homed, but {arm.status.trust}")
    check(arm.status.state is State.STANDBY, f"homed, but in {arm.status.state}")
    request = arm.reference.request()
    wanted = bench.transmission.to_motors(request.joints, request.opening_mm)
    off = bench.look().off_steps(wanted)
    check(off <= ON_THE_STEP, f"referenced {off} steps from where the arm stands")
    bench.check_trust(arm)


@row("a record is restored, and trusted only when confirmed", "reconnect", watched=True)
def a_record_is_restored_but_not_trusted(bench: Bench) -> None:
    arm = bench.ready()
    check_moves(bench, arm)
    left_at = arm.status.acknowledged
    bench.disconnect()
    bench.sleep(0.5)
    arm = bench.connect()
    restored = arm.status.trust
    forgets = bench.abilities.resets_on_open
    allowed = {Trust.RESTORED, Trust.SUSPECT} if forgets else {Trust.RESTORED}
    check(restored in allowed, f"reconnected, and the position is {restored}")
    check(arm.status.acknowledged == left_at, "the restored position is another one")
    bench.switch_on(arm)
    check_refused(
        planned_motions(arm)["move_j"], NotReferenced, "a motion from a restored position"
    )
    if restored is Trust.RESTORED:
        arm.reference.confirm_restored()
        check(arm.status.trust is Trust.REFERENCED, "a confirmed position is not referenced")
        check_moves(bench, arm)
    bench.check_trust(arm)


@row(
    "a second program learns who holds the arm",
    "reconnect",
    watched=True,
    smoke=True,
    transports=("pty", "tcp", "port"),
)
def a_second_program_learns_who_holds_the_arm(bench: Bench) -> None:
    arm = bench.connect()
    state = arm.status.state
    refusal = check_refused(bench.open_another, ArmInUse, "a second connection")
    check("held by this program" in str(refusal), f"it does not say who holds it: {refusal}")
    check(arm.status.state is state, "the second connection changed the first")
    arm.parts.look()


# -- A lost wire: nothing moves when it comes back, and trust is lost ------------------------------


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
    moved = bench.look().off_steps(before.motors)
    check(moved <= bench.settles_steps, f"leaving error-stop moved it by {moved} steps")
    check_refused(
        planned_motions(arm)["move_j"],
        NotReferenced,
        "a motion from an unconfirmed position",
    )
    bench.reference(arm)
    check_moves(bench, arm)


@row("a wire that comes back moves nothing", "reconnect", transports=(*IN_SIMULATION, "udp"))
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


@row("a motion does not outlive its wire", "reconnect", transports=IN_SIMULATION)
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


@row("a manual reconnect tries once", "reconnect", transports=IN_SIMULATION)
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


ROWS = rows_of(globals())
