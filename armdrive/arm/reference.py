"""Referencing an arm, and verifying how far its position has drifted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from armdrive.arm.connected import finished
from armdrive.arm.moving import BEFORE, Moving
from armdrive.config.arm import ArmConfig
from armdrive.config.sections import HomingSettings
from armdrive.connect.parts import Parts
from armdrive.dialog import JoggedArm, MarkRequest, Operator, PostureRequest
from armdrive.errors import OperatorNeeded, Refused, Stopped
from armdrive.errors.printable import reason_of
from armdrive.motion import reference as reference_tasks
from armdrive.motion.reference import (
    Drift,
    Verdict,
    Verified,
    confirmed_posture,
    drift_between,
    judge,
    take_reference,
    verified_view,
)
from armdrive.motion.resolve import above_mark
from armdrive.moves import ParkMove
from armdrive.registry import dialect
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.states import Event
from armdrive.status import Evidence, State, Trust
from armdrive.storage.record import last_entry, write_down
from kinematics.errors import finite
from kinematics.spaces import Joints, Pose

GroupReport = Callable[[tuple[str, ...]], None]


Accept = bool | Callable[[Verified], bool]

SAME_DRIFT = (
    "as much as the last time: slack or wrong numbers in the arm file rather than lost steps, "
    "which differ from time to time"
)

HOMING_PATIENCE_S = 300.0  # a homing that takes longer is stopped


def homes_by_switches(config: ArmConfig) -> bool:
    """Return whether an arm's file describes the controller's own homing, which moves the arm."""
    return config.homing is not None and dialect(config.connection.dialect).abilities.own_homing


class Referencing:
    """The reference of one arm: homing, declaring, confirming and verifying it.

    `arm` is the restricted view of the arm that an operator gets.
    """

    def __init__(self, arm: JoggedArm, parts: Parts, moving: Moving) -> None:
        self._arm = arm
        self._parts = parts
        self._moving = moving
        self._core = parts.core
        self._config = parts.config

    @property
    def unconfirmed(self) -> bool:
        """Whether planned motion has to wait until an operator confirms the restored position."""
        return self._parts.status.trust is Trust.RESTORED and not self._core.allow_restored

    # -- homing ---------------------------------------------------------------------------------

    async def home(self, operator: Operator | None, report: GroupReport, stops: int | None) -> Pose:
        """Reference the arm, by switches or by an operator; see `Arm.home`."""
        runner = self._parts.runner
        if self._config.homing is not None and self.homes_by_switches:
            return await self._home_by_switches(self._config.homing, report, stops)
        request = self.request()
        if operator is None:
            raise OperatorNeeded(
                "this arm has no homing switches, so a person has to look: call `home()` with an "
                "operator, or bring it to a known posture and call `declare_posture()`. "
                f"{request}"
            )
        runner.require(Event.HOME)
        # the operator acts after all stops so far
        runner.require_no_stop(runner.stops if stops is None else stops, BEFORE)
        await runner.perform(reference_tasks.begin_home(self._parts.context))
        try:
            self._have_confirmed(operator, request)
            await self._confirm_posture(request.joints, request.opening_mm, Evidence.HOMED)
        except BaseException:
            await self._leave_homing()
            raise
        return self._parts.pose

    @property
    def homes_by_switches(self) -> bool:
        """Whether `home` moves the arm."""
        return homes_by_switches(self._config)

    @property
    def homing_groups(self) -> tuple[tuple[str, ...], ...]:
        """The motor names of each homing group, in order; empty if the device decides."""
        names = [motor.name for motor in self._core.transmission.motors]
        groups = () if self._config.homing is None else self._config.homing.groups
        return tuple(tuple(names[motor - 1] for motor in group) for group in groups)

    async def _home_by_switches(
        self, homing: HomingSettings, report: GroupReport, stops: int | None
    ) -> Pose:
        context, runner = self._parts.context, self._parts.runner
        with self._parts.pace.lock:
            runner.require(Event.HOME)
            runner.require_no_stop(stops, BEFORE)
            names = self.homing_groups
            body = reference_tasks.home_device(context, homing, lambda group: report(names[group]))
            task = runner.submit(body, alone=True)
        await runner.finish(task, HOMING_PATIENCE_S)
        return self._parts.pose

    def _have_confirmed(self, operator: Operator, request: PostureRequest) -> None:
        """Raise unless the operator confirms the posture, or what has ended that meanwhile."""
        confirmed = operator(request)
        self._parts.runner.require_link()
        self._parts.context.require_no_fault()
        if self._core.state is not State.HOMING:
            raise Stopped("homing was stopped: the reference has not changed")
        if not confirmed:
            raise OperatorNeeded(
                f"the posture was not confirmed: the reference has not changed. {request}"
            )

    async def _leave_homing(self) -> None:
        """Stop any motion that the operator left running, and return to the previous state."""
        try:
            await self._parts.runner.stand_still()
        finally:
            with self._parts.pace.lock:
                self._core.settle()

    # -- declaring ------------------------------------------------------------------------------

    async def confirm_reference(self) -> None:
        """Declare that the arm now stands in its reference posture."""
        request = self.request()
        self._parts.runner.require(Event.MOVE, "confirming the reference")
        await self._confirm_posture(request.joints, request.opening_mm, Evidence.HOMED)

    async def declare_posture(self, posture: Joints | Pose, opening_mm: float) -> None:
        """Declare that the arm now stands in this posture, given by its joints or its pose."""
        geometry = self._config.model.arm
        if isinstance(posture, Pose):
            joints = geometry.ik(posture)
        else:
            joints = self._moving.ground().posture(posture)
        geometry.check(joints)
        self._parts.runner.require(Event.MOVE, "declaring a posture")
        await self._confirm_posture(joints, finite("opening_mm", opening_mm), Evidence.DECLARED)

    async def confirm_restored(self) -> None:
        """Confirm that the arm stands at the restored position; planned motion is allowed again."""
        await self._parts.runner.perform(reference_tasks.confirm_record(self._parts.context))

    def request(self) -> PostureRequest:
        """Return the posture in which the arm is referenced."""
        reference = self._config.model.reference
        if reference is None:
            way = (
                "to have it seek its switches, call `home()`"
                if self.homes_by_switches
                else "write [reference] into its arm file, or call `declare_posture()`"
            )
            raise Refused(f"no reference posture is known for the {self._config.title}: {way}")
        joints = self._config.model.arm.ik(reference.pose)
        return PostureRequest(self._arm, reference.pose, joints, reference.opening_mm)

    async def _confirm_posture(self, joints: Joints, opening_mm: float, evidence: Evidence) -> None:
        there = ArmCoordinates(joints, opening_mm)
        with self._parts.pace.lock:
            confirmed = confirmed_posture(self._core, there, evidence, self._parts.pace.now_s())
        await self._parts.runner.perform(take_reference(self._parts.context, confirmed))

    # -- verifying ------------------------------------------------------------------------------

    async def verify(
        self, operator: Operator | None, accept: Accept, speed: float, logbook: Path | None
    ) -> Verified:
        """Measure how far the position has drifted; see `Arm.verify`.

        The result is added to the `logbook`, and compared with the previous one there.
        """
        mark = self.request()
        request = MarkRequest(mark.arm, mark.pose, mark.joints, mark.opening_mm)
        if operator is None:
            raise OperatorNeeded(
                "a person has to bring the finger tips onto the mark: call `verify()` with an "
                "operator"
            )
        reference = self._core.belief.reason
        await finished(self._moving.start(ParkMove(speed, above_mark(self._config))))
        self._parts.runner.require(Event.HOME, "verifying the position")
        await self._parts.runner.perform(reference_tasks.begin_home(self._parts.context))
        try:
            self._have_confirmed(operator, request)
            verified = await self._measured(request, reference, accept, logbook)
            await self._conclude(request, verified)
        except BaseException:
            await self._leave_homing()
            raise
        return self._written(verified, reference, logbook)

    async def _measured(
        self, request: MarkRequest, reference: str, accept: Accept, logbook: Path | None
    ) -> Verified:
        position = await self._parts.runner.perform(
            reference_tasks.read_at_mark(self._parts.context)
        )
        transmission = self._core.transmission
        truth = ArmCoordinates(request.joints, request.opening_mm).motors(transmission)
        drift = drift_between(self._config.model, position, truth)
        verdict = judge(drift, reference)
        repeated = verdict is Verdict.DRIFT and self._same_as_last(drift, logbook)
        note = SAME_DRIFT if repeated else ""
        found = Verified(verdict, drift, accepted=False, found=drift.words(transmission), note=note)
        if not drift.steps.largest or not _taken(found, accept):
            return found
        return replace(found, accepted=True)

    def _same_as_last(self, drift: Drift, logbook: Path | None) -> bool:
        """Return whether the last verification found the same drift and was accepted."""
        if logbook is None:
            return False
        last = last_entry(logbook, self._config.calibration) or {}
        return bool(last.get("accepted")) and last.get("steps") == list(drift.steps)

    async def _conclude(self, request: MarkRequest, verified: Verified) -> None:
        if verified.accepted:
            await self._confirm_posture(request.joints, request.opening_mm, Evidence.HOMED)
        elif verified.verdict is Verdict.ROUNDING:
            await self._parts.runner.perform(reference_tasks.believe_mark(self._parts.context))
        else:
            await self._parts.runner.perform(
                reference_tasks.doubt_position(self._parts.context, verified.found)
            )

    def _written(self, verified: Verified, reference: str, logbook: Path | None) -> Verified:
        """Write a result into the logbook. If that fails, the result is valid and gets a note."""
        if logbook is None:
            return verified
        try:
            write_down(logbook, verified_view(verified), self._config.calibration, reference)
        except OSError as error:
            unwritten = f"the logbook could not be written: {reason_of(error)}"
            note = f"{verified.note}; {unwritten}" if verified.note else unwritten
            return replace(verified, note=note)
        return verified


def _taken(found: Verified, accept: Accept) -> bool:
    """Return whether the posture becomes the reference; `accept` is not asked about rounding."""
    if callable(accept):
        return found.verdict is not Verdict.ROUNDING and accept(found)
    return accept
