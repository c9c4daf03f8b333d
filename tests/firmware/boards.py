"""The boards that the bench can run: the image or program that each needs, and its motors.

The user builds it by the firmware's own instructions: an ELF file for an AVR processor, or a
program of this computer. Pins are named by port and bit: F0 is bit 0 of port F.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

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
class CoilBus:
    """The pins of a bus with a latch for each motor's coils.

    At an edge of `strobe` (`rise` or `fall`), the latch with the number on the `address` pins takes
    the number on the `coils` pins, the lowest bit first. `turn` lists the four full-step patterns
    in the order of a positive turn, and `off` is the pattern without current. `holds`: the motors
    keep their current at rest.
    """

    strobe: str
    edge: str
    address: tuple[str, ...]
    coils: tuple[str, ...]
    turn: tuple[int, ...]
    off: int
    holds: bool

    @property
    def option(self) -> list[str]:
        """The options for the processor simulator."""
        address, coils = "+".join(self.address), "+".join(self.coils)
        turn = "+".join(str(pattern) for pattern in self.turn)
        pins = f"strobe={self.strobe},edge={self.edge},address={address},coils={coils}"
        return ["--coil-bus", f"{pins},turn={turn},off={self.off}"]


@dataclass(frozen=True, slots=True)
class Coil:
    """The address of a motor on its board's coil bus."""

    address: int

    def option(self, axis: str) -> list[str]:
        """Return the options for the processor simulator."""
        return ["--coil", f"{axis}:{self.address}"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Board:
    """One kind of board with its firmware.

    `letters` are the names of its axes, in the order of the arm's motors. `twin` holds the settings
    of the simulated board that corresponds to this one.
    """

    name: str
    firmware: str
    dialect: str
    letters: str
    twin: Mapping[str, Value] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class AvrBoard(Board):
    """Firmware for an AVR processor, which is simulated with the wiring of each motor.

    `resets_on_open`: opening the port resets the processor, by DTR; its boot loader then hears
    nothing for `boot_ms`. A board with a `coil_bus` drives the coils of its motors itself.
    `native_usb`: the port is the processor's own USB, which also supplies it.
    """

    mcu: str
    motors: tuple[Driver | Coil, ...]
    resets_on_open: bool
    hz: int = 16_000_000
    boot_ms: int = 0
    coil_bus: CoilBus | None = None
    native_usb: bool = False

    @property
    def tells_current(self) -> bool:
        """Whether its pins show the motor current also at rest."""
        return self.coil_bus is None or self.coil_bus.holds

    @property
    def wiring(self) -> list[str]:
        """Return the words that wire the processor simulator."""
        words = ["--mcu", self.mcu, "--hz", str(self.hz)]
        if self.coil_bus is not None:
            words += self.coil_bus.option
        for letter, motor in zip(self.letters, self.motors, strict=True):
            words += motor.option(letter)
        words += ["--boot-ms", str(self.boot_ms)] if self.boot_ms else []
        words += ["--native-usb"] if self.native_usb else []
        return words if self.resets_on_open else [*words, "--no-reset-on-open"]


@dataclass(frozen=True, slots=True, kw_only=True)
class NativeBoard(Board):
    """Firmware that runs as a program of this computer; its serial line is standard input/output.

    The program is linked with glue that reports its steps (`motors.h`). It gets `options`, and runs
    in a folder of its own, which keeps its settings. `baud` paces the line, unless the program does
    that by itself.
    """

    options: tuple[str, ...] = ()
    baud: int | None = None
    configuration: str = ""
    """The file in its folder that it reads at its start; empty: `$` lines configure it."""


MEGA_5X = AvrBoard(
    name="mega5x",
    firmware="grbl-Mega-5X 1.1q, built for six axes X Y Z A B C on the pins of a RAMPS board",
    dialect="grbl",
    mcu="atmega2560",
    letters="XYZABC",
    motors=(
        Driver("F0", "F1", "E5", "D7"),
        Driver("F6", "F7", "J1", "F2"),
        Driver("L3", "L1", "D3", "K0"),
        Driver("A4", "A6", "L7", "A2"),
        Driver("C1", "C3", "L5", "C7"),
        Driver("L0", "B2", "F3", "B0"),
    ),
    resets_on_open=True,
    twin={"firmware": "mega5x"},
)
ROBKO = AvrBoard(
    name="robko",
    firmware="the Robko 01 Arduino library's example ARDN_Operation, with AccelStepper",
    dialect="robko01",
    mcu="atmega328p",
    letters="BSELRG",
    motors=tuple(Coil(address) for address in range(6)),
    resets_on_open=False,
    coil_bus=CoilBus(
        "C0", "rise", ("D6", "D7", "B0"), ("D2", "D3", "D4", "D5"), (5, 6, 10, 9), 0, holds=False
    ),
)
ARMDROID = AvrBoard(
    name="armdroid",
    firmware="the Armdroid library's example SerialDriver on the pins of an Arduino Uno",
    dialect="armdroid",
    mcu="atmega328p",
    letters="BSERLG",
    motors=tuple(Coil(address) for address in (6, 5, 4, 3, 2, 1)),
    resets_on_open=True,
    boot_ms=1000,  # Optiboot's timeout on an Uno
    coil_bus=CoilBus(
        "D2", "fall", ("D3", "D4", "D5"), ("D6", "D7", "B0", "B1"), (12, 9, 3, 6), 15, holds=True
    ),
    twin={"board": "uno"},
)
ARMDROID_USB = replace(
    ARMDROID,
    name="armdroidusb",
    firmware="the same on the pins of an Arduino Leonardo, with native USB",
    mcu="atmega32u4",
    resets_on_open=False,
    boot_ms=0,
    coil_bus=CoilBus(
        "D1", "fall", ("D0", "D4", "C6"), ("D7", "E6", "B4", "B5"), (12, 9, 3, 6), 15, holds=True
    ),
    native_usb=True,
    twin={},
)
GRBLHAL = NativeBoard(
    name="grblhal",
    firmware="grblHAL's Simulator, built for six axes and linked with grblhal_motors.c",
    dialect="grbl",
    letters="XYZABC",
    options=("-n", "-b", "/dev/null", "-t", "0"),  # bare lines, no list of blocks, our own pace
    twin={"firmware": "grblhal"},
)
FLUIDNC = NativeBoard(
    name="fluidnc",
    firmware="FluidNC's native build for Linux, with fluidnc_motors.cpp for its pins and timers",
    dialect="grbl",
    letters="XYZABC",
    baud=115_200,
    configuration="native_localfs/config.yaml",
    twin={"firmware": "fluidnc"},
)
BOARDS: Mapping[str, Board] = MappingProxyType(
    {board.name: board for board in (MEGA_5X, ROBKO, ARMDROID, ARMDROID_USB, GRBLHAL, FLUIDNC)}
)
"""Every board, by the name of its option on the command line."""
