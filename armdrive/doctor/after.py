"""From an examination to findings, and to what to do next."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

from armdrive.dialects import DIALECTS
from armdrive.doctor.findings import Finding, note, ok, problem
from armdrive.doctor.probing import Examination
from armdrive.doctor.signs import Identity, says_something_readable
from armdrive.interview.toml_text import value as toml
from armdrive.received import excerpt

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
    import shlex

    return shlex.quote(port) if os.name == "posix" else port
