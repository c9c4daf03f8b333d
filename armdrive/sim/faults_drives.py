"""The faults of a CAN bus and of the drives on it: frames lost or overtaken, drives mute or reset.

They need no more than a device that is `DrivesOnBus`; some, one that `SaysEmergencies`.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from armdrive.errors import BadRequest
from armdrive.sim.device import lacks
from armdrive.sim.drives import DrivesOnBus, SaysEmergencies
from armdrive.sim.fault_kind import Begin, Bench, Running
from armdrive.sim.fault_request import FaultRequest, whole
from armdrive.sim.faults_arm import motor_of
from armdrive.sim.faults_wire import silencing
from armdrive.sim.wire_faults import Amount

_CODE = re.compile(r"[0-9A-Fa-f]{4}")
FIRST_ERROR = 0x100
"""Of an EMCY: what is below says that no error is left."""


def frame_doubled(frame: bytes, amount: Amount) -> tuple[bytes, float]:
    """Say a frame twice."""
    return frame * (2 if amount.strikes(len(frame)) else 1), 0.0


def bus_off(bench: Bench, _: FaultRequest) -> Begin:
    """Have the host's adapter leave the bus."""
    _drives(bench)
    line: Any = bench.line

    def begin() -> Running:
        if not hasattr(line, "leave_bus"):
            raise BadRequest("this wire is no CAN bus, so no adapter can leave it")
        line.leave_bus()
        return Running(lambda: line.leave_bus(off=False), lambda: bool(line.bus_off))

    return begin


def alone(bench: Bench, _: FaultRequest) -> Begin:
    """Have nobody acknowledge what the adapter sends: it stands alone on its bus."""
    _drives(bench)
    adapter = getattr(bench.line, "adapter", None)
    silence = silencing(bench, "both")

    def set_alone(on: bool) -> None:
        if adapter is not None:
            adapter.faults.alone = on

    def begin() -> Running:
        set_alone(True)
        silent = silence()

        def end() -> None:
            set_alone(False)
            silent.end()

        return Running(end)

    return begin


def mute_drive(bench: Bench, request: FaultRequest) -> Begin:
    """Have a drive say nothing, while it hears and obeys."""
    return _lasting(bench, request, lambda drives, at, on: drives.mute_drive(at, on))


def dead_drive(bench: Bench, request: FaultRequest) -> Begin:
    """Take a drive's supply away."""
    return _lasting(bench, request, lambda drives, at, on: drives.power_drive(at, not on))


def without_done(bench: Bench, request: FaultRequest) -> Begin:
    """Have a drive not say that a motion is done."""
    return _lasting(bench, request, lambda drives, at, on: drives.withhold_done(at, on))


def reset_drive(bench: Bench, request: FaultRequest) -> Begin:
    """Have a drive's firmware begin anew."""
    drives, at = _drives(bench), motor_of(bench, request.words[0])
    return lambda: drives.reset_drive(at)


def other_mode(bench: Bench, request: FaultRequest) -> Begin:
    """Give a drive another mode, as somebody does at its keys."""
    return _changed(bench, request, lambda drives, at, mode: drives.set_drive_mode(at, mode))


def other_id(bench: Bench, request: FaultRequest) -> Begin:
    """Give a drive another id, one that another has perhaps."""
    return _changed(bench, request, lambda drives, at, node: drives.set_drive_id(at, node))


def ailing_drive(bench: Bench, request: FaultRequest) -> Begin:
    """Have a drive fail by itself, for as long as this lasts; it is to be reset then."""
    drives, at = _emergencies(bench), motor_of(bench, request.words[0])
    code = _code(request.words[1])

    def begin() -> Running:
        drives.ail_drive(at, code)
        return Running(lambda: drives.mend_drive(at, code))

    return begin


def warning_drive(bench: Bench, request: FaultRequest) -> Begin:
    """Have a drive say an EMCY, and go on."""
    drives, at = _emergencies(bench), motor_of(bench, request.words[0])
    code = _code(request.words[1])
    return lambda: drives.warn_drive(at, code)


def _emergencies(bench: Bench) -> SaysEmergencies:
    if not isinstance(bench.device, SaysEmergencies):
        raise lacks(bench.device, "error codes of its own")
    return bench.device


def _code(word: str) -> int:
    if not _CODE.fullmatch(word) or int(word, 16) < FIRST_ERROR:
        raise BadRequest(f"an error code is four hex digits from 0100 on, 4310 say, not {word!r}")
    return int(word, 16)


def _drives(bench: Bench) -> DrivesOnBus:
    device = bench.device
    if not isinstance(device, DrivesOnBus):
        raise BadRequest(f"the simulated {device.title} has no drives on a bus")
    return device


def _lasting(
    bench: Bench, request: FaultRequest, switch: Callable[[DrivesOnBus, int, bool], None]
) -> Begin:
    drives, at = _drives(bench), motor_of(bench, request.words[0])

    def begin() -> Running:
        switch(drives, at, True)
        return Running(lambda: switch(drives, at, False))

    return begin


def _changed(
    bench: Bench, request: FaultRequest, change: Callable[[DrivesOnBus, int, int], int]
) -> Begin:
    drives, at = _drives(bench), motor_of(bench, request.words[0])
    value = whole(request.words[1])

    def begin() -> Running:
        before = change(drives, at, value)
        return Running(lambda: _discard(change(drives, at, before)))

    return begin


def _discard(_: int) -> None:
    """Take no interest in what was before."""
