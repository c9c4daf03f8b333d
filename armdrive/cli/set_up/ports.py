"""Lists the serial ports and CAN adapters, the programs that use them, and their arm files."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

from armdrive.cli.presenter import Result
from armdrive.setup.ports import (
    ClosedPort,
    PortNaming,
    arm_files,
    look_at,
)
from armdrive.transports.ports import list_can_ports, list_ports


def ports(options: argparse.Namespace) -> Result:  # noqa: ARG001
    """List the ports."""
    files = arm_files()
    found = list_ports()
    closed = tuple(look_at(info.device, files, found) for info in found)
    view = {
        "ports": [_view(each) for each in closed],
        "can": [asdict(each) for each in list_can_ports(found)],
        "absent": _absent(files),
        "unusable_arm_files": [
            {"arm": each.arm, "error": each.error} for each in files if each.error
        ],
    }
    return Result(view, _lines(closed, view))


def _lines(found: tuple[ClosedPort, ...], view: Mapping[str, Any]) -> Iterator[str]:
    for each in found:
        stable = f" ({each.info.stable_name})" if each.info.stable_name else ""
        yield f"{each.port}{stable}"
        yield from (f"    {line}" for line in each.lines)
    for bus in view["can"]:
        yield f"{bus['port']}  {bus['description']}"
        if bus["todo"]:
            yield f"    {bus['todo']}"
    if not found:
        yield "there is no serial port: plug the adapter in, or check its driver"
    for each in view["absent"]:
        yield f"the arm file {each['arm']}: {each['why']}"
    for each in view["unusable_arm_files"]:
        yield f"the arm file {each['arm']} cannot be used: {each['error']}"
    if found:
        yield "`armdrive doctor PORT` finds out what a port leads to, without moving anything"


def _view(port: ClosedPort) -> dict[str, Any]:
    info, holder = port.info, None
    if info.holder is not None:
        holder = {**asdict(info.holder), "arm": port.driven or None}
    return {
        "port": port.port,
        "description": info.description,
        "usb": info.usb_id or None,
        "manufacturer": info.manufacturer,
        "serial_number": info.serial_number,
        "stable_name": info.stable_name,
        "arm_files": list(port.arms),
        "belongs_to": [str(each) for each in port.owners],
        "holder": holder,
        "allowed": info.readable,
        "fix": "" if info.readable else port.findings[-1].fix,
    }


def _absent(files: tuple[PortNaming, ...]) -> list[dict[str, str]]:
    """Return the arm files whose port is missing, and why."""
    found = [(each, each.missing()) for each in files]
    return [
        {"arm": each.arm, "port": each.port, "usb_serial": each.usb_serial, "why": why}
        for each, why in found
        if why
    ]
