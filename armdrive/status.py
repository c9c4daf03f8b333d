"""The status of an arm: a frozen snapshot that any thread may read."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import asdict, dataclass
from enum import Enum
from types import MappingProxyType
from typing import Any, NamedTuple, Self

from armdrive.abilities import Torque
from armdrive.errors.table import code_of_name
from kinematics.spaces import Joints, Motors, Pose
from kinematics.text import counted, deg_text, mm_text, shown_name

# Bounds: they are rounded up, because less was not promised.


def rounded_up(bound: float, digits: int) -> float:
    """Round a bound to this many digits, but never below it."""
    scale = 10.0**digits
    return math.ceil(round(bound * scale, 6)) / scale  # 0.28 * 100 is a little more than 28


def longest(time_s: float) -> str:
    """Return how long something goes on at most."""
    return f"{rounded_up(time_s, 2):.2f} s"


def farthest(distance_mm: float) -> str:
    """Return how far something goes on at most."""
    return f"{rounded_up(distance_mm, 0):.0f} mm"


def bound_words(time_s: float, distance_mm: float) -> str:
    """Return how long, and how far, something goes on at most."""
    return f"{longest(time_s)} and {farthest(distance_mm)}"


# Scheduling jitter: how late a thread wakes for its deadlines.
#
# Deadlines are absolute, so that a late one does not delay the next.

LATE_S = 5e-3  # a twentieth of the time that a burst lasts


@dataclass(frozen=True, slots=True)
class SchedulingJitter:
    """How punctually a thread woke: `late` of its deadlines were met more than `LATE_S` late."""

    count: int = 0
    late: int = 0
    worst_s: float = 0.0

    def after(self, late_s: float) -> SchedulingJitter:
        """Count a deadline that was met `late_s` late; early ones count as punctual."""
        late = self.late + (late_s > LATE_S)
        return SchedulingJitter(self.count + 1, late, max(self.worst_s, late_s))

    def __str__(self) -> str:
        if not self.count:
            return "no deadline has passed"
        return (
            f"{counted(self.count, 'deadline')}, {self.late} met more than {_ms(LATE_S)} late, "
            f"the latest {_ms(self.worst_s)} late"
        )


NEVER_WOKEN = SchedulingJitter()


def _ms(time_s: float) -> str:
    return f"{time_s * 1e3:.2g} ms" if time_s < 0.1 else f"{time_s * 1e3:.0f} ms"


class State(Enum):
    """The states of an arm, after PLCopen's states of an axis group."""

    DISCONNECTED = "disconnected"
    DISABLED = "disabled"
    STANDBY = "standby"
    HOMING = "homing"
    MOVING = "moving"
    STOPPING = "stopping"
    ERROR_STOP = "error-stop"

    @property
    def where(self) -> str:
        """The state, as a sentence says it: the arm is ..."""
        return f"in {self.value}" if self is State.ERROR_STOP else self.value


# What to do about a state in which a call is refused; errors/actions.py has the words for it.
WAYS_OUT: Mapping[State, str] = MappingProxyType(
    {
        State.DISCONNECTED: "call `reconnect()`",
        State.DISABLED: "call `enable()` to switch the motors on",
        State.STANDBY: "nothing has to be done first",
        State.HOMING: "wait for the referencing to end, or stop it",
        State.MOVING: "wait for the motion to end, or stop it",
        State.STOPPING: "wait until the arm stands",
        State.ERROR_STOP: "look at the arm, then call `reset()`",
    }
)

# The states in which nothing can move the arm until a person has done that.
IMMOBILE = (State.DISCONNECTED, State.DISABLED, State.ERROR_STOP)

# The states in which the arm moves, or is paused in a motion.
IN_MOTION = (State.HOMING, State.MOVING, State.STOPPING)


class Trust(Enum):
    """How far the position can be trusted; independent of the state."""

    UNKNOWN = "unknown"
    RESTORED = "restored"
    REFERENCED = "referenced"
    SUSPECT = "suspect"


# What to do about a position that is not referenced, in the same words.
WAYS_TO_TRUST: Mapping[Trust, str] = MappingProxyType(
    {
        Trust.UNKNOWN: "bring the arm to its reference posture and call `home()`",
        Trust.SUSPECT: "look at the arm, then call `home()`",
        Trust.RESTORED: "compare the arm with the drawn posture, then call "
        "`reference.confirm_restored()`, or connect with `allow_restored=True`",
    }
)

# The levels of trust at which the arm is believed to stand where its counts say.
#
# They allow no planned motion yet: `runtime.states.Belief.allows_planning` decides that.
BELIEVED = (Trust.REFERENCED, Trust.RESTORED)

