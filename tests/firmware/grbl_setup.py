"""Configure a GRBL board for an arm with `$` lines, as its owner does before the first motion."""

from __future__ import annotations

import time
from collections.abc import Mapping

import serial

from armdrive.config.arm import ArmConfig
from armdrive.sim.grbl import board_axes, motor_letters, well_set_up
from armdrive.sim.grbl.firmware import FIRMWARES
from firmware_protocol.grbl import keys

from .boards import Board

RESETS_S = 3.0
"""A board that resets when its port is opened greets within this time."""
ANSWERS_S = 5.0
SOFT_RESET = b"\x18"
SAME = 0.0005
"""Boards print settings with three decimals."""


class SetUpFailed(Exception):
    """A board gave no answer, or a wrong one, while it was configured."""


class Conversation:
    """Sends lines to a board and returns the answers, without a driver."""

    def __init__(self, port: str) -> None:
        self._port = serial.Serial(port, 115_200, timeout=0.1)
        try:
            self.heard_until("Grbl", longest_s=RESETS_S)
        except SetUpFailed:  # opening its port does not reset it
            self.say(SOFT_RESET)
            self.heard_until("Grbl")

    def heard_until(self, *ends: str, longest_s: float = ANSWERS_S) -> list[str]:
        """Return the lines up to one that begins with any of `ends`."""
        lines, end_s = [], time.monotonic() + longest_s
        while time.monotonic() < end_s:
            line = self._port.readline().decode("latin-1").strip()
            if line:
                lines.append(line)
            if line.startswith(ends):
                return lines
        raise SetUpFailed(f"the board said no {' or '.join(ends)} within {longest_s:g} s: {lines}")

    def ask(self, line: str) -> list[str]:
        """Send a line and return the answer without its `ok`."""
        self._port.write(f"{line}\n".encode())
        lines = self.heard_until("ok", "error")
        if lines[-1] != "ok":
            raise SetUpFailed(f"the board refuses {line!r}: {lines[-1]}")
        return lines[:-1]

    def say(self, data: bytes) -> None:
        """Send real-time commands, which have no answer."""
        self._port.write(data)

    def close(self) -> None:
        """Close the port."""
        self._port.close()

    def __enter__(self) -> Conversation:
        return self

    def __exit__(self, *error: object) -> None:
        self.close()


def settings_for(config: ArmConfig, board: Board) -> dict[int, float]:
    """Return the settings for an arm, limited to the axes that the board has."""
    letters = motor_letters(config)
    values = well_set_up(config, letters, board_axes(letters, ""))
    values = FIRMWARES[str(board.twin["firmware"])].adapted(values)
    return {
        number: value
        for number, value in values.items()
        if number < keys.STEPS_PER_UNIT or number % 10 < len(board.letters)
    }


FLUIDNC_AXIS = """
  {letter}:
    steps_per_mm: {steps}
    max_rate_mm_per_min: {rate}
    acceleration_mm_per_sec2: {acceleration}
    max_travel_mm: {travel}
    soft_limits: {soft}{homing}
    motor0:
      limit_all_pin: gpio.{limit_pin}
      hard_limits: {hard}
      pulloff_mm: {pull_off}
      stepstick:
        step_pin: gpio.{step_pin}
        direction_pin: gpio.{dir_pin}"""
FLUIDNC_HOMING = """
    homing:
      cycle: 1
      positive_direction: {upwards}
      mpos_mm: 0
      seek_mm_per_min: {seek}
      feed_mm_per_min: {feed}
      seek_scaler: 1.5
      feed_scaler: 5"""

FLUIDNC_SLOWER = 4.0
"""It seeks its switches more slowly: a task polls them, and a busy computer lets it wait."""


FLUIDNC_AXES = "xyzabc"


def fluidnc_configuration(values: Mapping[int, float]) -> str:
    """Return FluidNC's configuration with these settings, on the pins of fluidnc_motors.cpp."""
    seek, down = values[keys.HOMING_SEEK] / FLUIDNC_SLOWER, int(values[keys.HOMING_DIRECTIONS])
    homing = FLUIDNC_HOMING if values[keys.HOMING] else ""
    blocks = [
        FLUIDNC_AXIS.format(
            letter=letter,
            steps=values[keys.STEPS_PER_UNIT + axis],
            rate=values[keys.RATE + axis],
            acceleration=values[keys.ACCELERATION + axis],
            travel=values[keys.TRAVEL + axis],
            soft=str(bool(values[keys.SOFT_LIMITS])).lower(),
            homing=homing.format(
                seek=seek, feed=values[keys.HOMING_FEED], upwards=str(not down >> axis & 1).lower()
            ),
            limit_pin=2 * len(FLUIDNC_AXES) + axis,
            hard=str(bool(values[keys.HARD_LIMITS])).lower(),
            pull_off=values[keys.PULL_OFF],
            step_pin=2 * axis,
            dir_pin=2 * axis + 1,
        )
        for axis, letter in enumerate(FLUIDNC_AXES)
        if keys.STEPS_PER_UNIT + axis in values
    ]
    return f"""name: arm
board: bench
junction_deviation_mm: {values[keys.JUNCTION]}
stepping:
  engine: Timed
  idle_ms: {values[keys.IDLE_MS]:.0f}
axes:
  shared_stepper_disable_pin: gpio.18{"".join(blocks)}
coolant:
  flood_pin: gpio.19
  mist_pin: gpio.20
user_outputs:
  digital0_pin: gpio.21
  analog0_pin: gpio.36
besc:
  output_pin: gpio.35
  speed_map: 0=0% {values.get(keys.MOST_SPEED, 1000):.0f}=100%
"""


def set_up(port: str, values: Mapping[int, float]) -> None:
    """Write the settings that differ. Raises `SetUpFailed`."""
    with Conversation(port) as board:
        told = (line[1:].split("=") for line in board.ask("$$") if line.startswith("$"))
        before = {int(number): float(text.split()[0]) for number, text in told}
        # $20 needs $22=1
        for number, value in sorted(values.items(), key=lambda each: (each[0] == 20, each[0])):
            if abs(before.get(number, -1.0) - value) > SAME:
                board.ask(f"${number}={value:.3f}".rstrip("0").rstrip("."))
