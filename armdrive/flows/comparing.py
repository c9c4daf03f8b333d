"""Comparing a device's settings with the arm file's, and writing what a person has agreed to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from armdrive.controllers.requests import Done, MendSetting, ReadSettings
from armdrive.controllers.settings import Settings
from armdrive.errors import DeviceFault, SettingsDiffer
from armdrive.flow import Flow
from armdrive.flows.asking import TRIES

if TYPE_CHECKING:
    from armdrive.flows.exchange import Wire


def compare_settings(wire: Wire) -> Flow[Settings]:
    """Read the device's settings; what differs from the arm file keeps the arm from moving.

    A difference is believed when it is read twice: the line has no check bytes.
    """
    core = wire.core
    reply, seen = (yield from _ask_settings(wire)), None
    for _ in range(TRIES):
        if not reply.differences or reply == seen:
            break
        seen, reply = reply, (yield from _ask_settings(wire))
    core.differences = reply.differences
    if reply.differences:
        core.notify(str(reply), SettingsDiffer(str(reply)))
    return reply


def compare_again(wire: Wire) -> Flow[None]:
    """Read settings once more that kept the arm from moving: somebody may have mended them."""
    if any(each.must for each in wire.core.differences):
        yield from compare_settings(wire)


def _ask_settings(wire: Wire) -> Flow[Settings]:
    reply = yield from wire.request(ReadSettings())
    if not isinstance(reply, Settings):
        wire.core.fault(f"the controller did not tell its settings ({reply}): look at the wire")
        raise DeviceFault(wire.core.error)
    return reply


def mend_settings(wire: Wire, lines: tuple[str, ...]) -> Flow[Settings]:
    """Write the lines that a person has agreed to, one at a time, and compare again."""
    core = wire.core
    for line in lines:
        reply = yield from wire.request(MendSetting(line))
        if not isinstance(reply, Done):
            raise DeviceFault(f"the controller did not take `{line}`: {reply}")
    core.notice = ""
    return (yield from compare_settings(wire))
