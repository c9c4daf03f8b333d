"""Calibrating a drive's encoder against its motor, which turns: only with nothing on the shaft."""

from __future__ import annotations

from armdrive.commissioning.acts import About, Hear, Put, Stands, Talk, agreed, say
from armdrive.commissioning.drives import Known, reading
from armdrive.commissioning.plan import Planned
from firmware_protocol.mks import (
    Calibrate,
    Done,
    Event,
    Failed,
    MotorState,
    ReadState,
    StateRead,
)

LONGEST_S = 60.0
LOOK_S = 0.5
_ALREADY = "It says that it is calibrated already. Do it all the same?"


def calibrate(drive: Planned, found: Known) -> Talk[bool]:
    """Offer a calibration; return whether the encoder is calibrated, as far as is known."""
    known = found.version is not None
    already = found.version is not None and found.version.calibrated
    if already:
        wanted = yield from agreed(
            _ALREADY, "Only after a drive was put on another motor.", About.FREE, drive.motor, "no"
        )
    else:
        told = "says that it is not" if known else "does not tell whether it is"
        yield from say(
            f"Drive {drive.node} {told} calibrated. Calibration turns the motor by itself, for up "
            f"to {LONGEST_S:g} s, and nothing but its supply stops it for certain: nothing may be "
            "on its shaft, no belt, no gear, no arm. One sold on its motor mostly is calibrated."
        )
        wanted = yield from agreed(
            f"Is the shaft of the {drive.name} motor free, and may it turn now?",
            "no leaves it out; calibrate before the motor is built in.",
            About.FREE,
            drive.motor,
        )
    if not wanted:
        return already or not known
    return (yield from _carry_out(drive))


def _carry_out(drive: Planned) -> Talk[bool]:
    heard: tuple[Event, ...] = yield Put(drive.node, Calibrate())
    ended = _ending(heard)
    waited_s = 0.0
    while ended is None and waited_s < LONGEST_S:
        heard = yield Hear(LOOK_S)
        waited_s += LOOK_S
        ended = _ending(heard)
        if ended is None and not (yield from _busy(drive.node)):
            heard = yield Hear(LOOK_S)  # the word that ends it may be on its way
            ended = _ending(heard) is True
    yield Stands(drive.node)
    if ended:
        yield from say(f"Drive {drive.node} is calibrated.")
        return True
    yield from say(
        f"Drive {drive.node} did not calibrate. Look at the supply (12 V at least), at the motor's "
        "two phases, and that the magnet sits on the shaft's end; then try once more."
    )
    return False


def _ending(heard: tuple[Event, ...]) -> bool | None:
    """Return how it ended; None while it goes on."""
    for each in heard:
        if isinstance(each, Done | Failed) and isinstance(each.request, Calibrate):
            return isinstance(each, Done)
    return None


def _busy(node: int) -> Talk[bool]:
    found = yield from reading(node, ReadState())
    return isinstance(found, StateRead) and found.state is not MotorState.STOPPED