# The same, as a status in JSON, a record and a recording spell them.
BELIEVED_WORDS = tuple(each.value for each in BELIEVED)


class Evidence(Enum):
    """An observation about the position, in the words of the status, and the trust that follows.

    Most evidence speaks against the position, which is suspect then.
    """

    trust: Trust

    def __new__(cls, words: str, trust: Trust = Trust.SUSPECT) -> Self:
        """Make a member whose value is its words."""
        evidence = object.__new__(cls)
        evidence._value_, evidence.trust = words, trust
        return evidence

    NO_RECORD = "no position of this arm has been saved", Trust.UNKNOWN
    RECORD_UNUSABLE = "the saved position cannot be used", Trust.UNKNOWN
    RECORD_MATCHES = "saved by the last session, and the registers match", Trust.RESTORED
    LINK_BACK = "the link was lost and restored, and the registers match", Trust.RESTORED
    HOMED = "referenced in the reference posture", Trust.REFERENCED
    HOMED_BY_SWITCHES = "referenced by the controller's own homing", Trust.REFERENCED
    DECLARED = "the posture was declared by the caller", Trust.REFERENCED
    CONFIRMED = "the operator confirmed the recorded posture", Trust.REFERENCED
    RECORD_DIFFERS = "the registers differ from the saved ones: the arm was moved or lost its power"
    ENDED_IN_MOTION = "the last program ended in mid-motion"
    ANSWER_LOST = "a motion was sent, but never answered"
    SILENT = "the controller did not answer, and may have lost its power"
    READ_BACK_DIFFERS = "the registers are not where the motion should have left them"
    MOTION_REFUSED = "the controller refused a valid motion"
    BROKEN_OFF = "a motion was aborted before its end"
    HOMING_FAILED = "the controller's homing did not finish"
    OFF_ITS_MARK = "verified at the reference mark, where the position was off"
    STOPPED_DEAD = "the motors were stopped without a ramp and may have lost steps"
    ALARM = "the controller went into alarm during a motion"
    OFF_THE_PATH = "the controller reported a position off the path that was sent"
    SWITCHED_OFF = "the controller switched the motors off, and the arm can sag"
    CURRENT_DROPPED = "the motor current was switched off, and the arm can sag"
    LOST_IN_MOTION = "the link was lost during a motion"
    MOVED_BY_OTHERS = "the registers changed without a command: moved by hand or by a pendant"
    RESTARTED = "the controller reported a restart"
    CONTROLLER_RESTARTED = "the registers are zero, as after a reset or a loss of power"


def code_of_reason(reason: str) -> str:
    """Return the catalogue's code for a trust's reason, which begins with its evidence's text."""
    for evidence in Evidence:
        if reason.startswith(evidence.value):
            return code_of_name(evidence.name)
    return ""


class Current(Enum):
    """Whether the motors hold the arm up."""

    HELD = "held"
    OFF = "off"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Status:
    """A snapshot of an arm.

    - `commanded`, `acknowledged`, `read_back`: the position last commanded, the one that the
      controller has confirmed, and the latest reading of its registers. They can differ. All are
      motor steps in the arm's model, or None if unknown.
    - `joints`, `pose`, `gripper_mm` (the distance between the fingers): computed from
      `acknowledged`, or from the latest report of a device that reports while it moves. None while
      the trust is unknown.
    - `stop_time_s`, `stop_distance_mm`: worst-case bounds on how long and how far the finger tips
      would continue after a stop now. `silent_time_s`, `silent_distance_mm`: the same if the
      program died or the cable was pulled.
    - `error_code`, `notice_code`: rows of the error catalogue. If there are several notices,
      `notice` has all of them, and `notice_code` is that of the first.
    - `notices`: the number of notices so far. The same words with a higher number are a new notice.
    - `torque`: when the arm is held up, and when it sags.
    - `paused`, `speed_override`: whether the arm is paused, and the factor that slows it.
    - `scheduling_jitter`: how late the thread that drives the arm woke; never late in simulated
      time.
    - `underruns`: how often the device's queue ran empty in mid-motion.
    """

    arm: str
    title: str
    link: str
    dialect: str
    simulated: bool
    state: State
    trust: Trust
    trust_reason: str
    current: Current
    joints: Joints | None = None
    pose: Pose | None = None
    gripper_mm: float | None = None
    gripping: bool | None = None
    commanded: Motors | None = None
    acknowledged: Motors | None = None
    read_back: Motors | None = None
    inputs: int | None = None
    outputs: int | None = None
    stop_time_s: float = 0.0
    stop_distance_mm: float = 0.0
    silent_time_s: float = 0.0
    silent_distance_mm: float = 0.0
    last_sent: str = ""
    last_answer: str = ""
    notice: str = ""
    error: str = ""
    error_code: str = ""
    notice_code: str = ""
    notices: int = 0
    torque: Torque | None = None
    time_s: float = 0.0
    trust_since_s: float = 0.0
    paused: bool = False
    speed_override: float = 1.0
    scheduling_jitter: SchedulingJitter = NEVER_WOKEN
    underruns: int = 0

    @property
    def pause_time_s(self) -> float:
        """How long the arm would move after a pause now: as long as if the program died."""
        return self.silent_time_s

    @property
    def pause_distance_mm(self) -> float:
        """How far the tip would move at most after a pause now."""
        return self.silent_distance_mm

    @property
    def trust_code(self) -> str:
        """The catalogue's code for the trust's reason; empty if the reason is no problem."""
        return code_of_reason(self.trust_reason)

    @property
    def trust_age(self) -> str:
        """How long the trust has had its current value, in words."""
        age_s = max(self.time_s - self.trust_since_s, 0.0)
        unit_s, unit = next(
            (size, name)
            for size, name in ((3600, "h"), (60, "min"), (1, "s"))
            if age_s >= size or size == 1
        )
        return f"for {age_s / unit_s:.0f} {unit}"

    @property
    def which(self) -> str:
        """The arm's name, title and link, and whether it is real."""
        return which_arm(status_view(self))

    def __str__(self) -> str:
        lines = [self.which, *map(str, status_rows(status_view(self)))]
        if self.scheduling_jitter.count:
            lines.append(f"scheduling: {self.scheduling_jitter}")
        return "\n".join(lines)


