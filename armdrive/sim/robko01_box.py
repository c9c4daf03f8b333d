"""The board of a simulated Robko 01: what its firmware does with each request, until power is cut.

Requests are answered one at a time, each a little after it has come. A frame that is none, and a
request that the firmware names but does not know, is dropped in silence.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from armdrive.sim.drive import Drive
from armdrive.sim.uncoordinated import UncoordinatedRack
from armdrive.sim.world import World
from firmware_protocol.robko01 import (
    AXES,
    Acknowledged,
    Answer,
    Axes,
    Busy,
    Clear,
    Device,
    Disable,
    Enable,
    GetRobotId,
    Ignored,
    Inputs,
    InputsRead,
    IsMoving,
    LoadPosition,
    MoveAbsolute,
    MoveRelative,
    MoveSpeed,
    Moving,
    Op,
    Outputs,
    OutputsSet,
    Ping,
    Pong,
    Position,
    Positions,
    Request,
    RobotId,
    SavePosition,
    SetRobotId,
    Status,
    Stop,
    wrap,
)
from kinematics.spaces import Motors

THINKS_S = 0.0025
"""A ping of eight bytes went round in 5 ms; the rest of that was the line's."""
EARLY_ZERO_S = 0.010
"""So long behind an accepted move `IsMoving` may still answer that nothing moves."""
AVR, ESP32 = "avr", "esp32"


@dataclass(frozen=True, slots=True)
class RobkoHabits:
    """What differs between boards: see `robko01_twin` for each.

    With `grid_s` a motor has a chance to make a step only so often. `watchdog_s` of silence
    switch the motors off (0: there is no watchdog); with `rearms` any frame switches them on.
    """

    board: str = AVR
    acceleration_steps_s2: float = 700.0
    grid_s: float = 0.008
    slowness: float = 0.0
    watchdog_s: float = 0.0
    rearms: bool = False


class RobkoDrive(Drive[UncoordinatedRack]):
    """Axes that go their own way; without current the counts go on and the arm does not."""

    def __init__(self, world: World, habits: RobkoHabits) -> None:
        stretch = 1.0 + habits.slowness
        rack = UncoordinatedRack(
            (0,) * len(world.motors),
            acceleration_hz_s=habits.acceleration_steps_s2 / stretch**2,
            grid_s=habits.grid_s * stretch,
            stagger_s=habits.grid_s * stretch / 8,
        )
        super().__init__(world, rack)

    def _follow(self, now_s: float) -> None:
        if not self.world.energised:
            self._driven = Motors(self.rack.positions(now_s))
        super()._follow(now_s)


