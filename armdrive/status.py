"""What is known about an arm at one moment: a frozen snapshot that any thread may read."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from armdrive.carried import Carried
from armdrive.lateness import NEVER_WOKEN, Wakes
from armdrive.torque import Torque
from kinematics.spaces import Joints, Motors, Pose

NOTHING_CARRIED = Carried()


class State(Enum):
    """PLCopen's states of an axis group."""

    DISCONNECTED = "disconnected"
    DISABLED = "disabled"
    STANDBY = "standby"
    HOMING = "homing"
    MOVING = "moving"
    STOPPING = "stopping"
    ERROR_STOP = "error-stop"


class Trust(Enum):
    """Whether the position can be believed; orthogonal to the state."""

    UNKNOWN = "unknown"
    RESTORED = "restored"
    REFERENCED = "referenced"
    SUSPECT = "suspect"


class Current(Enum):
    """Whether the motors hold the arm up."""

    HELD = "held"
    OFF = "off"
    UNKNOWN = "unknown"


@dataclass(frozen=True, slots=True)
class Status:
    """One moment of an arm.

    `commanded` is where the arm was last told to be, `acknowledged` where the controller said
    it has been, `read_back` what the controller's registers last showed: three fields, since
    they can differ. All are motor steps in the arm's model; None before anything is known.
    `joints`, `pose` and `gripper_mm` (how far apart the fingers are) follow from `acknowledged`
    and are None while the trust is unknown; of a device that reports while it moves, they follow
    from what it reported last. `stop_time_s` and `stop_distance_mm` bound, for the worst case, how
    long and how far the finger tips go on after a stop is asked for now; `silent_time_s` and
    `silent_distance_mm` the same if this program dies now, or the cable is pulled. The codes are
    rows of the catalogue of errors. `torque` says what holds the arm, and what lets it sag.
    `paused` says that somebody wants the arm to wait, `speed_override` to go slower than asked.
    `wakes` is how late the thread woke that drives the arm; on simulated time it never does.
    `underruns` counts how often a device that queues stood still while more was to come, `carried`
    what went over the wire.
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
    torque: Torque | None = None
    time_s: float = 0.0
    trust_since_s: float = 0.0
    paused: bool = False
    speed_override: float = 1.0
    wakes: Wakes = NEVER_WOKEN
    underruns: int = 0
    carried: Carried = NOTHING_CARRIED

    @property
    def pause_time_s(self) -> float:
        """How long the arm goes on when it is paused now: as when nothing more comes at all."""
        return self.silent_time_s

    @property
    def pause_distance_mm(self) -> float:
        """How far the tip goes on when the arm is paused now, at most."""
        return self.silent_distance_mm

    @property
    def trust_code(self) -> str:
        """The catalogue's code of the reason, where it speaks against the position."""
        from armdrive.catalogue import code_of_reason

        return code_of_reason(self.trust_reason)

    @property
    def trust_age(self) -> str:
        """For how long the position has been trusted, or doubted, in words."""
        age_s = max(self.time_s - self.trust_since_s, 0.0)
        unit_s, unit = next(
            (size, name)
            for size, name in ((3600, "h"), (60, "min"), (1, "s"))
            if age_s >= size or size == 1
        )
        return f"for {age_s / unit_s:.0f} {unit}"

    @property
    def which(self) -> str:
        """Say in words which arm this is, and whether it is real."""
        kind = "SIMULATED" if self.simulated else "REAL"
        return f"{self.arm} ({self.title}), {kind}, {self.link}"

    def __str__(self) -> str:
        position = f"position {self.trust.value} {self.trust_age}: {self.trust_reason}"
        lines = [self.which, f"state {self._conduct}, {position}"]
        if self.joints is not None and self.pose is not None:
            lines += [f"joints {self.joints}", f"tip {self.pose}"]
        if self.gripper_mm is not None:
            grip = ", gripping" if self.gripping else ""
            lines.append(f"gripper {self.gripper_mm:.1f} mm{grip}")
        if self.acknowledged is not None:
            lines.append(f"motors {', '.join(map(str, self.acknowledged))}")
        lines.append(
            f"motor current {self.current.value}; a stop takes at most {self.stop_time_s:.2f} s "
            f"and {self.stop_distance_mm:.0f} mm"
        )
        if self.silent_time_s > self.stop_time_s:
            lines[-1] += (
                f"; if this program dies, {self.silent_time_s:.2f} s and "
                f"{self.silent_distance_mm:.0f} mm"
            )
        if self.wakes.count:
            lines.append(f"punctuality: {self.wakes}")
        if self.underruns:
            lines.append(f"underruns: {self.underruns}, the queue ran empty in mid-motion")
        if self.torque is not None:
            lines.append(f"after disable the arm {self.torque.disable}")
            lines.append(f"after estop the arm {self.torque.estop}")
        lines += [f"{word}: {text}" for word, text in self._remarks() if text]
        return "\n".join(lines)

    @property
    def _conduct(self) -> str:
        slowed = f", slowed to {self.speed_override:.0%}" if self.speed_override < 1.0 else ""
        return self.state.value + ", PAUSED" * self.paused + slowed

    def _remarks(self) -> tuple[tuple[str, str], ...]:
        return (
            ("notice", coded(self.notice, self.notice_code)),
            ("error", coded(self.error, self.error_code)),
        )


def coded(words: str, code: str) -> str:
    """Put a code before the words it belongs to."""
    return f"[{code}] {words}" if code and words else words
