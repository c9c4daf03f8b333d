"""Finding a GRBL board, and bringing it to where it reads lines again. Nothing here moves."""

from __future__ import annotations

from collections.abc import Generator

from armdrive.dialects.grbl.exchange import REPORTS_TO_OFFSET, Answering, Asking, refusal
from armdrive.dialects.grbl.receive import TURNING
from armdrive.dialects.grbl.stops import DEAF, GrblStopping
from armdrive.tasks import Done, RequestRejected, Timeout
from firmware_protocol.grbl import (
    Acknowledged,
    QueryBuildInfo,
    Realtime,
    Restarted,
    State,
    StatusReported,
    Unlock,
)
from firmware_protocol.grbl.events import Event as HostEvent

TRIES = 3
"""How often the board's build is asked for."""
REPORTS_ALIKE = 2
"""A report has no check bytes: that an output is off is believed when it is told so often."""
CRITICAL = (1, 2)
"""After these alarms a board takes no line before a reset; grblHAL goes on to report meanwhile."""
CALM_S = 1.0
"""A motion that a program before this one left behind is waited for so long."""


class GrblContact(GrblStopping):
    """The way to a board that stands and listens."""

    reset_lets_go = False
    """A reset can switch off what the gripper hangs on."""
    outputs_told = True
    """Whether a report tells that what the gripper hangs on is switched on."""

    def contact(self) -> Generator[float, HostEvent | None, Timeout | RequestRejected | None]:
        """Find the board, whether opening its port has reset it or not. Moves nothing.

        Return what stands against it, where something does.
        """
        began_s = self.now_s
        if not (yield from self._alive()) and not (yield from self.soft_reset()):
            self.last_said = "? (and to a reset)"
            return self.silence(began_s)
        if not (yield from self._calm_down()):
            return self.silence(began_s)
        # a reset may have been lost, or not been made
        if not (yield from self.spoil()) and not (yield from self.soft_reset()):
            return self.silence(began_s)
        yield from self._recognise()
        yield from self.look(self.settings.answer_s)  # which counts its axes, where they are untold
        if self.lacking:
            return RequestRejected(self._lacking_words(), moved=False)
        self.press(Realtime.FEED_100)
        self.contacted = True
        return None

    def _recognise(self) -> Generator[float, HostEvent | None, None]:
        """Ask for the board's build until it is told without a flaw."""
        for _ in range(TRIES):
            garbled = self.garbled
            heard = yield from self.ask(QueryBuildInfo(), self.settings.answer_s)
            self.recognised = isinstance(heard, Acknowledged) and self.garbled == garbled
            if self.recognised and not self.lacking:  # a letter may have been damaged, too
                return

    def _lacking_words(self) -> str:
        axes = self._host.dialect.axes
        return (
            f"the board has {len(axes)} axes ({axes}), and by grbl.axes this arm has motors on "
            f"{', '.join(self.lacking)} too: take a board and a firmware with an axis for each "
            "motor (grbl-Mega-5X, grblHAL, FluidNC), or put the right letters into grbl.axes"
        )

    def _alive(self) -> Generator[float, HostEvent | None, bool]:
        """Wait for a banner or a report; a board that is starting answers nothing for a while."""
        end_s = self.now_s + self.settings.boot_s
        while self.now_s < end_s:
            self.press(Realtime.STATUS)
            again_s = min(self.now_s + 2.0 * self.settings.poll_s, end_s)
            while self.now_s < again_s:
                heard = yield from self.listen(again_s)
                if isinstance(heard, StatusReported | Restarted):
                    return True
        return False

    def _calm_down(self) -> Asking:
        """See to it that the board stands and reads lines, whatever an earlier program left.

        A reset forgets a half line. In Idle it keeps position and state, $22 or not (gnea/grbl
        grbl/main.c: the prior state and sys_position stay), and the motors where $1 is 255.
        """
        if not (yield from self.look(self.settings.answer_s)):
            return True
        end_s = self.now_s + CALM_S
        while self.state in TURNING and self.now_s < end_s:
            yield from self.pause(self.now_s + self.settings.poll_s)
            yield from self.look(self.settings.answer_s)
        if self.state in TURNING or (self.state is State.HOLD and self.sub_state):
            yield from self.hold()
        elif self.state in DEAF or not (yield from self._may_let_go()):
            return (yield from self.soft_reset())
        return True

    def _may_let_go(self) -> Asking:
        """Tell whether a reset may open the gripper.

        It does not where reports say, twice, that all that it would switch off is off already.
        They say so with the overrides, every tenth time or twentieth.
        """
        if not (self.reset_lets_go and self.outputs_told):
            return self.reset_lets_go
        told = 0
        for _ in range(REPORTS_TO_OFFSET):
            if not (yield from self.look(self.settings.answer_s)) or self.reported is None:
                break
            report = self.reported.report
            told += report.overrides is not None
            if report.accessories or report.speed:
                break
            if told == REPORTS_ALIKE:
                return False
        return True

    def clear(self) -> Answering:
        """Leave alarm, hold, sleep or muteness; the board's position is as good as it was."""
        began_s = self.now_s
        heard = yield from self.look(self.settings.answer_s)
        critical = self.alarm is not None and self.alarm.code in CRITICAL
        if heard and self.state in TURNING:
            yield from self.hold()
        else:
            may_read = heard and not critical and self.state not in DEAF
            reads = may_read and (yield from self.spoil())
            if not reads and not (yield from self.soft_reset()):
                return self.silence(began_s)
        yield from self.look(self.settings.answer_s)
        if self.state is State.ALARM:
            answer = yield from self.ask(Unlock(), self.settings.answer_s)
            if not isinstance(answer, Acknowledged):
                return refusal(answer, "the board stays locked")
            yield from self.look(self.settings.answer_s)
        if self.state is not State.IDLE:
            return RequestRejected(f"the board's state is {self.state or 'not told'}", moved=False)
        return Done()
