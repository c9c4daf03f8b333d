"""The table of dialects: what each device can do, and the makers of its two ends.

The driver chooses its strategies from `abilities` alone; no other file asks which dialect it is.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects.bus.tools import BusTools
from armdrive.dialects.bus.words import Ear
from armdrive.dialects.cia402.frames import CanopenEar
from armdrive.dialects.cia402.survey import BUS as CANOPEN_BUS
from armdrive.dialects.mks.commissioning import BUS as MKS_BUS
from armdrive.dialects.mks.frames import MksEar
from armdrive.dialects.pendant import PendantTools
from armdrive.dialects.teachmover.pendant import PENDANT

# The TeachMover's is the one such program so far: other code takes the name from the registry.
from armdrive.dialects.teachmover.pendant import PendantProgram as PendantProgram
from armdrive.errors import BadRequest, Refused
from firmware_protocol.frames import Frame
from kinematics.errors import suggestion

if TYPE_CHECKING:
    from armdrive.config.arm import ArmConfig
    from armdrive.dialects.controller import Controller


@dataclass(frozen=True, slots=True)
class Dialect:
    """One row: `preset` is the arm that speaks it where no arm file says otherwise.

    `raise_dtr` is how its port is opened by default: a board with native USB is mute without it.
    `settings` gives the class of what an arm file says in the section of the dialect's name, and
    `controller` the driver's end for an arm. `can` says that it is spoken on a CAN bus: its port is
    an adapter's, and `baud` the bus's bit rate; `bus` is how its drives are surveyed and set up.
    `pendant` is how the program in the arm's own memory is read, of an arm that keeps one.
    """

    name: str
    title: str
    preset: str
    baud: int
    raise_dtr: bool
    quick_stop: str
    torque: Torque
    abilities: Abilities
    settings: Callable[[], type[Any]]
    controller: Callable[[ArmConfig], Controller]
    can: bool = False
    bus: BusTools | None = None
    pendant: PendantTools[PendantProgram] | None = None


def _teachmover_settings() -> type[Any]:
    from armdrive.dialects.teachmover.controller import TeachMoverSettings

    return TeachMoverSettings


def _teachmover(config: ArmConfig) -> Controller:
    from armdrive.dialects.teachmover.controller import TeachMoverController

    return TeachMoverController(
        DIALECTS["teachmover"].abilities, config.device, config.connection.baud
    )


def _armdroid_settings() -> type[Any]:
    from armdrive.dialects.armdroid.settings import ArmdroidSettings

    return ArmdroidSettings


def _armdroid(config: ArmConfig) -> Controller:
    from armdrive.dialects.armdroid.controller import ArmdroidController

    return ArmdroidController(DIALECTS["armdroid"].abilities, config.device, config.connection.baud)


def _robko01_settings() -> type[Any]:
    from armdrive.dialects.robko01.settings import RobkoSettings

    return RobkoSettings


def _robko01(config: ArmConfig) -> Controller:
    from armdrive.dialects.robko01.controller import RobkoController

    return RobkoController(DIALECTS["robko01"].abilities, config.device, config.connection.baud)


def _grbl_settings() -> type[Any]:
    from armdrive.dialects.grbl.settings import GrblSettings

    return GrblSettings


def _grbl(config: ArmConfig) -> Controller:
    from armdrive.dialects.grbl.controller import GrblController

    return GrblController(DIALECTS["grbl"].abilities, config)


def _mks_settings() -> type[Any]:
    from armdrive.dialects.mks.settings import MksSettings

    return MksSettings


def _mks(config: ArmConfig) -> Controller:
    from armdrive.dialects.mks.controller import MksController

    return MksController(DIALECTS["mks"].abilities, config)


def _cia402_settings() -> type[Any]:
    from armdrive.dialects.cia402.settings import Cia402Settings

    return Cia402Settings


def _cia402(config: ArmConfig) -> Controller:
    from armdrive.dialects.cia402.controller import Cia402Controller

    return Cia402Controller(DIALECTS["cia402"].abilities, config)


DIALECTS: Mapping[str, Dialect] = MappingProxyType(
    {
        "teachmover": Dialect(
            name="teachmover",
            title="TeachMover",
            preset="teachmover",
            baud=9600,
            raise_dtr=False,
            quick_stop="The STOP key of the pendant is the quicker stop: it ends a burst at once.",
            torque=Torque(
                disable="sags: `@RESET` takes the current away until the next motion",
                estop="is held: the burst under way is finished, and the current stays on",
                power_loss="sags, and the registers are zero afterwards",
                closed_port="is held: nothing is sent, and DTR and RTS stay down",
            ),
            abilities=Abilities(
                motors=6,
                coordinated=True,
                abort=Abort.NONE,
                queued_segments=0,
                speed_mode_with_watchdog=False,
                reports_while_moving=False,
                own_homing=False,
                resets_on_open=False,
                check_bytes=False,
                current=Switching.DROPS,
                grip_switch=True,
                pendant=True,
                jog_burst_s=0.15,
                planned_burst_s=0.15,
                traffic=Traffic(line_chars=36, answer_chars=2),
                register_bits=16,
                program_rows=64,
                inputs=7,
            ),
            settings=_teachmover_settings,
            controller=_teachmover,
            pendant=PENDANT,
        ),
        "robko01": Dialect(
            name="robko01",
            title="Robko 01",
            preset="robko01",
            baud=115_200,
            raise_dtr=False,
            quick_stop="The switch of its power supply is the quicker stop: the arm sags then.",
            torque=Torque(
                disable="sags: the motors are switched off",
                estop="is held: the burst ramps down; whether an AVR board holds, feel once",
                power_loss="sags, and the registers are zero afterwards",
                closed_port="is held on a serial port; sags when the retrofit's TCP link ends",
            ),
            abilities=Abilities(
                motors=6,
                coordinated=False,
                abort=Abort.RAMP,
                queued_segments=0,
                speed_mode_with_watchdog=False,
                reports_while_moving=True,
                own_homing=False,
                resets_on_open=False,
                check_bytes=True,
                current=Switching.BOTH,
                grip_switch=False,
                pendant=False,
                jog_burst_s=0.25,
                planned_burst_s=0.5,
                traffic=Traffic(line_chars=32, answer_chars=12),
                register_bits=16,
                inputs=8,
            ),
            settings=_robko01_settings,
            controller=_robko01,
        ),
        "armdroid": Dialect(
            name="armdroid",
            title="Armdroid 1",
            preset="armdroid1",
            baud=9600,
            raise_dtr=True,
            quick_stop="The motors' power switch is the only quicker stop, and the arm sags then.",
            torque=Torque(
                disable="sags: `0t` takes the current away; firmware before 2.0 cannot, and holds",
                estop="is held: the burst under way is finished, and the current stays on",
                power_loss="sags; a reset of the board alone is up to the interface",
                closed_port="is held, unless the board is reset by the next opening of its port",
            ),
            abilities=Abilities(
                motors=6,
                coordinated=False,
                abort=Abort.NONE,
                queued_segments=0,
                speed_mode_with_watchdog=False,
                reports_while_moving=False,
                own_homing=False,
                resets_on_open=True,
                check_bytes=False,
                current=Switching.BOTH,
                grip_switch=False,
                pendant=False,
                jog_burst_s=0.15,
                planned_burst_s=0.15,
                traffic=Traffic(line_chars=22, answer_chars=60, device_s=0.2),
                register_bits=16,
            ),
            settings=_armdroid_settings,
            controller=_armdroid,
        ),
        "grbl": Dialect(
            name="grbl",
            title="GRBL board",
            preset="minimover5",
            baud=115_200,
            raise_dtr=False,
            quick_stop="The switch of the motors' supply is the quicker stop: the arm sags then.",
            torque=Torque(
                disable="sags: `$SLP` puts the board and its motors to sleep",
                estop="sags for 0.5 s in motion (`ALARM:3`), then is held; grblHAL holds it",
                power_loss="sags, and the position is zero afterwards",
                closed_port="is held where `$1` is 255; opening the port resets most boards",
            ),
            abilities=Abilities(
                motors=6,
                coordinated=True,
                abort=Abort.RAMP,
                queued_segments=15,
                speed_mode_with_watchdog=False,
                reports_while_moving=True,
                own_homing=True,
                resets_on_open=True,
                check_bytes=False,
                current=Switching.DROPS,
                grip_switch=False,
                pendant=False,
                jog_burst_s=0.15,
                planned_burst_s=0.4,
                traffic=Traffic(line_chars=34, answer_chars=4),
                register_bits=32,
                ramp_s=0.15,
                jerk_s=0.05,
                inputs=11,
            ),
            settings=_grbl_settings,
            controller=_grbl,
        ),
        "mks": Dialect(
            name="mks",
            title="MKS servo drives",
            preset="minimover5-mks",
            baud=500_000,
            raise_dtr=False,
            quick_stop="The switch of the motors' supply is the quicker stop: the arm sags then.",
            torque=Torque(
                disable="sags: every drive switches its motor off",
                estop="is held: the drives stop dead and hold; above 1000 rpm they ramp down",
                power_loss="sags, and the drives count from zero afterwards",
                closed_port="is held: the drives stand and hold, whoever is silent",
            ),
            abilities=Abilities(
                motors=6,
                coordinated=True,
                abort=Abort.RAMP,
                queued_segments=3,
                speed_mode_with_watchdog=False,
                reports_while_moving=True,
                own_homing=True,
                resets_on_open=False,
                check_bytes=True,
                current=Switching.BOTH,
                grip_switch=False,
                pendant=False,
                jog_burst_s=0.15,
                planned_burst_s=0.3,
                traffic=Traffic(line_chars=78, answer_chars=60),
                register_bits=48,
                ramp_s=0.15,
                jerk_s=0.05,
            ),
            settings=_mks_settings,
            controller=_mks,
            can=True,
            bus=MKS_BUS,
        ),
        "cia402": Dialect(
            name="cia402",
            title="CiA 402 drives",
            preset="minimover5-cia402",
            baud=500_000,
            raise_dtr=False,
            quick_stop="The switch of the motors' supply is the quicker stop: the arm sags then.",
            torque=Torque(
                disable="sags: every drive switches its motor off",
                estop="is held: the drives brake on their quick-stop ramps and hold",
                power_loss="sags, and most drives count from zero afterwards",
                closed_port="is held: the drives miss the heartbeat, brake if they move, and hold",
            ),
            abilities=Abilities(
                motors=6,
                coordinated=True,
                abort=Abort.RAMP,
                queued_segments=3,
                speed_mode_with_watchdog=False,
                reports_while_moving=True,
                own_homing=True,
                resets_on_open=False,
                check_bytes=True,
                current=Switching.BOTH,
                grip_switch=False,
                pendant=False,
                jog_burst_s=0.15,
                planned_burst_s=0.3,
                traffic=Traffic(line_chars=80, answer_chars=74),
                register_bits=32,
                ramp_s=0.15,
                jerk_s=0.05,
                beats=True,
            ),
            settings=_cia402_settings,
            controller=_cia402,
            can=True,
            bus=CANOPEN_BUS,
        ),
    }
)


def dialect(name: str) -> Dialect:
    """Return a row of the table; raises `BadRequest` that suggests the nearest name."""
    try:
        return DIALECTS[name]
    except KeyError:
        hint = suggestion(name, DIALECTS)
        raise BadRequest(
            f"no dialect is named {name!r}; known are {', '.join(DIALECTS)}{hint}"
        ) from None


def pendant_of(config: ArmConfig) -> PendantTools[PendantProgram]:
    """Return how an arm's own program is read and written; raises `Refused` where it has none."""
    tools = dialect(config.connection.dialect).pendant
    if tools is None:
        raise Refused(f"the {config.title} keeps no program in a memory of its own")
    return tools


