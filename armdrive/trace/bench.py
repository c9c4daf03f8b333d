"""A simulated twin on simulated time, brought to where a recording begins, fed with its bytes."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence

from armdrive.config.arm import ArmConfig
from armdrive.dialects.words import Message, Weight
from armdrive.errors import ArmError, BadRequest, RecordingError
from armdrive.registry.simulate import simulate_device
from armdrive.sim.device import SimDevice, Value, state_json, state_line
from armdrive.sim.simulated_arm import DIALECT
from armdrive.sim.wire import PacedDevice
from armdrive.sim.world.saved import Json
from armdrive.trace.describe import talk
from kinematics.errors import KinematicsError

Said = deque[tuple[float, Message]]

ANSWER_S = 2.0
"""A twin that stands has answered by then, or never will."""
MOTION_S = 300.0
"""So long its motions are waited for."""
_STALLED = 1000


class ReplayBench:
    """One twin. `late_s` is how far it has fallen behind the arm that was recorded.

    `passing` is the last of its reports that tell of a moment.
    """

    def __init__(self, config: ArmConfig, settings: Mapping[str, Value] | None = None) -> None:
        self.late_s = 0.0
        self.now_s = 0.0
        self._config = config
        self._settings = settings
        self._answers: Said = deque()
        self._banners: Said = deque()
        self.passing: Message | None = None
        self._passed_s = -math.inf
        self._splitter = talk(config.connection.dialect).splitter()
        self._make(None)

    @property
    def words(self) -> str:
        """The physical state of the twin in one line."""
        return state_line(self._device)

    @property
    def view(self) -> dict[str, Json]:
        """The physical state of the twin as plain data."""
        return state_json(self._device)

    @property
    def passing_s(self) -> float:
        """When that report came, on the recording's clock."""
        return self._passed_s - self.late_s

    @property
    def moving(self) -> bool:
        """Whether its motors turn."""
        return self._device.moving

    @property
    def registers(self) -> tuple[int, ...]:
        """What its controller would tell."""
        return tuple(self._device.registers)

    def place(self, registers: Sequence[int], position: Sequence[int] | None) -> None:
        """Have its controller count from there, and its motors stand at a position if one is known.

        Raises `RecordingError` for counts that such a controller cannot have.
        """
        saved = self._device.to_json()
        saved["registers"] = list(registers)
        world = saved["world"]
        if position is not None and isinstance(world, dict):
            world["motors"] = list(position)
        self._make({DIALECT: self._config.connection.dialect, **saved})
        self._answers.clear()
        self._banners.clear()
        self._line.advance(self.now_s)

    def send(self, data: bytes, time_s: float) -> None:
        """Give it bytes at a time of the recording."""
        self.advance(time_s)
        self._line.send(data, self.now_s)

    def advance(self, time_s: float) -> None:
        """Let it live up to a time of the recording."""
        self._live(time_s + self.late_s)

    def answer(self, time_s: float) -> Message | None:
        """Return its next answer, waiting for it beyond a time of the recording where it must.

        None where none comes. What it is late by is added to every time from then on.
        """
        return self._next(self._answers, time_s)

    def banner(self, time_s: float) -> Message | None:
        """Return its next banner in the same way."""
        return self._next(self._banners, time_s)

    def forget_banners(self) -> None:
        """Take no notice of how it began."""
        self._banners.clear()

    def stand(self, time_s: float) -> bool:
        """Let its motors come to rest, beyond a time of the recording where it must."""
        self.advance(time_s)
        due_s = self.now_s
        while self.moving and self.now_s < due_s + MOTION_S:
            self._live(max(min(self._line.next_s(), due_s + MOTION_S), self.now_s))
        self.late_s += self.now_s - due_s
        return not self.moving

    def unasked(self, before_s: float = math.inf) -> Message | None:
        """Return an answer from before a time that the recorded arm has not given."""
        if self._answers and self._answers[0][0] <= before_s + self.late_s:
            return self._answers[0][1]
        return None

    def _next(self, said: Said, time_s: float) -> Message | None:
        self.advance(time_s)
        due_s = self.now_s
        while not said and self._waits(due_s):
            self._live(min(max(self._line.next_s(), self.now_s), due_s + MOTION_S))
        if not said:
            return None
        self.late_s += self.now_s - due_s
        return said.popleft()[1]

    def _waits(self, due_s: float) -> bool:
        next_s = self._line.next_s()
        patient_s = MOTION_S if self.moving else ANSWER_S
        return max(next_s, self.now_s) < due_s + patient_s

    def _live(self, time_s: float) -> None:
        """Take what it says up to a time on its own clock, each thing at its moment."""
        idle = 0
        while (due_s := self._line.next_s()) < time_s and idle < _STALLED:
            idle = 0 if due_s > self.now_s else idle + 1
            self._take(max(due_s, self.now_s))
        self._take(max(time_s, self.now_s))

    def _take(self, now_s: float) -> None:
        self.now_s = now_s
        for message in self._splitter.feed(self._line.receive(now_s)):
            if message.weight in (Weight.ANSWER, Weight.MOMENT):
                self._answers.append((now_s, message))
            elif message.weight is Weight.BANNER:
                self._banners.append((now_s, message))
            elif message.weight is Weight.PASSING:
                self.passing, self._passed_s = message, now_s

    def _make(self, saved: object) -> None:
        try:
            self._device: SimDevice = simulate_device(self._config, saved, settings=self._settings)
        except BadRequest:  # a setting that the caller has chosen
            raise
        except (ArmError, KinematicsError, ArithmeticError, LookupError) as error:
            raise RecordingError(f"no twin can be made of the recorded arm: {error}") from None
        self._line = self._wire()

    def _wire(self) -> PacedDevice:
        network = "://" in self._config.connection.port
        if network and self._device.baud is not None:  # which keeps no pace
            return PacedDevice(self._device, None)
        return self._device.line()
