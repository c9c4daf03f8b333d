"""Referencing an arm, and verifying how far its position has drifted."""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from dataclasses import replace
from typing import Any, Protocol, TypeVar

from armdrive.arm.arguments import RULES
from armdrive.arm.connected import BEFORE, PATIENCE, ArmPart, Handle, finished
from armdrive.blocking import blocking
from armdrive.config.arm import ArmConfig
from armdrive.connect.parts import Parts
from armdrive.connect.runner import PATIENCE_S
from armdrive.dialects.controller import in_turn
from armdrive.dialog import JoggedArm, MarkRequest, Operator, PostureRequest
from armdrive.errors import OperatorNeeded, Refused, Stopped
from armdrive.errors.arguments import checked_calls, known_attributes
from armdrive.motion import reference as reference_tasks
from armdrive.motion.execute import Moved
from armdrive.motion.plan import audit_opening
from armdrive.motion.reference import (
    Verdict,
    Verified,
    confirmed_posture,
    drift_between,
    judge,
    take_reference,
)
from armdrive.motion.resolve import above_mark
from armdrive.moves import ParkMove, in_order
from armdrive.registry import dialect
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.states import Event
from armdrive.runtime.stop_bounds import homing_bound
from armdrive.status import Evidence, State, Trust, bound_words
from armdrive.tasks import listed
from armdrive.trace.recorder import traced
from kinematics.limits import refuse_worst
from kinematics.spaces import Joints, Pose

T = TypeVar("T")

GroupReport = Callable[[tuple[str, ...]], None]

Accept = bool | Callable[[Verified], bool]


def homes_by_switches(config: ArmConfig) -> bool:
    """Return whether an arm's file describes the controller's own homing, which moves the arm."""
    return config.homing is not None and dialect(config.connection.dialect).abilities.own_homing


class ReferencedArm(JoggedArm, Protocol):
    """The arm of a reference: what an operator gets of it, and what a verification needs."""

    operator: Operator | None

    def start(self, move: ParkMove) -> Handle[Moved]:
        """Start a move."""


@known_attributes
@traced("reference")
@checked_calls(RULES)
class ArmReference(ArmPart):
    """What an arm's position rests on: declaring, confirming and verifying its posture."""

    def __init__(self, arm: ReferencedArm, parts: Parts) -> None:
        super().__init__(parts)
        self._arm = arm
        self._config = parts.config

    @property
    def homes_by_switches(self) -> bool:
        """Whether `home` moves the arm, because its controller seeks switches."""
        return homes_by_switches(self._config)

    @property
    def homing_groups(self) -> tuple[tuple[str, ...], ...]:
        """The motor names of each homing group, in order; empty if the device decides."""
        names = [motor.name for motor in self._core.transmission.motors]
        groups = () if self._config.homing is None else self._config.homing.groups
        return tuple(tuple(names[motor - 1] for motor in group) for group in groups)

    @property
    def homing_words(self) -> str:
        """What `home` makes the controller do, its bound, and which of its settings differ.

        Empty for an arm without switches.
        """
        bound = homing_bound(self._config, self._core.controller)
        if bound is None:
            return ""
        named = ", then ".join(" and ".join(group) for group in self.homing_groups)
        order = f"the switches of {named}" if named else "its switches, in its own order"
        silent = bound_words(bound.silent_time_s, bound.silent_distance_mm)
        differing = listed(self._core.differences)
        return (
            f"THE ARM WILL MOVE: its controller seeks {order}. If this program dies or the link is "
            f"lost, it goes on for at most {silent}."
            + (f" But its settings differ from the arm file: {differing}." if differing else "")
        )

    @property
    def unconfirmed(self) -> bool:
        """Whether planned motion has to wait until an operator confirms the restored position."""
        return self._parts.status.trust is Trust.RESTORED and not self._core.allow_restored

    def request(self) -> PostureRequest:
        """Return the posture in which the arm is referenced."""
        reference = self._config.model.reference
        if reference is None:
            way = (
                "to have it seek its switches, call `home()`"
                if self.homes_by_switches
                else "write [reference] into its arm file, or call `reference.declare()`"
            )
            raise Refused(f"no reference posture is known for the {self._config.title}: {way}")
        joints = self._config.model.arm.ik(reference.pose)
        return PostureRequest(self._arm, reference.pose, joints, reference.opening_mm)

    @blocking
    async def confirm(self) -> None:
        """Declare that the arm now stands in its reference posture."""
        request = self.request()
        self._parts.runner.require(Event.MOVE, "confirming the reference")
        await _take(self._parts, request.joints, request.opening_mm, Evidence.HOMED)

    @blocking
    async def declare(self, posture: Joints | Pose, *, opening_mm: float = 0.0) -> None:
        """Declare that the arm now stands in this posture, given by its joints or its pose.

        Raises `JointLimit`, and `OutOfBounds` for an opening that the gripper cannot have.
        """
        geometry = self._config.model.arm
        if isinstance(posture, Pose):
            joints = geometry.ik(posture)
        else:
            joints = in_order(posture, geometry.joint_names)
        refuse_worst(geometry.violations(joints))
        # A grasp pulls in more cable than closing does, and whole steps round: such an opening is a
        # little out of the range, and was reported by this arm. A slip is further out.
        widest_mm = self._config.model.gripper_range_mm[1]
        if self._core.transmission.has_gripper and abs(opening_mm) > 2.0 * widest_mm:
            audit_opening(self._config, opening_mm)
        self._parts.runner.require(Event.MOVE, "declaring a posture")
        await _take(self._parts, joints, opening_mm, Evidence.DECLARED)

    @blocking
    async def confirm_restored(self) -> None:
        """Confirm that the arm stands at the restored position; planned motion is allowed again."""
        await self._parts.runner.perform(reference_tasks.confirm_record(self._parts.context))

    @blocking
    async def verify(
        self, *, operator: Operator | None = None, accept: Accept = False, speed: float = 0.5
    ) -> Verified:
        """Measure how far the position has drifted, at the reference mark.

        The arm **moves** to a point above the mark. Then `operator` is called with a `MarkRequest`,
        jogs the finger tips onto the mark, and returns True. If `accept` is True, or a function
        that returns True for the result, the posture becomes the new reference; otherwise a
        position with drift becomes suspect. Raises `NotReferenced` if there is no position to
        verify, and `OperatorNeeded` without an operator or without a confirmation.
        """
        mark = self.request()
        request = MarkRequest(mark.arm, mark.pose, mark.joints, mark.opening_mm)
        if (asked := operator or self._arm.operator) is None:
            raise OperatorNeeded(
                "a person has to bring the finger tips onto the mark: call `reference.verify()` "
                "with an operator"
            )
        reference = self._core.belief.reason
        await finished(self._arm.start(ParkMove(speed, above_mark(self._config))))
        self._parts.runner.require(Event.HOME, "verifying the position")

        async def conclude() -> Verified:
            verified = await self._measured(request, reference, accept)
            await self._conclude(request, verified)
            return verified

        return await _guided(self._parts, asked, request, conclude)

    async def _measured(self, request: MarkRequest, reference: str, accept: Accept) -> Verified:
        position = await self._parts.runner.perform(
            reference_tasks.read_at_mark(self._parts.context)
        )
        transmission = self._core.transmission
        truth = ArmCoordinates(request.joints, request.opening_mm).motors(transmission)
        drift = drift_between(self._config, position, truth)
        verdict = judge(drift, reference)
        found = Verified(verdict, drift, accepted=False, found=drift.words(transmission))
        if not drift.steps.largest or not _taken(found, accept):
            return found
        return replace(found, accepted=True)

    async def _conclude(self, request: MarkRequest, verified: Verified) -> None:
        if verified.accepted:
            await _take(self._parts, request.joints, request.opening_mm, Evidence.HOMED)
        elif verified.verdict is Verdict.ROUNDING:
            await self._parts.runner.perform(reference_tasks.believe_mark(self._parts.context))
        else:
            await self._parts.runner.perform(
                reference_tasks.doubt_position(self._parts.context, verified.found)
            )


