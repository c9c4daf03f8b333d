"""What CiA 402 leaves to the maker of a drive, or what no source tells: one row a quirk."""

from __future__ import annotations

from armdrive.sim.bus.node import Quirk

_UNKNOWN = "not measured on any real drive"

# each row: name, default, what it does, source; without a default the drives are always so
# fmt: off
QUIRKS: tuple[Quirk, ...] = (
    Quirk("hold_after_loss", "hold",
          "what a drive does when cyclic targets stop: hold the last one, or extrapolate",
          "makers differ: SEW-EURODRIVE (MOVI-C, EtherCAT) can hold the set-point; "
          "STOBER (CiA 402 Controller Based, ID 442454.02, section 2.4) extrapolates "
          "up to I423, then faults", ("hold", "extrapolate")),
    Quirk("limits", False, "a drive that runs into a pressed limit switch does a quick stop",
          "the profile leaves it to the maker"),
    Quirk("keeps_position", False, "after power-on drives have their old position instead of 0",
          "depends on the encoder: absolute ones keep it, incremental ones do not"),
    Quirk("answer_ms", 1.0, "milliseconds until a drive has a frame ready",
          f"{_UNKNOWN}; a late frame describes an older state", guess=True),
    Quirk("boot_s", 0.5, "seconds from power or reset to the boot-up message",
          _UNKNOWN, guess=True, most=60.0, above_zero=True),
    Quirk("reset_ms", 20.0, "milliseconds from a communication reset to the boot-up message",
          _UNKNOWN, guess=True),
    Quirk("late_watch", None, "the master is watched from its first heartbeat on",
          "CiA 301, object 1016"),
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
