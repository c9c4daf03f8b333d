"""Describe the messages of GRBL boards and their hosts in words, and recognise such a board."""

from __future__ import annotations

import re
from collections.abc import Mapping
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
from firmware_protocol.grbl.commands import Realtime, pieces
from kinematics.text import counted

_SYSTEM: Mapping[str, str] = MappingProxyType(
    {
        "$$": "read the settings", "$I": "ask for the version", "$G": "read the modes",
        "$#": "read the parameters", "$X": "unlock", "$H": "home by the switches",
        "$C": "check mode", "$SLP": "sleep, motors off", "$N": "read the start-up lines",
    }
)  # fmt: skip


def _report(message: StatusReport) -> str:
    state = message.state.value if isinstance(message.state, State) else message.state
    sub = "" if message.sub_state is None else f":{message.sub_state}"
    position = message.machine_position or ()
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
    found = list(pieces(data))
    rest = b"".join(piece for piece in found if isinstance(piece, bytes))
    texts = filter(None, (line.strip() for line in rest.decode("latin-1").split("\n")))
    told = [plain(piece) for piece in found if isinstance(piece, Realtime)]
    told += [_SYSTEM.get(text.upper(), text) for text in texts]
    return "; ".join(told) or ("an empty line" if rest else "")


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
    installable=_FIRMWARE,
)

TOOLS = DeviceTools(TALK, RECOGNITION)
