"""How long a call may take that moves nothing: one rule for connecting, resets, looks and the rest.

The engine keeps it (engine.py), whatever comes over the wire, so that no controller has to.
"""

from __future__ import annotations

from dataclasses import fields

CALL_LIMIT_S = 20.0
"""Connecting, a reset, a look and whatever else moves nothing ends within this.

Twice the slowest first contact: a GRBL board may take 4 s to start, and is then reset three times,
2 s each. So one attempt may be lost to noise.
"""

DEVICE_WAITS = ("answer_margin_s", "answer_s", "boot_s", "mute_s")
"""The settings of a dialect that say how long its device is waited for."""


def call_limit_s(device: object) -> float:
    """Return the limit for an arm, by the section of its file that is named after its dialect.

    Who has a slow device waited for three times as long as usual gets three times the limit: a
    deadline that no device of theirs could keep would leave the arm without any use.
    """
    longer = 1.0
    for each in fields(device) if hasattr(device, "__dataclass_fields__") else ():  # type: ignore[arg-type]
        if each.name in DEVICE_WAITS and isinstance(each.default, float) and each.default > 0.0:
            longer = max(longer, getattr(device, each.name) / each.default)
    return CALL_LIMIT_S * longer
