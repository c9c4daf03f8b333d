"""Room for a burst of a device that does not coordinate its motors: how far it may stray.

A whole motion is audited as if it were straight in joint space. Such a device keeps to that only
at the ends of its bursts; between them each motor goes its own way. So a burst is made short
enough that the tip stays within `motion.straying_mm` of the straight way, and shorter where a
guard is nearer than that.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.stopping import straying_mm

if TYPE_CHECKING:
    from armdrive.core import Core
    from kinematics import Motors

SMALL_STEPS = 8
"""A burst this small is sent whatever it may stray: there must be a way out of a guard."""

LOOKS = (0.25, 0.5, 0.75)
"""Where on its way a burst is compared with the guards; its ends have been audited."""


def has_room(core: Core, target: Motors, rate_hz: float) -> bool:
    """Tell whether a burst from where the arm is may stray as far as it can."""
    start = core.acknowledged
    steps = target - start
    if core.controller.abilities.coordinated or steps.largest <= SMALL_STEPS:
        return True
    strays = core.controller.strays_steps(steps, rate_hz)
    here, _ = core.transmission.to_joints(start)
    stray_mm = straying_mm(core.config, here, strays)
    if stray_mm > core.config.motion.straying_mm:
        return False
    if not core.position_known:
        return True
    there, _ = core.transmission.to_joints(target)
    guards = core.config.model.guards.over(core.config.model.arm)
    for look in LOOKS:
        angles = (a + (b - a) * look for a, b in zip(here, there, strict=True))
        room = guards.room(here.replace(**dict(zip(here.names, angles, strict=True))))
        if min(room) < stray_mm:
            return False
    return True
