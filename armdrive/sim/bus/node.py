"""One drive on a simulated CAN bus: its motor, its supply and its cable.

These are the parts of every kind of drive. `BusNode` is what a kind adds: which frames it obeys and
sends, and when it acts by itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.mechanics.motors import LimitSwitch, switch_places
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.world.saved import Json
from firmware_protocol.frames import Frame
from kinematics.text import counted


def node_ids(ids: Sequence[int] | None, count: int) -> tuple[int, ...]:
    """Return one id for each of `count` motors, from an arm file's ids. Raises `BadRequest`."""
    numbers = tuple(ids or range(1, count + 1))[:count]
    if len(numbers) < count:
        raise BadRequest(
            f"ids of {counted(len(numbers), 'drive')} cannot turn {counted(count, 'motor')}"
        )
    return numbers


# --- The motor, and the limit switch on its shaft ------------------------------------------------


class NodeMotor:
    """One motor of the arm as its drive sees it. Counts are those of its encoder."""

    def __init__(self, shafts: ShaftDrive, index: int, switch_at: int, way: int = 1) -> None:
        self.index = index
        self.point = shafts.rack.each[index]
        """Its set-point."""
        self._shafts = shafts
        self.zero = self.shaft
        """The shaft position at which the drive counts zero."""
        self.switch = LimitSwitch(lambda: self.shaft, switch_at, way)

    @property
    def shaft(self) -> int:
        """The physical position of the shaft."""
        return self._shafts.shafts[self.index]

    @property
    def counts(self) -> int:
        """The position that the drive reports."""
        return self.shaft - self.zero

    @property
    def holding(self) -> bool:
        """Whether it has current."""
        return self._shafts.holding[self.index]

    @property
    def moving(self) -> bool:
        """Whether its set-point was moving at the last update."""
        return self.point.moving(self._shafts.rack.now_s)

    def count_from(self, counts: int) -> None:
        """Make the drive count from this number; nothing turns."""
        self.zero = self.shaft - counts

    def look(self, now_s: float) -> None:
        """Move all shafts to where their position loops have brought them by now."""
        self._shafts.look(now_s)

    def hold(self, now_s: float) -> None:
        """Switch its current on: it holds the shaft where it is."""
        self._shafts.hold(self.index, now_s)

    def release(self, now_s: float) -> None:
        """Switch its current off: its load sags."""
        self._shafts.release((self.index,), now_s)

    def recall(self, holding: bool) -> None:
        """Restore whether it holds; nothing sags, since the saved arm has sagged already."""
        self._shafts.holding[self.index] = holding
        self._shafts.world.energised = all(self._shafts.holding)


def motors_of(config: ArmConfig, shafts: ShaftDrive, *, beyond: int = 0) -> list[NodeMotor]:
    """Return the motors, with switches `beyond` counts after the end of homing by the arm file."""
    turning = shafts.world.body.transmission
    places = switch_places(config, turning, (beyond,) * len(turning.motors))
    return [NodeMotor(shafts, index, at, way) for index, (at, way) in enumerate(places)]


# --- The drive -----------------------------------------------------------------------------------


class NodePort:
    """A drive's supply and its connection to the bus."""

    def __init__(self) -> None:
        self.send: Callable[[Frame], None] = lambda _frame: None
        """Puts a frame on the bus; its board provides that."""
        self.answer_s = 0.001
        """How long the drive takes to prepare a frame: a guess, see each kind's quirks."""
        self.powered = self.plugged = True
        self.mute = False
        """Whether the drive sends nothing, although it receives and obeys."""
        self.withheld = False
        """Whether it does not report the end of a motion."""
        self.boots_s = -math.inf
        """When its firmware has started; minus infinity once it has."""

    @property
    def booting(self) -> bool:
        """Whether its firmware is still starting."""
        return self.boots_s > -math.inf

    @property
    def awake(self) -> bool:
        """Whether it has power and has started."""
        return self.powered and not self.booting

    def say(self, frame: Frame | None) -> None:
        """Put a frame on the bus, if there is one."""
        if frame is not None and self.powered and self.plugged and not self.mute:
            self.send(frame)


class BusNode(Protocol):
    """A drive on one motor, as its board sees it. The board calls `live` whenever `due_s` has come.

    A brown-out or a reset frees the shaft and drops whatever was under way (`forget`). Then the
    firmware starts: when power returns (`begin`), or by itself some time after a reset (`restart`).
    """

    motor: NodeMotor
    port: NodePort

    def listens(self, can_id: int) -> bool:
        """Return whether it takes frames with an id from the bus."""

    def receive(self, frame: Frame, now_s: float) -> None:
        """Take a frame that it listens for."""

    def due_s(self) -> float:
        """Return when it next acts by itself, apart from controlling its shaft."""

    def live(self, now_s: float) -> None:
        """Do what is due by now."""

    def forget(self, now_s: float) -> None:
        """Release the shaft, and forget what is lost without power."""

    def begin(self, now_s: float) -> None:
        """Start after power has returned."""

    def restart(self, now_s: float) -> None:
        """Start again. Until then it holds no shaft and answers nothing."""

    def set_id(self, node: int, now_s: float) -> int:
        """Change the id, as its keys or switches do; return the old one. Raises `BadRequest`."""

    def set_mode(self, mode: int, now_s: float) -> int:
        """Change the mode, as its keys do; return the old one. Raises `BadRequest`."""

    @property
    def busy(self) -> bool:
        """Whether it is carrying out an order."""

    def seen(self, error: int, now_s: float) -> dict[str, Json]:
        """Return the data it would report, given its shaft's distance from the set-point."""

    def known(self) -> Any:
        """Return its state, and `powered`, as a dataclass to be saved."""

    def recall(self, saved: Any) -> None:
        """Restore what `known` returned, once its power is known. Raises `StateFileError`."""


def switch_power(node: BusNode, on: bool, now_s: float) -> None:
    """Switch a drive's supply off or on."""
    if not on:
        node.forget(now_s)
    node.port.powered = on
    if on:
        node.begin(now_s)
