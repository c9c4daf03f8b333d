"""Simulated arms on CiA 402 drives: how one is made from an arm file, and its options.

`node` is one drive: its frames, `objects` (what its EDS file describes), `states` and `motion`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.bus.node import Quirk, motors_of, node_ids, options_of
from armdrive.sim.cia402.node import Cia402Node, SavedCia402Drive
from armdrive.sim.cia402.objects import dictionary, varied
from armdrive.sim.device import Option, Options
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world import World
from firmware_protocol import canopen
from firmware_protocol.canopen import Dictionary, OperationMode, Place

PROFILE = 402
BITRATES = (10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)
"""The bit rates of CiA 301."""
_INDICES = re.compile(r"[0-9A-Fa-f]{4}(\+[0-9A-Fa-f]{4})*")
_CONSTANT = re.compile(r"([0-9A-Fa-f]{4}):([0-9A-Fa-f]{2})=(-?\d{1,10})")


@dataclass(frozen=True, slots=True)
class SavedCia402Drives:
    """What is saved of the drives."""

    drives: tuple[SavedCia402Drive, ...]


class Cia402Board(DrivesBoard[Cia402Node]):
    """Drives that sample their shafts at each SYNC, and report errors of their own."""

    saved_as = SavedCia402Drives
    title = "arm on CiA 402 drives"

    def ail(self, drive: int, code: int) -> None:
        """Put a drive in fault, until the error is mended and the drive is reset."""
        node = self.nodes[drive]
        if node.port.powered:
            node.states.ailing.add(code)
            node.states.fault(code, self.now_s)
            self.collect()

    def mend(self, drive: int, code: int) -> None:
        """Remove the cause of a drive's error; the fault itself must still be reset."""
        self.nodes[drive].states.mend(code)

    def warn(self, drive: int, code: int) -> None:
        """Make a drive send an EMCY that changes nothing."""
        self.nodes[drive].say_emcy(code)
        self.collect()


def _make(config: ArmConfig, world: World, options: Options) -> Cia402Board:
    objects = _objects(options)
    shafts = ShaftDrive(world, _top_rate(objects))
    motors, modes = motors_of(config, shafts, behind=1), _modes(options)
    nodes = [
        Cia402Node(motor, number, objects, modes, options)
        for motor, number in zip(motors, _numbers(config, len(motors)), strict=True)
    ]
    return Cia402Board(world, shafts, nodes, options.whole("bitrate"))


def _numbers(config: ArmConfig, count: int) -> tuple[int, ...]:
    numbers = node_ids(getattr(config.device, "ids", ()), count)
    if not all(1 <= number <= canopen.NODE_MAX for number in numbers):
        found = ", ".join(map(str, numbers))
        raise BadRequest(f"node ids are 1 to {canopen.NODE_MAX}, not {found}")
    return numbers


def _objects(options: Options) -> Dictionary:
    """Return every drive's objects: those of its EDS, changed by the options."""
    missing, profile = options.text("missing"), options.whole("profile")
    new = ("60A9",) if options.flag("factory") else ()
    if missing and not _INDICES.fullmatch(missing):
        raise BadRequest(f'missing is written "60C2", or as more joined by +, not {missing!r}')
    indices = frozenset(int(word, 16) for word in (*missing.split("+"), *new) if word)
    kind = dictionary().find(canopen.DEVICE_TYPE)
    high = 0 if kind is None else int(kind.default or 0) & ~0xFFFF
    changed: dict[Place, int] = {
        canopen.DEVICE_TYPE: high | profile,
        canopen.SUPPORTED_MODES: canopen.supported_word(_modes(options)),
    }
    constant = _constants(options.text("constant"))
    if (window := options.whole("following_window")) >= 0:
        changed[canopen.FOLLOWING_ERROR_WINDOW] = window
    return varied(indices, {**changed, **constant}, constant)


def _constants(text: str) -> dict[Place, int]:
    found = [_CONSTANT.fullmatch(word) for word in text.split("+") if word]
    if not all(found):
        raise BadRequest(f'constant is written "60C2:02=-3", or as more joined by +, not {text!r}')
    return {Place(int(one[1], 16), int(one[2], 16)): int(one[3]) for one in found if one}


def _modes(options: Options) -> frozenset[OperationMode]:
    own = {OperationMode.PROFILE_POSITION: True}
    own[OperationMode.HOMING] = options.flag("homing")
    own[OperationMode.CYCLIC_POSITION] = options.flag("csp")
    return frozenset(mode for mode, has in own.items() if has)


