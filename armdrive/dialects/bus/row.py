"""Registry entries of arms with drives on a CAN bus: what all of them share."""

from __future__ import annotations

from collections.abc import Callable

from armdrive.abilities import Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects.dialect import DeviceTools, Dialect, Driver, Language

BITS_S = 500_000
"""The default bit rate of the bus."""


def bus_dialect(
    name: str,
    title: str,
    language: tuple[str, str],
    *,
    driver: Callable[[], Driver],
    tools: Callable[[], DeviceTools],
    torque: Torque,
    traffic: Traffic,
    register_bits: int,
    silence: str,
    check_bytes: bool,
    beats: bool = False,
) -> Dialect:
    """Return the entry of a dialect; `language` is the protocol's name in commands and in words.

    The abilities are those of drives as shipped; the controller refines them.
    """
    return Dialect(
        name=name,
        title=title,
        preset=f"minimover5-{name}",
        baud=BITS_S,
        torque=torque,
        abilities=Abilities(
            motors=6,
            coordinated=True,
            abort=Abort.RAMP,
            queued_segments=3,
            reports_while_moving=True,
            own_homing=True,
            check_bytes=check_bytes,
            current=Switching.BOTH,
            jog_burst_s=0.15,
            planned_burst_s=0.3,
            traffic=traffic,
            register_bits=register_bits,
            ramp_s=0.15,
            jerk_s=0.05,
            beats=beats,
        ),
        driver=driver,
        tools=tools,
        language=Language(*language, tools, silence),
    )
