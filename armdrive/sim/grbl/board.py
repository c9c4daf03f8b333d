"""A simulated GRBL board: its reports, hard limits, motion, and main loop, and the board itself.

One line is executed at a time, by a script that yields when to resume it: a time, or infinity for
"after the next event". Real-time commands are picked out of the stream as they arrive (`orders`).
States of the main loop:

    booting   input is not read, and is lost when the board has started
    critical  a limit alarm: only a reset is obeyed
    blocked   Hold (in most firmware only once it is complete) and Sleep, during a jog cancel, and
              when hung: lines stay in the ring
    hung      Idle, after a jog cancel that came as the jog ended: a resume or a reset frees it
    else      the current line continues, or the next one is taken out of the ring

Sources: gnea/grbl grbl/protocol.c, serial.c, motion_control.c and stepper.c (st_go_idle).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Generic, TypeAlias, TypeVar

from armdrive.abilities import BITS_A_BYTE
from armdrive.errors import BadRequest
from armdrive.sim.device import Board
from armdrive.sim.grbl.firmware import MINUTE_S, AlarmNumber, BoardSettings
from armdrive.sim.grbl.hardware import (
    BoardBuild,
    BoardDrive,
    BoardOutputs,
    MotorCurrent,
    OutputFingers,
    ReceiveRing,
    Switches,
)
from armdrive.sim.mechanics.motors import SwitchState
from armdrive.sim.world import World
from armdrive.sim.world.saved import Json, require_names, unfit
from armdrive.text.toml import setting
from firmware_protocol.grbl import (
    Answer,
    Device,
    Error,
    Feedback,
    LineReceived,
    Modal,
    Ok,
    Realtime,
    State,
    StatusReport,
    keys,
    pieces,
    written,
)
from kinematics.spaces import Motors

# --- Scripts: generators that yield the time until which they wait -------------------------------
# Infinity means "until something happens": such a script checks again after every event.

T = TypeVar("T")
# A line being executed; it returns its reply.
Script: TypeAlias = Generator[float, None, Ok | Error]
# A start-up sequence.
Boot: TypeAlias = Generator[float, None, None]


@dataclass(frozen=True, slots=True)
class FirmwareRoutines:
    """What the firmware does, as functions of its board.

    `orders` has them. A board gets them when it is made, because `orders` imports this file.
    """

    line: Callable[[GrblBoard, LineReceived], Script]
    order: Callable[[GrblBoard, Realtime], None]
    critical: Callable[[GrblBoard, int], None]
    fail: Callable[[GrblBoard, int], Boot]
    switched_on: Callable[[GrblBoard, float], Boot]


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


# --- The status report ---------------------------------------------------------------------------
# Source: gnea/grbl grbl/report.c and config.h: WCO comes with every 30th report in motion and every
# 10th at rest, Ov with every 20th and 10th. Here both come with every 10th, and Ov after a change.

# The minimum time between reports. Several requests within it get one report.
GAP_S = 0.005
# The input bits: probe, door, feed hold, cycle start, reset.
PINS = "PDHSR"
_OFTEN = 10
# The parts of a report by their bits in $10 (`$ES`, setting 10).
_MPOS, _BUFFERS, _FEED, _PINS, _OFFSET, _OVERRIDES = 1, 2, 8, 16, 32, 64


class StatusReporter:
    """Answers `?`. A report takes time on the wire, and the next one waits for it."""

    def __init__(self, baud: int | None) -> None:
        self._byte_s = BITS_A_BYTE / baud if baud else 0.0
        self._free_s = -math.inf
        self.restart()

    def restart(self) -> None:
        """Start as after a reset: the first report contains the work offset."""
        self.asked = False
        self._count = 0

    def outputs_changed(self) -> None:
        """Include the overrides and accessories in the next report."""
        self._count = 1

    def due_s(self, board: GrblBoard) -> float:
        """Return when a report is due; infinity if none is, or none can be sent."""
        if not self.asked:
            return math.inf
        firmware = board.firmware
        silent = board.booting.active or (board.critical and firmware.mute_in_critical)
        homing = board.state is State.HOME and board.main_loop.executing
        if silent or (firmware.silent_in_homing and homing):
            return math.inf
        return max(self._free_s, board.now_s)

    def report(self, board: GrblBoard) -> StatusReport:
        """Return the report for this moment."""
        turn, self._count, self.asked = self._count % _OFTEN, self._count + 1, False
        told = int(board.settings[keys.REPORT]) | ~board.firmware.report_bits
        pins = [letter for bit, letter in enumerate(PINS) if board.inputs_set >> bit & 1]
        pins += [letter for axis, letter in enumerate(board.axes) if board.switches.pressed(axis)]
        others: list[str] = []
        if turn == 0 and told & _OFFSET:
            others.append(f"WCO:{written((0.0,) * len(board.axes))}")
        if turn == 1 and told & _OVERRIDES:
            others.append("Ov:100,100,100")
        if turn == 1 and board.outputs.letters:
            others.append(f"A:{board.outputs.letters}")
        report = StatusReport(
            board.state,
            int(not board.cycle.stands) if board.state is State.HOLD else None,
            board.drive.units_of(board.drive.counts) if told & _MPOS else None,
            board.firmware.blocks - board.drive.queued(board.now_s) if told & _BUFFERS else None,
            board.ring.free if told & _BUFFERS else None,
            float(round(board.drive.speed(board.now_s) * MINUTE_S)) if told & _FEED else None,
            board.outputs.on.get("spindle", 0.0) if told & _FEED else None,
            "".join(pins) or None if told & _PINS else None,
            tuple(others),
        )
        length = len(report.line) + 2
        self._free_s = board.now_s + max(GAP_S, length * self._byte_s)
        return report


# --- Hard limits: a switch that changes while the board is not homing ----------------------------
# The firmware's interrupt fires on both edges of every switch, so backing off a switch raises an
# alarm too. Source: gnea/grbl grbl/limits.c.

# How often the switches are checked during motion.
TICK_S = 0.005


class HardLimits:
    """Checks the switches; `due_s` is when to call `look` next."""

    def __init__(self) -> None:
        self.due_s = math.inf
        self._pressed = 0

    def plan(self, board: GrblBoard) -> None:
        """Compute when to check next."""
        if not (_in_force(board) and board.drive.moving):
            self.due_s = math.inf
        elif math.isinf(self.due_s):
            self.due_s = board.now_s + TICK_S

    def look(self, board: GrblBoard) -> None:
        """Raise the alarm if a switch has changed."""
        before = self._pressed
        self.forget(board)
        deaf = board.state in (State.ALARM, State.HOME) or board.booting.active
        if self._pressed != before and _in_force(board) and not deaf:
            board.routines.critical(board, AlarmNumber.HARD_LIMIT)

    def forget(self, board: GrblBoard) -> None:
        """Take the present state of the switches as the reference."""
        self.due_s = math.inf
        self._pressed = board.switches.mask()


def _in_force(board: GrblBoard) -> bool:
    """Return whether a change of a switch is an alarm: not every build acts on $21=1."""
    return board.firmware.hard_limits and board.settings.on(keys.HARD_LIMITS)


# --- The motion of the queued lines, from the start to a stand -----------------------------------
# Source: gnea/grbl grbl/protocol.c (protocol_auto_cycle_start, EXEC_CYCLE_STOP).

_BLOCKING = (State.HOLD, State.SLEEP)


class MotionCycle:
    """Starts the motion of the queued lines, ends it, and knows what follows once it has ended.

    `stands`: a hold is complete. `cancelling`: the motion is braked, and its lines are dropped at
    the end; `cancels` counts how often. `hangs`: at the end the board stops reading lines.
    """

    def __init__(self) -> None:
        self.cancels = 0
        self.forget()

    def forget(self) -> None:
        """Forget what was to follow."""
        self.stands = self.cancelling = self.hangs = False

    def autostart(self, board: GrblBoard) -> None:
        """Start to execute the queued lines as soon as no more arrive."""
        if board.state is State.IDLE and board.drive.rack.waiting:
            self.start(board, State.RUN)

    def start(self, board: GrblBoard, state: State) -> None:
        """Switch the motors on and execute the queue."""
        board.current.keep_on()
        board.drive.rack.resume(board.now_s)
        board.state = state

    def cancel(self, board: GrblBoard) -> None:
        """Slow down and drop the planned lines; lines not read yet run afterwards."""
        if not self.cancelling:
            self.cancelling = True
            self.cancels += 1
            board.drive.brake(board.now_s, board.firmware.cancel_keeps)

    def kill(self, board: GrblBoard) -> None:
        """Stop dead."""
        board.drive.kill(board.now_s)
        self.forget()

    def ended(self, board: GrblBoard) -> None:
        """React to the end of motion."""
        if board.state is not State.HOME:
            board.current.release_at_rest(board.now_s)
        if self.cancelling:
            self.cancelling = False
            board.drive.stop(board.now_s)
            board.position = board.drive.goal_units
            board.state = State.IDLE
        elif board.state in _BLOCKING:
            self.stands = True
        elif board.state in (State.RUN, State.JOG):
            board.state = State.IDLE
        if self.hangs:
            self.hangs, board.main_loop.hung = False, board.state is State.IDLE


# --- The main loop: one line after the other, unless something blocks it -------------------------
# Source: gnea/grbl grbl/protocol.c (protocol_main_loop).


class MainLoop:
    """Takes lines out of the ring and executes them, one at a time.

    `hung`: a jog cancel has left the board in Idle without reading lines. `refused` is the error of
    the last line, 0 if it was carried out. `afterwards` is what the line being executed does once
    its reply has been sent.
    """

    def __init__(self) -> None:
        self._line: BoardScript[Ok | Error] = BoardScript()
        self.forget()

    def forget(self) -> None:
        """Abandon the line being executed, without a reply."""
        self._line.end()
        self.hung = False
        self.refused = 0
        self.afterwards: Callable[[], None] | None = None

    @property
    def executing(self) -> bool:
        """Whether a line is being executed."""
        return self._line.active

    @property
    def pauses(self) -> bool:
        """Whether the line being executed waits for a time, not for an event."""
        return self._line.active and not math.isinf(self._line.until_s)

    def blocked(self, board: GrblBoard) -> bool:
        """Return whether no lines are executed."""
        # only a completed hold suspends the loop (gnea/grbl grbl/protocol.c, EXEC_CYCLE_STOP)
        held = board.state in _BLOCKING and board.cycle.stands
        held |= board.cycle.cancelling or self.hung
        return held or board.booting.active or board.critical

    def due_s(self, board: GrblBoard) -> float:
        """Return when the line goes on; infinity if something has to happen first."""
        until_s = self._line.until_s
        return math.inf if math.isinf(until_s) or self.blocked(board) else until_s

    def run(self, board: GrblBoard) -> None:
        """Execute lines as long as there is something to do."""
        while not self.blocked(board):
            if not self._line.active and not self._fetch(board):
                board.cycle.autostart(board)
                break
            if not self._line.ready(board.now_s):
                break
            answer = self._line.step()
            if answer is not None and board.codec.unanswered:
                board.say(answer[0])
                then, self.afterwards = self.afterwards, None
                if then is not None:
                    then()
            elif answer is None and self._line.until_s > board.now_s:
                break  # it waits for a time or an event, and neither comes within this loop
        board.limits.plan(board)

    def drop_line(self, board: GrblBoard) -> None:
        """Abandon the line being executed; most firmware answers it with ok."""
        if self._line.active:
            self._line.end()
            if board.codec.unanswered and board.firmware.answers_dropped:
                board.say(Ok())

    def _fetch(self, board: GrblBoard) -> bool:
        """Take a line out of the ring; return False if none is complete."""
        while data := board.ring.take_line():
            board.codec.receive_data(data)
            if (line := board.codec.next_event()) is not None:
                self._line.begin(board.routines.line(board, line), board.now_s)
                return True
        return False


# --- Real-time commands that have arrived but were not read yet -----------------------------------


class UnreadCommands:
    """The real-time commands that wait for the board to read them; most boards do so at once.

    Observed on FluidNC: while it executes a line it reads them late, and while it waits at a switch
    in homing not at all. Then it first starts the next motion and fills its segment buffer, and
    `waited` says that the commands being obeyed come after that.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Drop them."""
        self.due_s = math.inf
        self.waited = False
        self._commands: list[Realtime] = []

    def put(self, board: GrblBoard, command: Realtime) -> None:
        """Add one that arrives now."""
        late_s = board.firmware.reads_every_s if board.main_loop.executing else 0.0
        self.due_s = min(self.due_s, board.now_s + late_s)
        self._commands.append(command)

    def obey(self, board: GrblBoard) -> None:
        """Obey all of them, if the board reads them now."""
        executing = board.main_loop.executing
        if not self._commands or (executing and board.now_s < self.due_s):
            return
        polls = board.firmware.reads_every_s > 0.0
        if polls and board.state is State.HOME and board.main_loop.pauses:
            fills = board.firmware.stepping
            self.due_s = board.main_loop.due_s(board) + fills.segments * fills.compute_s
            self.waited = True
            return
        commands, self._commands, self.due_s = self._commands, [], math.inf
        for command in commands:
            board.routines.order(board, command)
        self.waited = False


# --- The board ------------------------------------------------------------------------------------

# Bytes put into the ring before the main loop runs: fewer than the smallest ring holds.
READ_AT_ONCE = 64
COUNT_MOST = (1 << 31) - 1
_PIN_ORDERS = {"H": Realtime.FEED_HOLD, "S": Realtime.RESUME, "R": Realtime.SOFT_RESET}
_LOCKED = (State.ALARM, State.SLEEP)


@dataclass(frozen=True, slots=True)
class SavedGrblBoard:
    """What is saved of a board: its settings by number, its outputs, and whether it is locked."""

    axes: str
    settings: Mapping[int, float]
    outputs: Mapping[str, float]
    state: str = setting(words=(State.ALARM, State.IDLE))


class GrblBoard(Board):
    """The firmware on its board, the arm, and fingers that one of the outputs may move."""

    title: ClassVar[str] = "GRBL board"
    saved_as = SavedGrblBoard
    input_bits = len(PINS)
    register_range: ClassVar[tuple[int, int]] = (-COUNT_MOST, COUNT_MOST)
    drive: BoardDrive

    def __init__(
        self,
        world: World,
        build: BoardBuild,
        settings: BoardSettings,
        switches: Switches,
        routines: FirmwareRoutines,
        baud: int | None,
    ) -> None:
        super().__init__(world, BoardDrive(world, build, settings.limits()), baud)
        self.build = build
        self.firmware = firmware = build.firmware
        self.axes = build.axes
        self.settings = settings
        self.switches = switches
        self.routines = routines
        self.codec = Device(replace(firmware.dialect, axes=build.axes))
        self.modal = Modal()
        self.position: tuple[float, ...] = (0.0,) * len(build.axes)
        """Where the axes stand after all lines that have been parsed, in units."""
        self.outputs = BoardOutputs()
        self.fingers = OutputFingers(world, build, self.outputs)
        self.reporter = StatusReporter(baud)
        self.current = MotorCurrent(world, settings)
        self.ring = ReceiveRing(firmware.ring_bytes)
        self.limits = HardLimits()
        self.echoes = False
        self.booting: BoardScript[None] = BoardScript()
        self.cycle = MotionCycle()
        self.main_loop = MainLoop()
        self.unread = UnreadCommands()
        self.again: list[int] = []
        self.unhomed: set[int] = set()
        self.start(0.0)

    def start(self, wait_s: float) -> None:
        """Restart the firmware after a delay, with its banner."""
        self.forget()
        self.outgoing.clear()
        self.booting.begin(self.routines.switched_on(self, wait_s), self.now_s)
        while self.booting.until_s <= self.now_s:
            self.happen()

    def boot(self) -> None:
        """Start the firmware."""
        self.start(self.firmware.boot_s)

    def forget(self) -> None:
        """Clear what is lost with the power, and with a reset of the whole board."""
        self.main_loop.forget()
        self.booting.end()
        self.critical = self.holds_next = self.stalls = False
        self.unread.forget()
        self.again = []
        self.state = State.IDLE
        self.deaf_until_s = -math.inf
        self.current.off_s = math.inf
        self.outputs.on.clear()
        self.fingers.forget()

    def unhome(self) -> None:
        """Forget which axes have been homed, if the firmware keeps count."""
        homes = self.firmware.locks_until_homed and self.settings.on(keys.HOMING)
        self.unhomed = set(range(len(self.axes))) if homes else set()

    # Observable state.

    @property
    def busy(self) -> bool:
        """Whether a line is being executed, lines wait, or something moves."""
        return self.main_loop.executing or len(self.ring) > 0 or self.drive.rack.waiting > 0

    @property
    def registers(self) -> Motors:
        """The step counts of the axes that have motors."""
        return self.drive.registers

    def details(self) -> dict[str, Json]:
        """Return the firmware, its state, its outputs, and how many bytes were lost."""
        return {
            "firmware": self.firmware.name,
            "state": str(self.state),
            "outputs": dict(self.outputs.on),
            "lost_bytes": self.ring.lost,
        }

    # The wire.

    def tell(self, text: str) -> None:
        """Send a message for people."""
        self.say(Feedback(text))

    def say(self, answer: Answer) -> None:
        """Send a message."""
        self.outgoing += self.codec.send(answer)

    def receive(self, data: bytes) -> None:
        """Receive bytes, as the receive interrupt does."""
        if self.now_s < self.deaf_until_s:  # the interrupts are off: even a reset is ignored
            self.ring.lost += len(data)
            return
        for piece in pieces(data):
            if isinstance(piece, Realtime):
                self.unread.put(self, piece)
                self.unread.obey(self)
            else:
                self._put(piece)
        self.main_loop.run(self)

    def _put(self, data: bytes) -> None:
        """Put characters into the ring. The board reads meanwhile, so a line may be longer."""
        for start in range(0, len(data), READ_AT_ONCE):
            self.ring.put(self._edited(data[start : start + READ_AT_ONCE]))
            self.main_loop.run(self)

    def _edited(self, data: bytes) -> bytes:
        """Return what gets into a line; a board that edits it echoes characters or drops them."""
        if not self.firmware.edits_lines:
            return data
        kept = b""
        for sign in (data[at : at + 1] for at in range(len(data))):
            control = sign < b" " and sign not in b"\r\n"
            self.echoes = (self.echoes or control) and sign != b"\f"
            if not control:
                kept += sign
                self.outgoing += sign if self.echoes else b""
        return kept

    # Time.

    def due_s(self) -> float:
        """Return when the board next acts on its own."""
        due_s = min(
            self.booting.until_s,
            self.drive.rack.next_line_s,
            self.current.off_s,
            self.limits.due_s,
            self.fingers.due_s,
            self.main_loop.due_s(self),
            self.unread.due_s,
        )
        return min(due_s, self.reporter.due_s(self)) if self.reporter.asked else due_s

    def happen(self) -> None:
        """Do what is due."""
        now_s = self.now_s
        if self.fingers.due_s <= now_s:
            self.fingers.arrive(now_s)
        if self.booting.until_s <= now_s:
            self.booting.step()
        if self.drive.live(now_s):
            self.cycle.ended(self)
        if self.limits.due_s <= now_s:
            self.limits.look(self)
        if self.current.off_s <= now_s:
            self.current.cut(now_s)
        self.main_loop.run(self)
        self.unread.obey(self)
        if self.reporter.due_s(self) <= now_s:
            self.say(self.reporter.report(self))

    # Actions of a person.

    def set_input(self, bit: int, on: bool) -> None:
        """Set a control pin. Hold, start and reset act like the corresponding commands."""
        pressed = on and not self.inputs_set >> bit & 1
        super().set_input(bit, on)
        order = _PIN_ORDERS.get(PINS[bit])
        if order is not None and pressed and self.powered and not self.booting.active:
            self.routines.order(self, order)

    def set_switch(self, axis: int, state: SwitchState) -> None:
        """Make the limit switch of a motor (counted from 0) stick, or free it."""
        if not 0 <= axis < len(self.build.order):
            raise BadRequest(f"motors are numbered 0 to {len(self.build.order) - 1}, not {axis}")
        self.switches.by_axis[self.build.order[axis]].state = state
        self.moved_by_hand(counted=False)

    def moved_by_hand(self, *, counted: bool) -> None:
        """Count steps made at the controls; check the switches after motion by force."""
        if counted:
            self.position = self.drive.goal_units
            self.limits.forget(self)
        elif self.powered:
            self.limits.look(self)

    def reset(self) -> None:
        """Reset the board, as opening its port does: it loses its position, and the arm sags."""
        if self.powered:
            self.drive.stop(self.now_s)
            self.current.cut(self.now_s)
            self.start(self.firmware.boot_s)

    # The saved world.

    def known(self) -> SavedGrblBoard:
        """Return the settings, the outputs, and whether the board is locked."""
        return SavedGrblBoard(
            self.axes,
            self.settings.values,
            self.outputs.on,
            str(State.ALARM if self.state in _LOCKED else State.IDLE),
        )

    def recall_known(self, saved: SavedGrblBoard) -> None:
        """Restore what `known` returned. Raises `StateFileError`."""
        if saved.axes != self.axes:
            raise unfit(f"the saved board has other axes than {self.axes}")
        require_names("settings", map(str, saved.settings), map(str, self.settings.values))
        self.outputs.on.update(saved.outputs)
        self.settings.values.update(saved.settings)
        self.drive.rack.limits = self.settings.limits()
        self.position = self.drive.goal_units
        self.state = State(saved.state)
        if self.state is State.ALARM:
            self.unhome()
        self.outgoing.clear()
        self.limits.forget(self)
