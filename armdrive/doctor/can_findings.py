"""From a survey of a CAN bus and the state of its adapter to findings, as far as evidence goes.

A wrong bit rate, a bus without nodes and an open wire look alike from one end: then all of them are
named, with what tells them apart.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from armdrive.commissioning.drives import Known
from armdrive.commissioning.languages import likely
from armdrive.doctor.can_survey import Survey
from armdrive.doctor.findings import Finding, note, ok, problem
from armdrive.transports.can_health import BusHealth, BusState
from armdrive.transports.can_timing import frame_bits
from firmware_protocol.mks import NODE_DEFAULT, Ability, Code, Mode, SilenceWatchdog

BUSY = 0.7
"""A bus that is loaded more than this makes its nodes wait."""
RESISTORS = (
    "with the supply off measure between CAN H and L: 60 ohm are right, 120 mean that one of the "
    "two resistors at the ends is missing, open circuit that both are"
)
NOBODY = (
    "see that the drives have their motor supply, that H and L are not swapped, and the bit rate "
    "(CanRate in the menu of an MKS drive): `armdrive doctor --can --every-rate` tries all four"
)
MOST_SHOWN = 3
SOME = 2
"""So many answers may be late on a computer that is busy."""


def of_listening(heard: Survey, seconds: float, bits_s: int) -> list[Finding]:
    """Say what passed while nothing was sent."""
    count = len(heard.passing)
    if not count:
        return [ok(f"nothing passed in {seconds:g} s, so nobody is disturbed by questions")]
    bits = sum(map(frame_bits, heard.passing))
    load = f", a load of {bits / seconds / bits_s:.1%}" if bits_s else ""
    what = f"{count} frames passed in {seconds:g} s{load}"
    if heard.commands:
        ear = likely(heard.commands).ear()
        shown = "; ".join(ear.hear(each).words for each in heard.commands[:MOST_SHOWN])
        return [
            problem(
                f"{what}, and another program commands drives ({shown})",
                "nothing was asked meanwhile: end that program, then ask again; `armdrive can "
                "monitor` shows what it says",
            )
        ]
    found = [ok(f"{what}; nobody commands drives")]
    if bits_s and bits / seconds / bits_s > BUSY:
        found.append(note("the bus is very busy: answers come late", "use a higher bit rate"))
    return found


def of_health(health: BusHealth, lost: str = "") -> list[Finding]:
    """Say how the adapter gets on with the bus."""
    counters = (
        f"sent {health.sent}, heard {health.heard}, refused {health.refused}, error frames "
        f"{health.error_frames}"
    )
    state = f"the adapter is {health.state.value} ({counters})"
    if health.state is BusState.OFF:
        return [
            problem(
                f"the adapter has left the bus: {state}",
                "the bit rate is another than that of the other nodes, or CAN H and L are shorted "
                "or swapped; with nobody at all on the bus an adapter stays error-passive",
            )
        ]
    if health.state is not BusState.ACTIVE:
        trouble = f": {health.last_trouble}" if health.last_trouble else ""
        return [note(f"{state}{trouble}", RESISTORS)]
    return [ok(state)] if not lost else [note(f"{state}; then {lost}", RESISTORS)]


def of_answers(found: Survey, health: BusHealth, arm: str = "NAME") -> list[Finding]:
    """Say who answered, or why perhaps nobody did."""
    if not found.drives:
        return [of_nobody(found.asked, health)]
    names = ", ".join(str(each.node) for each in found.drives)
    findings = [ok(f"of the ids {numbers(found.asked)} there answer: {names}")]
    missed = sum(each.missed for each in found.drives)
    findings += of_lost(missed, found.garbled, health)
    for each in found.drives:
        findings += of_drive(each, arm)
    return findings


def of_lost(missed: int, garbled: int, health: BusHealth) -> list[Finding]:
    """Say what was lost or broken between questions and answers, and what does that."""
    what = (
        f"{missed} answers came only after a second question, {garbled} frames could not be "
        f"read, {health.error_frames} error frames were seen"
    )
    wiring = f"a resistor that is missing, a loose plug or a long stub do that: {RESISTORS}"
    if missed > SOME or garbled or health.error_frames:
        return [problem(what, wiring)]
    return [note(what, f"a busy computer does that too; if it stays, {wiring}")] if missed else []


def of_nobody(asked: Sequence[int], health: BusHealth) -> Finding:
    """Say why perhaps nobody answered."""
    what = f"nobody answers of the ids {numbers(asked)}"
    passive = health.state in (BusState.PASSIVE, BusState.OFF)
    if health.refused or passive:
        return problem(
            f"{what}, and nobody acknowledges what is sent: no node is there that hears this bit "
            "rate",
            NOBODY,
        )
    if health.error_frames:
        return problem(f"{what}, and the bus has errors: somebody has another bit rate", NOBODY)
    return problem(
        f"{what}, though the adapter took every frame: there is a node without these ids, or none "
        "at all (the first firmwares of the CANable do not tell)",
        f"ask more ids with --ids 1-127; {NOBODY}",
    )


def of_drive(drive: Known, arm: str = "NAME") -> list[Finding]:
    """Say what one drive tells of itself, and what is wrong with it."""
    mode = drive.mode
    words = [drive.board, drive.firmware_words, f"at {drive.counts} counts"]
    words += [f"mode {int(mode.mode)}"] if mode else []
    words += ["holds" if drive.enabled else "has let its motor go"]
    words += [drive.state.name.lower().replace("_", " ")] if drive.state is not None else []
    name = f"drive {drive.node}"
    found = [ok(f"{name}: {', '.join(words)}")]
    if drive.doubled:
        found.append(
            problem(
                f"{name}: two drives have this id",
                f"plug in one at a time: `armdrive can setup {arm}`",
            )
        )
    if mode is not None and mode.mode is not Mode.BUS_FOC:
        found.append(
            problem(
                f"{name}: mode {int(mode.mode)} ({mode.mode.name}) obeys no motion of the bus",
                f"`armdrive doctor --arm {arm} --mend`, or `armdrive can setup {arm}`, sets mode 5",
            )
        )
    if drive.stalled:
        found.append(
            problem(
                f"{name}: its protection has let the shaft go",
                "see what blocks it, then call `reset()`, or its supply off and on",
            )
        )
    if drive.version is not None and not drive.version.calibrated:
        found.append(
            problem(
                f"{name}: its encoder is not calibrated", f"`armdrive can setup {arm}` does that"
            )
        )
    if Ability.SILENCE_WATCHDOG not in drive.able:
        found.append(
            note(f"{name}: no watchdog before firmware 1.0.9; ends at its last target", "")
        )
    elif drive.settings.get(Code.WATCHDOG) == SilenceWatchdog(0):
        found.append(note(f"{name}: its watchdog is off; `enable()` switches it on", ""))
    return found


def of_arm(
    ids: Sequence[int], answering: Iterable[int], arm: str, section: str = "mks"
) -> list[Finding]:
    """Compare who answers with the ids of an arm file."""
    there = set(answering)
    missing = [node for node in ids if node not in there]
    more = sorted(there - set(ids))
    found = []
    if missing:
        mend = "see its supply and plug"
        if NODE_DEFAULT in there and section == "mks":
            mend += f"; a new drive is id 1 whatever it turns: `armdrive can setup {arm}`"
        found.append(problem(f"the arm file's drives {numbers(missing)} do not answer", mend))
    if more:
        what = f"drives {numbers(more)} answer that are not in the arm file's {section}.ids"
        found.append(note(what, ""))
    return found or [ok("every drive of the arm file answers, and no other")]


def numbers(ids: Sequence[int]) -> str:
    """Write ids: a run of them as its ends."""
    numbers = sorted(ids)
    if len(numbers) > 2 and numbers == list(range(numbers[0], numbers[-1] + 1)):
        return f"{numbers[0]} to {numbers[-1]}"
    return ", ".join(map(str, numbers)) or "none"
