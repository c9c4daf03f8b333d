"""Calibrating a drive's encoder against its motor, which turns: only with nothing on the shaft."""

from __future__ import annotations

from armdrive.commissioning.acts import About, Hear, Put, Stands, Talk, agreed, say
from armdrive.commissioning.drives import Known, answer_of
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
LOOK_S = 0.1
"""So often it is asked how it fares, which feeds the watchdog where that is on already."""
BEGUN_S = 0.5
"""A drive that stands so long after it was told to calibrate does not do it."""
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
    ended, waited_s = _ending(heard), 0.0
    while ended is None and waited_s < LONGEST_S:
        heard = yield Hear(LOOK_S)
        heard += yield Put(drive.node, ReadState())
        waited_s += LOOK_S
        ended = _ending(heard)
        if ended is None and waited_s > BEGUN_S and _stands(heard):
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


def _stands(heard: tuple[Event, ...]) -> bool:
    """Tell whether a drive says that its motor stands; one that is busy may say nothing."""
    found = answer_of(heard)
    return isinstance(found, StateRead) and found.state is MotorState.STOPPED
