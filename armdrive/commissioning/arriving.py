"""One drive comes to the bus: it is recognised by its id, or given it. Nothing turns."""

from __future__ import annotations

from armdrive.commissioning.acts import About, Hear, Put, Talk, agreed, say
from armdrive.commissioning.drives import Known, answers, doubled, known
from armdrive.commissioning.plan import Plan, Planned
from firmware_protocol.mks import NODE_DEFAULT, Done, Event, Failed, SetId

SETTLE_S = 0.3
"""A drive that was given an id has taken it by then."""

ONE_AT_A_TIME = (
    "Every drive is shipped as id 1. Two of one id obey one command both, and spoil each other's "
    "answers: so plug in one new drive at a time."
)
CHECKS = (
    "Nobody answers. Check that the drive has its motor supply, that CAN H and L are not swapped, "
    "that both ends of the cable have their resistor of 120 ohm, and that its bit rate (CanRate in "
    "its menu, 500K as shipped) is that of the adapter. `armdrive doctor --can` tells what is "
    "known of the bus."
)


def arrive(plan: Plan, drive: Planned) -> Talk[Known | None]:
    """Bring a drive to its id; None where the person leaves it out."""
    found = yield from _recognised(plan, drive)
    while found is None:
        if not (yield from _plug_in(drive)):
            return None
        ready: bool | None = yield from answers(drive.node)
        if not ready:
            ready = yield from _give_id(drive)
        if ready is None:
            return None
        if ready:
            found = yield from _checked(drive)
    return found


def _recognised(plan: Plan, drive: Planned) -> Talk[Known | None]:
    """Return the drive where its id answers and nobody else can be meant by it."""
    if drive.node == NODE_DEFAULT and len(plan.drives) > 1:
        return None  # may be a new drive: the person has to say that it is this one
    if not (yield from answers(drive.node)):
        return None
    return (yield from _checked(drive))


def _plug_in(drive: Planned) -> Talk[bool]:
    words = f"Is the drive of the {drive.name} plugged in, and no other new one?"
    yield from say(
        f"Plug the CAN cable of the {drive.name} drive in. Drives that have their ids may stay."
    )
    return (
        yield from agreed(
            words,
            f"{ONE_AT_A_TIME} no leaves the {drive.name} out for now.",
            About.CONNECT,
            drive.motor,
        )
    )


def _checked(drive: Planned) -> Talk[Known | None]:
    """Look at a drive that answers; None where two do, or it is gone again."""
    found = yield from known(drive.node)
    if found is None:
        yield from say(CHECKS)
        return None
    if found.doubled:
        yield from say(_two(drive.node))
        return None
    calibrated = "" if found.version is None else _calibrated(found.version.calibrated)
    yield from say(
        f"Drive {found.node} answers: {found.board}, {found.firmware_words}, "
        f"at {found.counts} counts{calibrated}."
    )
    return found


def _calibrated(is_so: bool) -> str:
    return ", calibrated" if is_so else ", its encoder not calibrated"


def _give_id(drive: Planned) -> Talk[bool | None]:
    """Give the new drive, which answers as id 1, the id of its motor; None where nobody wants it.

    False where it did not work: the person may plug something else in, and try again.
    """
    if not (yield from answers(NODE_DEFAULT)):
        yield from say(CHECKS)
        return False
    if (yield from doubled(NODE_DEFAULT)):
        yield from say(_two(NODE_DEFAULT))
        return False
    if not (
        yield from agreed(
            f"A new drive answers as id {NODE_DEFAULT}. Make it id {drive.node}, for the "
            f"{drive.name}? Nothing turns.",
            "It keeps the id without current (8B). no leaves it as it is.",
            motor=drive.motor,
        )
    ):
        return None
    heard: tuple[Event, ...] = yield Put(NODE_DEFAULT, SetId(drive.node))
    yield Hear(SETTLE_S)
    if not (yield from answers(drive.node)):
        refused = any(isinstance(each, Failed) for each in heard)
        why = "The drive refused the id." if refused else "It does not answer by the new id."
        yield from say(f"{why} Switch its supply off and on, and try once more.")
        return False
    if (yield from answers(NODE_DEFAULT)):
        yield from say(
            f"Id {drive.node} answers now, and so does id {NODE_DEFAULT} still: a second new drive "
            f"is on the bus, and it may have been made id {drive.node} too. Unplug all but one of "
            "them, and set the CanID of the others back in their menu if it has changed."
        )
        return False
    said = any(isinstance(each, Done) for each in heard)
    yield from say(f"It is drive {drive.node} now" + ("." if said else ", though it did not say."))
    return True


def _two(node: int) -> str:
    return f"More than one drive answers as id {node}. {ONE_AT_A_TIME}"


def all_there(plan: Plan) -> Talk[tuple[Planned, ...]]:
    """Return the drives of a plan that do not answer, or not alone."""
    wrong = []
    for drive in plan.drives:
        if not (yield from answers(drive.node)) or (yield from doubled(drive.node)):
            wrong.append(drive)  # noqa: PERF401 - a talk cannot be held in a comprehension
    return tuple(wrong)
