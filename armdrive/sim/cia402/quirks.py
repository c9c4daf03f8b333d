"""What can be chosen of simulated CiA 402 drives, and what they always do.

A setting with a `source` is a quirk: what CiA 402 leaves to the maker of a drive, or what no source
says. A guess was never measured.
"""

from __future__ import annotations

from dataclasses import dataclass

from armdrive.text.toml import setting

# The bit rates of CiA 301.
BITRATES = (10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)
_UNKNOWN = "not measured on any real drive"


# fmt: off
@dataclass(frozen=True, slots=True)
class Cia402Quirks:
    """The settings of simulated drives."""

    bitrate: int = setting(500_000, "bits a second of the drives and their bus", words=BITRATES)
    factory: bool = setting(False,
        "drives as many are sold: they count speeds in rpm, without 60A9")
    csp: bool = setting(True,
        "drives have cyclic synchronous position; else profile position alone")
    homing: bool = setting(True, "drives can home by themselves")
    missing: str = setting("",
        "objects that the drives lack, for example 60C2; several are joined by +")
    constant: str = setting("",
        "objects that cannot be written, for example 60C2:02=-3; several are joined by +")
    following_window: int = setting(-1,
        "following error window at power-on, in increments; -1: as in the EDS")

    hold_after_loss: str = setting("hold",
        "what a drive does when cyclic targets stop: hold the last one, or extrapolate",
        words=("hold", "extrapolate"),
        source="makers differ: SEW-EURODRIVE (MOVI-C, EtherCAT) can hold the set-point; "
        "STOBER (CiA 402 Controller Based, ID 442454.02, section 2.4) extrapolates "
        "up to I423, then faults")
    speed_unit: float = setting(0.0,
        "increments/s that a unit of speed is; 0: what 60A9 tells, or 1", low=0.0, high=1e6,
        source="makers differ: rpm (Roboteq, CANBus Networking Manual, 0x6081), 65536ths of "
        "increments in a period (Technosoft's iPOS, in roboticslab-uc3m/yarp-devices)")
    ramp_unit: float = setting(0.0,
        "increments/s² that a unit of ramps is; 0: the unit of speed, a second",
        low=0.0, high=1e6,
        source="makers differ: tenths of rpm/s (Roboteq, CANBus Networking Manual, 0x6083)")
    keeps_position: bool = setting(False,
        "after power-on drives have their old position instead of 0",
        source="depends on the encoder: absolute ones keep it, incremental ones do not")


# What cannot be chosen: name, what drives do, source.
ALWAYS: tuple[tuple[str, str, str], ...] = (
    ("by_sync", "a drive sends its TPDOs upon SYNC alone", "a simplification"),
    ("absolute", "each set-point of profile position is absolute, and obeyed at once; no halt",
     "a simplification: armdrive uses no others"),
    ("answers", "a drive has a frame ready after 1 ms", f"guess: {_UNKNOWN}"),
    ("boots", "the boot-up message comes 0.5 s after power or a reset", f"guess: {_UNKNOWN}"),
    ("resets", "the boot-up message comes 20 ms after a communication reset",
     f"guess: {_UNKNOWN}"),
    ("late_watch", "the master is watched from its first heartbeat on", "CiA 301, object 1016"),
    ("leaves_operation",
     "a node that misses its master's heartbeat becomes pre-operational while 1029:01 is 0",
     ("CiA 301, object 1029; observed on the Lely CANopen stack 2.4 (co_nmt_on_hb); maxon's "
      "EPOS4 does so too (eposlib, CHANGELOG.md)")),
    ("stopped_is_lost",
     ("a node that is stopped by NMT, or whose communication is reset, reacts as if the master "
      "were lost"),
     "CiA 402-2, object 6007 (abort connection)"),
    ("goes_on", "after a quick stop that stays active, enabling continues the motion",
     "CiA 402-2, transition 16"),
    ("old_target", "a drive that enters cyclic position mode moves to an old target",
     "guess: not in the profile: a master must write the target first"),
    ("stores_nothing", "after a power cut or a reset, objects are as the EDS says",
     "this EDS has no object 1010 (store parameters)"),
    ("beats_together", "drives with the same heartbeat period send at the same moments",
     "guess: a simplification that saves the simulation wake-ups"),
)
# fmt: on
