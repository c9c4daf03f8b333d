"""A simulated GRBL board: its receive ring, its main loop, and the state that both look at.

One line is at work at a time, as a script that yields when it wants to go on: a time, or infinity
for "when something has happened". Real-time commands are picked out of the stream as they arrive
(`grbl_orders`). What the main loop is doing:

    booting   nothing is read; what arrives is lost when the board has started
    critical  a limit alarm: nothing but a reset is heard
    blocked   in Hold, Door and Sleep, and while a jog is cancelled: lines stay in the ring
    else      the line at work goes on, or the next one is taken out of the ring

Sources: gnea/grbl grbl/protocol.c, serial.c, motion_control.c and stepper.c (st_go_idle).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import TypeAlias

from armdrive.sim.grbl_drive import BoardDrive
from armdrive.sim.grbl_firmware import Firmware
from armdrive.sim.grbl_outputs import Outputs
from armdrive.sim.grbl_parser import Parser
from armdrive.sim.grbl_ring import Ring
from armdrive.sim.grbl_settings import HARD_LIMITS, Settings
from armdrive.sim.grbl_status import Reporter
from armdrive.sim.grbl_switches import Switches
from firmware_protocol.grbl import Answer, Device, Error, LineReceived, Ok, Realtime, State

Script: TypeAlias = Generator[float, None, Ok | Error]
"""A line at work; it returns its answer."""
Boot: TypeAlias = Generator[float, None, None]

TICK_S = 0.005
"""How often hard limits are looked at while something moves."""
_BLOCKING = (State.HOLD, State.DOOR, State.SLEEP)
_PICKED = re.compile(rb"[\x18!?~\x80-\xff]")
_PICKED_BY_GRBLHAL = re.compile(rb"[\x18\x19!?~\x80-\xff]")


@dataclass(frozen=True, slots=True)
class Makers:
    """What the board is made to do with lines and real-time commands; in modules of their own."""

    line: Callable[[Board, LineReceived], Script]
    order: Callable[[Board, Realtime], None]
    critical: Callable[[Board, int], None]
    fail: Callable[[Board, int], None]


class Board:
    """Everything that the firmware knows and does. Answers are appended to `said`."""

    def __init__(
        self,
        firmware: Firmware,
        axes: str,
        settings: Settings,
        drive: BoardDrive,
        switches: Switches,
        said: bytearray,
        makers: Makers,
        *,
        baud: int | None,
        coast: float,
        outputs_changed: Callable[[], None],
    ) -> None:
        self.firmware = firmware
        self.axes = axes
        self.settings = settings
        self.drive = drive
        self.switches = switches
        self.coast = coast
        self.codec = Device(firmware.dialect(axes))
        self.parser = Parser(axes)
        self.outputs = Outputs()
        self.outputs_changed = outputs_changed
        self.reporter = Reporter(baud)
        self.ring = Ring(firmware.ring_bytes)
        self.startup = ["", ""]
        self.note = ""
        self.inputs = ""
        self.now_s = 0.0
        self.state = State.IDLE
        self.stands = False
        self.cancelling = False
        self.leaving = False
        self.critical = False
        self.overrides = [100, 100, 100]
        self.deaf_until_s = -math.inf
        self.idle_off_s = math.inf
        self.boot: Boot | None = None
        self._boot_s = math.inf
        self._said = said
        self._makers = makers
        self._job: Script | None = None
        self._job_s = math.inf
        self._tick_s = math.inf
        self._pressed = 0
        self._picked = _PICKED_BY_GRBLHAL if self.codec.dialect.grblhal_realtime else _PICKED

    # What others look at.

    @property
    def blocked(self) -> bool:
        """Whether the main loop goes on with no line."""
        held = self.state in _BLOCKING or self.cancelling
        return held or self.boot is not None or self.critical

    @property
    def at_work(self) -> bool:
        """Whether a line is at work, or lines wait, or something moves."""
        return self._job is not None or bool(self.ring) or self.drive.rack.waiting > 0

    @property
    def full(self) -> bool:
        """Whether the planner takes no more lines."""
        return self.drive.rack.waiting >= self.firmware.blocks

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
            command = _ORDERS.get(data[found.start()])
            if command is not None and self.boot is None:
                self.order(command)
        self.ring.put(data[start:])
        self.run()

    # Time.

    def due_s(self) -> float:
        """Tell when the board next does something by itself."""
        return min(
            math.inf if self.blocked else self._job_s,
            self._boot_s,
            self.drive.rack.next_line_s,
            self.idle_off_s,
            self._tick_s,
            self.reporter.due_s(self),
        )

    def happen(self, now_s: float) -> None:
        """Do what is due."""
        self.now_s = now_s
        if self.boot is not None and self._boot_s <= now_s:
            self.go_on_booting()
        if self.drive.rack.next_line_s <= now_s:
            self.drive.settle(now_s)
            if not self.drive.moving:
                self._stood()
        if self._tick_s <= now_s:
            self.look_at_switches()
        if self.idle_off_s <= now_s:
            self.idle_off_s = math.inf
            self.drive.world.cut_current(now_s)
        self.run()
        if self.reporter.due_s(self) <= now_s:
            self.say(self.reporter.report(self))

    def run(self) -> None:
        """Go on with lines as far as there is something to do at this moment."""
        while not self.blocked:
            if self._job is None:
                data = self.ring.take_line()
                if not data:
                    self.autostart()
                    break
                self.codec.receive_data(data)
                request = self.codec.next_event()
                if isinstance(request, LineReceived):
                    self._job = self._makers.line(self, request)
                    self._job_s = -math.inf
            elif not self._go_on():
                break
        if not self._watching:
            self._tick_s = math.inf
        elif math.isinf(self._tick_s):
            self._tick_s = self.now_s + TICK_S

    def _go_on(self) -> bool:
        """Resume the line at work; False where it waits, or has waited in vain."""
        if self._job is None or not (self._job_s <= self.now_s or math.isinf(self._job_s)):
            return False
        try:
            self._job_s = next(self._job)
        except StopIteration as end:
            self._job, self._job_s = None, math.inf
            if not self.codec.unanswered:  # the board was reset while it was at work
                return True
            self.say(end.value)
            return True
        return self._job_s <= self.now_s

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
        self._makers.critical(self, code)

    def fail(self, code: int) -> None:
        """Lock the board by an alarm after which it starts anew by itself."""
        self._makers.fail(self, code)

    def order(self, command: Realtime) -> None:
        """Carry out a real-time command."""
        self._makers.order(self, command)

    def write_eeprom(self) -> Generator[float, None, None]:
        """Write, with the interrupts off on some boards: what arrives meanwhile is lost."""
        if self.firmware.deaf_in_eeprom:
            self.deaf_until_s = self.now_s + self.firmware.eeprom_s
        yield self.now_s + self.firmware.eeprom_s

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

    # Limits.

    @property
    def _watching(self) -> bool:
        limited = self.settings.on(HARD_LIMITS) and self.state is not State.HOME
        return limited and self.drive.moving and not self.critical

    def look_at_switches(self, *, forget: bool = False) -> None:
        """Raise ALARM:1 where a switch has changed, pressed or let go; `forget` only looks."""
        self._tick_s = math.inf
        before, self._pressed = self._pressed, self.switches.mask()
        deaf = forget or self.state in (State.ALARM, State.HOME) or self.boot is not None
        if self._pressed != before and self.settings.on(HARD_LIMITS) and not deaf:
            self.alarm(1)

    # Starting anew.

    def begin_boot(self, boot: Boot) -> None:
        """Start anew by a script that yields until when it waits; the line at work yields first."""
        self.boot, self._boot_s = boot, self.now_s

    def go_on_booting(self) -> None:
        """Take the next step of starting anew."""
        if self.boot is None:
            return
        try:
            self._boot_s = next(self.boot)
        except StopIteration:
            self.boot, self._boot_s = None, math.inf

    def forget(self) -> None:
        """Lose what is lost with the power, and with a reset of the whole board."""
        if self._job is not None:
            self._job.close()
        self._job, self._job_s = None, math.inf
        self.boot, self._boot_s = None, math.inf
        self.critical = self.stands = self.cancelling = self.leaving = False
        self.state = State.IDLE
        self.deaf_until_s, self.idle_off_s, self._tick_s = -math.inf, math.inf, math.inf
        self.codec.discard()
        self.ring.clear()
        self.outputs.off()
        self.outputs.digital.clear()
        self.outputs.analog.clear()

    def drop_line(self) -> None:
        """Leave the line at work; as the firmware falls out of it, it is answered with ok."""
        if self._job is not None:
            self._job.close()
            self._job, self._job_s = None, math.inf
            if self.codec.unanswered:
                self.say(Ok())


_ORDERS = {int(command): command for command in Realtime}
