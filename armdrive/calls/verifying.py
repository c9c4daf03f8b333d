"""Verifying: how far the arm has drifted, found with its finger tips on the table's mark."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from armdrive.calls.moving import Moving
from armdrive.calls.referencing import Referencing
from armdrive.drift import Drift, Verdict, Verified, drift_between, judge
from armdrive.errors import OperatorNeeded
from armdrive.flows import referencing, verifying
from armdrive.logbook import last_entry, write_down
from armdrive.posture import MarkRequest, Operator
from armdrive.states import Event, after
from armdrive.trust import Evidence

Accept = bool | Callable[[Verified], bool]

AGAIN = (
    "as much as the last time: slack or wrong numbers in the arm file rather than lost steps, "
    "which differ from time to time"
)


class Verifying(Moving, Referencing):
    """The call that compares the position with the world."""

    logbook: Path | None = None
    """Where verifications are written down; None of a simulated arm that nobody remembers."""

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
            write_down(self.logbook, verified, self.config.calibration, reference)
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
