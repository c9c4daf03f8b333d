"""Simulated arms on CiA 402 drives: how one is made from an arm file.

`node` is one drive: its frames, `objects` (what its EDS file describes), `states` and `motion`.
`quirks` is what can be chosen.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.bus import DrivesBoard
from armdrive.sim.bus.node import motors_of, node_ids
from armdrive.sim.cia402.node import Cia402Node, SavedCia402Drive
from armdrive.sim.cia402.objects import varied
from armdrive.sim.cia402.quirks import Cia402Quirks
from armdrive.sim.mechanics.shafts import ShaftDrive
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world import World
from firmware_protocol import canopen
from firmware_protocol.canopen import Dictionary, OperationMode, Place

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

    def put_in_fault(self, drive: int, code: int) -> None:
        """Put a drive in fault, until the error is fixed and the drive is reset."""
        node = self.node(drive)
        if node.port.powered:
            node.states.active_errors.add(code)
            node.states.fault(code, self.now_s)

    def fix(self, drive: int, code: int) -> None:
        """Remove the cause of a drive's error; the fault itself must still be reset."""
        self.node(drive).states.active_errors.discard(code)

    def warn(self, drive: int, code: int) -> None:
        """Make a drive send an EMCY that changes nothing."""
        self.node(drive).say_emcy(code)


def _make(config: ArmConfig, world: World, quirks: Cia402Quirks) -> Cia402Board:
    objects = _objects(quirks)
    shafts = ShaftDrive(world, _top_rate(objects))
    motors, modes = motors_of(config, shafts, beyond=1), _modes(quirks)
    nodes = [
        Cia402Node(motor, number, objects, modes, quirks)
        for motor, number in zip(motors, _numbers(config, len(motors)), strict=True)
    ]
    return Cia402Board(world, shafts, nodes, quirks.bitrate)


def _numbers(config: ArmConfig, count: int) -> tuple[int, ...]:
    numbers = node_ids(getattr(config.device, "ids", ()), count)
    if not all(1 <= number <= canopen.NODE_MAX for number in numbers):
        found = ", ".join(map(str, numbers))
        raise BadRequest(f"node ids are 1 to {canopen.NODE_MAX}, not {found}")
    return numbers


def _objects(quirks: Cia402Quirks) -> Dictionary:
    """Return every drive's objects: those of its EDS, changed by the settings."""
    missing = quirks.missing
    new = ("60A9",) if quirks.factory else ()
    if missing and not _INDICES.fullmatch(missing):
        raise BadRequest(f'missing is written "60C2", or as more joined by +, not {missing!r}')
    indices = frozenset(int(word, 16) for word in (*missing.split("+"), *new) if word)
    changed: dict[Place, int] = {canopen.SUPPORTED_MODES: canopen.supported_word(_modes(quirks))}
    constant = _constants(quirks.constant)
    if (window := quirks.following_window) >= 0:
        changed[canopen.FOLLOWING_ERROR_WINDOW] = window
    return varied(indices, {**changed, **constant}, constant)


def _constants(text: str) -> dict[Place, int]:
    found = [_CONSTANT.fullmatch(word) for word in text.split("+") if word]
    if not all(found):
        raise BadRequest(f'constant is written "60C2:02=-3", or as more joined by +, not {text!r}')
    return {Place(int(one[1], 16), int(one[2], 16)): int(one[3]) for one in found if one}


def _modes(quirks: Cia402Quirks) -> frozenset[OperationMode]:
    own = {OperationMode.PROFILE_POSITION: True}
    own[OperationMode.HOMING] = quirks.homing
    own[OperationMode.CYCLIC_POSITION] = quirks.csp
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


KIND = SimDeviceKind(Cia402Board, _make, Cia402Quirks)
