"""What drives on a CAN bus share, whatever protocol they speak; here, their registry entries.

Read in this order:

    paths      the planned path of all motors
    homing     the end of an earlier motion, and the drives' own homing
    drives     the motors of an arm, one drive each; ids, settings, missing drives
    tools      work on a bus without an arm: surveying drives and setting them up
    words      one frame described in words

Both dialects have one shape: an exchange holds the drives and what is known of them, and each
request is one script over it (`contact`, `motion`, `homing`, `compare`). The scripts themselves are
not shared. An MKS drive reports its position when it is asked, and gets speeds and targets. A CiA
402 drive reports it at every SYNC, and gets places. How a script notices a fault, or the end of a
motion, follows from that.
"""

from __future__ import annotations

from collections.abc import Callable

from armdrive.abilities import SEGMENTS_AHEAD, Abilities, Abort, Switching, Torque, Traffic
from armdrive.dialects import DeviceTools, Dialect, Driver, Language
from armdrive.transports.address import BITRATE


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
    beats: bool = False,
) -> Dialect:
    """Return the entry of a dialect; `language` is the protocol's name in commands and in words.

    The abilities are those of drives as shipped; the controller refines them.
    """
    return Dialect(
        name=name,
        title=title,
        preset=f"minimover5-{name}",
        baud=BITRATE,
        torque=torque,
        abilities=Abilities(
            motors=6,
            coordinated=True,
            abort=Abort.RAMP,
            queued_segments=SEGMENTS_AHEAD,
            reports_while_moving=True,
            own_homing=True,
            current=Switching.BOTH,
            jog_burst_s=0.15,
            planned_burst_s=0.3,
            traffic=traffic,
            register_bits=register_bits,
            ramp_s=0.15,
            jerk_s=0.05,
            encoders=True,
            beats=beats,
        ),
        driver=driver,
        tools=tools,
        language=Language(*language, tools, silence),
    )
