"""The state of one arm, and the only place where it changes.

Only the engine's tasks (armdrive/motion) change the state; all others read the frozen `Status`.
The position ledger is in position.py. Three things change independently of one another:

- the state of the state machine: `happen` applies an event, by the table in states.py;
- the trust in the position: `learn` applies evidence;
- what the operator reads: `notify` and `report` show notices.

`fault` latches error-stop and shows its cause. It leaves the trust alone: an emergency stop of an
idle arm casts no doubt on its position. Whatever does is learned as well.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import Controller
from armdrive.errors import ArmError, NoAnswer, Refused, SettingsDiffer, StateFileError
from armdrive.errors.table import entry, entry_of, named
from armdrive.moves import ContinuousJog, IncrementalJog
from armdrive.registry import dialect
from armdrive.runtime.backlash import doubt_words
from armdrive.runtime.engine import Engine
from armdrive.runtime.overrides import SpeedOverride
from armdrive.runtime.persistence import Memory
from armdrive.runtime.position import (
    DeviceReadings,
    FingerState,
    MotionSegment,
    PositionLedger,
    motors_of,
)
from armdrive.runtime.states import (
    ALERTED,
    FIRST_BELIEF,
    PLANNED_MOTION,
    UNPOWERED,
    Belief,
    Event,
    after,
    require_reference,
)
from armdrive.runtime.stop_bounds import StopBound, StopForecast
from armdrive.status import (
    IN_MOTION,
    Current,
    Evidence,
    SchedulingJitter,
    State,
    Status,
    Trust,
    coded,
)
from armdrive.storage.record import Record, RecordStore
from armdrive.tasks import Alert, AlertKind, Difference, listed
from armdrive.trace.entries import EntryCondition
from armdrive.trace.recorder import FlightRecorder
from kinematics.spaces import Motors

# The error and the notice in the status.

# The code of a fault that is reported as text only.
FAULT = named("DeviceFault").code

EMERGENCY_STOP = named("EMERGENCY_STOP").code
WRONG_STATE = named("WrongState").code
RECONNECTED = named("RECONNECTED").code
ALARM_VOUCHED = named("ALARM_VOUCHED").code
LOCKED = named("LOCKED").code


def code_of(cause: BaseException | Evidence) -> str:
    """Return the code of an error or an evidence, or an empty string."""
    row = entry_of(cause) if isinstance(cause, Evidence) else entry(cause)
    return "" if row is None else row.code


@dataclass(frozen=True, slots=True)
class Message:
    """An error or a notice for the operator, and its code if it reports a problem."""

    words: str = ""
    code: str = ""

    def __str__(self) -> str:
        return coded(self.words, self.code)


class Core:
    """The state of one arm. The engine's tasks change it, under the pace's lock.

    Raises `Refused` if the arm's motors do not fit its controller.
    """

    def __init__(
        self,
        config: ArmConfig,
        controller: Controller,
        tracer: FlightRecorder,
        record_store: RecordStore,
        wake: Callable[[], None] | None = None,
    ) -> None:
        self.config = config
        self.controller = controller
        self.transmission = motors_of(config, controller)
        self.error = Message()
        """Why the arm is in error-stop, or why its link is lost."""
        self._notices: dict[str, str] = {}
        """The messages for the operator, by their codes: see `notify` and `report`."""
        self.notices = 0
        """Number of notices so far, also in the same words, and of those that were withdrawn."""
        self.readings = DeviceReadings(controller.abilities)
        self.fingers = FingerState(config, self.transmission)
        self.position = PositionLedger(
            self.transmission,
            config.backlash_steps,
            self._unwrap,
            self.readings,
            self.fingers,
        )
        self.stops = StopForecast(config, self.transmission)
        self.speed_override = SpeedOverride()
        self.memory = Memory(record_store, self.record, wake)
        self.tracer = tracer
        self.allow_restored = False
        self.geometry_known = config.model.verified
        self.state = State.DISCONNECTED
        self.before_loss = State.DISCONNECTED
        self.latched = Message()
        self.belief: Belief = FIRST_BELIEF
        self.hold: ContinuousJog | None = None
        self.holds = 0
        """Number of requests to start or continue a held jog."""
        self.nudges: list[IncrementalJog] = []
        self.still_since_s = 0.0
        self.differences: tuple[Difference, ...] = ()

    def _unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Undo the wrap of registers. Reconnecting replaces the controller, so look it up."""
        return self.controller.unwrap(registers, near)

    # -- events -------------------------------------------------------------------------------

    def happen(self, event: Event) -> None:
        """Apply an event to the state machine; raises `WrongState` if it is not allowed."""
        before, self.state = self.state, after(self.state, event)
        if self.state is not before:
            self.withdraw(WRONG_STATE)  # only the state before explains it
        self.tracer.changed()

    def settle(self) -> None:
        """End a motion, unless a fault or the loss of the link has already changed the state."""
        self.stops.end()
        if self.state in IN_MOTION:
            self.happen(Event.DONE)

    def fault(self, cause: str | ArmError, code: str = FAULT) -> None:
        """Latch error-stop with its cause, and drop the jogs that have not begun."""
        code = code_of(cause) if isinstance(cause, ArmError) else code
        self.error = Message(str(cause), code)
        self._drop_pending()
        if self.state is State.DISCONNECTED:  # kept until the link is back: see `lose`
            self.latched = self.error
        else:
            self.happen(Event.FAULT)

    def lose(self, lost: ArmError) -> None:
        """Record the loss of the link, and drop the jogs that have not begun."""
        if self.state is not State.DISCONNECTED:
            self.before_loss = self.state
            self.latched = self.error if self.state is State.ERROR_STOP else Message()
            self.withdraw()  # they were about a link that worked
        self.error = Message(str(lost), code_of(lost))
        self._drop_pending()
        self.happen(Event.LOST)

    def lost_in_motion(self, now_s: float) -> None:
        """Record that the link was lost during a motion: the device finishes what it was sent."""
        self.stops.cut_off()
        self.learn(Evidence.LOST_IN_MOTION, now_s)

    def _drop_pending(self) -> None:
        self.hold = None
        self.nudges.clear()
        self.speed_override.end_pause()

    def learn(self, evidence: Evidence, now_s: float, detail: str = "") -> None:
        """Apply evidence to the trust in the position and the current; save a changed trust."""
        if evidence in UNPOWERED:
            self.readings.current = Current.UNKNOWN
        before = self.belief
        self.belief = before.after(evidence, now_s, detail)
        if self.belief is not before:
            self.remember()
            self.tracer.changed()

    def require_reference(self, what: str = PLANNED_MOTION) -> None:
        """Raise `NotReferenced`, which begins with `what`, unless planned motion is allowed."""
        require_reference(self.belief, allow_restored=self.allow_restored, what=what)

    def require_geometry(self) -> None:
        """Raise `Refused` if the arm's lengths and steps are unverified template values."""
        if not self.geometry_known:
            raise Refused(
                f"the lengths and steps of the {self.config.model.title} are unverified template "
                "values, so a Cartesian goal would be wrong. Measure the arm and enter every key "
                "of [lengths] and [steps_per_turn] in its arm file (`armdrive config show NAME` "
                "prints the template's values, which count only once they are measured), or set "
                "verified = true in its model file. Moving single joints works as it is"
            )

    def require_settings(self, *, homing: bool = False) -> None:
        """Raise `SettingsDiffer` while settings of the controller forbid moving, or homing."""
        wrong = [each for each in self.differences if each.must or (homing and each.homes)]
        if wrong:
            sends = any(each.fix for each in wrong)
            remedy = "`armdrive doctor --fix` sends these lines. " if sends else ""
            raise SettingsDiffer(
                f"the arm does not {'home' if homing else 'move'} while the controller's settings "
                "differ from the arm file: "
                f"{listed(wrong)}. {remedy}A simulated arm starts over with `--fresh`"
            )

    @property
    def position_known(self) -> bool:
        """Whether soft limits and Cartesian coordinates are meaningful."""
        return self.belief.allows_planning(allow_restored=self.allow_restored)

    @property
    def current(self) -> Current:
        """Whether the motors hold the arm, which nobody knows while the device does not answer."""
        silent = self.state is State.DISCONNECTED or self.error.code == NoAnswer.code
        return Current.UNKNOWN if silent else self.readings.current

    @property
    def seen(self) -> Motors:
        """The position to display: read back if a reporting device has not confirmed a motion.

        It stays there if the motion's end is never confirmed, as after the loss of the link.
        """
        position, reports = self.position, self.controller.abilities.reports_while_moving
        underway = self.state is State.HOMING or position.commanded != position.acknowledged
        if underway and reports and position.read_back is not None:
            return position.read_back
        return position.acknowledged

    # -- notices ------------------------------------------------------------------------------
    #
    # An event replaces all notices: only the latest counts. What is found out about the arm, such
    # as a locked device or settings that differ, is true beside them, and replaces only what was
    # found out about the same. A motion, a reset and a reference begin without notices.

    @property
    def notice(self) -> Message:
        """All notices, with the code of the first."""
        (code, words), *others = self._notices.items() or [("", "")]
        more = (coded(other, its_code) for its_code, other in others)
        return Message(". ".join([words.rstrip(".") if others else words, *more]), code)

    def notify(self, words: str, cause: BaseException | Evidence | None = None) -> None:
        """Show an event, if it has words, in place of all notices, with the code of its cause."""
        self.withdraw()
        if words:
            self.report(words, "" if cause is None else code_of(cause))

    def report(self, words: str, code: str) -> None:
        """Show something found out about the arm beside the notices of other codes."""
        self.notices += 1
        self._notices[code] = words

    def withdraw(self, *codes: str) -> None:
        """Withdraw the notices with these codes; without codes, all of them."""
        for code in codes or tuple(self._notices):
            if self._notices.pop(code, None) is not None:
                self.notices += 1

    def clear_messages(self) -> None:
        """Clear error and notices at a reference; tell of backlash that the reference left open."""
        self.error = Message()
        names = [motor.name for motor in self.transmission.motors]
        self.notify(doubt_words(names, self.position.slack))

    # -- the position record ------------------------------------------------------------------

    def mark_still(self) -> None:
        """Save the position of an arm at rest, and remove the motion mark."""
        self.memory.mark_still()
        self.report_write_errors()

    def remember(self) -> None:
        """Save the present position and trust; a motion mark stays."""
        self.memory.remember()
        self.report_write_errors()

    def report_write_errors(self) -> None:
        """Show in a notice why the position or a recording could not be written, if so."""
        if trouble := self.memory.trouble():
            self.report(trouble, StateFileError.code)
        if trouble := self.tracer.files.take_trouble():
            self.report(trouble, "")

    def record(self, in_motion: bool) -> Record:
        """Return the record of this moment."""
        position = self.position
        return Record(
            arm=self.config.name,
            calibration=self.config.calibration,
            offset=position.offset,
            registers=position.expected,
            taken=position.slack.taken if position.slack.any else (),
            unsure=position.slack.unsure,
            coordinates=position.coordinates.values,
            trust=self.belief.trust.value,
            reason=self.belief.reason,
            in_motion=in_motion,
        )

    # -- views --------------------------------------------------------------------------------

    def condition(self) -> EntryCondition:
        """Return the condition whose changes the flight recorder notes."""
        return EntryCondition(
            self.position.shift,
            self.state,
            (self.belief.trust, self.belief.reason, self.belief.since_s),
            self.current,
            str(self.notice),
            str(self.error),
        )

    def stop_bound(self) -> StopBound:
        """Return how long and how far the tip moves on after a stop at this moment."""
        known = self.belief.trust is not Trust.UNKNOWN
        joints = self.position.coordinates.joints if known else None
        lost = self.state is State.DISCONNECTED
        return self.stops.bound(
            self.controller, joints, lost=lost, slowed=self.speed_override.was_slowed
        )

    def plans(self, legs: Iterable[MotionSegment], burst_s: float) -> None:
        """Base the stop bound on a planned motion until `settle`, or until the motion is slowed."""
        self.speed_override.begin()
        self.stops.plan(self.controller, legs, burst_s)

    def status(
        self, engine: Engine, *, simulated: bool, scheduling_jitter: SchedulingJitter
    ) -> Status:
        """Return the status at this moment."""
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
            gripper_mm=self.fingers.seen_mm(opening_mm) if known else None,
            gripping=self.readings.gripping,
            commanded=self.position.commanded,
            acknowledged=self.position.acknowledged,
            read_back=self.position.read_back,
            inputs=self.readings.inputs,
            outputs=self.readings.outputs,
            stop_time_s=bound.time_s,
            stop_distance_mm=bound.distance_mm,
            silent_time_s=bound.silent_time_s,
            silent_distance_mm=bound.silent_distance_mm,
            last_sent=engine.last_sent,
            last_answer=engine.last_answer,
            notice=self.notice.words,
            error=self.error.words,
            error_code=self.error.code,
            notice_code=self.notice.code,
            notices=self.notices,
            torque=dialect(self.config.connection.dialect).torque,
            time_s=engine.now_s,
            paused=self.speed_override.paused,
            speed_override=self.speed_override.override,
            scheduling_jitter=scheduling_jitter,
            underruns=self.controller.underruns,
        )


def alerted(core: Core, alert: Alert, now_s: float) -> None:
    """Latch error-stop with the device's message, and apply its evidence to the position.

    That a device was found locked is only a notice: it is no fault of this session, the device
    refuses any motion, and some devices start locked each time.
    """
    if alert.kind is AlertKind.LOCKED:
        core.report(alert.text, LOCKED)
        return
    evidence = ALERTED[alert.kind]
    if evidence is not None:
        core.learn(evidence, now_s, alert.text)
    code = ALARM_VOUCHED if evidence is None else code_of(evidence)
    core.fault(f"{alert.text}. Look at the arm, then call `reset()`", code)
