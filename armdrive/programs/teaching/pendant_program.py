"""A taught sequence as rows for an arm's own memory, so that its pendant can run it alone.

Nobody audits what the pendant runs: each way between rows is looked at here, before there are any.
What the arm's memory cannot say (lines, waits, grasping) is refused by the number of the step.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from armdrive.config.arm import ArmConfig
from armdrive.errors import OutOfBounds, Refused
from armdrive.motion.plan import audit, limit_error
from armdrive.registry import pendant_of
from armdrive.registry.pendant import PendantProgram
from armdrive.storage.points import Point, Step, StepList
from firmware_protocol.errors import BadField
from kinematics.spaces import Joints


def rows_of(
    config: ArmConfig,
    steps: StepList,
    points: Mapping[str, Point],
    origin: tuple[int, ...] | None,
) -> PendantProgram:
    """Return the rows that do what a sequence does; raises `Refused` and `OutOfBounds`.

    Rows are absolute in the registers of an arm with this `origin`. The fingers of the first row
    are those of its point.
    """
    if origin is None:
        raise Refused("nobody knows what the arm's registers count from: home it first")
    maker = _Maker(config, points, origin)
    for number, step in enumerate(steps.steps, 1):
        try:
            maker.take(step)
        except OutOfBounds as error:
            raise OutOfBounds(
                f"step {number} ({step}): {error}",
                name=error.name,
                value=error.value,
                bound=error.bound,
            ) from None
        except (Refused, BadField) as error:
            raise Refused(f"step {number} ({step}) is no row of the arm's: {error}") from None
    if not maker.rows:
        raise Refused("the sequence has no steps: there is nothing to make rows of")
    return PendantProgram(tuple(maker.rows), origin)


class _Maker:
    """Makes rows, one after another, each from where the one before has led."""

    def __init__(
        self, config: ArmConfig, points: Mapping[str, Point], origin: tuple[int, ...]
    ) -> None:
        self.rows: list[Any] = []
        self._config = config
        self._pendant = pendant_of(config)
        self._points = points
        self._origin = origin
        self._point: Point | None = None
        self._opening_mm: float | None = None

    def take(self, step: Step) -> None:
        """Make the row of a step."""
        if step.wait_s is not None:
            raise Refused("how the arm's memory says a wait is not known")
        if step.how != "joint":
            raise Refused("it knows joint motions alone")
        if step.point:
            self._go(self._points[step.point])
        else:
            self._opening_mm = self._opening(step)
        self._add(step.speed)

    def _go(self, point: Point) -> None:
        if self._opening_mm is None:
            self._opening_mm = point.opening_mm
        beyond = self._config.model.arm.violations(point.joints)
        if beyond:
            raise limit_error(beyond[0])
        start = point if self._point is None else self._point
        audit(self._config, [start.joints, point.joints])
        self._point = point

    def _opening(self, step: Step) -> float:
        closed_mm, open_mm = self._config.model.gripper_range_mm
        if step.gripper == "point":
            said = None if self._point is None else self._point.opening_mm
        else:
            said = {"open": open_mm, "close": closed_mm}.get(str(step.gripper))
        width = step.gripper if isinstance(step.gripper, int | float) else said
        if width is None:
            why = "it closes blindly: say a width" if step.gripper == "grasp" else "no width known"
            raise Refused(why)
        if not closed_mm <= width <= open_mm:
            raise Refused(f"the fingers open from {closed_mm:g} to {open_mm:g} mm")
        return float(width)

    def _add(self, speed: float) -> None:
        if self._point is None:
            raise Refused("a row says where the whole arm is: begin with a way to a point")
        if self._opening_mm is None:
            raise Refused("nobody knows how far the fingers are open there: teach it again")
        positions = self._registers(self._point.joints, self._opening_mm)
        number = len(self.rows) + 1
        self.rows.append(self._pendant.row(self._config, number, speed, positions))

    def _registers(self, joints: Joints, opening_mm: float) -> tuple[int, ...]:
        transmission = self._config.model.transmission
        if transmission is None:
            raise Refused("the arm file gives no motors")
        there = transmission.to_motors(joints, opening_mm)
        return tuple(at - zero for at, zero in zip(there, self._origin, strict=True))
