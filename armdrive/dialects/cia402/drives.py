"""One drive of an arm: what it has reported, and what is wrong with it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from enum import Enum
from typing import TypeAlias

from armdrive.dialects.bus.drives import off_target_words
from armdrive.tasks import Alert, AlertKind
from firmware_protocol import canopen
from firmware_protocol.canopen import DriveState, NodeState
from firmware_protocol.fields import in_words

# Drives count positions in 32 bits.
TARGET_MAX = (1 << 31) - 1
FAULTS = (DriveState.FAULT, DriveState.FAULT_REACTION)
# The states in which a motor holds its shaft.
HOLDING = (DriveState.ENABLED, DriveState.QUICK_STOP)

# The end of an object transfer.
Answer: TypeAlias = canopen.Uploaded | canopen.Downloaded | canopen.Aborted


class Trouble(Enum):
    """What can be wrong with a drive: what that means for the arm, and in words."""

    RESTARTED = AlertKind.RESTARTED, "{drive} was reset, or lost its power for a moment"
    ORDERED = (
        AlertKind.ALARM,
        "another program has ordered {drive} to be {network}, or it missed a heartbeat",
    )
    IN_FAULT = AlertKind.SWITCHED_OFF, "{drive} is in fault and has switched its motor off{why}"
    LOCKED = AlertKind.LOCKED, f"{IN_FAULT[1]}; `reset()` clears that"
    STOPPED = AlertKind.ALARM, "{drive} has stopped by itself, and holds{why}"
    SWITCHED_OFF = AlertKind.SWITCHED_OFF, "{drive} has switched its motor off"
    OTHER_MODE = AlertKind.OFF_PATH, "another program has brought {drive} to mode {drive.mode}"
    OFF_TARGET = AlertKind.OFF_PATH, "{off}"

    def alert(self, drive: Cia402Drive) -> Alert:
        """Return the alert about a drive; ask it for its error first."""
        kind, words = self.value
        network = "" if drive.network is None else in_words(drive.network).replace(" ", "-")
        off = off_target_words(drive, drive.count, drive.goal, "increments")
        return Alert(kind, words.format(drive=drive, why=drive.why, network=network, off=off))


@dataclass(slots=True, eq=False)
class Cia402Drive:
    """One drive, by its reports and its orders. Increments, and seconds by the clock.

    `window` is how far from its target it may rest.
    """

    node: int
    name: str
    motor: int
    window: int

    # -- what it reported ---------------------------------------------------------------------
    word: canopen.Statusword | None = None
    """None while its state is unknown."""
    mode: int = 0
    network: NodeState | None = None
    """Its state in its last heartbeat."""
    count: int = 0
    """Its position."""
    read_s: float = -math.inf
    """When it was asked for this position, by SYNC or SDO."""
    reported_s: float = -math.inf
    """When its last PDO came."""
    asked_s: float = -math.inf
    """When its last object transfer began."""
    missed: int = 0
    """How many SYNCs were sent since then."""
    still_s: float = math.inf
    """Since when its position has not changed, except for the tremble of its position loop."""
    off_s: float = math.inf
    """Since when its positions are off its goal; infinity while the last one is not."""
    near: int = 0
    """How many positions in a row were at its goal."""
    fell: DriveState | None = None
    """The state in which it was not enabled, at the latest report of that since a motion began."""
    error: str = ""
    """Its last error, in words."""
    missed_heartbeat: bool = False
    booted: bool = False
    alerted: bool = False
    """Whether an alert has reported what is wrong with it."""
    answer: Answer | None = None
    """The answer to its last object transfer."""
    repeats: int = 0
    """How many questions for objects were repeated."""
    strays: int = 0
    """How many answers came that were not awaited any more."""

    # -- what it was ordered ------------------------------------------------------------------
    goal: int = 0
    """Its last target, or where it is held."""
    handshake: canopen.SetPointHost = field(default_factory=canopen.SetPointHost)
    """The hand-over of its goal in profile position mode."""

    # -- its units ----------------------------------------------------------------------------
    speed_unit_hz: float = 0.0
    """Increments/s of one unit of speed; 0 if that is unknown."""
    ramp_unit_hz_s: float = 0.0
    reported_unit_hz: float = 0.0
    turn: float = 0.0
    """Increments of a turn of its motor; 0 if that is unknown."""

    homing_method: int | None = None
    """How it homes (6098); None if it does not report that."""
    fresh: bool = False
    """Whether it was held where it was found, and not ordered since."""
    _still_at: int = 0

    def __str__(self) -> str:
        return f"drive {self.node} ({self.name})"

    def speed(self, rate_hz: float) -> int:
        """Return a speed in its own unit: at least 1."""
        return max(round(rate_hz / self.speed_unit_hz), 1)

    def ramp(self, slope_hz_s: float) -> int:
        """Return a ramp in its own unit: at least 1."""
        return max(round(slope_hz_s / self.ramp_unit_hz_s), 1)

    @property
    def tremble(self) -> int:
        """How far the position of a drive that stands may vary."""
        return self.window // 4 + 1

    @property
    def state(self) -> DriveState | None:
        """Its state of CiA 402; None if unknown."""
        return None if self.word is None else self.word.state

    @property
    def holds(self) -> bool:
        """Whether its motor has current, as far as is known."""
        return self.state is not None and self.state.holds

    @property
    def operates(self) -> bool:
        """Whether it exchanges PDOs, as far as its heartbeats show that."""
        return self.network in (None, NodeState.OPERATIONAL)

    @property
    def dropped_out(self) -> bool:
        """Whether it has left the bus's operation because it missed a heartbeat (object 1029)."""
        return self.missed_heartbeat and not self.operates

    # -- events -------------------------------------------------------------------------------

    def note_word(self, word: canopen.Statusword) -> None:
        """Record its statusword."""
        self.word = word
        self.handshake.receive(word)
        if word.state is not DriveState.ENABLED:
            self.fell = word.state

    def note_position(self, count: int, asked_s: float) -> None:
        """Record its position."""
        if abs(count - self._still_at) > self.tremble or math.isinf(self.still_s):
            self._still_at, self.still_s = count, asked_s
        self.count, self.read_s = count, asked_s
        self.near = self.near + 1 if self.is_near else 0
        self.off_s = math.inf if self.is_near else min(self.off_s, asked_s)

    def note_report(self, report: canopen.DriveReport, synced_s: float, now_s: float) -> None:
        """Record its PDO."""
        self.mode, self.reported_s, self.missed = report.mode, now_s, 0
        self.network, self.missed_heartbeat = NodeState.OPERATIONAL, False  # no other sends PDOs
        self.note_position(report.position, synced_s)
        self.note_word(report.word)

    def note_error(self, event: canopen.Emergency) -> str:
        """Record the error that it reports; return it in words."""
        words = f"{event.words} (error {event.code:04X})"
        if not event.over:  # the cause stays of interest after the error is over
            self.error = words
        self.missed_heartbeat |= event.code == canopen.HEARTBEAT_MISSING
        return words

    # -- orders -------------------------------------------------------------------------------

    def order(self, goal: int) -> None:
        """Record a target."""
        if goal != self.goal:
            self.goal, self.near = goal, 0
        self.fresh = False

    def offer(self, goal: int) -> None:
        """Record a target, and begin to hand it over in profile position mode."""
        self.order(goal)
        self.handshake = canopen.SetPointHost()
        if self.word is not None:  # it may be ready for a target already
            self.handshake.receive(self.word)

    def watch(self) -> None:
        """Begin a motion: judge the drive by its reports from now on."""
        self.near, self.fell, self.error = 0, None, ""
        self.still_s = self.off_s = math.inf

    # -- judgements ---------------------------------------------------------------------------

    @property
    def is_near(self) -> bool:
        """Whether its last position is at its goal."""
        return abs(self.count - self.goal) <= self.window

    @property
    def still_for_s(self) -> float:
        """For how long its positions were the same."""
        return max(self.read_s - self.still_s, 0.0)

    @property
    def stuck_s(self) -> float:
        """For how long its positions were the same, and off its goal."""
        return max(self.read_s - max(self.still_s, self.off_s), 0.0)

    @property
    def register(self) -> int:
        """Its position; its goal if it stands there, since a position loop trembles."""
        return self.goal if self.is_near and self.still_for_s > 0.0 else self.count

    def found_near(self, there: int) -> int:
        """Return where it stands: where it was left, if it was found near there."""
        if self.fresh and abs(self.goal - there) <= self.window:
            self.goal = there
        return self.goal

    @property
    def why(self) -> str:
        """The error that it reported, to be appended; empty if it reported none."""
        return f": {self.error}" if self.error else ""

    def trouble(self, *, on: bool, moving: bool) -> Trouble | None:
        """Return what is wrong with it, if its motor should be `on`, or if it should be moving.

        In motion, a drive that was not enabled at a single report has stopped by itself. A fault
        while the motors are off is no event of the arm: the drive is only locked.
        """
        state = (self.fell if moving else None) or self.state
        if self.booted:
            return Trouble.RESTARTED
        if not self.operates and not self.missed_heartbeat:
            return Trouble.ORDERED
        if state in FAULTS:
            return Trouble.IN_FAULT if on else Trouble.LOCKED
        if state is DriveState.QUICK_STOP or self.dropped_out:
            return Trouble.STOPPED if moving else None
        if on and self.word is not None and state is not DriveState.ENABLED:
            return Trouble.SWITCHED_OFF
        return None


def value_of(answer: canopen.Uploaded) -> int:
    """Decode a whole number by the type of its object, however many bytes the drive sends."""
    entry = canopen.STANDARD.find(answer.place)
    kind = canopen.DataType.U32 if entry is None else entry.type
    size = kind.size or 0
    return int(kind.unpack(answer.data[:size].ljust(size, b"\0")))
