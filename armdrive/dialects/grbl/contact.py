"""Make contact with a GRBL board and get it to read lines. Nothing here moves the arm.

`make` runs before the first request, `prepare` before each motion, and `clear` when the operator
resets the arm. The board may be in any state when they begin: starting up, in a motion or a hold
that another program left, in alarm, asleep, with half a line in its input, or hung. A reset leaves
most of these states, but it also switches off the outputs, one of which may hold the gripper.
"""

from __future__ import annotations

from dataclasses import dataclass

from armdrive.dialects.exchange import TRIES, Obstructed, Script, ScriptIO
from armdrive.dialects.grbl.board import LINES_IGNORED, MOVING, BoardState
from armdrive.dialects.grbl.exchange import POLL_S, GrblExchange, refusal
from armdrive.dialects.grbl.settings import GrblSettings
from armdrive.dialects.grbl.stops import GrblStops
from armdrive.tasks import Alert, AlertKind, Done, Reply, RequestRejected
from firmware_protocol.grbl import (
    Acknowledged,
    Line,
    Realtime,
    Restarted,
    State,
    StatusReport,
    SystemCommand,
)
from firmware_protocol.grbl.host import Event as HostEvent
from kinematics.text import counted

# After these alarms a board is reset before it gets a line. After 1 and 2, at a limit, it accepts
# none; grblHAL still sends reports. After the others, of homing that failed, FluidNC would drive
# the next line from where its search was to end, not from where it stands (Homing.cpp, fail).
RESET_ALARMS = (1, 2, 8, 9, 15)
# Time allowed for a motion that an earlier program left running, before it is stopped.
LEFTOVER_MOTION_S = 1.0
# The parser's modes that motions rely on: plane XY, mm, relative, units per minute, and the first
# coordinate system. A reset or a start-up line may have changed them.
MODES = Line("G17G21G91G94G54")
READS_NO_LINES = (
    "the board reports idle but reads no lines, even after a reset: switch it off and on, then "
    "home the arm"
)


@dataclass(slots=True, eq=False)
class GrblContact:
    """Brings a board to rest, ready to read lines."""

    io: ScriptIO[HostEvent]
    exchange: GrblExchange
    board: BoardState
    stops: GrblStops
    settings: GrblSettings

    def make(self) -> Script[HostEvent, None]:
        """Make contact, whether or not opening the port has reset the board. Moves nothing.

        Raises `Obstructed` if that fails.
        """
        board, exchange, began_s = self.board, self.exchange, self.io.now_s
        # wait for a banner or a report: a board that is starting up does not answer for a while
        boot_s, every_s = self.settings.boot_s, 2.0 * POLL_S
        alive = yield from exchange.sign_of_life(boot_s, every_s, StatusReport | Restarted)
        if alive:
            yield from self._end_leftover_motion()
        exchange.end_echo()
        # a reset may have been lost or not needed, so check that the board reads lines
        if not (yield from self._reads_lines(seen=alive)):
            raise Obstructed(self.io.silence(began_s))
        yield from self._recognise()
        # the report's coordinates give the number of axes, if `$I` has not named them
        yield from exchange.look()
        if board.lacking:
            axes, lacking = board.letters, ", ".join(board.lacking)
            raise Obstructed(
                f"the board has {counted(len(axes), 'axis', 'axes')} ({axes}), but grbl.axes "
                f"also puts motors of this arm on {lacking}: use a board and a firmware with an "
                "axis for each motor (grbl-Mega-5X, grblHAL, FluidNC), or correct the letters in "
                "grbl.axes"
            )
        exchange.send_realtime(Realtime.FEED_100)
        board.contacted = True
        if board.state is State.ALARM:
            self.io.notify(Alert(AlertKind.LOCKED, board.locked_words()))

    def _recognise(self) -> Script[HostEvent, None]:
        """Ask for the build information until it arrives undamaged."""
        for _ in range(TRIES):
            board, garbled = self.board, self.board.garbled
            message = yield from self.exchange.ask(SystemCommand.QUERY_BUILD)
            board.recognised = isinstance(message, Acknowledged) and board.garbled == garbled
            # if an axis is lacking, its letter may have been damaged: ask again
            if board.recognised and not board.lacking:
                return

    def _end_leftover_motion(self) -> Script[HostEvent, None]:
        """End what an earlier program left running.

        A reset discards a half-received line. In Idle it keeps position and state, whatever $22 is
        (gnea/grbl grbl/main.c: the prior state and sys_position stay), and the motors stay on if
        $1 is 255. If it could open the gripper, a line that is refused has to do.
        """
        if not (yield from self.exchange.look()):
            return  # it may read lines nevertheless
        end_s = self.io.now_s + LEFTOVER_MOTION_S
        while self.board.state in MOVING and self.io.now_s < end_s:
            yield from self.io.pause(self.io.now_s + POLL_S)
            yield from self.exchange.look()
        if self.board.in_motion:
            yield from self.stops.hold()
        elif self.board.state in LINES_IGNORED or not self.stops.outputs.reset_lets_go:
            yield from self.exchange.soft_reset()

    def clear(self) -> Script[HostEvent, Reply]:
        """Leave an alarm, a hold, sleep or a mute state; the position is as valid as before.

        One reset may not be enough: a feed hold may arrive after it, and FluidNC may report a
        motion, without one, after the reset that ends a limit alarm.
        """
        began_s = self.io.now_s
        seen = yield from self.exchange.look()
        for _ in range(TRIES):
            if seen and self.board.state in MOVING:
                yield from self.stops.hold()
            elif not (yield from self._reads_lines(seen=seen)):
                return self.io.silence(began_s)
            seen = yield from self.exchange.look()
            if self.board.state in (State.IDLE, State.ALARM):
                break
        if self.board.state is State.ALARM:
            answer = yield from self.exchange.ask(SystemCommand.UNLOCK)
            if not isinstance(answer, Acknowledged):
                return refusal(answer, "the board stays locked")
            yield from self.exchange.look()
        if self.board.state is not State.IDLE:
            return RequestRejected(f"the board's state is {self.board.state}", moved=False)
        return Done()

    def _reads_lines(self, *, seen: bool) -> Script[HostEvent, bool]:
        """Get the board to read lines, if necessary by a reset; `seen` is whether it reports."""
        stale = self.board.alarm is not None and self.board.alarm.code in RESET_ALARMS
        may_read = seen and not stale and self.board.state not in LINES_IGNORED
        if may_read and (yield from self.exchange.flush_line()):
            return True
        return (yield from self.exchange.soft_reset())

    def prepare(self) -> Script[HostEvent, None]:
        """Make the board ready for a motion. Raises `Obstructed` if that fails.

        A board that is Idle but reads no lines is reset, which keeps the position of a board at
        rest. A resume would also make it read lines, but it would execute those that wait in its
        receive buffer.
        """
        board = self.board
        if not (yield from self.exchange.confirm_position()):
            raise Obstructed(
                board.alarm_words() if board.alarm else "the board reports no position"
            )
        if board.state is State.ALARM:
            raise Obstructed(board.locked_words())
        if board.state is not State.IDLE:
            raise Obstructed(board.busy_words())
        board.room = board.free_blocks or 0
        for _ in range(TRIES):
            message = yield from self.exchange.ask(MODES)
            if isinstance(message, Acknowledged):
                return
            if message is None and not (yield from self.stops.reset_and_restore(moving=False)):
                break
        raise Obstructed(
            READS_NO_LINES if message is None else refusal(message, "its modes could not be set")
        )
