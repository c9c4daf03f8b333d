"""The row of the simulated arm on CiA 402 drives: how it is made for an arm, and its settings."""

from __future__ import annotations

import re

from armdrive.config.arm import ArmConfig
from armdrive.errors import BadRequest
from armdrive.sim.bus.drives import ShaftDrive, switches
from armdrive.sim.cia402.device import SimCia402
from armdrive.sim.cia402.node import Cia402Node, Cia402Quirks, ServoPoint
from armdrive.sim.cia402.objects import ENCODER_INCREMENTS, MOST_MOTOR_SPEED, dictionary, without
from armdrive.sim.device import Option, Options
from armdrive.sim.simulated_arm import SimDeviceKind
from armdrive.sim.world.arm import World
from firmware_protocol.canopen import (
    DEVICE_TYPE,
    FOLLOWING_ERROR_WINDOW,
    NODE_MAX,
    SUPPORTED_MODES,
    Dictionary,
    OperationMode,
    Place,
    supported_word,
)

PROFILE = 402
BITRATES = (10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)
"""Of CiA 301."""
_INDICES = re.compile(r"[0-9A-Fa-f]{4}(\+[0-9A-Fa-f]{4})*")
_ANSWER_MS = (0.0, 1000.0)
SLACK_S = 0.005
"""Orders that wait for their SYNC mind no shaft; who looks at its end sees what a period did."""


def _make(config: ArmConfig, world: World, options: Options) -> SimCia402:
    bits_s = options.whole("bitrate")
    if bits_s not in BITRATES:
        raise BadRequest(f"bitrate is one of {', '.join(map(str, BITRATES))}, not {bits_s}")
    objects, quirks = _objects(options), _quirks(options)
    points = [ServoPoint(count) for count in world.motors]
    drive = ShaftDrive(world, points, _top_rate(objects), SLACK_S)
    wired = switches(config, drive, behind=1)
    nodes = [
        Cia402Node(index, number, objects, drive, wired[index], quirks)
        for index, number in enumerate(_numbers(config, len(world.motors)))
    ]
    return SimCia402(world, drive, nodes, bits_s)


def _numbers(config: ArmConfig, count: int) -> tuple[int, ...]:
    numbers = tuple(getattr(config.device, "ids", ()) or range(1, count + 1))[:count]
    if len(numbers) < count:
        raise BadRequest(f"ids of {len(numbers)} drives cannot turn the {count} motors of this arm")
    if not all(1 <= number <= NODE_MAX for number in numbers):
        raise BadRequest(f"node ids are 1 to {NODE_MAX}, not {', '.join(map(str, numbers))}")
    return numbers


def _objects(options: Options) -> Dictionary:
    """Return what every drive has: what its EDS says, as far as nobody has wished otherwise."""
    missing, profile = options.text("missing"), options.whole("profile")
    if missing and not _INDICES.fullmatch(missing):
        raise BadRequest(f'missing is written "60C2", or as more joined by +, not {missing!r}')
    if not 0 <= profile <= 0xFFFF:
        raise BadRequest(f"profile is 0 to 65535, not {profile}")
    indices = frozenset(int(word, 16) for word in missing.split("+") if word)
    kind = dictionary().find(DEVICE_TYPE)
    high = 0 if kind is None else int(kind.default or 0) & ~0xFFFF
    changed: dict[Place, int] = {
        DEVICE_TYPE: high | profile,
        SUPPORTED_MODES: supported_word(_modes(options)),
    }
    if (window := options.whole("following_window")) >= 0:
        changed[FOLLOWING_ERROR_WINDOW] = window
    return without(indices, changed)


def _modes(options: Options) -> frozenset[OperationMode]:
    own = {OperationMode.PROFILE_POSITION: True}
    own[OperationMode.HOMING] = options.flag("homing")
    own[OperationMode.CYCLIC_POSITION] = options.flag("csp")
    return frozenset(mode for mode, has in own.items() if has)


def _top_rate(objects: Dictionary) -> float:
    """Return the increments a second that a drive makes up for: as fast as its motor turns."""
    speed, increments = objects.find(MOST_MOTOR_SPEED), objects.find(ENCODER_INCREMENTS)
    if speed is None or increments is None:
        raise BadRequest("a drive without 6080 and 608F turns nothing: it cannot lack them")
    return int(speed.default or 0) * int(increments.default or 0) / 60.0


def _quirks(options: Options) -> Cia402Quirks:
    answer_ms, boot_s = options.number("answer_ms"), options.number("boot_s")
    if not _ANSWER_MS[0] <= answer_ms <= _ANSWER_MS[1]:
        raise BadRequest(f"answer_ms is from 0 to {_ANSWER_MS[1]:g}, not {answer_ms:g}")
    if not 0.0 < boot_s <= 60.0:
        raise BadRequest(f"boot_s is above 0 and at most 60, not {boot_s:g}")
    return Cia402Quirks(
        modes=_modes(options),
        extrapolates=options.text("hold_after_loss") == "extrapolate",
        limits=options.flag("limits"),
        keeps_position=options.flag("keeps_position"),
        answer_s=answer_ms / 1000,
        boot_s=boot_s,
    )


KIND = SimDeviceKind(
    title="arm on CiA 402 drives",
    device=SimCia402,
    make=_make,
    options=(
        Option("bitrate", 500_000, "bits a second of the drives and their bus"),
        Option("csp", True, "drives have cyclic synchronous position; else profile position alone"),
        Option("homing", True, "drives can home by themselves"),
        Option("missing", "", "objects that the drives lack: 60C2 say, or more joined by +"),
        Option("profile", PROFILE, "the device profile that 1000 tells"),
        Option(
            "hold_after_loss",
            "hold",
            "what a drive does when its cyclic targets stop: stand at the last, or run on",
            ("hold", "extrapolate"),
        ),
        Option("limits", False, "a pressed limit switch has a drive quick-stop that leads into it"),
        Option("following_window", -1, "increments that a shaft may be behind at first; -1: EDS"),
        Option("keeps_position", False, "after power-on the position is what it was, not 0"),
        Option("answer_ms", 0.5, "milliseconds until a drive has a frame ready"),
        Option("boot_s", 0.5, "seconds from power or reset to the boot-up message"),
    ),
)
