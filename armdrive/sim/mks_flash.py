"""What a simulated MKS drive keeps without current: its settings, as shipped or as an arm needs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar, cast

from armdrive.errors import StateFileError
from armdrive.sim.saved import MEND, Json, Saved
from firmware_protocol.errors import ProtocolError
from firmware_protocol.mks import (
    Bitrate,
    Code,
    Device,
    Mode,
    ReplyMode,
    SetArrival,
    SetBitrate,
    SetCurrent,
    SetDirection,
    SetGroup,
    SetHoldingCurrent,
    SetHoming,
    SetId,
    SetMicrosteps,
    SetMode,
    SetPositionProtection,
    SetReplies,
    SetStallProtection,
    Setting,
    SettingRead,
    SilenceWatchdog,
    Version,
    as_setting,
)

S = TypeVar("S", bound=Setting)

FACTORY: tuple[Setting, ...] = (
    SetMode(Mode.PULSE_FOC),
    SetCurrent(1600),
    SetHoldingCurrent(50),
    SetMicrosteps(16),
    SetDirection(False),
    SetStallProtection(False),
    SetPositionProtection(False, 66, 14_000),
    SetHoming(active_high=False, counter_clockwise=False, speed_rpm=60, limits=False, method=0),
    SetArrival(True),
    SilenceWatchdog(0),
    SetBitrate(Bitrate.K500),
    SetId(1),
    SetReplies(ReplyMode.FULL),
)
"""As a drive is shipped; it belongs to no group. Numbers that are not in the manual are usual."""


class Flash:
    """The settings of one drive."""

    def __init__(self, changed: Iterable[Setting] = ()) -> None:
        self._settings: dict[Code, Setting] = {each.code: each for each in (*FACTORY, *changed)}

    def of(self, kind: type[S]) -> S:
        """Return a setting by its kind; a group's id may be none, and is not asked for so."""
        return cast(S, self._settings[kind.code])

    def get(self, code: Code) -> Setting | None:
        """Return a setting by its code; None for a group's id where there is none."""
        return self._settings.get(code)

    def put(self, setting: Setting) -> None:
        """Keep a setting."""
        self._settings[setting.code] = setting

    def device(self, firmware: Version, *, new_id_answers: bool) -> Device:
        """Make an end of the bus that is as it is set up."""
        group = self._settings.get(Code.GROUP)
        return Device(
            self.of(SetId).node,
            firmware,
            group=group.node if isinstance(group, SetGroup) else None,
            replies=self.of(SetReplies).mode,
            bitrate=self.of(SetBitrate).bitrate,
            new_id_answers=new_id_answers,
        )

    def to_json(self) -> dict[str, Json]:
        """Return the settings as they are on the bus, by the name of their code."""
        return {code.name.lower(): each.payload.hex() for code, each in self._settings.items()}

    @classmethod
    def from_json(cls, saved: Saved) -> Flash:
        """Know again what `to_json` wrote. Raises `StateFileError`."""
        codes = [each.code for each in FACTORY]
        codes += [Code.GROUP] if saved.has(Code.GROUP.name.lower()) else []
        found = cls(_read(code, saved.text(code.name.lower())) for code in codes)
        saved.end()
        return found


def _read(code: Code, text: str) -> Setting:
    try:
        setting = as_setting(SettingRead(code, bytes.fromhex(text)))
    except (ProtocolError, ValueError):
        setting = None
    if setting is None:
        raise StateFileError(f"a saved drive's {code.name.lower()} cannot be {text!r:.60}; {MEND}")
    return setting
