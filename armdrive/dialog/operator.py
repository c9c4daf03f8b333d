"""The requests of `home` and `verify` to an operator, and the arm as an operator sees it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, Unpack

from armdrive.moves import BASE_FRAME, Angles, Jog, JointJog, TipJog
from armdrive.status import Status
from kinematics.presets import ArmModel
from kinematics.spaces import Joints, Pose


class JogResult(Protocol):
    """The result of a jog."""

    @property
    def note(self) -> str:
        """What was clipped or left out; empty if nothing was."""


class JoggedArm(Protocol):
    """An arm that can be watched, jogged and stopped, and nothing else."""

    @property
    def status(self) -> Status:
        """The arm's present status."""

    @property
    def model(self) -> ArmModel:
        """Its geometry and its limits."""

    def jog_j(
        self,
        amounts: Angles | None = None,
        /,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        **axes: Unpack[JointJog],
    ) -> JogResult:
        """Jog joints by increments, or for a time."""

    def jog_l(
        self,
        amounts: Angles | None = None,
        /,
        *,
        speed: float = 0.25,
        duration_s: float | None = None,
        frame: str = BASE_FRAME,
        **axes: Unpack[TipJog],
    ) -> JogResult:
        """Jog the tip by increments, or for a time."""

    def hold(self, jog: Jog, *, speed: float, for_s: float) -> None:
        """Jog for a time, unless called again before its end; do not wait."""

    def move_motors(self, *steps: int, speed: float = 0.25) -> object:
        """Move each motor by whole steps from where it is."""

    def sleep(self, time_s: float) -> None:
        """Let time pass on the arm's own clock."""

    def stop(self) -> None:
        """Stop, and wait until the arm stands."""


@dataclass(frozen=True, slots=True, eq=False)
class PostureRequest:
    """Asks an operator to bring the arm to a posture and to say whether it is there.

    The operator may jog `arm`, and do nothing else with it.
    """

    arm: JoggedArm
    pose: Pose
    joints: Joints
    opening_mm: float

    def __str__(self) -> str:
        return (
            f"Bring the arm to its reference posture: finger tips touching the table "
            f"{self.pose.x_mm:.0f} mm in front of the base axis, hand straight down, wrist "
            f"turnbuckles lined up, fingers just touching each other. ({self.pose})"
        )


@dataclass(frozen=True, slots=True, eq=False)
class MarkRequest(PostureRequest):
    """Asks for the same posture, reached by small jogs, as exactly as possible."""

    def __str__(self) -> str:
        return (
            f"Bring the finger tips onto the reference mark, {self.pose.x_mm:.0f} mm in front of "
            f"the base axis, in small jogs: tips just touching the table, hand straight down, "
            f"wrist turnbuckles lined up, fingers just touching each other. ({self.pose})"
        )


Operator = Callable[[PostureRequest], bool]
"""Returns True when the arm stands in the requested posture."""