# The table of what drives on a CAN bus speak: who hears it, and which dialects speak it.


@dataclass(frozen=True, slots=True)
class Language:
    """One row. `silence` says what it means that nothing passes."""

    name: str
    title: str
    dialect: str
    ear: Callable[[], Ear]
    silence: str


LANGUAGES: Mapping[str, Language] = MappingProxyType(
    {
        each.name: each
        for each in (
            Language(
                "mks",
                "MKS drives",
                "mks",
                MksEar,
                "An idle bus of drives is silent: they speak when they are asked",
            ),
            Language(
                "canopen",
                "CANopen",
                "cia402",
                CanopenEar,
                "An idle bus is silent where no drive was told to say heartbeats (object 1017)",
            ),
        )
    }
)
"""Every language by its name."""
USUAL = LANGUAGES["mks"]
"""Taken where nobody says otherwise."""


def language_of(dialect: str) -> Language:
    """Return the language of a dialect that is spoken on a bus, the usual one of any other."""
    return next((each for each in LANGUAGES.values() if each.dialect == dialect), USUAL)


def likely(frames: Iterable[Frame]) -> Language:
    """Return the language in which the most of some frames can be read."""
    heard = tuple(frames)

    def foreign(language: Language) -> int:
        ear = language.ear()
        return sum(ear.hear(frame).foreign for frame in heard)

    return min(LANGUAGES.values(), key=foreign)