def coded(words: str, code: str) -> str:
    """Return a message with its error code in front, if it has one."""
    return f"[{code}] {words}" if code and words else words


def trust_words(trust: str, reason: str, code: str) -> str:
    """Return why a position is trusted or not; with its code only if something is wrong.

    A restored position agrees with all that could be compared: it awaits a look at the arm.
    """
    return reason if trust == Trust.RESTORED.value else coded(reason, code)


# A status as plain data, with units in the names, for `--json` and for the control socket.


def pose_numbers(pose: Pose) -> dict[str, float]:
    """Return a pose in mm and degrees, unrounded."""
    yaw = {} if pose.yaw_deg is None else {"yaw_deg": pose.yaw_deg}
    return {
        "x_mm": pose.x_mm,
        "y_mm": pose.y_mm,
        "z_mm": pose.z_mm,
        "pitch_deg": pose.pitch_deg,
        "roll_deg": pose.roll_deg,
        **yaw,
    }


def joints_numbers(joints: Joints) -> dict[str, float]:
    """Return joint angles in degrees, unrounded."""
    return {f"{name}_deg": angle for name, angle in joints.deg.items()}


def pose_view(pose: Pose | None) -> dict[str, float] | None:
    """Return a pose in mm and degrees, rounded for display."""
    return None if pose is None else _displayed(pose_numbers(pose))


def joints_view(joints: Joints | None) -> dict[str, float] | None:
    """Return joint angles in degrees, rounded for display."""
    return None if joints is None else _displayed(joints_numbers(joints))


def _displayed(numbers: Mapping[str, float]) -> dict[str, float]:
    """Return numbers rounded as JSON has them, by the unit at the end of each key."""
    return {key: round(each, _DECIMALS[key.rpartition("_")[2]]) for key, each in numbers.items()}


# The decimals of each unit: fewer than a motor step is worth would hide that a motor turned.
_DECIMALS: Mapping[str, int] = MappingProxyType({"mm": 3, "deg": 4, "ms": 3})


_NUMBER = {"type": "number"}
_TEXT = {"type": "string"}
_FLAG = {"type": "boolean"}
_COUNT = {"type": "integer"}
_STEPS = {"anyOf": [{"type": "array", "items": _COUNT}, {"type": "null"}]}

_JITTER = {
    "type": "object",
    "properties": {
        "deadlines": _COUNT,
        "late": _COUNT,
        "worst_ms": _NUMBER,
    },
}


def _maybe(schema: Mapping[str, Any]) -> dict[str, Any]:
    return {"anyOf": [schema, {"type": "null"}]}


def _choice(kind: type[Enum]) -> dict[str, Any]:
    return {"enum": [each.value for each in kind]}


def _jitter_view(jitter: SchedulingJitter) -> dict[str, float]:
    worst = _displayed({"worst_ms": jitter.worst_s * 1e3})
    return {"deadlines": jitter.count, "late": jitter.late, **worst}


