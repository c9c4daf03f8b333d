"""What drives on a CAN bus share, whatever protocol they speak; here, their registry entries.

Read in this order:

    paths      the planned path of all motors, and each drive's course by its orders
    questions  the open questions about a drive's position, and when a reading was sampled
    intervals  where a healthy shaft can be, and what a reading shows that lies elsewhere
    observer   conclusions from the orders, questions and replies of each drive
    phases     what the drives of an arm do together: the table of phases and signals, and the
               stages of every dialect: the end of an earlier motion, stopping, homing
    drives     the motors of an arm, one drive each; ids, settings, missing drives
    tools      work on a bus without an arm: surveying drives and setting them up
    words      one frame described in words

What a drive counts as, when, and where that is decided. `fits`, `doubted` and `behind` are watched.
Each of the others ends the motion (MKS by the table of `phases`): all drives stop, the one with the
trouble is asked why if it replies, all hold where they stand, and the position is suspect. CiA 402
drives judge their following error by themselves, so that only MKS drives need the observer.

  fits        within reach, and where its orders had it lately               intervals
  doubted     out of reach once: asked again at once, else ignored           observer
  behind      within reach but off its path; comes nearer, or turns at       intervals
              least half as far as ordered
  blocked     like behind, but does neither; or stands off its orders for    intervals
              0.15 s, although it confirmed one meanwhile
              MKS: stands short of its last target at nine looks, or has     mks.motion
              left it in a pause after an outage
              CiA 402: has stood off its target for 0.6 s                    cia402.motion
  restarted   out of reach twice, and its count can have run up from zero    observer
              MKS: the same, but it was away (it owes replies) instead       mks.drive, ledger
              CiA 402: its boot-up message came                              cia402.drives
              CiA 402: its settings are gone when it is contacted            cia402.contact
  elsewhere   out of reach twice, otherwise                                  observer
              at rest: is read off its place                                 mks, cia402.contact
  off path    no single time offset explains all positions, at two looks     mks.steering
              MKS: came to rest beyond where its stop can have led it        mks.stops
  mute        MKS: missed four polls while another drive replied             mks.observer
              MKS, braking: missed eight                                     mks.stops
              CiA 402: does not tell its state when it may have stopped,     cia402.exchange
              or sends no report until that is asked again
              CiA 402, at rest: does not answer a request                    cia402.exchange
  silent      MKS: all drives missed ten polls                               mks.observer
  late        MKS: 15 late readings in a row, and no drive sends prompt ones mks.observer
  unfit       MKS: rejects two orders, and has stalled, has no current or    mks.drive
              is in another mode; or a limit switch has stopped it
              CiA 402: was not enabled for a cycle                           cia402.drives
              CiA 402: is in another mode                                    cia402.motion

An MKS drive tells its position when it is asked (a poll), a CiA 402 drive at every SYNC.
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
