"""What an arm on CiA 402 drives can do, and how it is used where no arm file says otherwise."""

from __future__ import annotations

from armdrive.abilities import Torque, Traffic
from armdrive.dialects.bus import row
from armdrive.dialects.dialect import DeviceTools, Dialect, Driver, Language


def _driver() -> Driver:
    from armdrive.dialects.cia402.controller import DRIVER

    return DRIVER


def _tools() -> DeviceTools:
    from armdrive.dialects.cia402.survey import TOOLS

    return TOOLS


ENTRY = Dialect(
    name="cia402",
    title="CiA 402 drives",
    preset="minimover5-cia402",
    baud=row.BITS_S,
    raise_dtr=False,
    quick_stop=row.QUICK_STOP,
    torque=Torque(
        disable="sags: every drive switches its motor off",
        estop="is held: the drives brake on their quick-stop ramps and hold",
        power_loss="sags, and most drives count from zero afterwards",
        closed_port="is held: the drives miss the heartbeat, brake if they move, and hold",
    ),
    abilities=row.abilities(Traffic(line_chars=80, answer_chars=74), register_bits=32, beats=True),
    driver=_driver,
    tools=_tools,
    language=Language(
        "canopen",
        "CANopen",
        _tools,
        "An idle bus is silent where no drive was told to say heartbeats (object 1017)",
    ),
)
