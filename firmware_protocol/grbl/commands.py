"""Everything a host can send as a line, and which of it writes EEPROM."""

from __future__ import annotations

import re
from typing import TypeAlias

from firmware_protocol.grbl.moves import (
    AnalogOutput,
    Coolant,
    DigitalOutput,
    Dwell,
    Jog,
    Line,
    Modes,
    Move,
    SpindleOff,
    SpindleOn,
)
from firmware_protocol.grbl.system import (
    CheckMode,
    Help,
    Home,
    QueryBuildInfo,
    QueryParameters,
    QueryParserState,
    QuerySettings,
    QueryStartupLines,
    Restore,
    SetSetting,
    Sleep,
    StoreBuildInfo,
    StoreStartupLine,
    Unlock,
)

SystemCommand: TypeAlias = (
    Help
    | QuerySettings
    | QueryBuildInfo
    | QueryParameters
    | QueryParserState
    | QueryStartupLines
    | Unlock
    | CheckMode
    | Sleep
    | Home
    | SetSetting
    | StoreStartupLine
    | StoreBuildInfo
    | Restore
)
"""The lines that begin with `$`, but for jogs."""

GcodeCommand: TypeAlias = (
    Move | Modes | SpindleOn | SpindleOff | Coolant | DigitalOutput | AnalogOutput | Dwell
)

Command: TypeAlias = GcodeCommand | Jog | SystemCommand | Line

_WRITES_EEPROM = re.compile(
    r"\$[0-9.]+=|\$N[0-9]+=|\$I=|\$RST=|[^$]*G0*(?:10(?:\.0*)?(?![0-9.])|(?:28|30)\.10*(?![0-9]))"
)


def writes_eeprom(text: str) -> bool:
    """Tell whether a line makes GRBL write EEPROM.

    While it does, received bytes are lost: nothing else may be under way then.
    """
    return _WRITES_EEPROM.match(re.sub(r"[ /]|\([^)]*\)", "", text.upper())) is not None
