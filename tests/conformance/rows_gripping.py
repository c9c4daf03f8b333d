"""Behaviours of fingers without a stepped motor: on a servo, or on an output."""

from armdrive.arm import Arm
from armdrive.errors import ArmError, BadRequest, OutOfBounds, Refused
from armdrive.status import State

from .behaviour import IN_SIMULATION, no_servo, row, rows_of, servo, valve
from .bench import Bench
from .motions import begin_sweep, check_refused
from .observation import check
from .rows_moving import FINGERS_MM, check_moves
from .rows_stopping import check_settled

WIDTH_MM = 24.0
FURTHER_MM = 8.0


def _arm_with(bench: Bench, kind: str) -> Arm:
    bench.use_arm_file(f'[gripper]\nkind = "{kind}"')
    arm = bench.ready()
    check_refused(lambda: arm.gripper.opening_mm, Refused, "an opening that was not commanded yet")
    return arm


def _wait_whole_stroke(bench: Bench, arm: Arm) -> None:
    """Wait a little longer than the fingers take from one end to the other."""
    narrow_mm, wide_mm = arm.model.gripper_range_mm
    bench.sleep(1.1 * (wide_mm - narrow_mm) / arm.model.gripper_speed_mm_s)


def _check_fingers(bench: Bench, arm: Arm, wanted_mm: float) -> None:
    off_mm = abs(bench.look().opening_mm - wanted_mm)
    check(off_mm <= FINGERS_MM, f"the fingers are {off_mm:.1f} mm from {wanted_mm} mm")
    check(arm.gripper.opening_mm == wanted_mm, f"the driver says {arm.gripper.opening_mm} mm")
    check(arm.status.state is State.STANDBY, f"gripped, and in {arm.status.state}")


def _check_fingers_stay(bench: Bench, arm: Arm, wanted_mm: float) -> None:
    """Check that after a motion and a stop the fingers are where they were."""
    check_moves(bench, arm)
    _check_fingers(bench, arm, wanted_mm)
    begin_sweep(arm)
    bench.wait_until_moving()
    arm.stop()
    check_settled(bench, arm)
    _wait_whole_stroke(bench, arm)
    _check_fingers(bench, arm, wanted_mm)


@row("a servo moves to the requested opening", "gripper", needs=(servo,), transports=IN_SIMULATION)
def a_servo_moves_to_the_requested_opening(bench: Bench) -> None:
    arm = _arm_with(bench, "servo")
    with bench.check_unmoved("a servo"):
        for opening_mm in (WIDTH_MM, FURTHER_MM):
            arm.gripper.open(opening_mm)
            _check_fingers(bench, arm, opening_mm)
    widest_mm = arm.model.gripper_range_mm[1]
    check_refused(
        lambda: arm.gripper.open(widest_mm + 5.0), OutOfBounds, "wider than the fingers open"
    )
    _check_fingers_stay(bench, arm, FURTHER_MM)


@row("an output opens and closes the fingers", "gripper", needs=(valve,), transports=IN_SIMULATION)
def an_output_opens_and_closes(bench: Bench) -> None:
    arm = _arm_with(bench, "output")
    narrow_mm, wide_mm = arm.model.gripper_range_mm
    with bench.check_unmoved("an output"):
        arm.gripper.open()
        _check_fingers(bench, arm, wide_mm)
        arm.gripper.close()  # this output is on, and a reset would switch it off
        _check_fingers(bench, arm, narrow_mm)
        check_refused(lambda: arm.gripper.open(WIDTH_MM), BadRequest, "half open by an output")
    _check_fingers_stay(bench, arm, narrow_mm)


@row(
    "connecting does not release an output gripper",
    "gripper",
    needs=(valve,),
    transports=IN_SIMULATION,
)
def connecting_does_not_release_an_output(bench: Bench) -> None:
    """A simulated servo without a command stays where it is; a real one may go limp."""
    arm = _arm_with(bench, "output")
    arm.gripper.close()
    held_mm = bench.look().opening_mm
    bench.disconnect()
    arm = bench.connect()
    _wait_whole_stroke(bench, arm)
    off_mm = abs(bench.look().opening_mm - held_mm)
    check(off_mm <= FINGERS_MM, f"connecting has moved the fingers by {off_mm:.0f} mm")
    check_refused(
        lambda: arm.gripper.opening_mm, ArmError, "an opening that another program commanded"
    )


@row(
    "a servo that the controller cannot drive is refused",
    "gripper",
    needs=(no_servo,),
    transports=IN_SIMULATION,
)
def a_servo_that_the_controller_cannot_drive_is_refused(bench: Bench) -> None:
    bench.use_arm_file('[gripper]\nkind = "servo"')
    with bench.check_unmoved("a refused connection"):
        refusal = check_refused(bench.connect, Refused, "an arm whose controller has no servo")
    check("gripper.kind" in str(refusal), f"the refusal does not name the key: {refusal}")


ROWS = rows_of(globals())
