"""What CiA 402 leaves to the maker of a drive, or what no source tells: one row a quirk."""

from __future__ import annotations

from armdrive.sim.bus.node import Quirk

_UNKNOWN = "not measured on any real drive"

# each row: name, default, what it does, source; without a default the drives are always so
# fmt: off
QUIRKS: tuple[Quirk, ...] = (
    Quirk("hold_after_loss", "hold",
          "what a drive does when its cyclic targets stop: stand at the last, or run on",
          "makers differ: by SEW-EURODRIVE (MOVI-C, EtherCAT) a set-point may stop and not be "
          "extrapolated; STOBER (CiA 402 Controller Based, ID 442454.02, section 2.4) extrapolates "
          "up to I423, and then fails", ("hold", "extrapolate")),
    Quirk("limits", False, "a pressed limit switch has a drive quick-stop that leads into it",
          "left to the maker"),
    Quirk("keeps_position", False, "after power-on the position is what it was, not 0",
          "the encoder decides: an absolute one keeps it, an incremental one does not"),
    Quirk("answer_ms", 1.0, "milliseconds until a drive has a frame ready",
          f"{_UNKNOWN}; the later, the older is what it tells", guess=True),
    Quirk("boot_s", 0.5, "seconds from power or reset to the boot-up message",
          _UNKNOWN, guess=True, most=60.0, above_zero=True),
    Quirk("reset_ms", 20.0, "milliseconds from a reset of the communication to the boot-up message",
          _UNKNOWN, guess=True),
    Quirk("late_watch", None, "the master's silence is minded from its first heartbeat on",
          "CiA 301, object 1016"),
    Quirk("stopped_is_lost", None,
          "a node that NMT stops or whose communication is reset reacts as to a lost master",
          "CiA 402-2, object 6007 (abort connection)"),
    Quirk("goes_on", None, "in a quick stop that stays, enabling is an order to go on",
          "CiA 402-2, transition 16"),
    Quirk("old_target", None, "who begins cyclic position goes at once to an old target",
          "not in the profile: a master has to write the target first", guess=True),
    Quirk("stores_nothing", None, "without power, or after a reset, objects are as the EDS says",
          "this EDS has no 1010"),
    Quirk("beats_together", None, "drives of one heartbeat period beat at the same moments",
          "a simplification of the simulation, which wakes less often for it", guess=True),
)
# fmt: on
