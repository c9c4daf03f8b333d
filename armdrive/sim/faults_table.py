"""The table of faults that a simulated arm can be given: name, arguments, what goes wrong.

Each row checks its arguments when the fault is asked for, and gives back what begins it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from armdrive.errors import BadRequest
from armdrive.sim.device import HasSwitches, Resettable, SimDevice
from armdrive.sim.drives import DrivesOnBus, SaysEmergencies
from armdrive.sim.fault_kind import FaultKind
from armdrive.sim.faults_arm import BROWN_OUT_S, brown_out, lose_steps, reset, stall, switch
from armdrive.sim.faults_drives import (
    ailing_drive,
    alone,
    bus_off,
    dead_drive,
    frame_doubled,
    mute_drive,
    other_id,
    other_mode,
    reset_drive,
    warning_drive,
    without_done,
)
from armdrive.sim.faults_wire import (
    delaying,
    draw,
    garbage,
    mute,
    on_wire,
    replug,
    ruling,
    unplug,
)
from armdrive.sim.wire_faults import changed, lost, repeated
from armdrive.transports.can_faults import frame_lost, overtaken
from kinematics.errors import did_you_mean

_FRAMES = "P|#N|next"
"""How many: each frame with a probability, the one with the n-th byte from now, or the next."""
AMOUNT = "P|#N|next"
"""How much: each byte with a probability, the n-th byte from now, or all of the next message."""
_ON_BUS = tuple(
    replace(kind, needs=DrivesOnBus)
    for kind in (
        FaultKind("lose-frame", _FRAMES, "frames are lost", on_wire(lambda _: frame_lost), (1, 1)),
        FaultKind(
            "double-frame", _FRAMES, "frames come twice", on_wire(lambda _: frame_doubled), (1, 1)
        ),
        FaultKind(
            "overtake",
            _FRAMES,
            "frames come after the next one",
            ruling(lambda _, amount: overtaken(amount)),
            (1, 1),
        ),
        FaultKind("bus-off", "", "the host's adapter leaves the bus", bus_off),
        FaultKind("alone", "", "nobody acknowledges what the adapter sends", alone),
        FaultKind("drive-mute", "MOTOR", "a drive says nothing, but obeys", mute_drive, (1, 1)),
        FaultKind("drive-dead", "MOTOR", "a drive has no supply", dead_drive, (1, 1)),
        FaultKind("drive-reset", "MOTOR", "a drive begins anew", reset_drive, (1, 1)),
        FaultKind("drive-mode", "MOTOR MODE", "a drive has another mode", other_mode, (2, 2)),
        FaultKind("drive-id", "MOTOR ID", "a drive has another id", other_id, (2, 2)),
        FaultKind("no-done", "MOTOR", "a drive says no motion done", without_done, (1, 1)),
    )
)
"""What befalls drives on a CAN bus alone."""
_OF_DRIVES = tuple(
    replace(kind, needs=SaysEmergencies)
    for kind in (
        FaultKind("drive-fault", "MOTOR CODE", "a drive fails, 4310 say", ailing_drive, (2, 2)),
        FaultKind("drive-emcy", "MOTOR CODE", "a drive says an EMCY alone", warning_drive, (2, 2)),
    )
)
"""What befalls drives that have error codes."""
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
            *_ON_BUS,
            *_OF_DRIVES,
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
    hint = did_you_mean(name, FAULTS, f"there are {', '.join(FAULTS)}", likeness=0.4)
    raise BadRequest(f"there is no fault {name!r}; {hint}")
