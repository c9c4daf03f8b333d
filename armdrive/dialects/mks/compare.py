"""How MKS drives are set up, compared with the arm file; and the lines that mend it.

A line is a drive's id, a colon, and a setting's code and value in hexadecimal: `3: 82 05`.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from armdrive.dialects.mks.settings import MksSettings
from armdrive.dialects.mks.wire import MksWire, Script, Told, meant
from armdrive.errors import Refused
from armdrive.tasks import DeviceSettings, Difference, Done, RequestRejected
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.frames import Frame
from firmware_protocol.mks import (
    CURRENT_MAX_MA,
    SETTING_CODES,
    Ability,
    Code,
    Mode,
    ReadSetting,
    ReplyMode,
    SetCurrent,
    SetMicrosteps,
    SetMode,
    SetReplies,
    Setting,
    SettingRead,
    SilenceWatchdog,
    decode_request,
    encode,
)
from firmware_protocol.mks import Done as Taken

_LINE = re.compile(r"\s*([0-9]{1,4})\s*:\s*((?:[0-9A-Fa-f]{2}\s*){2,7})")
_NOT_BY_LINE = (Code.NODE, Code.BITRATE, Code.GROUP)
"""Settings after which the drive would be somewhere else: commissioning has a command for them."""


@dataclass(frozen=True, slots=True)
class WantedSetting:
    """One setting that an arm needs, in words, and why."""

    setting: Setting
    what: str
    why: str


def wanted_settings(device: MksSettings, current_ma: int) -> tuple[WantedSetting, ...]:
    """Return what each drive of an arm has to be set to; motors have this current."""
    watchdog_ms = round(device.watchdog_s * 1000)
    return (
        WantedSetting(
            SetMode(Mode.BUS_FOC), "mode 5 (SR_vFOC)", "outside it no bus motion is obeyed"
        ),
        WantedSetting(SetReplies(ReplyMode.FULL), "replies on", "the driver hears what is done"),
        WantedSetting(
            SetMicrosteps(device.microsteps),
            f"{device.microsteps} microsteps",
            "with 16, 32 or 64 the drive's speeds are rpm",
        ),
        WantedSetting(SetCurrent(current_ma), f"{current_ma} mA", "the motor's own rating"),
        WantedSetting(
            SilenceWatchdog(watchdog_ms),
            f"watchdog {watchdog_ms} ms",
            "the motor stops when the computer has died or the cable is pulled",
        ),
    )


_COMPARED = (Code.MODE, Code.MICROSTEPS, Code.REPLIES, Code.CURRENT)
"""What a connected arm is compared in; its watchdog is switched on with the motors."""
_MUST = (Code.MODE, Code.MICROSTEPS)
"""Nothing moves without these, or not as it should."""


class MksComparing:
    """Reads settings, compares and mends them."""

    def __init__(self, wire: MksWire) -> None:
        self._wire = wire

    def compare(self, firmware: str) -> Script:
        """Read what the arm depends on; what a firmware cannot tell is left to the first motion."""
        wire = self._wire
        if not wire.can(Ability.READ_SETTINGS):
            return DeviceSettings((), firmware)
        began_s = wire.now_s
        differences: list[Difference] = []
        current_ma = wire.settings.current_ma
        wanted = {
            each.setting.code: each.setting
            for each in wanted_settings(wire.settings, current_ma or CURRENT_MAX_MA)
        }
        for code in _COMPARED if current_ma else _COMPARED[:-1]:
            found = yield from wire.read(ReadSetting(code))
            if missing := [node for node in wire.nodes if node not in found]:
                return wire.absence(missing, began_s)
            differences += self._differing(found, wanted[code])
        return DeviceSettings(tuple(differences), firmware)

    def _differing(self, found: Mapping[int, Told], wanted: Setting) -> list[Difference]:
        differences = []
        for node in self._wire.nodes:
            read = found[node]
            if not isinstance(read, SettingRead) or read.value is None:
                continue  # it is not told
            is_set = meant(read)
            if is_set != wanted:
                differences.append(
                    Difference(
                        f"{wanted.code.name.lower()} of {self._wire.drive(node)}",
                        value_words(is_set) or read.value.hex(" "),
                        value_words(wanted),
                        mending_line(node, wanted),
                        wanted.code in _MUST,
                    )
                )
        return differences

    def mend(self, line: str) -> Script:
        """Write one setting."""
        node, setting = parsed_line(line)
        if node not in self._wire.nodes:
            raise Refused(f"`{line}`: no drive of this arm has the id {node}")
        found = yield from self._wire.ask({node: setting}, text=line)
        heard = found.get(node)
        if heard is None:
            return RequestRejected(self._wire.absent_words((node,)), moved=False)
        if not isinstance(heard, Taken):
            return RequestRejected(f"{self._wire.drive(node)} refused `{line}`", moved=False)
        return Done()


def mending_line(node: int, setting: Setting) -> str:
    """Return the line that sets something."""
    return f"{node}: {encode(node, setting).data[:-1].hex(' ')}"


def parsed_line(line: str) -> tuple[int, Setting]:
    """Read a mending line. Raises `Refused` for one that sets nothing of a drive."""
    found = _LINE.fullmatch(line)
    if found is None:
        raise Refused(f"`{line}` is no setting of a drive: write one as `3: 82 05`")
    node, data = int(found[1]), bytes.fromhex(found[2])
    code = data[0]
    if code not in SETTING_CODES or code in _NOT_BY_LINE:
        raise Refused(f"`{line}` sets nothing that can be mended so")
    try:
        frame_data = data + bytes(((node + sum(data)) & 0xFF,))
        setting = decode_request(Frame(node, frame_data))
    except (RemoteProtocolError, ValueError) as error:
        raise Refused(f"`{line}` is no setting of a drive: {error}") from None
    return node, setting  # type: ignore[return-value]


def value_words(setting: Setting | None) -> str:
    """Return a setting's value for people."""
    match setting:
        case SetMode(mode):
            return f"{int(mode)} ({mode.name})"
        case SetMicrosteps(count):
            return str(count)
        case SetReplies(mode):
            return mode.name.lower()
        case SetCurrent(current_ma):
            return f"{current_ma} mA"
        case SilenceWatchdog(timeout_ms):
            return f"{timeout_ms} ms" if timeout_ms else "off"
    return ""
