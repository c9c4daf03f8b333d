"""How somebody tells the arm where it is. None of these calls moves it by itself."""

from __future__ import annotations

from collections.abc import Callable

from armdrive.arm.jogging import JogCalls
from armdrive.arm.moving import MoveCalls
from armdrive.config.sections import HomingSettings
from armdrive.dialog import MarkRequest, Operator, PostureRequest
from armdrive.errors import OperatorNeeded, Refused, Stopped
from armdrive.motion import reference as referencing
from armdrive.motion import verify as verifying
from armdrive.motion.reference import take_reference, vouched
from armdrive.motion.verify import Drift, Verdict, Verified, drift_between, judge, verified_view
from armdrive.runtime.position import ArmCoordinates
from armdrive.runtime.states import Event, after
from armdrive.status import Evidence, State, Trust
from armdrive.storage.verifications import last_entry, write_down
from kinematics.errors import finite
from kinematics.spaces import Joints, Pose

Told = Callable[[tuple[str, ...]], None]


def unheard(_: tuple[str, ...]) -> None:
    """Nobody wants to hear which motors have been homed."""


HOMING_PATIENCE_S = 300.0
"""A homing that takes longer is stopped."""


class ReferenceCalls(MoveCalls, JogCalls):
    """The calls that give the position its meaning."""

    def home(self, *, operator: Operator | None = None, told: Told = unheard) -> Pose:
        """Take the reference posture, which an operator has to confirm; return its pose.

        An arm whose file has a `[homing]` section, on a device that homes by its own switches,
        **moves**: the device seeks its switches. Any other needs somebody who looks: `operator`
        is called with a `PostureRequest`, may jog the arm, and returns True when it stands there.
        Without one, `OperatorNeeded`. A simulated arm has a simulated operator. `told` is called by
        the engine's thread with the names of each group of motors that has found its switches; it
        must not wait for anything.
        """
        if self.config.homing is not None and self.homes_by_switches:
            return self._home_by_switches(self.config.homing, told)
        operator = operator or self.operator
        request = self.reference_request()
        if operator is None:
            raise OperatorNeeded(
                "this arm has no switches, so somebody has to look at it: call `home()` with an "
                "operator, or bring it to a known posture and call `declare_posture()`. "
                f"{request}"
            )
        after(self.core.state, Event.HOME)
        self.perform(referencing.begin_home(self.wire))
        try:
            self._have_confirmed(operator, request)
            self._vouch(request.joints, request.opening_mm, Evidence.HOMED)
        except BaseException:
            self._leave_homing()
            raise
        return self.pose

    @property
    def homes_by_switches(self) -> bool:
        """Whether `home` moves the arm: its file says where its controller's own homing ends."""
        return self.config.homing is not None and self.abilities.own_homing

    @property
    def homing_groups(self) -> tuple[tuple[str, ...], ...]:
        """The names of the motors that home by switches, in their order; empty: the device's."""
        names = [motor.name for motor in self.core.transmission.motors]
        groups = () if self.config.homing is None else self.config.homing.groups
        return tuple(tuple(names[motor - 1] for motor in group) for group in groups)

    def _home_by_switches(self, homing: HomingSettings, told: Told) -> Pose:
        with self.pace.lock:
            after(self.core.state, Event.HOME)
            names = self.homing_groups
            flow = referencing.home_device(self.wire, homing, lambda group: told(names[group]))
            task = self.submit(flow, alone=True)
        self.finish(task, HOMING_PATIENCE_S)
        return self.pose

    def _have_confirmed(self, operator: Operator, request: PostureRequest) -> None:
        """Raise unless the operator confirms the posture and nobody has stopped meanwhile."""
        confirmed = operator(request)
        if self.core.state is not State.HOMING:
            raise Stopped("homing was stopped: nothing was referenced")
        if not confirmed:
            raise OperatorNeeded(
                f"the posture was not confirmed: nothing was referenced. {request}"
            )

    def _leave_homing(self) -> None:
        """Stop what the operator may have left in motion, and go back to where homing began."""
        try:
            self.stand_still()
        finally:
            with self.pace.lock:
                self.core.settle()

    def confirm_reference(self) -> None:
        """Say that the arm stands in its reference posture now."""
        request = self.reference_request()
        after(self.core.state, Event.MOVE)
        self._vouch(request.joints, request.opening_mm, Evidence.HOMED)

    def declare_posture(self, posture: Joints | Pose, *, opening_mm: float = 0.0) -> None:
        """Say that the arm stands in this posture now, by joints or by pose."""
        joints = self.model.arm.ik(posture) if isinstance(posture, Pose) else posture
        self.model.arm.check(joints)
        after(self.core.state, Event.MOVE)
        self._vouch(joints, finite("opening_mm", opening_mm), Evidence.DECLARED)

    def confirm_restored(self) -> None:
        """Say that the arm stands as its record shows it: planned motion is allowed again."""
        if self.status.trust is not Trust.RESTORED:
            raise Refused(
                "there is no restored position to confirm, the position is "
                f"{self.status.trust.value}: call `home()`"
            )
        self.perform(referencing.confirm_record(self.wire))

    def reference_request(self) -> PostureRequest:
        """Return the posture that a reference is taken in."""
        reference = self.model.reference
        if reference is None:
            way = (
                "to have it seek its switches, call `home()`"
                if self.homes_by_switches
                else "write [reference] into its arm file, or call `declare_posture()`"
            )
            raise Refused(f"no reference posture is known of the {self.config.title}: {way}")
        joints = self.model.arm.ik(reference.pose)
        return PostureRequest(self, reference.pose, joints, reference.opening_mm)

    def _vouch(self, joints: Joints, opening_mm: float, evidence: Evidence) -> None:
        there = ArmCoordinates(joints, opening_mm)
        with self.pace.lock:
            word = vouched(self.core, there, evidence, self.pace.now_s())
        self.perform(take_reference(self.wire, word))


