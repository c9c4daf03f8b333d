"""The driver's end of the Tutor dialect: neutral requests to lines, lines to replies."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from armdrive.abilities import Abilities
from armdrive.config.arm import ArmConfig
from armdrive.dialects import Driver
from armdrive.dialects.controller import (
    HOST_DELAY_S,
    ScriptRunner,
    StopPart,
    Stopping,
    answer_without_device,
)
from armdrive.dialects.exchange import Script
from armdrive.tasks import (
    Done,
    MoveBy,
    ReadPosition,
    Registers,
    Reply,
    Request,
    RequestRejected,
)
from armdrive.text.toml import check_settings, setting
from firmware_protocol.events import Unreadable
from firmware_protocol.tutor import (
    RATE_MAX_HZ,
    Answer,
    Command,
    Failed,
    Host,
    Move,
    Ok,
    Positions,
    Where,
)
from kinematics.spaces import Motors

DeviceEvent: TypeAlias = Answer | Unreadable

LONGEST_LINE = len("M 2000" + 6 * " -2147483647" + "\n")
LONGEST_ANSWER = len("p" + 6 * " -2147483647" + "\n")


@dataclass(frozen=True, slots=True)
class TutorSettings:
    """The section [tutor] of an arm file."""

    answer_margin_s: float = setting(0.5, "added to every deadline", low=0.1, high=10.0)

    def __post_init__(self) -> None:
        check_settings(self, "tutor")


class TutorController(ScriptRunner[DeviceEvent]):
    """One Tutor board, seen from the driver."""

    def __init__(self, abilities: Abilities, config: ArmConfig) -> None:
        self._host = Host()
        super().__init__(abilities, self._host)
        self._settings: TutorSettings = config.device
        self._byte_s = config.connection.byte_s

    def script(self, request: Request) -> Script[DeviceEvent, Reply]:
        """Send one line and wait for its answer."""
        command = self._command(request)
        if isinstance(command, Reply):
            return command
        io = self.io
        began_s = io.now_s
        data = self._host.send(command)
        wire_s = (len(data) + LONGEST_ANSWER) * self._byte_s
        longest_s = 2.0 * self._motion_s(command) + wire_s + self._settings.answer_margin_s
        # the first one may follow half a line that another program has left in the board
        for _ in range(2 if isinstance(command, Where) else 1):
            io.write(data, data.decode("ascii").strip())
            until_s = io.now_s + longest_s
            message = yield from io.wait_for(until_s, lambda each: isinstance(each, Answer))
            if not isinstance(message, Failed):
                break
        match message:
            case Ok():
                return Done()
            case Positions(steps):
                return Registers(Motors(steps))
            case Failed():
                return RequestRejected("it did not understand the line", moved=False)
            case _:
                self.give_up()
                return io.silence(began_s)

    def _command(self, request: Request) -> Command | Reply:
        match request:
            case MoveBy(steps, rate_hz):
                return Move(int(self.usable_rate_hz(rate_hz)), tuple(steps))
            case ReadPosition():
                return Where()
            case _:
                return answer_without_device(request)

    def _motion_s(self, command: Command) -> float:
        if not isinstance(command, Move):
            return 0.0
        return max(map(abs, command.steps)) / command.rate_hz

    def give_up(self) -> None:
        """Forget half an answer."""
        self._host.discard()

    def usable_rate_hz(self, rate_hz: float) -> float:
        """Return the rate in whole steps a second, at or below the one wanted."""
        return float(math.floor(min(max(rate_hz, 1.0), RATE_MAX_HZ)))  # asked with infinity too

    def duration_s(self, steps: float, rate_hz: float) -> float:
        """Return how long so many steps take."""
        return steps / self.usable_rate_hz(rate_hz)

    def stopping(self, burst_s: float, parts: Sequence[StopPart] = ()) -> Stopping:
        """Return one burst behind its line, since nothing ends a motion early."""
        sent_s = HOST_DELAY_S + LONGEST_LINE * self._byte_s
        return self.whole_burst(burst_s, parts, sent_s)


DRIVER = Driver(TutorSettings, TutorController)
