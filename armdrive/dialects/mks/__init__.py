"""Driving MKS SERVO42D/57D drives on a CAN bus.

Read in this order, after `dialects.bus`:

    controller   requests of an arm: which collaborator carries out each
    wire         what is said to the drives and what they answer; every answer feeds the observer
    contact      finding the drives, switching them on and off, clearing stalls
    motion       the stages of a motion, from the first order until all stand
    steering     the orders along a way, given again and again in flight
    bursts       motion by firmware that cannot be steered
    stops        stopping, and leaving no drive pushing against anything
    homing       the drives' own search for their switches
    inquiry      what a drive is asked about itself: firmware, shared ids, why it does not move

The rest is for people: `settings` and `compare` for the arm file, `survey` and `commissioning` for
a bus and its drives, `words` for what passes on it.

Here is the row of the registry: what such an arm can do, and how it is used where no arm file says
otherwise.
"""

from __future__ import annotations

from armdrive.abilities import Torque, Traffic
from armdrive.dialects.bus import row
from armdrive.dialects.dialect import DeviceTools, Dialect, Driver, Language


def _driver() -> Driver:
    from armdrive.dialects.mks.controller import DRIVER

    return DRIVER


def _tools() -> DeviceTools:
    from armdrive.dialects.mks.commissioning import TOOLS

    return TOOLS


ENTRY = Dialect(
    name="mks",
    title="MKS servo drives",
    preset="minimover5-mks",
    baud=row.BITS_S,
    raise_dtr=False,
    quick_stop=row.QUICK_STOP,
    torque=Torque(
        disable="sags: every drive switches its motor off",
        estop="is held: the drives stop dead and hold; above 1000 rpm they ramp down",
        power_loss="sags, and the drives count from zero afterwards",
        closed_port="is held: the drives stand and hold, whoever is silent",
    ),
    abilities=row.abilities(Traffic(line_chars=78, answer_chars=60), register_bits=48),
    driver=_driver,
    tools=_tools,
    language=Language(
        "mks",
        "MKS drives",
        _tools,
        "An idle bus of drives is silent: they speak when they are asked",
    ),
)