# Verifying: how far the arm has drifted, found with its finger tips on the table's mark.

Accept = bool | Callable[[Verified], bool]

AGAIN = (
    "as much as the last time: slack or wrong numbers in the arm file rather than lost steps, "
    "which differ from time to time"
)


class VerifyCalls(ReferenceCalls):
    """The call that compares the position with the world."""

    def verify(
        self, *, operator: Operator | None = None, accept: Accept = False, speed: float = 0.5
    ) -> Verified:
        """Measure how far the registers are from what the reference posture should read.

        **Moves** above the reference mark, planned, and then as the operator jogs: he is called
        with a `MarkRequest`, brings the finger tips onto the mark and returns True. With `accept`,
        or where it returns True for what was found, the posture becomes the new reference; else a
        position that is off is suspect from then on. Raises `NotReferenced` where there is no
        position to verify, and `OperatorNeeded` where nobody looks or confirms.
        """
        operator = operator or self.operator
        mark = self.reference_request()
        request = MarkRequest(mark.arm, mark.pose, mark.joints, mark.opening_mm)
        if operator is None:
            raise OperatorNeeded(
                "somebody has to bring the finger tips onto the mark: call `verify()` with an "
                "operator"
            )
        reference = self.core.belief.reason
        self.go_over(self.above_mark(), speed)
        after(self.core.state, Event.HOME)
        self.perform(referencing.begin_home(self.wire))
        try:
            self._have_confirmed(operator, request)
            verified = self._measured(request, reference, accept)
            self._conclude(request, verified)
        except BaseException:
            self._leave_homing()
            raise
        return self._written(verified, reference)

    def _measured(self, request: MarkRequest, reference: str, accept: Accept) -> Verified:
        position = self.perform(verifying.read_at_mark(self.wire))
        transmission = self.core.transmission
        truth = transmission.to_motors(request.joints, request.opening_mm)
        drift = drift_between(self.model, position, truth)
        verdict = judge(drift, reference)
        note = AGAIN if verdict is Verdict.DRIFT and self._came_before(drift) else ""
        found = Verified(verdict, drift, accepted=False, found=drift.words(transmission), note=note)
        if not drift.steps.largest or not _taken(found, accept):
            return found
        return Verified(verdict, drift, accepted=True, found=found.found, note=note)

    def _came_before(self, drift: Drift) -> bool:
        """Tell whether the last verification found the same, and was taken for the reference."""
        if self.logbook is None:
            return False
        last = last_entry(self.logbook, self.config.calibration) or {}
        return bool(last.get("accepted")) and last.get("steps") == list(drift.steps)

    def _conclude(self, request: MarkRequest, verified: Verified) -> None:
        if verified.accepted:
            self._vouch(request.joints, request.opening_mm, Evidence.HOMED)
        elif verified.verdict is Verdict.ROUNDING:
            self.perform(verifying.believe_mark(self.wire))
        else:
            self.perform(verifying.doubt_position(self.wire, verified.found))

    def _written(self, verified: Verified, reference: str) -> Verified:
        """Write it down; a disk that does not take it is a note, since the arm is measured."""
        if self.logbook is None:
            return verified
        try:
            write_down(self.logbook, verified_view(verified), self.config.calibration, reference)
        except OSError as error:
            note = f"{verified.note}; it could not be written down: {error}".removeprefix("; ")
            return Verified(
                verified.verdict, verified.drift, verified.accepted, verified.found, note
            )
        return verified


def _taken(found: Verified, accept: Accept) -> bool:
    """Tell whether the posture becomes the reference; nobody is asked about what is right."""
    if callable(accept):
        return found.verdict is not Verdict.ROUNDING and accept(found)
    return accept
