"""A simulated GRBL board: its receive ring, its main loop, and the state that both look at.

One line is at work at a time, as a script that yields when it wants to go on: a time, or infinity
for "when something has happened". Real-time commands are picked out of the stream as they arrive
(`grbl_orders`). What the main loop is doing:

    booting   nothing is read; what arrives is lost when the board has started
    critical  a limit alarm: nothing but a reset is heard
    blocked   in Hold, Door and Sleep, while a jog is cancelled, and hung: lines stay in the ring
    hung      Idle, after a jog cancel that came as the jog ended: a resume or a reset frees it
    else      the line at work goes on, or the next one is taken out of the ring

Sources: gnea/grbl grbl/protocol.c, serial.c, motion_control.c and stepper.c (st_go_idle).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

from armdrive.sim.grbl_build import Build
from armdrive.sim.grbl_drive import BoardDrive
from armdrive.sim.grbl_limits import HardLimits
from armdrive.sim.grbl_outputs import Outputs
from armdrive.sim.grbl_parser import Parser
from armdrive.sim.grbl_ring import Ring
from armdrive.sim.grbl_script import Makers, Task
from armdrive.sim.grbl_settings import Settings
from armdrive.sim.grbl_status import Reporter
from armdrive.sim.grbl_switches import Switches
from firmware_protocol.grbl import (
    GRBLHAL_ONLY,
    Answer,
    Device,
    Error,
    LineReceived,
    Ok,
    Realtime,
    State,
)

_BLOCKING = (State.HOLD, State.DOOR, State.SLEEP)
_PICKED = re.compile(rb"[\x18!?~\x80-\xff]")
_PICKED_BY_GRBLHAL = re.compile(rb"[\x18\x19!?~\x80-\xff]")


class Board:
    """Everything that the firmware knows and does. Answers are appended to `said`."""

    def __init__(
        self,
        build: Build,
        settings: Settings,
        drive: BoardDrive,
        switches: Switches,
        said: bytearray,
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
        self.parser = Parser(build.axes, firmware.unknown)
        self.outputs = Outputs()
        self.outputs_changed = outputs_changed
        self.reporter = Reporter(baud)
        self.ring = Ring(firmware.ring_bytes)
        self.startup = ["", ""]
        self.note = self.inputs = ""
        self.now_s = 0.0
        self.state = State.IDLE
        self.stands = self.cancelling = self.leaving = self.critical = False
        self.hangs = self.hung = False
        self.afterwards: Callable[[], None] | None = None
        self.overrides, self.cancels = [100, 100, 100], 0
        self.deaf_until_s = -math.inf
        self.idle_off_s = math.inf
        self.boot: Task[None] = Task()
        self.limits = HardLimits()
        self._line: Task[Ok | Error] = Task()
        self._said = said
        self.makers = makers
        self._picked = _PICKED_BY_GRBLHAL if firmware.grblhal else _PICKED
        known = set(Realtime) if firmware.grblhal else set(Realtime) - GRBLHAL_ONLY
        self._orders = {int(one): one for one in known}

    # What others look at.

    @property
    def blocked(self) -> bool:
        """Whether the main loop goes on with no line."""
        held = self.state in _BLOCKING or self.cancelling or self.hung
        return held or self.boot.active or self.critical

    @property
    def at_work(self) -> bool:
        """Whether a line is at work, or lines wait, or something moves."""
        return self._line.active or len(self.ring) > 0 or self.drive.rack.waiting > 0

    @property
    def full(self) -> bool:
        """Whether the planner takes no more lines."""
        blocks = self.firmware.blocks
        return self.drive.rack.waiting >= blocks and self.drive.queued(self.now_s) >= blocks

    def say(self, answer: Answer) -> None:
        """Send something."""
        self._said += self.codec.send(answer)

    # The wire.

    def hear(self, data: bytes, now_s: float) -> None:
        """Take bytes as the receive interrupt does."""
        self.now_s = now_s
        if now_s < self.deaf_until_s:
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
        """Tell when the board next does something by itself."""
        return min(
            math.inf if self.blocked else self._line.until_s,
            self.boot.until_s,
            self.drive.next_s,
            self.idle_off_s,
            self.limits.due_s,
            self.reporter.due_s(self),
        )

    def happen(self, now_s: float) -> None:
        """Do what is due."""
        self.now_s = now_s
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
        """Go on with lines as far as there is something to do."""
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
        """Take a line out of the ring; False where none is whole."""
        while data := self.ring.take_line():
            self.codec.receive_data(data)
            request = self.codec.next_event()
            if isinstance(request, LineReceived):
                self._line.begin(self.makers.line(self, request), self.now_s)
                return True
        return False

    # Motion.

    def autostart(self) -> None:
        """Begin to follow the lines that are queued, as soon as no more are coming."""
        if self.state is State.IDLE and self.drive.rack.waiting:
            self.set_going(State.RUN)

    def set_going(self, state: State) -> None:
        """Switch the motors on and follow the queue."""
        self.drive.energise()
        self.idle_off_s = math.inf
        self.drive.rack.resume(self.now_s)
        self.state = state

    def kill(self) -> None:
        """Stop dead."""
        self.drive.kill(self.now_s, self.coast)
        self.cancelling = self.stands = self.leaving = False

    def let_motors_go(self) -> None:
        """Switch the motors off after the idle delay, even where $1 leaves them on."""
        self.idle_off_s = self.now_s + self.settings.idle_s

    def alarm(self, code: int) -> None:
        """Lock the board by a limit alarm, until it is reset."""
        self.makers.critical(self, code)

    def _stood(self) -> None:
        """Act on motors that have come to a stand."""
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

    # Starting anew.

    def forget(self) -> None:
        """Lose what is lost with the power, and with a reset of the whole board."""
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
        """Leave the line at work; as the firmware falls out of it, it is answered with ok."""
        if self._line.active:
            self._line.end()
            if self.codec.unanswered:
                self.say(Ok())
