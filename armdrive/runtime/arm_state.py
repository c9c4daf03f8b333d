"""All that is known of one arm, and the only place where it changes.

The engine's tasks (armdrive/motion) are its only writers; everybody else reads the frozen
`Status` it makes. What becomes of its position is in position.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from armdrive.config.arm import ArmConfig
from armdrive.dialects.controller import Controller
from armdrive.errors import ArmError, Refused, SettingsDiffer, StateFileError
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
from armdrive.runtime.states import FIRST_BELIEF, Belief, Event, after, require_reference
from armdrive.runtime.stop_bounds import StopBound, StopForecast
from armdrive.status import Evidence, LinkStats, SchedulingJitter, State, Status, Trust, coded
from armdrive.storage.record import PositionRecorder, Record
from armdrive.tasks import Difference
from armdrive.trace.calls import NO_TRACER, Tracer
from armdrive.trace.entries import EntryCondition
from kinematics.spaces import Motors

# What the status says beside its numbers: an error and a notice, each with its code. Words that are
# put down without a code have none: words and code never come apart.

FAULT = named("DeviceFault").code
"""The code of a fault that is reported in words alone."""

EMERGENCY_STOP = named("EMERGENCY_STOP").code
RECONNECTED = named("RECONNECTED").code
ALARM_VOUCHED = named("ALARM_VOUCHED").code


def code_of(cause: BaseException | Evidence) -> str:
    """Return the code of an error or of an evidence; empty where it has none."""
    row = entry_of(cause) if isinstance(cause, Evidence) else entry(cause)
    return "" if row is None else row.code


class Diagnostics:
    """The error and the notice of one arm."""

    def __init__(self) -> None:
        self._error = self._notice = ("", "")

    @property
    def error(self) -> str:
        """Why the arm is in error-stop, or why its wire is lost."""
        return self._error[0]

    @error.setter
    def error(self, words: str) -> None:
        self._error = (words, "")

    @property
    def error_code(self) -> str:
        """The catalogue's code of the error."""
        return self._error[1]

    @property
    def notice(self) -> str:
        """What somebody should know."""
        return self._notice[0]

    @notice.setter
    def notice(self, words: str) -> None:
        self._notice = (words, "")

    @property
    def notice_code(self) -> str:
        """The catalogue's code of the notice, where it is about something that went wrong."""
        return self._notice[1]

    def say_error(self, words: str, code: str) -> None:
        """Put an error down with its code."""
        self._error = (words, code)

    def notify(self, words: str, cause: BaseException | Evidence) -> None:
        """Put a notice down with the code of its cause."""
        self._notice = (words, code_of(cause))


