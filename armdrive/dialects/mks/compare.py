"""Compare the settings of MKS drives with the arm file, and correct them line by line.

A line is a drive's id, a colon, and a setting's code and value in hexadecimal: `3: 82 05`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from armdrive.dialects.bus.drives import absent_words
from armdrive.dialects.mks.drive import MksDrive, setting_of
from armdrive.dialects.mks.exchange import MksExchange, Script, is_done
from armdrive.dialects.mks.settings import MksSettings
from armdrive.errors import Refused
from armdrive.tasks import DeviceSettings, Difference, Done, RequestRejected
from firmware_protocol.errors import RemoteProtocolError
from firmware_protocol.fields import in_words
from firmware_protocol.frames import Frame
from firmware_protocol.mks import (
    SETTING_CODES,
    Ability,
    Answer,
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
from kinematics.text import counted

_LINE = re.compile(r"\s*([0-9]{1,4})\s*:\s*((?:[0-9A-Fa-f]{2}\s*){2,7})")
# Settings that would change the drive's address: commissioning has a command for them.
_NOT_BY_LINE = (Code.NODE, Code.BITRATE)


@dataclass(frozen=True, slots=True)
class WantedSetting:
    """One setting that an arm needs, in words, and the reason.

    Without one that it `must` have, the arm moves wrongly or not at all.
    """

    setting: Setting
    what: str
    why: str
    must: bool = False


def wanted_settings(device: MksSettings, current_ma: int) -> list[WantedSetting]:
    """Return the settings that each drive of an arm needs, with this motor current (0: any)."""
    mode, watchdog_ms = Mode.BUS_FOC, round(device.watchdog_s * 1000)
    wanted = [
        WantedSetting(
            SetMode(mode),
            f"mode {mode.title}",
            "in other modes it ignores motion commands",
            must=True,
        ),
        WantedSetting(
            SetReplies(ReplyMode.FULL), "replies on", "the program learns what each drive does"
        ),
        WantedSetting(
            SetMicrosteps(device.microsteps),
            counted(device.microsteps, "microstep"),
            "with 16, 32 or 64 the drive's speeds are in rpm",
            must=True,
        ),
        WantedSetting(
            SilenceWatchdog(watchdog_ms),
            f"watchdog {watchdog_ms} ms",
            "the motor stops when the computer has died or the cable is pulled",
        ),
    ]
    if current_ma:
        rated = WantedSetting(SetCurrent(current_ma), f"{current_ma} mA", "the motor's own rating")
        wanted.insert(-1, rated)
    return wanted


def compare(io: MksExchange) -> Script:
    """Compare the settings that the arm depends on, as far as the firmware reports them.

    The watchdog is not compared: it is switched on with the motors.
    """
    if not io.can(Ability.READ_SETTINGS):
        return DeviceSettings((), io.firmware)
    began_s = io.now_s
    differences: list[Difference | None] = []
    for wanted in wanted_settings(io.settings, io.settings.current_ma):
        if isinstance(wanted.setting, SilenceWatchdog):
            continue
        found = yield from io.read(ReadSetting(wanted.setting.code))
        if missing := [drive for drive in io.drives if drive not in found]:
            return io.absence(missing, began_s)
        differences += (_difference(each, found[each], wanted) for each in io.drives)
    return DeviceSettings(tuple(filter(None, differences)), io.firmware)


def _difference(drive: MksDrive, answer: Answer, wanted: WantedSetting) -> Difference | None:
    """Return how a drive's setting differs; None if it agrees or the drive does not report it."""
    if not isinstance(answer, SettingRead) or answer.value is None:
        return None
    is_set, setting = setting_of(answer), wanted.setting
    if is_set == setting:
        return None
    return Difference(
        f"{in_words(setting.code)} of {drive}",
        value_words(is_set) or answer.value.hex(" "),
        value_words(setting),
        fix_line(drive.node, setting),
        wanted.must,
    )


def fix(io: MksExchange, line: str) -> Script:
    """Write one setting."""
    node, setting = parsed_line(line)
    drive = io.find(node)
    if drive is None:
        raise Refused(f"`{line}`: no drive of this arm has the id {node}")
    reply = (yield from io.ask({drive: setting}, text=line)).get(drive)
    if reply is None:
        return RequestRejected(absent_words((drive,), "id"), moved=False)
    if not is_done(reply):
        return RequestRejected(f"{drive} refused `{line}`", moved=False)
    return Done()


def fix_line(node: int, setting: Setting) -> str:
    """Return the line that writes a setting."""
    return f"{node}: {encode(node, setting).data[:-1].hex(' ')}"


def parsed_line(line: str) -> tuple[int, Setting]:
    """Parse such a line. Raises `Refused` if it writes no setting of a drive."""
    found = _LINE.fullmatch(line)
    if found is None:
        raise Refused(f"`{line}` is not a drive setting: write one like `3: 82 05`")
    node, data = int(found[1]), bytes.fromhex(found[2])
    code = data[0]
    if code not in SETTING_CODES or code in _NOT_BY_LINE:
        raise Refused(f"`{line}` writes nothing that may be changed this way")
    try:
        frame_data = data + bytes(((node + sum(data)) & 0xFF,))
        setting = decode_request(Frame(node, frame_data))
    except (RemoteProtocolError, ValueError) as error:
        raise Refused(f"`{line}` is not a drive setting: {error}") from None
    return node, setting  # type: ignore[return-value]


def value_words(setting: Setting | None) -> str:
    """Return a setting's value as text."""
    match setting:
        case SetMode(mode):
            return mode.title
        case SetMicrosteps(count):
            return str(count)
        case SetReplies(mode):
            return in_words(mode)
        case SetCurrent(current_ma):
            return f"{current_ma} mA"
        case SilenceWatchdog(timeout_ms):
            return f"{timeout_ms} ms" if timeout_ms else "off"
    return ""
