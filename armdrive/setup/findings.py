"""From an examination to findings, and to what to do next."""

from __future__ import annotations

import os
import shlex
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from armdrive.dialects.bus.tools import RESISTORS, Listened, numbers
from armdrive.dialects.recognition import Identity, says_something_readable
from armdrive.dialog.conversation import Finding, note, ok, problem
from armdrive.registry import DIALECTS, likely
from armdrive.runtime.engine import excerpt
from armdrive.setup.prober import Examination
from armdrive.status import Lateness, SchedulingJitter
from armdrive.tasks import DeviceSettings, Difference
from armdrive.text.toml import value as toml
from armdrive.transports.can_health import BusHealth, BusState, frame_bits

CHECK_WIRING = (
    "check that the arm is switched on, that the cable carries data, and that transmit and "
    "receive are not swapped"
)
NEVER_RESET = "in the arm file, under [connection]: raise_dtr = true and keep_dtr_on_close = true"


@dataclass(frozen=True, slots=True)
class Expected:
    """What an arm file or the command line says of the port; None and empty where nothing."""

    dialect: str = ""
    baud: int | None = None
    spared_reset: bool = False


def findings(found: Examination, expected: Expected) -> list[Finding]:
    """Say what an examination has found."""
    if found.identity is None:
        return [*_unrecognised(found, expected)]
    listed = [_identified(found.identity, found.baud)]
    listed += _differing(found, expected)
    if found.echoes:
        listed.append(
            problem(
                "what is sent comes back as well",
                "armdrive needs a line without an echo: switch it off in the adapter or on the "
                "board, and check that transmit and receive are not joined",
            )
        )
    if found.restarted:
        listed.append(_restarted(found, expected))
    return listed


def _identified(identity: Identity, baud: int | None) -> Finding:
    if not identity.dialect:
        return problem(
            f"{identity.firmware} answers, which armdrive does not speak with", identity.remedy
        )
    at = f" at {baud} baud" if baud else ""
    return ok(f"it speaks {identity.dialect}: {identity.firmware}{at}")


def _differing(found: Examination, expected: Expected) -> list[Finding]:
    identity = found.identity
    if identity is None or not identity.dialect or expected.dialect in ("", identity.dialect):
        return []
    return [
        problem(
            f"{expected.dialect} was expected, and {identity.dialect} answers",
            f'say dialect = "{identity.dialect}" in the arm file (--dialect {identity.dialect}), '
            "or connect the other arm",
        )
    ]


def _restarted(found: Examination, expected: Expected) -> Finding:
    if found.baud is None:
        return note(
            "it greeted when the connection was opened: a board behind a serial server has "
            "restarted then, and its arm may have sagged"
        )
    what = (
        "the board restarted when its port was opened: motors lose their current, and an arm sags"
    )
    if expected.spared_reset:
        return note(f"{what}; the first opening after plugging in always does that")
    return note(what, NEVER_RESET)


def _unrecognised(found: Examination, expected: Expected) -> list[Finding]:
    heard = found.everything
    tried = sorted({each.baud for each in found.heard})
    at = "" if len(tried) < 2 else f" at {' and '.join(map(str, tried))} baud"
    if found.echoes:
        return [
            problem(
                "what is sent comes straight back: no arm answers like that",
                "transmit and receive are joined somewhere, or a terminal echoes: check the wiring",
            )
        ]
    if not heard:
        if expected.baud is None:
            return [problem(f"nobody answers{at}", f"{CHECK_WIRING}; try another rate with --baud")]
        return [problem(f"nobody answers at {expected.baud} baud", f"{CHECK_WIRING}, and the rate")]
    if says_something_readable(heard):
        return [
            problem(
                f"somebody speaks, but no dialect that is known here: {excerpt(heard)}",
                "if that is half a line, look at the cable; else the firmware is no arm's",
            )
        ]
    return [
        problem(
            f"bytes come that nobody can read{at}: {excerpt(heard)}",
            "another baud rate (--baud N) or a bad contact, a missing ground say",
        )
    ]


