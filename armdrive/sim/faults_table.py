"""The table of faults that a simulated arm can be given: name, arguments, what goes wrong.

Each row checks its arguments when the fault is asked for, and gives back what begins it.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from types import MappingProxyType

from armdrive.errors import BadRequest
from armdrive.sim.device import HasSwitches, Resettable, SimDevice
from armdrive.sim.fault_kind import FaultKind
from armdrive.sim.faults_arm import BROWN_OUT_S, brown_out, lose_steps, reset, stall, switch
from armdrive.sim.faults_wire import delaying, draw, garbage, mute, on_wire, replug, unplug
from armdrive.sim.wire_faults import changed, lost, repeated

AMOUNT = "P|#N|next"
"""How much: each byte with a probability, the n-th byte from now, or all of the next message."""
FAULTS: Mapping[str, FaultKind] = MappingProxyType(
    {
        kind.name: kind
        for kind in (
            FaultKind("drop", AMOUNT, "bytes are lost", on_wire(lambda _: lost), (1, 1)),
            FaultKind(
                "corrupt",
                AMOUNT,
                "bytes have a bit flipped",
                on_wire(lambda request: changed(draw(request, 2))),
                (1, 1),
            ),
            FaultKind("duplicate", AMOUNT, "bytes come twice", on_wire(lambda _: repeated), (1, 1)),
            FaultKind(
                "delay",
                f"SECONDS [{AMOUNT}]",
                "messages are late",
                on_wire(delaying, 1, "1"),
                (1, 2),
            ),
            FaultKind("mute", "", "the device says nothing", mute),
            FaultKind("garbage", "[COUNT]", "the device says noise, 8 bytes", garbage, (0, 1)),
            FaultKind("unplug", "", "the cable is pulled", unplug),
            FaultKind("replug", "[as NAME]", "the cable is put back", replug, (0, 2)),
            FaultKind(
                "brown-out",
                "",
                "power fails for half a second: registers are lost, the arm sags",
                brown_out,
                lasts_s=BROWN_OUT_S,
            ),
            FaultKind(
                "reset",
                "",
                "the board resets, its power on",
                reset,
                needs=Resettable,
            ),
            FaultKind("lose-steps", "MOTOR N", "the next N steps are lost", lose_steps, (2, 2)),
            FaultKind("stall", "MOTOR", "a motor no longer follows", stall, (1, 1)),
            FaultKind(
                "switch",
                "MOTOR open|closed|free",
                "a limit switch sticks",
                switch,
                (2, 2),
                needs=HasSwitches,
            ),
        )
    }
)
"""Every fault by its name; parsing, help and lists are made from it."""


def faults_of(device: type[SimDevice]) -> tuple[FaultKind, ...]:
    """Return the faults that a kind of device can have."""
    return tuple(kind for kind in FAULTS.values() if kind.befalls(device))


def fault_kind(name: str) -> FaultKind:
    """Return a row of the table; `BadRequest` suggests the nearest name."""
    if name in FAULTS:
        return FAULTS[name]
    near = difflib.get_close_matches(name, FAULTS, n=1, cutoff=0.4)
    hint = f"did you mean {near[0]!r}?" if near else f"there are {', '.join(FAULTS)}"
    raise BadRequest(f"there is no fault {name!r}; {hint}")
