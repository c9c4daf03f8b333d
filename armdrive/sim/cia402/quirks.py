"""What CiA 402 leaves to the maker of a drive, or what no source tells: one row a quirk."""

from __future__ import annotations

from dataclasses import dataclass

from armdrive.sim.bus.node import Quirk
from firmware_protocol.canopen import OperationMode

QUIRKS: tuple[Quirk, ...] = (
    Quirk(
        "hold_after_loss",
        "what a drive does when its cyclic targets stop: stand at the last, or run on",
        "makers differ: by SEW-EURODRIVE (MOVI-C, EtherCAT, distributed clocks) a set-point may "
        "stop and not be extrapolated; STOBER extrapolates up to I423 and then fails (CiA 402 "
        "Controller Based, ID 442454.02, section 2.4)",
        default="hold",
        choices=("hold", "extrapolate"),
    ),
    Quirk(
        "limits",
        "a pressed limit switch has a drive quick-stop that leads into it",
        "left to the maker; EMCY 8612 is a reached limit in CiA 402-2",
        default=False,
    ),
    Quirk(
        "keeps_position",
        "after power-on the position is what it was, not 0",
        "the encoder decides: an absolute one keeps it, an incremental one does not",
        default=False,
    ),
    Quirk(
        "answer_ms",
        "milliseconds until a drive has a frame ready",
        "not measured on any real drive",
        default=0.5,
        guess=True,
    ),
    Quirk(
        "boot_s",
        "seconds from power or reset to the boot-up message",
        "not measured on any real drive",
        default=0.5,
        guess=True,
        most=60.0,
        above_zero=True,
    ),
    Quirk(
        "reset_ms",
        "milliseconds from a reset of the communication to the boot-up message",
        "not measured on any real drive",
        default=20.0,
        guess=True,
    ),
    Quirk(
        "watch_from_first_beat",
        "a drive minds its master's silence from the first heartbeat on",
        "CiA 301, object 1016",
    ),
    Quirk(
        "stopped_is_silent",
        "a node that NMT stops, or whose communication is reset, reacts as if its master were lost",
        "CiA 402-2, object 6007 (abort connection)",
    ),
    Quirk(
        "goes_on",
        "a drive in quick stop that stays takes a later enabling as an order to go on",
        "CiA 402-2, transition 16",
    ),
    Quirk(
        "old_target",
        "a drive that begins cyclic position goes at once to the target that lies there",
        "not in the profile: a master has to write the target first",
        guess=True,
    ),
    Quirk(
        "stores_nothing",
        "without power, or after a node's reset, all objects hold what the EDS says",
        "this EDS has no 1010; a reset of the communication loses what is below 2000 (CiA 301)",
    ),
    Quirk(
        "beats_together",
        "drives of one heartbeat period beat at the same moments",
        "a simplification of the simulation, which wakes less often for it",
        guess=True,
    ),
)
"""Those without a default are no setting: the drives are always so."""


@dataclass(frozen=True, slots=True)
class Cia402Quirks:
    """The choice for each row that has one, by its name; and the modes that a drive has."""

    modes: frozenset[OperationMode]
    hold_after_loss: str
    limits: bool
    keeps_position: bool
    answer_ms: float
    boot_s: float
    reset_ms: float