class RobkoBox:
    """Requests in, answers out, motors turned; answers are appended to `said`."""

    def __init__(
        self,
        drive: RobkoDrive,
        habits: RobkoHabits,
        said: bytearray,
        inputs_set: Callable[[], int],
    ) -> None:
        self.habits = habits
        self.enabled = False
        self.outputs = 0
        self.dropped = 0
        self._drive = drive
        self._said = said
        self._inputs_set = inputs_set
        self._codec = Device()
        self._answer_s = math.inf
        self._accepted_s = -math.inf
        self._fed_s = -math.inf
        self._by_speed = False

    @property
    def unanswered(self) -> bool:
        """Whether a request is being thought about."""
        return self._codec.unanswered is not None

    @property
    def registers(self) -> Motors:
        """The positions as they are reported: in 16 bits."""
        return Motors(wrap(count) for count in self._drive.counts)

    @property
    def due_s(self) -> float:
        """When it answers, or its watchdog runs out."""
        watched = self.habits.watchdog_s and self.enabled
        return min(self._answer_s, self._fed_s + self.habits.watchdog_s if watched else math.inf)

    def receive(self, data: bytes, now_s: float) -> None:
        """Take bytes; each request is thought about for a while."""
        self._codec.receive_data(data)
        self._take_up(now_s)

    def happen(self, now_s: float) -> None:
        """Answer, or act on the watchdog, where that is due."""
        if self._answer_s <= now_s:
            self._answer_s = math.inf
            request = self._codec.unanswered
            if request is not None:
                self._reply(request, now_s)
            self._take_up(now_s)
        elif self.due_s <= now_s:
            self._switch(False, now_s)

    def _take_up(self, now_s: float) -> None:
        while not self.unanswered and (heard := self._codec.next_event()) is not None:
            if isinstance(heard, Ignored):
                self.dropped += 1
            else:
                self._answer_s = now_s + THINKS_S

    def _reply(self, request: Request, now_s: float) -> None:
        if self.habits.rearms and not self.enabled:
            self._switch(True, now_s)
        if isinstance(request, Ping | Inputs | Position) or self.habits.rearms:
            self._fed_s = now_s
        if isinstance(request, SavePosition | LoadPosition):
            self._codec.forget()
        else:
            self._said += self._codec.send(self._do(request, now_s))

    def _do(self, request: Request, now_s: float) -> Answer:
        match request:
            case Ping(payload):
                return Pong(payload)
            case Inputs():
                return InputsRead(self._inputs_set())
            case IsMoving():
                early = now_s < self._accepted_s + EARLY_ZERO_S
                return Moving(0 if early else self._drive.rack.mask(now_s))
            case Position():
                return Positions(self._where(now_s))
            case MoveRelative(axes) | MoveAbsolute(axes):
                return self._move(request.op, axes, request.op is Op.MOVE_RELATIVE, now_s)
            case MoveSpeed(axes):
                return self._run(axes, now_s)
            case Outputs(value):
                self.outputs = value
                return self._outputs_set()
            case SetRobotId(robot_id) | GetRobotId(robot_id):
                return RobotId(request.op, robot_id)
            case _:
                self._command(request, now_s)
                return Acknowledged(request.op)

    def _command(self, request: Request, now_s: float) -> None:
        match request:
            case Stop() if not self._by_speed:
                self._drive.rack.ramp_down(now_s)
            case Enable():
                self._switch(True, now_s)
            case Disable():
                self._switch(False, now_s)
            case Clear():
                self._drive.set_counts((0,) * AXES, now_s)
            case _:
                pass  # a Stop that means nothing to axes which run by speed

    def _outputs_set(self) -> Answer:
        if self.habits.board == AVR:
            return Acknowledged(Op.OUTPUTS)
        return OutputsSet(self.outputs)

    def _where(self, now_s: float) -> Axes:
        speeds = (wrap(round(speed)) for speed in self._drive.rack.speeds(now_s))
        return Axes(tuple(self.registers), tuple(speeds))

    def _switch(self, on: bool, now_s: float) -> None:
        self.enabled = on
        if on:
            self._fed_s = max(self._fed_s, now_s)
            self._drive.energise()
        else:
            self._drive.world.cut_current(now_s)

    def _move(self, op: Op, axes: Axes, relative: bool, now_s: float) -> Answer:
        rack = self._drive.rack
        if not self.enabled:
            return Acknowledged(op, Status.ERROR)
        if mask := rack.mask(now_s):
            return Busy(op, mask)
        here = rack.positions(now_s)
        for axis, (steps, speed) in enumerate(
            zip(axes.positions_steps, axes.speeds_steps_s, strict=True)
        ):
            goal = here[axis] + steps if relative else steps
            if goal != here[axis]:
                rack.move_to(axis, goal, self._hz(abs(speed)), now_s)
        self._by_speed = False
        self._accepted_s = now_s
        return Acknowledged(op)

    def _run(self, axes: Axes, now_s: float) -> Answer:
        if not self.enabled:
            return Acknowledged(Op.MOVE_SPEED, Status.ERROR)
        for axis, speed in enumerate(axes.speeds_steps_s):
            self._drive.rack.run(axis, self._hz(speed), now_s, ramp=False)
        self._by_speed = any(axes.speeds_steps_s)
        return Acknowledged(Op.MOVE_SPEED)

    def _hz(self, speed_steps_s: float) -> float:
        return speed_steps_s / (1.0 + self.habits.slowness)