class Core:
    """One arm's state. Touched under the pace's lock, by the engine's tasks.

    Raises `Refused` for an arm whose motors do not fit its controller.
    """

    def __init__(
        self,
        config: ArmConfig,
        controller: Controller,
        recorder: PositionRecorder | None = None,
        wake: Callable[[], None] | None = None,
    ) -> None:
        self.config = config
        self.controller = controller
        self.transmission = motors_of(config, controller)
        self.diagnostics = Diagnostics()
        self.readings = DeviceReadings(grip_switch=controller.abilities.grip_switch)
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
        self.memory = Memory(recorder, self.record, wake)
        self.tracer: Tracer = NO_TRACER
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
        self.differences: tuple[Difference, ...] = ()

    def _unwrap(self, registers: Motors, near: Motors) -> Motors:
        """Undo the registers' wrap by the controller of now: a mended wire brings another one."""
        return self.controller.unwrap(registers, near)

    # -- what happens -------------------------------------------------------------------------

    def happen(self, event: Event) -> None:
        """Follow the table of states; raises `WrongState` where it has no such row."""
        self.state = after(self.state, event)
        self.tracer.changed()

    def settle(self) -> None:
        """End a motion, unless a fault or a loss has taken the state elsewhere meanwhile."""
        self.stops.end()
        if self.state in (State.MOVING, State.HOMING, State.STOPPING):
            self.happen(Event.DONE)

    def fault(self, cause: str | ArmError, code: str = FAULT) -> None:
        """Latch error-stop and say why; what was asked for and not begun is forgotten."""
        code = code_of(cause) if isinstance(cause, ArmError) else code
        self.diagnostics.say_error(str(cause), code)
        self._forget_what_waits()
        if self.state is State.DISCONNECTED:
            self.latched = (self.diagnostics.error, self.diagnostics.error_code)
        else:
            self.happen(Event.FAULT)

    def lose(self, lost: ArmError) -> None:
        """Note that the wire is gone, and with it all that was asked for and not begun."""
        if self.state is not State.DISCONNECTED:
            self.before_loss = self.state
            faulty = self.state is State.ERROR_STOP
            said = self.diagnostics
            self.latched = (said.error, said.error_code) if faulty else ("", "")
        self.diagnostics.say_error(str(lost), code_of(lost))
        self._forget_what_waits()
        self.happen(Event.LOST)

    def lost_in_motion(self, now_s: float) -> None:
        """Note that the wire was lost while the arm moved: what it was sent runs on."""
        self.stops.cut_off()
        self.learn(Evidence.LOST_IN_MOTION, now_s)

    def _forget_what_waits(self) -> None:
        self.hold = None
        self.nudges.clear()
        self.speed_override.end_pause()

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
        if reporting and self.position.read_back is not None:
            return self.position.read_back
        return self.position.acknowledged

    def clear_remarks(self) -> None:
        """Forget what was remarked before a reference; a doubt about it is a remark of its own."""
        self.diagnostics.error = ""
        names = [motor.name for motor in self.transmission.motors]
        self.diagnostics.notice = doubt_words(names, self.position.slack)

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
            self.diagnostics.notify(trouble, StateFileError(trouble))

    def record(self, in_motion: bool) -> Record:
        """Return what there is to be remembered of this moment."""
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

    # -- what is shown ------------------------------------------------------------------------

    def condition(self) -> EntryCondition:
        """Return what a flight recorder notes whenever it has changed."""
        return EntryCondition(
            self.position.shift,
            self.state,
            (self.belief.trust, self.belief.reason, self.belief.since_s),
            self.readings.current,
            coded(self.diagnostics.notice, self.diagnostics.notice_code),
            coded(self.diagnostics.error, self.diagnostics.error_code),
        )

    def stop_bound(self) -> StopBound:
        """Return how long and how far the tip goes on if a stop is asked for now."""
        known = self.belief.trust is not Trust.UNKNOWN
        joints = self.position.coordinates.joints if known else None
        lost = self.state is State.DISCONNECTED
        return self.stops.bound(
            self.controller, joints, lost=lost, slowed=self.speed_override.was_slowed
        )

    def plans(self, legs: Iterable[MotionSegment], burst_s: float) -> None:
        """Announce from now on how a planned motion ends, until `settle`.

        Where it is slowed meanwhile, it is no longer the motion that was planned.
        """
        self.speed_override.begin()
        self.stops.plan(self.controller, legs, burst_s)

    def status(
        self, engine: Engine, *, simulated: bool, scheduling_jitter: SchedulingJitter
    ) -> Status:
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
            current=self.readings.current,
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
            notice=self.diagnostics.notice,
            error=self.diagnostics.error,
            error_code=self.diagnostics.error_code,
            notice_code=self.diagnostics.notice_code,
            torque=dialect(self.config.connection.dialect).torque,
            time_s=engine.now_s,
            paused=self.speed_override.paused,
            speed_override=self.speed_override.override,
            scheduling_jitter=scheduling_jitter,
            underruns=self.controller.underruns,
            link_stats=LinkStats(
                engine.bytes_sent, engine.bytes_heard, self.config.connection.baud
            ),
        )