def _trusted_for_s(status: Status) -> float:
    return round(max(status.time_s - status.trust_since_s, 0.0), 1)


def _gripper_mm(status: Status) -> float | None:
    opening_mm = status.gripper_mm
    return None if opening_mm is None else _displayed({"gripper_mm": opening_mm})["gripper_mm"]


_Row = tuple[Callable[[Status], Any], Mapping[str, Any]]

# Each key of a status in JSON: the function that computes its value, and its schema.
STATUS_FIELDS: Mapping[str, _Row] = MappingProxyType(
    {
        "arm": (lambda status: status.arm, _TEXT),
        "title": (lambda status: status.title, _TEXT),
        "link": (lambda status: status.link, _TEXT),
        "dialect": (lambda status: status.dialect, _TEXT),
        "simulated": (lambda status: status.simulated, _FLAG),
        "state": (lambda status: status.state.value, _choice(State)),
        "paused": (lambda status: status.paused, _FLAG),
        "speed_override": (lambda status: round(status.speed_override, 4), _NUMBER),
        "trust": (lambda status: status.trust.value, _choice(Trust)),
        "trust_reason": (lambda status: status.trust_reason, _TEXT),
        "trust_for_s": (_trusted_for_s, _NUMBER),
        "current": (lambda status: status.current.value, _choice(Current)),
        "joints": (lambda status: joints_view(status.joints), _maybe({"$ref": "#/$defs/joints"})),
        "pose": (lambda status: pose_view(status.pose), _maybe({"$ref": "#/$defs/pose"})),
        "gripper_mm": (_gripper_mm, _maybe(_NUMBER)),
        "gripping": (lambda status: status.gripping, _maybe(_FLAG)),
        "commanded_steps": (lambda status: status.commanded, _STEPS),
        "acknowledged_steps": (lambda status: status.acknowledged, _STEPS),
        "read_back_steps": (lambda status: status.read_back, _STEPS),
        "inputs": (lambda status: status.inputs, _maybe(_COUNT)),
        "outputs": (lambda status: status.outputs, _maybe(_COUNT)),
        "stop_time_s": (lambda status: rounded_up(status.stop_time_s, 3), _NUMBER),
        "stop_distance_mm": (lambda status: rounded_up(status.stop_distance_mm, 1), _NUMBER),
        "silent_time_s": (lambda status: rounded_up(status.silent_time_s, 3), _NUMBER),
        "silent_distance_mm": (lambda status: rounded_up(status.silent_distance_mm, 1), _NUMBER),
        "pause_time_s": (lambda status: rounded_up(status.pause_time_s, 3), _NUMBER),
        "pause_distance_mm": (lambda status: rounded_up(status.pause_distance_mm, 1), _NUMBER),
        "scheduling_jitter": (lambda status: _jitter_view(status.scheduling_jitter), _JITTER),
        "underruns": (lambda status: status.underruns, _COUNT),
        "torque": (
            lambda status: None if status.torque is None else asdict(status.torque),
            _maybe({"type": "object"}),
        ),
        "notice": (lambda status: status.notice, _TEXT),
        "error": (lambda status: status.error, _TEXT),
        "trust_code": (lambda status: status.trust_code, _TEXT),
        "notice_code": (lambda status: status.notice_code, _TEXT),
        "error_code": (lambda status: status.error_code, _TEXT),
    }
)


def status_view(status: Status) -> dict[str, Any]:
    """Return a status as plain data."""
    return {key: value(status) for key, (value, _) in STATUS_FIELDS.items()}


# A status in words. It is made from the plain data, so that an arm looks the same whether this
# program is connected to it or another program reports it.

# The width of the first column.
LABEL = 10


class StatusRow(NamedTuple):
    """A line of a status: its label, a word that a terminal shows in colour, and the rest."""

    label: str
    word: str
    rest: str = ""

    def __str__(self) -> str:
        return f"{self.label:<{LABEL}}{self.word}{self.rest}"


# The motor current in words.
_MOTORS: Mapping[str, str] = MappingProxyType(
    {
        Current.HELD.value: "on: they hold the arm",
        Current.OFF.value: "off",
        Current.UNKNOWN.value: "on or off: not known",
    }
)

# The current of a disabled arm that has not been read. `armdrive doctor` asks drives on a bus.
_NOT_ASKED = "not switched on by this program; they may hold the arm all the same"


def motors_words(state: str, current: str) -> str:
    """Say whether motors hold the arm: they are ..."""
    unasked = (state, current) == (State.DISABLED.value, Current.UNKNOWN.value)
    return _NOT_ASKED if unasked else _MOTORS[current]