def _taken(found: Verified, accept: Accept) -> bool:
    """Return whether the posture becomes the reference; `accept` is not asked about rounding."""
    if callable(accept):
        return found.verdict is not Verdict.ROUNDING and accept(found)
    return accept


# Homing, by switches or by an operator.


async def home(
    parts: Parts,
    reference: ArmReference,
    operator: Operator | None,
    report: GroupReport,
    stops: int | None,
) -> Pose:
    """Reference the arm, by switches or by an operator; see `Arm.home`."""
    runner = parts.runner
    if parts.config.homing is not None and reference.homes_by_switches:
        groups = reference.homing_groups
        search = parts.core.controller.search
        with parts.pace.lock:  # the controller may be learning how fast its drives home
            lasts_s = in_turn(search(each).lasts for each in parts.config.homing.requests()).s
            runner.require(Event.HOME)
            runner.require_no_stop(stops, BEFORE)
            body = reference_tasks.home_device(
                parts.context, parts.config.homing, lambda group: report(groups[group])
            )
            task = runner.submit(body, alone=True)
        await runner.finish(task, lasts_s * PATIENCE + PATIENCE_S)
        return parts.pose
    request = reference.request()
    if operator is None:
        raise OperatorNeeded(
            "this arm has no homing switches, so a person has to look: call `home()` with an "
            "operator, run the program with `armdrive run` in a terminal, or bring the arm to a "
            f"known posture and call `reference.declare()`. {request}"
        )
    runner.require(Event.HOME)
    # the operator acts after all stops so far
    runner.require_no_stop(runner.stops if stops is None else stops, BEFORE)
    await _guided(
        parts,
        operator,
        request,
        lambda: _take(parts, request.joints, request.opening_mm, Evidence.HOMED),
    )
    return parts.pose


async def _guided(
    parts: Parts,
    operator: Operator,
    request: PostureRequest,
    conclude: Callable[[], Coroutine[Any, Any, T]],
) -> T:
    """Let an operator bring the arm to a posture, and conclude from it."""
    await parts.runner.perform(reference_tasks.begin_home(parts.context))
    try:
        _have_confirmed(parts, operator, request)
        return await conclude()
    except BaseException:
        await parts.runner.stand_still()  # the operator may have left a motion running
        raise


def _have_confirmed(parts: Parts, operator: Operator, request: PostureRequest) -> None:
    """Raise unless the operator confirms the posture, or what has ended that meanwhile."""
    confirmed = operator(request)
    parts.runner.require_link()
    parts.context.require_no_fault()
    if parts.core.state is not State.HOMING:
        raise Stopped("homing was stopped: the reference has not changed")
    if not confirmed:
        raise OperatorNeeded(
            f"the posture was not confirmed: the reference has not changed. {request}"
        )


async def _take(parts: Parts, joints: Joints, opening_mm: float, evidence: Evidence) -> None:
    """Take a posture as the arm's position."""
    there = ArmCoordinates(joints, opening_mm)
    with parts.pace.lock:
        confirmed = confirmed_posture(parts.core, there, evidence, parts.pace.now_s())
    await parts.runner.perform(take_reference(parts.context, confirmed))
