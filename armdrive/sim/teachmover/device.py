"""A TeachMover that is not there: the device side of its dialect on a simulated physical arm.

Where the real arm's habit is unknown the harsher one is built: bytes that come in while a command
is unanswered are lost, the program memory is lost with the power, and after power-up the motors
are without current until the first motion.
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

from armdrive.errors import BadRequest
from armdrive.sim.device import BoxedDevice
from armdrive.sim.mechanics.motors import DEFAULT_RATES, CoordinatedDrive, RateTable, checked_error
from armdrive.sim.teachmover.box import ControllerBox, TwinSettings
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import Json
from firmware_protocol.teachmover import Key

BAUD = 9600


class SimTeachMover(BoxedDevice):
    """The controller box, the arm, and the person beside them; see `TwinSettings` for the rest."""

    title: ClassVar[str] = "TeachMover"
    box: ControllerBox
    _drive: CoordinatedDrive

    def __init__(
        self,
        world: World | None = None,
        *,
        speed_table: RateTable = DEFAULT_RATES,
        speed_error: float = 0.0,
        baud: int | None = BAUD,
        keeps_input_while_moving: bool = False,
        delay_unit_s: float = 0.001,
        grip_bit: int = 0,
    ) -> None:
        world = world or World()
        super().__init__(world, CoordinatedDrive(world), baud)
        self.box = ControllerBox(
            self._drive,
            self.clock,
            TwinSettings(
                speed_table,
                checked_error(speed_error),
                keeps_input_while_moving,
                delay_unit_s,
                grip_bit,
            ),
            self.said,
            lambda: self.inputs_set,
        )

    @property
    def byte_gap_s(self) -> float:
        """The pause after each byte that it sends, as @DELAY has set it."""
        return self.box.byte_gap_s

    # What can be seen.

    @property
    def inputs(self) -> int:
        """The input byte, the grip switch in it."""
        return self.box.inputs

    @property
    def speed_error(self) -> float:
        """By which share motions last longer than the speed table says."""
        return self.box.settings.speed_error

    def details(self) -> dict[str, Json]:
        """Return the pendant's key, the outputs, and how wrong the speed is."""
        return {
            "key": self.box.last_key.name,
            "outputs": self.box.outputs,
            "speed_error": self.speed_error,
        }

    # What a person can do.

    def key_names(self) -> tuple[str, ...]:
        """Name the pendant's keys."""
        return tuple(key.name for key in Key if key is not Key.NONE)

    def press_named(self, name: str) -> None:
        """Press a key of the pendant by its name, in capitals or not."""
        wanted = name.upper()
        if wanted not in Key.__members__:
            raise BadRequest(
                f"the pendant has no key {name!r}; it has {', '.join(self.key_names())}"
            )
        self.press(Key[wanted])

    def press(self, key: Key) -> None:
        """Press a key of the pendant: STOP ends a motion, a program and the pendant's control."""
        if self.powered:
            self.box.last_key = key
            if key is Key.STOP:
                self.box.stop_key()

    def pendant_returns(self) -> bool:
        """Give control back to the host, answering its @SET; False where it has control."""
        return self.box.give_back()

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit; the grip switch's own bit follows the fingers alone."""
        grip = self.box.settings.grip_bit
        if not 0 <= bit < self.input_bits or bit == grip:
            raise BadRequest(f"input bits are 0 to 7 without {grip}, the grip switch; not {bit}")
        super().set_input(bit, on)

    def set_speed_error(self, error: float) -> None:
        """Make motions that begin from now on last longer (0.2: a fifth) or shorter (negative)."""
        self.box.settings = replace(self.box.settings, speed_error=checked_error(error))
