"""What drives on a CAN bus share, whatever protocol they speak; here, their registry entries.

Read in this order:

    paths      the planned path of all motors, and each drive's course by its orders
    ledger     the open questions to a drive, the replies that it owes, how many it may miss
    observer   conclusions from orders, questions and replies: the table of verdicts, and when a
               drive counts as blocked, weak, off its path, mute, silent or late
    phases     what the drives of an arm do together: the table of phases and signals, and the
               stages of every dialect: the end of an earlier motion, stopping, homing
    drives     the motors of an arm, one drive each; ids, settings, missing drives
    tools      work on a bus without an arm: surveying drives and setting them up
    words      one frame described in words

If an MKS drive falls silent in motion, its ledger counts the unanswered polls. The observer
concludes `mute` (`silent` if no drive replies), and the table of `phases` stops the others and
reports why. A CiA 402 drive reports at every SYNC, so there the missed reports are counted instead
(`cia402.leading`).
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
        baud=BITRATE,
        torque=torque,
        abilities=Abilities(
            motors=6,
            coordinated=True,
            abort=Abort.RAMP,
            queued_segments=SEGMENTS_AHEAD,
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