def which_arm(view: Mapping[str, Any]) -> str:
    """Return an arm's name, title and link, and whether it is real."""
    kind = "SIMULATED" if view["simulated"] else "REAL"
    return f"{view['arm']} ({view['title']}), {kind}, {view['link']}"


def outcome_words(status: Status) -> str:
    """Say what a call that switches motors, or clears an error, has led to, and what is next."""
    way = f"; {WAYS_OUT[status.state]}" if status.state is State.DISABLED else ""
    return (
        f"state {status.state.value}, motor current {status.current.value}, "
        f"position {status.trust.value}{way}"
    )


def status_rows(view: Mapping[str, Any]) -> Iterator[StatusRow]:
    """Yield a status line by line: state, position, tip, joints, gripper, stop, and errors."""
    yield StatusRow("state", view["state"], _conduct(view))
    yield StatusRow("motors", motors_words(view["state"], view["current"]))
    if program := program_line(view):
        yield StatusRow("program", program, _progress(view))
    reason = trust_words(view["trust"], view["trust_reason"], view["trust_code"])
    yield StatusRow("position", view["trust"], f": {reason}")
    if view["pose"] is not None:
        yield StatusRow("tip", ", ".join(_coordinates(view["pose"])))
    yield from _joint_rows(view["joints"] or {})
    if view["gripper_mm"] is not None:
        grip = ", gripping" if view["gripping"] else ""
        yield StatusRow("gripper", f"{mm_text(view['gripper_mm'])} open{grip}")
    if view["inputs"] is not None:
        yield StatusRow("inputs", _inputs(view["inputs"]))
    yield StatusRow("stop", _stopping(view))
    if (torque := view["torque"]) is not None:
        yield StatusRow("disable", f"the arm {torque['disable']}")
        yield StatusRow("estop", f"the arm {torque['estop']}")
    if view["underruns"]:
        yield StatusRow("underruns", f"{view['underruns']}: the arm stood still in mid-motion")
    for label in ("notice", "error"):
        if view[label]:
            yield StatusRow(label, coded(view[label], view[f"{label}_code"]))


def _conduct(view: Mapping[str, Any]) -> str:
    override = view["speed_override"]
    return ", PAUSED" * bool(view["paused"]) + (
        f", slowed to {override:.0%}" if override < 1.0 else ""
    )


def _joint_rows(joints: Mapping[str, float]) -> Iterator[StatusRow]:
    """Yield a row for each joint, the angles below each other."""
    names = [shown_name(key.removesuffix("_deg")) for key in joints]
    width = max(map(len, names), default=0)
    for at, (name, angle) in enumerate(zip(names, joints.values(), strict=True)):
        yield StatusRow("" if at else "joints", f"{name:<{width}}{deg_text(angle):>9}")


def _coordinates(pose: Mapping[str, float]) -> Iterator[str]:
    for key, value in pose.items():
        name, unit = key.rsplit("_", 1)
        yield f"{name} {mm_text(value) if unit == 'mm' else deg_text(value)}"


def _inputs(bits: int) -> str:
    on = [str(number + 1) for number in range(bits.bit_length()) if bits >> number & 1]
    return f"on: {', '.join(on)}" if on else "all off"


def _stopping(view: Mapping[str, Any]) -> str:
    words = f"takes at most {bound_words(view['stop_time_s'], view['stop_distance_mm'])}"
    silent = bound_words(view["silent_time_s"], view["silent_distance_mm"])
    if view["state"] == State.DISCONNECTED.value:
        return f"does not reach the arm; what was sent ends by itself within {silent}"
    if view["silent_time_s"] > view["stop_time_s"]:
        words += f"; without this program, {silent}"
    return words


def program_line(view: Mapping[str, Any]) -> str:
    """Return which line of which program an arm runs; nothing if it runs none."""
    program = view.get("program")
    if not isinstance(program, dict) or not program:
        return ""
    file, line = program.get("file"), program.get("line")
    text = program.get("text") or program.get("act") or ""  # an act without a line has a name
    return f"{file}, line {line}: {text}" if line else f"{file}: {text}"


def _progress(view: Mapping[str, Any]) -> str:
    """Return how far a program has come, where that is known."""
    program = view.get("program") or {}
    percent, left_s = program.get("percent"), program.get("left_s")
    loop, loops = program.get("loop"), program.get("loops", 1)
    facts = [] if loops == 1 else [f"loop {loop} of {loops}" if loops else f"loop {loop}"]
    if isinstance(percent, int | float) and isinstance(left_s, int | float):
        facts.append(f"{percent:.0f}%, {left_s:.0f} s left")
    return f" ({', '.join(facts)})" if facts else ""
