"""The serial ports and CAN adapters here, who has them, and whose arm files name them."""

from __future__ import annotations

import argparse
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from armdrive.cli.presenter import emit, say
from armdrive.errors import NoSuchPort
from armdrive.setup.ports import (
    PortNaming,
    arm_files,
    forbidden,
    held_by_armdrive,
    owners_of,
    same_port,
    strangers_to,
)
from armdrive.transports.address import is_can
from armdrive.transports.can_address import CanAddress
from armdrive.transports.ports import PortInfo, ask_drivers, list_can_ports, list_ports


def run(options: argparse.Namespace) -> int:
    """List the ports."""
    files = tuple(map(_by_device, arm_files()))
    ports = list_ports()
    views = [_view(info, files) for info in ports]
    absent = _absent(ports, files)
    adapters = [*list_can_ports(ports), *(ask_drivers() if options.can else ())]
    buses = [asdict(each) for each in {each.port: each for each in reversed(adapters)}.values()]
    unusable = [{"arm": each.arm, "error": each.error} for each in files if each.error]
    if options.json:
        told = {"ports": views, "can": buses, "absent": absent, "unusable_arm_files": unusable}
        emit(told)
        return 0
    for view in views:
        _show(view)
    for bus in buses:
        say(f"{bus['port']}  {bus['description']}")
        if bus["todo"]:
            say(f"    {bus['todo']}")
    if not views:
        say("no serial port is there: plug the adapter in, or look at its driver")
    for each in absent:
        say(f"the arm file {each['arm']}: {each['why']}")
    for each in unusable:
        say(f"the arm file {each['arm']} cannot be used: {each['error']}")
    if views:
        say("`armdrive doctor PORT` finds out what a port leads to, without moving anything")
    return 0


def _by_device(naming: PortNaming) -> PortNaming:
    """Return an arm file's naming with the serial port of its CAN adapter, where that is one."""
    address = CanAddress.parse(naming.port) if is_can(naming.port) else CanAddress()
    return replace(naming, port=address.device) if address.device else naming


def _view(info: PortInfo, files: tuple[PortNaming, ...]) -> dict[str, Any]:
    owners = owners_of(info.device, files)
    arms = [each.arm for each in owners]
    holder = None
    if info.holder is not None:
        arm = held_by_armdrive(info.device, arms)
        holder = {"pid": info.holder.pid, "program": info.holder.program, "arm": arm or None}
    return {
        "port": info.device,
        "description": info.description,
        "usb": None if info.vid is None or info.pid is None else f"{info.vid:04x}:{info.pid:04x}",
        "manufacturer": info.manufacturer,
        "serial_number": info.serial_number,
        "stable_name": info.stable_name,
        "arm_files": arms,
        "belongs_to": [str(each) for each in owners],
        "named_for_another_adapter": [each.arm for each in strangers_to(info.device, files)],
        "holder": holder,
        "allowed": info.readable,
        "mend": "" if info.readable else forbidden(info.device).mend,
    }


def _absent(ports: tuple[PortInfo, ...], files: tuple[PortNaming, ...]) -> list[dict[str, str]]:
    """Return the arm files whose port is not to be found, and why."""
    found = [(each, _missing(each, ports)) for each in files]
    return [
        {"arm": each.arm, "port": each.port, "usb_serial": each.usb_serial, "why": why}
        for each, why in found
        if why
    ]


def _missing(naming: PortNaming, ports: tuple[PortInfo, ...]) -> str:
    """Say why the port of an arm file is not to be found; nothing where it is."""
    try:
        port = naming.find()
    except NoSuchPort as error:
        return str(error)
    there = (
        not port
        or "://" in port
        or is_can(port)
        or Path(port).exists()
        or any(same_port(port, info.device) for info in ports)
    )
    return "" if there else f"it names {port}, which is not there: check the cable and the name"


def _show(view: dict[str, Any]) -> None:
    what = ", ".join(
        word
        for word in (
            view["description"],
            view["manufacturer"],
            view["usb"],
            view["serial_number"] and f"serial number {view['serial_number']}",
        )
        if word
    )
    say(f"{view['port']}  {what}".rstrip())
    if view["stable_name"]:
        say(f"    the name that stays: {view['stable_name']}")
    for owner in view["belongs_to"]:
        say(f"    belongs to the arm file {owner}")
    for arm in view["named_for_another_adapter"]:
        say(f"    not the adapter of the arm file {arm}, which names this port")
    if view["holder"]:
        drives = f", which drives {view['holder']['arm']}" if view["holder"]["arm"] else ""
        say(f"    held by {view['holder']['program']} (pid {view['holder']['pid']}){drives}")
    if not view["allowed"]:
        say(f"    you may not open it: {view['mend']}")