def _top_rate(objects: Dictionary) -> float:
    """Return how fast a drive can catch up, in increments/s: its motor's top speed."""
    speed, increments = (
        objects.find(canopen.MOST_MOTOR_SPEED),
        objects.find(canopen.ENCODER_INCREMENTS),
    )
    if speed is None or increments is None:
        raise BadRequest("a drive without 6080 and 608F turns nothing: it cannot lack them")
    return int(speed.default or 0) * int(increments.default or 0) / 60.0


# What CiA 402 leaves to the maker of a drive, or what no source tells: one row a quirk.

_UNKNOWN = "not measured on any real drive"

# each row: name, default, what it does, source; without a default the drives are always so
# fmt: off
QUIRKS: tuple[Quirk, ...] = (
    Quirk("hold_after_loss", "hold",
          "what a drive does when cyclic targets stop: hold the last one, or extrapolate",
          "makers differ: SEW-EURODRIVE (MOVI-C, EtherCAT) can hold the set-point; "
          "STOBER (CiA 402 Controller Based, ID 442454.02, section 2.4) extrapolates "
          "up to I423, then faults", ("hold", "extrapolate")),
    Quirk("speed_unit", 0.0, "increments/s that a unit of speed is; 0: what 60A9 tells, or 1",
          "makers differ: rpm (Roboteq, CANBus Networking Manual, 0x6081), 65536ths of increments "
          "in a period (Technosoft's iPOS, in roboticslab-uc3m/yarp-devices)", most=1e6),
    Quirk("ramp_unit", 0.0, "increments/s² that a unit of ramps is; 0: the unit of speed, a second",
          "makers differ: tenths of rpm/s (Roboteq, CANBus Networking Manual, 0x6083)", most=1e6),
    Quirk("limits", False, "a drive that runs into a pressed limit switch does a quick stop",
          "the profile leaves it to the maker"),
    Quirk("keeps_position", False, "after power-on drives have their old position instead of 0",
          "depends on the encoder: absolute ones keep it, incremental ones do not"),
    Quirk("answer_ms", 1.0, "milliseconds until a drive has a frame ready",
          f"{_UNKNOWN}; a late frame describes an older state", guess=True),
    Quirk("boot_s", 0.5, "seconds from power or reset to the boot-up message",
          _UNKNOWN, guess=True, least=0.001, most=60.0),
    Quirk("reset_ms", 20.0, "milliseconds from a communication reset to the boot-up message",
          _UNKNOWN, guess=True),
    Quirk("late_watch", None, "the master is watched from its first heartbeat on",
          "CiA 301, object 1016"),
    Quirk("leaves_operation", None,
          "a node that misses its master's heartbeat becomes pre-operational while 1029:01 is 0",
          "CiA 301, object 1029; observed on the Lely CANopen stack 2.4 (co_nmt_on_hb); maxon's "
          "EPOS4 does so too (eposlib, CHANGELOG.md)"),
    Quirk("stopped_is_lost", None,
          "a node that is stopped by NMT, or whose communication is reset, reacts as if the master "
          "were lost",
          "CiA 402-2, object 6007 (abort connection)"),
    Quirk("goes_on", None, "after a quick stop that stays active, enabling continues the motion",
          "CiA 402-2, transition 16"),
    Quirk("old_target", None, "a drive that enters cyclic position mode moves to an old target",
          "not in the profile: a master must write the target first", guess=True),
    Quirk("stores_nothing", None, "after a power cut or a reset, objects are as the EDS says",
          "this EDS has no object 1010 (store parameters)"),
    Quirk("beats_together", None, "drives with the same heartbeat period send at the same moments",
          "a simplification that saves the simulation wake-ups", guess=True),
)
# fmt: on


KIND = SimDeviceKind(
    title=Cia402Board.title,
    board=Cia402Board,
    make=_make,
    options=(
        Option("bitrate", 500_000, "bits a second of the drives and their bus", BITRATES),
        Option("factory", False, "drives as many are sold: they count speeds in rpm, without 60A9"),
        Option("csp", True, "drives have cyclic synchronous position; else profile position alone"),
        Option("homing", True, "drives can home by themselves"),
        Option(
            "missing", "", "objects that the drives lack, for example 60C2; several are joined by +"
        ),
        Option(
            "constant",
            "",
            "objects that cannot be written, for example 60C2:02=-3; several are joined by +",
        ),
        Option(
            "profile", PROFILE, "the device profile that object 1000 reports", bounds=(0, 0xFFFF)
        ),
        Option(
            "following_window",
            -1,
            "following error window at power-on, in increments; -1: as in the EDS",
        ),
        *options_of(QUIRKS),
    ),
)
