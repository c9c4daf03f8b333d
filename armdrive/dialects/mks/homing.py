"""The drives' own homing, in the arm file's groups: each searches for its switch or its stop.

The drive itself counts from zero where it has found that. Nothing here ever sets a zero.
"""

from __future__ import annotations

from collections.abc import Sequence

from armdrive.dialects.bus.group import Act, Phase, Signal, Stages, lead
from armdrive.dialects.bus.observer import MUTE_LOOKS
from armdrive.dialects.mks.stops import Braking, MksStops
from armdrive.dialects.mks.wire import MksWire, Script
from armdrive.tasks import Done, Halted, Progress, RequestRejected
from firmware_protocol.mks import (
    COUNTS_PER_TURN,
    Failed,
    Home,
    HomingState,
    MotorState,
    ReadEncoder,
    ReadHoming,
    ReadState,
)
from firmware_protocol.mks import Done as Ended

HOMING_POLL_S = 0.05
BEYOND = 1.1
"""A search that goes this much farther than a motor's whole range will find nothing."""


class MksHoming:
    """Has drives home themselves."""

    def __init__(self, wire: MksWire, stops: MksStops, ranges: Sequence[float]) -> None:
        self._wire, self._stops = wire, stops
        self._ranges = dict(zip(wire.nodes, ranges, strict=True))
        """How far each motor turns, in counts, from one end of its joints' limits to the other."""

    def home(self, groups: tuple[tuple[int, ...], ...]) -> Script:
        """Home group after group; all drives, one after the other, where none is named."""
        wire = self._wire
        for group in groups or tuple((motor,) for motor in range(len(wire.drives))):
            reply = yield from self._home_group(tuple(wire.nodes[motor] for motor in group))
            if not isinstance(reply, Done):
                return reply
        return Done()

    def _home_group(self, nodes: tuple[int, ...]) -> Script:
        wire = self._wire
        answers = yield from wire.ask(dict.fromkeys(nodes, Home()), tries=1, text="HOME")
        for node in nodes:
            wire.drive(node).moving = True
        searching = Searching(wire, nodes, self._ranges)
        braking = Braking(wire, self._stops, ())
        refused = [node for node in nodes if isinstance(answers.get(node), Failed)]
        if refused:
            searching.wrong = f"{wire.drive(refused[0])} refused to home"
        searching.left -= {node for node in nodes if isinstance(answers.get(node), Ended)}

        def stop() -> None:
            """Stop them dead: they obey no ramp while they home."""
            nonlocal braking
            braking = self._stops.brake(nodes, hard=True)

        stages: Stages = {Phase.HOMING: lambda: searching, Phase.STOPPING: lambda: braking}
        acts = {Act.STOP_DEAD: stop, Act.HOLD: lambda: self._stops.hold(braking)}
        yield from lead(wire, Phase.HOMING, stages, acts)
        if searching.wrong:
            return RequestRejected(searching.wrong)
        if searching.left:
            return self._stops.unstopped(braking) or Halted(kept=False)
        for node in nodes:
            wire.host.settle(node)
            wire.drive(node).moving = False
        return Done()


class Searching:
    """Drives search for their switches."""

    def __init__(self, wire: MksWire, nodes: Sequence[int], ranges: dict[int, float]) -> None:
        self._wire = wire
        self.left = set(nodes)
        self.wrong = ""
        """What went wrong, in words."""
        self._given_up_s = wire.now_s + wire.settings.homing_s
        self._start = {node: wire.drive(node).count or 0 for node in nodes}
        self._most = {node: BEYOND * ranges[node] + COUNTS_PER_TURN for node in nodes}
        self._due_s = wire.now_s
        wire.homing.clear()

    def signal(self, now_s: float) -> Signal | None:
        """Return what has become of it."""
        if self._wire.stop_asked and self.left:
            return Signal.STOP
        if not self.wrong:
            self._look()
        if not self.wrong and self.left and now_s > self._given_up_s:
            self.wrong = f"{self._wire.drive(min(self.left))} found no switch"
        if self.wrong:
            return Signal.TROUBLE
        return None if self.left else Signal.THERE

    def speak(self, now_s: float) -> float:
        """Ask where they are, before the rest: at their zeros the counts begin anew."""
        if now_s < self._due_s:
            return self._due_s
        self._due_s = now_s + HOMING_POLL_S
        wire = self._wire
        for node in sorted(self.left):
            wire.states.pop(node, None)
            wire.homing.pop(node, None)
            for question in (ReadEncoder(), ReadHoming(), ReadState()):
                wire.put(node, question)
        wire.tell(Progress(wire.registers()))
        return self._due_s

    def _look(self) -> None:
        wire = self._wire
        for node in sorted(self.left):
            drive, told = wire.drive(node), wire.homing.get(node)
            if drive.ledger.unheard_looks > MUTE_LOOKS:
                self.wrong = wire.absent_words((node,))
            elif told is HomingState.FAILED:
                self.wrong = f"{drive} did not find its switch or stop"
            elif told is HomingState.DONE and wire.states.get(node) is MotorState.STOPPED:
                self.left.discard(node)
            elif abs((drive.count or 0) - self._start[node]) > self._most[node]:
                self.wrong = f"{drive} found no switch within its joints' limits"
