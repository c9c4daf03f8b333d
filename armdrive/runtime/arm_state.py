"""All that is known of one arm, and the only place where it changes.

The engine's flows (armdrive/motion) are its only writers; everybody else reads the frozen
`Status` it makes. What becomes of its position is in position.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import Controller, Stopping
from armdrive.errors import ArmError, Refused, SettingsDiffer, StateFileError
from armdrive.moves import ContinuousJog, IncrementalJog
from armdrive.registry import dialect
from armdrive.runtime.backlash import doubt_words
from armdrive.runtime.diagnostics import FAULT, Diagnostics, code_of
from armdrive.runtime.engine import Engine
from armdrive.runtime.overrides import SpeedOverride
from armdrive.runtime.persistence import Memory
from armdrive.runtime.position import MotionSegment, PositionLedger
from armdrive.runtime.states import Event, after
from armdrive.runtime.stop_bounds import RunOn, StopBound, run_on, stretches
from armdrive.runtime.trust import FIRST_BELIEF, Belief, require_reference
from armdrive.status import Evidence, LinkStats, SchedulingJitter, State, Status, Trust, coded
from armdrive.storage.record import PositionRecorder, Record
from armdrive.tasks import Difference
from armdrive.trace.calls import NO_TRACER, Tracer
from armdrive.trace.entries import EntryCondition
from kinematics.spaces import Joints, Motors


class Core(PositionLedger, Diagnostics):
    """One arm's state. Touched under the pace's lock, by the engine's flows."""

    def __init__(
        self,
        config: ArmConfig,
        controller: Controller,
        recorder: PositionRecorder | None = None,
        wake: Callable[[], None] | None = None,
    ) -> None:
        Diagnostics.__init__(self)
        PositionLedger.__init__(self, config, controller)
        self.tracer: Tracer = NO_TRACER
        self.memory = Memory(recorder, self._record, wake)
        self.allow_restored = False
        self.geometry_known = config.model.verified
        self.state = State.DISCONNECTED
        self.before_loss = State.DISCONNECTED
        self.latched = ("", "")
        self.told_early: tuple[Evidence, str] | None = None
        """The first evidence that the device gave unasked, against a record that is read later."""
        self.belief: Belief = FIRST_BELIEF
        self.hold: ContinuousJog | None = None
        self.holds = 0
        """How often somebody has asked for a held jog, or for it to go on."""
        self.nudges: list[IncrementalJog] = []
        self.still_since_s = 0.0
        self.tempo = SpeedOverride()
        self.burst_s = config.motion.jog_burst_s
        self._planned: RunOn | None = None
        """How the planned motion under way goes on when it is stopped."""
        self._unplanned: tuple[tuple[float, Stopping], RunOn] | None = None
        """The same for whatever may be commanded next, and what that was computed from."""
        self._bound: tuple[RunOn, Joints | None, StopBound] | None = None
        """The bound that was announced last: most looks find the arm where it was."""
        self.cut_off_s = 0.0
        """The longest that what was under way may last when the wire was lost."""
        self.differences: tuple[Difference, ...] = ()

    # -- what happens -------------------------------------------------------------------------

    def happen(self, event: Event) -> None:
        """Follow the table of states; raises `WrongState` where it has no such row."""
        self.state = after(self.state, event)
        self.tracer.changed()

    def settle(self) -> None:
        """End a motion, unless a fault or a loss has taken the state elsewhere meanwhile."""
        self.burst_s = self.config.motion.jog_burst_s
        self._planned = None
        if self.state in (State.MOVING, State.HOMING, State.STOPPING):
            self.happen(Event.DONE)

    def fault(self, cause: str | ArmError, code: str = FAULT) -> None:
        """Latch error-stop and say why; what was asked for and not begun is forgotten."""
        self.say_error(str(cause), code_of(cause) if isinstance(cause, ArmError) else code)
        self._forget_what_waits()
        if self.state is State.DISCONNECTED:
            self.latched = (self.error, self.error_code)
        else:
            self.happen(Event.FAULT)

    def lose(self, lost: ArmError) -> None:
        """Note that the wire is gone, and with it all that was asked for and not begun."""
        if self.state is not State.DISCONNECTED:
            self.before_loss = self.state
            faulty = self.state is State.ERROR_STOP
            self.latched = (self.error, self.error_code) if faulty else ("", "")
        self.say_error(str(lost), code_of(lost))
        self._forget_what_waits()
        self.happen(Event.LOST)

    def lost_in_motion(self, now_s: float) -> None:
        """Note that the wire was lost while the arm moved: what it was sent runs on."""
        self.cut_off_s = max(self.cut_off_s, self.burst_s)
        self.learn(Evidence.LOST_IN_MOTION, now_s)

    def _forget_what_waits(self) -> None:
        self.hold = None
        self.nudges.clear()
        self.tempo.end_pause()

    def learn(self, evidence: Evidence, now_s: float, detail: str = "") -> None:
        """Weigh evidence about the position, and remember what came of it."""
        before = self.belief
        self.belief = before.after(evidence, now_s, detail)
        if self.belief is not before:
            self.remember()
            self.tracer.changed()

    def require_reference(self) -> None:
        """Raise `NotReferenced` unless planned motion may go on."""
        require_reference(self.belief, allow_restored=self.allow_restored)

    def require_geometry(self) -> None:
        """Raise `Refused` for an arm whose lengths and steps nobody has filled in."""
        if not self.geometry_known:
            raise Refused(
                f"the numbers of the {self.config.model.title} are a template that nobody has "
                "verified, so that a Cartesian goal would lead somewhere else: measure the arm and "
                "give every key of [lengths] and [steps_per_turn] in its arm file as measured "
                "(`armdrive config show NAME --toml` prints the template's, which do not count "
                "unchanged), or say verified = true in its model file. Joints can be moved as they "
                "are"
            )

    def require_settings(self) -> None:
        """Raise `SettingsDiffer` while the device is set up for another arm than the file's."""
        wrong = [each for each in self.differences if each.must]
        if wrong:
            raise SettingsDiffer(
                "nothing moves while the controller's settings are not the arm file's: "
                + "; ".join(map(str, wrong))
                + ". `armdrive doctor --mend` sends these lines"
            )

    @property
    def position_known(self) -> bool:
        """Tell whether limits and Cartesian coordinates mean anything."""
        return self.belief.trust is Trust.REFERENCED or (
            self.belief.trust is Trust.RESTORED and self.allow_restored
        )

    @property
    def seen(self) -> Motors:
        """Where the motors are to be shown: as reported in motion, else as acknowledged."""
        moving = self.state in (State.MOVING, State.HOMING, State.STOPPING)
        reporting = moving and self.controller.abilities.reports_while_moving
        return self.read_back if reporting and self.read_back is not None else self.acknowledged

    def clear_remarks(self) -> None:
        """Forget what was remarked before a reference; a doubt about it is a remark of its own."""
        self.error = ""
        names = [motor.name for motor in self.transmission.motors]
        self.notice = doubt_words(names, self.slack)

    # -- what is remembered -------------------------------------------------------------------

    def mark_still(self) -> None:
        """Have the position of an arm that stands written, and the mark of motion taken away."""
        self.memory.mark_still()
        self.hear_memory()

    def remember(self) -> None:
        """Have what is believed now written; a mark of motion stays."""
        self.memory.remember()
        self.hear_memory()

    def hear_memory(self) -> None:
        """Show what went wrong with writing since this was last asked."""
        if trouble := self.memory.trouble():
            self.notify(trouble, StateFileError(trouble))

    def present_record(self) -> Record:
        """Return what there is to be remembered of an arm that stands."""
        return self._record(in_motion=False)

    def _record(self, in_motion: bool) -> Record:
        return Record(
            arm=self.config.name,
            calibration=self.config.calibration,
            offset=self.offset,
            registers=self.expected,
            taken=self.slack.taken if self.slack.any else (),
            unsure=self.slack.unsure,
            coordinates=(*self.coordinates.joints, self.coordinates.opening_mm),
            trust=self.belief.trust.value,
            reason=self.belief.reason,
            in_motion=in_motion,
        )

    # -- what is shown ------------------------------------------------------------------------

    def condition(self) -> EntryCondition:
        """Return what a flight recorder notes whenever it has changed."""
        return EntryCondition(
            self.shift,
            self.state,
            (self.belief.trust, self.belief.reason, self.belief.since_s),
            self.current,
            coded(self.notice, self.notice_code),
            coded(self.error, self.error_code),
        )

    def stop_bound(self) -> StopBound:
        """Return how long and how far the tip goes on if a stop is asked for now."""
        joints = self.coordinates.joints if self.belief.trust is not Trust.UNKNOWN else None
        lost = self.state is State.DISCONNECTED
        burst_s = max(self.burst_s, self.cut_off_s) if lost else self.burst_s
        planned = None if lost or self.tempo.was_slowed else self._planned
        if planned is None:
            key = burst_s, self.controller.stopping(burst_s)
            if self._unplanned is None or self._unplanned[0] != key:
                self._unplanned = key, run_on(self.config, self.controller, burst_s)
            planned = self._unplanned[1]
        if self._bound is None or self._bound[0] is not planned or self._bound[1] != joints:
            self._bound = planned, joints, planned.bound(self.config, joints)
        return self._bound[2]

    def plans(self, legs: Iterable[MotionSegment], burst_s: float) -> None:
        """Announce from now on how a planned motion ends, until `settle`.

        Where it is slowed meanwhile, it is no longer the motion that was planned.
        """
        self.burst_s = burst_s
        self.tempo.begin()
        found = stretches(self.transmission, legs)
        self._planned = run_on(self.config, self.controller, burst_s, found) if found else None

    def status(self, engine: Engine, *, simulated: bool, wakes: SchedulingJitter) -> Status:
        """Return a frozen picture of this moment."""
        known = self.belief.trust is not Trust.UNKNOWN
        joints, opening_mm = self.transmission.to_joints(self.seen)
        bound = self.stop_bound()
        return Status(
            arm=self.config.name,
            title=self.config.title,
            link=engine.link.description,
            dialect=self.config.connection.dialect,
            simulated=simulated,
            state=self.state,
            trust=self.belief.trust,
            trust_reason=self.belief.reason,
            trust_since_s=self.belief.since_s,
            current=self.current,
            joints=joints if known else None,
            pose=self.config.model.arm.fk(joints) if known else None,
            gripper_mm=self.opening_seen_mm(opening_mm) if known else None,
            gripping=self.gripping,
            commanded=self.commanded,
            acknowledged=self.acknowledged,
            read_back=self.read_back,
            inputs=self.inputs,
            outputs=self.outputs,
            stop_time_s=bound.time_s,
            stop_distance_mm=bound.distance_mm,
            silent_time_s=bound.silent_time_s,
            silent_distance_mm=bound.silent_distance_mm,
            last_sent=engine.last_sent,
            last_answer=engine.last_answer,
            notice=self.notice,
            error=self.error,
            error_code=self.error_code,
            notice_code=self.notice_code,
            torque=dialect(self.config.connection.dialect).torque,
            time_s=engine.now_s,
            paused=self.tempo.paused,
            speed_override=self.tempo.override,
            wakes=wakes,
            underruns=self.controller.underruns,
            carried=LinkStats(engine.bytes_sent, engine.bytes_heard, self.config.connection.baud),
        )