def next_steps(
    port: str,
    found: Examination,
    *,
    arm: str = "",
    owners: Sequence[str] = (),
    compared: bool = False,
) -> list[str]:
    """Return the lines to type next; none where no arm was found.

    `arm` is the arm file's that was looked at, `owners` are those that the port belongs to, and
    `compared` says that settings have been looked at already.
    """
    identity = found.identity
    if identity is None or identity.dialect not in DIALECTS:
        return []
    if arm:
        return [f"armdrive status --arm {arm}"]
    if owners and not compared:
        return [f"armdrive doctor --arm {each}" for each in owners]
    row = DIALECTS[identity.dialect]
    baud = "" if found.baud in (None, row.baud) else f" --baud {found.baud}"
    status = f"armdrive status --port {quoted(port)} --dialect {row.name}{baud}"
    settings = f"armdrive doctor {quoted(port)} --dialect {row.name}{baud}"
    return [status] if compared else [settings, status]


def arm_file_lines(port: str, found: Examination, usb_serial: str = "") -> list[str]:
    """Return an arm file's lines for what was found; none where no arm was found.

    The adapter's number, where it has one, finds the arm under any name of its port.
    """
    identity = found.identity
    if identity is None or identity.dialect not in DIALECTS:
        return []
    row = DIALECTS[identity.dialect]
    lines = [f'model = "{row.preset}"', "", "[connection]"]
    lines += [f'dialect = "{row.name}"', f"port = {toml(port)}"]
    if usb_serial:
        lines.append(f"usb_serial = {toml(usb_serial)}")
    if found.baud not in (None, row.baud):
        lines.append(f"baud = {found.baud}")
    if found.restarted and found.baud is not None:
        lines += ["raise_dtr = true", "keep_dtr_on_close = true"]
    return lines


def quoted(port: str) -> str:
    """Return a port's name as a shell takes it."""
    return shlex.quote(port) if os.name == "posix" else port


# From a survey of a CAN bus and the state of its adapter to findings, as far as evidence goes.

BUSY = 0.7
"""A bus that is loaded more than this makes its nodes wait."""
MOST_SHOWN = 3


def of_listening(heard: Listened, seconds: float, bits_s: int) -> list[Finding]:
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


def of_arm(
    ids: Sequence[int], answering: Iterable[int], arm: str, section: str = "mks"
) -> list[Finding]:
    """Compare who answers with the ids of an arm file."""
    there = set(answering)
    bus = DIALECTS[section].bus
    commissioning = bus.commissioning if bus is not None else None
    missing = [node for node in ids if node not in there]
    more = sorted(there - set(ids))
    found = []
    if missing:
        mend = "see its supply and plug"
        if commissioning is not None and commissioning.new_id in there:
            mend += (
                f"; a new drive is id {commissioning.new_id} whatever it turns: "
                f"`armdrive can setup {arm}`"
            )
        found.append(problem(f"the arm file's drives {numbers(missing)} do not answer", mend))
    if more:
        what = f"drives {numbers(more)} answer that are not in the arm file's {section}.ids"
        found.append(note(what, ""))
    return found or [ok("every drive of the arm file answers, and no other")]


# The settings of a device that is known, compared with what its arm file expects.


def settings_findings(settings: DeviceSettings) -> list[Finding]:
    """Say which settings differ; those that keep the arm from moving are problems."""
    listed = [_finding(each) for each in settings.differences]
    told = f" ({settings.firmware})" if settings.firmware else ""
    return listed or [ok(f"the controller's settings{told} are what the arm file expects")]


def _finding(difference: Difference) -> Finding:
    what = f"{difference.setting} is {difference.found}, expected {difference.expected}"
    return (problem if difference.must else note)(what, difference.mend)


# How punctually this computer wakes a thread: measured, while nothing is opened or moved.

PERIOD_S = 0.01
DEADLINES = 60

LATE_S = 5e-3
"""Later than this now and then is worth a word: a burst is some 100 ms long."""


def measure(deadlines: int = DEADLINES, period_s: float = PERIOD_S) -> SchedulingJitter:
    """Return how late a thread woke for so many deadlines that were set beforehand."""
    lateness = Lateness()
    due_s = time.perf_counter()
    for _ in range(deadlines):
        due_s += period_s
        time.sleep(max(due_s - time.perf_counter(), 0.0))
        lateness.add(time.perf_counter() - due_s)
    return lateness.view()


def finding(scheduling_jitter: SchedulingJitter) -> Finding:
    """Say whether it is punctual enough to drive an arm smoothly."""
    what = f"this computer's punctuality: {scheduling_jitter}"
    if scheduling_jitter.p99_s <= LATE_S:
        return ok(what)
    return note(
        what,
        "other programs keep it busy: bursts then come late and motion stutters, though nothing "
        "runs away. Close some, or set a longer motion.planned_burst_s",
    )
