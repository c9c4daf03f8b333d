"""How the arm is told where it is, and how far it has drifted from there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from armdrive.arm.connected import finished
from armdrive.arm.moving import Moving
from armdrive.config.sections import HomingSettings
from armdrive.connect.parts import Parts
from armdrive.dialog.operator import JoggedArm, MarkRequest, Operator, PostureRequest
from armdrive.errors import OperatorNeeded, Refused, Stopped
from armdrive.motion import reference as referencing
from armdrive.motion import reference as verifying
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
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.states import Event, after
from armdrive.status import Evidence, State, Trust
from armdrive.storage.verifications import last_entry, write_down
from kinematics.errors import finite
from kinematics.spaces import Joints, Pose

Told = Callable[[tuple[str, ...]], None]


def unreported(_: tuple[str, ...]) -> None:
    """Nobody wants to hear which motors have been homed."""


Accept = bool | Callable[[Verified], bool]

AGAIN = (
    "as much as the last time: slack or wrong numbers in the arm file rather than lost steps, "
    "which differ from time to time"
)

HOMING_PATIENCE_S = 300.0
"""A homing that takes longer is stopped."""


class Referencing:
    """The reference of one arm: taken, declared, confirmed and verified.

    `arm` is the arm as an operator meets it.
    """

    def __init__(self, arm: JoggedArm, parts: Parts, moving: Moving) -> None:
        self._arm = arm
        self._parts = parts
        self._moving = moving
        self._core = parts.core
        self._config = parts.config

    def require(self) -> None:
        """Raise `NotReferenced`, with the way to a reference, unless planned motion may go on."""
        self._core.require_reference()

    @property
    def unconfirmed(self) -> bool:
        """Whether planned motion waits for somebody to confirm where an earlier program left it."""
        return self._parts.status.trust is Trust.RESTORED and not self._core.allow_restored

    # -- homing ---------------------------------------------------------------------------------

    async def home(self, operator: Operator | None, told: Told) -> Pose:
        """Take the reference posture, by switches or by an operator; see `Arm.home`."""
        if self._config.homing is not None and self.homes_by_switches:
            return await self._home_by_switches(self._config.homing, told)
        request = self.request()
        if operator is None:
            raise OperatorNeeded(
                "this arm has no switches, so somebody has to look at it: call `home()` with an "
                "operator, or bring it to a known posture and call `declare_posture()`. "
                f"{request}"
            )
        after(self._core.state, Event.HOME)
        await self._parts.runner.perform(referencing.begin_home(self._parts.wire))
        try:
            self._have_confirmed(operator, request)
            await self._confirm_posture(request.joints, request.opening_mm, Evidence.HOMED)
        except BaseException:
            await self._leave_homing()
            raise
        return self._parts.pose

    @property
    def homes_by_switches(self) -> bool:
        """Whether `home` moves the arm: its file says where its controller's own homing ends."""
        return self._config.homing is not None and self._core.controller.abilities.own_homing

    @property
    def homing_groups(self) -> tuple[tuple[str, ...], ...]:
        """The names of the motors that home by switches, in their order; empty: the device's."""
        names = [motor.name for motor in self._core.transmission.motors]
        groups = () if self._config.homing is None else self._config.homing.groups
        return tuple(tuple(names[motor - 1] for motor in group) for group in groups)

    async def _home_by_switches(self, homing: HomingSettings, told: Told) -> Pose:
        wire, runner = self._parts.wire, self._parts.runner
        with self._parts.pace.lock:
            after(self._core.state, Event.HOME)
            names = self.homing_groups
            body = referencing.home_device(wire, homing, lambda group: told(names[group]))
            task = runner.submit(body, alone=True)
        await runner.finish(task, HOMING_PATIENCE_S)
        return self._parts.pose

    def _have_confirmed(self, operator: Operator, request: PostureRequest) -> None:
        """Raise unless the operator confirms the posture and nobody has stopped meanwhile."""
        confirmed = operator(request)
        if self._core.state is not State.HOMING:
            raise Stopped("homing was stopped: nothing was referenced")
        if not confirmed:
            raise OperatorNeeded(
                f"the posture was not confirmed: nothing was referenced. {request}"
            )

    async def _leave_homing(self) -> None:
        """Stop what the operator may have left in motion, and go back to where homing began."""
        try:
            await self._parts.runner.stand_still()
        finally:
            with self._parts.pace.lock:
                self._core.settle()

    # -- declaring ------------------------------------------------------------------------------

    async def confirm_reference(self) -> None:
        """Say that the arm stands in its reference posture now."""
        request = self.request()
        after(self._core.state, Event.MOVE)
        await self._confirm_posture(request.joints, request.opening_mm, Evidence.HOMED)

    async def declare_posture(self, posture: Joints | Pose, opening_mm: float) -> None:
        """Say that the arm stands in this posture now, by joints or by pose."""
        geometry = self._config.model.arm
        joints = geometry.ik(posture) if isinstance(posture, Pose) else posture
        geometry.check(joints)
        after(self._core.state, Event.MOVE)
        await self._confirm_posture(joints, finite("opening_mm", opening_mm), Evidence.DECLARED)

    async def confirm_restored(self) -> None:
        """Say that the arm stands as its record shows it: planned motion is allowed again."""
        trust = self._parts.status.trust
        if trust is not Trust.RESTORED:
            raise Refused(
                "there is no restored position to confirm, the position is "
                f"{trust.value}: call `home()`"
            )
        await self._parts.runner.perform(referencing.confirm_record(self._parts.wire))

    def request(self) -> PostureRequest:
        """Return the posture that a reference is taken in."""
        reference = self._config.model.reference
        if reference is None:
            way = (
                "to have it seek its switches, call `home()`"
                if self.homes_by_switches
                else "write [reference] into its arm file, or call `declare_posture()`"
            )
            raise Refused(f"no reference posture is known of the {self._config.title}: {way}")
        joints = self._config.model.arm.ik(reference.pose)
        return PostureRequest(self._arm, reference.pose, joints, reference.opening_mm)

    async def _confirm_posture(self, joints: Joints, opening_mm: float, evidence: Evidence) -> None:
        there = ArmCoordinates(joints, opening_mm)
        with self._parts.pace.lock:
            confirmed = confirmed_posture(self._core, there, evidence, self._parts.pace.now_s())
        await self._parts.runner.perform(take_reference(self._parts.wire, confirmed))

    # -- verifying ------------------------------------------------------------------------------

    async def verify(
        self, operator: Operator | None, accept: Accept, speed: float, logbook: Path | None
    ) -> Verified:
        """Measure how far the registers are from the reference; see `Arm.verify`.

        What was found is written into the `logbook`, which also tells what was found before.
        """
        mark = self.request()
        request = MarkRequest(mark.arm, mark.pose, mark.joints, mark.opening_mm)
        if operator is None:
            raise OperatorNeeded(
                "somebody has to bring the finger tips onto the mark: call `verify()` with an "
                "operator"
            )
        reference = self._core.belief.reason
        await finished(self._moving.start(ParkMove(speed, above_mark(self._config))))
        after(self._core.state, Event.HOME)
        await self._parts.runner.perform(referencing.begin_home(self._parts.wire))
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
        position = await self._parts.runner.perform(verifying.read_at_mark(self._parts.wire))
        transmission = self._core.transmission
        truth = ArmCoordinates(request.joints, request.opening_mm).motors(transmission)
        drift = drift_between(self._config.model, position, truth)
        verdict = judge(drift, reference)
        note = AGAIN if verdict is Verdict.DRIFT and self._came_before(drift, logbook) else ""
        found = Verified(verdict, drift, accepted=False, found=drift.words(transmission), note=note)
        if not drift.steps.largest or not _taken(found, accept):
            return found
        return replace(found, accepted=True)

    def _came_before(self, drift: Drift, logbook: Path | None) -> bool:
        """Tell whether the last verification found the same, and was taken for the reference."""
        if logbook is None:
            return False
        last = last_entry(logbook, self._config.calibration) or {}
        return bool(last.get("accepted")) and last.get("steps") == list(drift.steps)

    async def _conclude(self, request: MarkRequest, verified: Verified) -> None:
        if verified.accepted:
            await self._confirm_posture(request.joints, request.opening_mm, Evidence.HOMED)
        elif verified.verdict is Verdict.ROUNDING:
            await self._parts.runner.perform(verifying.believe_mark(self._parts.wire))
        else:
            await self._parts.runner.perform(
                verifying.doubt_position(self._parts.wire, verified.found)
            )

    def _written(self, verified: Verified, reference: str, logbook: Path | None) -> Verified:
        """Write it down; a disk that does not take it is a note, since the arm is measured."""
        if logbook is None:
            return verified
        try:
            write_down(logbook, verified_view(verified), self._config.calibration, reference)
        except OSError as error:
            note = f"{verified.note}; it could not be written down: {error}".removeprefix("; ")
            return replace(verified, note=note)
        return verified


def _taken(found: Verified, accept: Accept) -> bool:
    """Tell whether the posture becomes the reference; nobody is asked about what is right."""
    if callable(accept):
        return found.verdict is not Verdict.ROUNDING and accept(found)
    return accept
