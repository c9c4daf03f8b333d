"""Behaviours of fingers that are commanded and not stepped: a servo's, and those on an output."""

from __future__ import annotations

from armdrive.arm import Arm
from armdrive.errors import ArmError, BadRequest, OutOfBounds, Refused
from armdrive.status import State

from .behaviour import IN_SIMULATION, Behaviour, no_servo, servo, valve
from .bench import Bench
from .going import begin_sweep, joints_from, refused
from .rows_moving import FINGERS_MM, arrived
from .rows_stopping import settled, under_way
from .seen import check

WIDTH_MM = 24.0
FURTHER_MM = 8.0


def _fitted(bench: Bench, kind: str) -> Arm:
    bench.fit(f'[gripper]\nkind = "{kind}"')
    arm = bench.ready()
    refused(lambda: arm.gripper.opening_mm, Refused, "an opening that nobody has commanded yet")
    return arm


def _whole_way(bench: Bench, arm: Arm) -> None:
    """Wait for as long as the fingers would take from one end to the other, and a little more."""
    narrow_mm, wide_mm = arm.model.gripper_range_mm
    bench.sleep(1.1 * (wide_mm - narrow_mm) / arm.model.gripper_speed_mm_s)


def _fingers_at(bench: Bench, arm: Arm, wanted_mm: float) -> None:
    off_mm = abs(bench.look().opening_mm - wanted_mm)
    check(off_mm <= FINGERS_MM, f"the fingers are {off_mm:.1f} mm from {wanted_mm} mm")
    check(arm.gripper.opening_mm == wanted_mm, f"they are said to be at {arm.gripper.opening_mm}")
    check(arm.status.state is State.STANDBY, f"gripped, and in {arm.status.state}")


def _keeps(bench: Bench, arm: Arm, wanted_mm: float) -> None:
    """Check that neither a motion nor a stop moves the fingers for long."""
    arm.move_j(**joints_from(arm, 4.0, -2.0))
    arrived(bench, arm)
    _fingers_at(bench, arm, wanted_mm)
    begin_sweep(arm)
    under_way(bench)
    arm.stop()
    settled(bench, arm)
    _whole_way(bench, arm)
    _fingers_at(bench, arm, wanted_mm)


def a_servo_goes_where_it_is_told(bench: Bench) -> None:
    arm = _fitted(bench, "servo")
    with bench.unmoved("a servo"):
        for opening_mm in (WIDTH_MM, FURTHER_MM):
            arm.gripper.move(opening_mm)
            _fingers_at(bench, arm, opening_mm)
    widest_mm = arm.model.gripper_range_mm[1]
    refused(lambda: arm.gripper.move(widest_mm + 5.0), OutOfBounds, "wider than the fingers open")
    _keeps(bench, arm, FURTHER_MM)


def an_output_opens_and_closes(bench: Bench) -> None:
    arm = _fitted(bench, "output")
    narrow_mm, wide_mm = arm.model.gripper_range_mm
    with bench.unmoved("an output"):
        arm.gripper.open()
        _fingers_at(bench, arm, wide_mm)
        arm.gripper.close()  # by an output that is on: a reset would switch it off
        _fingers_at(bench, arm, narrow_mm)
        refused(lambda: arm.gripper.move(WIDTH_MM), BadRequest, "half open by an output")
    _keeps(bench, arm, narrow_mm)


def connecting_lets_nothing_go(bench: Bench) -> None:
    """A servo that is told nothing stays where it is here; a real one may go limp."""
    arm = _fitted(bench, "output")
    arm.gripper.close()
    held_mm = bench.look().opening_mm
    bench.leave()
    arm = bench.connect()
    _whole_way(bench, arm)
    off_mm = abs(bench.look().opening_mm - held_mm)
    check(off_mm <= FINGERS_MM, f"connecting has moved the fingers by {off_mm:.0f} mm")
    refused(lambda: arm.gripper.opening_mm, ArmError, "an opening that another program commanded")


def a_servo_that_nothing_drives_is_refused(bench: Bench) -> None:
    bench.fit('[gripper]\nkind = "servo"')
    with bench.unmoved("a refused connection"):
        told = refused(bench.connect, Refused, "an arm whose controller has no servo")
    check("gripper.kind" in str(told), f"the refusal does not name what is wrong: {told}")


ROWS = (
    Behaviour("a servo goes where it is told", "gripper", a_servo_goes_where_it_is_told,
              needs=(servo,), transports=IN_SIMULATION),
    Behaviour("an output opens and closes the fingers", "gripper", an_output_opens_and_closes,
              needs=(valve,), transports=IN_SIMULATION),
    Behaviour("connecting lets nothing go that an output holds", "gripper",
              connecting_lets_nothing_go, needs=(valve,), transports=IN_SIMULATION),
    Behaviour("a servo that nothing drives is refused", "gripper",
              a_servo_that_nothing_drives_is_refused, needs=(no_servo,),
              transports=IN_SIMULATION),
)  # fmt: skip
