"""The drives' own homing, in the arm file's groups: each searches for its switch or its stop.

The drive itself counts from zero where it has found that. Nothing here ever sets a zero.
"""

from __future__ import annotations

from collections.abc import Generator

from armdrive.dialects.mks.arrival import Ending, MksArrival
from armdrive.dialects.mks.stops import MUTE_LOOKS
from armdrive.tasks import Done, Halted, Progress, RequestRejected
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    Answered,
    Event,
    Failed,
    Home,
    HomingRead,
    HomingState,
    MotorState,
    ReadHoming,
    Started,
)
from firmware_protocol.mks import Done as Ended

HOMING_POLL_S = 0.05
BEYOND = 1.1
"""A search that goes this much farther than a motor's whole range will find nothing."""


class MksHoming(MksArrival):
    """Has drives home themselves."""

    ranges: tuple[float, ...] = ()
    """How far each motor turns, in counts, from one end of its joints' limits to the other."""

    def home(self, groups: tuple[tuple[int, ...], ...]) -> Ending:
        """Home group after group; all drives, one after the other, where none is named."""
        if not self.on:
            return RequestRejected("its motors are disabled: call `enable()`", moved=False)
        for group in groups or tuple((motor,) for motor in range(len(self.drives))):
            reply = yield from self._home_group(tuple(self.nodes[motor] for motor in group))
            if not isinstance(reply, Done):
                return reply
        return (yield from self.take_up()) or Done()

    def _home_group(self, nodes: tuple[int, ...]) -> Ending:
        began_s = self.now_s
        answers = yield from self.ask(dict.fromkeys(nodes, Home()), tries=1, text="HOME")
        for node in nodes:
            self.drive(node).moving = True
        refused = [node for node in nodes if isinstance(answers.get(node), Failed)]
        if refused:
            return (yield from self._end(nodes, f"{self.drive(refused[0])} refused to home"))
        left = set(nodes)
        left -= {node for node in nodes if isinstance(answers.get(node), Ended)}
        mute = dict.fromkeys(nodes, 0)
        start = {node: self.drive(node).seen or 0 for node in nodes}
        while left:
            if self.stop_asked:
                halted = yield from self.halt(nodes, hard=True)  # it obeys no ramp while it homes
                return halted or Halted(kept=False)
            if self.now_s > began_s + self.settings.homing_s:
                return (yield from self._end(nodes, f"{self.drive(min(left))} found no switch"))
            asked_s = self.now_s
            failed = yield from self._watch_homing(left, mute, start)
            if failed:
                return (yield from self._end(nodes, failed))
            yield from self._listen(asked_s + HOMING_POLL_S, left)
        for node in nodes:
            self._host.settle(node)
            self.drive(node).moving = False
        return Done()

    def _watch_homing(
        self, left: set[int], mute: dict[int, int], start: dict[int, int]
    ) -> Generator[float, Event | None, str]:
        """Look at drives that home; forget those that have ended, and say what went wrong."""
        yield from self.look_once(left)  # before the rest: at the zero the counts begin anew
        found = yield from self.ask(dict.fromkeys(left, ReadHoming()), tries=1)
        states = yield from self.states_once(left)
        self.tell(Progress(self.registers()))
        for node in tuple(left):
            heard, state = found.get(node), states.get(node)
            mute[node] = 0 if node in found or node in states else mute[node] + 1
            if mute[node] >= MUTE_LOOKS:
                return self.absent_words((node,))
            read = heard.answer if isinstance(heard, Answered) else None
            told = read.by_command if isinstance(read, HomingRead) else None
            if told is HomingState.FAILED:
                return f"{self.drive(node)} did not find its switch or stop"
            if state is MotorState.STOPPED and told is HomingState.DONE:
                left.discard(node)
            elif abs((self.drive(node).seen or 0) - start[node]) > self._most(node):
                return f"{self.drive(node)} found no switch within its joints' limits"
        return ""

    def _most(self, node: int) -> float:
        return BEYOND * self.ranges[self.nodes.index(node)] + COUNTS_PER_TURN

    def _listen(self, until_s: float, left: set[int]) -> Generator[float, Event | None, None]:
        """Let time pass; hear of drives that have ended."""
        while self.now_s < until_s and not self.stop_asked:
            heard = yield until_s
            if isinstance(heard, Ended) and isinstance(heard.request, Home):
                left.discard(heard.node)
            elif isinstance(heard, Started):
                self.heed(heard)
            elif heard is not None:
                self.unasked(heard)

    def _end(self, nodes: tuple[int, ...], words: str) -> Ending:
        """End a homing that went wrong: every drive of the group is stopped."""
        yield from self.halt(nodes, hard=True)
        return RequestRejected(words)
