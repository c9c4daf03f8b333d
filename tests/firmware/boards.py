"""The boards that the bench can simulate: the image that each needs, and the pins of its motors.

An image is an ELF file that the user has built by the firmware's own instructions. Pins are named
by port and bit: F0 is bit 0 of port F.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from armdrive.registry import DIALECTS
from armdrive.sim.device import Value


@dataclass(frozen=True, slots=True)
class Driver:
    """The pins of a motor with a step and direction driver."""

    step: str
    dir: str
    limit: str
    enable: str

    def option(self, axis: str) -> list[str]:
        """Return the options for the processor simulator."""
        pins = f"step={self.step},dir={self.dir},limit={self.limit},enable={self.enable}"
        return ["--axis", f"{axis}:{pins}"]


@dataclass(frozen=True, slots=True)
class Coil:
    """The address of a motor on the coil bus of a Robko 01 board."""

    address: int

    def option(self, axis: str) -> list[str]:
        """Return the options for the processor simulator."""
        return ["--coil", f"{axis}:{self.address}"]


@dataclass(frozen=True, slots=True)
class Board:
    """One kind of board with its firmware.

    `axes` maps the letter of each axis to its wiring, in the order of the arm's motors.
    `resets_on_open`: opening the port resets the processor, by DTR. `twin` holds the settings of
    the simulated board that corresponds to this one.
    """

    name: str
    firmware: str
    dialect: str
    mcu: str
    axes: Mapping[str, Driver | Coil]
    resets_on_open: bool
    twin: Mapping[str, Value] = field(default_factory=dict)
    hz: int = 16_000_000

    @property
    def lacking(self) -> str:
        """Return why this board cannot drive an arm; empty if it can."""
        needed = DIALECTS[self.dialect].abilities.motors
        if len(self.axes) >= needed:
            return ""
        return f"the board has {len(self.axes)} axes, and the arm has {needed} motors"

    @property
    def tells_current(self) -> bool:
        """Whether its pins show the motor current; coils are off between steps anyway."""
        return not self.drives_coils

    @property
    def drives_coils(self) -> bool:
        """Whether it drives the motors' coils itself, instead of a driver's step pins."""
        return any(isinstance(motor, Coil) for motor in self.axes.values())

    @property
    def wiring(self) -> list[str]:
        """Return the words that wire the processor simulator."""
        words = ["--mcu", self.mcu, "--hz", str(self.hz)]
        for letter, motor in self.axes.items():
            words += motor.option(letter)
        return words if self.resets_on_open else [*words, "--no-reset-on-open"]

    @property
    def letters(self) -> str:
        """The axis letters in the order of the arm's motors."""
        return "".join(self.axes)


MEGA_5X = Board(
    name="mega5x",
    firmware="grbl-Mega-5X 1.1q, built for six axes X Y Z A B C on the pins of a RAMPS board",
    dialect="grbl",
    mcu="atmega2560",
    axes={
        "X": Driver("F0", "F1", "E5", "D7"),
        "Y": Driver("F6", "F7", "J1", "F2"),
        "Z": Driver("L3", "L1", "D3", "K0"),
        "A": Driver("A4", "A6", "L7", "A2"),
        "B": Driver("C1", "C3", "L5", "C7"),
        "C": Driver("L0", "B2", "F3", "B0"),
    },
    resets_on_open=True,
    twin={"firmware": "mega5x"},
)
GRBL_328P = Board(
    name="grbl",
    firmware="GRBL 1.1h as it is, three axes on the pins of an Arduino Uno",
    dialect="grbl",
    mcu="atmega328p",
    axes={
        "X": Driver("D2", "D5", "B1", "B0"),
        "Y": Driver("D3", "D6", "B2", "B0"),
        "Z": Driver("D4", "D7", "B4", "B0"),
    },
    resets_on_open=True,
    twin={"firmware": "grbl"},
)
ROBKO = Board(
    name="robko",
    firmware="the Robko 01 Arduino library's example ARDN_Operation, with AccelStepper",
    dialect="robko01",
    mcu="atmega328p",
    axes={letter: Coil(address) for address, letter in enumerate("BSELRG")},
    resets_on_open=False,
)
BOARDS: Mapping[str, Board] = MappingProxyType(
    {board.name: board for board in (MEGA_5X, GRBL_328P, ROBKO)}
)
"""Every board, by the name of its option on the command line."""
