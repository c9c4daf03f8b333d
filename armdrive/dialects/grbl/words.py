"""Describe the messages of GRBL boards and their hosts in words, and recognise such a board."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType

from armdrive.dialects import DeviceTools
from armdrive.dialects.recognition import Certainty, Identity, Probe, Recognition, decoded
from armdrive.dialects.words import AnswerLines, Describer, Message, Sentences, Weight, plain
from firmware_protocol.grbl.answers import (
    Alarm,
    Banner,
    Error,
    Feedback,
    Ok,
    Remark,
    Setting,
    State,
    StatusReport,
    Version,
    decode_answer,
)
from firmware_protocol.grbl.codes import alarm_code, error_code
from firmware_protocol.grbl.commands import Realtime, split_realtime
from kinematics.text import counted

_WORD = re.compile(r"([A-Za-z])([-+]?[0-9.]+)")

# G-code words and their meanings. Words that only repeat the usual modes have none.
_CODES: Mapping[str, str] = MappingProxyType(
    {
        "G0": "rapid", "G1": "straight", "G4": "wait", "G17": "", "G20": "inches", "G21": "",
        "G53": "in machine coordinates", "G54": "", "G90": "absolute", "G91": "relative", "G94": "",
        "M3": "output on", "M4": "output on", "M5": "output off", "M8": "coolant on",
        "M9": "coolant off",
        "M62": "output on after the motion", "M63": "output off after the motion",
        "M64": "output on", "M65": "output off",
    }
)  # fmt: skip

# G-code letters that are not axes.
_ARGUMENTS: Mapping[str, str] = MappingProxyType({"F": "feed", "S": "power", "P": "number"})

_SYSTEM: Mapping[str, str] = MappingProxyType(
    {
        "$$": "read the settings", "$I": "ask for the version", "$G": "read the modes",
        "$#": "read the parameters", "$X": "unlock", "$H": "home by the switches",
        "$C": "check mode", "$SLP": "sleep, motors off", "$N": "read the start-up lines",
    }
)  # fmt: skip
_JOG = "$J="


def _report(message: StatusReport) -> str:
    state = message.state.value if isinstance(message.state, State) else message.state
    sub = "" if message.sub_state is None else f":{message.sub_state}"
    position = message.machine_position or message.work_position or ()
    at = f" at {' '.join(f'{each:g}' for each in position)}" if position else ""
    feed = f", feed {message.feed:g}" if message.feed else ""
    room = (
        "" if message.free_blocks is None else f", room for {counted(message.free_blocks, 'block')}"
    )
    pins = f", pins {message.pins}" if message.pins else ""
    return f"{state}{sub}{at}{feed}{room}{pins}"


def _banner(message: Banner) -> str:
    return f"the board has started: {message.variant.value} {message.version}"


SENTENCES: Sentences = MappingProxyType(
    {
        StatusReport: _report,
        Ok: lambda _: "taken",
        Error: lambda message: f"refused ({message.code}): {error_code(message.code).meaning}",
        Alarm: lambda message: f"alarm {message.code}: {alarm_code(message.code).meaning}",
        Banner: _banner,
        Setting: lambda message: f"setting {message.key} is {message.value}",
        Feedback: lambda message: f"says: {message.text}",
        Remark: lambda message: f"says: {message.text}",
        Version: lambda message: f"version {message.version}",
    }
)


def lines(data: bytes) -> str:
    """Describe the bytes that a host writes: real-time characters first, then each line."""
    urgent, rest = split_realtime(data)
    told = "; ".join((*map(plain, urgent), *_lines(rest.decode("latin-1"))))
    return told or ("an empty line" if rest else "")


def _lines(text: str) -> Iterator[str]:
    for line in text.split("\n"):
        bare = line.strip()
        if bare:
            yield _SYSTEM.get(bare.upper()) or _block(bare)


def _block(line: str) -> str:
    jog = line.upper().startswith(_JOG)
    if line.startswith("$") and not jog:
        return f"set {line}"
    found = _WORD.findall(line[len(_JOG) :] if jog else line)
    if not found:
        return "no G-code"
    codes = [_code(letter.upper() + number) for letter, number in found if letter.upper() in "GM"]
    axes = [f"{_name(letter)} {number}" for letter, number in found if letter.upper() not in "GM"]
    meanings = [each for each in codes if each]
    return (
        ": ".join(part for part in (" ".join(["jog"] * jog + meanings), ", ".join(axes)) if part)
        or "set the modes"
    )


def _name(letter: str) -> str:
    return _ARGUMENTS.get(letter.upper(), letter.upper())


def _code(word: str) -> str:
    """Return the meaning of a code; `G01` is the same as `G1`."""
    letter, number = word[0], word[1:].lstrip("0") or "0"
    return _CODES.get(letter + number, word)


def _classify(line: bytes) -> Message:
    if line.startswith(b"<"):
        return Message(line, Weight.PASSING)
    if line.lower().startswith(b"grbl"):
        return Message(line, Weight.BANNER)
    own = line.startswith((b"[", b"$", b">"))
    return Message(line, Weight.SELF if own else Weight.ANSWER)


TALK = Describer(lambda: AnswerLines(b"\r\n", _classify), decode_answer, lines, sentences=SENTENCES)


# Recognise a GRBL board by its banner, a report, an alarm or a refusal.

_OLD = re.compile(r"grbl 0\.", re.IGNORECASE)
_FIRMWARE = "GRBL 1.1, grbl-Mega-5X, grblHAL or FluidNC"
# The start of a banner, which is enough even if its end is lost.
_BEGUN_BANNER = re.compile(rb"(?:^|[\r\n])(grbl(?:hal)? [0-9][!-~]*)", re.IGNORECASE)
_REFUSAL = re.compile(rb"(?:^|[\r\n])error:[0-9]{1,3}\r?\n")


def _sign(received: bytes) -> Identity | None:
    firmware, greeted, seen = "", False, _REFUSAL.search(received) is not None
    for answer in decoded(received, b"\r\n", decode_answer):
        seen |= isinstance(answer, StatusReport | Alarm)
        if isinstance(answer, Banner):
            firmware = f"{answer.variant} {answer.version}"
            if answer.firmware:
                firmware = f"FluidNC {answer.firmware}"
            greeted = True
        elif isinstance(answer, Version) and answer.version:
            firmware = f"{firmware or 'GRBL'} ({answer.version})"
    begun = _BEGUN_BANNER.search(received)
    if not firmware and begun:
        firmware, greeted = begun[1].decode("ascii"), True
    if _OLD.match(firmware):
        return Identity(
            "",
            f"{firmware}, whose reports have an older form",
            greeted,
            f"put {_FIRMWARE} on the board",
        )
    found = Identity("grbl", firmware or "a firmware of the GRBL family", greeted)
    return found if seen or firmware else None


RECOGNITION = Recognition(
    _sign,
    Certainty.WORDED,
    (Probe("?", bytes((Realtime.STATUS,)), 0.5, times=2),),
    # only for a board that has just greeted: on any other, the line end could complete a line
    # that another program left half sent
    details=Probe("$I", b"$I\n", 0.5),
    installable=_FIRMWARE,
)

TOOLS = DeviceTools(TALK, RECOGNITION)
