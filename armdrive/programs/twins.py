"""The twin that a program is rehearsed on: the arm's own, standing where the arm stands.

A simulated arm is rehearsed in a copy of its world, blocks and all. Of a real one nobody knows what
is around it: its twin stands alone. Where nobody knows where the arm stands, that is assumed, or
left to the program, which has to reference it first.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.connecting import connect_simulated
from armdrive.recorder.witness import NO_WITNESS
from armdrive.sim.twin import make_twin
from armdrive.status import State, Trust
from armdrive.whereabouts import Coordinates

if TYPE_CHECKING:
    from collections.abc import Callable

    from armdrive.arm import Arm
    from armdrive.armfile import ArmConfig
    from armdrive.paces import PaceChoice
    from armdrive.sim.twin import Twin


def rehearsing_arm(
    config: ArmConfig,
    arm: Arm | None,
    assumed: Callable[[str], object] | None,
    clock: PaceChoice = None,
) -> Arm:
    """Return a connected twin of an arm on simulated time, enabled, which the caller closes.

    Without `arm` the arm itself cannot be asked. With `assumed`, a position that nobody knows is
    assumed, and `assumed` hears a sentence about it; without, the twin is as little referenced as
    the arm is. `clock` is one of simulated time that several twins share.
    """
    twin = _twin(config, arm)
    there = _known(arm)
    if there is None and assumed is not None:
        there, where = _supposed(config, arm)
        if there is not None:
            assumed(f"the arm stands in {where}")
    if there is not None:
        twin.device.bring_to(there.joints, there.opening_mm)
    made = connect_simulated(config, twin=twin, pace=clock, witness=NO_WITNESS)
    try:
        _make_ready(made, there)
        if arm is not None:
            made.speed_override = arm.speed_override
    except BaseException:
        made.close()
        raise
    return made


def knows_its_world(arm: Arm | None) -> bool:
    """Tell whether the world around an arm is known: that of a simulated one is."""
    return arm is not None and arm.twin is not None


def _twin(config: ArmConfig, arm: Arm | None) -> Twin:
    if arm is None or arm.twin is None:
        return make_twin(config)
    with arm.pace.lock:
        saved = arm.twin.save()
    return make_twin(config, saved)


def _make_ready(made: Arm, there: Coordinates | None) -> None:
    if made.status.state is State.DISABLED:
        made.enable()
    if there is not None:
        made.declare_posture(there.joints, opening_mm=there.opening_mm)


def _known(arm: Arm | None) -> Coordinates | None:
    """Return where an arm stands, if planned motion may begin there."""
    if arm is None:
        return None
    with arm.pace.lock:
        return arm.core.coordinates if arm.core.position_known else None


def _supposed(config: ArmConfig, arm: Arm | None) -> tuple[Coordinates | None, str]:
    """Return where an arm may be taken to stand, and what that place is called."""
    if arm is not None and arm.status.trust is not Trust.UNKNOWN:
        with arm.pace.lock:
            return arm.core.coordinates, "the place where it was seen last"
    reference = config.model.reference
    if reference is not None:
        joints = config.model.arm.ik(reference.pose)
        return Coordinates(joints, reference.opening_mm), "its reference posture"
    if config.homing is not None:
        return Coordinates(config.homing.joints, config.homing.opening_mm), "its switches"
    return None, ""
