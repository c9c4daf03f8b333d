"""A TeachMover that is not there: the device side of its dialect on a simulated physical arm.

Where the real arm's habit is unknown the harsher one is built: bytes that come in while a command
is unanswered are lost, the program memory is lost with the power, and after power-up the motors
are without current until the first motion.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from armdrive.errors import BadRequest
from armdrive.sim.device import SimBase
from armdrive.sim.mechanics.motors import DEFAULT_RATES, CoordinatedDrive, RateTable, checked_error
from armdrive.sim.teachmover.box import ControllerBox, TwinSettings, known_json, recall_known
from armdrive.sim.world.arm import World
from armdrive.sim.world.saved import Json, Saved
from firmware_protocol.teachmover import Key, ProgramRow
from kinematics.spaces import Motors

BAUD = 9600


class SimTeachMover(SimBase):
    """The controller box, the arm, and the person beside them; see `TwinSettings` for the rest."""

    title: ClassVar[str] = "TeachMover"
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
        self._box = self._new_box(
            TwinSettings(
                speed_table,
                checked_error(speed_error),
                keeps_input_while_moving,
                delay_unit_s,
                grip_bit,
            )
        )

    @property
    def byte_gap_s(self) -> float:
        """The pause after each byte that it sends, as @DELAY has set it."""
        return self._box.byte_gap_s

    # What can be seen.

    @property
    def busy(self) -> bool:
        """Whether a command is unanswered."""
        return self._box.busy

    @property
    def registers(self) -> Motors:
        """The position registers, which know only what was commanded."""
        return self._box.registers

    @property
    def last_key(self) -> Key:
        """The pendant's key pressed last."""
        return self._box.last_key

    @property
    def inputs(self) -> int:
        """The input byte, the grip switch in it."""
        return self._box.inputs

    @property
    def outputs(self) -> int:
        """The output byte that a STEP wrote last."""
        return self._box.outputs

    @property
    def lost_bytes(self) -> int:
        """How many bytes came in while it was deaf, since power-up."""
        return self._box.lost_bytes

    @property
    def memory(self) -> Mapping[int, ProgramRow]:
        """The program's rows by number."""
        return self._box.memory

    @property
    def speed_error(self) -> float:
        """By which share motions last longer than the speed table says."""
        return self._box.settings.speed_error

    def details(self) -> dict[str, Json]:
        """Return the pendant's key, the outputs, and how wrong the speed is."""
        return {
            "key": self.last_key.name,
            "outputs": self.outputs,
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
            self._box.last_key = key
            if key is Key.STOP:
                self._box.stop_key(self.now_s)

    def pendant_move(self, steps: Sequence[int]) -> None:
        """Move by the pendant, at once; the registers count it. Raises `BadRequest` in motion."""
        self.jog(steps)

    def pendant_returns(self) -> bool:
        """Give control back to the host, answering its @SET; False where it has control."""
        return self._box.give_back(self.now_s)

    def set_input(self, bit: int, on: bool) -> None:
        """Set an input bit; the grip switch's own bit follows the fingers alone."""
        grip = self._box.settings.grip_bit
        if not 0 <= bit < self.input_bits or bit == grip:
            raise BadRequest(f"input bits are 0 to 7 without {grip}, the grip switch; not {bit}")
        super().set_input(bit, on)

    def set_speed_error(self, error: float) -> None:
        """Make motions that begin from now on last longer (0.2: a fifth) or shorter (negative)."""
        self._box.settings = replace(self._box.settings, speed_error=checked_error(error))

    # The box.

    def _new_box(self, settings: TwinSettings) -> ControllerBox:
        return ControllerBox(self._drive, settings, self.said, lambda: self.inputs_set)

    def _hear(self, data: bytes) -> None:
        self._box.receive(data, self.now_s)

    def _motion_ended(self) -> None:
        self._box.motion_ended(self.now_s)

    def _forget(self) -> None:
        self._box = self._new_box(self._box.settings)

    def _known(self) -> dict[str, Json]:
        return known_json(self._box)

    def _recall_known(self, saved: Saved) -> None:
        recall_known(self._box, saved)
