"""The properties of one GRBL firmware: axes, line length, receive buffer and extra words."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

from firmware_protocol.errors import whole
from firmware_protocol.grbl.words import axis_letters

LINE_CHARACTERS_MAX = 1024
RING_BYTES_MAX = 1 << 16


class Variant(StrEnum):
    """The firmware. grbl-Mega-5X identifies itself as GRBL."""

    GRBL = "Grbl"
    GRBLHAL = "GrblHAL"
    FLUIDNC = "FluidNC"


@dataclass(frozen=True, slots=True)
class Dialect:
    """A firmware as its build made it.

    `max_line` counts characters without the line end. `ring_bytes` is the receive ring as `$I`
    gives it, or None where it is unknown: then one line at a time. `outputs` admits M62 to M68.
    `crlf_answers_twice` is GRBL's habit: CR and LF each end a line, and an empty line gets its ok.
    """

    variant: Variant = Variant.GRBL
    axes: str = "XYZ"
    max_line: int = 79
    ring_bytes: int | None = 128
    outputs: bool = False
    single_axis_homing: bool = False
    crlf_answers_twice: bool = True

    def __post_init__(self) -> None:
        axis_letters(self.axes)
        whole("max_line", self.max_line, 1, LINE_CHARACTERS_MAX)
        if self.ring_bytes is not None:
            whole("ring_bytes", self.ring_bytes, 2, RING_BYTES_MAX)

    @property
    def grblhal_realtime(self) -> bool:
        """Whether the firmware supports grblHAL's additional real-time bytes."""
        return self.variant is Variant.GRBLHAL


GRBL = Dialect()
MEGA_5X = Dialect(axes="XYZABC", ring_bytes=255, outputs=True, single_axis_homing=True)
"""The build determines the number of axes (five or six) and their letters."""
GRBLHAL = Dialect(
    Variant.GRBLHAL,
    "XYZABC",
    max_line=256,
    ring_bytes=1024,
    outputs=True,
    single_axis_homing=True,
    crlf_answers_twice=False,
)
FLUIDNC = Dialect(
    Variant.FLUIDNC,
    "XYZABC",
    max_line=255,
    ring_bytes=None,
    outputs=True,
    single_axis_homing=True,
    crlf_answers_twice=False,
)
