"""What can be chosen of simulated CiA 402 drives.

A setting with a `source` is a quirk: what CiA 402 leaves to the maker of a drive, or what no source
says. A guess was never measured.
"""

from __future__ import annotations

from dataclasses import dataclass

from armdrive.text.toml import setting

# The bit rates of CiA 301.
BITRATES = (10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000)


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
# fmt: on
