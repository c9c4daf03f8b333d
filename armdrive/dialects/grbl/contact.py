"""Finding a GRBL board, and bringing it to where it reads lines. Nothing here moves the arm."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass

from armdrive.dialects.exchange import ScriptIO
from armdrive.dialects.grbl.board import DEAF, TURNING, BoardState
from armdrive.dialects.grbl.exchange import (
    REPORTS_TO_OFFSET,
    Answering,
    Asking,
    GrblExchange,
    refusal,
)
from armdrive.dialects.grbl.settings import GrblSettings
from armdrive.dialects.grbl.stops import GrblOutputs, GrblStops
from armdrive.tasks import Done, RequestRejected, Timeout
from firmware_protocol.grbl import (
    Acknowledged,
    Modes,
    QueryBuildInfo,
    Realtime,
    Restarted,
    State,
    StatusReported,
    Unlock,
)
from firmware_protocol.grbl.host import Event as HostEvent

TRIES = 3
"""How often the board's build is asked for, its modes are set, and a report that surprises is
followed by another."""
REPORTS_ALIKE = 2
"""A report has no check bytes: that an output is off is believed when it is told so often."""
CRITICAL = (1, 2)
"""After these alarms a board takes no line before a reset; grblHAL goes on to report meanwhile."""
CALM_S = 1.0
"""A motion that a program before this one left behind is waited for so long."""
UNREAD = (
    "the board says it is idle but reads no line, also after a reset: switch it off and on, then "
    "home the arm"
)


@dataclass(slots=True, eq=False)
class GrblContact:
    """The way to a board that stands and reads lines."""

    io: ScriptIO[HostEvent]
    exchange: GrblExchange
    board: BoardState
    stops: GrblStops
    outputs: GrblOutputs
    settings: GrblSettings

    def make(self) -> Generator[float, HostEvent | None, Timeout | RequestRejected | None]:
        """Find the board, whether opening its port has reset it or not. Moves nothing.

        Return what stands against it, where something does.
        """
        began_s = self.io.now_s
        # a banner or a report; a board that is starting answers nothing for a while
        boot_s, every_s = self.settings.boot_s, 2.0 * self.settings.poll_s
        alive = yield from self.exchange.sign_of_life(boot_s, every_s, StatusReported | Restarted)
        if not alive and not (yield from self.exchange.soft_reset()):
            self.io.say(b"", "? (and to a reset)")
            return self.io.silence(began_s)
        if not (yield from self._calm_down()):
            return self.io.silence(began_s)
        # a reset may have been lost, or not been made
        if not (yield from self.exchange.spoil()) and not (yield from self.exchange.soft_reset()):
            return self.io.silence(began_s)
        yield from self._recognise()
        # which counts the board's axes, where `$I` does not tell them
        yield from self.exchange.look(self.settings.answer_s)
        if self.board.lacking:
            return RequestRejected(self._lacking_words(), moved=False)
        self.exchange.press(Realtime.FEED_100)
        self.board.contacted = True
        return None

    def _recognise(self) -> Generator[float, HostEvent | None, None]:
        """Ask for the board's build until it is told without a flaw."""
        for _ in range(TRIES):
            board, garbled = self.board, self.board.garbled
            heard = yield from self.exchange.ask(QueryBuildInfo(), self.settings.answer_s)
            board.recognised = isinstance(heard, Acknowledged) and board.garbled == garbled
            if board.recognised and not board.lacking:  # a letter may have been damaged, too
                return

    def _lacking_words(self) -> str:
        axes, lacking = self.board.letters, ", ".join(self.board.lacking)
        return (
            f"the board has {len(axes)} axes ({axes}), and by grbl.axes this arm has motors on "
            f"{lacking} too: take a board and a firmware with an axis for each motor "
            "(grbl-Mega-5X, grblHAL, FluidNC), or put the right letters into grbl.axes"
        )

    def _calm_down(self) -> Asking:
        """See to it that the board stands and reads lines, whatever an earlier program left.

        A reset forgets a half line. In Idle it keeps position and state, $22 or not (gnea/grbl
        grbl/main.c: the prior state and sys_position stay), and the motors where $1 is 255.
        """
        if not (yield from self.exchange.look(self.settings.answer_s)):
            return True
        end_s = self.io.now_s + CALM_S
        while self.board.state in TURNING and self.io.now_s < end_s:
            yield from self.io.pause(self.io.now_s + self.settings.poll_s)
            yield from self.exchange.look(self.settings.answer_s)
        if self.board.in_motion:
            yield from self.stops.hold()
        elif self.board.state in DEAF or not (yield from self._may_let_go()):
            return (yield from self.exchange.soft_reset())
        return True

    def _may_let_go(self) -> Asking:
        """Tell whether a reset may open the gripper.

        It does not where reports say, twice, that all that it would switch off is off already.
        They say so with the overrides, every tenth time or twentieth.
        """
        if not (self.outputs.reset_lets_go and self.outputs.reported):
            return self.outputs.reset_lets_go
        told = 0
        for _ in range(REPORTS_TO_OFFSET):
            seen = yield from self.exchange.look(self.settings.answer_s)
            if not seen or self.board.reported is None:
                break
            report = self.board.reported.report
            told += report.overrides is not None
            if report.accessories or report.speed:
                break
            if told == REPORTS_ALIKE:
                return False
        return True

    def clear(self) -> Answering:
        """Leave alarm, hold, sleep or muteness; the board's position is as good as it was."""
        began_s = self.io.now_s
        heard = yield from self.exchange.look(self.settings.answer_s)
        critical = self.board.alarm is not None and self.board.alarm.code in CRITICAL
        if heard and self.board.state in TURNING:
            yield from self.stops.hold()
        else:
            may_read = heard and not critical and self.board.state not in DEAF
            reads = may_read and (yield from self.exchange.spoil())
            if not reads and not (yield from self.exchange.soft_reset()):
                return self.io.silence(began_s)
        yield from self.exchange.look(self.settings.answer_s)
        if self.board.state is State.ALARM:
            answer = yield from self.exchange.ask(Unlock(), self.settings.answer_s)
            if not isinstance(answer, Acknowledged):
                return refusal(answer, "the board stays locked")
            yield from self.exchange.look(self.settings.answer_s)
        if self.board.state is not State.IDLE:
            state = self.board.state or "not told"
            return RequestRejected(f"the board's state is {state}", moved=False)
        return Done()

    def prepare(self) -> Generator[float, HostEvent | None, RequestRejected | None]:
        """See to it that a motion can begin; return why it cannot, where it cannot.

        A report has no check bytes: one that surprises is believed when it comes twice.
        """
        board = self.board
        seen: object = State.IDLE, board.position
        for _ in range(TRIES):
            if not (yield from self.exchange.look_position(self.settings.answer_s)):
                words = board.alarm_words() if board.alarm else "the board tells no position"
                return RequestRejected(words, moved=False)
            if seen == (board.state, board.position):
                break
            seen = board.state, board.position
        if board.state is State.ALARM:
            return RequestRejected(f"{board.alarm_words()}. `reset()` unlocks it", moved=False)
        if board.state is not State.IDLE:
            return RequestRejected(
                f"the board's state is {board.state}; `reset()` leaves it", moved=False
            )
        for _ in range(2):
            if (yield from self.exchange.clean_line()):
                refused = yield from self._set_modes()
                if refused is None or not board.polls.stray:
                    return refused
            if not (yield from self.stops.free()):
                break
        return RequestRejected(UNREAD, moved=False)

    def _set_modes(self) -> Generator[float, HostEvent | None, RequestRejected | None]:
        """Put the parser into the modes that our lines are written for: harmless to repeat."""
        heard: HostEvent | None = None
        for _ in range(0 if self.board.modes_set else TRIES):
            if not (yield from self.exchange.clean_line()):
                break
            heard = yield from self.exchange.ask(Modes(relative=True), self.settings.answer_s)
            if isinstance(heard, Acknowledged):
                self.board.modes_set = True
                break
        if self.board.modes_set:
            return None
        return refusal(heard, "the board's modes could not be set")
