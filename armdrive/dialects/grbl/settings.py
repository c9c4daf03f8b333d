"""The `[grbl]` section of an arm file, a board's axes, and the check of a board's settings.

GrblSettings   what the arm file says of the board
BoardAxes      which axis of the board each motor is, and how motions are written for it
Comparison     what the board reports of itself (`$$`), against what the arm file expects
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from datetime import date
from typing import NamedTuple, TypeAlias

from armdrive.config.arm import ArmConfig
from armdrive.dialects.grbl.planner import Limits, MotorPath
from armdrive.dialects.grbl.variants import LOCATE_PULL_OFFS, SEARCH_TRAVELS, Behaviour
from armdrive.errors import ArmFileError
from armdrive.tasks import Difference
from armdrive.text.toml import check_settings, setting
from firmware_protocol.grbl import AXIS_LETTERS, keys
from firmware_protocol.grbl.dialect import write_number
from kinematics.spaces import Joints, Motors
from kinematics.text import counted
from kinematics.transmission import Transmission

UNITS = ("steps", "degrees")
SERVOS = re.compile(r"M3|M6[78]E[0-9]{1,2}")
OUTPUTS = re.compile(r"flood|mist|P[0-9]{1,2}")
# The pin letters of a report, in the order of the input bits: probe, door, hold, start, reset and
# the limit switches.
PINS = "PDHSRXYZABC"


@dataclass(frozen=True, slots=True)
class GrblSettings:
    """How a GRBL board is wired to the arm and set up.

    The board's "mm" is one motor step ($100=1), or one degree of the motor's turn as its row in the
    arm file defines it (one mm for a gripper's motor).
    """

    axes: str = setting("XYZABC", "the board's letter for each motor, in the arm's order")
    unit: str = setting("steps", "what a mm of the board stands for: steps or degrees", words=UNITS)
    ramp_s: float = setting(
        0.1, "time to full speed, to compute the expected accelerations", low=0.005, high=10.0
    )
    accelerations: tuple[float, ...] = setting(
        (),
        "expected $120 ..., in steps a second squared; empty: full speed in ramp_s",
        low=0.1,
        high=1e8,
    )
    travel: tuple[float, ...] = setting(
        (), "expected $130 ..., in the board's units", low=0.1, high=1e6
    )
    soft_limits: bool = setting(False, "expected $20")
    hard_limits: bool = setting(False, "expected $21")
    hard_limits_checked: str = setting(
        "", "the day on which all limit switches worked; written by config limits"
    )
    homing: bool = setting(False, "expected $22")
    outputs: tuple[str, ...] = setting(
        ("flood",), "what each output bit switches: flood, mist, P0, P1 ..."
    )
    servo: str = setting("M3", "the word that sets the gripper's servo")
    servo_closed: float = setting(
        0.0, "the servo's number with the fingers closed", low=0.0, high=100_000.0
    )
    servo_open: float = setting(
        1000.0, "the servo's number with the fingers open", low=0.0, high=100_000.0
    )
    gripper_output: int = setting(0, "the output bit of a gripper of kind output", low=0, high=7)
    gripper_closes: bool = setting(True, "whether that output closes the gripper when on")
    following_error_steps: float = setting(
        2.0, "how far a motor may be off the path that was sent", low=1.0, high=1000.0
    )
    report_timeout_s: float = setting(
        1.0, "a board that sends no report for this long is lost", low=0.5, high=10.0
    )
    answer_s: float = setting(1.0, "timeout for an answer", low=0.2, high=30.0)
    boot_s: float = setting(
        4.0,
        "longest start of a board that restarts when its port is opened",
        low=0.5,
        high=30.0,
    )
    homing_s: float = setting(
        120.0, "longest homing, if the board does not report its speeds", low=1.0, high=3600.0
    )
    segments: int | None = setting(
        None,
        "motion segments the board computes ahead; by default, its firmware's number",
        low=1,
        high=100,
    )

    def __post_init__(self) -> None:
        check_settings(self, "grbl")
        letters = self.axes
        if not letters or set(letters) - set(AXIS_LETTERS) or len(set(letters)) != len(letters):
            raise ArmFileError(
                f"grbl.axes must give each motor its own letter from {AXIS_LETTERS}, not "
                f"{letters!r}"
            )
        if not SERVOS.fullmatch(self.servo):
            raise ArmFileError(f"grbl.servo must be M3, or one like M67E0, not {self.servo!r}")
        for word in self.outputs:
            if not OUTPUTS.fullmatch(word):
                raise ArmFileError(
                    f"grbl.outputs lists flood, mist, P0, P1 and so on, not {word!r}"
                )
        if self.hard_limits_checked and not _is_day(self.hard_limits_checked):
            raise ArmFileError(
                "grbl.hard_limits_checked must be a date such as 2026-11-23, not "
                f"{self.hard_limits_checked!r}"
            )

    @property
    def limit_inputs(self) -> Mapping[str, int]:
        """The input bit of each axis's limit switch, in the order of the motors."""
        return {letter: PINS.index(letter) for letter in self.axes}


def _is_day(word: str) -> bool:
    try:
        return date.fromisoformat(word).isoformat() == word
    except ValueError:
        return False


def fitting(config: ArmConfig) -> Transmission:
    """Return an arm's transmission, whose motors and gripper fit the section `[grbl]`.

    Raises `ArmFileError` if they do not.
    """
    settings: GrblSettings = config.device
    transmission = config.model.transmission
    if transmission is None:
        raise ArmFileError("the arm's motor steps are not known: give steps_per_turn")
    count, outputs = len(transmission.motors), len(settings.outputs)
    if len(settings.axes) < count:
        raise ArmFileError(
            f"grbl.axes names {counted(len(settings.axes), 'axis', 'axes')}, but the arm has "
            f"{counted(count, 'motor')}"
        )
    for name in ("accelerations", "travel"):
        if len(getattr(settings, name)) not in (0, count):
            raise ArmFileError(
                f"grbl.{name} must have {counted(count, 'entry', 'entries')}, one for each motor"
            )
    if config.gripper.kind == "output" and settings.gripper_output >= outputs:
        raise ArmFileError(
            f"grbl.gripper_output is bit {settings.gripper_output}, but grbl.outputs names "
            f"{counted(outputs, 'output')}, counted from 0: name the gripper's"
        )
    return transmission


# The mapping of an arm's motors to a board's axes: letters, units and speeds.
#
# A motion line is relative, and counts whole motor steps if those are the unit:
# docs/controllers/grbl.md explains why. The feed precedes the axis words and every number has a
# sign, so that a lost byte never joins two words into one number. Only a lost minus can make a
# motion longer.

# The expected junction deviation ($11): with much less, the arm slows down at every rounded corner.
JUNCTION_STEPS = 1.0
# Decimals of a distance in degrees; they resolve every motor step.
DECIMALS = 4
# Most steps per unit: reports have three decimals, which must resolve a step.
MOST_STEPS_PER_UNIT = 400.0


@dataclass(frozen=True, slots=True)
class BoardAxes:
    """The board axes of an arm's motors, in the motors' order.

    `most_hz` is each motor's rate when every joint that it moves is at full speed. `fastest_hz` is
    the highest rate of any motor for a single joint. If the board limits every motor to that, no
    motion uses a higher rate. `spans` is how far each motor turns within the joints' limits, in the
    board's units. `seeks` is which way each motor has to seek its homing switch: 1, -1, or 0 if the
    arm file does not show it.
    """

    letters: str
    steps_per_unit: tuple[float, ...]
    most_hz: tuple[float, ...]
    fastest_hz: float
    spans: tuple[float, ...]
    seeks: tuple[int, ...]

    @classmethod
    def of(cls, config: ArmConfig) -> BoardAxes:
        """Return the axes of an arm. Raises `ArmFileError`."""
        settings: GrblSettings = config.device
        transmission = fitting(config)
        count = len(transmission.motors)
        per_unit = tuple(
            1.0
            if settings.unit == "steps"
            else _per_degree(abs(motor.steps_per_unit), index, config)
            for index, motor in enumerate(transmission.motors)
        )
        if max(per_unit) > MOST_STEPS_PER_UNIT:
            raise ArmFileError(
                f"grbl.unit: a degree has {max(per_unit):.0f} motor steps, which three decimals "
                'cannot tell apart: use "steps"'
            )
        speeds = (*config.model.joint_speeds_rad_s, config.model.gripper_speed_mm_s)
        turned = [
            [abs(share * speed) for share, speed in zip(row, speeds, strict=False)]
            for row in transmission.matrix
        ]
        return cls(
            settings.axes[:count],
            per_unit,
            transmission.most_steps(speeds),
            max(map(max, turned)),
            tuple(steps / per for steps, per in zip(config.motor_ranges, per_unit, strict=True)),
            _seeks(config, transmission),
        )

    def expected(self, settings: GrblSettings) -> Limits:
        """Return the limits that the arm file expects of the board."""
        rates_hz = tuple(min(most, self.fastest_hz) for most in self.most_hz)
        slopes = settings.accelerations or tuple(rate / settings.ramp_s for rate in rates_hz)
        return Limits(
            self.steps_per_unit,
            self._in_units(rates_hz),
            self._in_units(slopes),
            JUNCTION_STEPS / max(self.steps_per_unit),
        )

    def _in_units(self, steps: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(count / per for count, per in zip(steps, self.steps_per_unit, strict=True))

    def board(self) -> str:
        """Return the letters of a board with exactly these axes, in the board's order."""
        return "".join(letter for letter in AXIS_LETTERS if letter in self.letters)

    def motors(self, position: tuple[float, ...], board: str) -> Motors:
        """Convert a board's machine position into whole motor steps."""
        placed: Mapping[str, float] = dict(zip(board, position, strict=True))
        return Motors(
            math.floor(placed[letter] * per + 0.5)
            for letter, per in zip(self.letters, self.steps_per_unit, strict=True)
        )

    def words(self, start: Motors, end: Motors) -> str:
        """Return the relative axis words from one absolute position to another.

        They are differences of rounded absolute positions, so that rounding errors do not add up.
        """
        return "".join(
            f"{letter}{_written(there - here, per)}"
            for letter, here, there, per in zip(
                self.letters,
                self._rounded(start),
                self._rounded(end),
                self.steps_per_unit,
                strict=True,
            )
            if there != here
        )

    def _rounded(self, position: Motors) -> list[int]:
        """Return an absolute position as a whole number of the last written decimal."""
        return [
            count if per == 1.0 else round(count / per * 10**DECIMALS)
            for count, per in zip(position, self.steps_per_unit, strict=True)
        ]


def _seeks(config: ArmConfig, transmission: Transmission) -> tuple[int, ...]:
    """Return which way each motor has to turn to its switch, as far as the arm file shows it.

    The switch is at the end of the motor's travel where homing ends. In the middle half of the
    travel it may be on either side.
    """
    homing, model = config.homing, config.model
    count = len(transmission.motors)
    if homing is None:
        return (0,) * count
    angles = tuple((one.low_rad + one.high_rad) / 2.0 for one in model.arm.limits)
    opening_mm = math.fsum(model.gripper_range_mm) / 2.0
    middle = transmission.to_exact(Joints(angles, model.arm.joint_names), opening_mm)
    ends = transmission.to_exact(homing.joints, homing.opening_mm)
    homes = {motor - 1 for group in homing.groups for motor in group} or range(count)
    return tuple(
        (end - at > span / 4.0) - (at - end > span / 4.0) if motor in homes else 0
        for motor, (end, at, span) in enumerate(zip(ends, middle, config.motor_ranges, strict=True))
    )


def _per_degree(per_unit: float, index: int, config: ArmConfig) -> float:
    """Return a turning motor's steps per degree, or the gripper's steps per mm."""
    turning = index < len(config.model.arm.joint_names)
    return math.radians(per_unit) if turning else per_unit


def _written(amount: int, per: float) -> str:
    if per == 1.0:
        return f"{amount:+d}"
    return f"{amount / 10**DECIMALS:+.{DECIMALS}f}".rstrip("0").rstrip(".")


def feed(path: MotorPath) -> str:
    """Return a line's F word, never faster than its speed, without a decimal point if possible."""
    per_minute = max(path.speed * 60.0, 10.0**-DECIMALS)
    decimals = min(max(3 - math.floor(math.log10(per_minute)), 0), DECIMALS)
    scaled = math.floor(per_minute * 10**decimals + 1e-6)
    text = f"{max(scaled, 1) / 10**decimals:.{decimals}f}"
    return f"F{text.rstrip('0').rstrip('.') if '.' in text else text}"


# A comparison of a board's settings with the arm file: the differences, their effect on motion, and
# the lines that correct them.

# A board's settings by key, as the board reports them.
ReportedSettings = Mapping[int | str, str]

# Settings are reported with three decimals.
SETTING_TOLERANCE = 1e-3
# An axis that is slower than expected by no more than this share is not reported.
RATE_TOLERANCE = 0.02

# Whether a setting as found differs from the one wanted, in a way that matters.
Differs: TypeAlias = Callable[[float, float], bool]


def _is_other(found: float, wanted: float) -> bool:
    return abs(found - wanted) > SETTING_TOLERANCE


def _is_lower(found: float, wanted: float) -> bool:
    return found < wanted * (1.0 - RATE_TOLERANCE)


def _is_switched(found: float, wanted: float) -> bool:
    return bool(found) != bool(wanted)


class Expected(NamedTuple):
    """A setting as the arm file expects it.

    `must` means that nothing moves until it is corrected, `homes` that no motor homes.
    """

    key: int
    wanted: float
    what: str
    differs: Differs
    must: bool = False
    homes: bool = False


@dataclass(frozen=True, slots=True)
class Comparison:
    """Compares the settings that a board reports with those that the arm file expects.

    `board` are the letters of the board's axes, in the order in which its settings number them.
    """

    settings: GrblSettings
    axes: BoardAxes
    board: str
    reported: ReportedSettings
    behaviour: Behaviour

    def number(self, key: int | str | None) -> float | None:
        """Return a setting as a number; None if the board does not report one."""
        if isinstance(key, int) and key not in self.reported:
            key = self.behaviour.key(key, self.board)
        try:
            value = float("" if key is None else self.reported.get(key, ""))
        except ValueError:
            return None
        return value if math.isfinite(value) else None

    def _of_motor(self, group: int, motor: int) -> float | None:
        return self.number(group + self.board.index(self.axes.letters[motor]))

    def limits(self) -> Limits:
        """Return the axes' actual limits; those that the board does not report are as expected.

        So are rates and accelerations of zero: nothing moves until they are corrected.
        """
        expected, junction = self.axes.expected(self.settings), self.number(keys.JUNCTION)
        rates = (
            (self._of_motor(keys.RATE, motor) or rate * 60.0) / 60.0
            for motor, rate in enumerate(expected.rates)
        )
        slopes = (
            self._of_motor(keys.ACCELERATION, motor) or slope
            for motor, slope in enumerate(expected.accelerations)
        )
        junction = expected.junction if junction is None else junction
        return Limits(expected.steps_per_unit, tuple(rates), tuple(slopes), junction)

    def searches_s(self) -> tuple[float | None, ...]:
        """Return how long each motor homes at most, in s; None if the board does not say."""
        limits = self.limits()
        each = zip(limits.rates, limits.accelerations, strict=True)
        return tuple(self._search_s(motor, *limit) for motor, limit in enumerate(each))

    def _search_s(self, motor: int, fastest: float, slope: float) -> float | None:
        """Return how long a motor homes whose axis has this highest rate, in units a second.

        It seeks its switch, no faster than its axis's highest rate, backs off, approaches it
        slowly, and backs off again; FluidNC backs off slowly, and also first from a switch that is
        pressed. Sources: gnea/grbl grbl/limits.c (limits_go_home) and grbl/planner.c, grblHAL/core
        machine_limits.c, whose approach is longer than GRBL's and may be repeated ($43), FluidNC
        Homing.cpp and Cartesian.cpp (axesVector).
        """
        names = self.behaviour.homing_of(self.axes.letters[motor])
        seek, feed, off, pause_ms, *scalers = map(self.number, names)
        far, near = scalers or (SEARCH_TRAVELS, LOCATE_PULL_OFFS)
        travel = self._of_motor(keys.TRAVEL, motor)
        if not (travel and seek and feed and off and far and near):
            return None
        runs = self.number(keys.HOMING_RUNS) or 1.0
        seek, feed = min(seek / 60.0, fastest), min(feed / 60.0, fastest)
        backs_off = feed if self.behaviour.pulls_off_slowly else seek
        turns = 2.0 * runs + 3.0  # motions, each with a ramp and a pause
        drives_s = far * travel / seek + runs * near * off / feed + (runs + 2.0) * off / backs_off
        return drives_s + turns * (max(seek, feed) / slope + (pause_ms or 0.0) / 1000.0)

    def differences(self) -> Iterator[Difference]:
        """Yield each difference from the arm file, with the line that corrects it."""
        for key, wanted, what, differs, must, homes in self._expected():
            found = self.number(key)
            missing = found is None and key == keys.IDLE_MS
            if not missing and (found is None or not differs(found, wanted)):
                continue
            changed_by = self.behaviour.key(key, self.board)
            # rounded up, because three decimals must not make a limit lower than expected
            expected = write_number(math.ceil(wanted * 1000.0 - 1e-6) / 1000.0)
            where = "" if changed_by is not None else ", in the board's configuration file"
            line = "" if changed_by is None else f"${changed_by}={expected}"
            shown = "not reported" if found is None else write_number(found)
            yield Difference(f"${key} ({what}{where})", shown, expected, line, must, homes)

    def _expected(self) -> Iterator[Expected]:
        settings, behaviour = self.settings, self.behaviour
        what = "motors on while standing"
        yield Expected(keys.IDLE_MS, keys.ALWAYS_ON_MS, what, _is_other, must=True)
        # the other parts may stay
        mask = int(self.number(keys.REPORT) or 0) | behaviour.report_bits
        yield Expected(keys.REPORT, mask, "what reports contain", _is_other, must=True)
        yield Expected(keys.INCHES, 0, "reports in inches", _is_switched, must=True)
        for motor in range(len(self.axes.letters)):
            yield from self._expected_of_axis(motor)
        junction = self.axes.expected(settings).junction
        yield Expected(keys.JUNCTION, junction, "the corner rounding", _is_other)
        yield Expected(keys.SOFT_LIMITS, settings.soft_limits, "soft limits", _is_switched)
        yield Expected(keys.HARD_LIMITS, settings.hard_limits, "hard limits", _is_switched)
        if behaviour.homing_bits is not None and settings.homing:
            bits = int(self.number(keys.HOMING) or 0) | behaviour.homing_bits
            yield Expected(keys.HOMING, bits, "homing, also of single axes", _is_other)
        else:
            yield Expected(keys.HOMING, settings.homing, "homing", _is_switched)
        if settings.homing:
            what = "homing directions: motors would move away from their switches"
            mask = self._homing_mask()
            yield Expected(keys.HOMING_DIRECTIONS, mask, what, _is_other, homes=True)
        if behaviour.sleep_switch:
            what = "sleep: only it releases the motors"
            yield Expected(keys.SLEEP_ENABLE, 1, what, _is_switched)

    def _expected_of_axis(self, motor: int) -> Iterator[Expected]:
        settings, expected = self.settings, self.axes.expected(self.settings)
        letter = self.axes.letters[motor]
        axis = self.board.index(letter)
        steps, what = expected.steps_per_unit[motor], f"steps per unit of {letter}"
        yield Expected(keys.STEPS_PER_UNIT + axis, steps, what, _is_other, must=True)
        for key, least, what in (
            (keys.RATE, expected.rates[motor] * 60.0, f"the highest rate of {letter}"),
            (keys.ACCELERATION, expected.accelerations[motor], f"the acceleration of {letter}"),
        ):
            stuck = self.number(key + axis) == 0.0
            effect = "a motion would never end" if stuck else "motion is slower than requested"
            yield Expected(key + axis, least, f"{what}: {effect}", _is_lower, must=stuck)
        what = f"the travel of {letter}"
        if settings.travel and settings.soft_limits:
            yield Expected(keys.TRAVEL + axis, settings.travel[motor], what, _is_other)
        elif settings.homing:
            travel = math.ceil((settings.travel or self.axes.spans)[motor])
            what += f": homing gives up after {SEARCH_TRAVELS:g} times that"
            yield Expected(keys.TRAVEL + axis, travel, what, _is_lower)

    def _homing_mask(self) -> int:
        """Return the board's own mask with a bit for each motor that has to home downwards."""
        mask = int(self.number(keys.HOMING_DIRECTIONS) or 0)
        for letter, way in zip(self.axes.letters, self.axes.seeks, strict=True):
            bit = 1 << self.board.index(letter)
            if way:
                mask = mask | bit if way < 0 else mask & ~bit
        return mask
