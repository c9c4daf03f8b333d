"""A simulated GRBL board: its receive ring, its main loop, its reports, and its hard limits.

One line is executed at a time, by a script that yields when to resume it: a time, or infinity for
"after the next event". Real-time commands are picked out of the stream as they arrive (`orders`).
States of the main loop:

    booting   input is not read, and is lost when the board has started
    critical  a limit alarm: only a reset is obeyed
    blocked   Hold, Door and Sleep, during a jog cancel, and when hung: lines stay in the ring
    hung      Idle, after a jog cancel that came as the jog ended: a resume or a reset frees it
    else      the current line continues, or the next one is taken out of the ring

Sources: gnea/grbl grbl/protocol.c, serial.c, motion_control.c and stepper.c (st_go_idle).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Generic, TypeAlias, TypeVar

from armdrive.sim.device import SharedState
from armdrive.sim.grbl.firmware import HARD_LIMITS, INCHES, REPORT, BoardSettings
from armdrive.sim.grbl.hardware import BoardBuild, BoardDrive, BoardOutputs, Switches
from armdrive.sim.grbl.parser import GcodeParser
from armdrive.sim.mechanics.planner import SEGMENT_S
from armdrive.status import BITS_A_BYTE
from firmware_protocol.grbl import (
    GRBLHAL_ONLY,
    Answer,
    Device,
    Error,
    LineReceived,
    Ok,
    Realtime,
    State,
    StatusReport,
)

# --- The receive ring: when it is full, bytes are lost without a word ----------------------------

_LINE_END = re.compile(rb"[\r\n]")
_LONGEST = 4096


class ReceiveRing:
    """Bytes that the main loop has not read, and the line that it has started to read.

    `lost` counts the bytes that did not fit.
    """

    def __init__(self, size: int) -> None:
        self.size = size
        self.lost = 0
        self._bytes = bytearray()
        self._begun = bytearray()

    def __len__(self) -> int:
        return len(self._bytes)

    @property
    def free(self) -> int:
        """How many more bytes fit."""
        return self.size - len(self._bytes)

    def put(self, data: bytes) -> None:
        """Store as many bytes as fit."""
        kept = data[: self.free]
        self.lost += len(data) - len(kept)
        self._bytes += kept

    def take_line(self) -> bytes:
        """Read up to the end of a line and return the line; None if its end has not arrived."""
        end = _LINE_END.search(self._bytes)
        count = len(self._bytes) if end is None else end.end()
        self._begun += self._bytes[:count]
        del self._bytes[:count]
        if end is None:
            del self._begun[_LONGEST:]  # no line is this long, and its end is still to come
            return b""
        line = bytes(self._begun)
        self._begun.clear()
        return line

    def clear(self) -> None:
        """Forget everything."""
        self._bytes.clear()
        self._begun.clear()


# --- Scripts: generators that yield the time until which they wait -------------------------------
# Infinity means "until something happens": such a script checks again after every event.

T = TypeVar("T")
Script: TypeAlias = Generator[float, None, Ok | Error]
"""A line being executed; it returns its reply."""
Boot: TypeAlias = Generator[float, None, None]
"""A start-up sequence."""


@dataclass(frozen=True, slots=True)
class Makers:
    """How a board executes lines, real-time commands and its two kinds of alarms."""

    line: Callable[[GrblBoard, LineReceived], Script]
    order: Callable[[GrblBoard, Realtime], None]
    critical: Callable[[GrblBoard, int], None]
    fail: Callable[[GrblBoard, int], None]


class BoardScript(Generic[T]):
    """At most one script at a time."""

    def __init__(self) -> None:
        self.until_s = math.inf
        self._script: Generator[float, None, T] | None = None

    @property
    def active(self) -> bool:
        """Whether a script is running."""
        return self._script is not None

    def begin(self, script: Generator[float, None, T], now_s: float) -> None:
        """Start a script, which takes its first step in `step`."""
        self._script, self.until_s = script, now_s

    def ready(self, now_s: float) -> bool:
        """Return whether the script is due, or waits for an event."""
        waits = self.until_s > now_s and not math.isinf(self.until_s)
        return self._script is not None and not waits

    def step(self) -> tuple[T] | None:
        """Resume the script; once it has ended, return its result."""
        script = self._script
        if script is None:
            return None
        try:
            self.until_s = next(script)
        except StopIteration as end:
            if self._script is script:  # the script may have started another one
                self.end()
            return (end.value,)
        return None

    def end(self) -> None:
        """Abandon the script."""
        if self._script is not None:
            self._script.close()
        self._script, self.until_s = None, math.inf


# --- The status report, and how often it comes ---------------------------------------------------
# Source: gnea/grbl grbl/report.c and config.h: WCO comes with every 30th report in motion and every
# 10th at rest, Ov with every 20th and 10th, and both at once after a change.

GAP_S = 0.005
"""The minimum time between reports. Several requests within it get one report."""
_BUSY = (State.HOME, State.RUN, State.HOLD, State.JOG, State.DOOR)
_WCO_BUSY, _OV_BUSY, _IDLE = 30, 20, 10
_MPOS, _BUFFERS = 1, 2
_MINUTE_S = 60.0
MM_PER_INCH = 25.4


class StatusReporter:
    """Answers `?`. A report takes time on the wire, and the next one waits for it."""

    def __init__(self, baud: int | None) -> None:
        self.asked = False
        self._byte_s = BITS_A_BYTE / baud if baud else 0.0
        self._free_s = -math.inf
        self.restart()

    def restart(self) -> None:
        """Start as after a reset: the first report contains the work offset."""
        self.asked = False
        self._until_wco = self._until_ov = 0

    def offset_changed(self) -> None:
        """Include the work offset in the next report."""
        self._until_wco = 0

    def overrides_changed(self) -> None:
        """Include the overrides in the next report."""
        self._until_ov = 0

    def due_s(self, board: GrblBoard) -> float:
        """Return when a report is due; infinity if none is, or none can be sent."""
        if not self.asked:
            return math.inf
        firmware = board.firmware
        silent = board.boot.active or (board.critical and firmware.mute_in_critical)
        if silent or (firmware.silent_in_homing and board.state is State.HOME):
            return math.inf
        return max(self._free_s, board.now_s)

    def report(self, board: GrblBoard) -> StatusReport:
        """Return the report for this moment."""
        self.asked = False
        per_unit = 1.0 / MM_PER_INCH if board.settings.on(INCHES) else 1.0
        position = tuple(at * per_unit for at in board.drive.units_of(board.drive.counts))
        offset = tuple(at * per_unit for at in board.parser.offset)
        mask = int(board.settings[REPORT])
        work = tuple(a - b for a, b in zip(position, offset, strict=True))
        buffers = bool(mask & _BUFFERS)
        wco, overrides = self._now_and_then(board.state in _BUSY)
        report = StatusReport(
            board.state,
            _sub_state(board),
            position if mask & _MPOS else None,
            None if mask & _MPOS else work,
            board.firmware.blocks - board.drive.queued(board.now_s) if buffers else None,
            board.ring.free if buffers else None,
            feed=float(round(board.drive.speed(board.now_s) * _MINUTE_S * per_unit)),
            speed=board.outputs.speed,
            pins=_pins(board),
            work_offset=offset if wco else None,
            overrides=tuple(board.overrides) if overrides else None,
            accessories=(board.outputs.letters or None) if overrides else None,
        )
        length = len(report.line) + 2
        self._free_s = board.now_s + max(GAP_S, length * self._byte_s)
        return report

    def _now_and_then(self, busy: bool) -> tuple[bool, bool]:
        """Count a report; return whether the offset and the overrides are due. Never both."""
        if self._until_wco == 0:
            self._until_wco = (_WCO_BUSY if busy else _IDLE) - 1
            self._until_ov = max(self._until_ov, 1)
            wco = True
        else:
            self._until_wco -= 1
            wco = False
        if self._until_ov == 0:
            self._until_ov = (_OV_BUSY if busy else _IDLE) - 1
            return wco, True
        self._until_ov -= 1
        return wco, False


def _sub_state(board: GrblBoard) -> int | None:
    if board.state is State.HOLD:
        return 0 if board.stands else 1
    if board.state is State.DOOR:
        return 0 if board.stands else 2
    return None


def _pins(board: GrblBoard) -> str | None:
    letters = "".join(
        letter for axis, letter in enumerate(board.axes) if board.switches.pressed(axis)
    )
    return (board.inputs + letters) or None


# --- Hard limits: a switch that changes while the board is not homing ----------------------------
# The firmware's interrupt fires on both edges of every switch, so backing off a switch raises an
# alarm too. Source: gnea/grbl grbl/limits.c.

TICK_S = 0.005
"""How often the switches are checked during motion."""
HARD_LIMIT = 1


class HardLimits:
    """Checks the switches; `due_s` is when to call `look` next."""

    def __init__(self) -> None:
        self.due_s = math.inf
        self._pressed = 0

    def plan(self, board: GrblBoard) -> None:
        """Compute when to check next."""
        limited = _in_force(board) and board.state is not State.HOME
        if not (limited and board.drive.moving) or board.critical:
            self.due_s = math.inf
        elif math.isinf(self.due_s):
            self.due_s = board.now_s + TICK_S

    def look(self, board: GrblBoard) -> None:
        """Raise the alarm if a switch has changed."""
        before = self._pressed
        self.forget(board)
        deaf = board.state in (State.ALARM, State.HOME) or board.boot.active
        if self._pressed != before and _in_force(board) and not deaf:
            board.alarm(HARD_LIMIT)

    def forget(self, board: GrblBoard) -> None:
        """Take the present state of the switches as the reference."""
        self.due_s = math.inf
        self._pressed = board.switches.mask()


def _in_force(board: GrblBoard) -> bool:
    """Return whether a change of a switch is an alarm: not every build acts on $21=1."""
    return board.firmware.hard_limits and board.settings.on(HARD_LIMITS)


_BLOCKING = (State.HOLD, State.DOOR, State.SLEEP)
_PICKED = re.compile(rb"[\x18!?~\x80-\xff]")
_PICKED_BY_GRBLHAL = re.compile(rb"[\x18\x19!?~\x80-\xff]")


class GrblBoard:
    """The complete firmware state. Replies are appended to `outgoing`."""

    def __init__(
        self,
        shared: SharedState,
        build: BoardBuild,
        settings: BoardSettings,
        drive: BoardDrive,
        switches: Switches,
        makers: Makers,
        *,
        baud: int | None,
        outputs_changed: Callable[[], None],
    ) -> None:
        self.firmware = firmware = build.firmware
        self.axes = build.axes
        self.settings = settings
        self.drive = drive
        self.switches = switches
        self.coast = build.coast
        self.codec = Device(firmware.dialect(build.axes))
        self.parser = GcodeParser(build.axes, firmware.unknown)
        self.outputs = BoardOutputs()
        self.outputs_changed = outputs_changed
        self.reporter = StatusReporter(baud)
        self.ring = ReceiveRing(firmware.ring_bytes)
        self.startup = ["", ""]
        self.note = self.inputs = ""
        self.state = State.IDLE
        self.stands = self.cancelling = self.leaving = self.critical = False
        self.hangs = self.hung = False
        self.afterwards: Callable[[], None] | None = None
        self.overrides, self.cancels = [100, 100, 100], 0
        self.deaf_until_s = -math.inf
        self.idle_off_s = math.inf
        self.boot: BoardScript[None] = BoardScript()
        self.limits = HardLimits()
        self._line: BoardScript[Ok | Error] = BoardScript()
        self._shared = shared
        self.makers = makers
        self._picked = _PICKED_BY_GRBLHAL if firmware.grblhal else _PICKED
        known = set(Realtime) if firmware.grblhal else set(Realtime) - GRBLHAL_ONLY
        self._orders = {int(one): one for one in known}

    # Observable state.

    @property
    def now_s(self) -> float:
        """The current time."""
        return self._shared.now_s

    @property
    def blocked(self) -> bool:
        """Whether the main loop executes no lines."""
        held = self.state in _BLOCKING or self.cancelling or self.hung
        return held or self.boot.active or self.critical

    @property
    def at_work(self) -> bool:
        """Whether a line is being executed, lines wait, or something moves."""
        return self._line.active or len(self.ring) > 0 or self.drive.rack.waiting > 0

    @property
    def full(self) -> bool:
        """Whether the planner is full."""
        blocks = self.firmware.blocks
        return self.drive.rack.waiting >= blocks and self.drive.queued(self.now_s) >= blocks

    def say(self, answer: Answer) -> None:
        """Send a message."""
        self._shared.outgoing += self.codec.send(answer)

    # The wire.

    def hear(self, data: bytes) -> None:
        """Receive bytes, as the receive interrupt does."""
        if self.now_s < self.deaf_until_s:
            self.ring.lost += len(data)
            return
        start = 0
        for found in self._picked.finditer(data):
            self.ring.put(data[start : found.start()])
            start = found.end()
            command = self._orders.get(data[found.start()])
            if command is not None and not self.boot.active:
                self.makers.order(self, command)
        self.ring.put(data[start:])
        self.run()

    # Time.

    def due_s(self) -> float:
        """Return when the board next acts on its own."""
        return min(
            math.inf if self.blocked else self._line.until_s,
            self.boot.until_s,
            self.drive.next_s,
            self.idle_off_s,
            self.limits.due_s,
            self.reporter.due_s(self),
        )

    def happen(self) -> None:
        """Do what is due."""
        now_s = self.now_s
        if self.boot.until_s <= now_s:
            self.boot.step()
        if self.drive.live(now_s):
            self._stood()
        if self.limits.due_s <= now_s:
            self.limits.look(self)
        if self.idle_off_s <= now_s:
            self.idle_off_s = math.inf
            self.drive.world.cut_current(now_s)
        self.run()
        if self.reporter.due_s(self) <= now_s:
            self.say(self.reporter.report(self))

    def run(self) -> None:
        """Execute lines as long as there is something to do."""
        while not self.blocked:
            if not self._line.active and not self._fetch():
                self.autostart()
                break
            if not self._line.ready(self.now_s):
                break
            answer = self._line.step()
            if answer is not None and self.codec.unanswered:
                self.say(answer[0])
                then, self.afterwards = self.afterwards, None
                if then is not None:
                    then()
            elif answer is None and self._line.until_s > self.now_s:
                break
        self.limits.plan(self)

    def _fetch(self) -> bool:
        """Take a line out of the ring; return False if none is complete."""
        while data := self.ring.take_line():
            self.codec.receive_data(data)
            request = self.codec.next_event()
            if isinstance(request, LineReceived):
                self._line.begin(self.makers.line(self, request), self.now_s)
                return True
        return False

    # Motion.

    def autostart(self) -> None:
        """Start to execute the queued lines as soon as no more arrive."""
        if self.state is State.IDLE and self.drive.rack.waiting:
            self.set_going(State.RUN)

    def set_going(self, state: State) -> None:
        """Switch the motors on and execute the queue."""
        self.drive.energise()
        self.idle_off_s = math.inf
        self.drive.rack.resume(self.now_s)
        self.state = state

    def kill(self) -> None:
        """Stop dead."""
        self.drive.kill(self.now_s, self.coast)
        self.cancelling = self.stands = self.leaving = False

    def let_motors_go(self) -> None:
        """Switch the motors off after the idle delay, even if $1 says to leave them on."""
        self.idle_off_s = self.now_s + self.settings.idle_s

    def alarm(self, code: int) -> None:
        """Lock the board after a limit alarm, until it is reset."""
        self.makers.critical(self, code)

    def _stood(self) -> None:
        """React to the end of motion."""
        if not self.settings.motors_stay_on and self.state is not State.HOME:
            self.let_motors_go()
        if self.leaving:
            self.leaving = False
            self.alarm(2)
        elif self.cancelling:
            self.cancelling = False
            self.drive.stop(self.now_s)
            self.parser.position = self.drive.units_of(self.drive.rack.goal)
            self.state = State.IDLE
        elif self.state in (State.HOLD, State.DOOR, State.SLEEP):
            self.stands = True
        elif self.state in (State.RUN, State.JOG):
            self.state = State.IDLE
        if self.hangs:
            self.hangs, self.hung = False, self.state is State.IDLE

    # Restarting.

    def forget(self) -> None:
        """Clear what is lost with the power, and with a reset of the whole board."""
        self._line.end()
        self.boot.end()
        self.critical = self.stands = self.cancelling = self.leaving = False
        self.hangs = self.hung = False
        self.afterwards = None
        self.state = State.IDLE
        self.deaf_until_s, self.idle_off_s = -math.inf, math.inf
        self.codec.discard()
        self.ring.clear()
        self.outputs.forget()

    def drop_line(self) -> None:
        """Abandon the line being executed; the firmware answers it with ok as it leaves it."""
        if self._line.active:
            self._line.end()
            if self.codec.unanswered:
                self.say(Ok())


# --- What lines wait for, as parts of their scripts ----------------------------------------------

Waits = Generator[float, None, None]


def until_still(board: GrblBoard) -> Waits:
    """Wait until the queue is empty and the motors stand."""
    while board.drive.rack.waiting or board.state is State.RUN:
        board.autostart()
        yield math.inf


def until_room(board: GrblBoard) -> Waits:
    """Wait until the planner has room for a line; a line leaves it with its last segment."""
    while board.full:
        board.autostart()
        yield board.now_s + SEGMENT_S


def write_eeprom(board: GrblBoard) -> Waits:
    """Write the EEPROM with interrupts off on some boards: what arrives meanwhile is lost."""
    if board.firmware.deaf_in_eeprom:
        board.deaf_until_s = board.now_s + board.firmware.eeprom_s
    yield board.now_s + board.firmware.eeprom_s
