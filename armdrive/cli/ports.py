"""The serial ports of this computer, who has them, and which arm files name them.

Nothing is opened to find that out: `armdrive doctor PORT` does that, and asks first.
"""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from armdrive.cli.choosing import add_json_option
from armdrive.cli.output import emit, say

if TYPE_CHECKING:
    from armdrive.doctor.owners import Naming
    from armdrive.transports.ports import PortInfo


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_json_option(parser)


def run(options: argparse.Namespace) -> int:
    """List the ports."""
    from armdrive.doctor.owners import arm_files
    from armdrive.transports.ports import list_ports

    files = arm_files()
    ports = list_ports()
    views = [_view(info, files) for info in ports]
    absent = _absent(ports, files)
    unusable = [{"arm": each.arm, "error": each.error} for each in files if each.error]
    if options.json:
        emit({"ports": views, "absent": absent, "unusable_arm_files": unusable})
        return 0
    for view in views:
        _show(view)
    if not views:
        say("no serial port is there: plug the adapter in, or look at its driver")
    for each in absent:
        say(f"the arm file {each['arm']} names {each['port']}, which is not there")
    for each in unusable:
        say(f"the arm file {each['arm']} cannot be used: {each['error']}")
    if views:
        say("`armdrive doctor PORT` finds out what a port leads to, without moving anything")
    return 0


def _view(info: PortInfo, files: tuple[Naming, ...]) -> dict[str, Any]:
    from armdrive.doctor.before import forbidden
    from armdrive.doctor.owners import held_by_armdrive, naming

    arms = naming(info.device, files)
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
        "arm_files": list(arms),
        "holder": holder,
        "allowed": info.readable,
        "mend": "" if info.readable else forbidden(info.device).mend,
    }


def _absent(ports: tuple[PortInfo, ...], files: tuple[Naming, ...]) -> list[dict[str, str]]:
    from armdrive.doctor.owners import same_port

    return [
        {"arm": each.arm, "port": each.port}
        for each in files
        if each.port
        and "://" not in each.port
        and not _is_there(each.port)
        and not any(same_port(each.port, info.device) for info in ports)
    ]


def _is_there(port: str) -> bool:
    from pathlib import Path

    return Path(port).exists()


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
    if view["arm_files"]:
        say(f"    named by the arm file {', '.join(view['arm_files'])}")
    if view["holder"]:
        drives = f", which drives {view['holder']['arm']}" if view["holder"]["arm"] else ""
        say(f"    held by {view['holder']['program']} (pid {view['holder']['pid']}){drives}")
    if not view["allowed"]:
        say(f"    you may not open it: {view['mend']}")
