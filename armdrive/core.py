"""All that is known of one arm, and the only place where it changes.

The engine's flows (armdrive/flows) are its only writers; everybody else reads the frozen
`Status` it makes. Positions are motor steps of the model: registers plus the reference offset.
A reference is that offset: nothing here ever asks the controller to zero its registers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from armdrive.armfile import ArmConfig
from armdrive.controllers.controller import Controller
from armdrive.controllers.requests import Difference, Registers
from armdrive.dialects import dialect
from armdrive.errors import ArmError, BadRequest, Refused, SettingsDiffer, StateFileError
from armdrive.intents import Jog
from armdrive.memory import Memory
from armdrive.record import Record, Recorder
from armdrive.recorder.witness import NO_WITNESS, Witness
from armdrive.remarks import FAULT, Remarks, code_of
from armdrive.states import Event, after
from armdrive.status import Current, State, Status, Trust
from armdrive.stopping import StopBound, stop_bound
from armdrive.tempo import Tempo
from armdrive.trust import FIRST_BELIEF, Belief, Evidence, require_reference
from kinematics import Joints, Motors, Transmission


@dataclass(frozen=True, slots=True)
class Coordinates:
    """Where the arm is meant to be, before rounding to steps: joints and gripper opening."""

    joints: Joints
    opening_mm: float

    def towards(self, other: Coordinates, fraction: float) -> Coordinates:
        """Return the point at a fraction of the straight way in joint space."""
        if fraction >= 1.0:
            return other
        angles = (a + (b - a) * fraction for a, b in zip(self.joints, other.joints, strict=True))
        opening_mm = self.opening_mm + (other.opening_mm - self.opening_mm) * fraction
        return Coordinates(Joints(tuple(angles), self.joints.names), opening_mm)


@dataclass(frozen=True, slots=True)
class Hold:
    """A jog that somebody holds, until when, and how fast."""

    jog: Jog
    speed: float
    until_s: float

    def __post_init__(self) -> None:
        for name, share in self.jog.axes:
            if not -1.0 <= share <= 1.0:
                raise BadRequest(f"a held jog goes in directions from -1 to 1, not {name}={share}")


class Core(Remarks):
    """One arm's state. Touched under the pace's lock, by the engine's flows."""

    def __init__(
        self,
        config: ArmConfig,
        controller: Controller,
        recorder: Recorder | None = None,
        wake: Callable[[], None] | None = None,
    ) -> None:
        super().__init__()
        if config.model.transmission is None:
            raise Refused(
                f"no motor steps are known of the {config.model.title}: give steps_per_turn in "
                "an arm file of a model that has motors"
            )
        motors = len(config.model.transmission.motors)
        if motors != controller.abilities.motors:
            raise Refused(
                f"the {config.title} has {motors} motors, but its controller drives "
                f"{controller.abilities.motors}: list every motor of the controller in the arm file"
            )
        self.config = config
        self.controller = controller
        self.witness: Witness = NO_WITNESS
        self.transmission: Transmission = config.model.transmission
        self.memory = Memory(recorder, self._record, wake)
        self.allow_restored = False
        self.geometry_known = config.model.verified
        self.state = State.DISCONNECTED
        self.before_loss = State.DISCONNECTED
        self.latched = ("", "")
        self.belief: Belief = FIRST_BELIEF
        self.current = Current.UNKNOWN
        still = Motors([0] * controller.abilities.motors)
        self.offset = still
        self.commanded = still
        self.acknowledged = still
        self.read_back: Motors | None = None
        self.coordinates = self.coordinates_of(still)
        self.inputs: int | None = None
        self.outputs: int | None = None
        self.gripping: bool | None = None
        self.touch_mm: float | None = None
        self.gripper_share: float | None = None
        self.hold: Hold | None = None
        self.nudges: list[tuple[Jog, float]] = []
        self.still_since_s = 0.0
        self.tempo = Tempo()
        self.burst_s = config.motion.jog_burst_s
        self.differences: tuple[Difference, ...] = ()

    # -- what happens -------------------------------------------------------------------------

    def happen(self, event: Event) -> None:
        """Follow the table of states; raises `WrongState` where it has no such row."""
        self.state = after(self.state, event)
        self.witness.changed()

    def settle(self) -> None:
        """End a motion, unless a fault or a loss has taken the state elsewhere meanwhile."""
        self.burst_s = self.config.motion.jog_burst_s
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
            self.witness.changed()

    def require_reference(self) -> None:
        """Raise `NotReferenced` unless planned motion may go on."""
        require_reference(self.belief, allow_restored=self.allow_restored)

    def require_geometry(self) -> None:
        """Raise `Refused` for an arm whose lengths and steps nobody has filled in."""
        if not self.geometry_known:
            raise Refused(
                f"the numbers of the {self.config.model.title} are a template that nobody has "
                "verified, so that a Cartesian goal would lead somewhere else: measure the arm and "
                "give every key of [lengths] and [steps_per_turn] in its arm file, or say verified "
                "= true in its model file. Joints can be moved as they are"
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

    # -- where the arm is ---------------------------------------------------------------------

    def goes_to(self, target: Motors) -> None:
        """Note a motion that is about to be sent."""
        self.commanded = target
        self.current = Current.HELD

    def arrived(self, coordinates: Coordinates | None) -> None:
        """Note that the motion was acknowledged, and which unrounded point it stands for."""
        self.acknowledged = self.commanded
        self.coordinates = coordinates or self.coordinates_of(self.acknowledged)
        if self.touch_mm is not None and self.coordinates.opening_mm >= self.touch_mm:
            self.touch_mm = None  # the fingers have let go

    @property
    def grip_force_n(self) -> float:
        """The force with which the fingers press, from the cable pulled in behind the touch."""
        steps_per_n = self.config.model.grip_steps_per_n
        if self.touch_mm is None or steps_per_n is None:
            return 0.0
        steps_per_mm = abs(self.transmission.motors[-1].steps_per_unit)
        return (self.touch_mm - self.coordinates.opening_mm) * steps_per_mm / steps_per_n

    def found(self, registers: Registers) -> None:
        """Take the registers for the position of an arm of which nothing else is known."""
        self.sense(registers)
        self.commanded = self.acknowledged = self.read_back = registers.positions
        self.coordinates = self.coordinates_of(registers.positions)

    def sense(self, registers: Registers) -> None:
        """Take the inputs; an arm without a grip switch never tells whether it grips."""
        self.inputs = registers.inputs
        if self.controller.abilities.grip_switch:
            self.gripping = registers.gripping

    def compare(self, registers: Registers) -> Motors:
        """Take a read-back; return its difference from the acknowledged position, in steps."""
        self.sense(registers)
        expected = self.acknowledged - self.offset
        counts = self.controller.unwrap(registers.positions, expected)
        self.read_back = counts + self.offset
        return self.read_back - self.acknowledged

    def progress(self, registers: Registers) -> None:
        """Note where the motors are while they move."""
        counts = self.controller.unwrap(registers.positions, self.commanded - self.offset)
        self.read_back = counts + self.offset

    @property
    def seen(self) -> Motors:
        """Where the motors are to be shown: as reported in motion, else as acknowledged."""
        moving = self.state in (State.MOVING, State.HOMING, State.STOPPING)
        reporting = moving and self.controller.abilities.reports_while_moving
        return self.read_back if reporting and self.read_back is not None else self.acknowledged

    def believe_registers(self) -> None:
        """Take the read-back for the position: the motors are there, whatever was commanded."""
        if self.read_back is not None and self.read_back != self.acknowledged:
            self.commanded = self.acknowledged = self.read_back
            self.coordinates = self.coordinates_of(self.acknowledged)

    def count_anew(self, registers: Motors) -> None:
        """Keep the position, and let it be what these registers mean from now on."""
        self.offset = self.acknowledged - registers
        self.commanded = self.read_back = self.acknowledged

    def refer(self, registers: Motors, there: Coordinates) -> None:
        """Make the present registers mean a known posture."""
        position = self.transmission.to_motors(there.joints, there.opening_mm)
        self.offset = position - registers
        self.commanded = self.acknowledged = self.read_back = position
        self.coordinates = there

    def restore(self, record: Record, registers: Motors) -> bool:
        """Take up a recorded reference; False where the registers no longer agree with it."""
        self.offset = Motors(record.offset)
        recorded = Motors(record.registers)
        counts = self.controller.unwrap(registers, recorded)
        self.commanded = self.acknowledged = self.read_back = recorded + self.offset
        self.coordinates = self._recorded_point(record) or self.coordinates_of(self.acknowledged)
        if counts != recorded and not registers.largest:  # the counters lost the power, not the arm
            self.count_anew(registers)
        elif counts != recorded:
            self.read_back = counts + self.offset
            self.believe_registers()
        return counts == recorded

    def _recorded_point(self, record: Record) -> Coordinates | None:
        """Return the unrounded point of a record, if it stands for the same whole steps."""
        names = self.coordinates.joints.names
        if len(record.coordinates) != len(names) + 1:
            return None
        *angles, opening_mm = record.coordinates
        there = Coordinates(Joints(tuple(angles), names), opening_mm)
        same = self.transmission.to_motors(there.joints, opening_mm) == self.acknowledged
        return there if same else None

    def _opening_mm(self, pulled_mm: float) -> float | None:
        """Return how far apart the fingers are, from where their motor or servo has them."""
        if self.transmission.has_gripper:
            return max(pulled_mm, self.touch_mm or 0.0)
        if self.gripper_share is None:
            return None
        low, high = self.config.model.gripper_range_mm
        return low + self.gripper_share * (high - low)

    def coordinates_of(self, position: Motors) -> Coordinates:
        """Return the point that whole motor steps stand for."""
        joints, opening_mm = self.transmission.to_joints(position)
        return Coordinates(joints, opening_mm)

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
            registers=self.acknowledged - self.offset,
            coordinates=(*self.coordinates.joints, self.coordinates.opening_mm),
            trust=self.belief.trust.value,
            reason=self.belief.reason,
            in_motion=in_motion,
        )

    # -- what is shown ------------------------------------------------------------------------

    def stop_bound(self) -> StopBound:
        """Return how long and how far the tip goes on if a stop is asked for now."""
        joints = self.coordinates.joints if self.belief.trust is not Trust.UNKNOWN else None
        return stop_bound(self.config, self.controller, joints, self.burst_s)

    def status(
        self, *, link: str, simulated: bool, now_s: float, last_sent: str, last_answer: str
    ) -> Status:
        """Return a frozen picture of this moment."""
        known = self.belief.trust is not Trust.UNKNOWN
        joints, opening_mm = self.transmission.to_joints(self.seen)
        bound = self.stop_bound()
        return Status(
            arm=self.config.name,
            title=self.config.title,
            link=link,
            dialect=self.config.connection.dialect,
            simulated=simulated,
            state=self.state,
            trust=self.belief.trust,
            trust_reason=self.belief.reason,
            trust_since_s=self.belief.since_s,
            current=self.current,
            joints=joints if known else None,
            pose=self.config.model.arm.fk(joints) if known else None,
            gripper_mm=self._opening_mm(opening_mm) if known else None,
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
            last_sent=last_sent,
            last_answer=last_answer,
            notice=self.notice,
            error=self.error,
            error_code=self.error_code,
            notice_code=self.notice_code,
            torque=dialect(self.config.connection.dialect).torque,
            time_s=now_s,
            paused=self.tempo.paused,
            speed_override=self.tempo.override,
        )
